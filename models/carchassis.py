"""CarChassis: a car driven by its rear wheels and steered by its front wheels.

Its source is lost, but for the kinds of its joints. Dimensions, masses and layout were chosen for libgz so that it
rests at the height that worlds saved by the old server give.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from libgz.geometry import GzColor
from libgz.models.parts import DARK, fit
from libgz.models.robot import MobileRobot, RobotAttributes, clamp
from libgz.models.skin import SkinAttributes, clothe
from libgz.models.wheels import Steering, Tire, Wheel, add_tire, on_hinge, on_hinge2
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.worldfile.attributes import color

RADIUS, WHEEL_BASE = 0.25, 1.4  # [m]
HALF_TRACK = 0.50  # [m]
TIRE = Tire(RADIUS, 0.08, 1.0, DARK)
STEERING_STOP = math.radians(30.0)
STEERING_GAIN, STEERING_DAMPING, STEERING_TORQUE = 8.0, 0.2, 20.0  # [1/s], -, [N m]
DRIVE_TORQUE = 10.0  # [N m], each rear wheel


@dataclass(frozen=True)
class CarChassisAttributes(SkinAttributes, RobotAttributes):
    """What `<model:CarChassis>` may hold."""

    color: GzColor = color(1.0, 1.0, 1.0, help="its colour")


class CarChassis(MobileRobot):
    """A box on four wheels; the origin is on the ground under the centre.

    Serves position. It obeys cmd_vel_pos[0], the speed [m/s], and cmd_vel_rot[2], which is not a turning rate here but
    the angle of the front wheels [rad]. Its odometry is that of a bicycle.
    Dimensions and layout chosen for libgz.
    """

    attributes: ClassVar[type[RobotAttributes]] = CarChassisAttributes
    values: CarChassisAttributes

    def build(self) -> None:  # noqa: D102
        chassis = Body(self.world)
        self.AddBody(chassis, True)
        hull = fit(
            BoxGeom(chassis, self.modelSpaceId, 2.0, 0.90, 0.30), (0.0, 0.0, 0.40), 16.0, GzColor(*self.values.color)
        )
        self.rear: list[Wheel] = []
        self.front: list[Steering] = []
        for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK)):
            rear = add_tire(self, f"{side}_rear", (-WHEEL_BASE / 2.0, y, RADIUS), TIRE)
            self.rear.append(on_hinge(self, rear, chassis))
            front = on_hinge2(self, add_tire(self, f"{side}_front", (WHEEL_BASE / 2.0, y, RADIUS), TIRE), chassis)
            self.front.append(Steering(front.joint, STEERING_STOP, STEERING_GAIN, STEERING_TORQUE, STEERING_DAMPING))
        clothe(self, hull, self.values)

    def measure(self, step: float) -> None:
        """The odometry of a bicycle: the rear wheels' way, turned by the front wheels' angle."""
        speed = RADIUS * sum([wheel.rate() for wheel in self.rear]) / len(self.rear)
        angle = sum([steering.angle() for steering in self.front]) / len(self.front)
        self.advance(speed * step, speed * step * math.tan(angle) / WHEEL_BASE, step)

    def drive(self) -> None:
        """Run the rear wheels."""
        speed, _ = self.wanted
        for wheel in self.rear:
            wheel.run(speed / RADIUS, DRIVE_TORQUE)

    def act(self, step: float) -> None:
        """Steer."""
        _, angle = self.wanted
        for steering in self.front:
            steering.turn_to(clamp(angle, STEERING_STOP))
