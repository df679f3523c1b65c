"""TopicManager: the topics of this process, and the delivery of their messages."""

from __future__ import annotations

import functools
import threading
import weakref
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar, Protocol

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.names import takes_names
from libgz.classic.transport.elements import check_elements
from libgz.classic.transport.received import Received
from libgz.classic.transport.topic import Incoming, LocalSubscriber, Topic
from libgz.physics.lock import WorldLock
from libgz.transport.allowance import Allowance

__all__ = ["PATIENCE", "DeliveryThread", "Remote", "TopicManager"]

PATIENCE = 0.02  # [s] of waiting for another thread that delivers
DELIVERY_PERIOD = 0.001  # [s] between deliveries of a DeliveryThread


class Remote(Protocol):
    """A connection to other processes."""

    client: bool  # whether there is a server to wait for
    watch_only: bool  # whether other processes may only receive

    def refresh(self, topic: Topic) -> None:
        """Announce the publishers and subscribers that this process now has."""

    def refresh_namespaces(self, names: list[str]) -> None:
        """Announce the names of this process's worlds."""

    def send(self, topic: Topic, publisher: int, number: int, message: Message) -> None:
        """Send a message to the subscribers of other processes."""

    def attached(self, topic: str) -> bool:
        """Whether another process publishes a topic, and all those that do have been asked for their messages."""

    def receivers(self, topic: str) -> int:
        """Return how many other processes are connected to this one's publishers of a topic."""

    def namespaces(self) -> list[str]:
        """Return the names of the other processes' worlds."""

    def advertised(self) -> dict[str, str]:
        """Return topic to type name of what the other processes publish."""

    def info(self, topic: str) -> Any:
        """Return a TopicInfo message on a topic in all processes."""

    def topics(self) -> list[str]:
        """Return the names of the topics that a process publishes or subscribes to."""


@takes_names
class TopicManager:
    """All topics of this process; `TopicManager.Instance()` is its only instance.

    Messages wait in the order in which they were published, from any thread, until `ProcessNodes` delivers them: the
    server calls it after each iteration, so that callbacks run between iterations, in a fixed order. Those that come
    from other processes follow, as far as a server has time for them.

    Attributes:
        allowance: what a server has for messages of other processes.
    """

    _instance: ClassVar[TopicManager | None] = None

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.queue: deque[Callable[[], None]] = deque()
        self.incoming: deque[Callable[[], None]] = deque()  # what other processes have sent
        self.allowance = Allowance()
        self.delivering = threading.RLock()  # held while callbacks run
        self.received = Received()
        self.locks: set[WorldLock] = set()  # of the worlds that are to deliver messages of other processes at once
        self.remote: Remote | None = None
        self.thread = DeliveryThread(self)
        self._watchers: list[Callable[[Topic], None]] = []
        self._namespaces: list[str] = []
        self._busy = False
        self._paused = False

    @classmethod
    def Instance(cls) -> TopicManager:
        """Return the manager of this process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    # Delivery ----------------------------------------------------------------------------------------------------

    @property
    def waits(self) -> bool:
        """Whether messages wait."""
        return bool(self.queue or self.incoming)

    def ProcessNodes(self) -> None:
        """Deliver the messages published up to now; those that callbacks publish wait for the next call.

        So do all while another thread delivers: one of its callbacks may wait for the world that this thread steps.
        """
        if not self.waits:
            return
        if not self.delivering.acquire(timeout=PATIENCE):
            return
        try:
            self._deliver()
        finally:
            self.delivering.release()

    def _deliver(self) -> None:
        if self._busy or self._paused:
            return
        self._busy = True
        try:
            for _ in range(len(self.queue)):
                try:
                    deliver = self.queue.popleft()
                except IndexError:
                    break
                deliver()
            self._deliver_incoming()
        finally:
            self._busy = False

    def _deliver_incoming(self) -> None:
        """Deliver messages of other processes: all to a client, to a server as long as they may take."""
        bounded = not self.trusting
        self.allowance.begin()
        for _ in range(len(self.incoming)):
            if bounded and not self.allowance.left:
                break
            try:
                deliver = self.incoming.popleft()
            except IndexError:
                break
            deliver()
            self.allowance.spend()

    @property
    def trusting(self) -> bool:
        """Whether this is a client, which trusts its server, whose world may be large."""
        return self.remote is not None and self.remote.client

    def PauseIncoming(self, pause: bool) -> None:
        """Stop delivering messages, or deliver them again."""
        self._paused = pause

    def ClearBuffers(self) -> None:
        """Drop all waiting messages."""
        self.queue.clear()
        self.incoming.clear()
        for topic in list(self.topics.values()):
            self.received.clear(topic)
            for publisher in topic.live_publishers():
                publisher.ClearBuffer()

    # Topics ------------------------------------------------------------------------------------------------------

    def topic(self, name: str) -> Topic:
        """Return the topic with a full name, a new one if there is none."""
        return self.topics.setdefault(name, Topic(name))

    def check_type(self, name: str, type_name: str) -> None:
        """Raise ParameterError if this or another process publishes a topic with another type."""
        known = self.TopicMsgType(name)
        if known not in ("", type_name):
            raise ParameterError(
                f"topic {name} is published with {known}; it cannot be advertised with {type_name} too"
            )

    def TopicMsgType(self, name: str) -> str:
        """Return the full name of the type published on a topic, or an empty string."""
        topic = self.topics.get(name)
        found = topic.type_name() if topic is not None else ""
        return found or (self.remote.advertised().get(name, "") if self.remote is not None else "")

    def AdvertisedTopics(self) -> dict[str, str]:
        """Return topic to full type name of all published topics, those of other processes included, sorted."""
        found = dict(self.remote.advertised()) if self.remote is not None else {}
        found.update({name: topic.type_name() for name, topic in list(self.topics.items()) if topic.live_publishers()})
        return dict(sorted(found.items()))

    def TopicNames(self) -> list[str]:
        """Return the names of all topics, sorted: those that are published, and those that somebody subscribes to.

        Raises:
            GazeboError: the master does not answer.
        """
        if self.remote is not None:
            return sorted(self.remote.topics())
        found = {name for name, one in list(self.topics.items()) if one.live_publishers() or one.live_subscribers()}
        return sorted(found)

    def TopicInfo(self, name: str) -> Any:
        """Return a TopicInfo message: type, publishers, subscribers, with the address at which a process listens.

        Without a link to other processes the port is 0.

        Raises:
            GazeboError: the master does not answer.
        """
        if self.remote is not None:
            return self.remote.info(name)
        topic = self.topics.get(name)
        known = self.TopicMsgType(name) or (topic.expected_type() if topic is not None else "")
        info: Any = message_type("TopicInfo")(msg_type=known)
        parts = {"topic": name, "msg_type": info.msg_type, "host": "127.0.0.1", "port": 0}
        for _ in topic.live_publishers() if topic is not None else ():
            info.publisher.add(**parts)
        for _ in topic.live_subscribers() if topic is not None else ():
            info.subscriber.add(**parts)
        return info

    def clear(self, prefix: str) -> None:
        """End all publications and subscriptions of topics with a prefix; an empty prefix means all."""
        for name, topic in list(self.topics.items()):
            if name.startswith(prefix):
                for publisher in topic.live_publishers():
                    publisher.Fini()
                for subscriber in topic.live_subscribers():
                    subscriber.Unsubscribe()
                self.received.clear(topic)
                self.topics.pop(name, None)

    def refresh(self, topic: Topic) -> None:
        """Announce a change of publishers or subscribers to other processes; forget a topic without any."""
        if topic.used:
            self.topics.setdefault(topic.name, topic)
        else:
            self._forget(topic)
        for watcher in self._watchers:
            watcher(topic)
        if self.remote is not None:
            self.remote.refresh(topic)

    def _forget(self, topic: Topic) -> None:
        if self.topics.get(topic.name) is topic:
            self.topics.pop(topic.name, None)

    def refresh_later(self, topic: Topic) -> None:
        """Announce a change with the next delivery: safe while objects are collected."""
        if self.remote is not None or self._watchers:
            self.queue.append(functools.partial(self.refresh, topic))
        elif not topic.used:
            self._forget(topic)

    def latch(self, topic: Topic, subscriber: LocalSubscriber) -> None:
        """Queue the last message of each publisher for a new subscriber."""
        to = weakref.ref(subscriber)
        for publisher in topic.live_publishers():
            if publisher.latest is not None:
                self.queue.append(functools.partial(_take, to, publisher.latest[1]))

    def receive(self, topic: Topic, message: Incoming, queue: deque[Callable[[], None]] | None = None) -> None:
        """Queue a message from another process, by default for `ProcessNodes`; any thread may call this."""
        if self.received.add(topic, message):
            (self.incoming if queue is None else queue).append(functools.partial(_receive, topic, self.received))
            for lock in list(self.locks):
                lock.interrupt()

    def watch(self, watcher: Callable[[Topic], None]) -> None:
        """Call a function with each topic that there is, and with each whose publishers or subscribers change."""
        self._watchers = [*self._watchers, watcher]
        for topic in list(self.topics.values()):
            watcher(topic)

    def unwatch(self, watcher: Callable[[Topic], None]) -> None:
        """Call a function no more."""
        self._watchers = [one for one in self._watchers if one != watcher]

    def link(self, remote: Remote) -> None:
        """Connect the topics to other processes."""
        self.remote = remote
        self._refresh_namespaces()
        for topic in list(self.topics.values()):
            remote.refresh(topic)

    def unlink(self, remote: Remote) -> None:
        """Disconnect the topics from other processes."""
        if self.remote is remote:
            self.remote = None
            for topic in list(self.topics.values()):
                topic.remote = False

    # Namespaces --------------------------------------------------------------------------------------------------

    def AddTopicNamespace(self, name: str) -> None:
        """Add the name of a world; `~` means the first one in a node that was not given a name."""
        if name not in self._namespaces:
            self._namespaces.append(name)
            self._refresh_namespaces()

    def RemoveTopicNamespace(self, name: str) -> None:
        """Remove the name of a closed world, and end its topics."""
        if name in self._namespaces:
            self._namespaces.remove(name)
            self._refresh_namespaces()
        self.clear(f"/gazebo/{name}/")

    def GetTopicNamespaces(self) -> list[str]:
        """Return the names of the worlds of this process, oldest first, then those of other processes."""
        others = self.remote.namespaces() if self.remote is not None else []
        return list(dict.fromkeys((*self._namespaces, *others)))

    def _refresh_namespaces(self) -> None:
        if self.remote is not None:
            self.remote.refresh_namespaces(list(self._namespaces))


class DeliveryThread:
    """Delivers messages periodically in a thread: for clients, which have no server loop that does it."""

    def __init__(self, manager: TopicManager) -> None:
        self._manager = manager
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def running(self) -> bool:
        """Whether the thread runs."""
        return self._thread is not None and self._thread.is_alive()

    def start(self) -> None:
        """Start the thread, unless it runs."""
        if not self.running:
            self._stopping.clear()
            self._thread = threading.Thread(target=self._deliver, name="transport", daemon=True)
            self._thread.start()

    def _deliver(self) -> None:
        while not self._stopping.wait(DELIVERY_PERIOD):
            self._manager.ProcessNodes()

    def stop(self) -> None:
        """Stop the thread; also allowed in a callback, where the thread ends after it."""
        self._stopping.set()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()


def _take(subscriber: weakref.ref[LocalSubscriber], message: Message) -> None:
    found = subscriber()
    if found is not None:
        found.take(message)


def _receive(topic: Topic, received: Received) -> None:
    """Decode and deliver the oldest message received from another process."""
    incoming = received.take(topic)
    if incoming is None:
        return
    known = topic.type_name()
    if known not in ("", incoming.type_name):
        received.refuse(topic.name, f"it is published here with {known}; a {incoming.type_name} was dropped")
        return
    try:
        kind = message_type(incoming.type_name)
        if not TopicManager.Instance().trusting:
            check_elements(kind.DESCRIPTOR, incoming.data, topic.elements)
        message = kind.FromString(incoming.data)
    except (NotFoundError, ParameterError) as error:
        received.refuse(topic.name, f"a received message was dropped: {error}")
        return
    if incoming.subscriber is None:
        topic.deliver(incoming.number, message, latching=False)
    elif (subscriber := incoming.subscriber()) is not None:
        subscriber.take(message)
