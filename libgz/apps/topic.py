"""libgz topic: list, describe, print, measure and publish topics of a running gzserver, and send requests."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import time
from collections.abc import Callable
from typing import Any

from libgz.apps.console import read_text, say
from libgz.apps.server_link import PATIENCE, publish, receive
from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.visible import one_line
from libgz.classic import msgs
from libgz.classic.transport import Link, Node, TopicManager, connect
from libgz.classic.transport.functions import request

__all__ = ["configure", "run"]

PERIOD = 1.0  # [s] between printed measurements


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("-l", "--list", action="store_true", help="list all topics")
    what.add_argument(
        "-i", "--info", metavar="TOPIC", help="print the type, the publishers and the subscribers of a topic"
    )
    what.add_argument("-e", "--echo", metavar="TOPIC", help="print the messages of a topic")
    what.add_argument("-v", "--view", metavar="TOPIC", help="Gazebo's window of a topic, which libgz has not")
    what.add_argument("-z", "--hz", metavar="TOPIC", help="print the messages per second of real time")
    what.add_argument("-b", "--bw", metavar="TOPIC", help="print the bytes per second of real time")
    what.add_argument("-p", "--publish", metavar="TOPIC", help="publish one message, given by -m or -f")
    what.add_argument(
        "-r",
        "--request",
        metavar="REQUEST",
        help="send a request to the world, with -m as its data, and print the response",
    )
    add = parser.add_argument
    add(
        "-m",
        "--msg",
        type=str,
        metavar="TEXT",
        help="the message, such as 'x: 1, y: 2' or '{\"x\": 1}', or the data of a request",
    )
    add("-f", "--file", metavar="FILE", help="a file with the message")
    add("-t", "--type", metavar="TYPE", help="the message type, for topics without publishers")
    add("-w", "--world-name", default="", metavar="WORLD", help="the world that ~ stands for (default: the first one)")
    add(
        "-d",
        "--duration",
        type=float,
        default=None,
        metavar="S",
        help="with -e, -z, -b: duration in real time [s]; with -p, -r: longest wait [s] (default 5)",
    )
    add("-n", "--num", type=int, default=None, metavar="N", help="number of messages (default: until interrupted)")
    add("--json", action="store_true", help="print JSON: with -l and -i one value, with -e, -z and -b one per line")
    add("-u", "--unformatted", action="store_true", help="with -e: print each message as one line of JSON")


def run(options: argparse.Namespace) -> int:
    """List, describe, print, measure, publish or request.

    Raises:
        ServerError: there is no server.
        LibraryError: the extra for topics between processes is not installed.
        ParameterError: the message cannot be read, or does not fit the topic.
        GazeboError: there is no subscriber or response, or the server ended.
    """
    if options.num is not None and options.num < 1:
        raise ParameterError(f"--num is {options.num}; it must be at least 1")
    if options.duration is not None and not 0.0 <= options.duration < math.inf:
        raise ParameterError(f"--duration is {options.duration:g}; it must not be negative")
    if options.view:
        raise ParameterError(
            f"there is no window that shows topics: use -e {options.view}, or gzserver --mcap and `libgz plot`"
        )
    with connect(timeout=PATIENCE) as link, contextlib.suppress(KeyboardInterrupt):
        if options.list:
            topics = TopicManager.Instance().TopicNames()
            say(json.dumps(topics) if options.json else "\n".join(map(one_line, topics)))
        elif options.request is not None:
            _request(options)
        else:
            topic = options.info or options.echo or options.hz or options.bw or options.publish
            node = Node()
            # A name that begins with / needs no world, and the server may not have one yet.
            node.Init(options.world_name or ("-" if topic.startswith("/") else ""))
            if options.info:
                _info(node.DecodeTopicName(topic), options.json)
            elif options.publish:
                _publish(node, topic, options)
            else:
                _subscribe(link, node, topic, options)
    return 0


def _info(topic: str, as_json: bool) -> None:
    info = TopicManager.Instance().TopicInfo(topic)
    if not info.publisher and not info.subscriber:
        raise NotFoundError(
            f"topic {topic} has no publishers and no subscribers{nearest(topic, TopicManager.Instance().TopicNames())}"
        )
    if as_json:
        row = {"topic": topic, "type": info.msg_type}
        for title, ends in (("publishers", info.publisher), ("subscribers", info.subscriber)):
            row[title] = [{"host": end.host, "process": end.port} for end in ends]
        say(json.dumps(row))
        return
    say(f"Type: {one_line(info.msg_type) or '(unknown)'}")
    for title, ends in (("Publishers", info.publisher), ("Subscribers", info.subscriber)):
        say(f"\n{title}:")
        for end in ends:
            say(f"\t{one_line(end.host)}, process {end.port}")


class _Echo:
    """Prints messages, as text or as JSON lines."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json

    def add(self, message: Any) -> None:
        say(json.dumps(message.ToDict()) if self._as_json else message.DebugString(), flush=True)

    def report(self) -> None:
        pass


class _Rate:
    """Measures messages per second of real time."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self._times: list[float] = []

    def add(self, message: Any) -> None:
        self._times.append(time.monotonic())

    def report(self) -> None:
        """Print the rate since the last report."""
        times = self._times
        if len(times) > 1 and times[-1] > times[0]:
            rate = (len(times) - 1) / (times[-1] - times[0])
            say(json.dumps({"hz": rate}) if self._as_json else f"Hz: {rate:7.2f}", flush=True)
        del times[:-1]  # the last message begins the next period


class _Bandwidth:
    """Measures bytes per second of real time, and the sizes of messages."""

    def __init__(self, as_json: bool) -> None:
        self._as_json = as_json
        self._arrivals: list[tuple[float, int]] = []  # time [s], size [bytes]

    def add(self, message: Any) -> None:
        self._arrivals.append((time.monotonic(), len(message.SerializeToString())))

    def report(self) -> None:
        """Print the bandwidth since the last report."""
        arrivals = self._arrivals
        span = arrivals[-1][0] - arrivals[0][0] if len(arrivals) > 1 else 0.0
        if span:
            sizes = [size for _, size in arrivals[1:]]
            mean = sum(sizes) / len(sizes)
            if self._as_json:
                row = {"bytes_per_second": sum(sizes) / span, "mean": mean, "min": min(sizes), "max": max(sizes)}
                say(json.dumps({**row, "messages": len(sizes)}), flush=True)
                del arrivals[:-1]
                return
            say(
                f"Total[{_bytes(sum(sizes) / span)}/s] Mean[{_bytes(mean)}] Min[{_bytes(min(sizes))}] "
                f"Max[{_bytes(max(sizes))}] Messages[{len(sizes)}]",
                flush=True,
            )
        del arrivals[:-1]  # the last message begins the next period


def _subscribe(link: Link, node: Node, topic: str, options: argparse.Namespace) -> None:
    """Print messages, or a measurement every period, until the duration or the number of messages is reached."""
    left = math.inf if options.num is None else options.num
    printer: _Echo | _Bandwidth | _Rate
    if options.echo:
        printer = _Echo(options.unformatted or options.json)
    else:
        printer = (_Bandwidth if options.bw else _Rate)(options.json)

    def OnMessage(message: Any) -> None:
        nonlocal left
        if left > 0:
            left -= 1
            printer.add(message)

    subscriber = node.Subscribe(topic, OnMessage, latching=bool(options.echo))
    begin = time.monotonic()
    for now in receive(link, options.duration):
        if now >= begin + PERIOD:
            begin = now
            printer.report()
        if left <= 0:
            break
    printer.report()
    subscriber.Unsubscribe()


def _bytes(number: float) -> str:
    for unit in ("B", "KB"):
        if number < 1024.0:
            return f"{number:.2f} {unit}"
        number /= 1024.0
    return f"{number:.2f} MB"


def _text(options: argparse.Namespace) -> str:
    """The message on the command line or in the file."""
    if (options.msg is None) == (options.file is None):
        raise ParameterError("-p needs a message, by -m TEXT or -f FILE")
    return str(options.msg) if options.msg is not None else read_text(options.file, "the message")


def _publish(node: Node, topic: str, options: argparse.Namespace) -> None:
    manager, full = TopicManager.Instance(), node.DecodeTopicName(topic)
    text, known = _text(options), options.type or manager.TopicInfo(full).msg_type
    if not known:
        others = [name for name in manager.TopicNames() if name != full]
        raise ParameterError(
            f"the type of topic {topic} is not known{nearest(full, others)}; give it by -t, such as -t Vector3d"
        )
    message = msgs.message_type(known)()
    if text.lstrip().startswith("{"):
        try:
            values = json.loads(text)
        except json.JSONDecodeError as error:
            raise ParameterError(f"the message is not valid JSON: {error}") from None
        message.FromDict(values)
    else:
        msgs.Parse(message, text)
    publish(node, topic, message, PATIENCE if options.duration is None else options.duration)


def _request(options: argparse.Namespace) -> None:
    """Send a request, and print the response with the message that it contains."""
    patience = PATIENCE if options.duration is None else options.duration
    if patience == 0.0:
        node = Node()
        node.Init(options.world_name)
        publish(node, "~/request", msgs.CreateRequest(options.request, options.msg or ""))
        return
    response = request(options.world_name, options.request, options.msg or "", patience)
    say(response.DebugString(), end="")
    unpack: Callable[[bytes], Any] | None = None
    with contextlib.suppress(NotFoundError):
        unpack = msgs.message_type(response.type).FromString if response.serialized_data else None
    if unpack is not None:
        say(f"\n{response.type}:\n{unpack(response.serialized_data).DebugString()}", end="")
