"""Motion: how a robot's body moves, as its controllers see it."""

from __future__ import annotations

import ctypes
from typing import Any, ClassVar

from libgz.base.geometry import GzPose, GzQuatern, GzQuaternInverse, GzQuaternToEuler, GzVector, rotate
from libgz.base.law import law
from libgz.base.records import numbers
from libgz.physics.body import Body

__all__ = ["Motion"]


class Motion(ctypes.Structure):
    """How a body moved when it was last measured.

    Attributes:
        position: of the body frame [m].
        rotation: of the body frame, a quaternion.
        attitude: roll, pitch and yaw [rad].
        velocity: of the centre of mass, in the body's own axes [m/s].
        rate: angular velocity, in the body's own axes [rad/s].
        up: the body's z axis.
    """

    STATE: ClassVar[tuple[str, ...]] = ("position", "rotation", "attitude", "velocity", "rate", "up")

    _fields_ = [(name, numbers(4 if name == "rotation" else 3)) for name in STATE]

    position: Any
    rotation: Any
    attitude: Any
    velocity: Any
    rate: Any
    up: Any

    @property
    @law
    def pose(self) -> GzPose:
        """Of the body frame [m]."""
        return GzPose(GzVector(*self.position), GzQuatern(*self.rotation))

    @law
    def measure(self, body: Body) -> None:
        """Find how a body moves now."""
        pose = body.GetPose()
        inverse = GzQuaternInverse(pose.rot)
        self.position, self.rotation = tuple(pose.pos), tuple(pose.rot)
        self.attitude = tuple(GzQuaternToEuler(pose.rot))
        self.velocity = tuple(rotate(inverse, body.GetLinearVel()))
        self.rate = tuple(rotate(inverse, body.GetAngularRate()))
        self.up = tuple(rotate(pose.rot, (0.0, 0.0, 1.0)))
