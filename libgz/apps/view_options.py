"""Options shared by the commands that render: a camera's pose, image size, and the OpenGL implementation."""

from __future__ import annotations

import math

from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzVector

__all__ = ["GL_HELP", "pose", "size"]

MOST = 16384  # [px] per side, Mesa's limit
GL_HELP = "OpenGL used for rendering: auto tries osmesa, then egl; none disables rendering; cameras produce no images "
GL_HELP += "(default: LIBGZ_GL, else auto)"


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
