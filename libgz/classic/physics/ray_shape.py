"""RayShape and MultiRayShape: rays, with the nearest collision on each."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzCoordPositionAdd, GzPose, VectorLike, rotate
from libgz.classic.math import Angle, Vector3d
from libgz.physics.check import LARGEST, finite_tuple
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.world import World
    from libgz.physics.body import Body
    from libgz.physics.engine import Engine
    from libgz.physics.geom import Geom

__all__ = ["MultiRayShape", "RayShape", "ScanGrid"]

MOST_RAYS = 1_000_000  # of a MultiRayShape to which rays are added
NO_HIT = 1000.0  # [m] the distance that a ray without a hit returns, as in Gazebo


class RayShape:
    """One ray.

    Args:
        world: the world.
        link: the link that the ray is fixed to; None: the world frame.
    """

    def __init__(self, world: World, link: Link | None = None) -> None:
        self._world, self._link = world, link
        self._start, self._end = Vector3d(), Vector3d(1.0, 0.0, 0.0)
        self._length = 0.0
        self._hit: Geom | None = None

    def GetType(self) -> str:
        """``ray``."""
        return "ray"

    def SetPoints(self, posStart: VectorLike, posEnd: VectorLike) -> None:
        """Set start and end [m].

        Raises:
            ParameterError: both are the same point, or not finite, or out of range.
        """
        start, end = (Vector3d(*finite_tuple(point, 3, "end of a ray [m]", LARGEST)) for point in (posStart, posEnd))
        if start.Distance(end) < 1e-9:
            raise ParameterError(f"a ray has no length: it starts and ends at {tuple(start)}")
        self._start, self._end = start, end
        self._length, self._hit = start.Distance(end), None

    def RelativePoints(self) -> tuple[Vector3d, Vector3d]:
        """Start and end [m], in the frame of the link."""
        return Vector3d(*self._start), Vector3d(*self._end)

    def GlobalPoints(self) -> tuple[Vector3d, Vector3d]:
        """Start and end [m], in the world frame."""
        if self._link is None:
            return self.RelativePoints()
        pose = self._link.body.GetPose()
        start, end = (Vector3d(*GzCoordPositionAdd(p, pose.pos, pose.rot)) for p in (self._start, self._end))
        return start, end

    GetRelativePoints, GetGlobalPoints = RelativePoints, GlobalPoints

    def Update(self) -> None:
        """Cast the ray."""
        start, end = self.GlobalPoints()
        full = start.Distance(end)
        engine = self._world.core.engine
        direction = (np.array(end) - np.array(start)) / full
        ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
        frame, rays = np.array((*start, 1.0, 0.0, 0.0, 0.0)), np.array([[0.0, 0.0, 0.0, *direction, full]])
        engine.scan(frame, rays, 0, ranges, rows)
        self._hit = engine.geoms.get(int(rows[0]))
        self._length = float(ranges[0]) if self._hit is not None else full

    def GetIntersection(self) -> tuple[float, str]:
        """(distance [m], scoped name) of the nearest collision on the ray now; (1000, "") for none."""
        self.Update()
        if self._hit is None:
            return NO_HIT, ""
        collision = self._world.collision_of(self._hit)
        return self._length, collision.GetScopedName() if collision is not None else ""

    def GetLength(self) -> float:
        """The distance of the hit in the last Update [m]; the length of the ray if there was none."""
        return self._length

    def SetLength(self, length: float) -> None:
        """Set the distance that GetLength returns until the next Update [m]."""
        self._length = float(length)

    def GetRetro(self) -> float:
        """The laser retro value of the hit; 0 for none."""
        return self._hit.GetRetro() if self._hit is not None else 0.0

    def GetFiducial(self) -> int:
        """The fiducial number of the hit; -1 for none."""
        return self._hit.GetFiducial() if self._hit is not None else -1

    Length, Retro, Fiducial = GetLength, GetRetro, GetFiducial


MOST_OWN = 16  # surfaces of its own model that a ray passes before its minimum range
BEYOND = 1e-6  # [m] behind such a surface


class ScanGrid:
    """The directions of a scan: rows of rays, the lowest row first, each from `min_angle` to `max_angle`.

    Args:
        samples: number of rays in a row, and of rows.
        angles: ((lowest, highest) about z, (lowest, highest) above the horizon) [rad].
        reach: minimum and maximum range [m].
    """

    def __init__(
        self,
        samples: tuple[int, int],
        angles: tuple[tuple[float, float], tuple[float, float]],
        reach: tuple[float, float],
    ) -> None:
        self.samples, self.angles, self.reach = samples, angles, reach

    def rays(self, offset: GzPose) -> NDArray[np.float64]:
        """Start [m], direction and length [m] of all rays, shape (n, 7), in the frame that `offset` is given in."""
        return ray_table(self.directions(), self.reach, offset)

    def directions(self) -> NDArray[np.float64]:
        """Unit vectors along all rays, shape (n, 3), in the frame of the laser."""
        yaw, pitch = (
            np.linspace(*angles, samples) if samples > 1 else np.zeros(1)  # a single ray points along x
            for angles, samples in zip(self.angles, self.samples, strict=True)
        )
        up, around = (grid.ravel() for grid in np.meshgrid(pitch, yaw, indexing="ij"))
        return np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=1)

    @property
    def spacing(self) -> float:
        """The smallest angle between neighbouring rays of a row, or of a column [rad]; a right angle for one ray."""
        pairs = zip(self.angles, self.samples, strict=True)
        return min([abs(last - first) / (count - 1) for (first, last), count in pairs if count > 1] + [0.5 * np.pi])


def ray_table(directions: NDArray[np.float64], reach: tuple[float, float], offset: GzPose) -> NDArray[np.float64]:
    """Rays for `Engine.scan`, shape (n, 7), from `reach[0]` to `reach[1]` [m] along each direction."""
    turn = np.array([rotate(offset.rot, axis) for axis in np.eye(3)])
    near, far = reach
    rays = np.empty((len(directions), 7))
    rays[:, 3:6] = directions @ turn
    rays[:, :3] = rays[:, 3:6] * near + np.array(offset.pos)
    rays[:, 6] = far - near
    return rays


class MultiRayShape:
    """The rays of a laser, fixed to a link, or to the world; they also hit the link itself.

    Args:
        engine: the world's engine.
        body: the link; None: the world frame.
        offset: pose of the laser in the link frame [m].
        grid: the directions of the rays; None for none, until AddRay.
    """

    STATE = (
        "_rows",
        "_reached",
    )

    def __init__(self, engine: Engine, body: Body | None, offset: GzPose, grid: ScanGrid | None = None) -> None:
        self.body = body
        self._engine = engine
        self._scans = Event("NewLaserScans")
        if grid is None:
            self.grid = ScanGrid((0, 1), ((0.0, 0.0), (0.0, 0.0)), (0.0, sys.float_info.max))
            self._rays = np.empty((0, 7))
        else:
            self.grid = grid
            self._engine.rays.set(self, grid.samples[0] * grid.samples[1])
            self.place(offset)
        self._rows: NDArray[np.int64] = np.full(self.RayCount(), -1, dtype=np.int64)
        self._reached: NDArray[np.float64] = np.full(self.RayCount(), sys.float_info.max)

    def place(self, offset: GzPose) -> None:
        """Set the pose of the laser in the link frame [m]."""
        self._rays = self.grid.rays(offset)

    def GetType(self) -> str:
        """``multiray``."""
        return "multiray"

    def AddRay(self, start: VectorLike, end: VectorLike) -> None:
        """Add a ray between two points in the frame of the link, or of the world [m].

        Raises:
            ParameterError: both are the same point, or not finite, or out of range; or there are too many rays.
        """
        first, last = (np.array(finite_tuple(point, 3, "end of a ray [m]", LARGEST)) for point in (start, end))
        length = float(np.linalg.norm(last - first))
        if length < 1e-9:
            raise ParameterError(f"a ray has no length: it starts and ends at {tuple(first.tolist())}")
        if len(self._rays) >= MOST_RAYS:
            raise ParameterError(f"a MultiRayShape has at most {MOST_RAYS} rays")
        self._engine.rays.set(self, len(self._rays) + 1)
        self._rays = np.vstack([self._rays, np.array([*first, *((last - first) / length), length])])
        self._rows = np.append(self._rows, -1)
        self._reached = np.append(self._reached, sys.float_info.max)

    def Update(self) -> None:
        """Cast all rays, from the present pose of the link."""
        pose = self._frame()
        frame = np.array((*pose.pos, *pose.rot))
        self._engine.scan(frame, self._rays, 0, self._reached, self._rows)
        if self.grid.reach[0] > 0.0:
            self._stop_at_near(frame)
        if self._scans:
            self._scans()

    def _frame(self) -> GzPose:
        return GzPose() if self.body is None else self.body.GetPose()

    def _stop_at_near(self, frame: NDArray[np.float64]) -> None:
        """Let what stands nearer than the minimum range stop its rays there; parts of the laser's own model do not."""
        near, own = self._rays.copy(), None if self.body is None else _top(self.body)
        near[:, :3] -= near[:, 3:6] * self.grid.reach[0]
        near[:, 6] = self.grid.reach[0]
        which = np.arange(len(near))
        for _ in range(MOST_OWN):
            reached, rows = np.empty(len(near)), np.empty(len(near), dtype=np.int64)
            self._engine.scan(frame, near, 0, reached, rows)
            if rows.max() < 0:  # as nearly always
                return
            hit = [row for row in np.unique(rows).tolist() if self._known(row)]
            mine = [row for row in hit if _top(self._engine.geoms[row].body) is own]
            stopped, through = np.isin(rows, [row for row in hit if row not in mine]), np.isin(rows, mine)
            self._reached[which[stopped]], self._rows[which[stopped]] = 0.0, rows[stopped]
            step = reached[through] + BEYOND
            near, which = near[through], which[through]
            near[:, :3] += near[:, 3:6] * step[:, None]
            near[:, 6] -= step
            near, which = near[near[:, 6] > 0.0], which[near[:, 6] > 0.0]
            if not len(near):
                return

    def ComputeVolume(self) -> float:
        """The volume: 0, for rays have none [m^3]."""
        return 0.0

    def show(self, ranges: NDArray[np.float64]) -> None:
        """Take ranges that were measured otherwise [m], shape (n,)."""
        self._reached[:] = np.where(np.isfinite(ranges), ranges - self.grid.reach[0], sys.float_info.max)

    def ConnectNewLaserScans(self, callback: Callable[[], object]) -> Connection:
        """Call `callback` after each scan, as long as the connection is kept."""
        return self._scans.Connect(callback)

    def DisconnectNewLaserScans(self, connection: Connection) -> None:
        """End such a connection."""
        connection.Disconnect()

    # Readings ----------------------------------------------------------------------------------------------------

    def ranges(self) -> NDArray[np.float64]:
        """The distances of the hits from the laser [m]; the maximum range without a hit. Row by row, shape (n,)."""
        return np.minimum(self._reached + self.grid.reach[0], self.grid.reach[1])

    def retros(self) -> NDArray[np.float64]:
        """The laser retro values of the hits, 0 without a hit, shape (n,)."""
        values = {row: self._engine.geoms[row].GetRetro() for row in np.unique(self._rows).tolist() if self._known(row)}
        if not any(values.values()):
            return np.zeros(len(self._rows))
        return np.array([values.get(row, 0.0) for row in self._rows.tolist()])

    def _known(self, row: int) -> bool:
        return row >= 0 and row in self._engine.geoms

    def segments(self) -> NDArray[np.float64]:
        """Start of all rays, and their hits or ends [m], in the world frame, shape (n, 2, 3)."""
        pose = self._frame()
        axes = np.array([rotate(pose.rot, axis) for axis in np.eye(3)])
        starts = self._rays[:, :3] @ axes + pose.pos
        reach = np.minimum(self._reached, self._rays[:, 6])[:, None]
        return np.stack([starts, starts + self._rays[:, 3:6] @ axes * reach], axis=1)

    def _check(self, index: int) -> int:
        if not 0 <= index < len(self._rows):
            raise NotFoundError(f"index[{index}] out of range[0-{len(self._rows)}]")
        return index

    def Range(self, index: int) -> float:
        """The distance of the hit of a ray [m]; the maximum range without a hit.

        Raises:
            NotFoundError: there is no such ray.
        """
        return float(min(self._reached[self._check(index)] + self.grid.reach[0], self.grid.reach[1]))

    def Retro(self, index: int) -> float:
        """The laser retro value of the hit of a ray; 0 without a hit."""
        row = int(self._rows[self._check(index)])
        return self._engine.geoms[row].GetRetro() if self._known(row) else 0.0

    def Fiducial(self, index: int) -> int:
        """The fiducial number of the hit of a ray; -1 without a hit."""
        row = int(self._rows[self._check(index)])
        return self._engine.geoms[row].GetFiducial() if self._known(row) else -1

    GetRange, GetRetro, GetFiducial = Range, Retro, Fiducial

    # Description -------------------------------------------------------------------------------------------------

    def RayCount(self) -> int:
        """The number of rays."""
        return len(self._rays)

    def SampleCount(self) -> int:
        """The number of rays in a row."""
        return self.grid.samples[0]

    def VerticalSampleCount(self) -> int:
        """The number of rows."""
        return self.grid.samples[1]

    def MinRange(self) -> float:
        """The minimum range [m]."""
        return self.grid.reach[0]

    def MaxRange(self) -> float:
        """The maximum range [m]."""
        return self.grid.reach[1]

    def MinAngle(self) -> Angle:
        """The angle of the first ray of a row [rad]."""
        return Angle(self.grid.angles[0][0])

    def MaxAngle(self) -> Angle:
        """The angle of the last ray of a row [rad]."""
        return Angle(self.grid.angles[0][1])

    def VerticalMinAngle(self) -> Angle:
        """The elevation of the lowest row [rad]."""
        return Angle(self.grid.angles[1][0])

    def VerticalMaxAngle(self) -> Angle:
        """The elevation of the highest row [rad]."""
        return Angle(self.grid.angles[1][1])

    GetSampleCount, GetVerticalSampleCount = SampleCount, VerticalSampleCount
    GetMinRange, GetMaxRange = MinRange, MaxRange
    GetMinAngle, GetMaxAngle = MinAngle, MaxAngle
    GetVerticalMinAngle, GetVerticalMaxAngle = VerticalMinAngle, VerticalMaxAngle


def _top(body: Body) -> object:
    """The outermost model of a body, or the body itself."""
    found: object = body.model if body.model is not None else body
    while getattr(found, "parent", None) is not None:
        found = found.parent  # type: ignore[attr-defined]
    return found
