"""Network: the topics of this process and those of other ones, by Gazebo classic's protocol.

A process announces to the master what it publishes and subscribes to, and listens at a port of its own. A subscriber
connects to each publisher of its topic; messages go directly from one to the other. Subscribers of one process share a
connection; those that also want the last message from before, latching ones, have one each.
"""

from __future__ import annotations

import collections
import functools
import math
import socket
import threading
import time
import weakref
from typing import Any

from libgz.base.errors import GazeboError, ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport.address import Address, encoded, listening_socket, listening_sockets, publicized_address
from libgz.classic.transport.framing import frame, packet, read_packet
from libgz.classic.transport.loop import Connection, SocketLoop
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.master import Master
from libgz.classic.transport.topic import Incoming, LocalSubscriber, Topic, sequence

__all__ = ["Network"]

SHARE = 0.02  # of a server's time, for handling what clients send
REQUEST = 1 << 16  # [bytes] of a subscriber's request
SOURCES = 500  # connections of a server to publishers of other processes
READING = ("_info", "_list", "_data", "_sdf")  # ends of the requests that only read a world
LARGEST = 1 << 26, 1 << 30  # [bytes] of a message that a server and a client accept
SEND_PATIENCE, CLOSE_PATIENCE = 10.0, (0.5, 5.0)  # [s] of a client for a slow receiver; of servers and clients
LOOK_UPS = 16  # threads that look up names of machines, which may take seconds for each
MOST_LOOK_UPS, LOOK_UP_AGAIN = 1000, 10.0  # names that wait, and when others have their turn [s]
NO_ADDRESS = OSError, ValueError, OverflowError  # what names that are none, and their ports, raise
ANSWER_PATIENCE = 5.0  # [s] for the master
ANSWERS = {"topic_info_response": "TopicInfo", "topic_list": "GzString_V"}  # and their types

_Key = tuple[str, str, int]  # topic, host, port of a publisher


class Network:
    """A connection to other processes.

    Args:
        address: Of the master. With port 0 a server takes a free port.
        serve: Whether to be the master, or only to connect to it.
        timeout: For the connection to the master [s].
        watch_only: Whether other processes may only receive, and ask on ~/request for what they show.

    Attributes:
        client: Whether there is a server to wait for.
        address: Of the master, with its port.

    Raises:
        OSError: there is no master at this address, or it does not answer; a server cannot listen there.
    """

    def __init__(self, address: Address, serve: bool, timeout: float = 10.0, watch_only: bool = False) -> None:
        self.client, self.watch_only = not serve, watch_only
        self._manager = TopicManager.Instance()
        self._lock = threading.RLock()  # of the tables of receivers; sending may find that one is closed
        self._receivers: dict[str, list[Connection]] = {}
        self._publishers: dict[_Key, str] = {}  # of other processes, to the types of their messages
        self._types: dict[str, str] = {}  # topic to type of what those publish
        self._advertised: dict[str, Any] = {}  # topic to what was announced
        self._subscribed: dict[str, Any] = {}
        self._sources: dict[tuple[_Key, int], Connection] = {}  # for all subscribers, 0, or for one, its id
        self._hosts: dict[_Key, str] = {}  # addresses of those whose machines were named, and looked up
        self._unknown: dict[_Key, float] = {}  # publishers without an address -> when it is looked up again [s]
        self._to_look_up: collections.deque[tuple[Topic, _Key]] = collections.deque()
        self._lookers = 0  # threads
        self._namespaces: list[str] = []
        self._registered: set[str] = set()  # of this process
        self._ready = threading.Event()
        # Answers do not say what was asked. They come in the order of the questions, of which there is one at a time;
        # one that comes late, after its question was given up, is not that of the next. If fewer come in time than
        # were awaited, the master has left a question out, and the last one is that of the last question.
        self._answers: dict[str, Any] = {}
        self._awaited = collections.Counter[str]()  # answers that have not come
        self._answered = threading.Condition()
        self._asking = threading.RLock()
        listeners = listening_sockets(address) if serve else []
        if listeners:
            address = Address(address.host, listeners[0].getsockname()[1])
        self.address = address
        self._loop = SocketLoop(SHARE if serve else None)
        try:
            self._connect(timeout, Master(self._loop, listeners) if serve else None)
        except OSError:
            self._loop.close(0.0)
            raise

    def _connect(self, timeout: float, master: Master | None) -> None:
        """Connect to the master, which may be this process's, and listen for subscribers."""
        where: Any = encoded(self.address.host), self.address.port
        made = socket.create_connection(where, timeout=timeout)
        if master is not None:
            master.own = made.getsockname()
        own = publicized_address()
        named = own != "127.0.0.1"
        listener = listening_socket(own if named else made.getsockname()[0])
        self._own = (own if named else listener.getsockname()[0], listener.getsockname()[1])
        self._loop.listen(listener, self._accept, REQUEST)
        self._master = Connection(self._loop, made, LARGEST[self.client])
        self._master.lossless = True
        self._master.on_frame = self._receive_packet
        self._master.on_close = self._master_closed
        self._loop.call(self._master.start)
        if not self._ready.wait(timeout):
            raise TimeoutError("it does not answer as a master of Gazebo")

    def close(self) -> None:
        """Send what waits, and close all connections. Can be called twice."""
        self._loop.close(CLOSE_PATIENCE[self.client])
        self._master.open = False

    def connected(self) -> bool:
        """Whether the connection to the master is open."""
        return self._master.open

    # Other processes ---------------------------------------------------------------------------------------------

    def namespaces(self) -> list[str]:
        """Return the names of the other processes' worlds."""
        return [name for name in self._namespaces if name not in self._registered]

    def advertised(self) -> dict[str, str]:
        """Return topic to type name of what the other processes publish."""
        return self._types

    def info(self, topic: str) -> Any:
        """Return the master's TopicInfo on a topic.

        Raises:
            GazeboError: the master does not answer, or has ended.
        """
        return self._ask("topic_info", topic, "topic_info_response")

    def topics(self) -> list[str]:
        """Return the names of all topics, those without publishers included.

        Raises:
            GazeboError: the master does not answer, or has ended.
        """
        return list(self._ask("get_topics", "", "topic_list").data)

    def _ask(self, what: str, about: str, answer: str) -> Any:
        """Return the master's answer, one of the types in ANSWERS."""
        request = message_type("Request")(id=0, request=what, data=about)
        with self._asking, self._answered:
            self._answers.pop(answer, None)
            self._awaited[answer] += 1
            self._loop.call(lambda: self._tell("request", request))
            self._answered.wait_for(lambda: not self._awaited[answer] or not self._master.open, ANSWER_PATIENCE)
            if not self._master.open:
                raise GazeboError("The server has ended.")
            if answer not in self._answers:
                raise GazeboError(f"the master at {self.address.uri} did not answer in {ANSWER_PATIENCE:g} s")
            self._awaited[answer] = 0
            return self._answers.pop(answer)

    def _receive_packet(self, data: bytes) -> None:
        """Handle a packet of the master.

        Raises:
            ParameterError: it is damaged.
        """
        kind, content = read_packet(data)
        if kind == "topic_namepaces_init":
            self._namespaces = list(message_type("GzString_V").FromString(content).data)
        elif kind == "topic_namespace_add":
            name: str = message_type("GzString").FromString(content).data
            if name not in self._namespaces:
                self._namespaces = [*self._namespaces, name]
        elif kind == "publishers_init":
            for publisher in message_type("Publishers").FromString(content).publisher:
                self._add_publisher(publisher)
            self._ready.set()
        elif kind in ("publisher_add", "publisher_advertise", "publisher_subscribe"):
            self._add_publisher(message_type("Publish").FromString(content))
        elif kind in ("publisher_del", "unadvertise"):
            found: Any = message_type("Publish").FromString(content)
            key = found.topic, found.host, found.port
            self._publishers.pop(key, None)
            self._hosts.pop(key, None)
            if self._unknown.get(key, math.inf) < math.inf:
                del self._unknown[key]
            self._types = {key[0]: name for key, name in self._publishers.items()}
        elif kind in ANSWERS and self._awaited[kind]:
            with self._answered:
                self._answers[kind] = message_type(ANSWERS[kind]).FromString(content)
                self._awaited[kind] -= 1
                self._answered.notify_all()

    def _master_closed(self) -> None:
        with self._answered:
            self._answered.notify_all()

    def _add_publisher(self, publisher: Any) -> None:
        key = publisher.topic, publisher.host, publisher.port
        if key[1:] != self._own:
            self._publishers[key] = publisher.msg_type
            self._types = {**self._types, publisher.topic: publisher.msg_type}
            topic = self._manager.topics.get(publisher.topic)
            if topic is not None:
                self._connect_sources(topic)

    # This process ------------------------------------------------------------------------------------------------

    def _tell(self, kind: str, message: Message) -> None:
        self._master.send(packet(kind, message))

    def refresh_namespaces(self, names: list[str]) -> None:
        """Announce the names of this process's worlds."""
        for name in names:
            if name not in self._registered:
                self._registered.add(name)
                message = message_type("GzString")(data=name)
                self._loop.call(functools.partial(self._tell, "register_topic_namespace", message))

    def refresh(self, topic: Topic) -> None:
        """Announce the publishers and subscribers that this process now has."""
        self._loop.call(functools.partial(self._refresh, topic))

    def _refresh(self, topic: Topic) -> None:
        if not self._master.open:
            return
        name, type_name = topic.name, topic.type_name()
        host, port = self._own
        before = self._advertised.get(name)
        if before is not None and before.msg_type != type_name:
            self._tell("unadvertise", self._advertised.pop(name))
            with self._lock:
                topic.remote = False
                ending = self._receivers.pop(name, [])
            for connection in ending:
                connection.end()
        if type_name and name not in self._advertised:
            publish = message_type("Publish")(topic=name, msg_type=type_name, host=host, port=port)
            self._advertised[name] = publish
            self._tell("advertise", publish)
        if topic.subscribers and name not in self._subscribed:
            known = self._types.get(name) or type_name or topic.expected_type()
            subscribe = message_type("Subscribe")(topic=name, host=host, port=port, msg_type=known, latching=False)
            self._subscribed[name] = subscribe
            self._tell("subscribe", subscribe)
        elif not topic.subscribers and name in self._subscribed:
            self._tell("unsubscribe", self._subscribed.pop(name))
        self._connect_sources(topic)

    # Receiving ---------------------------------------------------------------------------------------------------

    def _connect_sources(self, topic: Topic) -> None:
        """Connect to the publishers of a topic that are not connected, and close connections without subscribers."""
        if self.watch_only and not _asks(topic.name):
            if any(key[0] == topic.name for key in self._publishers):
                self._loop.warn("this server can only be watched: what clients publish on %s is ignored", topic.name)
            return
        subscribers = topic.live_subscribers()
        wanted = {id(one): weakref.ref(one) for one in subscribers if one.latching}
        if any(not one.latching for one in subscribers):
            wanted[0] = None  # type: ignore[assignment]
        for (key, target), connection in list(self._sources.items()):
            if key[0] == topic.name and target not in wanted:
                del self._sources[key, target]
                connection.close()
        now = time.monotonic()
        for key, type_name in list(self._publishers.items()):
            if key[0] == topic.name and self._unknown.get(key, 0.0) <= now:
                for target, subscriber in wanted.items():
                    if (key, target) not in self._sources:
                        self._open_source(topic, key, type_name, target, subscriber)

    def _open_source(
        self, topic: Topic, key: _Key, type_name: str, target: int, subscriber: weakref.ref[LocalSubscriber] | None
    ) -> None:
        if not self.client and len(self._sources) >= SOURCES:
            self._close_ended_sources()
        if not self.client and len(self._sources) >= SOURCES:
            self._loop.warn("clients publish on more than %d topics; others are not received", SOURCES)
            return
        host, port = self._hosts.get(key, key[1]), key[2]
        try:
            flags = socket.AI_NUMERICHOST if host != "localhost" else 0
            family, kind, protocol, _, where = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=flags)[0]
        except NO_ADDRESS:
            self._look_up_soon(topic, key)
            return
        try:
            made = socket.socket(family, kind, protocol)
        except OSError as error:  # clients can announce more than there are descriptors
            self._loop.warn("what clients publish on %s is not received: %s", topic.name, error)
            return
        made.setblocking(False)
        made.connect_ex(where)
        connection = Connection(self._loop, made, LARGEST[self.client])
        connection.on_frame = functools.partial(self._take, topic, type_name, subscriber)
        connection.on_close = functools.partial(self._forget_source, key, target)
        self._sources[key, target] = connection
        host, port = self._own
        own = message_type("Subscribe")(
            topic=topic.name, host=host, port=port, msg_type=type_name, latching=subscriber is not None
        )
        connection.send(packet("sub", own))
        connection.start()

    def _close_ended_sources(self) -> None:
        """Close connections to publishers that have ended: at once, their last messages might be lost."""
        for (key, target), connection in list(self._sources.items()):
            if key not in self._publishers:
                del self._sources[key, target]
                connection.close()

    def _forget_source(self, key: _Key, target: int) -> None:
        self._sources.pop((key, target), None)

    def _look_up_soon(self, topic: Topic, key: _Key) -> None:
        """Find the address of a publisher's machine by its name, in one of few threads: it may take seconds."""
        if self._unknown.get(key) == math.inf:
            return
        if len(self._to_look_up) >= MOST_LOOK_UPS:
            self._unknown[key] = time.monotonic() + LOOK_UP_AGAIN
            return
        self._unknown[key] = math.inf
        self._to_look_up.append((topic, key))
        if self._lookers < LOOK_UPS:
            self._begin_look_up()

    def _begin_look_up(self) -> None:
        threading.Thread(target=self._look_up_all, name="names", daemon=True).start()
        self._lookers += 1  # not of one that could not start

    def _look_up_all(self) -> None:
        while self._to_look_up:
            try:
                topic, key = self._to_look_up.popleft()
            except IndexError:
                break
            try:
                host = str(socket.getaddrinfo(key[1], key[2], type=socket.SOCK_STREAM)[0][4][0])
            except NO_ADDRESS:
                host = ""
            self._loop.call(functools.partial(self._looked_up, topic, key, host))
        self._loop.call(self._end_look_up)

    def _end_look_up(self) -> None:
        self._lookers -= 1
        if self._to_look_up:  # it came meanwhile
            self._begin_look_up()

    def _looked_up(self, topic: Topic, key: _Key, host: str) -> None:
        """Connect to a publisher whose machine has an address now; an empty one: it was not found."""
        self._unknown.pop(key, None)
        if key not in self._publishers:
            return
        if host:
            self._hosts[key] = host
            self._connect_sources(topic)
        else:
            self._unknown[key] = time.monotonic() + LOOK_UP_AGAIN

    def _take(self, topic: Topic, type_name: str, subscriber: weakref.ref[LocalSubscriber] | None, data: bytes) -> None:
        if self.watch_only:
            request: Any = message_type("Request").FromString(data)
            if not request.request.endswith(READING):
                self._loop.warn("this server can only be watched: request %.40r is ignored", request.request)
                return
        self._manager.receive(topic, Incoming(next(sequence), type_name, data, subscriber))

    def attached(self, topic: str) -> bool:
        """Whether another process publishes a topic, and all those that do have been asked for their messages."""
        found: list[bool] = []
        done = threading.Event()

        def look() -> None:  # after what this thread has announced before
            keys = [key for key in self._publishers if key[0] == topic]
            asked = {key for (key, _), connection in self._sources.items() if not connection.waits}
            found.append(bool(keys) and asked.issuperset(keys))
            done.set()

        self._loop.call(look)
        return done.wait(ANSWER_PATIENCE) and found[0]

    def receivers(self, topic: str) -> int:
        """Return how many other processes are connected to this one's publishers of a topic."""
        with self._lock:
            return len(self._receivers.get(topic, ()))

    # Sending -----------------------------------------------------------------------------------------------------

    def _accept(self, connection: Connection) -> None:
        connection.on_frame = functools.partial(self._begin, connection)

    def _begin(self, connection: Connection, data: bytes) -> None:
        """Handle a subscriber's request: the first packet on its connection.

        Raises:
            ParameterError: it is none.
        """
        kind, content = read_packet(data)
        if kind != "sub":
            raise ParameterError(f"a publisher was sent a packet {kind[:40]!r} instead of 'sub'")
        wanted: Any = message_type("Subscribe").FromString(content)
        topic = self._manager.topics.get(wanted.topic)
        if topic is None or wanted.topic not in self._advertised:
            connection.end()
            return
        connection.on_frame = _refuse
        connection.on_close = functools.partial(self._end, connection, topic)
        connection.on_room = functools.partial(self._resume, connection, topic)
        connection.tag = {}
        with self._lock:
            self._receivers.setdefault(topic.name, []).append(connection)
            topic.remote = True
            for publisher in topic.live_publishers() if wanted.latching else ():
                if publisher.latest is not None:
                    number, message = publisher.latest
                    connection.tag[publisher.id] = number
                    connection.send(frame(message.SerializeToString()))

    def _resume(self, connection: Connection, topic: Topic) -> None:
        """Send to a subscriber again that had received nothing for a while."""
        if topic.remote:
            return
        with self._lock:
            topic.remote = topic.remote or connection in self._receivers.get(topic.name, ())

    def _end(self, connection: Connection, topic: Topic) -> None:
        """Forget a subscriber that has closed its connection."""
        with self._lock:
            receivers = self._receivers.get(topic.name, [])
            if connection in receivers:
                receivers.remove(connection)
            if not receivers:
                self._receivers.pop(topic.name, None)
                topic.remote = False

    def send(self, topic: Topic, publisher: int, number: int, message: Message) -> None:
        """Send a message to the subscribers of other processes."""
        with self._lock:
            receivers = [one for one in self._receivers.get(topic.name, ()) if not one.stalled]
            if not receivers:
                topic.remote = False  # until one receives again
                return
            data = frame(message.SerializeToString())
            for connection in receivers:
                if connection.tag.get(publisher, 0) < number:  # it was not sent as the last one from before
                    connection.send(data)
        if self.client and not self._loop.inside():
            end = time.monotonic() + SEND_PATIENCE
            for connection in receivers:
                connection.wait_room(max(0.0, end - time.monotonic()))


def _asks(topic: str) -> bool:
    """Whether a topic is ~/request of a world."""
    return topic.startswith("/gazebo/") and topic.endswith("/request") and topic.count("/") == 3


def _refuse(_data: bytes) -> None:
    """Take what comes after a subscriber's request.

    Raises:
        ParameterError: always: subscribers send nothing more.
    """
    raise ParameterError("a subscriber sent more than its request")
