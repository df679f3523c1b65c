"""Faces of mesh files as triangles: polygons of any shape, strips and fans.

All functions number corners: the corners of all faces, one face after another. Positions, normals and texture
coordinates of a corner are then cut alike.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.physics.outlines import joined, triangulate

__all__ = ["Effort", "cut_fans", "cut_polygons", "cut_strips"]

Corners = NDArray[np.int64]

MOST_CORNERS = 1000  # of a concave polygon that is cut; one with more is read as a fan
MOST_CUT = 50_000_000  # sum of the squares of the corners of concave polygons that are cut together; 10 s
ROUNDING = 1e-9  # of the squares of sides, below which a corner is straight


class Effort:
    """What may still be spent on the concave polygons of one mesh, whose faces are in groups."""

    def __init__(self) -> None:
        self._left = MOST_CUT

    def allows(self, corners: int) -> bool:
        """Whether a polygon of so many corners may be cut; it is counted."""
        self._left -= corners * corners
        return self._left >= 0


def cut_polygons(
    counts: Corners,
    points: NDArray[np.float64],
    holes: NDArray[np.bool_] | None = None,
    effort: Effort | None = None,
) -> Corners:
    """Triangles of polygons, in the order of the polygons, shape (m, 3).

    Convex polygons become fans of their first corners, concave ones and those with holes are cut by ears (Meisters,
    1975). What cannot be cut, since its sides cross or its corners do not lie in a plane, or is beyond MOST_CUT,
    becomes a fan, without its holes.

    Args:
        counts: of corners of each polygon; those with less than three have no triangle.
        points: positions of all corners [m], shape (n, 3).
        holes: which polygons are holes in the last one before that is none; None for no holes.
        effort: of the mesh; None if it has no other polygons.

    Raises:
        ValueError: the polygons have more corners than there are.
    """
    if counts.sum() > len(points) or (len(counts) and counts.min() < 0):
        raise ValueError(f"the faces name {counts.sum()} corners; there are {len(points)}")
    starts = np.cumsum(counts) - counts
    inner = _holes_by_outline(counts, holes) if holes is not None else {}
    plain = counts > 2
    if holes is not None:
        plain &= ~holes
    plain[list(inner)] = False
    found: list[tuple[Corners, Corners]] = []  # (polygon of each triangle, triangles)
    effort = effort or Effort()
    for polygon, around in inner.items():
        rings = [starts[k] + np.arange(counts[k]) for k in (polygon, *around)]
        cut = _cut_around(points, rings, effort.allows(sum(map(len, rings))))
        found.append((np.full(len(cut), polygon), cut))
    for count in np.unique(counts[plain]).tolist():
        which = np.flatnonzero(plain & (counts == count))
        corners = starts[which, None] + np.arange(count)
        concave = _are_concave(points[corners]) if count > 3 else np.zeros(len(which), dtype=bool)
        steps = np.arange(1, count - 1)
        fan = np.stack([np.zeros_like(steps), steps, steps + 1], axis=1)
        found.append((np.repeat(which[~concave], len(fan)), corners[~concave][:, fan].reshape(-1, 3)))
        for polygon, own in zip(which[concave].tolist(), corners[concave], strict=True):
            cut = own[_ears(points[own], fan) if effort.allows(count) else fan]
            found.append((np.full(len(cut), polygon), cut))
    if not found:
        return np.zeros((0, 3), dtype=np.int64)
    order = np.argsort(np.concatenate([polygons for polygons, _ in found]), kind="stable")
    triangles: Corners = np.concatenate([triangles for _, triangles in found])[order]
    return triangles


def _holes_by_outline(counts: Corners, holes: NDArray[np.bool_]) -> dict[int, list[int]]:
    """The holes of each polygon that has some."""
    found: dict[int, list[int]] = {}
    outlines = np.maximum.accumulate(np.where(holes, -1, np.arange(len(holes))))  # of each, the last one up to it
    for hole in np.flatnonzero(holes & (counts > 2) & (outlines >= 0) & (counts[outlines] > 2)).tolist():
        found.setdefault(int(outlines[hole]), []).append(hole)
    return found


def _cut_around(points: NDArray[np.float64], rings: list[Corners], allowed: bool) -> Corners:
    """Triangles of one polygon, the first ring, with holes."""
    own = np.concatenate(rings)
    fan = rings[0][cut_fans(np.array([len(rings[0])]))]
    if not allowed or len(own) > MOST_CORNERS:
        return fan
    ends = np.cumsum([0, *map(len, rings)])
    flat = _flat(points[own], _normals(points[rings[0]][None])[0])
    try:
        ring = joined(flat, [np.arange(start, end) for start, end in pairwise(ends.tolist())])
        return own[ring[triangulate(flat[ring])]]
    except ParameterError:
        return fan


def cut_strips(counts: Corners) -> Corners:
    """Triangles of strips of so many corners: each two of neighbouring triangles share a side, shape (m, 3)."""
    rows = [start + _strip(count) for start, count in zip(np.cumsum(counts) - counts, counts.tolist(), strict=True)]
    return np.concatenate(rows) if rows else np.zeros((0, 3), dtype=np.int64)


def _strip(count: int) -> Corners:
    first = np.arange(max(count - 2, 0))
    odd = first % 2  # every second one has its first two corners exchanged
    return np.stack([first + odd, first + 1 - odd, first + 2], axis=1)


def cut_fans(counts: Corners) -> Corners:
    """Triangles of fans of so many corners: all share the first one, shape (m, 3)."""
    rows = []
    for start, count in zip(np.cumsum(counts) - counts, counts.tolist(), strict=True):
        steps = np.arange(1, max(count - 1, 1))
        rows.append(start + np.stack([np.zeros_like(steps), steps, steps + 1], axis=1))
    return np.concatenate(rows) if rows else np.zeros((0, 3), dtype=np.int64)


def _normals(polygons: NDArray[np.float64]) -> NDArray[np.float64]:
    """Normals of polygons, twice their areas long (Newell); shape (k, 3)."""
    arms = polygons - polygons[:, :1]
    total: NDArray[np.float64] = np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1)
    return total


def _are_concave(polygons: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether polygons of equally many corners, shape (k, n, 3), turn back at a corner."""
    sides = np.roll(polygons, -1, axis=1) - polygons
    turns = np.cross(np.roll(sides, 1, axis=1), sides)
    normals = _normals(polygons)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    across = np.einsum("knj,kj->kn", turns, normals / np.where(lengths > 0.0, lengths, 1.0))
    result: NDArray[np.bool_] = (across < -ROUNDING * (sides**2).sum(axis=2).max(axis=1, keepdims=True)).any(axis=1)
    return result


def _ears(points: NDArray[np.float64], fan: Corners) -> Corners:
    """Triangles of one concave polygon, seen along its normal."""
    if len(points) > MOST_CORNERS:
        return fan
    try:
        return triangulate(_flat(points, _normals(points[None])[0]))
    except ParameterError:
        return fan


def _flat(points: NDArray[np.float64], normal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Corners as seen against a normal, along the axis that is next to it, within a unit square; shape (n, 2)."""
    axis = int(np.argmax(np.abs(normal)))
    flat = points[:, [(axis + 1) % 3, (axis + 2) % 3]]
    if normal[axis] < 0.0:
        flat = flat[:, ::-1]
    result: NDArray[np.float64] = (flat - flat.min(axis=0)) / np.ptp(flat, axis=0).max()
    return result
