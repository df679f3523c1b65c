"""Disparities of two cameras side by side, from what is ahead of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["disparities"]

Depths = NDArray[np.float32]

HIDDEN = 1.0  # [px]; difference of disparities from which on a nearer point occludes another


def disparities(left: Depths, right: Depths, focal: float, baseline: float) -> tuple[Depths, Depths]:
    """Disparities of a left and a right image [px]; 0 where the point is not visible to the other camera.

    Args:
        left, right: distance ahead of each camera, along its axis [m], shape (height, width).
        focal: focal length [px].
        baseline: distance between the optical centres [m].
    """
    shifts = [np.float32(focal * baseline) / depth for depth in (left, right)]
    return _seen_by_both(shifts[0], shifts[1], -1.0), _seen_by_both(shifts[1], shifts[0], 1.0)


def _seen_by_both(own: Depths, other: Depths, sign: float) -> Depths:
    """`own` disparities, 0 where the point lies outside the other image or is occluded in it.

    Args:
        own, other: disparities of both images.
        sign: of the shift from a column of the own image to a column of the other.
    """
    width = own.shape[1]
    columns = np.rint(np.arange(width) + sign * own).astype(np.int64)
    inside = (columns >= 0) & (columns < width)
    there = np.take_along_axis(other, np.clip(columns, 0, width - 1), axis=1)
    return np.where(inside & (there <= own + HIDDEN), own, np.float32(0.0))
