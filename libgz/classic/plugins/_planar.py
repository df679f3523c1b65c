"""PlanarMotion: velocities that move a model in the plane, without wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, hypot, law, where
from libgz.classic.math import Vector3d

if TYPE_CHECKING:
    from libgz.base.geometry import GzQuatern
    from libgz.classic.physics import Model

__all__ = ["PlanarMotion", "heading"]


def heading(turn: GzQuatern) -> tuple[Any, Any]:
    """Cosine and sine of the yaw of a rotation; where it has none, those of 0."""
    w, x, y, z = turn
    cosine, sine = w * w + x * x - y * y - z * z, 2.0 * (w * z + x * y)  # each times its length
    length = hypot(cosine, sine)
    turned = length > 0.0
    divisor = where(turned, length, 1.0)
    return where(turned, cosine / divisor, 1.0), where(turned, sine / divisor, 0.0)


class PlanarMotion:
    """Velocities of a model, along its own axes, as they were commanded; it neither falls nor tilts.

    Args:
        model: the model.
        timeout: it stops when no command has come for this time [s]; infinity: never.
    """

    STATE = ("forward", "left", "turn", "time")

    forward, left = Number(), Number()  # [m/s]
    turn = Number()  # [rad/s]
    time = Number()  # of the last command [s]

    def __init__(self, model: Model, timeout: float = math.inf) -> None:
        self.model, self.timeout = model, timeout

    def command(self, forward: float, left: float, turn: float, now: float) -> None:
        """Take a command [m/s], [rad/s] at sim time `now` [s]."""
        self.forward, self.left, self.turn, self.time = forward, left, turn, now

    @law
    def move(self, now: Any) -> None:
        """Set the velocities of sim time `now` [s]."""
        forward, left, turn = self.forward, self.left, self.turn
        if self.timeout < math.inf:
            late = now - self.time > self.timeout
            forward, left, turn = where(late, 0.0, forward), where(late, 0.0, left), where(late, 0.0, turn)
        cosine, sine = heading(self.model.WorldPose().Rot())
        self.model.SetLinearVel(Vector3d(forward * cosine - left * sine, left * cosine + forward * sine, 0.0))
        self.model.SetAngularVel(Vector3d(0.0, 0.0, turn))
