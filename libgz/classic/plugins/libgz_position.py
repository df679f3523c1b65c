"""libgz_position: a model of an SDF world, driven by legacy clients."""

from __future__ import annotations

import math
import weakref
from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint
from libgz.classic.plugins._wheels import Wheel, separation
from libgz.errors import ParameterError
from libgz.geometry import NORMALIZE
from libgz.interfaces.position import Position
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s], as for legacy robots


class PositionPlugin(ModelPlugin):
    """Serves the libgazebo interface `position` for a model with two driven wheels.

    Legacy clients drive it: `libgz.Client().position("robot1").command(vx=0.3)`, Player's driver, or a C program with
    libgazebo, if the world runs with a server id (`gzserver --server-id 0`). Speed forward, yaw rate left positive.
    Odometry is computed from the wheels, from zero at the start and after a reset. A command is valid until the next.

    Elements:
        leftJoint, rightJoint: names of the wheels' joints (also left_joint, right_joint).
        wheelSeparation: [m]; by default the distance between the joints.
        wheelDiameter: [m]; by default that of the left wheel's shape.
        torque: maximum torque of each wheel's motor [N m] (5).
        updateRate: updates of the interface per second of sim time [Hz] (10).
        id: of the interface; by default the model's name.
    """

    STATE = ("odometry", "velocity", "command", "enabled", "rate")

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the elements, and create the interface."""
        torque = self._positive(sdf, "torque", 5.0)
        left = named_joint(model, sdf, "leftJoint", "left_joint")
        right = named_joint(model, sdf, "rightJoint", "right_joint")
        diameter = self._positive(sdf, "wheelDiameter", 0.0) if sdf.HasElement("wheelDiameter") else None
        self.left = Wheel(left, torque, diameter / 2.0 if diameter is not None else None)
        self.right = Wheel(right, torque, self.left.radius)
        self.separation = self._positive(sdf, "wheelSeparation", separation(left, right))
        self.rate = UpdateRate(self._positive(sdf, "updateRate", 10.0))
        name = sdf.Get(str, "id").strip() or model.GetName()
        core = model.core
        self.position, self.guard = Position(), Guard(f"position.{name}")
        self.enabled = True
        self.position.create(core.world.gz_server, name, model.GetName(), core.GetIntId(), core.GetParentIntId())
        self.position.data.cmd_enable_motors = 1
        weakref.finalize(self, self.position.destroy)  # when the plugin is dropped
        self.step_size = model.GetWorld().Physics().GetMaxStepSize
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    @staticmethod
    def _positive(sdf: Element, tag: str, default: float) -> float:
        value = sdf.Get(float, tag, default)[0]
        if not (math.isfinite(value) and value > 0.0):
            raise ParameterError(f"{sdf.where}: <{tag}> is {value:g}; it must be positive")
        return value

    def Reset(self) -> None:
        """Set odometry and command to zero."""
        self.odometry = [0.0, 0.0, 0.0]  # x [m], y [m], yaw [rad]
        self.velocity = (0.0, 0.0)  # [m/s], [rad/s]
        self.command = (0.0, 0.0)
        self.rate.last = -math.inf
        with self.position.locked() as data:
            data.cmd_vel_pos[:] = data.cmd_vel_rot[:] = (0.0, 0.0, 0.0)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Update odometry; at the update rate publish it, and read the client's command."""
        self._measure(self.step_size())
        now = info.simTime.Double()
        if self.rate.due(now):
            self._exchange(now)
            speed, turn = self.command
            half = turn * self.separation / 2.0
            self.left.run(speed - half)
            self.right.run(speed + half)

    def _measure(self, step: float) -> None:
        """Update odometry after a step [s]."""
        left, right = self.left.speed(), self.right.speed()
        self.velocity = (left + right) / 2.0, (right - left) / self.separation
        distance, yaw = step * self.velocity[0], self.odometry[2]
        self.odometry[0] += distance * math.cos(yaw)
        self.odometry[1] += distance * math.sin(yaw)
        self.odometry[2] = NORMALIZE(yaw + step * self.velocity[1])

    def _exchange(self, now: float) -> None:
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


GZ_REGISTER_MODEL_PLUGIN(PositionPlugin)
