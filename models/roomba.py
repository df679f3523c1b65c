"""Roomba: iRobot's vacuum cleaner.

The original source is lost. Diameter, axle and speed are those in Player's driver for the real machine (33 cm, 25.8 cm,
0.5 m/s), height and mass are about 9 cm and 2.7 kg; the layout was chosen for libgz.
"""

from __future__ import annotations

from libgz.base.geometry import GzColor
from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, DARK, add_body, fit
from libgz.models.wheels import Tire, add_caster
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom

TIRE = Tire(0.033, 0.012, 0.1, DARK)


class Roomba(DifferentialRobot):
    """A low disc on two driven wheels, with a ball in front and a skid behind.

    The origin is on the ground under the centre. Serves position and power.
    Dimensions as published for the real machine; layout chosen for libgz.
    """

    interfaces = ("position", "power")
    wheelSep, wheelDiam = 0.258, 0.066
    maxTorque = 0.5

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        space = self.modelSpaceId
        fit(CylinderGeom(chassis, space, 0.165, 0.07), (0.0, 0.0, 0.05), 1.6, GzColor(0.8, 0.8, 0.8))
        fit(BoxGeom(chassis, space, 0.10, 0.08, 0.05), (0.06, 0.0, 0.045), 1.0, DARK)
        skid = fit(SphereGeom(chassis, space, 0.012), (-0.13, 0.0, 0.016), 0.0, BLACK)
        skid.SetFriction(0.0)
        self.add_pair(0.129, 0.033, TIRE)
        add_caster(self, "caster", chassis, (0.13, 0.0, 0.015), 0.015, 0.1, BLACK)
