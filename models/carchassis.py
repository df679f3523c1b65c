"""CarChassis: a car driven by its rear wheels and steered by its front wheels.

Of the original source only the kinds of its joints are known. Dimensions, masses and layout were chosen for libgz so
that it rests at the height given in worlds saved by the original server.
"""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.base.law import Number, clamp, law, tan
from libgz.interfaces.position import PositionData
from libgz.models.motors import Axis, Servo, mean
from libgz.models.odometry import Odometry
from libgz.models.parts import DARK, add_body, fit
from libgz.models.robot import MobileRobot, RobotAttributes
from libgz.models.skin import SkinAttributes, add_skin
from libgz.models.wheels import Tire, Wheel, add_tire, on_hinge, on_hinge2
from libgz.physics.geoms import BoxGeom
from libgz.worldfile.attributes import color, declaration

RADIUS, WHEEL_BASE = 0.25, 1.4  # [m]
HALF_TRACK = 0.50  # [m]
TIRE = Tire(RADIUS, 0.08, 1.0, DARK)
STEERING_STOP = math.radians(30.0)
STEERING_GAIN, STEERING_DAMPING, STEERING_TORQUE = 8.0, 0.2, 20.0  # [1/s], -, [N m]
DRIVE_TORQUE = 10.0  # [N m], each rear wheel


@declaration
class CarChassisAttributes(SkinAttributes, RobotAttributes):
    """Attributes of `<model:CarChassis>`."""

    color: GzColor = color(1.0, 1.0, 1.0, help="colour of the chassis")


class CarChassis(MobileRobot):
    """A box on four wheels; the origin is on the ground under the centre.

    Serves position. It obeys cmd_vel_pos[0], the speed [m/s], and cmd_vel_rot[2], which here is not a turning rate but
    the steering angle of the front wheels [rad]. Its odometry is that of a bicycle model.
    Dimensions and layout chosen for libgz.
    """

    STATE: ClassVar[tuple[str, ...]] = ("odometry", "_steering")

    _steering = Number()  # wanted angle of the front wheels [rad]

    behaviour = "motors that drive and steer its wheels, and hold the steering straight; odometry"
    attributes: ClassVar[type[RobotAttributes]] = CarChassisAttributes
    values: CarChassisAttributes

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        hull = fit(
            BoxGeom(chassis, self.modelSpaceId, 2.0, 0.90, 0.30), (0.0, 0.0, 0.40), 16.0, GzColor(*self.values.color)
        )
        self.odometry = Odometry()
        self.rear: list[Wheel] = []
        self.front: list[Servo] = []
        for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK)):
            rear = add_tire(self, f"{side}_rear", (-WHEEL_BASE / 2.0, y, RADIUS), TIRE)
            self.rear.append(Wheel(Axis(on_hinge(self, rear, chassis))))
            steering = on_hinge2(self, add_tire(self, f"{side}_front", (WHEEL_BASE / 2.0, y, RADIUS), TIRE), chassis)
            self.front.append(
                Servo(Axis(steering), STEERING_GAIN, STEERING_TORQUE, STEERING_DAMPING, stop=STEERING_STOP)
            )
        add_skin(self, hull, self.values)

    @law
    def measure(self, step: float) -> None:
        """Odometry from the travel of the rear wheels and the angle of the front wheels."""
        speed = RADIUS * (self.rear[0].rate() + self.rear[1].rate()) / 2.0
        angle = mean([steering.angle() for steering in self.front])
        self.odometry.advance(speed * step, speed * step * tan(angle) / WHEEL_BASE, step)

    @law
    def publish(self, data: PositionData) -> None:
        """Odometry."""
        self.odometry.publish(data)

    def run(self, speed: float, angle: float) -> None:
        """Run the rear wheels at a speed [m/s], and steer to an angle [rad]."""
        self._steering = clamp(angle, STEERING_STOP)
        for wheel in self.rear:
            wheel.run(speed / RADIUS, DRIVE_TORQUE)

    @law
    def act(self, step: float) -> None:
        """Steer."""
        for steering in self.front:
            steering.turn_to(self._steering)
