"""WorldTopics: what a world says and hears on Gazebo's topics."""

from __future__ import annotations

import functools
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs
from libgz.classic.commands import Commands
from libgz.classic.describe import contacts_of, model_message, poses_message, statistics_message
from libgz.classic.physics.model import Model
from libgz.classic.physics.registry import live_worlds
from libgz.classic.transport import Node, Publisher, Subscriber, TopicManager

if TYPE_CHECKING:
    from libgz.classic.server import WorldServer

__all__ = ["WorldTopics"]

STATISTICS_PERIOD, POSES_PERIOD = 1.0 / 5.0, 1.0 / 60.0  # [s] of real time, Gazebo's


class _News:
    """Messages that are made when they are due and somebody listens."""

    def __init__(self, publisher: Publisher, period: float, make: Callable[[], Any]) -> None:
        self._publisher, self._period, self._make = publisher, period, make
        self._due = 0.0

    def update(self, now: float) -> None:
        """Publish, if it is time and somebody listens."""
        if now >= self._due and self._publisher.HasConnections():
            self._due = now + self._period
            self._publisher.Publish(self._make())


class WorldTopics:
    """The topics of one world: they are there before its plugins, and go with it."""

    def __init__(self, server: WorldServer) -> None:
        self._server, self._world = server, server.world
        self._manager = TopicManager.Instance()
        self._manager.AddTopicNamespace(self._world.Name())
        self._node = Node()
        self._node.Init(self._world.Name())
        world = self._world
        self._contacts = self._node.Advertise(msgs.Contacts, "~/physics/contacts")
        self._records = False  # whether contacts are recorded for that topic
        self._response = self._node.Advertise(msgs.Response, "~/response")
        self._models = self._node.Advertise(msgs.Model, "~/model/info")
        self._news = [
            _News(publisher, period, functools.partial(make, world))
            for publisher, period, make in (
                (self._node.Advertise(msgs.WorldStatistics, "~/world_stats"), STATISTICS_PERIOD, statistics_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/info"), POSES_PERIOD, poses_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/local/info"), POSES_PERIOD, poses_message),
                (self._contacts, 0.0, contacts_of),
            )
        ]
        self._subscribers = self._listen(Commands(server, self._response.Publish))

    def _listen(self, commands: Commands) -> list[Subscriber]:
        heard = {
            "~/factory": commands.factory,
            "~/factory/light": commands.factory_light,
            "~/joint": commands.joint,
            "~/light/modify": commands.light_modify,
            "~/model/modify": commands.model_modify,
            "~/physics": commands.physics,
            "~/request": commands.request,
            "~/world_control": commands.world_control,
            "/gazebo/server/control": commands.server_control,
        }
        return [self._node.Subscribe(topic, commands.guarded(topic, handler)) for topic, handler in heard.items()]

    def model_added(self, model: Model) -> None:
        """Tell of a model that joined a running world."""
        if self._models.HasConnections():
            self._models.Publish(model_message(model))

    def update(self) -> None:
        """Publish what is due, then deliver what was published in this iteration."""
        now = time.monotonic()
        for news in self._news:
            news.update(now)
        manager = self._world.Physics().GetContactManager()
        if self._contacts.HasConnections() != self._records:
            self._records = not self._records
            (manager.hold if self._records else manager.release)(self)
        manager.PublishContacts()
        self._manager.ProcessNodes()

    def close(self) -> None:
        """The world ends; so do its topics, unless another world of this process has the same name."""
        name = self._world.Name()
        self._node.Fini()
        self._subscribers.clear()
        if not any(world.Name() == name for world in live_worlds() if world is not self._world):
            self._manager.RemoveTopicNamespace(name)
