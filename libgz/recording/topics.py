"""TopicTap: receives the messages of all topics of a classic world."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from libgz.base.errors import NotFoundError
from libgz.classic.msgs.declare import declare, message_type
from libgz.classic.msgs.message import Message
from libgz.classic.transport import Node, Subscriber, TopicManager
from libgz.simulation.world import World

__all__ = ["TopicTap", "type_of_topic"]

# Recorded only while somebody else subscribes: contacts cost as much as the step that finds them.
ON_REQUEST = ("/physics/contacts",)
SEARCH_PERIOD = 50  # steps between two searches for new topics


def type_of_topic(name: str, declaration: str) -> type[Message]:
    """The type of a topic's messages; one that a program declared is declared again.

    Raises:
        ParameterError: the declaration is not understood.
    """
    try:
        return message_type(name)
    except NotFoundError:
        return declare(name, declaration.partition(": ")[2])


class TopicTap:
    """Subscribes to every topic of a world, and keeps what was published.

    Args:
        world: with views and topics attached.
    """

    def __init__(self, world: World) -> None:
        self._node = Node()
        self._node.Init(world.name)
        self._prefix = f"/gazebo/{world.name}/"
        self._manager = TopicManager.Instance()
        self._subscribers: dict[str, Subscriber] = {}
        self._messages: list[tuple[str, Message]] = []
        self._count, self._steps = -1, 0
        self._search()

    def _search(self) -> None:
        """Subscribe to topics that are new."""
        for name, topic in list(self._manager.topics.items()):
            if not name.startswith("/gazebo/") or name in self._subscribers:
                continue
            if name.endswith(ON_REQUEST) and not (topic.subscribers or topic.remote):
                continue
            self._subscribers[name] = self._node.Subscribe(name, self._receiver(name), latching=True)
        for name in [name for name in self._subscribers if name.endswith(ON_REQUEST)]:
            found = self._manager.topics.get(name)
            if found is None or (len(found.subscribers) <= 1 and not found.remote):
                self._subscribers.pop(name).Unsubscribe()
        self._count = len(self._manager.topics)

    def _receiver(self, name: str) -> Callable[[Any], None]:
        def receive(message: Message) -> None:
            self._messages.append((name, message))

        return receive

    def take(self) -> Iterator[tuple[str, str, str, bytes]]:
        """Topic, type, declaration and bytes of the messages since the last call."""
        self._steps += 1
        if len(self._manager.topics) != self._count or self._steps % SEARCH_PERIOD == 0:
            self._search()
        messages, self._messages = self._messages, []
        for name, message in messages:
            kind = type(message)
            yield name, kind.GetTypeName(), kind.__doc__ or "", message.SerializeToString()

    def close(self) -> None:
        """End the subscriptions. Can be called twice."""
        self._subscribers.clear()
        self._node.Fini()
