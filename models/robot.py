"""MobileRobot: what all robots have in common that a client drives through a position interface."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

from libgz.interfaces.position import Position, PositionData
from libgz.legacy.model import Model
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["Device", "MobileRobot", "RobotAttributes", "clamp"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s]; no robot here is a tenth as fast


@dataclass(frozen=True)
class RobotAttributes:
    """What the element of any robot may hold."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="updates of the interfaces per second of sim time")


class Device(Protocol):
    """A part of a robot with an interface of its own, such as a battery or a ring of sonars."""

    def Init(self) -> None:
        """Make the interface."""

    def Update(self, now: float) -> None:
        """Publish, at sim time `now` [s]."""

    def Fini(self) -> None:
        """Let the interface go."""


class MobileRobot(Model):
    """A robot with a position interface.

    Each step it measures its motion and acts on its motors; at its update rate it takes a command, passes it on and
    publishes. A command holds until the next one. Odometry starts at zero and knows nothing of teleports.
    """

    attributes: ClassVar[type[RobotAttributes]] = RobotAttributes
    interfaces: ClassVar[tuple[str, ...]] = ("position",)
    # The fields of the position interface that this robot obeys, in the order of `command`.
    commands: ClassVar[tuple[tuple[str, int], ...]] = (("cmd_vel_pos", 0), ("cmd_vel_rot", 2))

    def build(self) -> None:
        """Build bodies and joints."""
        raise NotImplementedError

    def measure(self, step: float) -> None:
        """Bring odometry and velocity up to date after a step [s]."""
        raise NotImplementedError

    def drive(self) -> None:
        """Pass `wanted` on to the motors; called at the update rate."""

    def act(self, step: float) -> None:
        """Control what has to be controlled each step [s]."""

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(self.attributes, node)
        self.rate = UpdateRate(self.values.updateRate)
        self.odometry = [0.0, 0.0, 0.0]  # x [m], y [m], yaw [rad]
        self.velocity = (0.0, 0.0)  # measured, [m/s] and [rad/s]
        self.command = (0.0,) * len(self.commands)  # as the client gave it, [m/s] and [rad/s]
        self.enabled = True
        self.devices: list[Device] = []
        self.build()

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.position = Position()
        self.guard = Guard(f"position.{self.GetId()}")
        self.position.create(self.world.gz_server, self.GetId(), self.GetName(), self.GetIntId(), self.GetParentIntId())
        self.position.data.cmd_enable_motors = 1
        for device in self.devices:
            device.Init()

    def Fini(self) -> None:  # noqa: D102
        self.position.destroy()
        for device in self.devices:
            device.Fini()

    def Update(self, step: float) -> None:  # noqa: D102
        if step == 0.0:
            return
        self.measure(step)
        now = self.world.GetSimTime()
        if self.rate.due(now):
            self._exchange(now)
            self.drive()
            for device in self.devices:
                device.Update(now)
        self.act(step)

    @property
    def wanted(self) -> tuple[float, ...]:
        """The command in force: zeros while the motors are switched off."""
        return self.command if self.enabled else (0.0,) * len(self.commands)

    def advance(self, travel: float, turn: float, step: float) -> None:
        """Add a way [m], in the direction so far, and then a turn [rad] to the odometry."""
        odometry = self.odometry
        odometry[0] += travel * math.cos(odometry[2])
        odometry[1] += travel * math.sin(odometry[2])
        odometry[2] += turn
        self.velocity = (travel / step, turn / step)

    def publish(self, data: PositionData) -> None:
        """Fill in what is known of pose and velocity."""
        pos, vel_pos = data.pos, data.vel_pos
        pos[0], pos[1], data.rot[2] = self.odometry
        vel_pos[0], data.vel_rot[2] = self.velocity

    def _exchange(self, now: float) -> None:
        """Publish the position, and take the client's command if its numbers are sane."""
        if not self.position.lock():
            return
        data = self.position.data
        enabled, wishes = data.cmd_enable_motors, tuple([getattr(data, name)[i] for name, i in self.commands])
        data.time = now
        data.stall = 0
        self.publish(data)
        self.position.unlock()
        self.enabled = bool(enabled)
        if wishes != self.command:  # which was checked
            self.command = tuple(
                self.guard.number(f"{name}[{i}]", wish, old, LARGEST_COMMAND)
                for (name, i), wish, old in zip(self.commands, wishes, self.command, strict=True)
            )


def clamp(value: float, limit: float) -> float:
    """`value` within +-limit."""
    return min(max(value, -limit), limit)
