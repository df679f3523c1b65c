"""PeopleBot: ActivMedia's tall robot on the base of a Pioneer 2.

The original source is lost. Outline and mass are those published for the real machine (47 x 38 x 112 cm, about 20 kg),
the poses of the sonars those in Player's driver; the layout of bodies was chosen for libgz.
"""

from __future__ import annotations

import math

from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, DARK, RED, add_body, fit
from libgz.models.sonars import SonarRing
from libgz.models.wheels import Tire, add_caster
from libgz.physics.geoms import BoxGeom

TIRE = Tire(0.095, 0.025, 0.5, DARK, hard=True)
# Left half of each ring, from the side to the front: x, y [m], direction [deg].
LOWER = ((0.069, 0.136, 90), (0.114, 0.119, 50), (0.148, 0.078, 30), (0.166, 0.027, 10))
UPPER = ((-0.020, 0.136, 90), (0.024, 0.119, 50), (0.058, 0.078, 30), (0.077, 0.027, 10))
LOWER_HEIGHT, UPPER_HEIGHT = 0.20, 1.05  # [m]


def sonar_poses() -> list[tuple[float, float, float, float]]:
    """(x, y, z [m], direction [rad]) of the sixteen sonars: the lower ring, then the upper, each from left to right."""
    poses = []
    for half, z in ((LOWER, LOWER_HEIGHT), (UPPER, UPPER_HEIGHT)):
        poses += [(x, y, z, math.radians(a)) for x, y, a in half]
        poses += [(x, -y, z, -math.radians(a)) for x, y, a in reversed(half)]
    return poses


class PeopleBot(DifferentialRobot):
    """Two driven wheels, a ball caster, a column with a deck, and sixteen sonars in two half rings.

    The origin is on the ground under the axle. Serves position, power and sonar.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    interfaces = ("position", "power", "sonar")
    wheelSep, wheelDiam = 0.33, 0.19
    maxTorque = 1.5  # with much more it tips over when it brakes

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        space = self.modelSpaceId
        fit(BoxGeom(chassis, space, 0.38, 0.27, 0.17), (-0.05, 0.0, 0.15), 12.0, RED)
        fit(BoxGeom(chassis, space, 0.12, 0.22, 0.72), (-0.12, 0.0, 0.60), 2.0, DARK)
        fit(BoxGeom(chassis, space, 0.40, 0.35, 0.16), (-0.06, 0.0, 1.04), 3.0, DARK)
        self.add_pair(0.165, 0.095, TIRE)
        add_caster(self, "caster", chassis, (-0.22, 0.0, 0.04), 0.04, 2.0, BLACK, hard=True)
        self.devices.append(SonarRing(self, chassis, sonar_poses()))
