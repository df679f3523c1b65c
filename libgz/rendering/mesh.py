"""Meshes of geoms and skins, as arrays; and functions that build the meshes of basic shapes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.physics.meshes import corner_normals, units
from libgz.rendering.gl import Constant

__all__ = [
    "Material",
    "Mesh",
    "box",
    "capsule",
    "cylinder",
    "disc",
    "heightfield",
    "rectangle",
    "ring",
    "smooth",
    "sphere",
    "torus",
    "triangles",
]

Floats = NDArray[np.float32]
MOST_PATCHES = 100  # of a flat face, in each direction


class Material(NamedTuple):
    """The material of a part of a skin: colours red, green, blue, alpha; exponent of highlights, 0 to 128."""

    diffuse: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    specular: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    ambient: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    shininess: float = 0.0

    @property
    def colors(self) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], tuple[float, ...], float]:
        """Ambient, diffuse, specular colour, emission, shininess."""
        return self.ambient, self.diffuse, self.specular, (0.0, 0.0, 0.0, 1.0), self.shininess


class Mesh(NamedTuple):
    """Triangles, lines or points.

    Attributes:
        vertices: [m], shape (n, 3).
        normals: unit vectors, shape (n, 3); None: unlit, in the plain diffuse colour.
        texcoords: shape (n, 2), (0, 0) is the lower left of the image; None: never textured.
        indices: of vertices, counter-clockwise seen from outside; None: all in order.
        mode: a GL primitive.
        material: replaces the geom's.
        two_sided: visible from both sides.
    """

    vertices: Floats
    normals: Floats | None = None
    texcoords: Floats | None = None
    indices: NDArray[np.uint32] | None = None
    mode: int = Constant.TRIANGLES
    material: Material | None = None
    two_sided: bool = False

    def moved(self, matrix: NDArray[np.float64]) -> Mesh:
        """The mesh seen from another frame: `matrix` is rigid, shape (4, 4)."""
        rotation = matrix[:3, :3]
        vertices = self.vertices @ rotation.T + matrix[:3, 3]
        normals = None if self.normals is None else _f(self.normals @ rotation.T)
        return self._replace(vertices=_f(vertices), normals=normals)

    def scaled(self, x: float, y: float, z: float) -> Mesh:
        """The mesh stretched along its axes; normals stay perpendicular."""
        factors = np.array((x, y, z), dtype=np.float32)
        normals = self.normals
        if normals is not None and np.all(factors != 0.0):
            normals = units(normals / factors)
        return self._replace(vertices=self.vertices * factors, normals=normals)

    def textured_by(self, matrix: Sequence[float]) -> Mesh:
        """The mesh with texture coordinates u' = a u + b v + c, v' = d u + e v + f for a matrix (a, b, c, d, e, f)."""
        if self.texcoords is None:
            return self
        rows = np.array(matrix).reshape(2, 3)
        return self._replace(texcoords=_f(self.texcoords @ rows[:, :2].T + rows[:, 2]))


def _f(values: ArrayLike) -> Floats:
    return np.ascontiguousarray(values, dtype=np.float32)


def _patches(columns: int, rows: int) -> NDArray[np.uint32]:
    """Triangles of a grid of (rows + 1) x (columns + 1) vertices, counter-clockwise if columns x rows points out."""
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    a = (j * (columns + 1) + i).ravel()
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return np.stack([a, b, c, a, c, d], axis=1).astype(np.uint32).ravel()


def rectangle(corner: ArrayLike, across: ArrayLike, up: ArrayLike, patch: float = math.inf) -> Mesh:
    """A flat rectangle from its lower left corner along two sides [m]; it carries the whole texture.

    `patch`: longest side of the patches that it is split into [m], up to `MOST_PATCHES`; light is computed at their
    corners.
    """
    sides = [np.asarray(side, dtype=np.float64) for side in (across, up)]
    columns, rows = (max(1, min(math.ceil(float(np.linalg.norm(side)) / patch), MOST_PATCHES)) for side in sides)
    i, j = np.meshgrid(np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 1.0, rows + 1))
    share = np.stack((i.ravel(), j.ravel()), axis=1)
    normal = np.broadcast_to(np.cross(sides[0], sides[1]), (len(share), 3))
    return Mesh(_f(np.asarray(corner) + share @ np.array(sides)), units(normal), _f(share), _patches(columns, rows))


def box(x: float, y: float, z: float, patch: float = math.inf) -> Mesh:
    """A box of full lengths [m]; each face is a `rectangle` that carries the whole texture."""
    faces, half = [], np.array((x, y, z)) / 2.0
    for axis in range(3):
        for sign in (1.0, -1.0):
            n = np.eye(3)[axis] * sign
            # Texture upright on the sides: t runs along z, or along y on top and bottom.
            t = np.eye(3)[1 if axis == 2 else 2]
            s = np.cross(t, n)
            faces.append(rectangle((n - s - t) * half, 2.0 * s * half, 2.0 * t * half, patch))
    starts = np.cumsum([0, *(len(face.vertices) for face in faces)])
    indices = [face.indices + start for face, start in zip(faces, starts[:-1], strict=True) if face.indices is not None]
    vertices, normals, texcoords = (
        np.concatenate([getattr(face, part) for face in faces]) for part in ("vertices", "normals", "texcoords")
    )
    return Mesh(_f(vertices), _f(normals), _f(texcoords), np.concatenate(indices).astype(np.uint32))


def _revolved(radii: Floats, heights: Floats, outward: Floats, upward: Floats, t: Floats, segments: int) -> Mesh:
    """A profile revolved about z; one value of each array per ring, from the bottom up."""
    angles = np.linspace(0.0, 2.0 * math.pi, segments + 1)
    cos, sin, one = np.cos(angles), np.sin(angles), np.ones(segments + 1)
    vertices = np.stack([np.outer(radii, cos), np.outer(radii, sin), np.outer(heights, one)], axis=-1)
    normals = np.stack([np.outer(outward, cos), np.outer(outward, sin), np.outer(upward, one)], axis=-1)
    texcoords = np.stack([np.outer(np.ones(len(t)), angles / (2.0 * math.pi)), np.outer(t, one)], axis=-1)
    indices = _patches(segments, len(radii) - 1)
    return Mesh(_f(vertices.reshape(-1, 3)), units(normals.reshape(-1, 3)), _f(texcoords.reshape(-1, 2)), indices)


def sphere(radius: float, segments: int) -> Mesh:
    """A sphere about the origin; the texture runs once around, poles at top and bottom."""
    angle = np.linspace(-math.pi / 2.0, math.pi / 2.0, segments // 2 + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    return _revolved(_f(radius * cos), _f(radius * sin), _f(cos), _f(sin), _f(angle / math.pi + 0.5), segments)


def cylinder(radius: float, length: float, segments: int) -> list[Mesh]:
    """A cylinder along z, centred: the side, which carries the texture, and two plain ends."""
    half = length / 2.0
    side = _revolved(_f([radius] * 2), _f([-half, half]), _f([1, 1]), _f([0, 0]), _f([0, 1]), segments)
    return [side, disc(radius, half, segments, 1.0), disc(radius, -half, segments, -1.0)]


def capsule(radius: float, length: float, segments: int) -> Mesh:
    """A cylinder along z with round ends, centred."""
    angle = np.linspace(-math.pi / 2.0, math.pi / 2.0, 2 * (segments // 4) + 2)
    cos, sin = np.cos(angle), np.sin(angle)
    heights = radius * sin + np.where(angle > 0.0, 0.5, -0.5) * length
    t = (heights - heights[0]) / (heights[-1] - heights[0])
    return _revolved(_f(radius * cos), _f(heights), _f(cos), _f(sin), _f(t), segments)


def disc(radius: float, z: float, segments: int, up: float) -> Mesh:
    """A flat disc at height z [m] visible from above (up 1) or below (-1)."""
    angles = np.linspace(0.0, 2.0 * math.pi * up, segments, endpoint=False)
    rim = np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(segments, z)], axis=1)
    middle = np.arange(1, segments - 1)
    indices = np.stack([np.zeros_like(middle), middle, middle + 1], axis=1).astype(np.uint32).ravel()
    return Mesh(_f(rim), _f(np.tile([0.0, 0.0, up], (segments, 1))), None, indices)


def torus(radius: float, tube: float, segments: int, reach: float = math.pi) -> Mesh:
    """A torus about z: radius of the ring's middle and of its tube [m].

    `reach`: how far around the tube it goes, to both sides from the outermost circle [rad]; pi closes it.
    """
    angle = np.linspace(-reach, reach, max(2, round(segments // 2 * reach / math.pi)) + 1)
    cos, sin = np.cos(angle), np.sin(angle)
    rings = _f(radius + tube * cos)
    return _revolved(rings, _f(tube * sin), _f(cos), _f(sin), _f((angle / math.pi + 1.0) / 2.0), segments)


def triangles(vertices: ArrayLike, corners: ArrayLike, texture_size: tuple[float, float] = (2.0, 2.0)) -> Mesh:
    """A triangle mesh: smooth at shallow edges, sharp at steep ones; its texture is projected from above.

    Args:
        vertices: [m], shape (n, 3).
        corners: indices, shape (m, 3).
        texture_size: extent of one image [m].
    """
    points, faces = np.asarray(vertices, dtype=np.float64), np.asarray(corners, dtype=np.int64).reshape(-1, 3)
    flat = points[faces].reshape(-1, 3)
    return Mesh(_f(flat), corner_normals(points, faces).reshape(-1, 3), _f(flat[:, :2] / texture_size))


def smooth(
    vertices: NDArray[np.float64],
    corners: NDArray[np.integer],
    normals: NDArray[np.float64],
    texcoords: NDArray[np.float64] | None,
    texture_size: tuple[float, float],
) -> Mesh:
    """A triangle mesh with normals and, if it has any, texture coordinates of its vertices, one row each.

    `corners`: indices, shape (3 m,). `texture_size`: extent of one image, which is else projected from above [m].
    """
    points = np.asarray(vertices, dtype=np.float64)
    places = points[:, :2] / texture_size if texcoords is None else texcoords
    return Mesh(_f(points), _f(normals), _f(places), np.ascontiguousarray(corners, dtype=np.uint32))


def heightfield(heights: ArrayLike, extent: tuple[float, ...], texture_size: tuple[float, float]) -> Mesh:
    """Ground of varying height, centred: heights [m], shape (rows, columns), rows along +y, columns along +x."""
    x_size, y_size = extent
    z = np.asarray(heights, dtype=np.float64)
    rows, columns = z.shape
    x, y = np.linspace(-x_size / 2.0, x_size / 2.0, columns), np.linspace(-y_size / 2.0, y_size / 2.0, rows)
    xs, ys = np.meshgrid(x, y)
    dz_dy, dz_dx = np.gradient(z, y, x)
    vertices = np.stack([xs, ys, z], axis=-1).reshape(-1, 3)
    normals = np.stack([-dz_dx, -dz_dy, np.ones_like(z)], axis=-1).reshape(-1, 3)
    return Mesh(_f(vertices), units(normals), _f(vertices[:, :2] / texture_size), _patches(columns - 1, rows - 1))


def ring(radii: NDArray[np.float64], segments: int, texture_size: tuple[float, float]) -> Mesh:
    """A flat ring around the origin, facing +z, of circles with these radii [m], from the inside outwards."""
    zero, one = np.zeros(len(radii), dtype=np.float32), np.ones(len(radii), dtype=np.float32)
    flat = _revolved(_f(radii[::-1]), zero, zero, one, one, segments)
    return flat._replace(texcoords=_f(flat.vertices[:, :2] / texture_size))
