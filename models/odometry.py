"""Odometry: the pose that a robot computes from the travel of its wheels."""

from __future__ import annotations

import ctypes
from typing import Any, ClassVar

from libgz.base.law import cos, law, sin
from libgz.base.records import numbers
from libgz.interfaces.position import PositionData

__all__ = ["Odometry"]


class Odometry(ctypes.Structure):
    """Pose and velocity by dead reckoning. Starts at zero; moving the model by other means does not change it.

    Attributes:
        pose: x [m], y [m], yaw [rad].
        velocity: forward [m/s], turning [rad/s].
    """

    STATE: ClassVar[tuple[str, ...]] = ("pose", "velocity")

    _fields_ = [("pose", numbers(3)), ("velocity", numbers(2))]

    pose: Any
    velocity: Any

    @law
    def advance(self, travel: float, turn: float, step: float) -> None:
        """Add a travel [m] in the present direction and then a turn [rad], made in a step [s]."""
        pose = self.pose
        pose[0] += travel * cos(pose[2])
        pose[1] += travel * sin(pose[2])
        pose[2] += turn
        self.velocity = (travel / step, turn / step)

    @law
    def publish(self, data: PositionData) -> None:
        """Write pose and velocity to the interface."""
        pos, vel_pos = data.pos, data.vel_pos
        pos[0], pos[1], data.rot[2] = self.pose
        vel_pos[0], data.vel_rot[2] = self.velocity
