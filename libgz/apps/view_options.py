"""What the commands that draw share: a free camera's place and size on the command line."""

from __future__ import annotations

from libgz.geometry import GzPose, GzQuaternFromEuler, GzVector

__all__ = ["pose", "size"]


def size(text: str) -> tuple[int, int]:
    """``640x480``: width and height [px]."""
    width, height = (int(part) for part in text.lower().split("x"))
    if min(width, height) < 1:
        raise ValueError
    return width, height


def pose(text: str) -> GzPose:
    """``x y z roll pitch yaw`` [m], [rad]."""
    x, y, z, roll, pitch, yaw = map(float, text.split())
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


size.__name__ = "WxH"
