"""WorldTopics: the topics that a world publishes and subscribes to."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Sequence
from typing import Any

from libgz.classic import msgs
from libgz.classic.commands import Commands, PausedSteps
from libgz.classic.describe import contacts_of, model_message, poses_message, statistics_message
from libgz.classic.physics.model import Model
from libgz.classic.physics.world import World
from libgz.classic.transport import Node, Publisher, Subscriber, TopicManager
from libgz.classic.transport.publisher import drop_waiting, queue_message, waiting_messages
from libgz.simulation.world import World as CoreWorld

__all__ = ["WorldTopics"]

STATISTICS_PERIOD, POSES_PERIOD = 1.0 / 5.0, 1.0 / 60.0  # [s] of real time, Gazebo's


class _Periodic:
    """A topic that is published periodically while it has subscribers.

    Args:
        publisher: of the topic.
        period: of wall-clock time between messages [s].
        make: creates a message.
    """

    def __init__(self, publisher: Publisher, period: float, make: Callable[[], Any]) -> None:
        self._publisher, self._period, self._make = publisher, period, make
        self._due = 0.0

    def update(self, now: float) -> None:
        """Publish a message if it is due at a time [s]."""
        if now >= self._due and self._publisher.HasConnections():
            self._due = now + self._period
            self._publisher.Publish(self._make())


class WorldTopics:
    """The topics of one world.

    Args:
        world: the world.
        paused_steps: requested iterations of the paused world.
    """

    def __init__(self, world: World, paused_steps: PausedSteps) -> None:
        self._world = world
        self._manager = TopicManager.Instance()
        self._manager.AddTopicNamespace(world.core.topic_space)
        self._node = Node()
        self._node.Init(world.core.topic_space)
        self._contacts = self._node.Advertise(msgs.Contacts, "~/physics/contacts")
        self._records = False  # whether contacts are recorded for that topic
        self._response = self._node.Advertise(msgs.Response, "~/response")
        self._models = self._node.Advertise(msgs.Model, "~/model/info")
        self._periodic = [
            _Periodic(publisher, period, functools.partial(make, world))
            for publisher, period, make in (
                (self._node.Advertise(msgs.WorldStatistics, "~/world_stats"), STATISTICS_PERIOD, statistics_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/info"), POSES_PERIOD, poses_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/local/info"), POSES_PERIOD, poses_message),
                (self._contacts, 0.0, contacts_of),
            )
        ]
        self._subscribers = self._subscribe(Commands(world, self._response.Publish, paused_steps))

    def _subscribe(self, commands: Commands) -> list[Subscriber]:
        handlers = {
            "~/atmosphere": commands.atmosphere,
            "~/factory": commands.factory,
            "~/factory/light": commands.factory_light,
            "~/joint": commands.joint,
            "~/light/modify": commands.light_modify,
            "~/model/modify": commands.model_modify,
            "~/physics": commands.physics,
            "~/plugin/reload": commands.plugin_reload,
            "~/request": commands.request,
            "~/wind": commands.wind,
            "~/world_control": commands.world_control,
            "/gazebo/server/control": commands.server_control,
        }
        return [self._node.Subscribe(topic, commands.guarded(topic, handler)) for topic, handler in handlers.items()]

    def save(self) -> list[tuple[str, Any]]:
        """The messages of this process that wait for delivery, as plain data.

        Those of other processes are not the world's, nor is the last message that a publisher keeps for late
        subscribers.
        """
        return [(self._node.EncodeTopicName(name), message) for name, message in waiting_messages(self._prefix)]

    def load(self, state: Sequence[tuple[str, Any]], *, replace: bool) -> None:
        """Take what `save` returned.

        Args:
            state: what it returned.
            replace: whether the messages of this process that wait now are dropped.
        """
        self._world.Physics().GetContactManager().release(self)
        self._records = False  # until the next update finds subscribers
        if replace:
            drop_waiting(self._prefix)
        for name, message in state:
            queue_message(self._node.DecodeTopicName(name), message)

    @property
    def _prefix(self) -> str:
        """Of the names of this world's topics."""
        return f"/gazebo/{self._world.core.topic_space}/"

    def model_added(self, model: Model) -> None:
        """Publish a model that was inserted."""
        if self._models.HasConnections():
            self._models.Publish(model_message(model))

    def update(self) -> None:
        """Publish due messages, then deliver all messages of this iteration."""
        now = time.monotonic()
        for topic in self._periodic:
            topic.update(now)
        manager = self._world.Physics().GetContactManager()
        if self._contacts.HasConnections() != self._records:
            self._records = not self._records
            if self._records:
                manager.hold(self)
            else:
                manager.release(self)
        manager.PublishContacts()
        self._manager.ProcessNodes()

    def close(self) -> None:
        """End the topics; the namespace stays if another world of this process has the same name."""
        name = self._world.core.topic_space
        self._node.Fini()
        self._subscribers.clear()
        others = [core for core in CoreWorld.all_running() if core.facade is not None and core is not self._world.core]
        if not any(core.topic_space == name for core in others):
            self._manager.RemoveTopicNamespace(name)
