"""Outlines of regions in an image, as polygons with few corners."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

__all__ = ["outlines", "simplified"]

_T = TypeVar("_T", bound=np.generic)

# Sides of a pixel: each leads clockwise to the next, with the pixel on its right. Rows grow downwards.
TOP, RIGHT, BOTTOM, LEFT = range(4)
_OUTWARD = ((-1, 0), (0, 1), (1, 0), (0, -1))  # (rows, columns) to the pixel beyond each side
_START = ((0, 0), (0, 1), (1, 1), (1, 0))  # (row, column) of the corner where each side begins


def outlines(mask: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """The borders between true and false pixels; the image is surrounded by false ones.

    Each is a closed polygon of pixel corners, (row, column), shape (n, 2), with the true pixels on its right; pixels
    that touch only at a corner are separate. Corner (0, 0) is the upper left corner of the first pixel.
    """
    filled = np.pad(mask.astype(bool), 1)
    columns = filled.shape[1]
    following = _following_sides(filled).tolist()
    left = bytearray(4 * filled.size)
    for side, step in enumerate(_OUTWARD):
        border = filled & ~_beyond(filled, step)
        left[side * filled.size : (side + 1) * filled.size] = border.tobytes()
    found = []
    first = left.find(1)
    while first >= 0:
        corners: list[int] = []
        edge = first
        while left[edge]:
            left[edge] = 0
            after = following[edge]
            if after // filled.size != edge // filled.size:  # the direction changes: a corner
                corners.append(after)
            edge = after
        sides, pixels = np.divmod(np.array(corners), filled.size)
        start = np.array(_START)[sides]
        found.append(np.stack(np.divmod(pixels, columns), axis=1) + start - 1)
        first = left.find(1, first)
    return found


def _following_sides(filled: NDArray[np.bool_]) -> NDArray[np.int64]:
    """For each side of each filled pixel, side * pixels + pixel, the next side of its border."""
    pixels = np.arange(filled.size).reshape(filled.shape)
    following = np.zeros((4, *filled.shape), dtype=np.int64)
    for side, outward in enumerate(_OUTWARD):
        ahead = _OUTWARD[(side + 1) % 4]
        around = (side + 1) % 4 * filled.size + pixels  # the pixel's own next side
        straight = side * filled.size + _beyond(pixels, ahead)
        inward = (side - 1) % 4 * filled.size + _beyond(pixels, ahead, outward)
        blocked = _beyond(filled, ahead)
        following[side] = np.where(~blocked, around, np.where(_beyond(filled, ahead, outward), inward, straight))
    return following.ravel()


def _beyond(values: NDArray[_T], *steps: tuple[int, int]) -> NDArray[_T]:
    """For each pixel, the value of the one that lies `steps` (rows, columns) from it."""
    return np.roll(values, [-sum(parts) for parts in zip(*steps, strict=True)], (0, 1))


def simplified(polygon: NDArray[np.int64], tolerance: float) -> NDArray[np.int64]:
    """A subset of a closed polygon's corners such that every omitted corner is within `tolerance`, shape (k, 2).

    The method is that of Douglas and Peucker (1973), from the first corner and the one farthest from it. A polygon
    smaller than the tolerance is reduced to two points.
    """
    closed = np.concatenate([polygon, polygon[:1]]).astype(np.float64)
    far = int(np.argmax(np.linalg.norm(closed - closed[0], axis=1)))
    keep = {0, far}
    spans = [(0, far), (far, len(polygon))]
    while spans:
        first, last = spans.pop()
        if last - first < 2:
            continue
        distances = _distances(closed[first + 1 : last], closed[first], closed[last])
        worst = int(np.argmax(distances))
        if distances[worst] > tolerance:
            middle = first + 1 + worst
            keep.add(middle)
            spans += [(first, middle), (middle, last)]
    return polygon[sorted(keep)]


def _distances(points: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Distances of points from the line segment a b, shape (n,)."""
    along = b - a
    share = np.clip((points - a) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    result: NDArray[np.float64] = np.linalg.norm(points - a - share[:, None] * along, axis=1)
    return result
