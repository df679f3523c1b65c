"""ClodBuster: the University of Pennsylvania's robot on a toy truck, four wheels driven and both axles steered.

The original source is lost. Wheelbase, track, wheels and encoders are those of Player's driver for the real machine;
the layout of bodies was chosen for libgz.
"""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.base.law import Number, clamp, floor, law
from libgz.base.records import numbers
from libgz.interfaces.position import PositionData
from libgz.models.drive import DifferentialRobot
from libgz.models.motors import Servo
from libgz.models.parts import DARK, add_body, fit
from libgz.models.robot import RobotAttributes
from libgz.models.wheels import Tire, add_steered_wheel
from libgz.physics.geoms import BoxGeom
from libgz.worldfile.attributes import boolean, declaration

WHEEL_BASE, TRACK, RADIUS = 0.2921, 0.275, 0.076  # [m]
COUNTS_PER_TURN = 408  # of a wheel's encoder
TIRE = Tire(RADIUS, 0.04, 0.4, DARK)
STEERING_STOP, LARGEST_STEERING = 0.5, 0.45  # [rad]
STEERING_GAIN, STEERING_TORQUE = 10.0, 5.0  # [1/s], [N m]
SLOWEST = 0.01  # [m/s]; at lower speeds it steers straight


@declaration
class ClodBusterAttributes(RobotAttributes):
    """Attributes of `<model:ClodBuster>`."""

    rawEncoder: bool = boolean(
        False, help="pos[0] and pos[1] are the counts of the left and the right encoders, 408 per turn"
    )


class ClodBuster(DifferentialRobot):
    """Four driven and steered wheels; the origin is on the ground under the centre.

    Serves position. It cannot turn on the spot: a turn without a speed is ignored.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    STATE: ClassVar[tuple[str, ...]] = ("steeringAngle", "counts")

    steeringAngle = Number()  # of the front axle [rad]; the rear axle has the opposite one

    behaviour = "motors that drive its wheels and steer both axles; odometry"
    attributes: ClassVar[type[RobotAttributes]] = ClodBusterAttributes
    values: ClodBusterAttributes
    wheelSep, wheelDiam = TRACK, 2.0 * RADIUS
    maxTorque = 2.0

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.36, 0.16, 0.10), (0.0, 0.0, 0.13), 4.0, GzColor(0.2, 0.3, 0.8))
        self.front: list[Servo] = []
        self.rear: list[Servo] = []
        self.counts = numbers(2)()  # of the left and the right encoders
        for axle, x, steerings in (("front", WHEEL_BASE / 2.0, self.front), ("rear", -WHEEL_BASE / 2.0, self.rear)):
            for side, y in (("left", TRACK / 2.0), ("right", -TRACK / 2.0)):
                position = (x, y, RADIUS)
                wheel, steering = add_steered_wheel(
                    self, f"{side}_{axle}", position, TIRE, chassis, STEERING_STOP, STEERING_GAIN, STEERING_TORQUE
                )
                self.wheels.add(wheel, y)
                steerings.append(steering)

    def run(self, speed: float, turn: float) -> None:
        """Steer both axles for the circle of radius speed / turn, and run the inner wheels slower."""
        curvature = turn / speed if abs(speed) >= SLOWEST else 0.0
        self.steeringAngle = clamp(math.atan(curvature * WHEEL_BASE / 2.0), LARGEST_STEERING)
        # The curvature that the steering reaches.
        curvature = math.tan(self.steeringAngle) * 2.0 / WHEEL_BASE
        super().run(speed, speed * curvature)

    @law
    def act(self, step: float) -> None:
        """Steer."""
        for steering in self.front:
            steering.turn_to(self.steeringAngle)
        for steering in self.rear:
            steering.turn_to(-self.steeringAngle)

    @law
    def measure(self, step: float) -> None:
        """Odometry and encoders."""
        super().measure(step)
        for i, rate in enumerate(self.wheel_rates()):
            self.counts[i] += COUNTS_PER_TURN * rate * step / (2.0 * math.pi)

    @law
    def publish(self, data: PositionData) -> None:
        """Odometry, or encoder counts with rawEncoder."""
        super().publish(data)
        if self.values.rawEncoder:
            data.pos[0], data.pos[1] = map(floor, self.counts)
