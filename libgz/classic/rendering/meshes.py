"""Shapes of visuals: their sizes, and the shapes that plugins attach by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.errors import NotFoundError, nearest
from libgz.geometry import GzColor, GzCoordPoseSub, GzPose, GzVector
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom, SphereGeom, TriMeshGeom
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.shot import pose_matrix
from libgz.sdf.element import Element
from libgz.sdf.materials import Material
from libgz.sdf.paths import find_uri
from libgz.sdfworld.visual import put_on

__all__ = ["attach_mesh", "base_size", "corners_of"]

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
        made = [TriMeshGeom(body, None, part.vertices, part.triangles) for part in parts]
        for geom, part in zip(made, parts, strict=True):
            if part.color is not None:
                geom.SetColor(GzColor(*part.color))
        return made
    else:
        raise NotFoundError(f"there is no mesh {name!r}{nearest(name, UNIT)}; there are {', '.join(UNIT)}, and files")
    put_on(made[0].appearance, Material())
    return made
