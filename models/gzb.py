"""Terrain files (.gzb): vertices, a strip for rendering, and triangles for collisions, as big-endian 32-bit integers.

Ten integers come first: version 500, six zeros, and the counts of vertices, strip indices and triangle indices; then
twelve integers for each vertex, each a thousand times its value; then the indices.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError
from libgz.base.files import read_file
from libgz.physics.meshes import triangle_normals

__all__ = ["GzbFile", "read_gzb", "write_gzb"]

VERSION = 500
HEADER = 10  # integers
RECORD = 12  # integers per vertex: texture s t, colour r g b a, normal x y z, position x y z [m]
SCALE = 1000.0
NONE = np.iinfo(np.int32).min  # marks an absent value


@dataclass
class GzbFile:
    """The contents of a terrain file."""

    vertices: NDArray[np.float64]  # shape (n, 12)
    strip: NDArray[np.int64]  # shape (k,)
    triangles: NDArray[np.int64]  # shape (m, 3)
    damage: list[str] = field(default_factory=list)  # descriptions of the damage


def read_gzb(path: Path) -> GzbFile:
    """Read a terrain; damaged indices are repaired where possible, and reported in `damage`.

    Raises:
        ParameterError: the file cannot be read, or is not a terrain file.
    """
    try:
        data = read_file(path)
    except OSError as error:
        raise ParameterError(f"cannot read terrain {str(path)!r}: {error.strerror}") from None
    numbers = np.frombuffer(data, dtype=">i4", count=len(data) // 4)
    if len(numbers) < HEADER or numbers[0] != VERSION:
        raise ParameterError(f"{str(path)!r} is not a terrain file: it does not begin with the number {VERSION}")
    vertex_count, strip_count, corner_count = (int(n) for n in numbers[7:10])
    needed = 4 * (HEADER + RECORD * vertex_count + strip_count + corner_count)
    if min(vertex_count, strip_count, corner_count) < 0 or corner_count % 3 or needed > len(data):
        raise ParameterError(
            f"terrain {str(path)!r} has {len(data)} bytes; its counts, {vertex_count} vertices, {strip_count} strip "
            f"indices and {corner_count} triangle indices, need {needed} bytes; create the file again"
        )
    records, indices = np.split(numbers[HEADER : needed // 4], [RECORD * vertex_count])
    vertices = np.where(records == NONE, 0.0, records / SCALE).reshape(-1, RECORD)
    strip, corners = np.split(indices.astype(np.int64), [strip_count])
    terrain = GzbFile(vertices, strip, corners.reshape(-1, 3))
    _repair(terrain)
    return terrain


def _repair(terrain: GzbFile) -> None:
    """Repair indices damaged by a conversion of line ends: bytes 0D became 0A, so some vertices are not used.

    A triangle that would be smaller with the unused vertex, or face up instead of down, gets that vertex. Damaged
    coordinates of vertices cannot be recognised.
    """
    count, triangles = len(terrain.vertices), terrain.triangles
    points = terrain.vertices[:, 9:]
    outside = (triangles < 0) | (triangles >= count)
    if outside.any():
        terrain.damage.append(f"{int(outside.any(axis=1).sum())} triangles refer to a vertex that does not exist")
        triangles = terrain.triangles = triangles[~outside.any(axis=1)]
    unused = np.setdiff1d(np.arange(count), triangles)
    repaired = 0
    for vertex in unused.tolist():
        as_damaged = int.from_bytes(vertex.to_bytes(4, "big").replace(b"\x0d", b"\x0a"), "big")
        if as_damaged == vertex:
            continue
        rows, corner = np.nonzero(triangles == as_damaged)
        meant = triangles[rows]
        meant[np.arange(len(rows)), corner] = vertex
        old, new = (_shape(points, candidates) for candidates in (triangles[rows], meant))
        better = ((old[0] < 0.0) & (new[0] > 0.0)) | ((new[0] > 0.0) & (new[1] < old[1]))
        triangles[rows[better], corner[better]] = vertex
        repaired += int(better.sum())
    if repaired:
        terrain.damage.append(f"{repaired} corners of triangles referred to a wrong vertex and were repaired")
    downward = int((triangle_normals(points, triangles)[:, 2] < 0.0).sum())
    if downward:
        terrain.damage.append(f"{downward} of {len(triangles)} triangles face down")


def _shape(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(z of each triangle's normal, -1 to 1; length of its border [m])."""
    corners = points[triangles]
    border = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).sum(axis=1)
    return triangle_normals(points, triangles)[:, 2], border


def write_gzb(path: Path, vertices: ArrayLike, strip: ArrayLike, triangles: ArrayLike) -> None:
    """Write a terrain with values rounded to a thousandth. Arguments as in `TerrainGeom.Load`.

    Raises:
        ParameterError: an index is out of range.
    """
    records = np.array(vertices, dtype=np.float64).reshape(-1, RECORD)
    strips, corners = np.array(strip, dtype=np.int64).ravel(), np.array(triangles, dtype=np.int64).ravel()
    for indices in (strips, corners):
        if indices.size and not 0 <= indices.min() <= indices.max() < len(records):
            raise ParameterError(f"an index of the terrain is out of range; there are {len(records)} vertices")
    head = [VERSION, 0, 0, 0, 0, 0, 0, len(records), len(strips), len(corners)]
    values = np.rint(records.ravel() * SCALE).astype(np.int64)
    path.write_bytes(np.concatenate([np.array(head), values, strips, corners]).astype(">i4").tobytes())
