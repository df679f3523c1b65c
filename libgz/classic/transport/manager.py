"""The topics of this process, and the delivery of their messages."""

from __future__ import annotations

import functools
import threading
import weakref
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from libgz.classic.msgs.declare import message_type
from libgz.classic.transport.topic import INCOMING, End, Incoming, Topic, log
from libgz.errors import NotFoundError, ParameterError

if TYPE_CHECKING:
    from libgz.classic.msgs.message import Message
    from libgz.classic.transport.subscriber import Subscriber

__all__ = ["Remote", "TopicManager"]


class Remote(Protocol):
    """The way to other processes."""

    client: bool  # whether there is a server to wait for

    def refresh(self, topic: Topic) -> None:
        """Offer and ask for what this process now publishes and listens to."""

    def refresh_namespaces(self, names: list[str]) -> None:
        """Tell the names of this process's worlds."""

    def send(self, topic: Topic, publisher: int, number: int, message: Message) -> None:
        """Send a message to the processes that listen."""

    def latch(self, topic: Topic, subscriber: Subscriber) -> None:
        """Ask the other processes for their last messages."""

    def namespaces(self) -> list[str]:
        """The worlds of the other processes."""

    def advertised(self) -> dict[str, str]:
        """Topic to type name of what the other processes publish."""

    def ends(self, topic: str) -> list[End]:
        """Who publishes on a topic and who listens, in the other processes."""


class TopicManager:
    """All topics of this process, there once: `TopicManager.Instance()`.

    Messages wait in the order in which they were published, from whatever thread, until `ProcessNodes` delivers them:
    the server calls it after each iteration, and so callbacks run between iterations, in a fixed order.
    """

    _instance: ClassVar[TopicManager | None] = None

    def __init__(self) -> None:
        self.topics: dict[str, Topic] = {}
        self.queue: deque[Callable[[], None]] = deque()
        self.pump = threading.RLock()  # held while callbacks run
        self.remote: Remote | None = None
        self._namespaces: list[str] = []
        self._busy = False
        self._paused = False

    @classmethod
    def Instance(cls) -> TopicManager:
        """The one of this process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    # Delivery ----------------------------------------------------------------------------------------------------

    def ProcessNodes(self) -> None:
        """Deliver what was published up to now; what callbacks publish waits for the next call."""
        if not self.queue:
            return
        with self.pump:
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
            finally:
                self._busy = False

    def PauseIncoming(self, pause: bool) -> None:
        """Hold all messages back, or deliver them again."""
        self._paused = pause

    def ClearBuffers(self) -> None:
        """Forget all messages that wait."""
        self.queue.clear()
        for topic in list(self.topics.values()):
            topic.incoming.clear()
            for publisher in topic.live_publishers():
                publisher.ClearBuffer()

    # Topics ------------------------------------------------------------------------------------------------------

    def topic(self, name: str) -> Topic:
        """The topic of a full name."""
        return self.topics.setdefault(name, Topic(name))

    def check_type(self, name: str, type_name: str) -> None:
        """Raise ParameterError if a topic is published with another type, here or in another process."""
        known = self.TopicMsgType(name)
        if known not in ("", type_name):
            raise ParameterError(
                f"topic {name} is published with {known}; it cannot be advertised with {type_name} too"
            )

    def TopicMsgType(self, name: str) -> str:
        """The full name of the type published on a topic, or an empty string."""
        topic = self.topics.get(name)
        found = topic.type_name() if topic is not None else ""
        return found or (self.remote.advertised().get(name, "") if self.remote is not None else "")

    def AdvertisedTopics(self) -> dict[str, str]:
        """Topic to full type name of all that is published, here and in the other processes, sorted."""
        found = dict(self.remote.advertised()) if self.remote is not None else {}
        found.update({name: topic.type_name() for name, topic in list(self.topics.items()) if topic.live_publishers()})
        return dict(sorted(found.items()))

    def TopicInfo(self, name: str) -> Any:
        """A TopicInfo message: the type, and who publishes and listens; `host` is the machine, `port` the process."""
        topic = self.topics.get(name)
        ends = [
            *(topic.ends() if topic is not None else []),
            *(self.remote.ends(name) if self.remote is not None else []),
        ]
        info = message_type("TopicInfo")(msg_type=self.TopicMsgType(name))
        for end in sorted(ends):
            host, _, process = end.process.rpartition(":")
            parts = {"topic": name, "msg_type": end.type_name or info.msg_type, "host": host, "port": int(process)}
            (info.publisher if end.what == "pub" else info.subscriber).add(**parts)
        return info

    def clear(self, prefix: str) -> None:
        """End all publications and subscriptions of topics whose full names begin so; an empty prefix means all."""
        for name, topic in list(self.topics.items()):
            if name.startswith(prefix):
                for publisher in topic.live_publishers():
                    publisher.Fini()
                for subscriber in topic.live_subscribers():
                    subscriber.Fini()
                self.topics.pop(name, None)

    def refresh(self, topic: Topic) -> None:
        """Tell other processes that publishers or subscribers have come or gone."""
        if self.remote is not None:
            self.remote.refresh(topic)

    def refresh_later(self, topic: Topic) -> None:
        """The same with the next delivery: safe while objects are collected."""
        if self.remote is not None:
            self.queue.append(functools.partial(self.refresh, topic))

    def latch(self, topic: Topic, subscriber: Subscriber) -> None:
        """Give a new subscriber the last message of each publisher."""
        to = weakref.ref(subscriber)
        for publisher in topic.live_publishers():
            if publisher.latest is not None:
                self.queue.append(functools.partial(_take, to, publisher.latest[1]))
        if self.remote is not None:
            self.remote.latch(topic, subscriber)

    def receive(self, topic: Topic, message: Incoming) -> None:
        """Queue what came from another process; any thread may call this."""
        if len(topic.incoming) < INCOMING:  # else the oldest goes, and its place in the queue is taken
            self.queue.append(functools.partial(_receive, topic))
        topic.incoming.append(message)

    def link(self, remote: Remote) -> None:
        """Reach other processes from now on."""
        self.remote = remote
        self._tell_namespaces()
        for topic in list(self.topics.values()):
            remote.refresh(topic)
            for subscriber in topic.live_subscribers():
                if subscriber.latching:
                    remote.latch(topic, subscriber)

    def unlink(self, remote: Remote) -> None:
        """Stay within this process from now on."""
        if self.remote is remote:
            self.remote = None
            for topic in list(self.topics.values()):
                topic.remote = False

    # Namespaces --------------------------------------------------------------------------------------------------

    def AddTopicNamespace(self, name: str) -> None:
        """Enter a world; the first one's name is what `~` means where a node is not told."""
        if name not in self._namespaces:
            self._namespaces.append(name)
            self._tell_namespaces()

    def RemoveTopicNamespace(self, name: str) -> None:
        """A world was closed: its topics end."""
        if name in self._namespaces:
            self._namespaces.remove(name)
            self._tell_namespaces()
        self.clear(f"/gazebo/{name}/")

    def GetTopicNamespaces(self) -> list[str]:
        """The names of the worlds of this process, oldest first, and then of the others."""
        others = self.remote.namespaces() if self.remote is not None else []
        return list(dict.fromkeys((*self._namespaces, *others)))

    def _tell_namespaces(self) -> None:
        if self.remote is not None:
            self.remote.refresh_namespaces(list(self._namespaces))


def _take(subscriber: weakref.ref[Subscriber], message: Message) -> None:
    found = subscriber()
    if found is not None:
        found.take(message)


def _receive(topic: Topic) -> None:
    """Read the oldest message that came from another process, and deliver it."""
    try:
        incoming = topic.incoming.popleft()
    except IndexError:
        return
    known = topic.type_name()
    if known not in ("", incoming.type_name):
        log.error(
            "topic %s is published here with %s; a %s that came was dropped", topic.name, known, incoming.type_name
        )
        return
    try:
        message = message_type(incoming.type_name).FromString(incoming.data)
    except (NotFoundError, ParameterError) as error:
        log.error("topic %s: a message that came was dropped: %s", topic.name, error)
        return
    if incoming.subscriber is None:
        topic.heard[incoming.sender] = (incoming.sent, incoming.number)
        topic.deliver(incoming.number, message)
        return
    subscriber = incoming.subscriber()
    last, when = topic.heard.get(incoming.sender, (0, 0))
    if subscriber is not None and not (last >= incoming.sent and when > subscriber.since):
        subscriber.take(message)
