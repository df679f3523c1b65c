"""WorldTopics: the topics that a world publishes and subscribes to."""

from __future__ import annotations

import functools
import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from libgz.classic import msgs
from libgz.classic.commands import Commands, PausedSteps
from libgz.classic.describe import (
    contacts_of,
    diagnostics_message,
    joint_message,
    light_message,
    link_data_message,
    model_message,
    poses_message,
    skeleton_message,
    statistics_message,
    surroundings_message,
)
from libgz.classic.looks import gui_message, road_messages
from libgz.classic.msgs.convert import CreateRequest
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.world import World
from libgz.classic.transport import Node, Publisher, Subscriber, TopicManager
from libgz.classic.transport.elements import MOST_OF_COMMANDS
from libgz.classic.transport.publisher import drop_waiting, queue_message, waiting_messages
from libgz.classic.user_commands import Handlers, UserCommands
from libgz.simulation.world import World as CoreWorld

__all__ = ["WorldTopics"]

STATISTICS_PERIOD, POSES_PERIOD = 1.0 / 5.0, 1.0 / 60.0  # [s] of real time, Gazebo's


def _with_nested(model: Model) -> Iterator[Model]:
    """A model, and the models in it."""
    yield model
    for part in model.NestedModels():
        yield from _with_nested(part)


class _Periodic:
    """A topic that is published periodically while it has subscribers.

    Args:
        publisher: of the topic.
        period: of wall-clock time between messages [s].
        make: creates a message.
    """

    def __init__(self, publisher: Publisher, period: float, make: Callable[[], Any]) -> None:
        self._publisher, self._period, self._make = publisher, period, make
        self.topic = TopicManager.Instance().topic(publisher.GetTopic())
        self.due = 0.0  # [s]

    @property
    def listened(self) -> bool:
        """Whether somebody subscribes."""
        return bool(self.topic.subscribers) or self.topic.remote

    def publish(self, now: float) -> None:
        """Publish a message at a time [s]."""
        self.due = now + self._period
        self._publisher.Publish(self._make())


class _Skeletons:
    """The topic of actors' poses: a message for each new one, while there are subscribers.

    Args:
        node: that advertises the topic as soon as there is an actor.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publisher: Publisher | None = None
        self._framed: dict[Any, float] = {}  # actor -> sim time of the last pose that was published [s]

    def add(self, actor: Model) -> None:
        """Publish the poses of an actor."""
        if self._publisher is None:
            self._publisher = self._node.Advertise(msgs.PoseAnimation, "~/skeleton_pose/info", 10)
        self._framed[actor] = -math.inf

    def remove(self, entity: Model | Light) -> None:
        """Publish those of a removed actor no longer."""
        self._framed.pop(entity, None)

    @property
    def listened(self) -> bool:
        """Whether there are poses that somebody wants."""
        return bool(self._framed) and self._publisher is not None and self._publisher.HasConnections()

    def update(self) -> None:
        """Publish new poses."""
        if self.listened and self._publisher is not None:
            for actor, framed in self._framed.items():
                if actor.core.framed != framed:
                    self._framed[actor] = actor.core.framed
                    self._publisher.Publish(skeleton_message(actor))


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
        self._manager.locks.add(world.core.lock)
        self._node = Node()
        self._node.Init(world.core.topic_space)
        self._contacts = self._node.Advertise(msgs.Contacts, "~/physics/contacts")
        self._records = False  # whether contacts are recorded for that topic
        self._response = self._node.Advertise(msgs.Response, "~/response")
        self._models = self._node.Advertise(msgs.Model, "~/model/info")
        self._lights = self._node.Advertise(msgs.Light, "~/light")
        self._joints = self._node.Advertise(msgs.Joint, "~/joint")
        self._scene = self._node.Advertise(msgs.Scene, "~/scene")
        self._visuals = self._node.Advertise(msgs.Visual, "~/visual")
        self._requests = self._node.Advertise(msgs.Request, "~/request")
        self._user_commands = self._node.Advertise(msgs.UserCmdStats, "~/user_cmd_stats")
        self._light_factory = self._node.Advertise(msgs.Light, "~/factory/light")
        self._parts: dict[Model | Light, list[Subscriber]] = {}
        self._model_changes = self._node.Advertise(msgs.Model, "~/model/modify")
        self._light_changes = self._node.Advertise(msgs.Light, "~/light/modify")
        self._worlds = self._node.Advertise(msgs.WorldModify, "/gazebo/world/modify")
        self._skeletons = _Skeletons(self._node)
        self._links: dict[Model, list[tuple[Link, Publisher]]] = {}  # whose velocities are published
        self._published_links = world.core.engine.steps
        self._periodic = [
            _Periodic(publisher, period, functools.partial(make, world))
            for publisher, period, make in (
                (self._node.Advertise(msgs.WorldStatistics, "~/world_stats"), STATISTICS_PERIOD, statistics_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/info"), POSES_PERIOD, poses_message),
                (self._node.Advertise(msgs.PosesStamped, "~/pose/local/info"), POSES_PERIOD, poses_message),
                (self._contacts, 0.0, contacts_of),
                (self._node.Advertise(msgs.Diagnostics, "~/diagnostics"), 0.0, diagnostics_message),
            )
        ]
        self._commands = Commands(world, self._response.Publish, paused_steps, self._changed)
        self._subscribers = self._subscribe(self._commands)
        # For latching subscribers, of which each receives the last message of each publisher.
        self._scene.Publish(surroundings_message(world), here=False)
        self._described = [
            self._publish_once(topic, message)
            for topic, messages in (("~/gui", self._gui()), ("~/roads", self._roads()))
            for message in messages
        ]

    def _gui(self) -> Iterator[Any]:
        """What the world's file says of the client's window."""
        sdf = self._world.SDF()
        found = [gui_message(gui) for gui in sdf.named("gui")] if sdf is not None else []
        yield from found or [msgs.GUI(fullscreen=False)]

    def _roads(self) -> Iterator[Any]:
        sdf = self._world.SDF()
        yield from road_messages(sdf) if sdf is not None else ()

    def _publish_once(self, topic: str, message: Any) -> Publisher:
        publisher = self._node.Advertise(type(message), topic, 10)
        publisher.Publish(message, here=False)
        return publisher

    def _subscribe(self, commands: Commands) -> list[Subscriber]:
        user = UserCommands(
            self._world,
            Handlers(
                functools.partial(_also, self._model_changes, commands.model_modify),
                functools.partial(_also, self._light_changes, commands.light_modify),
                commands.world_control,
                commands.wrench,
            ),
            self._user_commands.Publish,
        )
        handlers = {
            "~/atmosphere": (commands.atmosphere, msgs.Atmosphere),
            "~/factory": (commands.factory, msgs.Factory),
            "~/factory/light": (commands.factory_light, msgs.Light),
            "~/light/modify": (commands.light_modify, msgs.Light),
            "~/model/modify": (commands.model_modify, msgs.Model),
            "~/physics": (commands.physics, msgs.Physics),
            "~/plugin/reload": (commands.plugin_reload, msgs.Request),
            "~/request": (commands.request, msgs.Request),
            "~/scene": (commands.scene, msgs.Scene),
            "~/undo_redo": (commands.between_steps("~/undo_redo", user.undo_redo), msgs.UndoRedo),
            "~/user_cmd": (commands.between_steps("~/user_cmd", user.carry_out), msgs.UserCmd),
            "~/visual": (commands.visual, msgs.Visual),
            "~/wind": (commands.wind, msgs.Wind),
            "~/world_control": (commands.world_control, msgs.WorldControl),
            "/gazebo/server/control": (commands.server_control, msgs.ServerControl),
        }
        return [self._obey(topic, handler, kind) for topic, (handler, kind) in handlers.items()]

    def _obey(self, topic: str, handler: Callable[[Any], None], kind: type[Any]) -> Subscriber:
        """Have the messages of a topic handled, if they are not too large for that."""
        subscriber = self._node.Subscribe(topic, self._commands.guarded(topic, handler), kind=kind)
        self._manager.topic(subscriber.GetTopic()).elements = MOST_OF_COMMANDS
        return subscriber

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

    def _changed(self, entity: Model | Light) -> None:
        """Publish an entity that a message has changed."""
        if isinstance(entity, Light):
            if self._lights.HasConnections():
                self._lights.Publish(light_message(entity))
        elif self._models.HasConnections():
            self._models.Publish(model_message(entity))

    def subscribe(self, model: Model) -> None:
        """Subscribe to the topics by which a model is commanded."""
        self._parts[model] = self._subscribe_parts(model)

    def added(self, entity: Model | Light, announce: bool = True) -> None:
        """Advertise the topics of an entity; publish it if it was inserted."""
        if isinstance(entity, Model):
            measured = [link for link in entity.GetLinks() if _has_imu(link)]
            if measured:
                self._links[entity] = [
                    (link, self._node.Advertise(msgs.LinkData, f"~/{link.GetScopedName()}")) for link in measured
                ]
            if entity.core.is_actor:
                self._skeletons.add(entity)
        if not announce:
            return
        self._changed(entity)
        if isinstance(entity, Light) and not self._commands.was_made(entity.GetName()):
            self._light_factory.Publish(light_message(entity), here=False)
        if isinstance(entity, Model) and self._joints.HasConnections():
            for joint in entity.GetJoints():
                self._joints.Publish(joint_message(joint))

    def _subscribe_parts(self, model: Model) -> list[Subscriber]:
        """Subscribe to ~/MODEL/joint_cmd of it and the models in it, and to ~/MODEL/LINK/wrench of links that move."""
        commands, handlers = self._commands, {}
        for part in _with_nested(model):
            if part.GetJoints():
                handlers[f"~/{part.GetScopedName()}/joint_cmd"] = commands.joint, msgs.JointCmd
        for link in model.GetLinks() if not model.IsStatic() else ():
            name = link.GetScopedName()
            handlers[f"~/{name}/wrench"] = functools.partial(commands.wrench, name), msgs.Wrench
        return [self._obey(topic.replace("::", "/"), handler, kind) for topic, (handler, kind) in handlers.items()]

    def removed(self, entity: Model | Light) -> None:
        """End the topics of an entity, and publish that it was deleted."""
        for subscriber in self._parts.pop(entity, ()):
            subscriber.Unsubscribe()
        if isinstance(entity, Model):
            for _, publisher in self._links.pop(entity, ()):
                publisher.Fini()
        self._skeletons.remove(entity)
        self._requests.Publish(CreateRequest("entity_delete", entity.GetScopedName()), here=False)

    @property
    def idle(self) -> bool:
        """Whether `update` has nothing to do now."""
        if self._manager.waits or self._records or self._world.Physics().GetContactManager().filtered:
            return False
        if any(one.listened and time.monotonic() >= one.due for one in self._periodic):
            return False
        for links in self._links.values():
            for _, publisher in links:
                if publisher.HasConnections():
                    return False
        return not self._skeletons.listened

    def update(self) -> None:
        """Publish due messages, then deliver all messages of this iteration."""
        now = time.monotonic()
        for one in self._periodic:
            if one.listened and now >= one.due:
                one.publish(now)
        self._skeletons.update()
        self._publish_links()
        manager = self._world.Physics().GetContactManager()
        if self._contacts.HasConnections() != self._records:
            self._records = not self._records
            if self._records:
                manager.hold(self)
            else:
                manager.release(self)
        manager.PublishContacts()
        self._manager.ProcessNodes()
        if self._manager.allowance.changes:  # those that messages asked for were deferred
            self._world.core.after_step(self._manager.allowance.spend)

    def _publish_links(self) -> None:
        """Publish the velocities of links with an IMU, in each iteration."""
        step = self._world.core.engine.steps
        if step == self._published_links:
            return
        self._published_links = step
        for links in self._links.values():
            for link, publisher in links:
                if publisher.HasConnections():
                    publisher.Publish(link_data_message(link))

    def close(self) -> None:
        """End the topics; the namespace stays if another world of this process has the same name."""
        name = self._world.core.topic_space
        self._node.Fini()
        self._manager.locks.discard(self._world.core.lock)
        self._subscribers.clear()
        self._parts.clear()
        others = [core for core in CoreWorld.all_running() if core.facade is not None and core is not self._world.core]
        if not any(core.topic_space == name for core in others):
            drop_waiting(self._prefix)  # another world of this name would get them
            self._manager.RemoveTopicNamespace(name)


def _has_imu(link: Link) -> bool:
    """Whether a link has an IMU; then Gazebo publishes its velocities, too."""
    sdf = link.GetSDF()
    return sdf is not None and any(sensor.Get(str, "type") == "imu" for sensor in sdf.named("sensor"))


def _also(publisher: Publisher, handler: Callable[[Any], None], message: Any) -> None:
    """Handle a change, and publish it to other processes, which hear of user commands so."""
    handler(message)
    publisher.Publish(message, here=False)
