"""Polygons in the plane, cut into triangles and extruded to solids."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError

__all__ = ["extrude", "triangulate"]

Points = NDArray[np.float64]


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
        ParameterError: its sides cross each other.
    """
    left, triangles = list(range(len(points))), []
    while len(left) > 3:
        for k in range(len(left)):
            i, j, n = left[k - 1], left[k], left[(k + 1) % len(left)]
            a, b, c = points[i], points[j], points[n]
            if _cross(a, b, c) <= 0.0 or _any_inside(points[left], a, b, c):
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
    return abs(_cross(a, b, c)) < 1e-12


def _bridged(outer: Points, hole: Points) -> Points:
    """One polygon that goes around the outside, along a bridge to a hole, around that, and back."""
    clockwise = hole if _area(hole) < 0.0 else hole[::-1]
    start = int(np.argmax(clockwise[:, 0]))
    clockwise = np.roll(clockwise, -start, axis=0)
    far = np.linalg.norm(outer - clockwise[0], axis=1)
    for at in np.argsort(far).tolist():
        if _sees(clockwise[0], outer[at], [outer, clockwise]):
            ring = [outer[: at + 1], clockwise, clockwise[:1], outer[at : at + 1], outer[at + 1 :]]
            return np.concatenate(ring)
    raise ParameterError("the sides of a polyline cross each other")


def _sees(a: Points, b: Points, rings: list[Points]) -> bool:
    """Whether no side of any polygon crosses the way between two of their corners."""
    for ring in rings:
        for p, q in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            apart = _cross(a, b, p) * _cross(a, b, q) < 0.0 and _cross(p, q, a) * _cross(p, q, b) < 0.0
            if apart:
                return False
    return True


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
        if len(polygon) < 3 or abs(_area(polygon)) < 1e-12:
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
    outline = polygons[0] if _area(polygons[0]) > 0.0 else polygons[0][::-1]
    for hole in sorted(polygons[1:], key=lambda p: -float(p[:, 0].max())):
        outline = _bridged(outline, hole)
    cap = triangulate(outline)
    count = len(outline)
    low = np.column_stack([outline, np.zeros(count)])
    high = np.column_stack([outline, np.full(count, height)])
    i = np.arange(count)
    j = np.roll(i, -1)
    walls = np.concatenate([np.stack([i, j, j + count], axis=1), np.stack([i, j + count, i + count], axis=1)])
    return np.concatenate([low, high]), np.concatenate([cap[:, ::-1], cap + count, walls])
