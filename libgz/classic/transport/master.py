"""Master: the registry of publishers and subscribers of all processes, as Gazebo classic's clients expect it."""

from __future__ import annotations

import contextlib
import functools
import socket
from collections.abc import Callable, Iterable
from typing import Any

from libgz.base.errors import ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport.framing import packet, read_packet
from libgz.classic.transport.loop import Connection, SocketLoop
from libgz.classic.transport.topic import log

__all__ = ["Master"]

VERSION = "gazebo 11.1"  # major and minor only: clients compare it with their own, and some read it as a number
LARGEST = 1 << 16  # [bytes] of a packet
CONTENT = 1 << 12  # [bytes] of what it announces
MOST, MOST_OF_ALL = 1000, 10_000  # publishers, subscribers and namespaces of one client, and of all
LONGEST = 1000  # characters of a topic's name


class _Client:
    """What a process has announced."""

    def __init__(self, connection: Connection) -> None:
        self.connection = connection
        self.publishers: list[Any] = []
        self.subscribers: list[Any] = []
        self.namespaces: list[str] = []
        self.peer: object = None
        with contextlib.suppress(OSError):  # it has closed the connection
            self.peer = connection.socket.getpeername()

    @property
    def announced(self) -> int:
        """How much that is."""
        return len(self.publishers) + len(self.subscribers) + len(self.namespaces)


class _Announced:
    """What clients have announced, by topic: one that leaves may have announced much, among much of others."""

    def __init__(self) -> None:
        self._found: dict[str, list[tuple[_Client, Any]]] = {}

    def add(self, client: _Client, message: Any) -> None:
        """Add a publisher or subscriber."""
        self._found.setdefault(message.topic, []).append((client, message))

    def remove(self, client: _Client, message: Any) -> None:
        """Remove what was added."""
        left = self._found[message.topic]
        left.remove((client, message))
        if not left:
            del self._found[message.topic]

    def forget(self, client: _Client, topics: Iterable[str]) -> None:
        """Remove what a client has added of topics."""
        for topic in topics:
            left = [entry for entry in self._found.pop(topic) if entry[0] is not client]
            if left:
                self._found[topic] = left

    def of(self, topic: str) -> tuple[Any, ...]:
        """What was announced of a topic."""
        return tuple(message for _, message in self._found.get(topic, ()))

    def clients(self, topic: str) -> dict[_Client, None]:
        """Who has announced something of it."""
        return dict.fromkeys(client for client, _ in self._found.get(topic, ()))


class Master:
    """Accepts clients at listening sockets; all runs in the loop's thread.

    Args:
        loop: The loop.
        listeners: The sockets.

    Attributes:
        own: The address from which this process itself connects; it may announce as much as its worlds have.
    """

    def __init__(self, loop: SocketLoop, listeners: list[socket.socket]) -> None:
        self.own: object = None
        self._clients: list[_Client] = []
        self._published, self._subscribed = _Announced(), _Announced()
        self._handlers: dict[str, tuple[str, Callable[[_Client, Any], None]]] = {
            "register_topic_namespace": ("GzString", self._register_namespace),
            "advertise": ("Publish", self._advertise),
            "unadvertise": ("Publish", self._unadvertise),
            "subscribe": ("Subscribe", self._subscribe),
            "unsubscribe": ("Subscribe", self._unsubscribe),
            "request": ("Request", self._request),
        }
        for listener in listeners:
            loop.listen(listener, self._accept, LARGEST)

    def _accept(self, connection: Connection) -> None:
        client = _Client(connection)
        connection.lossless = True
        connection.on_frame = functools.partial(self._receive, client)
        connection.on_close = functools.partial(self._remove, client)
        self._clients.append(client)
        connection.send(packet("version_init", message_type("GzString")(data=VERSION)))
        names = message_type("GzString_V")(data=self._namespaces())
        connection.send(packet("topic_namepaces_init", names))
        connection.send(packet("publishers_init", self._all_publishers()))

    def _receive(self, client: _Client, data: bytes) -> None:
        """Handle a packet.

        Raises:
            ParameterError: it is damaged, or too much.
        """
        kind, content = read_packet(data)
        found = self._handlers.get(kind)
        if found is None:
            log.debug("the master was sent a packet %r, which it does not know", kind[:40])
            return
        name, handler = found
        if client.peer != self.own:
            self._check(client, name, content)
        message: Any = message_type(name).FromString(content)
        if name in ("Publish", "Subscribe") and not 0 < len(message.topic) <= LONGEST:
            raise ParameterError(f"the name of a topic has {len(message.topic)} characters; 1 to {LONGEST} are allowed")
        handler(client, message)

    def _check(self, client: _Client, name: str, content: bytes) -> None:
        """Raise ParameterError if another process announces too much."""
        if client.announced > MOST:
            raise ParameterError(f"it has announced more than {MOST} publishers and subscribers")
        if name != "Request" and len(content) > CONTENT:
            raise ParameterError(f"it has announced something of {len(content)} bytes; {CONTENT} are allowed")
        others = (one.announced for one in self._clients if one.peer != self.own)
        if name != "Request" and sum(others) > MOST_OF_ALL:
            raise ParameterError(f"clients have announced more than {MOST_OF_ALL} publishers and subscribers")

    def _send_all(self, data: bytes) -> None:
        self._send_to(tuple(self._clients), data)  # sending may find that one is closed

    # Tables ------------------------------------------------------------------------------------------------------

    def _namespaces(self) -> list[str]:
        return list(dict.fromkeys(name for client in self._clients for name in client.namespaces))

    def _all_publishers(self) -> Message:
        return message_type("Publishers")(publisher=[one for client in self._clients for one in client.publishers])

    # Packets -----------------------------------------------------------------------------------------------------

    def _register_namespace(self, client: _Client, message: Any) -> None:
        if message.data not in client.namespaces:
            client.namespaces.append(message.data)
            self._send_all(packet("topic_namespace_add", message))

    def _advertise(self, client: _Client, publisher: Any) -> None:
        client.publishers.append(publisher)  # before sending, which may find that the client has closed
        self._published.add(client, publisher)
        self._send_all(packet("publisher_add", publisher))
        self._send_to(self._subscribed.clients(publisher.topic), packet("publisher_advertise", publisher))

    def _unadvertise(self, client: _Client, publisher: Any) -> None:
        if publisher in client.publishers:
            client.publishers.remove(publisher)
            self._published.remove(client, publisher)
            self._announce_ends([publisher])

    def _announce_ends(self, publishers: list[Any]) -> None:
        self._send_all(_packets("publisher_del", publishers))
        for topic, ended in _by_topic(publishers).items():
            self._send_to(self._subscribed.clients(topic), _packets("unadvertise", ended))

    @staticmethod
    def _send_to(clients: Iterable[_Client], data: bytes) -> None:
        for client in clients:
            client.connection.send(data)

    def _subscribe(self, client: _Client, subscriber: Any) -> None:
        client.subscribers.append(subscriber)
        self._subscribed.add(client, subscriber)
        for publisher in self._published.of(subscriber.topic):
            client.connection.send(packet("publisher_subscribe", publisher))

    def _unsubscribe(self, client: _Client, subscriber: Any) -> None:
        found = next((one for one in client.subscribers if self._same(one, subscriber)), None)
        if found is not None:
            client.subscribers.remove(found)
            self._subscribed.remove(client, found)
            self._announce_unsubscriptions([found])

    @staticmethod
    def _same(one: Any, other: Any) -> bool:
        return (one.topic, one.host, one.port) == (other.topic, other.host, other.port)

    def _announce_unsubscriptions(self, subscribers: list[Any]) -> None:
        for topic, ended in _by_topic(subscribers).items():
            self._send_to(self._published.clients(topic), _packets("unsubscribe", ended))

    def _request(self, client: _Client, request: Any) -> None:
        if request.request == "get_publishers":
            client.connection.send(packet("publisher_list", self._all_publishers()))
        elif request.request == "get_topics":
            lists = (each for client in self._clients for each in (client.publishers, client.subscribers))
            topics = sorted({one.topic for each in lists for one in each})
            client.connection.send(packet("topic_list", message_type("GzString_V")(data=topics)))
        elif request.request == "get_topic_namespaces":
            names = message_type("GzString_V")(data=self._namespaces())
            client.connection.send(packet("get_topic_namespaces_response", names))
        elif request.request == "topic_info":
            info: Any = message_type("TopicInfo")()
            info.publisher.extend(self._published.of(request.data))
            info.subscriber.extend(self._subscribed.of(request.data))
            types = (one.msg_type for one in (*info.publisher, *info.subscriber) if one.msg_type)
            info.msg_type = next(types, "")
            client.connection.send(packet("topic_info_response", info))

    def _remove(self, client: _Client) -> None:
        """Announce the end of what a closed connection had announced: all at once, for it may be much, to many."""
        self._clients.remove(client)
        self._published.forget(client, _by_topic(client.publishers))
        self._subscribed.forget(client, _by_topic(client.subscribers))
        if client.publishers:
            self._announce_ends(client.publishers)
        self._announce_unsubscriptions(client.subscribers)


def _by_topic(announced: list[Any]) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    for one in announced:
        found.setdefault(one.topic, []).append(one)
    return found


def _packets(kind: str, messages: list[Any]) -> bytes:
    return b"".join(packet(kind, message) for message in messages)
