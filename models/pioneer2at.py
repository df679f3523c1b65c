"""Pioneer2AT: ActivMedia's four-wheeled outdoor robot, steering by its sides' speeds."""

from __future__ import annotations

from libgz.geometry import GzColor, GzVector
from libgz.models.drive import DifferentialRobot
from libgz.models.sonars import PIONEER2AT_RING, SonarRing
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom

WHEELS = {
    "left_front": (0.13335, 0.1905),
    "right_front": (0.13335, -0.1905),
    "left_rear": (-0.13335, 0.1905),
    "right_rear": (-0.13335, -0.1905),
}
AXLE_HEIGHT = 0.09525  # [m]


class Pioneer2AT(DifferentialRobot):
    """Four driven wheels and sixteen sonars; the origin is on the ground under the centre.

    Serves position, power and sonar. Its yaw runs on beyond a turn.
    """

    wheelSep, wheelDiam = 0.381, 0.20
    maxTorque = 10.0
    normaliseYaw = False

    def build(self) -> None:  # noqa: D102
        chassis = Body(self.world)
        self.AddBody(chassis, True)
        hull = BoxGeom(chassis, self.modelSpaceId, 0.48006, 0.3429, 0.1905)
        hull.SetRelativePosition((0.0, 0.0, 0.19525))
        hull.SetMass(10.0)
        hull.SetColor(GzColor(1.0, 0.0, 0.0))
        plate = BoxGeom(chassis, self.modelSpaceId, 0.5334, 0.381, 0.02)
        plate.SetRelativePosition((0.0, 0.0, 0.300025))
        plate.SetMass(0.0)
        plate.SetColor(GzColor(0.0, 0.0, 0.0))
        for name, (x, y) in WHEELS.items():
            self.add_wheel(name, GzVector(x, y, AXLE_HEIGHT), 0.035, 1.0, GzColor(0.3, 0.3, 0.3))
        self.sonars = SonarRing(self, chassis, PIONEER2AT_RING)
