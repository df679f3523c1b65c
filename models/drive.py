"""Differential drives, and DifferentialRobot: robots that steer by driving their sides at different speeds."""

from __future__ import annotations

from typing import ClassVar

from libgz.base.geometry import NORMALIZE, VectorLike
from libgz.base.law import law
from libgz.interfaces.position import PositionData
from libgz.models.battery import Battery
from libgz.models.motors import Axis, mean
from libgz.models.odometry import Odometry
from libgz.models.robot import MobileRobot, RobotAttributes
from libgz.models.wheels import Tire, Wheel, add_tire, on_hinge
from libgz.physics.body import Body
from libgz.physics.joint import HingeJoint
from libgz.worldfile.attributes import declaration, number, numbers
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["BatteryAttributes", "DifferentialDrive", "DifferentialRobot"]


@declaration
class BatteryAttributes(RobotAttributes):
    """Attributes of a robot with a battery."""

    batteryLevel: float = number(12.4, unit="V", least=0.0, help="voltage at the start")
    batteryCurve: tuple[float, ...] = numbers(
        2.0 / 3600.0,
        2.0 / 1e4,
        unit="V/s, V/m^2",
        least=0.0,
        help="voltage lost per second, and per squared metre of wheel travel",
    )


class DifferentialDrive:
    """The driven wheels of a robot's left and right side.

    Args:
        separation: distance between left and right wheels [m].
        diameter: of the wheels [m].
        torque: maximum torque of each wheel's motor [N m].
    """

    def __init__(self, separation: float, diameter: float, torque: float) -> None:
        self.separation, self.diameter, self.torque = separation, diameter, torque
        self.left: list[Wheel] = []
        self.right: list[Wheel] = []

    def add(self, wheel: Wheel, y: float) -> None:
        """Add a wheel at y [m], to the left where that is positive."""
        (self.left if y > 0.0 else self.right).append(wheel)

    @law
    def rates(self) -> tuple[float, float]:
        """Mean rate of the wheels of the left and the right side [rad/s]."""
        return _mean_rate(self.left), _mean_rate(self.right)

    def run(self, speed: float, turn: float) -> None:
        """Set the wheels' motors for a speed [m/s] and a turn [rad/s]."""
        half = turn * self.separation / 2.0
        for wheels, rate in ((self.left, speed - half), (self.right, speed + half)):
            for wheel in wheels:
                wheel.run(2.0 * rate / self.diameter, self.torque)


class DifferentialRobot(MobileRobot):
    """A robot with a differential drive; it has a battery if its attributes are BatteryAttributes."""

    STATE: ClassVar[tuple[str, ...]] = ("odometry",)

    attributes: ClassVar[type[RobotAttributes]] = BatteryAttributes
    wheelSep: ClassVar[float]  # between left and right wheels [m]
    wheelDiam: ClassVar[float]  # [m]
    maxTorque: ClassVar[float]  # of each wheel's motor [N m]
    normaliseYaw: ClassVar[bool] = False  # whether rot[2] is kept within +-pi

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.wheels = DifferentialDrive(self.wheelSep, self.wheelDiam, self.maxTorque)
        self.odometry = Odometry()
        self.battery: Battery | None = None
        super().Load(file, node)
        if isinstance(self.values, BatteryAttributes):
            self.battery = Battery(self, self.values.batteryLevel, self.values.batteryCurve)
            self.devices.insert(0, self.battery)

    def add_wheel(self, name: str, position: VectorLike, tire: Tire, base: Body | None = None) -> HingeJoint:
        """A driven wheel at `position` in the model's frame [m]; returns its hinge.

        Args:
            name: of the wheel's body and hinge.
            position: in the model's frame [m].
            tire: the kind of wheel.
            base: the body that it is attached to; by default the canonical body.
        """
        hinge = on_hinge(self, add_tire(self, name, position, tire), base or self.GetBody())
        _, y, _ = position
        self.wheels.add(Wheel(Axis(hinge)), y)
        return hinge

    def add_pair(self, y: float, z: float, tire: Tire, x: float = 0.0, suffix: str = "") -> list[HingeJoint]:
        """Driven wheels `left` and `right` at (x, +-y, z) in the model's frame [m]; returns their hinges."""
        return [self.add_wheel(f"left{suffix}", (x, y, z), tire), self.add_wheel(f"right{suffix}", (x, -y, z), tire)]

    @law
    def wheel_rates(self) -> tuple[float, float]:
        """Rates at which the wheels of the left and the right side roll on the ground [rad/s]."""
        return self.wheels.rates()

    @law
    def measure(self, step: float) -> None:
        """Odometry and battery from the wheels' rates."""
        left_rate, right_rate = self.wheel_rates()
        travel = step * self.wheelDiam / 2.0  # per [rad/s]
        left, right = travel * left_rate, travel * right_rate
        odometry = self.odometry
        odometry.advance((left + right) / 2.0, (right - left) / self.wheelSep, step)
        if self.normaliseYaw:
            odometry.pose[2] = NORMALIZE(odometry.pose[2])
        if self.battery is not None:
            self.battery.drain(step, left, right)

    @law
    def publish(self, data: PositionData) -> None:
        """Odometry."""
        self.odometry.publish(data)

    def run(self, speed: float, turn: float) -> None:
        """Drive at a speed [m/s] and a turn [rad/s]."""
        self.wheels.run(speed, turn)


def _mean_rate(wheels: list[Wheel]) -> float:
    return mean([wheel.rate() for wheel in wheels])
