"""Topics between processes, by eclipse-zenoh. Imported only when a link is opened.

Key expressions, with each name quoted into one part (`%2Fgazebo%2Fdefault%2Fgui`):

- ``libgz/topic/TOPIC``: the messages; attached to each stand the sender, the message's number, and its type;
- ``libgz/latch/TOPIC``: asked for the last messages of the publishers;
- liveliness tokens ``libgz/pub/TOPIC/TYPE/WHO``, ``libgz/sub/TOPIC/-/WHO`` and ``libgz/world/NAME/-/WHO``, where WHO is
  the session, a dot, and the process: they tell what is published and listened to, and go with the process.

The library calls back in threads of its own. There, nothing is done but to put data into queues and tables, and no lock
is taken: the library may be waiting for the call to end.
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
from libgz.classic.transport.subscriber import Subscriber
from libgz.classic.transport.topic import End, Incoming, Topic, log, sequence

__all__ = ["Network"]

ASK = 30.0  # [s] that other processes have to answer


def _quote(name: str) -> str:
    return quote(name, safe="")


def _config(mode: str, listen: list[str], connect: list[str], open_timeout: float) -> zenoh.Config:
    """No discovery: this address and no other."""
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


class _Way:
    """What this process has declared of a topic."""

    def __init__(self) -> None:
        self.publisher: zenoh.Publisher | None = None
        self.type_name = ""
        self.publishing: list[Any] = []  # what to undeclare when the last publisher goes
        self.listening: list[Any] = []


class Network:
    """The other processes.

    Args:
        endpoint: Such as `tcp/127.0.0.1:11345`.
        serve: Whether to listen there, as the server, or to connect.
        open_timeout: How long an answer to the first greeting may take [s].

    Raises:
        OSError: the endpoint cannot be opened.
    """

    def __init__(self, endpoint: str, serve: bool, open_timeout: float = 10.0) -> None:
        self.client = not serve
        self._manager = TopicManager.Instance()
        self._lock = threading.Lock()
        self._ways: dict[str, _Way] = {}
        self._tokens: dict[str, tuple[str, str, str, str]] = {}  # key to (what, name, type, process)
        self._worlds: dict[str, Any] = {}
        listen, connect = ([endpoint], []) if serve else ([], [endpoint])
        try:
            self._session: Any = zenoh.open(_config("router" if serve else "client", listen, connect, open_timeout))
        except zenoh.ZError as error:
            raise OSError(str(error)) from None
        # The simulation does not wait for a slow client; a client's command waits until it is sent.
        self._congestion = zenoh.CongestionControl.DROP if serve else zenoh.CongestionControl.BLOCK
        self._id = str(self._session.zid())
        self._who = _quote(f"{self._id}.{socket.gethostname()}:{os.getpid()}")
        me = weakref.ref(self)
        alive = self._session.liveliness()
        on_token = _direct(lambda sample: _on_token(me, sample))
        self._watch = alive.declare_subscriber("libgz/**", on_token, history=True)
        for reply in alive.get("libgz/**", timeout=ASK):  # to know what there is before anybody asks
            if reply.ok is not None:
                self._enter(str(reply.ok.key_expr))

    def close(self) -> None:
        """End the session; nothing comes or goes any more."""
        with self._lock:
            self._session.close()
            self._ways.clear()
            self._tokens.clear()

    def connected(self) -> bool:
        """Whether the server is there, for a client."""
        return bool(self._session.info.routers_zid())

    # What the others have ----------------------------------------------------------------------------------------

    def _enter(self, key: str) -> None:
        parts = [unquote(part) for part in key.split("/")]
        if len(parts) != 5 or parts[4].startswith(self._id + "."):
            return
        _, what, name, type_name, who = parts
        process = who.partition(".")[2]
        if re.fullmatch(r".+:\d{1,9}", process):  # anybody may connect, and say anything
            self._tokens[key] = (what, name, type_name, process)

    def _forget(self, key: str) -> None:
        self._tokens.pop(key, None)

    def namespaces(self) -> list[str]:
        """The worlds of the other processes."""
        return [name for what, name, _, _ in list(self._tokens.values()) if what == "world"]

    def advertised(self) -> dict[str, str]:
        """Topic to type name of what the other processes publish."""
        return {name: type_name for what, name, type_name, _ in list(self._tokens.values()) if what == "pub"}

    def ends(self, topic: str) -> list[End]:
        """Who publishes on a topic and who listens, in the other processes."""
        tokens = list(self._tokens.values())
        return [End(what, type_name, who) for what, name, type_name, who in tokens if name == topic and what != "world"]

    # What this process has ---------------------------------------------------------------------------------------

    def refresh_namespaces(self, names: list[str]) -> None:
        """Tell the names of this process's worlds."""
        with self._lock, contextlib.suppress(zenoh.ZError):
            for name in self._worlds.keys() - set(names):
                self._worlds.pop(name).undeclare()
            for name in names:
                if name not in self._worlds:
                    self._worlds[name] = self._token("world", name, "-")

    def refresh(self, topic: Topic) -> None:
        """Offer and ask for what this process now publishes and listens to."""
        with self._lock, contextlib.suppress(zenoh.ZError):
            if self._session.is_closed():
                return
            way = self._ways.setdefault(topic.name, _Way())
            type_name = topic.type_name()
            if way.publishing and type_name != way.type_name:
                way.publisher = None
                topic.remote = False
                _undeclare(way.publishing)
            if type_name and not way.publishing:
                self._offer(way, topic, type_name)
            if topic.subscribers and not way.listening:
                way.listening = [self._token("sub", topic.name, "-"), self._listen(topic)]
            elif way.listening and not topic.subscribers:
                _undeclare(way.listening)

    def _token(self, what: str, name: str, type_name: str) -> Any:
        return self._session.liveliness().declare_token(f"libgz/{what}/{_quote(name)}/{_quote(type_name)}/{self._who}")

    def _offer(self, way: _Way, topic: Topic, type_name: str) -> None:
        """Declare a topic that is published here."""
        publisher: zenoh.Publisher = self._session.declare_publisher(
            f"libgz/topic/{_quote(topic.name)}",
            congestion_control=self._congestion,
            allowed_destination=zenoh.Locality.REMOTE,
        )

        def on_match(status: Any) -> None:
            topic.remote = way.publisher is publisher and _matches(publisher)

        way.publisher, way.type_name = publisher, type_name
        listener = publisher.declare_matching_listener(_direct(on_match))
        manager, me, to = self._manager, weakref.ref(self), weakref.ref(topic)
        queryable = self._session.declare_queryable(
            f"libgz/latch/{_quote(topic.name)}",
            _direct(lambda query: manager.queue.append(functools.partial(_answer, me, to, query))),
            allowed_origin=zenoh.Locality.REMOTE,
        )
        way.publishing = [publisher, listener, queryable, self._token("pub", topic.name, type_name)]
        topic.remote = _matches(publisher)

    def _listen(self, topic: Topic) -> Any:
        manager, key = self._manager, f"libgz/topic/{_quote(topic.name)}"

        def on_message(sample: Any) -> None:
            incoming = _read(sample, None)
            if incoming is not None:
                manager.receive(topic, incoming)

        return self._session.declare_subscriber(key, _direct(on_message), allowed_origin=zenoh.Locality.REMOTE)

    def send(self, topic: Topic, publisher: int, number: int, message: Message) -> None:
        """Send a message to the processes that listen."""
        way = self._ways.get(topic.name)
        channel = way.publisher if way is not None else None
        if channel is not None:
            try:
                channel.put(message.SerializeToString(), attachment=self._stamp(publisher, number, message))
            except zenoh.ZError as error:
                log.debug("topic %s: a message was not sent: %s", topic.name, error)

    def _stamp(self, publisher: int, number: int, message: Message) -> bytes:
        return f"{self._id}.{publisher} {number} {message.GetTypeName()}".encode()

    def latch(self, topic: Topic, subscriber: Subscriber) -> None:
        """Ask the other processes for their last messages."""
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
                timeout=ASK,
            )


def _direct(callback: Callable[[Any], None]) -> Any:
    """A callback that the library calls in its network thread: otherwise each has a thread, for which the process's end
    would wait.
    """
    return zenoh.handlers.Callback(callback, None, indirect=False)


def _matches(publisher: Any) -> bool:
    """Whether somebody listens; the library's stubs promise a bool, and an object comes."""
    status = publisher.matching_status
    return bool(getattr(status, "matching", status))


def _undeclare(things: list[Any]) -> None:
    """Take back what was declared, the last first."""
    while things:
        with contextlib.suppress(zenoh.ZError):
            things.pop().undeclare()


def _on_token(network: weakref.ref[Network], sample: Any) -> None:
    found = network()
    if found is not None:
        (found._enter if sample.kind == zenoh.SampleKind.PUT else found._forget)(str(sample.key_expr))


def _answer(network: weakref.ref[Network], topic: weakref.ref[Topic], query: Any) -> None:
    """Answer a question for the last message of each publisher of this process; the server's thread does this."""
    found, known = network(), topic()
    if found is None or known is None:
        return
    for publisher in known.live_publishers():
        if publisher.latest is not None:
            number, message = publisher.latest
            stamp = found._stamp(publisher.id, number, message)
            with contextlib.suppress(zenoh.ZError):  # the one who asked is gone
                query.reply(query.key_expr, message.SerializeToString(), attachment=stamp)


def _read(sample: Any, subscriber: weakref.ref[Subscriber] | None) -> Incoming | None:
    """What came; None if it is not of our making."""
    words = sample.attachment.to_bytes().decode(errors="replace").split(" ") if sample.attachment is not None else []
    if len(words) != 3 or not words[1].isdecimal():
        return None
    return Incoming(next(sequence), words[0], int(words[1]), words[2], sample.payload.to_bytes(), subscriber)
