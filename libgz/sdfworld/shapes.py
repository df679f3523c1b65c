"""The shapes of SDF: geoms from `<geometry>` elements."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, NotFoundError, ParameterError, listed, nearest
from libgz.base.files import is_file
from libgz.base.geometry import GzColor, GzCoordPoseAdd, GzPose, GzQuatern, GzVector, rotate
from libgz.base.visible import one_line
from libgz.physics.body import Body
from libgz.physics.check import LARGEST, finite_tuple, positive, unit_axis
from libgz.physics.geom import Geom
from libgz.physics.geoms import (
    BoxGeom,
    CapsuleGeom,
    CylinderGeom,
    HeightfieldGeom,
    PlaneGeom,
    SphereGeom,
    TriMeshGeom,
)
from libgz.physics.mesh_parts import MeshPart, NamedImage
from libgz.physics.meshes import corner_normals, grid_triangles, units
from libgz.physics.outlines import extrude
from libgz.physics.space import Space
from libgz.sdf.description import UNSET
from libgz.sdf.element import Element
from libgz.sdf.paths import find_uri
from libgz.sdfworld.mesh_images import found_images
from libgz.sdfworld.visual import replaces_look, show_image

__all__ = ["KNOWN", "make_collision", "make_visual", "show_part"]

log = logging.getLogger("libgz.simulation")

KNOWN = ("box", "sphere", "cylinder", "capsule", "ellipsoid", "plane", "mesh", "heightmap", "polyline", "empty")
# Of which coordinates are computed; geoms check their own sizes.
VECTORS = {"plane": ("size", "normal"), "mesh": ("scale",), "heightmap": ("size", "pos")}
ROUND = 24  # corners of an ellipsoid's equator
THINNEST = 1e-4  # [m]
SIMPLE: dict[str, tuple[Callable[..., Geom], tuple[str, ...]]] = {
    "box": (BoxGeom, ("size",)),
    "sphere": (SphereGeom, ("radius",)),
    "cylinder": (CylinderGeom, ("radius", "length")),
    "capsule": (CapsuleGeom, ("radius", "length")),
}
PATCHES = 16  # of a rendered plane, in each direction: light is computed at their corners

Note = Callable[[Element, str], None]  # reports a warning about an element
T = TypeVar("T")
Triangles = tuple[NDArray[np.float64], NDArray[np.integer]]


def make_collision(body: Body, space: Space, element: Element, note: Note) -> Geom | None:
    """The geom of a `<collision>` at its place in the link; None, with a warning, for what cannot be built.

    Raises:
        ParameterError: a size is not allowed.
    """
    shape = _shape(element, note)
    if shape is None:
        return None
    pose = element.Get(GzPose, "pose")
    placed = GzCoordPoseAdd(pose, body.GetPose())
    if shape.name == "plane":
        normal = rotate(placed.rot, GzVector(*unit_axis(shape.Get(GzVector, "normal"), "normal")))
        altitude = sum(n * p for n, p in zip(normal, placed.pos, strict=True))
        return PlaneGeom(body, space, altitude, normal)
    geom = _simple(body, space, shape, note)
    if geom is None and shape.name == "heightmap" and body.dummy and HeightfieldGeom.suits(placed):
        heights = _made(shape, lambda: _heights(shape), note)
        if heights is None:
            return None
        size = shape.Get(GzVector, "size")
        geom = HeightfieldGeom(body, space, heights, size.x, size.y)
        pose = GzCoordPoseAdd(GzPose(shape.Get(GzVector, "pos"), GzQuatern()), pose)
    elif geom is None:
        parts = _meshes(shape, element, note)
        if not parts:
            return None
        vertices, triangles = _merged(parts)
        geom = TriMeshGeom(body, space, vertices, triangles)
    geom.SetRelativePose(pose)
    return geom


def make_visual(body: Body, element: Element, note: Note) -> list[Geom]:
    """The geoms of a `<visual>`, which are rendered and touch nothing: one for each material of a mesh."""
    shape = _shape(element, note)
    if shape is None:
        return []
    pose = element.Get(GzPose, "pose")
    geom = _simple(body, None, shape, note)
    if shape.name == "heightmap":
        from libgz.sdfworld.terrain import terrain_visual  # few worlds have one

        geom = _made(shape, lambda: terrain_visual(_find(shape), shape, body, note), note)
        if geom is None:
            return []
    found = [geom] if geom is not None else []
    if geom is None:
        parts = [_plane(shape)] if shape.name == "plane" else _meshes(shape, element, note)
        textures = [] if replaces_look(element) else [part.texture for part in parts if part.texture is not None]
        images = found_images(textures, lambda why: note(shape, why))
        for part in parts:
            geom = show_part(body, part, images)
            if shape.name == "plane":
                geom.texture_coordinates, geom.columns = _across(), PATCHES + 1
            found.append(geom)
    for geom in found:
        geom.SetRelativePose(pose)
    return found


def show_part(body: Body, part: MeshPart, images: Mapping[NamedImage, Path]) -> TriMeshGeom:
    """A geom that is only rendered: a part of a mesh with the colour, normals and image that its file has for it.

    Args:
        body: that it belongs to.
        part: of a mesh.
        images: the file of each image that was found.
    """
    if part.normals is None and part.texture is None:
        geom = TriMeshGeom(body, None, part.vertices, part.triangles)
        if part.color is not None:
            geom.SetColor(GzColor(*part.color))
        return geom
    # Corners that share a vertex may have different normals and places in the image, so each is a vertex of its own.
    corners = part.vertices[part.triangles].reshape(-1, 3)
    geom = TriMeshGeom(body, None, corners, np.arange(len(corners)).reshape(-1, 3))
    normals = corner_normals(part.vertices, part.triangles).astype(np.float64)
    if part.normals is not None:
        known = part.normals.any(axis=-1, keepdims=True)
        normals = np.where(known, part.normals, normals)
    geom.normals = normals.reshape(-1, 3)
    texture = part.texture
    shown = images.get(texture.image) if texture is not None and texture.image is not None else None
    if texture is not None and texture.coordinates is not None:
        geom.texture_coordinates = texture.coordinates.reshape(-1, 2)
    if shown is not None and geom.texture_coordinates is not None:
        show_image(geom.appearance, shown, part.color)
    elif part.color is not None:
        geom.SetColor(GzColor(*part.color))
    return geom


def _shape(element: Element, note: Note) -> Element | None:
    """The shape of a collision or visual; None, with a warning, where its kind is not supported.

    Raises:
        ParameterError: it has a number with which arithmetic overflows.
    """
    shape = element.child("geometry").GetFirstElement()
    if shape is None or shape.name == "empty":
        return None
    if shape.name not in KNOWN:
        known = f"{', '.join(KNOWN[:-1])} and {KNOWN[-1]}"
        note(shape, f"this shape is not simulated, and is left out; {known} are{nearest(shape.name, KNOWN)}")
        return None
    for key in VECTORS.get(shape.name, ()):
        finite_tuple(shape.Get(GzVector, key), 3, f"{shape.name} {key}", LARGEST)
    return shape


def _simple(body: Body, space: Space | None, shape: Element, note: Note) -> Geom | None:
    """The geom of a shape that ODE knows; None for others. One with a length of 0 touches nothing, as in classic."""
    if shape.name not in SIMPLE:
        return None
    make, keys = SIMPLE[shape.name]
    sizes: list[float] = []
    for key in keys:
        lengths = [*shape.Get(GzVector, key)] if key == "size" else [shape.Get(float, key)]
        if 0.0 in lengths:
            note(shape, f"{key} is 0: it touches nothing, and {THINNEST:g} m is used instead")
            space = None
        sizes += [length or THINNEST for length in lengths]
    return make(body, space, *sizes)


def _plane(shape: Element) -> MeshPart:
    """A rectangle at right angles to its normal."""
    size, normal = shape.Get(GzVector, "size"), np.array(shape.Get(GzVector, "normal"))
    length = float(np.linalg.norm(normal))
    normal = normal / length if length > 0.0 else np.array((0.0, 0.0, 1.0))
    ahead = np.array((1.0, 0.0, 0.0)) if abs(normal[0]) < 0.9 else np.array((0.0, 0.0, -1.0))
    left = np.cross(normal, ahead)
    left /= np.linalg.norm(left)
    ahead = np.cross(left, normal)
    x, y = (grid.reshape(-1, 1) for grid in np.meshgrid(*(np.linspace(-0.5, 0.5, PATCHES + 1),) * 2))
    return MeshPart("plane", x * size.x * ahead + y * size.y * left, grid_triangles(PATCHES + 1, PATCHES + 1))


def _across() -> NDArray[np.float64]:
    """Texture coordinates of such a rectangle: it shows the whole image once."""
    x, y = np.meshgrid(*(np.linspace(0.0, 1.0, PATCHES + 1),) * 2)
    return np.stack([x.ravel(), y.ravel()], axis=1)


def _merged(parts: list[MeshPart]) -> Triangles:
    """All parts as one mesh."""
    if len(parts) == 1:
        return parts[0].vertices, parts[0].triangles
    starts = np.cumsum([0, *(len(part.vertices) for part in parts)])
    triangles = [part.triangles + start for part, start in zip(parts, starts[:-1], strict=True)]
    return np.concatenate([part.vertices for part in parts]), np.concatenate(triangles)


def _meshes(shape: Element, element: Element, note: Note) -> list[MeshPart]:
    """The triangles of a mesh-like shape; none, with a warning, where a file is missing or cannot be read."""
    makers = {"mesh": _read, "heightmap": _heightmap, "polyline": _polyline, "ellipsoid": _ellipsoid}
    return _made(shape, lambda: makers[shape.name](shape, element), note) or []


def _made(shape: Element, make: Callable[[], T], note: Note) -> T | None:
    """What is made of a shape; None, with a warning, where its file is missing or cannot be read."""
    try:
        return make()
    except NotFoundError as error:
        note(shape, f"{error}; the shape is left out")
    except ParameterError:
        raise
    except GazeboError as error:
        note(shape, f"{error}; the shape is left out")
    return None


def _find(shape: Element) -> Path:
    if shape.Get(str, "uri") in ("", UNSET):
        raise NotFoundError("it has no <uri>")
    folder = Path(shape.file).parent if shape.file and not shape.file.startswith("<") else None
    path = find_uri(shape.Get(str, "uri"), folder)
    if not is_file(path):
        raise NotFoundError(
            f"Unable to find uri[{one_line(shape.Get(str, 'uri'))}]: {one_line(str(path))} is not a file"
        )
    return path


def _read(shape: Element, _element: Element) -> list[MeshPart]:
    """The parts of a mesh file, scaled; of a `<submesh>` those of its name, centred on the origin on request."""
    from libgz.physics.mesh_files import read_mesh  # many worlds have none

    path = _find(shape)
    parts = read_mesh(path)
    scale = np.array(shape.Get(GzVector, "scale"))
    center = np.zeros(3)
    if shape.HasElement("submesh"):
        submesh = shape.child("submesh")
        name = submesh.Get(str, "name")
        names = list(dict.fromkeys(part.name for part in parts))
        parts = [part for part in parts if part.name == name]
        if not parts:
            raise NotFoundError(f"mesh {path} has no submesh {name!r}; it has {listed(names)}{nearest(name, names)}")
        if submesh.Get(bool, "center"):
            points = np.concatenate([part.vertices for part in parts])
            center = 0.5 * (points.min(axis=0) + points.max(axis=0))
    turned = bool(np.prod(scale) < 0.0)  # mirrored: keep normals pointing outwards
    return [
        MeshPart(
            part.name,
            (part.vertices - center) * scale,
            part.triangles[:, ::-1] if turned else part.triangles,
            part.color,
            part.texture.mirrored() if turned and part.texture is not None else part.texture,
            _scaled_normals(part.normals, scale, turned),
        )
        for part in parts
    ]


def _scaled_normals(
    normals: NDArray[np.float64] | None, scale: NDArray[np.float64], turned: bool
) -> NDArray[np.float64] | None:
    """The normals of a stretched mesh, whose triangles have their corners in the opposite order if it is mirrored."""
    if normals is None or not scale.all():
        return None
    stretched: NDArray[np.float64] = units(normals / scale).astype(np.float64)
    return stretched[:, ::-1] if turned else stretched


def _heightmap(shape: Element, _element: Element) -> list[MeshPart]:
    from libgz.sdfworld.terrain import terrain_mesh  # few worlds have one

    return [terrain_mesh(_find(shape), shape)]


def _heights(shape: Element) -> NDArray[np.float64]:
    from libgz.sdfworld.terrain import terrain_heights

    return terrain_heights(_find(shape), shape)


def _polyline(_shape: Element, element: Element) -> list[MeshPart]:
    """Solids extruded from all outlines of the geometry; one inside another is a hole in it."""
    lines = list(element.child("geometry").named("polyline"))
    rings = [[_flat(point) for point in line.named("point")] for line in lines]
    height = positive(lines[0].Get(float, "height"), "polyline height [m]")
    try:
        vertices, triangles = extrude(list(rings), height)
    except ParameterError as error:
        raise GazeboError(str(error)) from None
    return [MeshPart("polyline", vertices, triangles)]


def _ellipsoid(shape: Element, _element: Element) -> list[MeshPart]:
    """A ball, stretched along x, y and z."""
    radii = [positive(radius, "ellipsoid radius [m]") for radius in shape.Get(GzVector, "radii")]
    up, around = np.linspace(-0.5 * np.pi, 0.5 * np.pi, ROUND // 2 + 1)[1:-1], np.arange(ROUND) * (2.0 * np.pi / ROUND)
    rows = [
        np.column_stack([np.cos(u) * np.cos(around), np.cos(u) * np.sin(around), np.full(ROUND, np.sin(u))]) for u in up
    ]
    ball = np.concatenate([*rows, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    count, i = len(rows) * ROUND, np.arange(ROUND)
    j = np.roll(i, -1)
    faces = [np.stack([np.full(ROUND, count), j, i], axis=1)]
    for k in range(len(rows) - 1):
        low, high = k * ROUND, (k + 1) * ROUND
        faces += [np.stack([low + i, low + j, high + j], axis=1), np.stack([low + i, high + j, high + i], axis=1)]
    top = (len(rows) - 1) * ROUND
    faces.append(np.stack([top + i, top + j, np.full(ROUND, count + 1)], axis=1))
    return [MeshPart("ellipsoid", ball * np.array(radii), np.concatenate(faces))]


def _flat(point: Element) -> tuple[float, float]:
    place = point.Get(GzVector)
    finite_tuple(place, 3, "polyline point [m]", LARGEST)
    return place.x, place.y
