"""Atrv: iRobot's ATRV-Jr, a four-wheeled robot for rough ground, with skid steering.

The original source is lost. Outline and mass are those published for the real machine (77.5 x 64 x 55 cm, 50 kg), the
poses of the sonars those in Player's configuration; the layout was chosen for libgz.
"""

from __future__ import annotations

import math

from libgz.base.geometry import GzColor
from libgz.models.drive import DifferentialRobot
from libgz.models.parts import DARK, GREY, add_body, fit
from libgz.models.sonars import SonarRing
from libgz.models.wheels import Tire
from libgz.physics.geoms import BoxGeom

AXLES = {"_front": 0.21, "_rear": -0.21}  # x [m]
TIRE = Tire(0.17, 0.05, 3.0, DARK, hard=True)
REAR = ((-335, -104, -150), (-340, -50, -165), (-347, 0, 180), (-340, 50, 165), (-335, 104, 150))  # [mm], [deg]
LEFT = (
    (230, 175, 45),
    (172, 179, 60),
    (117, 181, 75),
    (72, 181, 90),
    (-72, 181, 90),
    (-117, 181, 105),
    (-172, 179, 120),
    (-230, 175, 135),
)
FRONT = ((296, 104, 30), (302, 50, 15), (308, 0, 0), (302, -50, -15), (296, -104, -30))
RIGHT = tuple((x, -y, -a) for x, y, a in LEFT)
SONAR_HEIGHT = 0.36  # [m]; above the wheels, which collide as spheres


class Atrv(DifferentialRobot):
    """Four driven wheels and twenty-six sonars; the origin is on the ground under the centre.

    Serves position, power and sonar. Dimensions as published for the real machine; layout chosen for libgz.
    """

    interfaces = ("position", "power", "sonar")
    wheelSep, wheelDiam = 0.54, 0.34
    maxTorque = 20.0

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        space = self.modelSpaceId
        fit(BoxGeom(chassis, space, 0.62, 0.36, 0.26), (0.0, 0.0, 0.27), 36.0, GzColor(0.9, 0.3, 0.0))
        fit(BoxGeom(chassis, space, 0.70, 0.40, 0.03), (0.0, 0.0, 0.42), 2.0, GREY)
        for suffix, x in AXLES.items():
            self.add_pair(0.27, 0.17, TIRE, x, suffix)
        sonars = (*REAR, *LEFT, *FRONT, *RIGHT)
        poses = [(x / 1e3, y / 1e3, SONAR_HEIGHT, math.radians(a)) for x, y, a in sonars]
        self.devices.append(SonarRing(self, chassis, poses))
