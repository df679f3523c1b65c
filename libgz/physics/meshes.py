"""Arithmetic on triangle meshes: grids, strips, normals, and curves through points."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Mesh",
    "catmull_rom",
    "catmull_rom_slopes",
    "corner_normals",
    "grid_strip",
    "grid_triangles",
    "grid_vertices",
    "triangle_normals",
    "units",
    "vertex_normals",
]

STRIP = 1 << 17  # triangles or vertices whose normals are computed at once
CREASE = math.cos(math.radians(40.0))  # edges sharper than this are rendered sharp
# Catmull-Rom: the curve between the middle two of four points is (1, u, u^2, u^3) M (four points), u from 0 to 1.
_CATMULL_ROM = 0.5 * np.array([[0, 2, 0, 0], [-1, 0, 1, 0], [2, -5, 4, -1], [-1, 3, -3, 1]], dtype=np.float64)


@dataclass(eq=False, repr=False)
class Mesh:
    """Vertices [m], shape (n, 3), and the numbers of the corners of triangles, shape (m, 3)."""

    vertices: NDArray[np.float64]
    triangles: NDArray[np.uint32]


def grid_triangles(rows: int, columns: int) -> NDArray[np.uint32]:
    """Two triangles for each cell of a grid whose vertices are numbered row by row, shape (m, 3).

    They are counter-clockwise where columns run along x, rows along y.
    """
    found = np.empty((rows - 1, columns - 1, 6), dtype=np.uint32)
    found[..., 0] = np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)
    for k, offset in enumerate((1, columns + 1, 0, columns + 1, columns), start=1):
        np.add(found[..., 0], np.uint32(offset), out=found[..., k])
    return found.reshape(-1, 3)


def grid_vertices(x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vertices of a grid [m], shape (n, 3), row by row, from the x of its columns, the y of its rows, and each z."""
    vertices = np.empty((*z.shape, 3))
    vertices[..., 0], vertices[..., 1], vertices[..., 2] = x, y[:, None], z
    return vertices.reshape(-1, 3)


def grid_strip(rows: int, columns: int) -> NDArray[np.int64]:
    """The same grid as one triangle strip; doubled indices lead from row to row."""
    strip: list[NDArray[np.int64]] = []
    for row in range(rows - 1):
        pairs = row * columns + np.arange(columns)
        band = np.stack([pairs + columns, pairs], axis=1).ravel()
        strip += [band[:1], band, band[-1:]]
    return np.concatenate(strip)[1:-1]


def corner_normals(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float32]:
    """Unit normals of the corners of triangles, smooth at shallow edges, sharp at steep ones, shape (m, 3, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)  # twice the area long, so that large triangles count more
    sums = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(sums, triangles[:, k], across)
    face, smooth = units(across)[:, None, :], units(sums)[triangles]
    bends_little = np.einsum("ijk,ijk->ij", np.broadcast_to(face, smooth.shape), smooth) > CREASE
    return np.ascontiguousarray(np.where(bends_little[..., None], smooth, face), dtype=np.float32)


def units(vectors: ArrayLike) -> NDArray[np.float32]:
    """Vectors of length 1 in the same directions; those without a length stay zero."""
    given = np.asarray(vectors, dtype=np.float64)
    lengths = np.linalg.norm(given, axis=-1, keepdims=True)
    return np.ascontiguousarray(
        np.divide(given, lengths, out=np.zeros_like(given), where=lengths > 1e-30), dtype=np.float32
    )


def triangle_normals(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Unit normals of triangles, shape (m, 3); zero for those without area."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    result: NDArray[np.float64] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 1e-12)
    return result


def vertex_normals(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> NDArray[np.float64]:
    """Unit normals of vertices, shape (n, 3): the sum of those of the triangles around them."""
    sums = np.zeros((3, len(vertices)))
    for first in range(0, len(triangles), STRIP):  # what is computed on the way is larger than the mesh
        some = triangles[first : first + STRIP]
        faces = np.repeat(triangle_normals(vertices, some), 3, axis=0)
        for total, part in zip(sums, faces.T, strict=True):
            np.add.at(total, some.ravel(), part)
    result: NDArray[np.float64] = np.ascontiguousarray(sums.T)
    for first in range(0, len(result), STRIP):
        rows = result[first : first + STRIP]
        lengths = np.linalg.norm(rows, axis=1, keepdims=True)
        rows[:] = np.divide(rows, lengths, out=np.zeros_like(rows), where=lengths > 1e-12)
    return result


def catmull_rom(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of four points at the parameters `u` between the middle two, shape (n, 4)."""
    return np.stack([np.ones_like(u), u, u * u, u**3], axis=-1) @ _CATMULL_ROM


def catmull_rom_slopes(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """Weights of four points that give the curve's derivative by `u`, shape (n, 4)."""
    return np.stack([np.zeros_like(u), np.ones_like(u), 2.0 * u, 3.0 * u * u], axis=-1) @ _CATMULL_ROM
