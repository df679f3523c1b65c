"""Node: makes publishers and subscribers."""

from __future__ import annotations

import itertools
import time as clock
import weakref
from collections.abc import Callable
from typing import Any

from libgz.base.errors import ClosedError, ParameterError
from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.names import takes_names
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.publisher import Publisher
from libgz.classic.transport.subscriber import Subscriber
from libgz.classic.transport.topic import decode, encode, log
from libgz.simulation.event import owner
from libgz.simulation.running import RunningWorld, running_worlds

__all__ = ["Node"]

_ids = itertools.count()
NAMESPACE_TRIES = 10  # seconds that a client waits for the name of a world of its server


@takes_names
class Node:
    """Makes publishers and subscribers; in their topics' names `~` means `/gazebo/<world>`."""

    def __init__(self) -> None:
        self._id = next(_ids)
        self._namespace: str | None = None
        self._renamed = ""  # what absolute names begin with that a clone renames
        self._ends: weakref.WeakSet[Publisher | Subscriber] = weakref.WeakSet()

    def Init(self, space: str = "") -> None:
        """Set the world that `~` means.

        Args:
            space: The world's name. If empty: the world of the running plugin; outside plugins the first world; or
                `default` if this process has no world and no server is connected. For plugins of a clone, the name of
                their world means the clone; its own one is `World.topic_space`.
        """
        _open_topics()
        name, own = space.strip("/"), _own_world()
        self._renamed = ""
        if own is not None and name in ("", own.name):
            self._namespace = own.topic_space
            self._renamed = f"/gazebo/{own.name}/" if own.topic_space != own.name else ""
        else:
            self._namespace = name or first_namespace()

    def IsInitialized(self) -> bool:
        """Whether Init was called."""
        return self._namespace is not None

    def Fini(self) -> None:
        """End all publications and subscriptions of this node."""
        for end in list(self._ends):
            end.Fini()
        self._namespace = None

    def GetTopicNamespace(self) -> str:
        """Return the name of the world that `~` means.

        Raises:
            ClosedError: before Init, or after Fini.
        """
        if self._namespace is None:
            raise ClosedError("a transport Node was used before Init, or after Fini")
        return self._namespace

    TopicNamespace = GetTopicNamespace

    def GetId(self) -> int:
        """Return the number of this node in its process."""
        return self._id

    def DecodeTopicName(self, topic: str) -> str:
        """Return the full name of a topic: `/gazebo/<world>/a` for `~/a`."""
        name = decode(topic, self.GetTopicNamespace())
        if self._renamed and name.startswith(self._renamed):
            return f"/gazebo/{self._namespace}/{name.removeprefix(self._renamed)}"
        return name

    def EncodeTopicName(self, topic: str) -> str:
        """Return the short name of a topic: `~/a` for `/gazebo/<world>/a`."""
        return encode(topic, self.GetTopicNamespace())

    def Advertise(
        self, kind: type[Message] | str, topic: str, queueLimit: int = 1000, hzRate: float = 0.0
    ) -> Publisher:
        """Return a publisher, such as ``node.Advertise(msgs.Vector3d, "~/my_topic")``.

        It ends when it is dropped, and with the plugin that called this.

        Args:
            kind: The messages' type, or its name.
            topic: Such as ``~/my_topic``.
            queueLimit: Messages that may wait for delivery; above it, the oldest are dropped.
            hzRate: Messages per second of wall time; above it, messages are dropped. 0 for no limit.

        Raises:
            ParameterError: the topic is published with another type; or an argument is invalid.
            NotFoundError: there is no type with this name.
            ClosedError: before Init.
        """
        kind = _message_class(kind, "Advertise")
        manager, name = TopicManager.Instance(), self.DecodeTopicName(topic)
        manager.check_type(name, kind.GetTypeName())
        publisher = Publisher(manager.topic(name), kind, queueLimit, hzRate)
        self._ends.add(publisher)
        return publisher

    def Publish(self, topic: str, message: Message) -> None:
        """Publish one message on a topic, which is then advertised no longer.

        Raises:
            ParameterError: the topic is published with another type, or it is not a message.
            ClosedError: before Init.
        """
        self._once = self.Advertise(type(message), topic)
        self._once.Publish(message)

    def TryInit(self, maxWait: object = None) -> bool:
        """Init without a name; True: the world of this process, or of the server, is there."""
        self.Init()
        return True

    def Subscribe(
        self,
        topic: str,
        callback: Callable[[Any], Any],
        latching: bool = False,
        kind: type[Message] | str | None = None,
    ) -> Subscriber:
        """Return a subscriber, which must be kept: the subscription ends when it is dropped.

        Args:
            topic: Such as ``~/my_topic``.
            callback: Takes the message. All subscribers of the process get the same object: do not change it.
            latching: Whether to receive the last message of each existing publisher, too.
            kind: The messages' type, or its name, for those who publish by the topic's name alone, as `gz topic -p`
                does; messages of other types are received all the same.

        Raises:
            ParameterError: the callback cannot be called, the topic has no name, or `kind` is no type of messages.
            NotFoundError: there is no type with this name.
            ClosedError: before Init.
        """
        expected = "" if kind is None else _message_class(kind, "Subscribe").GetTypeName()
        manager = TopicManager.Instance()
        subscriber = Subscriber(manager.topic(self.DecodeTopicName(topic)), callback, latching, expected)
        self._ends.add(subscriber)
        return subscriber

    def GetMsgType(self, topic: str) -> str:
        """Return the full name of the type published on a topic, or an empty string."""
        return TopicManager.Instance().TopicMsgType(self.DecodeTopicName(topic))


def _message_class(kind: type[Message] | str, what: str) -> type[Message]:
    kind = message_type(kind) if isinstance(kind, str) else kind
    if not (isinstance(kind, type) and issubclass(kind, Message) and kind.GetTypeName()):
        raise ParameterError(f"{what} takes a message type such as msgs.Vector3d, not {kind!r}")
    return kind


def _open_topics() -> None:
    """Open the topics of this process's worlds; those without plugins and sensors have none before."""
    names = TopicManager.Instance().GetTopicNamespaces()
    for world in running_worlds():
        if world.topic_space not in names:
            world.attach_era()


def _own_world() -> RunningWorld | None:
    """Return the running plugin's world; None outside plugins."""
    plugin = owner.get()
    return next((world for world in running_worlds() if plugin is not None and plugin.events is world.events), None)


def first_namespace() -> str:
    """Return the name of the first world; a client waits some seconds for its server to have one."""
    manager = TopicManager.Instance()
    for second in range(1, NAMESPACE_TRIES + 1):
        end = clock.monotonic() + 1.0
        while not (names := manager.GetTopicNamespaces()):
            if manager.remote is None or not manager.remote.client:
                return "default"
            if clock.monotonic() > end:
                break
            clock.sleep(0.01)
        if names:
            return names[0]
        log.warning("Waited %dseconds for namespaces.", second)
    log.error("Waited %d seconds for namespaces. Giving up.", NAMESPACE_TRIES + 1)
    return "default"
