"""Quadruped: a robot with twelve joints that stands by its servos, a model of the benchmarks."""

from __future__ import annotations

from typing import ClassVar

import libgz
from libgz.base.law import law
from libgz.base.records import numbers
from libgz.models.motors import Axis, Servo
from libgz.models.parts import add_body, fit
from libgz.models.wheels import add_hinge
from libgz.simulation.plan import Plan
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

__all__ = ["HEIGHT", "LEGS", "Quadruped", "legged_text"]

TRUNK, TRUNK_MASS = (0.45, 0.20, 0.10), 9.0  # [m], [kg]
HIP_MASS, THIGH_MASS, SHANK_MASS = 0.7, 1.0, 0.2  # [kg]
LENGTH, WIDTH, FOOT = 0.20, 0.03, 0.025  # of thighs and shanks; radius of feet [m]
LEGS = tuple((x, y) for x in (0.19, -0.19) for y in (0.13, -0.13))  # [m]
HEIGHT = 2 * LENGTH + FOOT  # of the hips, legs straight [m]
GAIN, TORQUE = 10.0, 30.0  # [1/s], [N m]
STANCE = (0.0, 0.5, -1.0)  # [rad] of hip, thigh and shank


class Quadruped(libgz.Model):
    """A trunk on four legs of three joints each; the origin is on the ground, legs straight."""

    STATE: ClassVar[tuple[str, ...]] = ()

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:
        """Build it."""
        trunk, space = add_body(self), self.modelSpaceId
        fit(libgz.BoxGeom(trunk, space, *TRUNK), (0.0, 0.0, HEIGHT), TRUNK_MASS)
        self.targets, self.servos = numbers(3 * len(LEGS))(), []
        for leg, (x, y) in enumerate(LEGS):
            hip, thigh, shank = (add_body(self, f"{part}{leg}") for part in ("hip", "thigh", "shank"))
            fit(libgz.SphereGeom(hip, space, 0.04), (0.0, 0.0, 0.0), HIP_MASS)
            fit(libgz.BoxGeom(thigh, space, WIDTH, WIDTH, LENGTH), (0.0, 0.0, -LENGTH / 2), THIGH_MASS)
            fit(libgz.BoxGeom(shank, space, WIDTH, WIDTH, LENGTH), (0.0, 0.0, -LENGTH / 2), SHANK_MASS)
            fit(libgz.SphereGeom(shank, space, FOOT), (0.0, 0.0, -LENGTH), SHANK_MASS / 4)
            knee = HEIGHT - LENGTH
            for body, base, z, axis in (
                (hip, trunk, HEIGHT, (1.0, 0.0, 0.0)),
                (thigh, hip, HEIGHT, (0.0, 1.0, 0.0)),
                (shank, thigh, knee, (0.0, 1.0, 0.0)),
            ):
                body.SetPosition((x, y, z))
                hinge = add_hinge(self, body, base, (x, y, z), axis)
                self.servos.append(Servo(Axis(hinge), GAIN, TORQUE))
            self.targets[3 * leg : 3 * leg + 3] = STANCE

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:
        """Nothing."""

    def Fini(self) -> None:
        """Nothing."""

    def plan_update(self, plan: Plan) -> None:
        """Hold the stance."""
        plan.call(self.stand)

    @law
    def stand(self) -> None:
        """Turn the joints towards the stance."""
        for servo, target in zip(self.servos, self.targets, strict=True):
            servo.turn_to(target)


libgz.GZ_REGISTER_STATIC("Quadruped", Quadruped)


def legged_text(count: int) -> str:
    """A worldfile with robots in a row, 2 m apart."""
    robots = "".join(f"<model:Quadruped><id>q{i}</id><xyz>{2 * i} 0 0.01</xyz></model:Quadruped>" for i in range(count))
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robots}</gz:world>"
