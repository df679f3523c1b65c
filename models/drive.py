"""DifferentialRobot: what all robots have in common that steer by driving their sides at different speeds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from libgz.geometry import NORMALIZE, GzColor, GzQuaternFromAxis, GzVector
from libgz.interfaces.position import Position
from libgz.interfaces.power import Power
from libgz.models.sonars import SonarRing
from libgz.ode.types import dParamFMax, dParamVel
from libgz.physics.body import Body
from libgz.physics.geoms import WheelGeom
from libgz.physics.joint import HingeJoint
from libgz.simulation.model import Model
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import number, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["DifferentialRobot", "RobotAttributes"]

LARGEST_COMMAND = 100.0  # [m/s] or [rad/s]; no robot here is a tenth as fast


@dataclass(frozen=True)
class RobotAttributes:
    """What a Pioneer's element may hold."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="updates of the interfaces per second of sim time")
    batteryLevel: float = number(12.4, unit="V", least=0.0, help="charge at the start")
    batteryCurve: tuple[float, ...] = numbers(
        2.0 / 3600.0,
        2.0 / 1e4,
        unit="V/s, V/m^2",
        least=0.0,
        help="charge lost with time, and with squared wheel travel",
    )


class DifferentialRobot(Model):
    """A robot with a position, a power and (if it has sonars) a sonar interface.

    Each step it integrates its odometry and drains its battery; at its update rate it takes commands, sets its wheels'
    speeds and publishes. A command holds until the next one. Odometry starts at zero and knows nothing of teleports.
    """

    attributes = RobotAttributes

    wheelSep: ClassVar[float]  # between left and right wheels [m]
    wheelDiam: ClassVar[float]  # [m]
    maxTorque: ClassVar[float]  # of each wheel's motor [N m]
    normaliseYaw: ClassVar[bool]  # whether rot[2] is kept within +-pi

    def build(self) -> None:
        """Build bodies and joints: `add_wheel` for each driven wheel, and `sonars` if there are any."""
        raise NotImplementedError

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(RobotAttributes, node)
        self.left: list[HingeJoint] = []
        self.right: list[HingeJoint] = []
        self.sonars: SonarRing | None = None
        self.rate = UpdateRate(values.updateRate)
        self.batteryLevel = values.batteryLevel
        self.batteryCurve = values.batteryCurve
        self.odometry = [0.0, 0.0, 0.0]  # x [m], y [m], yaw [rad]
        self.velocity = (0.0, 0.0)  # [m/s], [rad/s], from the wheels
        self.command = (0.0, 0.0)  # wanted, [m/s] and [rad/s]
        self.enabled = True
        self._driven: tuple[float, float] | None = None  # what the motors were last set to
        self.build()

    def add_wheel(self, name: str, position: GzVector, tireRadius: float, mass: float, color: GzColor) -> None:
        """A driven wheel at `position` in the model's frame; the side is that of its y."""
        left = position.y > 0.0
        wheel = Body(self.world, name)
        self.AddBody(wheel)
        geom = WheelGeom(wheel, self.modelSpaceId, self.wheelDiam / 2.0, tireRadius)
        geom.SetMass(mass)
        geom.SetColor(color)
        wheel.SetPosition(position)
        wheel.SetRotation(GzQuaternFromAxis(1.0, 0.0, 0.0, -math.pi / 2.0 if left else math.pi / 2.0))
        hinge = HingeJoint(self.world, name=name)
        hinge.Attach(wheel, self.GetBody())
        hinge.SetAnchor(position)
        hinge.SetAxis((0.0, 1.0, 0.0))
        (self.left if left else self.right).append(hinge)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        owner = (self.GetId(), self.GetName(), self.GetIntId(), self.GetParentIntId())
        self.position, self.power = Position(), Power()
        self.guard = Guard(f"position.{self.GetId()}")
        self.position.create(self.world.gz_server, *owner)
        self.position.data.cmd_enable_motors = 1
        self.power.create(self.world.gz_server, *owner)
        self.power.data.levels[0] = self.batteryLevel
        if self.sonars is not None:
            self.sonars.Init()

    def Fini(self) -> None:  # noqa: D102
        self.position.destroy()
        self.power.destroy()
        if self.sonars is not None:
            self.sonars.Fini()

    def Update(self, step: float) -> None:  # noqa: D102
        if step == 0.0:
            return
        self._integrate(step)
        now = self.world.GetSimTime()
        if self.rate.due(now):
            self._exchange(now)
            self._drive()
            if self.sonars is not None:
                self.sonars.Update(now)

    def _integrate(self, step: float) -> None:
        """Odometry and battery from the wheels' rates."""
        scale = step * self.wheelDiam / 2.0
        left = scale * sum([joint.GetAngleRate() for joint in self.left]) / len(self.left)
        right = scale * sum([joint.GetAngleRate() for joint in self.right]) / len(self.right)
        travel, turn = (left + right) / 2.0, (right - left) / self.wheelSep
        odometry = self.odometry
        odometry[0] += travel * math.cos(odometry[2])
        odometry[1] += travel * math.sin(odometry[2])
        odometry[2] += turn
        if self.normaliseYaw:
            odometry[2] = NORMALIZE(odometry[2])
        self.velocity = (travel / step, turn / step)
        with_time, with_travel = self.batteryCurve
        drain = with_time * step + with_travel * (left * left + right * right)
        self.batteryLevel = max(0.0, self.batteryLevel - drain)

    def _exchange(self, now: float) -> None:
        """Publish position and power, and take the client's command if its numbers are sane."""
        if self.position.lock():
            data = self.position.data
            enabled, speed, turn = data.cmd_enable_motors, data.cmd_vel_pos[0], data.cmd_vel_rot[2]
            data.time = now
            pos, rot = data.pos, data.rot
            pos[0], pos[1], rot[2] = self.odometry
            data.vel_pos[0], data.vel_rot[2] = self.velocity
            data.stall = 0
            self.position.unlock()
            self.command = (
                self.guard.number("cmd_vel_pos[0]", speed, self.command[0], LARGEST_COMMAND),
                self.guard.number("cmd_vel_rot[2]", turn, self.command[1], LARGEST_COMMAND),
            )
            self.enabled = bool(enabled)
        if self.power.lock():
            self.power.data.time = now
            self.power.data.levels[0] = self.batteryLevel
            self.power.unlock()

    def _drive(self) -> None:
        """Set the wheels' motors, if the command changed."""
        speed, turn = self.command if self.enabled else (0.0, 0.0)
        if (speed, turn) == self._driven:
            return
        self._driven = (speed, turn)
        half = turn * self.wheelSep / 2.0
        for joints, rate in ((self.left, speed - half), (self.right, speed + half)):
            for joint in joints:
                joint.SetParam(dParamVel, 2.0 * rate / self.wheelDiam)
                joint.SetParam(dParamFMax, self.maxTorque)
