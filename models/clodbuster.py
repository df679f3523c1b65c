"""ClodBuster: the University of Pennsylvania's robot on a toy truck, four wheels driven and both axles steered.

Its source is lost. Wheelbase, track, wheels and encoders are those of Player's driver for the real machine; the layout
of bodies was chosen for libgz.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from libgz.geometry import GzColor
from libgz.interfaces.position import PositionData
from libgz.models.drive import DifferentialRobot
from libgz.models.parts import DARK, fit
from libgz.models.robot import RobotAttributes, clamp
from libgz.models.wheels import Steering, Tire, add_steered_wheel
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.worldfile.attributes import boolean

WHEEL_BASE, TRACK, RADIUS = 0.2921, 0.275, 0.076  # [m]
COUNTS_PER_TURN = 408  # of a wheel's encoder
TIRE = Tire(RADIUS, 0.04, 0.4, DARK)
STEERING_STOP, LARGEST_STEERING = 0.5, 0.45  # [rad]
STEERING_GAIN, STEERING_TORQUE = 10.0, 5.0  # [1/s], [N m]
SLOWEST = 0.01  # [m/s]; slower, there is no curve to steer


@dataclass(frozen=True)
class ClodBusterAttributes(RobotAttributes):
    """What `<model:ClodBuster>` may hold."""

    rawEncoder: bool = boolean(
        False, help="pos[0] and pos[1] are the counts of the left and the right encoders, 408 a turn"
    )


class ClodBuster(DifferentialRobot):
    """Four wheels, each on a stub that steers; the origin is on the ground under the centre.

    Serves position. It cannot turn on the spot: a turn without a speed leaves it standing.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    attributes: ClassVar[type[RobotAttributes]] = ClodBusterAttributes
    values: ClodBusterAttributes
    wheelSep, wheelDiam = TRACK, 2.0 * RADIUS
    maxTorque = 2.0

    def build(self) -> None:  # noqa: D102
        chassis = Body(self.world)
        self.AddBody(chassis, True)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.36, 0.16, 0.10), (0.0, 0.0, 0.13), 4.0, GzColor(0.2, 0.3, 0.8))
        self.front: list[Steering] = []
        self.rear: list[Steering] = []
        self.steeringAngle = 0.0  # wanted of the front axle; the rear axle steers against it [rad]
        self.counts = [0.0, 0.0]  # of the left and the right encoders
        for axle, x, steerings in (("front", WHEEL_BASE / 2.0, self.front), ("rear", -WHEEL_BASE / 2.0, self.rear)):
            for side, y in (("left", TRACK / 2.0), ("right", -TRACK / 2.0)):
                position = (x, y, RADIUS)
                wheel, steering = add_steered_wheel(
                    self, f"{side}_{axle}", position, TIRE, chassis, STEERING_STOP, STEERING_GAIN, STEERING_TORQUE
                )
                self.take_wheel(wheel, position)
                steerings.append(steering)

    def run(self, speed: float, turn: float) -> None:
        """Steer both axles on the circle of radius speed / turn, and run the inner wheels slower."""
        curvature = turn / speed if abs(speed) >= SLOWEST else 0.0
        self.steeringAngle = clamp(math.atan(curvature * WHEEL_BASE / 2.0), LARGEST_STEERING)
        # What the steering allows.
        curvature = math.tan(self.steeringAngle) * 2.0 / WHEEL_BASE
        super().run(speed, speed * curvature)

    def act(self, step: float) -> None:
        """Steer."""
        for steering in self.front:
            steering.turn_to(self.steeringAngle)
        for steering in self.rear:
            steering.turn_to(-self.steeringAngle)

    def measure(self, step: float) -> None:
        """Odometry and encoders."""
        super().measure(step)
        for i, rate in enumerate(self.wheel_rates()):
            self.counts[i] += COUNTS_PER_TURN * rate * step / (2.0 * math.pi)

    def publish(self, data: PositionData) -> None:
        """Odometry, or counts where they are wanted."""
        super().publish(data)
        if self.values.rawEncoder:
            data.pos[0], data.pos[1] = map(math.floor, self.counts)
