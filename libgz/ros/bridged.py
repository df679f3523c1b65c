"""BridgedNode: the nodes of ROS 2 of a server, by a bridge: a process with the user's own rclpy, over a socketpair."""

from __future__ import annotations

import contextlib
import json
import logging
import socket
import struct
import subprocess
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from libgz.base.errors import GazeboError, LibraryError
from libgz.base.python import environment
from libgz.base.visible import one_line
from libgz.ros.loop import SEND_AT_ONCE, Connection, Frame, Loop, kept
from libgz.ros.names import NodeNames
from libgz.ros.packing import LARGE, Buffer, Codec, FormatError, read_schema
from libgz.ros.types import MessageType, ServiceType

__all__ = ["BridgedNode", "Channel", "NodeSettings"]

log = logging.getLogger("libgz.ros")

PROGRAM = Path(__file__).parent / "bridge" / "program.py"
DECLARE, DROP, MESSAGE, ANSWER, HELLO, DECLARED, REFUSED, LISTENED, REQUEST = range(1, 10)  # sorts of frames
HEAD = struct.Struct("<IBI")  # length of what follows it, sort, channel
REST = HEAD.size - 4
MOST_FRAME = (1 << 24) + 64  # bytes: that of a request with a model's text
MOST_WAITING, MOST_BYTES = 1000, 1 << 23  # messages of one topic, or answers of one service, that wait for the bridge
MOST_TOGETHER = 1 << 26  # bytes of all that wait
MOST_ENDED = 10_000  # declarations that wait for the bridge though they have ended
MOST_TEXT = 1 << 20  # bytes of what the bridge says about itself and about types
LONGEST_REASON = 1000  # bytes of why it leaves something out
START_PATIENCE = 60.0  # [s]
END_PATIENCE = 0.5  # [s]; a bridge that hangs is killed then, before users think of a second signal
FIRST_PAUSE, LONGEST_PAUSE = 0.2, 10.0  # [s] before a bridge that ended is started again; longer if it lived no longer
# Parts of actions, by the ends of their types' names.
PARTS = {"FeedbackMessage": "FeedbackMessage", "GetResult": "GetResultService", "SendGoal": "SendGoalService"}


class NodeSettings(NamedTuple):
    """The node of a plugin: its namespace, its name, and its own qualities of service.

    Attributes:
        qos: (topic as the plugin names it, ``publisher`` or ``subscription``) -> policies, times in seconds.
    """

    space: str
    name: str
    qos: Mapping[tuple[str, str], Mapping[str, Any]]


class Channel:
    """What is published, subscribed to or served; a number on the wire.

    Attributes:
        topic: the full name.
        subscribed: whether there are subscribers, as far as the bridge says.
        listened: the same, or that the topic keeps its last messages for those that come.
        declared: whether the present bridge has said what the fields of its types are.
        codecs: those of the message, or of request and response; empty until the first bridge has said that.
    """

    def __init__(self, node: BridgedNode, verb: str, topic: str, kind: MessageType | ServiceType, about: Any) -> None:
        self._node, self.verb, self.topic, self.kind, self.about = node, verb, topic, kind, about
        self.number = 0
        self.declared = self.listened = self.subscribed = False
        self.codecs: list[Codec] = []
        self.receive: Callable[[bytes], Any] | None = None
        self.serve: Callable[[bytes, Callable[[bool, bytes], None]], bool] | None = None
        self.waiting = self.waiting_bytes = 0

    @property
    def codec(self) -> Codec:
        """The codec of a topic's messages."""
        return self.codecs[0]

    def publish(self, body: list[Buffer]) -> None:
        """Send a message, given by its parts; nobody waits for a slow bridge."""
        self._node.push(self, MESSAGE, body)


class BridgedNode:
    """Nodes of ROS 2. A bridge that ends is started again, and all is declared to it once more.

    Args:
        names: of the server's own node.
        python: the user's Python that has rclpy.

    Attributes:
        changed: channels whose subscribers came or went.
        notify: called, in the loop's thread, when they did.
        started: how often a bridge was started.
        about: what the bridge said of itself.
    """

    def __init__(self, names: NodeNames, python: Path) -> None:
        self.names, self.name, self.python = names, names.name, python
        self.changed: dict[Channel, None] = {}
        self.notify: Callable[[], object] = lambda: None
        self.started = 0
        self.about: dict[str, str] = {}
        self.process: subprocess.Popen[bytes] | None = None
        self._channels: dict[int, Channel] = {}
        self._last = 0
        # So that each channel is declared once to each bridge; reentrant, because Python may collect a channel within.
        self._declaring = threading.RLock()
        self._lacking: set[str] = set()
        self._link: _Link | None = None
        self._ended = False
        self._greeted = threading.Event()
        self._broken = threading.Event()
        self._loop = Loop("ros-bridge")
        self._keeper = threading.Thread(target=self._keep, name="ros-bridge-keeper", daemon=True)

    def start(self) -> None:
        """Start the bridge, and wait until it speaks.

        Raises:
            LibraryError: it ends instead: there is no rclpy, for example.
        """
        self._loop.start()
        try:
            self._open()
            if not self._wait():
                raise LibraryError(
                    f"ROS 2 cannot start: {self.python} cannot run rclpy, see the lines above; source a ROS 2 whose "
                    "Python this is, or run `libgz ros venv`"
                )
        except BaseException:  # such as a signal
            self.close()
            raise
        names = (one_line(self.about.get(key, ""))[:LONGEST_REASON] for key in ("distribution", "middleware"))
        log.info("ROS 2: %s over %s", *(name or "rclpy" for name in names))
        self._keeper.start()

    def _wait(self) -> bool:
        """Wait for the greeting of a bridge that was started; False if it does not come."""
        end = time.monotonic() + START_PATIENCE
        while not self._greeted.wait(0.02):
            if self._broken.is_set() or time.monotonic() > end or self._ended:
                return False
        return True

    def close(self) -> None:
        """End the bridge."""
        if self._ended:
            return
        self._ended = True
        self._broken.set()
        if self._keeper.is_alive():
            self._keeper.join(END_PATIENCE)
        if self._link is not None:
            self._loop.call(self._link.close)
        self._loop.close()
        self._end_process()

    # Process -----------------------------------------------------------------------------------------------------

    def _open(self) -> None:
        """Start a bridge."""
        ours, theirs = socket.socketpair()
        self._greeted.clear()
        self._broken.clear()
        with theirs:
            command = [str(self.python), str(PROGRAM), str(theirs.fileno())]
            try:
                self.process = subprocess.Popen(
                    command,
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                    cwd="/",
                    env=environment(),
                    process_group=0,  # so that Ctrl-C ends the server first, which ends the bridge
                )
            except OSError as error:
                ours.close()
                self._broken.set()
                log.error("ROS 2: %s cannot be run: %s", self.python, error.strerror)
                return
        self.started += 1
        link = self._link = _Link(self._loop, ours, self)
        self._loop.call(self._loop.add, link)

    def _keep(self) -> None:
        """Start the bridge again whenever it ends."""
        pause, begin = FIRST_PAUSE, time.monotonic()
        while not self._ended:
            if not self._broken.wait(1.0) or self._ended:
                continue
            self._end_process()
            if time.monotonic() - begin > LONGEST_PAUSE:
                pause = FIRST_PAUSE
            log.warning("ROS 2: the bridge has ended; it is started again in %g s", pause)
            end = time.monotonic() + pause
            while time.monotonic() < end and not self._ended:
                time.sleep(0.02)
            pause = min(2.0 * pause, LONGEST_PAUSE)
            if not self._ended:
                begin = time.monotonic()
                self._open()
                if not self._wait():
                    self._broken.set()  # one that says nothing is ended, too

    def _end_process(self) -> None:
        process = self.process
        if process is None:
            return
        try:
            process.wait(END_PATIENCE if self._ended else 0.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def greeted(self, body: bytes) -> None:
        """The bridge speaks: declare all."""
        if self._greeted.is_set():
            return
        about = _parsed(body)
        self.about = {str(key): str(value) for key, value in about.items()} if isinstance(about, dict) else {}
        with self._declaring:
            self._greeted.set()
            for channel in list(self._channels.values()):
                if channel.number in self._channels:
                    self._declare(channel)

    def lost(self) -> None:
        """The bridge is gone."""
        for channel in list(self._channels.values()):
            channel.declared = False
            self._hear(channel, False)
        self._broken.set()

    # Topics and services -----------------------------------------------------------------------------------------

    def advertise(
        self,
        topic: str,
        kind: MessageType,
        queue: int = 100,
        latch: bool = False,
        settings: NodeSettings | None = None,
        plain: str = "",
        **qos: Any,
    ) -> Channel:
        """Publish a topic by its full name.

        Args:
            topic: the name.
            kind: its type.
            queue: the depth.
            latch: whether it is transient local.
            settings: the node that publishes it; None: that of the server.
            plain: its name before it was resolved and remapped, for the settings.
            qos: further policies.
        """
        given = {"depth": queue, **({"durability": "transient_local"} if latch else {}), **qos}
        return self._open_channel("publish", topic, kind, settings, plain, given)

    def subscribe(
        self,
        topic: str,
        kind: MessageType,
        received: Callable[[bytes], Any],
        queue: int = 10,
        settings: NodeSettings | None = None,
        plain: str = "",
        **qos: Any,
    ) -> Channel:
        """Subscribe to a topic: `received` gets the bytes of each message, in the loop's thread."""
        given = {"depth": queue, **qos}
        return self._open_channel("subscribe", topic, kind, settings, plain, given, receive=received)

    def serve(
        self,
        name: str,
        kind: ServiceType,
        handle: Callable[[bytes, Callable[[bool, bytes], None]], bool],
        settings: NodeSettings | None = None,
    ) -> Channel:
        """Serve a service: `handle` gets each request and what takes the answer; it says whether it accepts it."""
        return self._open_channel("serve", name, kind, settings, "", {}, serve=handle)

    def _open_channel(
        self,
        verb: str,
        topic: str,
        kind: MessageType | ServiceType,
        settings: NodeSettings | None,
        plain: str,
        qos: dict[str, Any],
        receive: Callable[[bytes], Any] | None = None,
        serve: Callable[[bytes, Callable[[bool, bytes], None]], bool] | None = None,
    ) -> Channel:
        space, _, own = self.name.rpartition("/")
        place = (settings.space or "/", settings.name) if settings is not None else (space or "/", own)
        if settings is not None:
            qos |= settings.qos.get((plain, "subscription" if verb == "subscribe" else "publisher"), {})
        about = {"verb": verb, "name": topic, "type": _full_name(kind), "node": place, "qos": qos}
        channel = Channel(self, verb, topic, kind, about)
        channel.receive, channel.serve = receive, serve
        with self._declaring:
            self._last += 1
            channel.number = self._last
            self._channels[channel.number] = channel
            if self._greeted.is_set():
                self._declare(channel)
        return channel

    def withdraw(self, channel: Channel) -> None:
        """End what `advertise` or `serve` began."""
        with self._declaring:
            if self._channels.pop(channel.number, None) is not None and self._greeted.is_set():
                self._drop(channel)

    stop_serving = withdraw

    def unsubscribe(self, channel: Channel, _received: Callable[[bytes], Any]) -> None:
        """End what `subscribe` began."""
        self.withdraw(channel)

    def take_spent(self) -> float:
        """Time of the processor that what has come took, since the last call [s]."""
        return self._loop.share.take_spent()

    def follow_pace(self, hurried: Callable[[], bool]) -> None:
        """Let messages wait some milliseconds for others while the world runs faster than real time."""
        self._loop.hurried = hurried

    def lacks(self, package: str) -> bool:
        """Whether the bridge has said that it has no package of this name."""
        return package in self._lacking

    def served(self, name: str) -> bool:
        """Whether a service of a name is served."""
        return any(one.verb == "serve" and one.topic == name for one in list(self._channels.values()))

    def parameter(self, name: str) -> Any:
        """A parameter that the command line gives the server's node; None if it gives none."""
        return self.names.parameters.get(name.removeprefix(f"{self.name}/"))

    def search_parameter(self, _name: str, _space: str) -> Any:
        """None: ROS 2 has no parameters of namespaces."""
        return None

    # Wire --------------------------------------------------------------------------------------------------------

    def _declare(self, channel: Channel) -> None:
        self._post(DECLARE, channel.number, json.dumps(channel.about).encode())

    def _post(self, sort: int, number: int, body: bytes) -> None:
        """Send something small, from any thread."""
        link = self._link
        if link is None or link.closed:
            return
        link.queue.append((HEAD.pack(REST + len(body), sort, number) + body,))
        if len(link.queue) > len(self._channels) + MOST_ENDED:
            self._loop.call(link.close, "it takes no declarations")
        else:
            self._loop.call(link.flush)

    def _drop(self, channel: Channel) -> None:
        """End a channel, after its messages that wait."""
        link = self._link
        if link is not None:
            link.messages.append((None, HEAD.size, (HEAD.pack(REST, DROP, channel.number),)))
            link.send_soon(False)

    def push(self, channel: Channel, sort: int, body: list[Buffer]) -> None:
        """Send a message or an answer of some parts, or queue it."""
        link = self._link
        if link is None or link.closed:
            return
        size = HEAD.size + sum(map(len, body))
        parts = [HEAD.pack(size - 4, sort, channel.number), *body]
        hurried = sort == MESSAGE and self._loop.hurried()
        if not hurried and not link.messages and link.send_at_once(parts, size):
            return
        if channel.waiting >= MOST_WAITING or channel.waiting_bytes > MOST_BYTES or link.waiting_bytes > MOST_TOGETHER:
            what = "a message" if sort == MESSAGE else "an answer"
            self._loop.warn(
                f"slow {channel.topic}", "ROS 2: the bridge is too slow for %s; %s is left out", channel.topic, what
            )
            return
        link.add(channel, size, (b"".join(parts),) if size < LARGE else tuple(kept(parts)))
        link.send_soon(hurried)
        many = channel.waiting > MOST_WAITING // 2 or channel.waiting_bytes > MOST_BYTES // 2
        if many and not link.slow:
            link.hasten()

    def frame(self, sort: int, number: int, body: bytes) -> None:
        """A frame came from the bridge, in the loop's thread."""
        if sort == HELLO:
            self.greeted(body)
            return
        channel = self._channels.get(number)
        if channel is None:
            return
        if sort == MESSAGE and channel.receive is not None and channel.declared:
            try:
                channel.receive(body)
            except GazeboError as error:
                self._loop.warn(
                    f"bad {channel.topic}", "ROS 2: a message of %s is not obeyed: %s", channel.topic, error
                )
        elif sort == REQUEST and channel.serve is not None and len(body) >= 8 and channel.declared:
            self._request(channel, channel.serve, body[:8], body[8:])
        elif sort == LISTENED:
            self._hear(channel, any(body))
        elif sort == DECLARED:
            self._learn(channel, body)
        elif sort == REFUSED:
            package, text = channel.about["type"].partition("/")[0], body[:LONGEST_REASON].decode("utf-8", "replace")
            if text.startswith("ModuleNotFoundError"):
                self._lacking.add(package)
                self._loop.warn(
                    package, "ROS 2: there is no package %s: topics and services of its types are left out", package
                )
            else:
                self._loop.warn(f"refused {channel.topic}", "ROS 2: %s is left out: %s", channel.topic, text)

    def _request(
        self,
        channel: Channel,
        serve: Callable[[bytes, Callable[[bool, bytes], None]], bool],
        request: bytes,
        body: bytes,
    ) -> None:
        link = self._link

        def answer(good: bool, response: bytes) -> None:
            if self._link is link:  # a bridge numbers its requests by itself
                self.push(channel, ANSWER, [request, bytes([good]), response])

        if not serve(body, answer):
            self._loop.warn(f"many {channel.topic}", "ROS 2: %s has too many requests; one is refused", channel.topic)
            answer(False, b"")

    def _hear(self, channel: Channel, listened: bool) -> None:
        channel.subscribed = listened
        latched = channel.about["qos"].get("durability") == "transient_local"
        listened = (listened or latched) and channel.declared
        if listened != channel.listened:
            channel.listened = listened
            self.changed[channel] = None
            self.notify()

    def _learn(self, channel: Channel, body: bytes) -> None:
        """The bridge says what the fields of a channel's types are."""
        kind = channel.kind
        kinds = [kind] if isinstance(kind, MessageType) else [kind.request, kind.response]
        try:
            tables = _parsed(body)
            if not isinstance(tables, list) or len(tables) != len(kinds):
                raise FormatError("it does not say what the fields are")
            channel.codecs = [_codec(one, table) for one, table in zip(kinds, tables, strict=True)]
            channel.declared = True
            self._hear(channel, False)
        except GazeboError as error:
            text, kind = "ROS 2: %s (%s) is left out: %s", channel.about["type"]
            self._loop.warn(f"wrong {channel.topic}", text, channel.topic, kind, error)


class _Link(Connection):
    """The connection to a bridge.

    Attributes:
        messages: frames that wait, after those in `queue`, with their channels and sizes; None for ends of channels,
            which are not counted.
        waiting_bytes: the sizes of all that are counted [byte].
    """

    longest = MOST_FRAME

    def __init__(self, loop: Loop, sock: socket.socket, node: BridgedNode) -> None:
        super().__init__(loop, sock, "the bridge")
        with contextlib.suppress(OSError):
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 1 << 22)
        self.deadline = None
        self._node = node
        self.messages: deque[tuple[Channel | None, int, Frame]] = deque()
        self.waiting_bytes = 0
        self._counting = threading.Lock()  # of what waits, here and of channels

    def frame(self, body: bytes) -> None:
        """A frame came."""
        if len(body) < REST:
            self.close("it sent a frame that is too short")
            return
        self._node.frame(body[0], int.from_bytes(body[1:REST], "little"), body[REST:])

    @property
    def unsent(self) -> bool:
        """Whether something waits."""
        return super().unsent or bool(self.messages)

    def next_parts(self) -> list[Buffer]:
        """The parts of frames that wait, for one call; what the node itself says comes first."""
        parts = super().next_parts()
        size = 0 if not parts else SEND_AT_ONCE
        with self._counting:
            while size < SEND_AT_ONCE and self.messages:
                channel, length, frame = self.messages.popleft()
                self._count_off(channel, length)
                parts += frame
                size += length
        return parts

    def add(self, channel: Channel, size: int, frame: Frame) -> None:
        """Let a message or an answer wait, from any thread; none waits for a bridge that is gone."""
        with self._counting:
            if not self.closed:
                channel.waiting += 1
                channel.waiting_bytes += size
                self.waiting_bytes += size
                self.messages.append((channel, size, frame))

    def _count_off(self, channel: Channel | None, size: int) -> None:
        """Count what waits no more; the lock of counting is held."""
        if channel is not None:
            channel.waiting -= 1
            channel.waiting_bytes -= size
            self.waiting_bytes -= size

    def ended(self) -> None:
        """The bridge is gone."""
        with self._counting:  # nothing is added after this
            for channel, size, _ in self.messages:
                self._count_off(channel, size)
            self.messages.clear()
        self._node.lost()


def _full_name(kind: MessageType | ServiceType) -> str:
    """The name of a type in ROS 2, such as sensor_msgs/msg/Image."""
    package, _, name = kind.name.partition("/")
    owner, _, part = name.rpartition("_")
    if part in PARTS:
        return f"{package}/action/{owner}.Impl.{PARTS[part]}"
    return f"{package}/{'msg' if isinstance(kind, MessageType) else 'srv'}/{name}"


def _codec(kind: MessageType, table: Any) -> Codec:
    """The codec of a type with the fields that the bridge gives; its own are under an empty name.

    Raises:
        FormatError: the table is none.
    """
    valid = isinstance(table, dict) and all(
        isinstance(fields, dict) and all(isinstance(text, str) for text in fields.values()) for fields in table.values()
    )
    if not valid or "" not in table:
        raise FormatError("it does not say what the fields are")
    named = {kind.name if name == "" else name: fields for name, fields in table.items()}
    return Codec(kind, cdr=True, schema=read_schema(named, kind))


def _parsed(body: bytes) -> Any:
    """The value of a text of JSON; None if it is none, or too long."""
    try:
        return json.loads(body) if len(body) <= MOST_TEXT else None
    except (ValueError, RecursionError):
        return None
