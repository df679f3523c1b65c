"""What the commands that draw share: a free camera's place and size on the command line."""

from __future__ import annotations

import math

from libgz.geometry import GzPose, GzQuaternFromEuler, GzVector

__all__ = ["pose", "size"]

MOST = 16384  # [px] a side: what Mesa draws


def size(text: str) -> tuple[int, int]:
    """``640x480``: width and height [px]."""
    width, height = (int(part) for part in text.lower().split("x"))
    if not (1 <= width <= MOST and 1 <= height <= MOST):
        raise ValueError
    return width, height


def pose(text: str) -> GzPose:
    """``x y z roll pitch yaw`` [m], [rad]."""
    x, y, z, roll, pitch, yaw = numbers = tuple(map(float, text.split()))
    if not all(map(math.isfinite, numbers)):
        raise ValueError
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


size.__name__ = "WxH"
