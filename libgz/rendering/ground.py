"""Ground: a plane as rings around the point below the camera, each with one level of its texture.

Mesa's software rasteriser takes as long to find the mipmap level of a pixel as to fetch it. On a plane the level
follows from the distance alone: its borders are circles, and a ring between two of them needs one image only.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from libgz.rendering.mesh import Mesh, ring
from libgz.rendering.shot import View

__all__ = ["Sight", "rings"]

SECTORS = 16  # of each ring
FIRST, GROWTH = (
    2.0,
    2.0,
)  # most width of a ring [m], or of its inner radius; light is computed at vertices
STEPS = 8  # per doubling of a rounded number; at each, the borders of the levels move by a few per cent


class Sight(NamedTuple):
    """How a camera sees a plane, in rounded numbers, so that similar views share their rings.

    Attributes:
        height: of the camera above the plane [m].
        focal: focal length [px].
        reach: a distance from the camera's foot beyond which it sees nothing [m].
    """

    height: float
    focal: float
    reach: float

    @classmethod
    def of(cls, view: View, height: float) -> Sight:
        """The sight of a view from a height [m] above 0."""
        corner = math.hypot(view.width / 2.0, view.height / 2.0, view.focal) / view.focal
        reach = view.far * corner / math.cos(math.pi / SECTORS)
        return cls(_rounded(height, round), _rounded(view.focal, round), _rounded(reach, math.ceil))

    def borders(self, texel: float, count: int) -> list[float]:
        """Radii [m] of the circles between `count` levels of a texture with texels of that size [m].

        From one row of pixels to the next, a line of sight of length D moves on by D^2 / (height focal) on the plane.
        The borders are where that is sqrt(2), 2 sqrt(2) ... texels, as OpenGL has them; inside the camera's foot, 0.
        """
        squares = (self.height * self.focal * texel * 2.0 ** (k + 0.5) - self.height**2 for k in range(count - 1))
        return [math.sqrt(max(square, 0.0)) for square in squares]


def _rounded(value: float, to_whole: Callable[[float], int]) -> float:
    return float(2.0 ** (to_whole(STEPS * math.log2(value)) / STEPS))


def rings(sight: Sight, texel: float, count: int, texture_size: tuple[float, float]) -> list[tuple[int, Mesh]]:
    """The plane around the camera's foot, facing +z: levels of texture from 0 to `count` - 1, and what each covers.

    Args:
        sight: the camera's.
        texel: size of a texel of level 0 [m].
        count: of levels; 1 if there is no texture.
        texture_size: extent of one image [m].
    """
    ends = [min(border, sight.reach) for border in sight.borders(texel, count)] + [sight.reach]
    found = []
    for level, (start, end) in enumerate(itertools.pairwise([0.0, *ends])):
        if end > start:
            radii = [start]
            while radii[-1] < end:
                radii.append(min(max(FIRST, GROWTH * radii[-1]), end))
            found.append((level, ring(np.array(radii), SECTORS, texture_size)))
    return found
