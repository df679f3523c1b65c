"""DifferentialRobot: what all robots have in common that steer by driving their sides at different speeds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from libgz.geometry import NORMALIZE, VectorLike
from libgz.models.battery import Battery
from libgz.models.robot import MobileRobot, RobotAttributes
from libgz.models.wheels import Tire, Wheel, add_tire, on_hinge
from libgz.physics.body import Body
from libgz.worldfile.attributes import number, numbers
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["BatteryAttributes", "DifferentialRobot"]


@dataclass(frozen=True)
class BatteryAttributes(RobotAttributes):
    """What the element of a robot with a battery may hold."""

    batteryLevel: float = number(12.4, unit="V", least=0.0, help="charge at the start")
    batteryCurve: tuple[float, ...] = numbers(
        2.0 / 3600.0,
        2.0 / 1e4,
        unit="V/s, V/m^2",
        least=0.0,
        help="charge lost with time, and with squared wheel travel",
    )


class DifferentialRobot(MobileRobot):
    """A robot with driven wheels left and right; it has a battery if its attributes are those of one."""

    attributes: ClassVar[type[RobotAttributes]] = BatteryAttributes
    wheelSep: ClassVar[float]  # between left and right wheels [m]
    wheelDiam: ClassVar[float]  # [m]
    maxTorque: ClassVar[float]  # of each wheel's motor [N m]
    normaliseYaw: ClassVar[bool] = False  # whether rot[2] is kept within +-pi

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.left: list[Wheel] = []
        self.right: list[Wheel] = []
        self.battery: Battery | None = None
        self._driven: tuple[float, ...] | None = None  # what the motors were last set to
        super().Load(file, node)
        if isinstance(self.values, BatteryAttributes):
            self.battery = Battery(self, self.values.batteryLevel, self.values.batteryCurve)
            self.devices.insert(0, self.battery)

    def add_wheel(self, name: str, position: VectorLike, tire: Tire, base: Body | None = None) -> Body:
        """A driven wheel at `position` in the model's frame [m], on a hinge of the canonical body or another base."""
        body = add_tire(self, name, position, tire)
        self.take_wheel(on_hinge(self, body, base or self.GetBody()), position)
        return body

    def take_wheel(self, wheel: Wheel, position: VectorLike) -> None:
        """Drive a wheel, and count its turns; the side is that of its y."""
        _, y, _ = position
        (self.left if y > 0.0 else self.right).append(wheel)

    def wheel_rates(self) -> tuple[float, float]:
        """How fast the wheels of the left and the right side roll [rad/s]: the mean of each side."""
        return _mean_rate(self.left), _mean_rate(self.right)

    def measure(self, step: float) -> None:
        """Odometry and battery from the wheels' rates."""
        left_rate, right_rate = self.wheel_rates()
        way = step * self.wheelDiam / 2.0  # per [rad/s]
        left, right = way * left_rate, way * right_rate
        self.advance((left + right) / 2.0, (right - left) / self.wheelSep, step)
        if self.normaliseYaw:
            self.odometry[2] = NORMALIZE(self.odometry[2])
        if self.battery is not None:
            self.battery.drain(step, left, right)

    def drive(self) -> None:
        """Run the wheels, if the command changed."""
        wanted = self.wanted
        if wanted != self._driven:
            self._driven = wanted
            self.run(*wanted)

    def run(self, speed: float, turn: float) -> None:
        """Set the wheels' motors for a speed [m/s] and a turn [rad/s]."""
        half = turn * self.wheelSep / 2.0
        for wheels, rate in ((self.left, speed - half), (self.right, speed + half)):
            for wheel in wheels:
                wheel.run(2.0 * rate / self.wheelDiam, self.maxTorque)


def _mean_rate(wheels: list[Wheel]) -> float:
    total = 0.0
    for wheel in wheels:
        total += wheel.rate()
    return total / len(wheels)
