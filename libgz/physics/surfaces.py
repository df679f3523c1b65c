"""Ground made of triangles, and points that are only rendered: TerrainGeom, RoadGeom, PointSetGeom."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzVector, VectorLike
from libgz.physics.body import Body
from libgz.physics.check import finite, finite_tuple, positive, table
from libgz.physics.geom import Geom
from libgz.physics.geoms import TriMeshGeom
from libgz.physics.meshes import (
    catmull_rom,
    catmull_rom_slopes,
    grid_strip,
    grid_triangles,
    triangle_normals,
    vertex_normals,
)
from libgz.physics.space import Space

__all__ = ["PointSetGeom", "RoadGeom", "TerrainGeom"]

GRID = 0.5  # between vertices of a road, along and across [m]
HALF_WIDTH = 16  # vertices on either side of a road's middle
FINEST = 1e-3  # [m] between points of a road, which numbers of 32 bits count
FOOT = 0.10  # how far below z = 0 the edges of a road lie [m]
EDGE = 2  # profile points on either side that are moved down to there


class _GroundGeom(TriMeshGeom):
    """A mesh that is set after construction; until then nothing touches the geom."""

    def __init__(self, body: Body, space: Space | None) -> None:
        Geom.__init__(self, body, space)
        self._data = None
        self.vertices = np.zeros((0, 3))
        self.triangles = np.zeros((0, 3), dtype=np.uint32)


class TerrainGeom(_GroundGeom):
    """Hilly ground: a triangle mesh, set by `Load` or `LoadGrid`."""

    strip: NDArray[np.uint32] | None = None  # the same mesh as one triangle strip, for rendering

    def Load(self, packedVertices: ArrayLike, stripIndices: ArrayLike, odeIndices: ArrayLike) -> None:
        """Set the mesh.

        Triangles that name a vertex out of range, or have no area, are left out.

        Args:
            packedVertices: texture s, t, colour r, g, b, a, normal x, y, z, position x, y, z [m]; shape (n, 12).
            stripIndices: one triangle strip for rendering, shape (k,).
            odeIndices: triangles, counter-clockwise seen from above, shape (m, 3) or (3 m,).

        Raises:
            ParameterError: no triangle is left, or a number is not finite.
        """
        packed = table(packedVertices, 12, "vertices").astype(np.float64)
        if not np.isfinite(packed).all():
            raise ParameterError("a vertex of the terrain is not finite")
        triangles = table(odeIndices, 3, "triangles").astype(np.int64)
        strip = np.array(stripIndices, dtype=np.int64).ravel()
        triangles = triangles[((triangles >= 0) & (triangles < len(packed))).all(axis=1)]
        triangles = triangles[triangle_normals(packed[:, 9:], triangles).any(axis=1)]
        self.strip = strip[(strip >= 0) & (strip < len(packed))].astype(np.uint32)
        self.texture_coordinates, self.colors, self.normals = packed[:, 0:2], packed[:, 2:6], packed[:, 6:9]
        self.set_mesh(packed[:, 9:], triangles)

    def LoadGrid(
        self,
        heights: ArrayLike,
        spacing: float,
        repeats: tuple[float, float] = (1.0, 1.0),
        *,
        centred: bool = False,
    ) -> None:
        """Set heights on a square grid.

        Args:
            heights: [m], shape (rows, columns): rows along +y, columns along +x.
            spacing: between neighbours [m].
            repeats: how often a texture repeats over the whole in x and y.
            centred: whether the origin is the middle of the grid, not its first corner.

        Raises:
            ParameterError: there are fewer than 2 x 2 heights, or one is not finite.
        """
        z = np.array(heights, dtype=np.float64)
        if z.ndim != 2 or min(z.shape) < 2:
            raise ParameterError(f"heights have shape {z.shape}; at least 2 x 2 are needed")
        rows, columns = z.shape
        packed = np.zeros((z.size, 12))
        column, row = np.meshgrid(np.arange(columns), np.arange(rows))
        middle = ((columns - 1) / 2.0, (rows - 1) / 2.0) if centred else (0.0, 0.0)
        packed[:, 9:] = np.stack([column - middle[0], row - middle[1], z], axis=-1).reshape(-1, 3)
        packed[:, 9:11] *= positive(spacing, "vertex spacing [m]")
        share = np.stack([column / (columns - 1), row / (rows - 1)], axis=-1).reshape(-1, 2)
        packed[:, 0:2] = share * np.array(repeats)
        packed[:, 2:6] = 1.0
        triangles = grid_triangles(rows, columns)
        packed[:, 6:9] = vertex_normals(packed[:, 9:], triangles)
        self.Load(packed, grid_strip(rows, columns), triangles)


class RoadGeom(_GroundGeom):
    """A road of 16 m: a smooth curve through track points, carrying a smooth profile across.

    Add points, then call `UpdateMesh`. A vertex is the point of the curve, moved sideways, plus the height of the
    profile there; curves are Catmull-Rom splines. The outermost two points of each profile are put below z = 0, so that
    the road is an embankment on the plane.
    """

    def __init__(self, body: Body, space: Space | None) -> None:
        super().__init__(body, space)
        self.signs: list[tuple[GzVector, str]] = []  # position [m] and text
        self._track: list[tuple[float, ...]] = []
        self._distances: list[float | None] = []
        self._profiles: list[list[float]] = []
        self._track_spacing: float | None = None
        self._profile_spacing = 1.0

    def SetTrackSpacing(self, spacing: float) -> None:
        """Length of the curve's parameter from one track point to the next [m]."""
        self._track_spacing = _spacing(spacing, "track spacing [m]")

    def SetProfileSpacing(self, spacing: float) -> None:
        """Distance between the points of a profile [m]."""
        self._profile_spacing = _spacing(spacing, "profile spacing [m]")

    def AddTrackPoint(self, point: VectorLike, distance: float | None = None) -> int:
        """A point that the middle of the road passes through [m]; its index.

        `distance` is how far along the road it lies [m]; it counts where no track spacing is set.
        """
        self._track.append(finite_tuple(point, 3, "track point [m]"))
        self._distances.append(None if distance is None else finite(distance, "distance [m]"))
        self._profiles.append([])
        return len(self._track) - 1

    def AddProfilePoint(self, index: int, pz: float) -> None:
        """The next height across the road at a track point [m], relative to that point, from right to left.

        Raises:
            ParameterError: there is no such track point.
        """
        if not 0 <= index < len(self._profiles):
            raise ParameterError(f"there is no track point {index}; there are {len(self._profiles)}")
        self._profiles[index].append(finite(pz, "profile height [m]"))

    def AddSign(self, point: VectorLike, text: str) -> None:
        """A sign with a text; the point is where its foot is [m]."""
        self.signs.append((GzVector(*finite_tuple(point, 3, "sign [m]")), text))

    def UpdateMesh(self, point: VectorLike = (0.0, 0.0, 0.0)) -> None:
        """Build the mesh. `point`, about which the legacy server rendered a part of it, has no effect.

        The curve needs a point beyond each end: the road goes from the second to the last but one.

        Raises:
            ParameterError: there are fewer than four track points, or their distances do not increase.
        """
        track = np.array(self._track).reshape(-1, 3)
        if len(track) < 4:
            raise ParameterError(f"a road has {len(track)} track points; it needs at least 4")
        along = self._parameters()
        s = np.arange(along[1], along[-2] + 1e-9, GRID)
        first = np.clip(np.searchsorted(along, s, side="right") - 1, 1, len(track) - 3)
        u = (s - along[first]) / (along[first + 1] - along[first])
        four = first[:, None] + np.arange(-1, 3)
        middle = np.einsum("ik,ikd->id", catmull_rom(u), track[four])
        tangent = np.einsum("ik,ikd->id", catmull_rom_slopes(u), track[four])[:, :2]
        tangent /= np.maximum(np.linalg.norm(tangent, axis=1, keepdims=True), 1e-9)
        heights = np.einsum("ik,ikj->ij", catmull_rom(u), self._cross_sections(track)[four])
        across = GRID * np.arange(-HALF_WIDTH, HALF_WIDTH + 1)
        vertices = np.stack(
            [
                middle[:, 0, None] - tangent[:, 1, None] * across,
                middle[:, 1, None] + tangent[:, 0, None] * across,
                middle[:, 2, None] + heights,
            ],
            axis=-1,
        ).reshape(-1, 3)
        triangles = grid_triangles(len(s), len(across))[:, ::-1]
        self.normals = vertex_normals(vertices, triangles)
        size = self.appearance.texture_size
        i, j = np.meshgrid(GRID * np.arange(len(s)) / size.x, GRID * np.arange(len(across)) / size.y, indexing="ij")
        self.texture_coordinates = np.stack([i, j], axis=-1).reshape(-1, 2)
        self.set_mesh(vertices, triangles)

    def _parameters(self) -> NDArray[np.float64]:
        """The curve's parameter at each track point [m]."""
        known = [distance for distance in self._distances if distance is not None]
        if self._track_spacing is not None or len(known) < len(self._track):
            return np.arange(len(self._track), dtype=np.float64) * (self._track_spacing or 5.0)
        distances = np.array(known, dtype=np.float64)
        if (np.diff(distances) <= 0.0).any():
            at = int(np.argmax(np.diff(distances) <= 0.0))
            raise ParameterError(f"track point {at + 1} lies at {known[at + 1]:g} m, not beyond {known[at]:g} m")
        return distances

    def _cross_sections(self, track: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights across the road at each track point [m], relative to it, shape (n, 33)."""
        across = GRID * np.arange(-HALF_WIDTH, HALF_WIDTH + 1)
        sections = np.zeros((len(track), len(across)))
        for i, profile in enumerate(self._profiles):
            if not profile:
                continue
            points = np.array(profile)
            points[:EDGE] = points[-EDGE:] = -track[i, 2] - FOOT
            place = across / self._profile_spacing
            whole = np.floor(place).astype(np.int64)
            four = np.clip(whole[:, None] + len(points) // 2 + np.arange(-1, 3), 0, len(points) - 1)
            sections[i] = np.einsum("jk,jk->j", catmull_rom(place - whole), points[four])
        return sections


def _spacing(value: float, what: str) -> float:
    spacing = positive(value, what)
    if spacing < FINEST:
        raise ParameterError(f"{what} is {spacing:g}; it must be at least {FINEST:g}")
    return spacing


class PointSetGeom(Geom):
    """Points that are only rendered.

    Args:
        body: which they follow.
        space: the model's space; nothing touches the points.
        n: how many.
        points: in the geom's frame [m], shape (n, 3).
    """

    def __init__(self, body: Body, space: Space | None, n: int, points: ArrayLike) -> None:
        super().__init__(body, space)
        self.points: NDArray[np.float64] = np.array(points, dtype=np.float64).reshape(-1, 3)
        if len(self.points) != n or not np.isfinite(self.points).all():
            raise ParameterError(f"a point set of {n} got {len(self.points)} points; all must be given and finite")
