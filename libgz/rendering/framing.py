"""Framing: where a camera stands so that bodies, or all of a world, fill its image."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzVector
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import DomeGeom, FrustrumGeom, LightGeom, PlaneGeom, RayGeom
from libgz.rendering.camera import Camera
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.scene import SceneWorld
from libgz.rendering.shot import pose_matrix
from libgz.rendering.skin import read_skin

__all__ = ["framed", "free_camera", "overview", "visible_points"]

SEGMENTS = 16
FIELD_OF_VIEW = math.radians(60.0)  # horizontal
AZIMUTH, ELEVATION = math.radians(215.0), math.radians(30.0)  # of the side from which an overview looks
LARGE, REACH = 5.0, 20.0  # times the median distance, at least this [m]; an overview leaves out what lies farther
SHARE = 0.7  # of the image, that an overview fills; the rest shows what stands around
NOTHING = np.array([[-1.0, -1.0, 0.0], [1.0, 1.0, 1.0]])  # what an overview of an empty world looks at [m]
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
    hfov: float = FIELD_OF_VIEW,
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


def overview(world: SceneWorld, size: tuple[int, int] = (640, 480), hfov: float = FIELD_OF_VIEW) -> GzPose:
    """The pose of a camera that sees all that moves in a world, or all of it if nothing can, from the side and above.

    What is far from all else is left out.

    Args:
        world: the world.
        size: width and height of the image [px].
        hfov: horizontal field of view [rad].
    """
    bodies = list(dict.fromkeys(geom.body for geom in world.engine.geoms.values()))
    seen = [(body, points) for body in bodies if len(points := _finite(visible_points([body])))]
    chosen = [points for body, points in seen if not body.dummy] or [points for _, points in seen] or [NOTHING]
    centres = np.array([(points.min(axis=0) + points.max(axis=0)) / 2.0 for points in chosen])
    distances = np.linalg.norm(centres - np.median(centres, axis=0), axis=1)
    limit = max(LARGE * float(np.median(distances)), REACH)
    near = [points for points, distance in zip(chosen, distances, strict=True) if distance <= limit or len(chosen) < 3]
    return framed(np.concatenate(near), AZIMUTH, ELEVATION, size, hfov, SHARE)


def _finite(points: NDArray[np.float64]) -> NDArray[np.float64]:
    return points[np.isfinite(points).all(axis=1)]


def free_camera(world: SceneWorld, pose: GzPose, size: tuple[int, int] = (640, 480), shadows: bool = False) -> Camera:
    """A camera at any pose, with the field of view of an overview, which reaches as far as that looks.

    Args:
        world: the world.
        pose: of the camera, which looks along x [m].
        size: width and height of its images [px].
        shadows: whether they are rendered with shadows, unless an SDF scene forbids them.

    Raises:
        LibraryError: OpenGL does not work here.
        ParameterError: the size is out of range.
    """
    far = max(200.0, 4.0 * abs(pose.pos.z), 2.0 * max(map(abs, pose.pos)))
    camera = Camera(world, *size, FIELD_OF_VIEW, 0.05, far)
    camera.SetPose(pose)
    camera.options.shadows = shadows
    return camera
