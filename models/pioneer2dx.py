"""Pioneer2DX: ActivMedia's two-wheeled indoor robot with a caster."""

from __future__ import annotations

import math

from libgz.geometry import GzColor, GzQuaternFromAxis, GzVector
from libgz.models.drive import DifferentialRobot
from libgz.models.sonars import PIONEER2DX_RING, SonarRing
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom, SphereGeom
from libgz.physics.joint import BallJoint

CASTER = GzVector(-0.22, 0.0, -0.2)


class Pioneer2DX(DifferentialRobot):
    """Two driven wheels, a ball caster and sixteen sonars; the origin is the centre of the top plate above the axle.

    Serves position, power and sonar. Its yaw stays within +-pi.
    """

    wheelSep, wheelDiam = 0.35, 0.19
    maxTorque = 1.1
    normaliseYaw = True

    def build(self) -> None:  # noqa: D102
        chassis = Body(self.world)
        self.AddBody(chassis, True)
        hull = BoxGeom(chassis, self.modelSpaceId, 0.38, 0.27, 0.17)
        hull.SetRelativePosition((-0.05, 0.0, -0.085))
        hull.SetMass(5.0)
        hull.SetColor(GzColor(1.0, 0.0, 0.0))
        plate = BoxGeom(chassis, self.modelSpaceId, 0.45, 0.38, 0.005)
        plate.SetRelativePosition((-0.05, 0.0, 0.0))
        plate.SetMass(0.0)
        plate.SetColor(GzColor(0.0, 0.0, 0.0))
        for name, y in (("left", 0.175), ("right", -0.175)):
            self.add_wheel(name, GzVector(0.0, y, -0.145), 0.05, 0.5, GzColor(0.1, 0.1, 0.1))
        self._add_caster(chassis)
        self.sonars = SonarRing(self, chassis, PIONEER2DX_RING)

    def _add_caster(self, chassis: Body) -> None:
        """A ball under the rear; heavy on purpose, for it keeps the robot from pitching forward when it brakes."""
        caster = Body(self.world, "caster")
        self.AddBody(caster)
        ball = SphereGeom(caster, self.modelSpaceId, 0.04)
        ball.SetMass(5.0)
        ball.SetColor(GzColor(0.0, 0.0, 0.0))
        caster.SetPosition(CASTER)
        caster.SetRotation(GzQuaternFromAxis(1.0, 0.0, 0.0, math.pi / 2.0))
        joint = BallJoint(self.world, name="caster")
        joint.Attach(caster, chassis)
        joint.SetAnchor(CASTER)
