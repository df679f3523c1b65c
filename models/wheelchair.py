"""WheelChair: an electric wheelchair, driven by its rear wheels, with casters in front.

Of the original source only the kinds of its joints are known. Dimensions, masses and layout were chosen for libgz.
"""

from __future__ import annotations

from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.models.drive import DifferentialRobot
from libgz.models.motors import Axis
from libgz.models.parts import BLACK, DARK, GREY, add_body, fit
from libgz.models.robot import RobotAttributes
from libgz.models.wheels import Tire, Wheel, add_tire, on_hinge2
from libgz.physics.geoms import BoxGeom

TIRE = Tire(0.16, 0.04, 2.0, DARK, hard=True)
CASTER = Tire(0.09, 0.025, 0.7, DARK, hard=True)
BLUE = GzColor(0.1, 0.2, 0.5)


class WheelChair(DifferentialRobot):
    """A chair on four wheels with suspension; the origin is the top of the backrest, 1.20 m above the ground.

    Serves position. Dimensions and layout chosen for libgz.
    """

    example = """
    <model:WheelChair>
      <id>robot1</id>
      <xyz>0 0 1.2</xyz>
    </model:WheelChair>
    """

    attributes: ClassVar[type[RobotAttributes]] = RobotAttributes
    wheelSep, wheelDiam = 0.58, 0.32
    maxTorque = 30.0

    def build(self) -> None:  # noqa: D102
        chair = add_body(self)
        space = self.modelSpaceId
        fit(BoxGeom(chair, space, 0.50, 0.50, 0.12), (0.0, 0.0, -0.70), 20.0, BLUE)
        fit(BoxGeom(chair, space, 0.60, 0.46, 0.25), (0.0, 0.0, -0.93), 40.0, GREY)
        fit(BoxGeom(chair, space, 0.08, 0.46, 0.62), (-0.26, 0.0, -0.31), 6.0, BLUE)
        fit(BoxGeom(chair, space, 0.20, 0.40, 0.04), (0.45, 0.0, -1.02), 2.0, BLACK)
        for side, y in (("left", 1.0), ("right", -1.0)):
            position = (-0.20, 0.29 * y, -1.04)
            joint = on_hinge2(self, add_tire(self, f"{side}_rear", position, TIRE), chair, stop=0.0)
            self.wheels.add(Wheel(Axis(joint, 2)), y)
            caster = add_tire(self, f"{side}_caster", (0.35, 0.24 * y, -1.11), CASTER)
            caster.GetGeoms()[0].SetFriction(0.0)
            on_hinge2(self, caster, chair, stop=None)
