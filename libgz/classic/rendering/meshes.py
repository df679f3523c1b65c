"""Shapes of visuals: their sizes, and the shapes that plugins attach by name."""

from __future__ import annotations

import logging
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import NotFoundError, nearest
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzVector, VectorLike
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.shot import pose_matrix
from libgz.sdf.element import Element
from libgz.sdf.materials import Material
from libgz.sdf.paths import find_uri
from libgz.sdfworld.mesh_images import found_images
from libgz.sdfworld.shapes import show_part
from libgz.sdfworld.visual import put_on, set_transparency

__all__ = ["attach_mesh", "base_size", "corners_of", "distance_along"]

log = logging.getLogger("libgz.classic")

FINE = 64  # segments of a full turn of round shapes
UNIT = ("unit_box", "unit_sphere", "unit_cylinder")


def base_size(geom: Geom, sdf: Element | None) -> GzVector:
    """The size of a shape [m]; of a mesh the scale in its file, of others 1."""
    if isinstance(geom, BoxGeom):
        return GzVector(*geom.size)
    if isinstance(geom, CylinderGeom):
        return GzVector(2.0 * geom.radius, 2.0 * geom.radius, geom.length)
    if isinstance(geom, SphereGeom):
        return GzVector(*(2.0 * geom.radius,) * 3)
    shape = sdf.child("geometry").GetFirstElement() if sdf is not None else None
    if shape is not None and shape.name == "plane":
        size = shape.Get(GzVector, "size")
        return GzVector(size.x, size.y, 1.0)
    if shape is not None and shape.name == "mesh":
        return shape.Get(GzVector, "scale")
    return GzVector(1.0, 1.0, 1.0)


def corners_of(geom: Geom, frame: GzPose) -> NDArray[np.float64]:
    """The vertices of a geom's meshes, in a frame [m], shape (n, 3)."""
    place = pose_matrix(GzCoordPoseSub(geom.GetPose(), frame))
    found = [shape.scaled(*geom.appearance.scale).moved(place).vertices for shape in meshes_of(geom, 12)]
    return np.concatenate(found).astype(np.float64) if found else np.zeros((0, 3))


def distance_along(geom: Geom, start: VectorLike, direction: VectorLike) -> float:
    """The distance [m] from a global point, along a unit vector, to where a geom is rendered; inf if it is missed.

    By the intersection of a ray with each triangle (Moeller and Trumbore).
    """
    place = pose_matrix(geom.GetPose())
    origin, ray, found = np.array([*start]), np.array([*direction]), math.inf
    for shape in meshes_of(geom, FINE):
        points = shape.scaled(*geom.appearance.scale).moved(place).vertices.astype(np.float64)
        corners = (points if shape.indices is None else points[shape.indices]).reshape(-1, 3, 3)
        first = corners[:, 1] - corners[:, 0]
        second = corners[:, 2] - corners[:, 0]
        across = np.cross(ray, second)
        scale = np.einsum("ij,ij->i", first, across)
        with np.errstate(divide="ignore", invalid="ignore"):
            away = origin - corners[:, 0]
            u = np.einsum("ij,ij->i", away, across) / scale
            turned = np.cross(away, first)
            v = turned @ ray / scale
            distance = np.einsum("ij,ij->i", turned, second) / scale
            hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (distance > 0.0)
        found = min(found, float(distance[hit].min(initial=math.inf)))
    return found


def attach_mesh(body: Body, name: str) -> list[Geom]:
    """New geoms that are only rendered: a unit shape, or the parts of a mesh file.

    Raises:
        NotFoundError: there is no such shape or file.
        GazeboError: the file cannot be read.
    """
    made: list[Geom]
    if name == "unit_box":
        made = [BoxGeom(body, None, 1.0, 1.0, 1.0)]
    elif name == "unit_sphere":
        made = [SphereGeom(body, None, 0.5)]
    elif name == "unit_cylinder":
        made = [CylinderGeom(body, None, 0.5, 1.0)]
    elif Path(name).suffix:
        parts = read_mesh(find_uri(name))
        images = found_images([part.texture for part in parts if part.texture is not None], log.warning)
        made = [show_part(body, part, images) for part in parts]
        for geom in made:
            set_transparency(geom.appearance, 0.0)
        return made
    else:
        raise NotFoundError(f"there is no mesh {name!r}{nearest(name, UNIT)}; there are {', '.join(UNIT)}, and files")
    put_on(made[0].appearance, Material())
    return made
