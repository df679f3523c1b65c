"""Where a program's publications and subscriptions begin."""

from __future__ import annotations

import importlib
import itertools
import sys
import time as clock
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.classic.msgs.declare import message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.publisher import Publisher
from libgz.classic.transport.subscriber import Subscriber
from libgz.classic.transport.topic import decode, encode, log
from libgz.errors import ClosedError, ParameterError
from libgz.ode.types import ContactRule
from libgz.simulation.event import owner

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Node"]

_ids = itertools.count()
NAMESPACE_TRIES = 10  # seconds that a client waits for the server to name a world


class Node:
    """Makes publishers and subscribers; in their topics' names `~` means `/gazebo/<world>`."""

    def __init__(self) -> None:
        self._id = next(_ids)
        self._namespace: str | None = None
        self._ends: weakref.WeakSet[Publisher | Subscriber] = weakref.WeakSet()

    def Init(self, space: str = "") -> None:
        """Choose the world that `~` means.

        Args:
            space: The world's name; empty for that of the plugin that is running, elsewhere for the first one there is,
                or `default` if there is none in this process and no server is connected.
        """
        _open_topics()
        self._namespace = space.strip("/") or _own_namespace() or first_namespace()

    def IsInitialized(self) -> bool:
        """Whether Init was called."""
        return self._namespace is not None

    def Fini(self) -> None:
        """End all publications and subscriptions that this node made."""
        for end in list(self._ends):
            end.Fini()
        self._namespace = None

    def GetTopicNamespace(self) -> str:
        """The name of the world that `~` means.

        Raises:
            ClosedError: before Init, or after Fini.
        """
        if self._namespace is None:
            raise ClosedError("a transport Node was used before Init, or after Fini")
        return self._namespace

    TopicNamespace = GetTopicNamespace

    def GetId(self) -> int:
        """The number of this node in its process."""
        return self._id

    def DecodeTopicName(self, topic: str) -> str:
        """The full name of a topic: `~/a` becomes `/gazebo/<world>/a`."""
        return decode(topic, self.GetTopicNamespace())

    def EncodeTopicName(self, topic: str) -> str:
        """The short name of a topic: `/gazebo/<world>/a` becomes `~/a`."""
        return encode(topic, self.GetTopicNamespace())

    def Advertise(
        self, kind: type[Message] | str, topic: str, queueLimit: int = 1000, hzRate: float = 0.0
    ) -> Publisher:
        """A publisher, ``node.Advertise(msgs.Vector3d, "~/my_topic")``; it ends when it is dropped.

        Args:
            kind: The messages' type, or its name.
            topic: Such as ``~/my_topic``.
            queueLimit: Messages that may wait for delivery; then the oldest are dropped.
            hzRate: Messages per second of wall time; what is more is dropped. 0 for no limit.

        Raises:
            ParameterError: the topic is published with another type; an argument is not allowed.
            NotFoundError: there is no type of this name.
            ClosedError: before Init.
        """
        kind = message_type(kind) if isinstance(kind, str) else kind
        if not (isinstance(kind, type) and issubclass(kind, Message) and kind.GetTypeName()):
            raise ParameterError(f"Advertise takes a message type such as msgs.Vector3d first, not {kind!r}")
        manager, name = TopicManager.Instance(), self.DecodeTopicName(topic)
        manager.check_type(name, kind.GetTypeName())
        publisher = Publisher(manager.topic(name), kind, queueLimit, hzRate)
        self._ends.add(publisher)
        return publisher

    def Subscribe(self, topic: str, callback: Callable[[Any], Any], latching: bool = False) -> Subscriber:
        """A subscriber, which must be kept: the callback is called as long as it lives.

        Args:
            topic: Such as ``~/my_topic``.
            callback: Takes the message. All subscribers of the process get the same one: it is to be read only.
            latching: Whether to get the last message of each publisher that there is, too.

        Raises:
            ParameterError: the callback cannot be called, or the topic has no name.
            ClosedError: before Init.
        """
        subscriber = Subscriber(TopicManager.Instance().topic(self.DecodeTopicName(topic)), callback, latching)
        self._ends.add(subscriber)
        return subscriber

    def GetMsgType(self, topic: str) -> str:
        """The full name of the type published on a topic, or an empty string."""
        return TopicManager.Instance().TopicMsgType(self.DecodeTopicName(topic))


def _worlds() -> list[World]:
    """The SDF worlds that run in this process; clients that only listen have none, and need no engine."""
    module = sys.modules.get("libgz.simulation.world")
    running = module.World.all_running() if module is not None else []
    return [world for world in running if world.engine.contact_rule is ContactRule.CLASSIC]


def _open_topics() -> None:
    """Let worlds speak that have had no reason to: those without plugins and sensors."""
    names = TopicManager.Instance().GetTopicNamespaces()
    for world in _worlds():
        if world.name not in names:
            importlib.import_module("libgz.classic.server").attach(world)  # by name: it stands on this


def _own_namespace() -> str:
    """The name of the world whose plugin is running; an empty string outside plugins."""
    by = owner.get()
    return next((world.name for world in _worlds() if by is not None and by.events is world.events), "")


def first_namespace() -> str:
    """The first world's name; a client waits some seconds for its server to have one."""
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
