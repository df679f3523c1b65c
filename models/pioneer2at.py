"""Pioneer2AT: ActivMedia's four-wheeled outdoor robot with skid steering."""

from __future__ import annotations

from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, GREY, RED, add_body, fit
from libgz.models.sonars import PIONEER2AT_RING, SonarRing
from libgz.models.wheels import Tire
from libgz.physics.geoms import BoxGeom
from libgz.simulation.rate import OldRate
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

AXLES = {"_front": 0.13335, "_rear": -0.13335}  # x [m]
AXLE_HEIGHT = 0.09525  # [m]
TIRE = Tire(0.10, 0.035, 1.0, GREY)


class Pioneer2AT(DifferentialRobot):
    """ActivMedia's outdoor robot: four driven wheels with skid steering, sixteen sonars.

    The origin is on the ground under the centre.
    Its yaw is not limited to +-pi.
    """

    interfaces = ("position", "power", "sonar")
    wheelSep, wheelDiam = 0.381, 0.20
    maxTorque = 10.0

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        super().Load(file, node)
        if "updateTimes" in self.world.engine.quirks:
            self.rate = OldRate(self.rate.period, last=-self.rate.period, beyond=True)

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.48006, 0.3429, 0.1905), (0.0, 0.0, 0.19525), 10.0, RED)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.5334, 0.381, 0.02), (0.0, 0.0, 0.300025), 0.0, BLACK)
        for suffix, x in AXLES.items():
            self.add_pair(0.1905, AXLE_HEIGHT, TIRE, x, suffix)
        self.devices.append(SonarRing(self, chassis, PIONEER2AT_RING))
