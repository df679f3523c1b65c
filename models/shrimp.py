"""Shrimp: BlueBotics' climber on six wheels: two on a bogie on each side, one on a sprung fork, one behind.

The original source is lost. Outline, mass and wheels are about those published for the real machine (60 x 35 cm, 3 to
5 kg, 11 cm); the layout was chosen for libgz. The four-bar linkages of the bogies and the fork turn about a point below
the axles. Here each is a hinge at such a point, so that a wheel rises when it is pressed against a step.
"""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.base.law import Number, law
from libgz.models.drive import DifferentialRobot
from libgz.models.motors import Servo
from libgz.models.parts import DARK, GREY, add_body, fit
from libgz.models.robot import RobotAttributes
from libgz.models.wheels import Tire, Wheel, add_hinge, add_steered_wheel
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom

YELLOW = GzColor(0.9, 0.7, 0.1)
TIRE = Tire(0.055, 0.02, 0.15, DARK)
AXLE_HEIGHT = -0.145  # [m], below the origin
# The hinge of a bogie is ahead of its middle: the rear wheel carries so little weight that the front wheel, once it is
# up, can pull it up a step.
BOGIE_HINGE, BOGIE_STOP = (0.07, -0.165), math.radians(45.0)  # x, z [m]
FORK_HINGE, FORK_STOP = (0.08, -0.17), math.radians(60.0)  # x, z [m]
FORK_SPRING = 8.0  # [N m/rad]
END = 0.27  # [m], from the origin to the front and to the rear wheel, which are steered
STEERING_STOP, STEERING_GAIN, STEERING_TORQUE = math.radians(90.0), 10.0, 2.0  # [rad], [1/s], [N m]


class Shrimp(DifferentialRobot):
    """Six driven wheels, of which the front and the rear one are steered; the origin is 20 cm above the ground.

    Serves position; its odometry comes from the four wheels of the bogies. It climbs steps of 10 cm.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    STATE: ClassVar[tuple[str, ...]] = ("endAngle",)

    endAngle = Number()  # of the front wheel [rad]; the rear wheel has the opposite one

    behaviour = "motors that drive and steer its wheels; the spring of its fork; odometry"
    example = """
    <model:Shrimp>
      <id>robot1</id>
      <xyz>0 0 0.2</xyz>
    </model:Shrimp>
    """

    attributes: ClassVar[type[RobotAttributes]] = RobotAttributes
    wheelSep, wheelDiam = 0.28, 0.11
    maxTorque = 0.6

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        space = self.modelSpaceId
        fit(BoxGeom(chassis, space, 0.30, 0.14, 0.08), (0.0, 0.0, -0.04), 2.0, YELLOW)
        fit(BoxGeom(chassis, space, 0.20, 0.03, 0.03), (-0.20, 0.0, -0.09), 0.2, GREY)
        for side, y in (("left", 1.0), ("right", -1.0)):
            self._add_bogie(chassis, side, y)
        fork = self._add_fork(chassis)
        self.front, self.frontSteering = self._add_end_wheel("front", END, fork)
        self.rear, self.rearSteering = self._add_end_wheel("rear", -END, chassis)

    def _add_bogie(self, chassis: Body, side: str, y: float) -> None:
        """A bar with a wheel at each end, which tilts on a hinge."""
        bar = self._add_bar(f"{side}_bogie", (0.20, 0.02, 0.03), (0.0, 0.12 * y, AXLE_HEIGHT))
        x, z = BOGIE_HINGE
        tilt = add_hinge(self, bar, chassis, (x, 0.12 * y, z), (0.0, 1.0, 0.0), f"{side}_bogie")
        tilt.SetParam(dParamLoStop, -BOGIE_STOP)
        tilt.SetParam(dParamHiStop, BOGIE_STOP)
        for end, x in (("front", 0.09), ("rear", -0.09)):
            self.add_wheel(f"{side}_{end}", (x, 0.14 * y, AXLE_HEIGHT), TIRE, bar)

    def _add_fork(self, chassis: Body) -> Body:
        """The bar of the front wheel, which a spring holds down."""
        bar = self._add_bar("fork", (0.22, 0.03, 0.03), (0.19, 0.0, -0.09))
        x, z = FORK_HINGE
        self.fork = add_hinge(self, bar, chassis, (x, 0.0, z), (0.0, 1.0, 0.0), "fork")
        self.fork.SetParam(dParamLoStop, -FORK_STOP)
        self.fork.SetParam(dParamHiStop, FORK_STOP)
        return bar

    def _add_bar(self, name: str, size: tuple[float, float, float], position: tuple[float, float, float]) -> Body:
        bar = add_body(self, name)
        fit(BoxGeom(bar, self.modelSpaceId, *size), (0.0, 0.0, 0.0), 0.15, GREY)
        bar.SetPosition(position)
        return bar

    def _add_end_wheel(self, name: str, x: float, base: Body) -> tuple[Wheel, Servo]:
        position = (x, 0.0, AXLE_HEIGHT)
        return add_steered_wheel(self, name, position, TIRE, base, STEERING_STOP, STEERING_GAIN, STEERING_TORQUE)

    def run(self, speed: float, turn: float) -> None:
        """Run the wheels of the bogies, and steer and run the front and the rear wheel along the resulting motion."""
        super().run(speed, turn)
        sideways = turn * END
        direction = -1.0 if speed < 0.0 else 1.0
        self.endAngle = math.atan2(direction * sideways, abs(speed))
        for wheel in (self.front, self.rear):
            wheel.run(2.0 * direction * math.hypot(speed, sideways) / self.wheelDiam, self.maxTorque)

    @law
    def act(self, step: float) -> None:
        """Steer, and apply the spring of the fork."""
        self.frontSteering.turn_to(self.endAngle)
        self.rearSteering.turn_to(-self.endAngle)
        self.fork.SetTorque(-FORK_SPRING * self.fork.GetAngle())
