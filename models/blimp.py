"""Blimp: the University of Pennsylvania's airship, nine metres long.

Of the original source only the kinds of its shapes are known. Dimensions, masses and flight dynamics were chosen for
libgz.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

from libgz.base.geometry import GzColor, GzCoordPoseSub, GzPose, GzQuaternFromAxis, GzQuaternToEuler
from libgz.base.law import Value, clamp, law
from libgz.interfaces.position import PositionData
from libgz.models.motion import Motion
from libgz.models.parts import GREY, add_body, fit
from libgz.models.robot import MobileRobot, RobotAttributes
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom
from libgz.worldfile.attributes import boolean, declaration
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

RADIUS, LENGTH = 1.15, 6.7  # [m], of the envelope's cylinder, which has a hemisphere at each end
ENVELOPE_MASS, END_MASS, GONDOLA_MASS = 12.0, 4.0, 10.0  # [kg]
SILVER = GzColor(0.85, 0.85, 0.9)
DRAG, MAX_THRUST = 15.0, 20.0  # [N s/m], [N], along each axis
YAW_GAIN, MAX_YAW_TORQUE = 40.0, 40.0  # [N m s/rad], [N m]
RIGHTING, DAMPING = 60.0, 40.0  # [N m/rad], [N m s/rad]: the gondola hangs below


@declaration
class BlimpAttributes(RobotAttributes):
    """Attributes of `<model:Blimp>`."""

    is3d: bool = boolean(False, help="without effect: the position always has three dimensions")


class Blimp(MobileRobot):
    """A neutrally buoyant airship; models that are attached to it pull it down by their weight.

    The origin is the centre of the envelope. Serves position: the true pose, relative to the start. It obeys
    cmd_vel_pos[0], forward, cmd_vel_pos[2], up, and cmd_vel_rot[2]. Dimensions and layout chosen for libgz.
    """

    STATE: ClassVar[tuple[str, ...]] = ("start", "motion")

    behaviour = "thrust, drag, and the torque that keeps it upright (it drifts and turns freely); odometry"
    example = """
    <model:Blimp>
      <id>robot1</id>
      <xyz>0 0 10</xyz>
    </model:Blimp>
    """

    attributes: ClassVar[type[RobotAttributes]] = BlimpAttributes
    commands = (("cmd_vel_pos", 0), ("cmd_vel_rot", 2), ("cmd_vel_pos", 2))

    def build(self) -> None:  # noqa: D102
        hull = add_body(self)
        space = self.modelSpaceId
        along_x = GzQuaternFromAxis(0.0, 1.0, 0.0, math.pi / 2.0)
        fit(CylinderGeom(hull, space, RADIUS, LENGTH), (0.0, 0.0, 0.0), ENVELOPE_MASS, SILVER, along_x)
        for x in (LENGTH / 2.0, -LENGTH / 2.0):
            fit(SphereGeom(hull, space, RADIUS), (x, 0.0, 0.0), END_MASS, SILVER)
        fit(BoxGeom(hull, space, 0.8, 0.4, 0.3), (0.0, 0.0, -1.3), GONDOLA_MASS, GREY)
        hull.SetGravityMode(False)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.motion = Motion()
        super().Load(file, node)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        super().Init(file, node)
        self.start = self.GetPose()
        self.measure(0.0)

    @law
    def measure(self, step: float) -> None:
        """Update the true pose, and the velocities in the hull's frame."""
        self.motion.measure(self.GetBody())

    @law
    def publish(self, data: PositionData) -> None:
        """The true pose relative to the start, and the velocities."""
        relative: GzPose = GzCoordPoseSub(self.motion.pose, self.start)
        data.pos[:] = tuple(relative.pos)
        data.rot[:] = tuple(GzQuaternToEuler(relative.rot))
        data.vel_pos[:] = self.motion.velocity[:]
        data.vel_rot[:] = self.motion.rate[:]

    @law
    def act(self, step: float) -> None:
        """Apply thrust, drag and the righting torque of the gondola."""
        motion, hull = self.motion, self.GetBody()
        force, torque = _efforts(self.position.wanted, motion.velocity, motion.rate, motion.attitude)
        hull.AddRelForce(*force)
        hull.AddRelTorque(*torque)


def _efforts(
    wanted: Sequence[Value],
    velocity: Sequence[Value],
    rate: Sequence[Value],
    attitude: Sequence[Value],
) -> tuple[tuple[Value, ...], tuple[Value, ...]]:
    """Force [N] and torque [N m] along the hull's axes."""
    forward, turn, up = wanted
    force = (
        clamp(DRAG * (forward - velocity[0]), MAX_THRUST),
        -DRAG * velocity[1],
        clamp(DRAG * (up - velocity[2]), MAX_THRUST),
    )
    torque = (
        -RIGHTING * attitude[0] - DAMPING * rate[0],
        -RIGHTING * attitude[1] - DAMPING * rate[1],
        clamp(YAW_GAIN * (turn - rate[2]), MAX_YAW_TORQUE),
    )
    return force, torque
