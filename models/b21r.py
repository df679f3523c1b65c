"""B21R: iRobot's large indoor robot, a drum on a synchro drive.

The original source is lost. Size, mass and speeds are those published for the real machine (diameter 52.5 cm, height
106 cm, 122 kg), the poses of the sonars those in Player's configuration; the layout was chosen for libgz, with two
driven wheels instead of the synchro drive.
"""

from __future__ import annotations

import math

from libgz.base.geometry import GzColor
from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, DARK, add_body, fit
from libgz.models.sonars import SonarRing
from libgz.models.wheels import Tire, add_caster
from libgz.physics.geoms import CylinderGeom

TIRE = Tire(0.0625, 0.02, 1.0, DARK, hard=True)
# First angle [deg], radius and height [m] of the rings of 24 sonars, which run clockwise.
ENCLOSURE = (172.5, 0.250, 0.85)
BASE = (240.0, 0.260, 0.30)
SPACING = 15.0  # [deg]


def sonar_poses() -> list[tuple[float, float, float, float]]:
    """(x, y, z [m], direction [rad]) of the 48 sonars: those of the enclosure first, then those of the base."""
    poses = []
    for first, radius, z in (ENCLOSURE, BASE):
        for i in range(24):
            angle = math.radians(first - SPACING * i)
            poses.append((radius * math.cos(angle), radius * math.sin(angle), z, angle))
    return poses


class B21R(DifferentialRobot):
    """Two driven wheels, two sliding casters, two rings of 24 sonars; the origin is on the ground below the centre.

    Serves position, power and sonar. Dimensions as published for the real machine; layout chosen for libgz.
    """

    interfaces = ("position", "power", "sonar")
    wheelSep, wheelDiam = 0.40, 0.125
    maxTorque = 20.0

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        space = self.modelSpaceId
        fit(CylinderGeom(chassis, space, 0.2625, 0.35), (0.0, 0.0, 0.225), 80.0, GzColor(0.8, 0.0, 0.0))
        fit(CylinderGeom(chassis, space, 0.25, 0.66), (0.0, 0.0, 0.73), 37.0, GzColor(0.2, 0.2, 0.2))
        self.add_pair(0.20, 0.0625, TIRE)
        for name, x in (("front", 0.20), ("rear", -0.20)):
            add_caster(self, name, chassis, (x, 0.0, 0.05), 0.05, 1.0, BLACK, hard=True, friction=0.0)
        self.devices.append(SonarRing(self, chassis, sonar_poses()))
