"""The overlay of an image: bounding boxes, axes, centres of mass, rays, frusta; all as lines."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.geoms import FrustrumGeom, RayGeom
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.shot import Lines, View, pose_matrix

__all__ = ["overlay_lines"]

AXIS_LENGTH, COM_SIZE = 0.3, 0.05  # [m]
RED, GREEN, BLUE, YELLOW, WHITE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0)
CORNERS = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
EDGES = [(a, b) for a, b in itertools.combinations(range(8), 2) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1.0]


def overlay_lines(view: View, engine: Engine) -> tuple[Lines, ...]:
    """The lines that a view's options request."""
    options, found = view.options, []
    wanted = (
        options.displayBBox, options.displayAxes, options.displayCoM, options.displayRays, options.displayFrustrums
    )  # fmt: skip
    if not any(wanted):
        return ()
    geoms = list(engine.geoms.values())
    bodies = list(dict.fromkeys(geom.body for geom in geoms))
    if options.displayBBox:
        found.append((YELLOW, [_box(geom) for geom in geoms]))
    if options.displayAxes:
        for axis, color in enumerate((RED, GREEN, BLUE)):
            found.append((color, [_axis(body, axis) for body in bodies if body.bodyName]))
    if options.displayCoM:
        found.append((WHITE, [_com(body) for body in bodies if not body.dummy]))
    if options.displayRays:
        ends = [_ray(geom) for geom in geoms if isinstance(geom, RayGeom)]
        ends += [bundle.segments().reshape(-1, 3) for bundle in engine.ray_bundles]
        found.append((BLUE, ends))
    if options.displayFrustrums:
        found.append((GREEN, [_frustum(geom) for geom in geoms if isinstance(geom, FrustrumGeom)]))
    result = []
    for color, parts in found:
        ends = [part for part in parts if len(part)]
        if ends:
            result.append(Lines(np.ascontiguousarray(np.concatenate(ends), dtype=np.float32), color))
    return tuple(result)


def _placed(points: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _box(geom: Geom) -> NDArray[np.float64]:
    """The box around a geom, along its own axes."""
    vertices = [shape.vertices for shape in meshes_of(geom, 12)]
    if not vertices:
        return np.zeros((0, 3))
    points = np.concatenate(vertices)
    low, high = points.min(axis=0), points.max(axis=0)
    corners = low + CORNERS * (high - low)
    return _placed(corners[np.array(EDGES).ravel()], pose_matrix(geom.GetPose()))


def _axis(body: Body, axis: int) -> NDArray[np.float64]:
    return _placed(np.array([np.zeros(3), AXIS_LENGTH * np.eye(3)[axis]]), pose_matrix(body.GetPose()))


def _com(body: Body) -> NDArray[np.float64]:
    """A cross at the centre of mass."""
    arms = np.concatenate([np.array([-a, a]) for a in COM_SIZE * np.eye(3)])
    return _placed(arms, pose_matrix(body.GetCoMPose()))


def _ray(geom: RayGeom) -> NDArray[np.float64]:
    start, direction = (np.array(v) for v in geom.Get())
    return np.array([start, start + min(geom.GetLength(), geom.depth) * direction])


def _frustum(geom: FrustrumGeom) -> NDArray[np.float64]:
    """Near and far rectangles, and the edges between."""
    wide = math.tan(geom.fov / 2.0)
    sides = np.array([(1.0, s * wide, t * wide / geom.aspect) for s, t in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
    near, far = sides * geom.near_clip, sides * geom.far_clip
    ends = []
    for i in range(4):
        j = (i + 1) % 4
        ends += [near[i], near[j], far[i], far[j], near[i], far[i]]
    return _placed(np.array(ends), pose_matrix(geom.GetPose()))
