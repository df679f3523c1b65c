"""Geoms as SDF collisions and visuals."""

from __future__ import annotations

import copy
import math
from typing import TypeAlias

import numpy as np
from lxml import etree
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzCoordPositionSub,
    GzPose,
    GzQuaternInverse,
    GzVector,
    GzVectorMul,
    rotate,
)
from libgz.convert.element import Notes, add, color, name_of, pose
from libgz.ode.types import Surface
from libgz.physics.geom import Geom
from libgz.physics.geoms import (
    BoxGeom,
    CapsuleGeom,
    CylinderGeom,
    HeightfieldGeom,
    PlaneGeom,
    SphereGeom,
    TriMeshGeom,
    WheelGeom,
)

__all__ = ["CORRECTING_VELOCITY", "Meshes", "add_geom", "is_shape"]

# [m/s], the limit of libgz's contacts; with SDF's default of 0.01 robots sink on soft wheels
CORRECTING_VELOCITY = 100.0
RIGID = 1e12  # [N/m]; SDF's default, for an infinite kp
STICKY = 1e9  # Coulomb coefficient, for an infinite one
PLANE_EXTENT = (100.0, 100.0)  # [m] of an infinite plane that is rendered
Part: TypeAlias = tuple[GzPose, etree._Element]  # pose in the link, shape
SHAPES = (BoxGeom, SphereGeom, CylinderGeom, CapsuleGeom, PlaneGeom, TriMeshGeom, HeightfieldGeom)


class Meshes:
    """The mesh files of a converted world.

    Args:
        folder: name of their directory, relative to the SDF file.
    """

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.files: dict[str, bytes] = {}
        self._taken: set[str] = set()

    def add(self, name: str, vertices: NDArray[np.float64], triangles: NDArray[np.uint32]) -> str:
        """Add a mesh as binary STL; its path relative to the SDF file."""
        file = f"{name_of(name, self._taken)}.stl"
        corners = vertices[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        records = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
        records["normal"] = normals / np.where(lengths > 0.0, lengths, 1.0)
        records["corners"] = corners
        head = b"libgz".ljust(80) + np.uint32(len(triangles)).tobytes()
        self.files[f"{self.folder}/{file}"] = head + records.tobytes()
        return f"{self.folder}/{file}"


def is_shape(geom: Geom) -> bool:
    """Whether a geom has a surface: it is not a light, a ray or a camera's frustum."""
    return isinstance(geom, SHAPES)


def add_geom(
    link: etree._Element, geom: Geom, name: str, base: GzPose, owner: str, meshes: Meshes, notes: Notes
) -> None:
    """Collisions and visuals of one geom.

    Args:
        link: the SDF link.
        geom: the geom.
        name: the beginning of their names.
        base: the global pose of the link.
        owner: name of the model in notes.
        meshes: receives the triangles of meshes.
        notes: receives what has no counterpart.
    """
    shapes = _parts(geom, name, base, meshes)
    for i, part in enumerate(shapes):
        _add_surface(_add_shape(link, "collision", name, i, part, geom), geom)
    if isinstance(geom, WheelGeom):
        shapes = [(shapes[0][0], _cylinder(geom.radius, 2 * geom.tire_radius))]
    for i, part in enumerate(shapes):
        _add_material(_add_shape(link, "visual", name, i, part, geom), geom)
    _note_losses(geom, owner, notes)


def _add_shape(link: etree._Element, kind: str, name: str, i: int, part: Part, geom: Geom) -> etree._Element:
    """The collision or visual number `i` of a geom; its name is unique in the link."""
    place, shape = part
    element = add(link, kind, name=f"{name}_{f'end{i}_' if i else ''}{kind}")
    add(element, "pose", pose(place))
    if geom.appearance.retro:
        add(element, "laser_retro", geom.appearance.retro)
    add(element, "geometry").append(copy.deepcopy(shape))
    return element


def _parts(geom: Geom, name: str, base: GzPose, meshes: Meshes) -> list[Part]:
    """The shapes that form a geom."""
    place = GzCoordPoseSub(geom.GetPose(), base)
    if isinstance(geom, BoxGeom):
        shape = etree.Element("box")
        add(shape, "size", geom.size)
        return [(place, shape)]
    if isinstance(geom, SphereGeom):
        return [(place, _sphere(geom.radius))]
    if isinstance(geom, CylinderGeom):
        return [(place, _cylinder(geom.radius, geom.length))]
    if isinstance(geom, CapsuleGeom):  # SDF has capsules since 1.8
        ends = (GzPose(GzVector(0.0, 0.0, side * geom.length / 2.0)) for side in (-1.0, 1.0))
        balls = [(GzCoordPoseAdd(end, place), _sphere(geom.radius)) for end in ends]
        return [(place, _cylinder(geom.radius, geom.length)), *balls]
    if isinstance(geom, PlaneGeom):  # in global coordinates, wherever its body is
        shape = etree.Element("plane")
        add(shape, "normal", rotate(GzQuaternInverse(base.rot), geom.normal))
        add(shape, "size", PLANE_EXTENT)
        point = GzVectorMul(geom.altitude, geom.normal)
        return [(GzPose(GzCoordPositionSub(point, base.pos, base.rot)), shape)]
    return [(place, _mesh(geom, name, meshes))]


def _sphere(radius: float) -> etree._Element:
    shape = etree.Element("sphere")
    add(shape, "radius", radius)
    return shape


def _cylinder(radius: float, length: float) -> etree._Element:
    shape = etree.Element("cylinder")
    add(shape, "radius", radius)
    add(shape, "length", length)
    return shape


def _mesh(geom: Geom, name: str, meshes: Meshes) -> etree._Element:
    """A mesh file of a triangle mesh or a height field."""
    if isinstance(geom, HeightfieldGeom):
        vertices, triangles = geom.triangulated()
    elif isinstance(geom, TriMeshGeom):
        vertices, triangles = geom.vertices, geom.triangles
    else:
        raise ParameterError(f"{type(geom).__name__} has no counterpart in SDF")
    shape = etree.Element("mesh")
    add(shape, "uri", meshes.add(name, vertices, triangles))
    return shape


def _add_surface(collision: etree._Element, geom: Geom) -> None:
    """Contact parameters; ODE in SDF also uses the smaller friction of two, and adds springs in series."""
    values = geom.body.engine.tables.geoms.surface[geom.row].tolist()
    surface = add(collision, "surface")
    friction = add(add(surface, "friction"), "ode")
    for tag in ("mu", "mu2"):
        add(friction, tag, min(values[Surface.MU], STICKY))
    contact = add(add(surface, "contact"), "ode")
    add(contact, "kp", values[Surface.KP] if math.isfinite(values[Surface.KP]) else RIGID)
    add(contact, "kd", values[Surface.KD])
    add(contact, "max_vel", CORRECTING_VELOCITY)
    add(contact, "min_depth", 0.0)
    if values[Surface.BOUNCE]:
        bounce = add(surface, "bounce")
        add(bounce, "restitution_coefficient", min(values[Surface.BOUNCE], 1.0))
        add(bounce, "threshold", 0.0)


def _add_material(visual: etree._Element, geom: Geom) -> None:
    look = geom.appearance
    if geom.GetTransparency():
        add(visual, "transparency", 1.0 - color(look.diffuse)[3])
    material = add(visual, "material")
    for tag, value in (
        ("ambient", look.ambient),
        ("diffuse", look.diffuse),
        ("specular", look.specular),
        ("emissive", look.emission),
    ):
        add(material, tag, [*color(value)[:3], 1.0])


def _note_losses(geom: Geom, owner: str, notes: Notes) -> None:
    look = geom.appearance
    if look.texture_file is not None:
        notes.add(
            owner,
            f"the texture {look.texture_file.name} is omitted: SDF 1.6 needs a simulator's material script",
        )
    if look.skin_file is not None:
        notes.add(owner, f"the skin {look.skin_file.name} is omitted; the shape below it is rendered")
    if geom.surface(Surface.BOUNCE):
        notes.add(owner, "bounces only off surfaces that bounce, too: SDF uses the smaller coefficient of two")
    if look.fiducial != -1:
        notes.add(owner, f"fiducial {look.fiducial} has no counterpart")
