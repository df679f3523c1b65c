"""Framing: where a camera stands so that bodies fill its image."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from libgz.errors import GazeboError, ParameterError
from libgz.geometry import GzPose, GzQuaternFromEuler, GzVector
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.shot import pose_matrix
from libgz.rendering.skin import read_skin

__all__ = ["framed", "visible_points"]

SEGMENTS = 16
UNBOUNDED = (DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom)


def visible_points(bodies: Iterable[Body]) -> NDArray[np.float64]:
    """Corners of the rendered shapes of bodies, global [m], shape (n, 3); planes, lights and sky have none."""
    shown = [g for body in bodies for g in body.geoms if g.appearance.visible and not isinstance(g, UNBOUNDED)]
    found = [points for geom in shown for points in _points(geom)]
    return np.concatenate(found) if found else np.zeros((0, 3))


def _points(geom: Geom) -> Iterable[NDArray[np.float64]]:
    look, matrix = geom.appearance, pose_matrix(geom.GetPose())
    meshes = None
    if look.skin_file is not None:
        try:
            on_geom = pose_matrix(look.skin_pose)
            meshes = [part.scaled(*look.skin_scale).moved(on_geom) for part in read_skin(look.skin_file)]
        except GazeboError:  # reported when it is rendered
            meshes = None
    if meshes is None:
        meshes = [shape.scaled(*look.scale) for shape in meshes_of(geom, SEGMENTS)]
    return [shape.vertices @ matrix[:3, :3].T + matrix[:3, 3] for shape in meshes]


def framed(
    points: NDArray[np.float64],
    azimuth: float,
    elevation: float,
    size: tuple[int, int],
    hfov: float = math.radians(60.0),
    share: float = 0.9,
) -> GzPose:
    """The pose of a camera that looks at points from a side, so that they fill its image.

    Args:
        points: global [m], shape (n, 3).
        azimuth: of the side where the camera stands, counter-clockwise from +x [rad].
        elevation: of the camera above the horizontal [rad].
        size: width and height of the image [px].
        hfov: horizontal field of view [rad].
        share: of the image's width or height that the points fill, 0 to 1.

    Raises:
        ParameterError: there are no points.
    """
    if not len(points):
        raise ParameterError("there are no points to look at")
    turn = GzQuaternFromEuler(0.0, elevation, azimuth + math.pi)
    axes = pose_matrix(GzPose(GzVector(), turn))[:3, :3]  # columns: forward, left, up
    forward, *sides = (points @ axes).T
    wide = share * math.tan(hfov / 2.0)
    back, offsets = 0.1 - float(forward.min()), []
    for values, slope in zip(sides, (wide, wide * size[1] / size[0]), strict=True):
        # With the camera at -d, all |value - offset| <= slope (forward + d).
        above, below = float((values - slope * forward).max()), float((-values - slope * forward).max())
        offsets.append((above - below) / 2.0)
        back = max(back, (above + below) / (2.0 * slope))
    return GzPose(GzVector(*(axes @ (-back, *offsets)).tolist()), turn)
