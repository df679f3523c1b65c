"""OrientedBoxd: a box in any pose."""

from __future__ import annotations

from libgz.base.geometry import GzCoordPositionSub, GzPose, VectorLike
from libgz.classic.math.pose import Pose3d
from libgz.classic.math.vector3 import Vector3d

__all__ = ["OrientedBox", "OrientedBoxd"]


class OrientedBoxd:
    """A box of a size [m], with its centre at a pose."""

    __slots__ = ("_pose", "_size")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, size: VectorLike | OrientedBoxd = (0.0, 0.0, 0.0), pose: GzPose | None = None) -> None:
        lengths: VectorLike = size.Size() if isinstance(size, OrientedBoxd) else size
        place = size.Pose() if isinstance(size, OrientedBoxd) else pose
        self._size = Vector3d(*(abs(length) for length in lengths))
        self._pose = Pose3d(place) if place is not None else Pose3d()

    def Size(self, size: VectorLike | None = None) -> Vector3d:
        """The lengths of the sides [m]; an argument sets them first."""
        if size is not None:
            self._size = Vector3d(*(abs(length) for length in size))
        return self._size

    def Pose(self, pose: GzPose | None = None) -> Pose3d:
        """The pose of the centre [m]; an argument sets it first."""
        if pose is not None:
            self._pose = Pose3d(pose)
        return self._pose

    def XLength(self) -> float:
        """The length along its x axis [m]."""
        return self._size.x

    def YLength(self) -> float:
        """The length along its y axis [m]."""
        return self._size.y

    def ZLength(self) -> float:
        """The length along its z axis [m]."""
        return self._size.z

    def Volume(self) -> float:
        """The volume [m^3]."""
        return self._size.x * self._size.y * self._size.z

    def Contains(self, point: VectorLike) -> bool:
        """Whether a point [m] lies in it, or on its surface."""
        inside = GzCoordPositionSub(point, self._pose.pos, self._pose.rot)
        return all(abs(p) <= 0.5 * length for p, length in zip(inside, self._size, strict=True))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, OrientedBoxd):
            return NotImplemented
        return self._size == other._size and self._pose == other._pose

    def __repr__(self) -> str:
        return f"OrientedBoxd({self._size!r}, {self._pose!r})"


OrientedBox = OrientedBoxd
