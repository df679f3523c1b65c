"""Node: a node of ROS 1: registered with a master, it publishes, subscribes and serves; by the standard library."""

from __future__ import annotations

import logging
import os
import queue
import socket
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import urlsplit

from libgz.base.errors import ParameterError
from libgz.ros.loop import Listener, Loop
from libgz.ros.names import NodeNames
from libgz.ros.packed import Outbox
from libgz.ros.packing import Buffer, codec
from libgz.ros.tcpros import U32, Caller, Feed, Reader
from libgz.ros.types import MessageType, ServiceType
from libgz.ros.xmlrpc import MOST_REQUEST, Server, XmlRpcError, call, shown

__all__ = ["Node", "Publisher", "ServiceServer", "Subscriber"]

log = logging.getLogger("libgz.ros")

CHECK_PERIOD = 0.5  # [s] between two looks whether the master is there and knows this node
CLOSING_PATIENCE = 5.0  # [s] for all calls at the end
MOST_PUBLISHERS = 64  # of one topic that are read at the same time
MOST_ENDING = 10_000  # topics and services that have ended, and of which a master that is gone may know yet
MOST_PLACE = 1 << 16  # bytes of the answer where a publisher is, of which many may come at a time
LONGEST_URI = 1000  # characters of the address of a node
CONNECT_PATIENCE = 3.0  # [s]
PARAMETER_PATIENCE = 10.0  # [s]; the description of a robot is long


class RefusalError(XmlRpcError):
    """A master that answers that it does not do what it is asked for."""


class Publisher:
    """What a node publishes on one topic.

    Attributes:
        listened: whether there are subscribers, or the topic keeps its last message for those that come.
    """

    def __init__(self, node: Node, topic: str, kind: MessageType, queue: int, latch: bool) -> None:
        self.node, self.topic, self.kind, self.queue, self.latch = node, topic, kind, queue, latch
        self.codec = codec(kind)
        self.outbox = None if latch else Outbox()
        self._latched: bytes | None = None
        self._joining = threading.Lock()  # of what is kept or gathered, and of who gets it
        self.readers: tuple[Reader, ...] = ()
        self.listened = latch
        self.users = 0

    @property
    def subscribed(self) -> bool:
        """Whether there are subscribers now."""
        return bool(self.readers)

    def publish(self, body: list[Buffer]) -> None:
        """Send a message, given by its parts, to all subscribers; nobody waits for a slow one."""
        self.flush()  # of the same topic, and earlier
        size = sum(map(len, body))
        parts = [U32.pack(size), *body]
        readers = self.readers
        if self.latch:
            with self._joining:
                self._latched, readers = b"".join(parts), self.readers
        for reader in readers:
            reader.push(parts, size + U32.size)

    def flush(self) -> None:
        """Send what native code has published."""
        if self.outbox is None or not self.outbox.used:
            return
        with self._joining:
            frames = self.outbox.take()
            waiting = [(reader, frames[reader.skipped :]) for reader in self.readers]
            for reader, _ in waiting:
                reader.skipped = 0
        for reader, rest in waiting:
            if rest:
                reader.push([rest], len(rest), several=True)

    def connected(self, reader: Reader) -> None:
        """A subscriber came; what was kept waits for it, before all that is published from now on."""
        with self._joining:
            if self._latched is not None:
                reader.connection.queue.append((self._latched,))
            if self.outbox is not None:
                reader.skipped = int(self.outbox.used)
            self.readers = (*self.readers, reader)
        self.listened = True
        self.node.note_change(self)

    def disconnected(self, reader: Reader) -> None:
        """A subscriber went."""
        self.readers = tuple(one for one in self.readers if one is not reader)
        self.listened = self.latch or bool(self.readers)
        self.node.note_change(self)


class Subscriber:
    """A subscription of a node: its receivers get the bytes of each message, in the loop's thread."""

    def __init__(self, node: Node, topic: str, kind: MessageType) -> None:
        self.node, self.topic, self.kind, self.codec = node, topic, kind, codec(kind)
        self.receivers: tuple[Callable[[bytes], Any], ...] = ()
        self.publishers: dict[str, Feed | None] = {}  # by address; None while it is being connected

    def received(self, body: bytes) -> None:
        """Pass a message on."""
        for receive in self.receivers:
            receive(body)


class ServiceServer:
    """A service of a node: `handle` gets each request and a function that takes the answer; whether it accepts it."""

    def __init__(
        self, name: str, kind: ServiceType, handle: Callable[[bytes, Callable[[bool, bytes], None]], bool]
    ) -> None:
        self.name, self.kind, self.request = name, kind, handle
        self.codecs = codec(kind.request), codec(kind.response)


class Node:
    """A node of ROS 1.

    The master may come late, end and return: a thread looks for it, and registers all again whenever it does not know
    this node.

    Args:
        names: its name, remappings and addresses.

    Attributes:
        notify: called, in the wire's thread, when subscribers have come or gone.
        registered: how often all was registered with a master.
        changed: publishers whose subscribers came or went.
    """

    def __init__(self, names: NodeNames) -> None:
        self.names, self.name, self.master = names, names.name, names.master
        self.notify: Callable[[], object] = lambda: None
        self.registered = 0
        self.changed: dict[Publisher, None] = {}
        self._parameters: dict[str, Any] = {
            f"{self.name}/{name}": _typed(value) for name, value in names.parameters.items()
        }
        self._publishers: dict[str, Publisher] = {}
        self._subscribers: dict[str, Subscriber] = {}
        self._services: dict[str, ServiceServer] = {}
        self._lock = threading.RLock()  # reentrant, because Python may collect a publication within
        self._tasks: queue.SimpleQueue[Callable[[], object] | None] = queue.SimpleQueue()
        self._ending: dict[tuple[str, str], Publisher | Subscriber | ServiceServer] = {}  # that the master may know yet
        self._known = self._ended = False
        self._complained = False
        self._connecting = threading.BoundedSemaphore(MOST_PUBLISHERS)
        self.first_look = threading.Event()
        self._loop = Loop("ros-wire")
        self._listener = Listener(self._loop, names.address, self._accept)
        methods: dict[str, Callable[..., Any]] = {
            "getBusInfo": self._bus_info,
            "getBusStats": lambda _caller: (1, "", [[], [], []]),
            "getMasterUri": lambda _caller: (1, "", self.master),
            "getPid": lambda _caller: (1, "", os.getpid()),
            "getPublications": lambda _caller: (1, "", _listed(self._all_publishers())),
            "getSubscriptions": lambda _caller: (1, "", _listed(self._all_subscribers())),
            "paramUpdate": lambda _caller, _key, _value: (1, "", 0),
            "publisherUpdate": self._publisher_update,
            "requestTopic": self._request_topic,
            "shutdown": self._shut_down,
        }
        self._slave = Server(names.address, methods)
        host = f"[{names.host}]" if ":" in names.host else names.host
        self.uri = f"http://{host}:{self._slave.port}/"
        self._service_uri = f"rosrpc://{host}:{self._listener.port}"
        self._registrar = threading.Thread(target=self._run, name="ros-master", daemon=True)

    def start(self) -> None:
        """Begin to serve, and to look for the master."""
        self._loop.start()
        self._listener.start()
        self._slave.start()
        self._registrar.start()

    def close(self) -> None:
        """Unregister all, and end."""
        if self._ended:
            return
        self._ended = True
        end = time.monotonic() + CLOSING_PATIENCE
        self._tasks.put(None)  # after the calls for what plugins have just ended
        self._registrar.join(CLOSING_PATIENCE)
        if self._known:
            self._unregister_all(end)
        self._slave.close()
        self._listener.close()
        self._loop.close()

    # Topics and services -----------------------------------------------------------------------------------------

    def advertise(self, topic: str, kind: MessageType, queue: int = 100, latch: bool = False) -> Publisher:
        """Publish a topic by its full name. Those that publish the same topic share it.

        Raises:
            ParameterError: this node publishes the topic with another type.
        """
        with self._lock:
            publisher = self._publishers.get(topic)
            if publisher is None:
                publisher = self._publishers[topic] = Publisher(self, topic, kind, queue, latch)
                self._soon(self._register_publisher, publisher)
            _check_kind(topic, publisher.kind, kind)
            publisher.users += 1
        return publisher

    def withdraw(self, publisher: Publisher) -> None:
        """End what one `advertise` began."""
        with self._lock:
            publisher.users -= 1
            if publisher.users > 0:
                return
            self._remove(publisher)
        publisher.flush()
        for reader in publisher.readers:
            self._loop.call(reader.connection.flush)  # the last messages may wait for others
            self._loop.call(reader.connection.close)

    def flush(self) -> None:
        """Send what native code has published."""
        for publisher in self._all_publishers():
            publisher.flush()

    def subscribe(self, topic: str, kind: MessageType, received: Callable[[bytes], Any]) -> Subscriber:
        """Subscribe to a topic by its full name: `received` gets the bytes of each message, in the loop's thread.

        Raises:
            ParameterError: this node subscribes to the topic with another type.
        """
        with self._lock:
            subscriber = self._subscribers.get(topic)
            if subscriber is None:
                subscriber = self._subscribers[topic] = Subscriber(self, topic, kind)
                self._soon(self._register_subscriber, subscriber)
            _check_kind(topic, subscriber.kind, kind)
            subscriber.receivers = (*subscriber.receivers, received)
        return subscriber

    def unsubscribe(self, subscriber: Subscriber, received: Callable[[bytes], Any]) -> None:
        """End what `subscribe` began."""
        with self._lock:
            subscriber.receivers = tuple(one for one in subscriber.receivers if one != received)
            if subscriber.receivers:
                return
            self._remove(subscriber)
        for feed in list(subscriber.publishers.values()):
            if feed is not None:
                self._loop.call(feed.close)

    def serve(
        self, name: str, kind: ServiceType, handle: Callable[[bytes, Callable[[bool, bytes], None]], bool]
    ) -> ServiceServer:
        """Serve a service by its full name.

        Raises:
            ParameterError: this node serves it already.
        """
        service = ServiceServer(name, kind, handle)
        with self._lock:
            if name in self._services:
                raise ParameterError(f"service {name} is served already")
            self._services[name] = service
            self._soon(self._register_service, service)
        return service

    def stop_serving(self, service: ServiceServer) -> None:
        """End what `serve` began."""
        self._remove(service)

    def _remove(self, one: Publisher | Subscriber | ServiceServer) -> None:
        """Take one off its table. The master hears of it under the lock, so that nothing overtakes a registration."""
        table, key, _, _ = self._entry(one)
        with self._lock:
            if table.get(key) is one and not self._ended:  # at the end, all that is in the tables is unregistered
                del table[key]
                self._tasks.put(lambda: self._unregister(one))

    def _unregister(self, one: Publisher | Subscriber | ServiceServer) -> None:
        """Report to the master that something has ended; if it cannot be reached now, when it is there again."""
        _, key, method, _ = self._entry(one)
        if self.registered and len(self._ending) < MOST_ENDING:
            self._ending[method, key] = one
        if self._known:
            self._report_endings()

    def _report_endings(self) -> None:
        while self._ending:
            name = next(iter(self._ending))
            table, key, method, values = self._entry(self._ending[name])
            if key not in table:  # else it has begun again
                try:
                    self._ask(method, key, *values)
                except RefusalError as error:
                    self._complain(error)
            del self._ending[name]

    def _entry(self, one: Any) -> tuple[dict[str, Any], str, str, tuple[str, ...]]:
        """(table, key, method that unregisters it, its last argument)."""
        if isinstance(one, Publisher):
            return self._publishers, one.topic, "unregisterPublisher", (self.uri,)
        if isinstance(one, Subscriber):
            return self._subscribers, one.topic, "unregisterSubscriber", (self.uri,)
        return self._services, one.name, "unregisterService", (self._service_uri,)

    def take_spent(self) -> float:
        """Time of the processor that what has come took, since the last call [s]."""
        return self._loop.share.take_spent() + self._slave.share.take_spent()

    def follow_pace(self, hurried: Callable[[], bool]) -> None:
        """Let messages wait some milliseconds for others while the world runs faster than real time."""
        self._loop.hurried = hurried

    def note_change(self, publisher: Publisher) -> None:
        """The subscribers of a topic have come or gone."""
        self.changed[publisher] = None
        self.notify()

    def publication(self, topic: str) -> Publisher | None:
        """The publication of a topic."""
        return self._publishers.get(topic)

    def service(self, name: str) -> ServiceServer | None:
        """The service of a name."""
        return self._services.get(name)

    def _all_publishers(self) -> list[Publisher]:
        with self._lock:
            return list(self._publishers.values())

    def _all_subscribers(self) -> list[Subscriber]:
        with self._lock:
            return list(self._subscribers.values())

    def _all_services(self) -> list[ServiceServer]:
        with self._lock:
            return list(self._services.values())

    def _accept(self, sock: socket.socket, peer: str) -> Caller:
        return Caller(self._loop, sock, peer, self)

    # Parameters --------------------------------------------------------------------------------------------------

    def parameter(self, name: str) -> Any:
        """A parameter by its full name; None if it is not set, or there is no master."""
        if not self.first_look.wait(CONNECT_PATIENCE) or not self._known:
            return None
        try:
            code, _, value = call(self.master, "getParam", self.name, name, patience=PARAMETER_PATIENCE)
        except (XmlRpcError, ValueError, TypeError) as error:
            self._complain(error)
            return None
        return value if code == 1 else None

    def set_parameter(self, name: str, value: Any) -> None:
        """Set a parameter by its full name, soon, and again with each master that comes."""
        self._parameters[name] = value
        self._soon(self._send_parameter, name)

    def _send_parameter(self, name: str) -> None:
        self._ask("setParam", name, self._parameters[name])

    def search_parameter(self, name: str, space: str) -> Any:
        """A parameter in a namespace, or in the nearest one around it that has it; None if none has."""
        parts = [part for part in space.split("/") if part]
        for count in range(len(parts), -1, -1):
            value = self.parameter("/" + "/".join([*parts[:count], name]))
            if value is not None:
                return value
            if not self._known:
                return None
        return None

    # Master ------------------------------------------------------------------------------------------------------

    def _ask(self, method: str, *values: Any, patience: float = CONNECT_PATIENCE) -> Any:
        """Call a method of the master; the value of its answer.

        Raises:
            RefusalError: it refuses.
            XmlRpcError: there is no master.
        """
        answer = call(self.master, method, self.name, *values, patience=patience, most=MOST_REQUEST)
        try:
            code, text, value = answer
        except (TypeError, ValueError):
            raise XmlRpcError(f"{method} of {self.master}: {shown(answer)} is no answer of a master") from None
        if code != 1:
            raise RefusalError(f"{method} of {self.master}: {shown(text)}")
        return value

    def _soon(self, function: Callable[[Any], object], one: Any) -> None:
        """Have a call made by the thread of the registrar, if the master knows this node; else it registers all."""
        self._tasks.put(lambda: function(one) if self._known else None)

    def _run(self) -> None:
        """The registrar: makes the calls, and looks for the master."""
        due = 0.0
        while True:
            try:
                task = self._tasks.get(timeout=max(0.0, due - time.monotonic()))
            except queue.Empty:
                begin = time.thread_time()
                self._look()
                self.first_look.set()
                spent = time.thread_time() - begin  # on what a master says, so much passes otherwise
                due = time.monotonic() + max(CHECK_PERIOD, spent)
                continue
            if task is None:
                return
            try:
                task()
            except XmlRpcError as error:
                self._complain(error)
                self._known = self._known and isinstance(error, RefusalError)  # else all is registered again
            except Exception:
                log.exception("ROS: a call of the master failed")

    def _complain(self, error: Exception) -> None:
        """Log that a call of the master failed."""
        self._loop.warn(str(error), "ROS: %s", error)

    def _look(self) -> None:
        """Find out whether the master is there and knows this node; if not, register all."""
        try:
            code, _, uri = call(self.master, "lookupNode", self.name, self.name, most=MOST_REQUEST)
            if code == 1 and uri == self.uri and self._known:
                return
            if code == 1 and uri != self.uri and self._known:
                return  # another node took the name; the master asks this one to shut down
            self._register_all()
            self._known, self._complained = True, False
        except (XmlRpcError, TypeError, ValueError) as error:
            if self._known:
                self._loop.warn("gone", "ROS: the master at %s is gone; connected topics remain", self.master)
            elif not self._complained:
                log.warning("ROS: no master at %s; it is waited for (%s)", self.master, error)
            self._known, self._complained = False, True

    def _register_all(self) -> None:
        if not self._ask("hasParam", "/use_sim_time"):
            self._ask("setParam", "/use_sim_time", True)
        for name in list(self._parameters):
            self._send_parameter(name)
        for publisher in self._all_publishers():
            self._register_publisher(publisher)
        for subscriber in self._all_subscribers():
            self._register_subscriber(subscriber)
        for service in self._all_services():
            self._register_service(service)
        self._report_endings()
        self.registered += 1
        if self._loop.tally.due("registered"):  # a master may forget each time whom it knows
            times = self._loop.tally.times("registered")
            log.info("ROS: registered as %s with the master at %s%s", self.name, self.master, times)

    def _register_publisher(self, publisher: Publisher) -> None:
        if self._publishers.get(publisher.topic) is publisher:
            self._ask("registerPublisher", publisher.topic, publisher.kind.name, self.uri)

    def _register_subscriber(self, subscriber: Subscriber) -> None:
        if self._subscribers.get(subscriber.topic) is subscriber:
            uris = self._ask("registerSubscriber", subscriber.topic, subscriber.kind.name, self.uri)
            self._follow_all(subscriber, _addresses(uris))  # none is left: an update may have overtaken this answer

    def _register_service(self, service: ServiceServer) -> None:
        if self._services.get(service.name) is service:
            self._ask("registerService", service.name, self._service_uri, self.uri)

    def _unregister_all(self, end: float) -> None:
        """Take all off the master's lists, so that nobody waits for this node; until a time [s]."""
        for one in (*self._all_services(), *self._all_subscribers(), *self._all_publishers()):
            _, key, method, values = self._entry(one)
            try:
                self._ask(method, key, *values, patience=max(0.1, end - time.monotonic()))
            except XmlRpcError as error:
                log.info("ROS: %s", error)
                return

    # Calls of others ---------------------------------------------------------------------------------------------

    def _shut_down(self, _caller: str, reason: str = "") -> tuple[int, str, int]:
        log.warning(
            "ROS: the master asks this node to shut down: %s. The world runs without ROS from now on", shown(reason)
        )
        threading.Thread(target=self.close, name="ros-shutdown", daemon=True).start()
        return 1, "", 0

    def _request_topic(self, _caller: str, topic: str, protocols: Any) -> tuple[int, str, Any]:
        if topic not in self._publishers:
            return 0, f"{self.name} does not publish {topic!r}", 0
        if any(isinstance(one, list) and one and one[0] == "TCPROS" for one in protocols):
            return 1, f"ready on {self.names.host}", ["TCPROS", self.names.host, self._listener.port]
        return 0, "only TCPROS is spoken here", 0

    def _bus_info(self, _caller: str) -> tuple[int, str, Any]:
        rows: list[list[Any]] = []
        for publisher in self._all_publishers():
            for reader in publisher.readers:
                rows.append([len(rows) + 1, reader.connection.peer, "o", "TCPROS", publisher.topic, True])
        for subscriber in self._all_subscribers():
            for uri, feed in list(subscriber.publishers.items()):
                rows.append([len(rows) + 1, uri, "i", "TCPROS", subscriber.topic, feed is not None])
        return 1, "", rows

    def _publisher_update(self, _caller: str, topic: str, uris: Any) -> tuple[int, str, int]:
        subscriber = self._subscribers.get(topic)
        if subscriber is None:
            return 0, f"{self.name} does not subscribe to {topic!r}", 0
        wanted = _addresses(uris)
        for uri, feed in list(subscriber.publishers.items()):
            if uri not in wanted and feed is not None:
                self._loop.call(feed.close)
        self._follow_all(subscriber, wanted)
        return 1, "", 0

    def _follow_all(self, subscriber: Subscriber, uris: list[str]) -> None:
        """Connect to those publishers that are not connected yet."""
        new = [uri for uri in dict.fromkeys(uris) if uri not in subscriber.publishers]
        for number, uri in enumerate(new):  # of many where nobody is, each would take a thread
            full = max(number, len(subscriber.publishers)) >= MOST_PUBLISHERS
            if full or not self._connecting.acquire(blocking=False):
                text = "ROS: %s has more than %d publishers; those beyond are left out"
                self._loop.warn("publishers", text, subscriber.topic, MOST_PUBLISHERS)
                break
            subscriber.publishers[uri] = None
            threading.Thread(target=self._follow, args=(subscriber, uri), name="ros-connect", daemon=True).start()

    def _follow(self, subscriber: Subscriber, uri: str) -> None:
        """Connect to a publisher."""
        try:
            words = subscriber.topic, [["TCPROS"]]
            answer = call(uri, "requestTopic", self.name, *words, patience=CONNECT_PATIENCE, most=MOST_PLACE)
            code, text, (_, host, port) = answer
            if code != 1:
                raise XmlRpcError(f"requestTopic of {shown(uri)}: {shown(text)}")
            sock = socket.create_connection((str(host), int(port)), CONNECT_PATIENCE)
        except (XmlRpcError, OSError, TypeError, ValueError, OverflowError) as error:
            text = "ROS: %s cannot be read from %s: %s"
            self._loop.warn(("unread", subscriber.topic, uri), text, subscriber.topic, uri, shown(str(error)))
            subscriber.publishers.pop(uri, None)
            return
        finally:
            self._slave.share.spend(time.thread_time())
            self._connecting.release()
        header = {
            "callerid": self.name,
            "md5sum": subscriber.kind.md5,
            "tcp_nodelay": "1",
            "topic": subscriber.topic,
            "type": subscriber.kind.name,
        }
        peer = f"{urlsplit(uri).netloc}"
        feed = Feed(self._loop, sock, peer, header, subscriber.received, lambda: subscriber.publishers.pop(uri, None))
        subscriber.publishers[uri] = feed
        self._loop.call(feed.start)


def _addresses(uris: Any) -> list[str]:
    """The addresses of publishers that a master gives; those that are none are left out.

    Raises:
        XmlRpcError: it gives no list.
    """
    if not isinstance(uris, list):
        raise XmlRpcError(f"a list of publishers is {shown(uris)}")
    return [uri for uri in uris if isinstance(uri, str) and len(uri) <= LONGEST_URI]


def _listed(found: Sequence[Publisher] | Sequence[Subscriber]) -> list[list[str]]:
    return [[one.topic, one.kind.name] for one in found]


def _check_kind(topic: str, present: MessageType, wanted: MessageType) -> None:
    if present is not wanted:
        raise ParameterError(f"topic {topic} has type {present.name} already; it cannot be {wanted.name}, too")


def _typed(text: str) -> Any:
    """A private parameter of the command line as the value that it looks like."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
