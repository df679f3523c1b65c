"""Odometry: the pose that a robot computes from the travel of its wheels."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.interfaces.position import PositionData
from libgz.ode.records import OdometryRecord
from libgz.simulation.updates import Exchange

__all__ = ["Odometry"]


class Odometry(OdometryRecord):
    """Pose and velocity by dead reckoning. Starts at zero; moving the model by other means does not change it.

    Attributes:
        pose: x [m], y [m], yaw [rad].
        velocity: forward [m/s], turning [rad/s].
    """

    STATE: ClassVar[tuple[str, ...]] = ("pose", "velocity")

    def advance(self, travel: float, turn: float, step: float) -> None:
        """Add a travel [m] in the present direction and then a turn [rad], made in a step [s]."""
        pose = self.pose
        pose[0] += travel * math.cos(pose[2])
        pose[1] += travel * math.sin(pose[2])
        pose[2] += turn
        self.velocity = (travel / step, turn / step)

    def publish(self, data: PositionData) -> None:
        """Write pose and velocity to the interface."""
        pos, vel_pos = data.pos, data.vel_pos
        pos[0], pos[1], data.rot[2] = self.pose
        vel_pos[0], data.vel_rot[2] = self.velocity

    def share(self, exchange: Exchange) -> None:
        """Describe `publish` as numbers of an exchange."""
        exchange.doubles("pos", (self, "pose"), 2)
        exchange.doubles("rot", (self, "pose", 2), index=2)
        exchange.doubles("vel_pos", (self, "velocity"))
        exchange.doubles("vel_rot", (self, "velocity", 1), index=2)
