"""Pioneer2DX: ActivMedia's two-wheeled indoor robot with a caster."""

from __future__ import annotations

from libgz.models.drive import DifferentialRobot
from libgz.models.parts import BLACK, DARK, RED, add_body, fit
from libgz.models.sonars import PIONEER2DX_RING, SonarRing
from libgz.models.wheels import Tire, add_caster
from libgz.physics.geoms import BoxGeom

TIRE = Tire(0.095, 0.05, 0.5, DARK)


class Pioneer2DX(DifferentialRobot):
    """ActivMedia's indoor robot: two driven wheels, a ball caster, sixteen sonars.

    The origin is the centre of the top plate above the axle.
    Its yaw stays within +-pi.
    """

    interfaces = ("position", "power", "sonar")
    example = """
        <model:Pioneer2DX>
          <id>robot1</id>
          <xyz>0 0 0.24</xyz>
        </model:Pioneer2DX>
    """
    wheelSep, wheelDiam = 0.35, 0.19
    maxTorque = 1.1
    normaliseYaw = True

    def build(self) -> None:  # noqa: D102
        chassis = add_body(self)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.38, 0.27, 0.17), (-0.05, 0.0, -0.085), 5.0, RED)
        fit(BoxGeom(chassis, self.modelSpaceId, 0.45, 0.38, 0.005), (-0.05, 0.0, 0.0), 0.0, BLACK)
        self.add_pair(0.175, -0.145, TIRE)
        # Its mass keeps the robot from pitching forward when it brakes.
        add_caster(self, "caster", chassis, (-0.22, 0.0, -0.2), 0.04, 5.0, BLACK)
        self.devices.append(SonarRing(self, chassis, PIONEER2DX_RING))
