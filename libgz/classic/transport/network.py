"""Topics between processes, by eclipse-zenoh. Imported only when a link is opened.

Key expressions, with each name quoted into one part (`%2Fgazebo%2Fdefault%2Fgui`):

- ``libgz/topic/TOPIC``: the messages; attached to each are the sender, the message's number, and its type;
- ``libgz/latch/TOPIC``: queries for the last messages of the publishers;
- liveliness tokens ``libgz/pub/TOPIC/TYPE/WHO``, ``libgz/sub/TOPIC/-/WHO`` and ``libgz/world/NAME/-/WHO``, where WHO is
  the session, a dot, and the process: they announce publishers, subscribers and worlds, and end with the process.

The library calls callbacks in its own threads. They only put data into queues and tables, and take no lock: the library
may be waiting for the callback to return.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import re
import socket
import threading
import weakref
from collections.abc import Callable
from typing import Any
from urllib.parse import quote, unquote

import zenoh

from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.topic import Endpoint, Incoming, LocalSubscriber, Topic, log, sequence

__all__ = ["Network"]

QUERY_TIMEOUT = 30.0  # [s] for answers of other processes


def _quote(name: str) -> str:
    return quote(name, safe="")


def _config(mode: str, listen: list[str], connect: list[str], open_timeout: float) -> zenoh.Config:
    """Return a configuration for one address, without discovery."""
    config = zenoh.Config()
    settings: dict[str, Any] = {
        "mode": mode,
        "listen/endpoints": listen,
        "listen/timeout_ms": 0,
        "listen/exit_on_failure": True,
        "connect/endpoints": connect,
        "connect/timeout_ms": 0,
        "connect/exit_on_failure": True,
        "scouting/delay": 0,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/unicast/open_timeout": int(1000 * open_timeout),
    }
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return config


class _Channel:
    """The declarations of a topic in this process."""

    def __init__(self) -> None:
        self.publisher: zenoh.Publisher | None = None
        self.type_name = ""
        self.publishing: list[Any] = []  # to undeclare with the last publisher
        self.listening: list[Any] = []  # to undeclare with the last subscriber


class Network:
    """A connection to other processes.

    Args:
        endpoint: Such as `tcp/127.0.0.1:11345`.
        serve: Whether to listen there, as the server, or to connect.
        open_timeout: Time limit of the handshake [s].

    Raises:
        OSError: the endpoint cannot be opened.
    """

    def __init__(self, endpoint: str, serve: bool, open_timeout: float = 10.0) -> None:
        self.client = not serve
        self._manager = TopicManager.Instance()
        self._lock = threading.Lock()
        self._channels: dict[str, _Channel] = {}
        self._tokens: dict[str, tuple[str, str, str, str]] = {}  # key to (what, name, type, process)
        self._worlds: dict[str, Any] = {}
        listen, connect = ([endpoint], []) if serve else ([], [endpoint])
        try:
            self._session: Any = zenoh.open(_config("router" if serve else "client", listen, connect, open_timeout))
        except zenoh.ZError as error:
            raise OSError(str(error)) from None
        # The server drops messages for a slow client instead of waiting; a client waits until its command is sent.
        self._congestion = zenoh.CongestionControl.DROP if serve else zenoh.CongestionControl.BLOCK
        self._id = str(self._session.zid())
        self._who = _quote(f"{self._id}.{socket.gethostname()}:{os.getpid()}")
        me = weakref.ref(self)
        alive = self._session.liveliness()
        on_token = _direct(lambda sample: _on_token(me, sample))
        self._watch = alive.declare_subscriber("libgz/**", on_token, history=True)
        for reply in alive.get("libgz/**", timeout=QUERY_TIMEOUT):  # complete before the first query
            if reply.ok is not None:
                self._add_token(str(reply.ok.key_expr))

    def close(self) -> None:
        """Close the session. Can be called twice."""
        with self._lock:
            self._session.close()
            self._channels.clear()
            self._tokens.clear()

    def connected(self) -> bool:
        """Whether a client is connected to its server."""
        return bool(self._session.info.routers_zid())

    # Other processes ---------------------------------------------------------------------------------------------

    def _add_token(self, key: str) -> None:
        parts = [unquote(part) for part in key.split("/")]
        if len(parts) != 5 or parts[4].startswith(self._id + "."):
            return
        _, what, name, type_name, who = parts
        process = who.partition(".")[2]
        if re.fullmatch(r".+:\d{1,9}", process):  # tokens are untrusted input
            self._tokens[key] = (what, name, type_name, process)

    def _remove_token(self, key: str) -> None:
        self._tokens.pop(key, None)

    def namespaces(self) -> list[str]:
        """Return the names of the other processes' worlds."""
        return [name for what, name, _, _ in list(self._tokens.values()) if what == "world"]

    def advertised(self) -> dict[str, str]:
        """Return topic to type name of what the other processes publish."""
        return {name: type_name for what, name, type_name, _ in list(self._tokens.values()) if what == "pub"}

    def endpoints(self, topic: str) -> list[Endpoint]:
        """Return the publishers and subscribers of a topic in the other processes."""
        return [
            Endpoint(what, type_name, who)
            for what, name, type_name, who in list(self._tokens.values())
            if name == topic and what != "world"
        ]

    # This process ------------------------------------------------------------------------------------------------

    def refresh_namespaces(self, names: list[str]) -> None:
        """Announce the names of this process's worlds."""
        with self._lock, contextlib.suppress(zenoh.ZError):
            for name in self._worlds.keys() - set(names):
                self._worlds.pop(name).undeclare()
            for name in names:
                if name not in self._worlds:
                    self._worlds[name] = self._token("world", name, "-")

    def refresh(self, topic: Topic) -> None:
        """Announce the publishers and subscribers that this process now has."""
        with self._lock, contextlib.suppress(zenoh.ZError):
            if self._session.is_closed():
                return
            channel = self._channels.setdefault(topic.name, _Channel())
            type_name = topic.type_name()
            if channel.publishing and type_name != channel.type_name:
                channel.publisher = None
                topic.remote = False
                _undeclare(channel.publishing)
            if type_name and not channel.publishing:
                self._declare_publisher(channel, topic, type_name)
            if topic.subscribers and not channel.listening:
                channel.listening = [self._token("sub", topic.name, "-"), self._declare_subscriber(topic)]
            elif channel.listening and not topic.subscribers:
                _undeclare(channel.listening)
            if not (channel.publishing or channel.listening):
                self._channels.pop(topic.name, None)

    def _token(self, what: str, name: str, type_name: str) -> Any:
        return self._session.liveliness().declare_token(f"libgz/{what}/{_quote(name)}/{_quote(type_name)}/{self._who}")

    def _declare_publisher(self, channel: _Channel, topic: Topic, type_name: str) -> None:
        """Declare a topic that this process publishes."""
        publisher: zenoh.Publisher = self._session.declare_publisher(
            f"libgz/topic/{_quote(topic.name)}",
            congestion_control=self._congestion,
            allowed_destination=zenoh.Locality.REMOTE,
        )

        def on_match(status: Any) -> None:
            topic.remote = channel.publisher is publisher and _matches(publisher)

        channel.publisher, channel.type_name = publisher, type_name
        listener = publisher.declare_matching_listener(_direct(on_match))
        manager, me, to = self._manager, weakref.ref(self), weakref.ref(topic)
        queryable = self._session.declare_queryable(
            f"libgz/latch/{_quote(topic.name)}",
            _direct(lambda query: manager.queue.append(functools.partial(_answer, me, to, query))),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        channel.publishing = [publisher, listener, queryable, self._token("pub", topic.name, type_name)]
        topic.remote = _matches(publisher)

    def _declare_subscriber(self, topic: Topic) -> Any:
        manager, key = self._manager, f"libgz/topic/{_quote(topic.name)}"

        def on_message(sample: Any) -> None:
            incoming = _read(sample, None)
            if incoming is not None:
                manager.receive(topic, incoming)

        return self._session.declare_subscriber(key, _direct(on_message), allowed_origin=zenoh.Locality.REMOTE)

    def send(self, topic: Topic, publisher: int, number: int, message: Message) -> None:
        """Send a message to the subscribers of other processes."""
        channel = self._channels.get(topic.name)
        sender = channel.publisher if channel is not None else None
        if sender is not None:
            try:
                sender.put(message.SerializeToString(), attachment=self._stamp(publisher, number, message))
            except zenoh.ZError as error:
                log.debug("topic %s: a message was not sent: %s", topic.name, error)

    def _stamp(self, publisher: int, number: int, message: Message) -> bytes:
        return f"{self._id}.{publisher} {number} {message.GetTypeName()}".encode()

    def latch(self, topic: Topic, subscriber: LocalSubscriber) -> None:
        """Request the last messages of the other processes."""
        manager, to = self._manager, weakref.ref(subscriber)

        def on_reply(reply: Any) -> None:
            incoming = _read(reply.ok, to) if reply.ok is not None else None
            if incoming is not None:
                manager.receive(topic, incoming)

        with contextlib.suppress(zenoh.ZError):
            self._session.get(
                f"libgz/latch/{_quote(topic.name)}",
                _direct(on_reply),
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                allowed_destination=zenoh.Locality.REMOTE,
                timeout=QUERY_TIMEOUT,
            )


def _direct(callback: Callable[[Any], None]) -> Any:
    """Return a callback that the library calls in its network thread.

    Otherwise each callback has its own thread, which delays the end of the process.
    """
    return zenoh.handlers.Callback(callback, None, indirect=False)


def _matches(publisher: Any) -> bool:
    """Whether other processes have a subscriber; the library's stubs declare a bool, but it returns an object."""
    status = publisher.matching_status
    return bool(getattr(status, "matching", status))


def _undeclare(things: list[Any]) -> None:
    """Undeclare what was declared, in reverse order."""
    while things:
        with contextlib.suppress(zenoh.ZError):
            things.pop().undeclare()


def _on_token(network: weakref.ref[Network], sample: Any) -> None:
    found = network()
    if found is None:
        return
    if sample.kind == zenoh.SampleKind.PUT:
        found._add_token(str(sample.key_expr))
    else:
        found._remove_token(str(sample.key_expr))


def _answer(network: weakref.ref[Network], topic: weakref.ref[Topic], query: Any) -> None:
    """Answer a query for the last message of each publisher of this process, in the delivering thread."""
    found, known = network(), topic()
    if found is None or known is None:
        return
    for publisher in known.live_publishers():
        if publisher.latest is not None:
            number, message = publisher.latest
            stamp = found._stamp(publisher.id, number, message)
            with contextlib.suppress(zenoh.ZError):  # the querying process has ended
                query.reply(query.key_expr, message.SerializeToString(), attachment=stamp)


def _read(sample: Any, subscriber: weakref.ref[LocalSubscriber] | None) -> Incoming | None:
    """Return a received message; None if libgz did not send it."""
    words = sample.attachment.to_bytes().decode(errors="replace").split(" ") if sample.attachment is not None else []
    if len(words) != 3 or not words[1].isdecimal():
        return None
    return Incoming(next(sequence), words[0], int(words[1]), words[2], sample.payload.to_bytes(), subscriber)
