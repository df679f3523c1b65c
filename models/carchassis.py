"""CarChassis: a car driven by its rear wheels and steered by its front wheels.

Of the original source only the kinds of its joints are known. Dimensions, masses and layout were chosen for libgz so
that it rests at the height given in worlds saved by the original server.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.interfaces.position import PositionData
from libgz.models.motors import Axis, Servo
from libgz.models.odometry import Odometry
from libgz.models.parts import DARK, add_body, fit
from libgz.models.robot import MobileRobot, RobotAttributes, clamp
from libgz.models.skin import SkinAttributes, add_skin
from libgz.models.wheels import Tire, Wheel, add_tire, on_hinge, on_hinge2
from libgz.ode.records import numbers
from libgz.physics.geoms import BoxGeom
from libgz.simulation.updates import Exchange, UpdateRows, is_plain, replaced
from libgz.worldfile.attributes import color

RADIUS, WHEEL_BASE = 0.25, 1.4  # [m]
HALF_TRACK = 0.50  # [m]
TIRE = Tire(RADIUS, 0.08, 1.0, DARK)
STEERING_STOP = math.radians(30.0)
STEERING_GAIN, STEERING_DAMPING, STEERING_TORQUE = 8.0, 0.2, 20.0  # [1/s], -, [N m]
DRIVE_TORQUE = 10.0  # [N m], each rear wheel


@dataclass(frozen=True)
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
    ROW_PARTS = MobileRobot.ROW_PARTS | {"odometry", "front", "rear"}

    behaviour = "motors that drive and steer its wheels, and hold the steering straight; odometry"
    attributes: ClassVar[type[RobotAttributes]] = CarChassisAttributes
    values: CarChassisAttributes

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        hull = fit(
            BoxGeom(chassis, self.modelSpaceId, 2.0, 0.90, 0.30), (0.0, 0.0, 0.40), 16.0, GzColor(*self.values.color)
        )
        self.odometry = Odometry()
        self._steering = numbers(1)()  # wanted angle of the front wheels [rad]
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

    def measure(self, step: float) -> None:
        """Odometry from the travel of the rear wheels and the angle of the front wheels."""
        speed = RADIUS * sum([wheel.rate() for wheel in self.rear]) / len(self.rear)
        angle = sum([steering.angle() for steering in self.front]) / len(self.front)
        self.odometry.advance(speed * step, speed * step * math.tan(angle) / WHEEL_BASE, step)

    def publish(self, data: PositionData) -> None:
        """Odometry."""
        self.odometry.publish(data)

    def run(self, speed: float, angle: float) -> None:
        """Run the rear wheels at a speed [m/s], and steer to an angle [rad]."""
        self._steering[0] = clamp(angle, STEERING_STOP)
        for wheel in self.rear:
            wheel.run(speed / RADIUS, DRIVE_TORQUE)

    def act(self, step: float) -> None:
        """Steer."""
        for steering in self.front:
            steering.turn_to(self._steering[0])

    def MasterRowsOfMeasure(self, rows: UpdateRows) -> None:
        """Describe `measure` as a row."""
        plain = is_plain(self.odometry, Odometry, "advance")
        if replaced(self, CarChassis, "measure") or not plain:
            super().MasterRowsOfMeasure(rows)
            return
        driven, steered = ([part.axis.joint_axis for part in parts] for parts in (self.rear, self.front))
        rows.bicycle(self.measure, self.odometry, driven, steered, RADIUS, WHEEL_BASE)

    def MasterPublished(self, exchange: Exchange) -> bool:
        """Describe `publish` as numbers."""
        if replaced(self, CarChassis, "publish") or not is_plain(self.odometry, Odometry, "publish"):
            return False
        self.odometry.share(exchange)
        return True

    def MasterRowsOfAct(self, rows: UpdateRows) -> None:
        """Describe `act` as rows."""
        if replaced(self, CarChassis, "act"):
            super().MasterRowsOfAct(rows)
            return
        for steering in self.front:
            steering.add_row(rows, self._steering)
