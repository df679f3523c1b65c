"""The meshes of each kind of geom: a table from its class to a function that builds them.

A new kind gets a row in `GEOM_MESHES`, unless it is derived from a kind that has one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from libgz.ode.types import ContactRule
from libgz.physics.appearance import SAME
from libgz.physics.geom import Geom
from libgz.physics.geoms import (
    BoxGeom,
    CapsuleGeom,
    CylinderGeom,
    HeightfieldGeom,
    SphereGeom,
    TriMeshGeom,
    WheelGeom,
)
from libgz.rendering import mesh
from libgz.rendering.mesh import Mesh

__all__ = ["GEOM_MESHES", "MeshBuilder", "meshes_of", "round_radius"]

PATCH = 0.5  # [m] longest side of the patches of floors and walls near local lights
HUB = 0.8  # a wheel's hub discs: their radius as a share of the wheel's, and their place as one of the tire's

# (geom, segments of a full turn) -> meshes in the frame of the geom's centre
MeshBuilder = Callable[[Any, int], list[Mesh]]


def _wheel(geom: WheelGeom, segments: int) -> list[Mesh]:
    """A tire, and a disc on each side; where the discs close it, the tire has no inner side."""
    tire, ring, hub = geom.tire_radius, max(geom.radius - geom.tire_radius, 0.0), HUB * geom.radius
    inner = math.pi - math.asin(HUB)  # where the tire meets a disc's plane
    closed = ring + tire * math.cos(inner) < hub * math.cos(math.pi / segments)
    parts = [mesh.torus(ring, tire, segments, inner if closed else math.pi)]
    return parts + [mesh.disc(hub, HUB * tire * up, segments, up) for up in (1.0, -1.0)]


def _trimesh(geom: TriMeshGeom, _segments: int) -> list[Mesh]:
    """A mesh with normals and texture coordinates of its own, where it has any."""
    normals, texcoords, corners = geom.normals, geom.texture_coordinates, geom.triangles.ravel()
    if normals is not None:  # they belong to vertices, which triangles then share
        return [mesh.smooth(geom.vertices, corners, normals, texcoords, _texture_size(geom))]
    shape = mesh.triangles(geom.vertices, geom.triangles, _texture_size(geom))
    if texcoords is not None:
        shape = shape._replace(texcoords=np.ascontiguousarray(texcoords[corners], dtype=np.float32))
    return [shape]


def _texture_size(geom: Geom) -> tuple[float, float]:
    return geom.appearance.texture_size.x, geom.appearance.texture_size.y


# A kind without a row is rendered like its nearest base class with one; without any it is invisible.
GEOM_MESHES: dict[type[Geom], MeshBuilder] = {
    BoxGeom: lambda geom, segments: [mesh.box(*geom.size)],
    SphereGeom: lambda geom, segments: [mesh.sphere(geom.radius, segments)],
    CylinderGeom: lambda geom, segments: mesh.cylinder(geom.radius, geom.length, segments),
    CapsuleGeom: lambda geom, segments: [mesh.capsule(geom.radius, geom.length, segments)],
    WheelGeom: _wheel,
    TriMeshGeom: _trimesh,
    HeightfieldGeom: lambda geom, segments: [mesh.heightfield(geom.heights, geom.size, _texture_size(geom))],
}


def _fitted_sphere(geom: SphereGeom, segments: int) -> list[Mesh]:
    return [mesh.sphere(_fitted(geom.radius, segments), segments)]


def _fitted_cylinder(geom: CylinderGeom, segments: int) -> list[Mesh]:
    return mesh.cylinder(_fitted(geom.radius, segments, 2), geom.length, segments)


def _fitted_capsule(geom: CapsuleGeom, segments: int) -> list[Mesh]:
    return [mesh.capsule(_fitted(geom.radius, segments), geom.length, segments)]


def _fitted(radius: float, segments: int, share: int = 1) -> float:
    """The radius of the corners of a mesh whose surface lies as far outside of the round one as inside.

    A triangle of a sphere is nearer to the middle than its corners by up to radius * (pi / segments)^2; a strip of a
    cylinder by half of it.
    """
    return radius * (1.0 + (math.pi / segments) ** 2 / (2.0 * share))


# Round kinds of classic worlds. The old server had corners on the round surface, so legacy worlds have them, too.
FITTED_MESHES: dict[type[Geom], MeshBuilder] = {
    SphereGeom: _fitted_sphere,
    CylinderGeom: _fitted_cylinder,
    CapsuleGeom: _fitted_capsule,
    WheelGeom: _wheel,
}


def round_radius(geom: Geom) -> float:
    """The radius [m] of a round geom whose detail depends on its size in the image; 0 for all others."""
    if geom.body.engine.contact_rule is not ContactRule.CLASSIC or type(geom) not in FITTED_MESHES:
        return 0.0
    return float(geom.radius * max(map(abs, geom.appearance.scale)))  # type: ignore[attr-defined]


def meshes_of(geom: Geom, segments: int, local_lights: bool = False) -> list[Mesh]:
    """The meshes of a geom in the frame of its centre, with its texture's matrix; none if its kind is invisible.

    With `local_lights`, large boxes and planes of classic worlds are split into patches, because OpenGL computes light
    at vertices only. The old server used the corners of its boxes.
    """
    shapes, matrix = _shapes(geom, segments, local_lights), geom.appearance.texture_matrix
    return shapes if matrix == SAME else [shape.textured_by(matrix) for shape in shapes]


def _shapes(geom: Geom, segments: int, local_lights: bool) -> list[Mesh]:
    if local_lights and geom.body.engine.contact_rule is ContactRule.CLASSIC:
        if type(geom) is BoxGeom:
            x, y, z = geom.size
            return [mesh.box(x, y, z, PATCH)]
        if isinstance(geom, TriMeshGeom) and geom.columns:
            first, last, above = (geom.vertices[i] for i in (0, geom.columns - 1, -geom.columns))
            across, up = last - first, above - first
            # At least as fine as the geom's own grid.
            least = float(min(np.linalg.norm(across), np.linalg.norm(up))) / (geom.columns - 1)
            return [mesh.rectangle(first, across, up, min(PATCH, least) or PATCH)]
    if round_radius(geom):
        return FITTED_MESHES[type(geom)](geom, segments)
    for kind in type(geom).__mro__:
        build = GEOM_MESHES.get(kind)
        if build is not None:
            return build(geom, segments)
    return []
