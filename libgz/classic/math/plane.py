"""Planed: a plane, and the side of it on which something lies."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from libgz.base.errors import ParameterError
from libgz.base.geometry import VectorLike
from libgz.classic.math.box import AxisAlignedBox
from libgz.classic.math.vector2 import Vector2d
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Plane", "PlaneSide", "Planed"]

PARALLEL = 1e-3  # least sine of the angle between a line and the plane


class PlaneSide(IntEnum):
    """Where something lies."""

    NEGATIVE_SIDE = 0
    POSITIVE_SIDE = 1
    NO_SIDE = 2
    BOTH_SIDE = 3


class Planed:
    """The plane normal . p = offset [m], infinite, or with a size [m] for what shows it."""

    NEGATIVE_SIDE, POSITIVE_SIDE = PlaneSide.NEGATIVE_SIDE, PlaneSide.POSITIVE_SIDE
    NO_SIDE, BOTH_SIDE = PlaneSide.NO_SIDE, PlaneSide.BOTH_SIDE

    __slots__ = ("_normal", "_offset", "_size")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, *parts: Any) -> None:
        """Normal; normal and offset; or normal, size and offset; without arguments, a plane without a normal.

        Raises:
            ParameterError: it is none of these.
        """
        self._normal, self._size, self._offset = Vector3d(), Vector2d(), 0.0
        if parts:
            self.Set(*parts)

    def Set(self, *parts: Any) -> None:
        """Set them, from the constructor's arguments.

        Raises:
            ParameterError: it is none of these.
        """
        if not 1 <= len(parts) <= 3:
            raise ParameterError(f"a Planed takes normal, size and offset, not {parts!r}")
        self._normal = Vector3d(parts[0])
        self._size = Vector2d(*parts[1]) if len(parts) == 3 else Vector2d()
        self._offset = float(parts[-1]) if len(parts) > 1 else 0.0

    def Normal(self) -> Vector3d:
        """The normal, not a copy."""
        return self._normal

    def Size(self) -> Vector2d:
        """The size [m], not a copy."""
        return self._size

    def Offset(self) -> float:
        """The distance from the origin along the normal [m]."""
        return self._offset

    def Distance(self, point: VectorLike, direction: VectorLike | None = None) -> float:
        """The distance of a point [m], positive on the side of the normal.

        With a direction, how far the plane is along it, in multiples of its length; 0 for a parallel one.
        """
        if direction is None:
            return self._normal.Dot(point) - self._offset
        slope = self._normal.Dot(direction)
        return 0.0 if abs(slope) < PARALLEL else (self._offset - self._normal.Dot(point)) / slope

    def Intersection(self, point: VectorLike, gradient: VectorLike, tolerance: float = 1e-6) -> Vector3d | None:
        """The point where a line through a point [m] meets the plane; None for a parallel one."""
        slope = self._normal.Dot(gradient)
        if abs(slope) < tolerance:
            return None
        return Vector3d(point) + Vector3d(gradient) * ((self._offset - self._normal.Dot(point)) / slope)

    def Side(self, what: VectorLike | AxisAlignedBox) -> PlaneSide:
        """The side on which a point or a box lies."""
        if isinstance(what, AxisAlignedBox):
            half = what.Size() * 0.5
            reach = self._normal.AbsDot(half)
            distance = self.Distance(what.Center())
            if abs(distance) <= reach:
                return PlaneSide.BOTH_SIDE
        else:
            distance = self.Distance(what)
        if distance == 0.0:
            return PlaneSide.NO_SIDE
        return PlaneSide.POSITIVE_SIDE if distance > 0.0 else PlaneSide.NEGATIVE_SIDE

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Planed):
            return NotImplemented
        return (self._normal, self._size, self._offset) == (other._normal, other._size, other._offset)

    def __repr__(self) -> str:
        return f"Planed({self._normal!r}, {self._size!r}, {self._offset!r})"


Plane = Planed
