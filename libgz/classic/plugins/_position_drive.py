"""PositionDrive: base class of plugins that serve libgazebo's position interface for a model with driven wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.geometry import NORMALIZE
from libgz.base.law import cos, law, rarely, sin
from libgz.classic.common.time import sim_nanoseconds
from libgz.classic.event import Events
from libgz.classic.plugin import ModelPlugin
from libgz.classic.plugins._wheels import Wheel, separation
from libgz.interfaces.position import Position
from libgz.simulation.event import AtEnd
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard

if TYPE_CHECKING:
    from collections.abc import Sequence

    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

__all__ = ["PositionDrive", "positive"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s], as for legacy robots


def positive(sdf: Element, tag: str, default: float) -> float:
    """A number that an element gives.

    Raises:
        ParameterError: it is not positive.
    """
    value = sdf.Get(float, tag, default)[0]
    if not (math.isfinite(value) and value > 0.0):
        raise ParameterError(f"{sdf.where}: <{tag}> is {value:g}; it must be positive")
    return value


class PositionDrive(ModelPlugin):
    """Runs the wheels as the interface's clients command it, and serves odometry."""

    STATE: ClassVar[tuple[str, ...]] = ("odometry", "velocity", "command", "enabled", "rate")

    def serve(
        self,
        model: Model,
        left: Sequence[Joint],
        right: Sequence[Joint],
        *,
        torque: float,
        rate: float,
        name: str,
        diameter: float | None = None,
        distance: float | None = None,
    ) -> None:
        """Create the interface, and start.

        Args:
            model: of the joints.
            left, right: joints of wheels.
            torque: maximum torque of each wheel's motor [N m].
            rate: updates of the interface per second of sim time [Hz].
            name: of the interface.
            diameter: of the wheels [m]; by default that of the first one's shape.
            distance: between the sides [m]; by default as built.
        """
        first = Wheel(left[0], torque, diameter / 2.0 if diameter is not None else None)
        self.left = [first, *(Wheel(joint, torque, first.radius) for joint in left[1:])]
        self.right = [Wheel(joint, torque, first.radius) for joint in right]
        self.separation = separation(left[0], right[0]) if distance is None else distance
        self.rate = UpdateRate(rate)
        core = model.core
        self.position, self.guard = Position(), Guard(f"position.{name}")
        self.enabled = True
        self.position.create(core.world.gz_server, name, model.GetName(), core.GetIntId(), core.GetParentIntId())
        self.position.data.cmd_enable_motors = 1
        self.ending = AtEnd(self.position.destroy)
        self.clock, self.tables = core.world.clock, core.world.engine.tables.record
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Set odometry and command to zero."""
        self.odometry = np.zeros(3)  # x [m], y [m], yaw [rad]
        self.velocity = np.zeros(2)  # [m/s], [rad/s]
        self.rate.last = -math.inf
        self.order(0.0, 0.0)
        self.command = (0.0, 0.0)

    def order(self, speed: float, turn: float) -> None:
        """Command as a client of the interface does: speed forward [m/s], yaw rate, left positive [rad/s]."""
        with self.position.locked() as data:
            data.cmd_vel_pos[:] = (speed, 0.0, 0.0)
            data.cmd_vel_rot[:] = (0.0, 0.0, turn)

    @law
    def OnUpdate(self) -> None:
        """Update odometry; at the update rate publish it, and read the client's command."""
        self._measure(self.tables.step)
        now = sim_nanoseconds(self.clock) / 1e9
        if rarely(self.rate.is_due(now)):
            self.rate.due(now)
            self.exchange(now)
            self.run_wheels()

    def run_wheels(self) -> None:
        """Set the wheels' speeds to those of the command."""
        speed, turn = self.command
        half = turn * self.separation / 2.0
        for wheel in self.left:
            wheel.run(speed - half)
        for wheel in self.right:
            wheel.run(speed + half)

    @law
    def _measure(self, step: float) -> None:
        """Update odometry after a step [s]."""
        left, right = (sum(wheel.speed() for wheel in side) / len(side) for side in (self.left, self.right))
        speed, turn = (left + right) / 2.0, (right - left) / self.separation
        x, y, yaw = (self.odometry[i] for i in range(3))
        distance = step * speed
        self.velocity[:] = (speed, turn)
        self.odometry[:] = (x + distance * cos(yaw), y + distance * sin(yaw), NORMALIZE(yaw + step * turn))

    def exchange(self, now: float) -> None:
        """Publish odometry, and read the client's command."""
        if not self.position.lock():
            return
        data = self.position.data
        enabled, commands = data.cmd_enable_motors, (data.cmd_vel_pos[0], data.cmd_vel_rot[2])
        data.time, data.stall = now, 0
        data.pos[0], data.pos[1], data.rot[2] = self.odometry
        data.vel_pos[0], data.vel_rot[2] = self.velocity
        self.position.unlock()
        if not self.position.intact():
            return
        names = ("cmd_vel_pos[0]", "cmd_vel_rot[2]")
        speed, turn = (
            self.guard.number(name, value, old, LARGEST_COMMAND)
            for name, value, old in zip(names, commands, self.command, strict=True)
        )
        self.enabled = self.guard.switch("cmd_enable_motors", enabled, self.enabled)
        self.command = (speed, turn) if self.enabled else (0.0, 0.0)
