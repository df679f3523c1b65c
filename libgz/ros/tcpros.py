"""TCPROS: the connections of ROS 1 for topics and services, as both sides of them."""

from __future__ import annotations

import logging
import socket
import struct
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from libgz.base.errors import GazeboError
from libgz.ros.loop import Connection, Loop, kept
from libgz.ros.packing import LARGE, Buffer

if TYPE_CHECKING:
    from libgz.ros.types import MessageType, ServiceType

__all__ = ["Caller", "Feed", "Reader", "Served", "Sink", "encode_header", "parse_header"]

log = logging.getLogger("libgz.ros")

U32 = struct.Struct("<I")
MOST_HEADER = 1 << 16
MOST_FIELDS = 64
MOST_MESSAGE = 1 << 22  # bytes of a message that a topic of the simulation takes
MOST_CALL = 1 << 24  # bytes of a request: that of a spawned model with its text
WAITING = 1 << 22  # bytes that may wait for a subscriber beside those of its queue
LEAST_QUEUE = 100  # messages


def encode_header(fields: Mapping[str, str]) -> bytes:
    """The header of a connection with its length."""
    parts = [f"{name}={value}".encode() for name, value in fields.items()]
    body = b"".join(U32.pack(len(part)) + part for part in parts)
    return U32.pack(len(body)) + body


def parse_header(body: bytes) -> dict[str, str]:
    """The fields of a header, without its length.

    Raises:
        ValueError: it is none.
    """
    fields: dict[str, str] = {}
    at = 0
    while at < len(body):
        if at + 4 > len(body) or len(fields) == MOST_FIELDS:
            raise ValueError("its header is damaged")
        (size,) = U32.unpack_from(body, at)
        part = body[at + 4 : at + 4 + size]
        name, found, value = part.partition(b"=")
        if len(part) < size or not found:
            raise ValueError("its header is damaged")
        fields[name.decode("utf-8", "replace")] = value.decode("utf-8", "replace")
        at += 4 + size
    return fields


class Sink(Protocol):
    """A publication, as its connections use it."""

    topic: str
    kind: MessageType
    queue: int
    latch: bool

    def connected(self, reader: Reader) -> None:
        """A subscriber came: what the topic keeps for it is queued."""

    def disconnected(self, reader: Reader) -> None:
        """A subscriber went."""


class Served(Protocol):
    """A service, as its connections use it."""

    name: str
    kind: ServiceType

    def request(self, body: bytes, answer: Callable[[bool, bytes], None]) -> bool:
        """A request; whether it is accepted: `answer` is called later, from any thread."""


class Nodes(Protocol):
    """The node whose topics and services are served."""

    name: str

    def publication(self, topic: str) -> Sink | None:
        """The publication of a topic."""

    def service(self, name: str) -> Served | None:
        """The service of a name."""


class Caller(Connection):
    """A connection that another node opened: it becomes that of a subscriber, or of a service's client."""

    longest = MOST_HEADER

    def __init__(self, loop: Loop, sock: socket.socket, peer: str, node: Nodes) -> None:
        super().__init__(loop, sock, peer)
        self._node = node
        self._served: Served | None = None
        self._persistent = False
        self._busy = False
        self.reader: Reader | None = None

    def frame(self, body: bytes) -> None:
        """The header, and then requests."""
        if self._served is not None:
            self._request(self._served, body)
        elif self.reader is None:
            try:
                self._greet(parse_header(body))
            except ValueError as error:
                self.close(str(error))

    def _greet(self, fields: Mapping[str, str]) -> None:
        self.deadline = None
        caller = fields.get("callerid", "")[:200]
        self.peer = f"{caller} ({self.peer})" if caller else self.peer
        if "service" in fields:
            self._open_service(fields)
        else:
            self._open_topic(fields)

    def _refuse(self, text: str) -> None:
        self.loop.warn(text, "ROS: %s is refused: %s", self.peer, text)
        self.queue.append((encode_header({"error": text}),))
        self.finish()

    def _open_topic(self, fields: Mapping[str, str]) -> None:
        topic = fields.get("topic", "")[:200]
        sink = self._node.publication(topic)
        if sink is None:
            self._refuse(f"{self._node.name} does not publish {topic!r}")
            return
        kind = sink.kind
        if fields.get("md5sum") not in (kind.md5, "*") or fields.get("type", "*") not in (kind.name, "*"):
            given = f"{fields.get('type')} [{fields.get('md5sum')}]"[:200]
            self._refuse(f"topic {topic} has type {kind.name} [{kind.md5}], not {given}")
            return
        answer = {
            "callerid": self._node.name,
            "latching": str(int(sink.latch)),
            "md5sum": kind.md5,
            "message_definition": kind.text,
            "topic": topic,
            "type": kind.name,
        }
        self.reader = Reader(self, sink)
        self.send(encode_header(answer))
        if not self.closed:
            sink.connected(self.reader)
            self.flush()

    def _open_service(self, fields: Mapping[str, str]) -> None:
        name = fields["service"][:200]
        served = self._node.service(name)
        if served is None:
            self._refuse(f"{self._node.name} has no service {name!r}")
            return
        kind = served.kind
        if fields.get("md5sum") not in (kind.md5, "*"):
            self._refuse(f"service {name} has type {kind.name} [{kind.md5}], not [{fields.get('md5sum')}]"[:300])
            return
        answer = {
            "callerid": self._node.name,
            "md5sum": kind.md5,
            "request_type": kind.request.name,
            "response_type": kind.response.name,
            "service": name,
            "type": kind.name,
        }
        self.queue.append((encode_header(answer),))
        if fields.get("probe") == "1":
            self.finish()
            return
        self.flush()
        self._served, self._persistent, self.longest = served, fields.get("persistent") in ("1", "true"), MOST_CALL

    def _request(self, served: Served, body: bytes) -> None:
        if self._busy or self.unsent:
            self.close("it sent a request before it took the answer to the last one")
            return
        self._busy = True
        if not served.request(body, lambda good, answer: self.loop.call(self._answer, good, answer)):
            self._answer(False, b"too many requests wait")

    def _answer(self, good: bool, body: bytes) -> None:
        if self.closed:
            return
        self._busy = False
        self.queue.append((bytes([good]) + U32.pack(len(body)) + body,))
        if self._persistent:
            self.flush()
        else:
            self.finish()

    def ended(self) -> None:
        """The subscriber is gone."""
        if self.reader is not None:
            self.reader.sink.disconnected(self.reader)


class Reader:
    """A subscriber: messages that its socket does not take wait here. Of those too many, the oldest are dropped.

    Attributes:
        dropped: how many were dropped.
        skipped: bytes of messages that native code had gathered when it came.
    """

    def __init__(self, connection: Caller, sink: Sink) -> None:
        self.connection, self.sink = connection, sink
        self.dropped = self.skipped = 0
        self._most = max(sink.queue, LEAST_QUEUE)
        self._queue = connection.queue

    def push(self, parts: Sequence[Buffer], size: int, *, several: bool = False) -> None:
        """Send a message of some parts, or queue it; from any one thread.

        Args:
            parts: of its frame.
            size: of all together [byte].
            several: whether these are frames of several messages: of them, WAITING bytes may wait in any queue.
        """
        connection, queue, most = self.connection, self._queue, self._most
        hurried = connection.loop.hurried()
        if not hurried and connection.send_at_once(parts, size):
            return
        queue.append((b"".join(parts),) if size < LARGE else tuple(kept(parts)))
        connection.send_soon(hurried)
        if size * most > WAITING:
            most = max(0 if several else self.sink.queue, WAITING // size, 2)
        if len(queue) > most // 2 and not connection.slow:
            connection.hasten()
        while len(queue) > most:
            try:
                queue.popleft()
            except IndexError:  # the loop's thread took it
                break
            self.dropped += 1
            if self.dropped == 1:
                text = "ROS: %s reads %s too slowly; messages are dropped"
                connection.loop.warn(("slow", self.sink.topic), text, connection.peer, self.sink.topic)


class Feed(Connection):
    """A connection to a publisher.

    Args:
        header: what it is asked.
        md5: of the type that is expected.
        received: takes each message; it raises a GazeboError if that is invalid.
        gone: called at the end.
    """

    longest = MOST_HEADER

    def __init__(
        self,
        loop: Loop,
        sock: socket.socket,
        peer: str,
        header: Mapping[str, str],
        received: Callable[[bytes], Any],
        gone: Callable[[], object],
    ) -> None:
        super().__init__(loop, sock, peer)
        self._header, self._receive, self._gone = header, received, gone

    def start(self) -> None:
        """Ask for the messages; from the loop's thread."""
        self.loop.add(self)
        if self in self.loop.connections:
            self.send(encode_header(self._header))
        else:
            self._gone()

    def frame(self, body: bytes) -> None:
        """The header, and then messages."""
        if self.deadline is not None:
            self._greet(body)
            return
        try:
            self._receive(body)
        except GazeboError as error:
            self.close(f"{self._header['topic']}: {error}")

    def _greet(self, body: bytes) -> None:
        try:
            fields = parse_header(body)
        except ValueError as error:
            self.close(str(error))
            return
        wanted = self._header["md5sum"]
        if "error" in fields:
            self.close(f"{self._header['topic']}: {fields['error'][:300]}")
        elif fields.get("md5sum", wanted) not in (wanted, "*"):
            given = f"{fields.get('type')} [{fields.get('md5sum')}]"[:200]
            self.close(f"{self._header['topic']} has type {self._header['type']} [{wanted}] here, {given} there")
        else:
            self.deadline, self.longest = None, MOST_MESSAGE

    def ended(self) -> None:
        """The publisher is gone."""
        self._gone()
