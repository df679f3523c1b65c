"""Pioneer2AT: ActivMedia's four-wheeled outdoor robot, steering by its sides' speeds."""

from __future__ import annotations

from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, GREY, RED, fit
from libgz.models.sonars import PIONEER2AT_RING, SonarRing
from libgz.models.wheels import Tire
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.simulation.rate import OldRate
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

WHEELS = {
    "left_front": (0.13335, 0.1905),
    "right_front": (0.13335, -0.1905),
    "left_rear": (-0.13335, 0.1905),
    "right_rear": (-0.13335, -0.1905),
}
AXLE_HEIGHT = 0.09525  # [m]
TIRE = Tire(0.10, 0.035, 1.0, GREY)


class Pioneer2AT(DifferentialRobot):
    """ActivMedia's outdoor robot: four driven wheels that steer by their sides' speeds, sixteen sonars.

    The origin is on the ground under the centre.
    Its yaw runs on beyond a turn.
    """

    interfaces = ("position", "power", "sonar")
    wheelSep, wheelDiam = 0.381, 0.20
    maxTorque = 10.0

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        super().Load(file, node)
        if "updateTimes" in self.world.engine.quirks:
            self.rate = OldRate(self.rate.period, last=-self.rate.period, beyond=True)

    def build(self) -> None:  # noqa: D102
        chassis = Body(self.world)
        self.AddBody(chassis, True)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.48006, 0.3429, 0.1905), (0.0, 0.0, 0.19525), 10.0, RED)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.5334, 0.381, 0.02), (0.0, 0.0, 0.300025), 0.0, BLACK)
        for name, (x, y) in WHEELS.items():
            self.add_wheel(name, (x, y, AXLE_HEIGHT), TIRE)
        self.devices.append(SonarRing(self, chassis, PIONEER2AT_RING))
