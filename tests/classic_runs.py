"""Runs of SDF worlds with commands, recorded to the bit, for tests of states."""

from __future__ import annotations

import hashlib
import random
from pathlib import Path
from typing import Any

from libgz import World
from libgz.classic import msgs
from libgz.classic.server import attach
from libgz.classic.transport import Node, TopicManager

# Topics that depend on the wall clock, announce what a restore builds again, or have this module's own commands.
LEFT_OUT = (
    "world_stats", "diagnostics", "pose/info", "pose/local/info", "response", "request", "sim_events", "model/info",
    "/joint", "/light", "/sensor", "vel_cmd",
)  # fmt: skip


class Run:
    """Steps a world with commands that depend on the number of the step only, and records what happens.

    Args:
        world: a world that runs.
        seed: of the commands.
    """

    def __init__(self, world: World, seed: int = 1) -> None:
        self.world, self.seed = world, seed
        self.view = attach(world).world
        self.messages: list[bytes] = []
        self._node = Node()
        self._node.Init(world.topic_space)
        self._subscribers: list[Any] = []
        self._publishers: dict[str, Any] = {}

    def watch(self) -> None:
        """Activate all sensors, and subscribe to their topics and those of plugins."""
        self.activate()
        self.listen()

    def listen(self) -> None:
        """Subscribe to the topics of sensors and plugins that there are now."""
        self._subscribers.clear()
        prefix = f"/gazebo/{self.world.topic_space}/"
        for topic in list(TopicManager.Instance().AdvertisedTopics()):
            if topic.startswith(prefix) and not topic.endswith(LEFT_OUT):
                self._subscribers.append(self._node.Subscribe(topic, self._keep))

    def activate(self) -> None:
        """Activate all sensors."""
        sensors = self.view.server.sensors
        for sensor in sensors.sensors.values() if sensors is not None else ():
            sensor.SetActive(True)

    def _keep(self, message: Any) -> None:
        self.messages.append(message.SerializeToString())

    def command(self, number: int) -> None:
        """Apply the commands of a step: forces, joint targets, messages."""
        rng = random.Random(self.seed * 100_003 + number)
        models = [model for model in self.view.all_models() if not model.IsStatic()]
        if not models:
            return
        model = models[rng.randrange(len(models))]
        joints, links = model.GetJoints(), model.GetLinks()
        if number % 7 == 0 and links:
            links[0].AddForce((rng.uniform(-2, 2), rng.uniform(-2, 2), 0.0))
        if number % 11 == 0 and joints and joints[0].DOF():
            joints[0].SetForce(0, rng.uniform(-0.2, 0.2))
        if number % 50 == 1 and joints and joints[0].DOF():
            model.GetJointController().SetPositionTarget(joints[0].GetScopedName(), rng.uniform(-0.5, 0.5))
        if number % 40 == 3:
            topic = f"~/{model.GetName()}/vel_cmd"
            if topic not in self._publishers:
                self._publishers[topic] = self._node.Advertise(msgs.Pose, topic)
            message = msgs.Pose()
            message.position.x, message.orientation.w = rng.uniform(-0.3, 0.3), 1.0
            self._publishers[topic].Publish(message)

    def steps(self, count: int, *, every: int = 1) -> list[bytes]:
        """Run steps with commands; what the world was like after each of them, as digests."""
        self.messages.clear()
        record = []
        for _ in range(count):
            number = self.world.iterations
            self.command(number)
            self.world.Step()
            if not number % every:
                record.append(self.digest())
        return record

    def digest(self) -> bytes:
        """All that can be seen of the world now: engine, joints, sensors, images, messages since the run began."""
        return hashlib.blake2b(b"".join(self.parts()), digest_size=16).digest()

    def parts(self) -> list[bytes]:
        """The same in parts."""
        world, view = self.world, self.view
        parts = [repr(world.GetSimTime()).encode(), world.engine.states[list(world.engine.bodies)].tobytes()]
        for model in view.all_models():
            parts.append(repr(model.WorldPose()).encode())
            for joint in model.GetJoints():
                values = [(joint.Position(i), joint.GetVelocity(i), joint.GetForce(i)) for i in range(joint.DOF())]
                parts.append(repr(values).encode())
            for link in model.GetLinks():
                parts.append(repr([battery.Voltage() for battery in link.batteries]).encode())
        sensors = view.server.sensors
        for sensor in sensors.sensors.values() if sensors is not None else ():
            parts.append(repr((sensor.LastMeasurementTime().Double(), sensor.IsActive())).encode())
            if sensor.message_type is not None:
                parts.append(sensor.message().SerializeToString())
        return [*parts, *self.messages]


def first_difference(one: list[bytes], other: list[bytes]) -> int | None:
    """The number of the first step that differs; None if none does."""
    assert len(one) == len(other)
    return next((i for i, (a, b) in enumerate(zip(one, other, strict=True)) if a != b), None)


def opened(path: str | Path, **options: Any) -> Run:
    """A run of a world of a file."""
    return Run(World.from_file(path, **options))
