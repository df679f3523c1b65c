"""Polygons in the plane, cut into triangles and extruded to solids."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError

__all__ = ["extrude", "joined", "triangulate"]

Points = NDArray[np.float64]

MOST_WORK = 10**8  # of cutting one polygon, in points that are looked at: some seconds
FOR_TURN, FOR_EAR = 50, 1000  # work of looking at a corner, and at whether it may be cut off, beside that of each point
ON_SIDE = 1e-12  # twice an area, up to which three points lie on a line


def _cross(a: Points, b: Points, c: Points) -> float:
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _area(points: Points) -> float:
    """Twice the area, positive for a polygon that goes counter-clockwise."""
    x, y = points[:, 0], points[:, 1]
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _any_inside(points: Points, *corners: Points) -> bool:
    """Whether one of several points lies in a triangle, or on a side of it; its corners do not count."""
    inside = ~np.any([(points == corner).all(axis=1) for corner in corners], axis=0)
    x, y = points.T
    for p, q in zip(corners, (*corners[1:], corners[0]), strict=True):
        inside &= (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) >= 0.0
    return bool(inside.any())


def triangulate(points: Points) -> NDArray[np.int64]:
    """Triangles of a simple polygon that goes counter-clockwise, by cutting off ears (Meisters, 1975); shape (m, 3).

    Raises:
        ParameterError: its sides cross each other, or it takes too long: it has too many corners.
    """
    left, triangles, work = list(range(len(points))), [], 0
    while len(left) > 3:
        for k in range(len(left)):
            i, j, n = left[k - 1], left[k], left[(k + 1) % len(left)]
            a, b, c = points[i], points[j], points[n]
            turns = _cross(a, b, c) > 0.0
            work += FOR_EAR + len(left) if turns else FOR_TURN
            if work > MOST_WORK:
                raise ParameterError(f"a polyline of {len(points)} corners takes too long to be cut into triangles")
            if not turns or _any_inside(points[left], a, b, c):
                continue
            triangles.append((i, j, n))
            del left[k]
            break
        else:
            flat = next((k for k in range(len(left)) if _is_flat(points, left, k)), None)
            if flat is None:
                raise ParameterError("the sides of a polyline cross each other")
            del left[flat]
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64)


def _is_flat(points: Points, left: list[int], k: int) -> bool:
    a, b, c = points[left[k - 1]], points[left[k]], points[left[(k + 1) % len(left)]]
    return abs(_cross(a, b, c)) < ON_SIDE


def joined(points: Points, rings: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """One ring of corners, counter-clockwise: around an outline, and along bridges around the holes in it.

    Args:
        points: of all rings, shape (n, 2).
        rings: numbers of points, the outline first, in any order around.

    Raises:
        ParameterError: their sides cross each other.
    """
    ring = rings[0] if _area(points[rings[0]]) > 0.0 else rings[0][::-1]
    holes = sorted(rings[1:], key=lambda inner: -float(points[inner, 0].max()))  # each sees what is joined already
    for number, hole in enumerate(holes, 1):
        ring = _bridged(points, ring, hole, holes[number:])
    return ring


def _bridged(
    points: Points, outer: NDArray[np.int64], hole: NDArray[np.int64], others: list[NDArray[np.int64]]
) -> NDArray[np.int64]:
    """One ring that goes around the outside, along a bridge to a hole, which no other hole crosses, and back."""
    inner = hole if _area(points[hole]) < 0.0 else hole[::-1]
    inner = np.roll(inner, -int(np.argmax(points[inner, 0])))
    far = np.linalg.norm(points[outer] - points[inner[0]], axis=1)
    starts, ends = (
        np.concatenate([points[np.roll(ring, -shift)] for ring in (outer, inner, *others)]) for shift in (0, 1)
    )
    for at in np.argsort(far, kind="stable").tolist():
        around = points[outer[[at - 1, at, (at + 1) % len(outer)]]]
        if _opens_to(points[inner[0]], *around) and _sees(points[inner[0]], points[outer[at]], starts, ends):
            return np.concatenate([outer[: at + 1], inner, inner[:1], outer[at : at + 1], outer[at + 1 :]])
    raise ParameterError("the sides of a polyline cross each other")


def _opens_to(point: Points, before: Points, corner: Points, after: Points) -> bool:
    """Whether a point lies between the sides of a corner; where bridges meet, several corners are at one place."""
    inside = _cross(before, corner, point) >= 0.0, _cross(corner, after, point) >= 0.0
    return all(inside) if _cross(before, corner, after) >= 0.0 else any(inside)


def _sees(a: Points, b: Points, starts: Points, ends: Points) -> bool:
    """Whether no side crosses the way between two corners, and no corner lies on it."""
    (ax, ay), (bx, by), (px, py), (qx, qy) = a, b, starts.T, ends.T
    along = (starts - a) @ (b - a)
    on = np.abs((bx - ax) * (py - ay) - (by - ay) * (px - ax)) <= ON_SIDE
    if (on & (along > ON_SIDE) & (along < (b - a) @ (b - a) - ON_SIDE)).any():
        return False
    beside = [(bx - ax) * (y - ay) - (by - ay) * (x - ax) for x, y in ((px, py), (qx, qy))]
    around = [(qx - px) * (y - py) - (qy - py) * (x - px) for x, y in ((ax, ay), (bx, by))]
    return not ((beside[0] * beside[1] < 0.0) & (around[0] * around[1] < 0.0)).any()


def _holds(outer: Points, inner: Points) -> bool:
    """Whether most corners of a polygon lie inside another one."""
    x, y = inner[:, 0:1], inner[:, 1:2]
    (ax, ay), (bx, by) = outer.T, np.roll(outer, -1, axis=0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
    return bool((crossed.sum(axis=1) % 2).mean() > 0.5)


def _shapes(polygons: list[Points]) -> list[list[Points]]:
    """Outlines, each with the holes in it: what lies in an even number of others is solid, in an odd number a hole."""
    around = [[k for k, other in enumerate(polygons) if other is not p and _holds(other, p)] for p in polygons]
    shapes = {k: [polygons[k]] for k, outside in enumerate(around) if len(outside) % 2 == 0}
    for k, outside in enumerate(around):
        if k not in shapes:
            shapes[max((m for m in outside if m in shapes), key=lambda m: len(around[m]))].append(polygons[k])
    return list(shapes.values())


def extrude(rings: list[ArrayLike], height: float) -> tuple[Points, NDArray[np.int64]]:
    """Solids between z = 0 and the height [m] with polygons as outlines; a polygon inside another one is a hole in it.

    Returns:
        (vertices [m], shape (n, 3); triangles, counter-clockwise seen from outside, shape (m, 3)).

    Raises:
        ParameterError: a polygon has fewer than three corners, no area, or crossing sides.
    """
    polygons = [np.array(ring, dtype=np.float64).reshape(-1, 2) for ring in rings]
    polygons = [p[:-1] if len(p) > 1 and (p[0] == p[-1]).all() else p for p in polygons]
    for polygon in polygons:
        if len(polygon) < 3 or abs(_area(polygon)) < ON_SIDE:
            raise ParameterError("a polyline needs three points that span an area")
    vertices, triangles, count = [], [], 0
    for shape in _shapes(polygons):
        points, faces = _extrude(shape, height)
        vertices.append(points)
        triangles.append(faces + count)
        count += len(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def _extrude(polygons: list[Points], height: float) -> tuple[Points, NDArray[np.int64]]:
    """The solid of one outline, and of the holes in it."""
    ends = np.cumsum([0, *map(len, polygons)])
    rings = [np.arange(start, end) for start, end in pairwise(ends.tolist())]
    points = np.concatenate(polygons)
    outline = points[joined(points, rings)]
    cap = triangulate(outline)
    count = len(outline)
    low = np.column_stack([outline, np.zeros(count)])
    high = np.column_stack([outline, np.full(count, height)])
    i = np.arange(count)
    j = np.roll(i, -1)
    walls = np.concatenate([np.stack([i, j, j + count], axis=1), np.stack([i, j + count, i + count], axis=1)])
    return np.concatenate([low, high]), np.concatenate([cap[:, ::-1], cap + count, walls])
