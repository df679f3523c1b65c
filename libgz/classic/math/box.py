"""AxisAlignedBox: a box along the axes, such as a bounding box."""

from __future__ import annotations

import math
from typing import Any, overload

from libgz.base.errors import ParameterError
from libgz.base.geometry import VectorLike
from libgz.classic.math.vector3 import Vector3d

__all__ = ["AxisAlignedBox", "Box"]


class AxisAlignedBox:
    """The box between two corners [m]. `AxisAlignedBox()` is empty: its lower corner lies above the upper one."""

    __slots__ = ("max", "min")
    __hash__ = None  # type: ignore[assignment]

    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, low: AxisAlignedBox, /) -> None: ...
    @overload
    def __init__(self, low: VectorLike, high: VectorLike, /) -> None: ...
    @overload
    def __init__(self, x1: float, y1: float, z1: float, x2: float, y2: float, z2: float, /) -> None: ...
    def __init__(self, *parts: Any) -> None:
        """From two opposite corners [m], in any order, as vectors or as six numbers; from another box; or empty.

        Raises:
            ParameterError: it is none of these.
        """
        if not parts:
            self.min, self.max = Vector3d(math.inf, math.inf, math.inf), Vector3d(-math.inf, -math.inf, -math.inf)
            return
        if len(parts) == 1 and isinstance(parts[0], AxisAlignedBox):
            self.min, self.max = Vector3d(parts[0].min), Vector3d(parts[0].max)
            return
        if len(parts) == 6:
            parts = (parts[:3], parts[3:])
        if len(parts) != 2:
            raise ParameterError(f"an AxisAlignedBox takes two corners, six numbers or a box, not {parts!r}")
        self.min, self.max = Vector3d(parts[0]), Vector3d(parts[0])
        self.min.Min(parts[1])
        self.max.Max(parts[1])

    def Min(self) -> Vector3d:
        """The lower corner [m], not a copy."""
        return self.min

    def Max(self) -> Vector3d:
        """The upper corner [m], not a copy."""
        return self.max

    def Center(self) -> Vector3d:
        """The centre [m]; of an empty box, NaN."""
        return (self.min + self.max) * 0.5

    def Size(self) -> Vector3d:
        """The lengths of the sides [m]; of an empty box, 0."""
        return Vector3d(self.XLength(), self.YLength(), self.ZLength())

    def XLength(self) -> float:
        """The length along x [m]."""
        return max(0.0, self.max.x - self.min.x)

    def YLength(self) -> float:
        """The length along y [m]."""
        return max(0.0, self.max.y - self.min.y)

    def ZLength(self) -> float:
        """The length along z [m]."""
        return max(0.0, self.max.z - self.min.z)

    def Volume(self) -> float:
        """The volume [m^3]."""
        return self.XLength() * self.YLength() * self.ZLength()

    def Merge(self, other: AxisAlignedBox) -> None:
        """Extend it so that it contains another box."""
        self.min.Min(other.min)
        self.max.Max(other.max)

    def Contains(self, point: VectorLike) -> bool:
        """Whether a point [m] lies in it, or on its surface."""
        return all(a <= p <= b for a, p, b in zip(self.min, point, self.max, strict=True))

    def Intersects(self, other: AxisAlignedBox) -> bool:
        """Whether two boxes have a point in common; their surfaces are included."""
        return all(a <= d and c <= b for a, b, c, d in zip(self.min, self.max, other.min, other.max, strict=True))

    def Intersect(self, origin: VectorLike, dir: VectorLike, min: float, max: float) -> tuple[bool, float, Vector3d]:
        """(whether a ray meets the box between two distances [m], the distance, the point).

        The distance is 0, and the point the origin, if it does not.
        """
        direction, near, far = Vector3d(dir).Normalize(), float(min), float(max)
        for start, step, low, high in zip(origin, direction, self.min, self.max, strict=True):
            if step == 0.0:
                if not low <= start <= high:
                    return False, 0.0, Vector3d()
                continue
            ends = sorted(((low - start) / step, (high - start) / step))
            near, far = (ends[0] if ends[0] > near else near), (ends[1] if ends[1] < far else far)
        if near > far:
            return False, 0.0, Vector3d()
        return True, near, Vector3d(origin) + direction * near

    def IntersectCheck(self, origin: VectorLike, dir: VectorLike, min: float, max: float) -> bool:
        """Whether a ray meets the box between two distances [m]."""
        return self.Intersect(origin, dir, min, max)[0]

    def IntersectDist(self, origin: VectorLike, dir: VectorLike, min: float, max: float) -> tuple[bool, float]:
        """(whether a ray meets the box between two distances [m], the distance)."""
        return self.Intersect(origin, dir, min, max)[:2]

    def __add__(self, other: AxisAlignedBox) -> AxisAlignedBox:
        if not isinstance(other, AxisAlignedBox):
            return NotImplemented
        both = AxisAlignedBox(self)
        both.Merge(other)
        return both

    def __sub__(self, offset: VectorLike) -> AxisAlignedBox:
        return AxisAlignedBox(self.min - offset, self.max - offset)

    def __eq__(self, other: object) -> bool:
        return self.min == other.min and self.max == other.max if isinstance(other, AxisAlignedBox) else NotImplemented

    def Equal(self, other: AxisAlignedBox, tolerance: float = 1e-3) -> bool:
        """Whether no corner differs by more than `tolerance` [m] along an axis."""
        return self.min.Equal(other.min, tolerance) and self.max.Equal(other.max, tolerance)

    def __repr__(self) -> str:
        return f"AxisAlignedBox({self.min!r}, {self.max!r})" if self.min.IsFinite() else "AxisAlignedBox()"

    def __str__(self) -> str:
        return f"Min[{self.min}] Max[{self.max}]"

    GetCenter = Center
    GetSize = Size
    GetXLength = XLength
    GetYLength = YLength
    GetZLength = ZLength


Box = AxisAlignedBox
