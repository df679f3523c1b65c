"""libgz topic: the topics of a running server of SDF worlds: list, describe, print, measure, publish, request."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from libgz.classic import msgs
from libgz.classic.transport import Link, Node, TopicManager, connect, getAdvertisedTopics
from libgz.classic.transport.functions import request
from libgz.errors import GazeboError, NotFoundError, ParameterError, nearest

__all__ = ["configure", "run"]

PATIENCE = 5.0  # [s] for a server, a subscriber or an answer
PERIOD = 1.0  # [s] between lines of figures
NAP = 0.002  # [s] between looks for messages


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("-l", "--list", action="store_true", help="list what is published")
    what.add_argument("-i", "--info", metavar="TOPIC", help="show a topic's type, and who publishes and listens")
    what.add_argument("-e", "--echo", metavar="TOPIC", help="print the messages of a topic")
    what.add_argument("-z", "--hz", metavar="TOPIC", help="print the messages per second of wall time")
    what.add_argument("-b", "--bw", metavar="TOPIC", help="print the bytes per second")
    what.add_argument("-p", "--publish", metavar="TOPIC", help="send one message, given by -m or -f")
    what.add_argument("-r", "--request", metavar="REQUEST", help="ask the world something, with -m as its data")
    add = parser.add_argument
    add("-m", "--msg", metavar="TEXT", help="the message, such as 'x: 1, y: 2' or '{\"x\": 1}'; a request's data")
    add("-f", "--file", metavar="FILE", help="a file that holds the message")
    add("-t", "--type", metavar="TYPE", help="the type to publish, where nobody publishes on the topic yet")
    add("-w", "--world-name", default="", metavar="WORLD", help="the world that ~ means (default: the first one)")
    add("-d", "--duration", type=float, default=None, metavar="S", help="end after so much wall time")
    add("-n", "--num", type=int, default=None, metavar="N", help="end after so many messages")
    add("-u", "--unformatted", action="store_true", help="with -e: each message in one line of JSON")


def run(options: argparse.Namespace) -> int:
    """Do what is asked.

    Raises:
        ServerError: there is no server.
        LibraryError: the extra for topics between processes is not installed.
        ParameterError: the message cannot be read, or does not fit the topic.
        GazeboError: nobody listens or answers, or the server ended.
    """
    if options.num is not None and options.num < 1:
        raise ParameterError(f"--num is {options.num}; it must be at least 1")
    if options.duration is not None and not 0.0 <= options.duration < math.inf:
        raise ParameterError(f"--duration is {options.duration:g}; it must not be negative")
    with connect(timeout=PATIENCE) as link, contextlib.suppress(KeyboardInterrupt):
        if options.list:
            print(*getAdvertisedTopics(), sep="\n")
        elif options.request is not None:
            _request(options)
        else:
            topic = options.info or options.echo or options.hz or options.bw or options.publish
            node = Node()
            # A full name needs no world, and a server may have none yet.
            node.Init(options.world_name or ("-" if topic.startswith("/") else ""))
            if options.info:
                _info(node.DecodeTopicName(topic))
            elif options.publish:
                _publish(node, topic, options)
            else:
                _listen(link, node, topic, options)
    return 0


def _info(topic: str) -> None:
    info = TopicManager.Instance().TopicInfo(topic)
    if not info.publisher and not info.subscriber:
        raise NotFoundError(f"nobody publishes on {topic} or listens{nearest(topic, getAdvertisedTopics())}")
    print(f"Type: {info.msg_type or '(nobody publishes)'}")
    for title, ends in (("Publishers", info.publisher), ("Subscribers", info.subscriber)):
        print(f"\n{title}:")
        for end in ends:
            print(f"\t{end.host}, process {end.port}")


def _listen(link: Link, node: Node, topic: str, options: argparse.Namespace) -> None:
    """Print messages, or figures, until the time is over."""
    figures: list[tuple[float, int]] = []
    left = math.inf if options.num is None else options.num

    def OnMeasured(message: Any) -> None:
        figures.append((time.monotonic(), len(message.SerializeToString()) if options.bw else 0))

    def OnEcho(message: Any) -> None:
        print(json.dumps(message.ToDict()) if options.unformatted else message.DebugString(), flush=True)

    def OnMessage(message: Any) -> None:
        nonlocal left
        if left > 0:
            left -= 1
            (OnEcho if options.echo else OnMeasured)(message)

    subscriber = node.Subscribe(topic, OnMessage, latching=bool(options.echo))
    end = math.inf if options.duration is None else time.monotonic() + options.duration
    begin = time.monotonic()
    show = _show_bandwidth if options.bw else _show_rate
    while left > 0 and (now := time.monotonic()) < end:
        TopicManager.Instance().ProcessNodes()
        if now >= begin + PERIOD:
            begin = now
            if not options.echo:
                show(figures)
        if not link.connected():
            raise GazeboError("the server ended")
        time.sleep(NAP)
    TopicManager.Instance().ProcessNodes()
    if not options.echo:
        show(figures)
    subscriber.Unsubscribe()


def _show_rate(figures: list[tuple[float, int]]) -> None:
    """The rate since the last line, from the first to the last message."""
    span = figures[-1][0] - figures[0][0] if len(figures) > 1 else 0.0
    if span:
        print(f"Hz: {(len(figures) - 1) / span:7.2f}", flush=True)
    del figures[:-1]


def _show_bandwidth(figures: list[tuple[float, int]]) -> None:
    """The bytes a second since the last line, and the sizes of the messages; the first one only begins the time."""
    span = figures[-1][0] - figures[0][0] if len(figures) > 1 else 0.0
    if span:
        sizes = [size for _, size in figures[1:]]
        mean = sum(sizes) / len(sizes)
        print(
            f"Total[{_bytes(sum(sizes) / span)}/s] Mean[{_bytes(mean)}] Min[{_bytes(min(sizes))}] "
            f"Max[{_bytes(max(sizes))}] Messages[{len(sizes)}]",
            flush=True,
        )
    del figures[:-1]


def _bytes(number: float) -> str:
    for unit in ("B", "KB"):
        if number < 1024.0:
            return f"{number:.2f} {unit}"
        number /= 1024.0
    return f"{number:.2f} MB"


def _text(options: argparse.Namespace) -> str:
    """The message as it was given."""
    if (options.msg is None) == (options.file is None):
        raise ParameterError("-p takes the message by -m TEXT or by -f FILE")
    if options.msg is not None:
        return str(options.msg)
    try:
        return Path(options.file).read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise ParameterError(f"the message cannot be read from {options.file!r}: {error}") from None


def _publish(node: Node, topic: str, options: argparse.Namespace) -> None:
    text, known = _text(options), options.type or node.GetMsgType(topic)
    if not known:
        meant = nearest(node.DecodeTopicName(topic), getAdvertisedTopics())
        raise ParameterError(f"nobody publishes on {topic}{meant}; -t TYPE says what to send, such as -t Vector3d")
    message = msgs.message_type(known)()
    if text.lstrip().startswith("{"):
        try:
            values = json.loads(text)
        except json.JSONDecodeError as error:
            raise ParameterError(f"the message is no JSON: {error}") from None
        message.FromDict(values)
    else:
        msgs.Parse(message, text)
    publisher = node.Advertise(type(message), topic)
    if not publisher.WaitForConnection(PATIENCE if options.duration is None else options.duration):
        raise GazeboError(f"nobody listens to {publisher.GetTopic()}")
    publisher.Publish(message)


def _request(options: argparse.Namespace) -> None:
    """Ask, and print the answer; what is packed in it, too."""
    patience = PATIENCE if options.duration is None else options.duration
    if patience == 0.0:
        node = Node()
        node.Init(options.world_name)
        publisher = node.Advertise(msgs.Request, "~/request")
        if not publisher.WaitForConnection(PATIENCE):
            raise GazeboError(f"world {node.GetTopicNamespace()!r} takes no requests")
        publisher.Publish(msgs.CreateRequest(options.request, options.msg or ""))
        return
    response = request(options.world_name, options.request, options.msg or "", patience)
    print(response.DebugString(), end="")
    unpack: Callable[[bytes], Any] | None = None
    with contextlib.suppress(NotFoundError):
        unpack = msgs.message_type(response.type).FromString if response.serialized_data else None
    if unpack is not None:
        print(f"\n{response.type}:\n{unpack(response.serialized_data).DebugString()}", end="")
