"""RayProximity: a bundle of rays fixed to a body, for laser scanners and sonars."""

from __future__ import annotations

import sys
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPositionAdd, GzVector, VectorLike, rotate
from libgz.base.records import CastRecord
from libgz.ode.context import RayScan
from libgz.physics.body import Body
from libgz.physics.check import finite_tuple
from libgz.physics.engine import HasEngine
from libgz.physics.geom import Geom

__all__ = ["RayProximity"]


class RayProximity:
    """Rays from a body into the world; they hit all geoms but those of the body itself.

    Args:
        world: the World.
        body: what the rays are fixed to.
        rayCount: how many.

    Raises:
        ParameterError: there are none, or with them too many rays in the world.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_numbers",)

    def __init__(self, world: HasEngine, body: Body, rayCount: int) -> None:
        if rayCount < 1:
            raise ParameterError(f"a ray sensor has {rayCount} rays; it needs at least one")
        self.engine = world.engine
        self.body = body
        self.engine.rays.set(self, rayCount)
        self._rays = np.zeros((rayCount, 7))
        self._rays[:, 3] = self._rays[:, 6] = 1.0
        self.ranges: NDArray[np.float64] = np.full(rayCount, sys.float_info.max)
        self.rows: NDArray[np.int64] = np.full(rayCount, -1, dtype=np.int64)
        self._frame = np.zeros(7)
        self._scan = self.engine.scanner(RayScan(self._frame, self._rays, body.number, self.ranges, self.rows))
        self.engine.ray_bundles.add(self)
        self.engine.note_made(self)

    def close(self) -> None:
        """Take the rays out of what renderers show. Can be called twice."""
        self.engine.ray_bundles.discard(self)
        self.engine.rays.set(self, 0)

    @property
    def _numbers(self) -> bytes:
        """The rays, and what they hit, as bytes: an array each would take longer to save."""
        return self._rays.tobytes() + self.ranges.tobytes() + self.rows.tobytes()

    @_numbers.setter
    def _numbers(self, data: bytes) -> None:
        count = len(self.ranges)
        self._rays[:] = np.frombuffer(data, np.float64, 7 * count).reshape(count, 7)
        self.ranges[:] = np.frombuffer(data, np.float64, count, 56 * count)
        self.rows[:] = np.frombuffer(data, np.int64, count, 64 * count)

    def SetRay(self, index: int, a: VectorLike, b: VectorLike) -> None:
        """Place a ray in the body frame, from `a` to `b` [m].

        Raises:
            ParameterError: both are the same point, or not finite.
        """
        start, end = np.array(finite_tuple(a, 3, "ray start [m]")), np.array(finite_tuple(b, 3, "ray end [m]"))
        length = float(np.linalg.norm(end - start))
        if length < 1e-9:
            raise ParameterError(f"ray {index} has no length: it starts and ends at {tuple(start)}")
        self._rays[index, :3], self._rays[index, 3:6], self._rays[index, 6] = start, (end - start) / length, length

    def GetRay(self, index: int) -> tuple[GzVector, GzVector]:
        """(start [m], unit direction) of a ray, global."""
        pose = self.body.GetPose()
        start, direction = self._rays[index, :3].tolist(), self._rays[index, 3:6].tolist()
        return GzCoordPositionAdd(start, pose.pos, pose.rot), rotate(pose.rot, direction)

    @property
    def rays(self) -> NDArray[np.float64]:
        """Start [m], unit direction and length [m] of each ray in the body frame, shape (n, 7)."""
        return self._rays

    def Update(self) -> None:
        """Cast all rays from where the body is now."""
        self._frame[:] = self.body.frame()
        self._scan()

    def record(self) -> CastRecord:
        """What native updates need to cast the rays; it points into this object."""
        frame, rays, ranges, rows = (a.ctypes.data for a in (self._frame, self._rays, self.ranges, self.rows))
        handle = (1 << 64) - 1 if self.body.closed else self.body.id
        return CastRecord(self.body.row, handle, frame, rays, len(self.ranges), self.body.number, ranges, rows)

    def segments(self) -> NDArray[np.float64]:
        """Global ends of all rays, as far as they reached in the last `Update` [m], shape (n, 2, 3)."""
        pose = self.body.GetPose()
        axes = np.array([rotate(pose.rot, axis) for axis in np.eye(3)])
        starts = self._rays[:, :3] @ axes + pose.pos
        reach = np.minimum(self.ranges, self._rays[:, 6])[:, None]
        return np.stack([starts, starts + self._rays[:, 3:6] @ axes * reach], axis=1)

    def GetRange(self, index: int) -> float:
        """Distance from the ray's start [m]; the largest float if it hit nothing."""
        return float(self.ranges[index])

    def hits(self) -> list[tuple[int, int, Geom | None]]:
        """What was hit in the last `Update`: (first ray, ray after the last, geom) of neighbours that hit the same.

        The geom is None where nothing was hit, and where it was destroyed since.
        """
        rows = self.rows
        ends = (np.flatnonzero(rows[1:] != rows[:-1]) + 1).tolist()
        starts = [0, *ends]
        find = self.engine.geoms.get
        return [(i, j, find(row)) for i, j, row in zip(starts, [*ends, len(rows)], rows[starts].tolist(), strict=True)]

    def unmarked(self) -> bool:
        """Whether no ray hit a geom that reflects laser beams or has a fiducial number in the last `Update`."""
        hit = self.rows[self.rows >= 0]
        return not self.engine.tables.geoms.marks[hit].any()

    def GetRetro(self, index: int) -> float:
        """How much the geom that was hit reflects back; 0 if nothing was hit, or the geom was destroyed since."""
        geom = self.engine.geoms.get(int(self.rows[index]))
        return geom.GetRetro() if geom is not None else 0.0

    def GetFiducial(self, index: int) -> int:
        """The fiducial number of the geom that was hit; -1 for none."""
        geom = self.engine.geoms.get(int(self.rows[index]))
        return geom.GetFiducial() if geom is not None else -1
