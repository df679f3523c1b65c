"""Spline and RotationSpline: smooth paths through points and through rotations."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.geometry import QuaternLike, VectorLike
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.vector3 import Vector3d

__all__ = ["RotationSpline", "Spline"]

# Gauss-Legendre points and weights on [0, 1], for the lengths of segments.
_X, _W = np.polynomial.legendre.leggauss(12)
NODES, WEIGHTS = (0.5 * (_X + 1.0)).tolist(), (0.5 * _W).tolist()


class Spline:
    """A cubic Hermite spline through points [m].

    Tangents are those of a cardinal spline: (1 - tension) (next - previous) / 2; at the ends, of the two points there.
    If the first point is the last one, too, the path is closed, and smooth there.
    """

    def __init__(self) -> None:
        self._points: list[Vector3d] = []
        self._given: list[Vector3d | None] = []  # tangents that users gave
        self._tangents: list[Vector3d] = []
        self._tension, self._auto = 0.0, True
        self._lengths: list[float] | None = None  # from the start to each point [m]

    def Tension(self) -> float:
        """The tension: 0 for smooth curves, 1 for straight lines."""
        return self._tension

    def SetTension(self, tension: float) -> None:
        """Set the tension: 0 for smooth curves, 1 for straight lines."""
        self._tension = float(tension)
        self._changed()

    def AddPoint(self, point: VectorLike, tangent: VectorLike | None = None) -> None:
        """Add a point at the end [m], with a tangent of its own if one is given."""
        self._points.append(Vector3d(point))
        self._given.append(Vector3d(tangent) if tangent is not None else None)
        self._changed()

    def UpdatePoint(self, index: int, point: VectorLike, tangent: VectorLike | None = None) -> bool:
        """Replace a point [m]; False if there is none of this index."""
        if not 0 <= index < len(self._points):
            return False
        self._points[index] = Vector3d(point)
        self._given[index] = Vector3d(tangent) if tangent is not None else None
        self._changed()
        return True

    def PointCount(self) -> int:
        """The number of points."""
        return len(self._points)

    def Clear(self) -> None:
        """Remove all points."""
        self._points, self._given, self._tangents, self._lengths = [], [], [], None

    def Point(self, index: int) -> Vector3d:
        """A point [m]; one of infinities if there is none of this index."""
        return self.MthDerivative(index, 0)

    def Tangent(self, index: int) -> Vector3d:
        """The tangent at a point; one of infinities if there is none of this index."""
        return self.MthDerivative(index, 1)

    def MthDerivative(self, index: int, mth: int) -> Vector3d:
        """The point (0) or its tangent (1); higher derivatives are zero; infinities if there is no such point."""
        if not 0 <= index < len(self._points):
            return Vector3d(math.inf, math.inf, math.inf)
        return Vector3d(([self._points, self._tangents][mth][index]) if mth < 2 else (0.0, 0.0, 0.0))

    def AutoCalculate(self, auto: bool) -> None:
        """Set whether tangents follow at once when points change; else at RecalcTangents."""
        self._auto = bool(auto)

    def RecalcTangents(self) -> None:
        """Compute tangents anew."""
        points, last = self._points, len(self._points) - 1
        closed = last > 1 and points[0] == points[last]
        tangents = []
        for i, given in enumerate(self._given):
            before, after = points[max(i - 1, 0)], points[min(i + 1, last)]
            if closed and i in (0, last):
                before, after = points[last - 1], points[1]
            own = (after - before) * (0.5 * (1.0 - self._tension))
            tangents.append(given if given is not None else own)
        self._tangents, self._lengths = tangents, None

    def _changed(self) -> None:
        self._lengths = None
        if self._auto:
            self.RecalcTangents()
        else:
            self._tangents += [Vector3d()] * (len(self._points) - len(self._tangents))

    # Curve ---------------------------------------------------------------------------------------------------------

    def Interpolate(self, *at: float) -> Vector3d:
        """The point at a share of the length, 0 to 1; or `Interpolate(index, t)`: at t in the segment after a point.

        Within a segment the share of its length is taken as the curve's parameter, as in ignition::math.

        Raises:
            ParameterError: there is no point, or no such segment.
        """
        return self._derivative(at, 0)

    def InterpolateTangent(self, *at: float) -> Vector3d:
        """The derivative by the segment's parameter, at the same places."""
        return self._derivative(at, 1)

    def InterpolateMthDerivative(self, mth: int, *at: float) -> Vector3d:
        """A derivative by the segment's parameter, at the same places; 0 is the point itself."""
        return self._derivative(at, mth)

    def ArcLength(self, *at: float) -> float:
        """The length [m]: of all, up to a share of it, or of the segment after a point up to t."""
        if len(self._points) < 2:
            return math.inf if not self._points else 0.0
        if not at:
            return self._cumulated()[-1]
        index, t = self._segment(at)
        return self._length_to(index, t) + (self._cumulated()[index] if len(at) == 1 else 0.0)

    def _length_to(self, index: int, t: float) -> float:
        return t * math.fsum(w * self._curve(index, t * x, 1).Length() for x, w in zip(NODES, WEIGHTS, strict=True))

    def _cumulated(self) -> list[float]:
        if self._lengths is None:
            self._lengths = list(
                accumulate((self._length_to(i, 1.0) for i in range(len(self._points) - 1)), initial=0.0)
            )
        return self._lengths

    def _segment(self, at: Sequence[float]) -> tuple[int, float]:
        """(segment, parameter in it) of a share of the length, or of (index, t)."""
        last = len(self._points) - 1
        if len(at) == 2:
            index, t = int(at[0]), float(at[1])
            if not 0 <= index <= last:
                raise ParameterError(f"a spline of {last + 1} points has no point {index}")
            return (index - 1, 1.0) if index == last and last > 0 else (index, min(max(t, 0.0), 1.0))
        lengths = self._cumulated()
        way = min(max(float(at[0]), 0.0), 1.0) * lengths[-1]
        index = min(max(bisect_left(lengths, way) - 1, 0), last - 1)
        length = lengths[index + 1] - lengths[index]
        return index, (way - lengths[index]) / length if length > 0.0 else 0.0

    def _derivative(self, at: Sequence[float], mth: int) -> Vector3d:
        if not self._points:
            raise ParameterError("a spline without points has no curve; AddPoint adds one")
        if len(self._points) == 1:
            return self.MthDerivative(0, mth)
        return self._curve(*self._segment(at), mth)

    def _curve(self, index: int, t: float, mth: int) -> Vector3d:
        bases = (
            (2 * t**3 - 3 * t**2 + 1, -2 * t**3 + 3 * t**2, t**3 - 2 * t**2 + t, t**3 - t**2),
            (6 * t**2 - 6 * t, -6 * t**2 + 6 * t, 3 * t**2 - 4 * t + 1, 3 * t**2 - 2 * t),
            (12 * t - 6, -12 * t + 6, 6 * t - 4, 6 * t - 2),
            (12.0, -12.0, 6.0, 6.0),
        )
        if mth >= len(bases):
            return Vector3d()
        a, b, c, d = bases[mth]
        points, tangents = self._points, self._tangents
        return points[index] * a + points[index + 1] * b + tangents[index] * c + tangents[index + 1] * d

    GetTension, GetPoint, GetTangent, GetPointCount = Tension, Point, Tangent, PointCount


class RotationSpline:
    """A smooth path through rotations (Shoemake's squad); all its segments take the same time."""

    def __init__(self) -> None:
        self._points: list[Quaterniond] = []
        self._tangents: list[Quaterniond] = []
        self._auto = True

    def AddPoint(self, point: QuaternLike) -> None:
        """Add a rotation at the end."""
        self._points.append(Quaterniond(point))
        self._changed()

    def UpdatePoint(self, index: int, point: QuaternLike) -> bool:
        """Replace a rotation; False if there is none of this index."""
        if not 0 <= index < len(self._points):
            return False
        self._points[index] = Quaterniond(point)
        self._changed()
        return True

    def Point(self, index: int) -> Quaterniond:
        """A rotation.

        Raises:
            ParameterError: there is none of this index.
        """
        if not 0 <= index < len(self._points):
            raise ParameterError(f"a spline of {len(self._points)} rotations has no rotation {index}")
        return Quaterniond(self._points[index])

    def PointCount(self) -> int:
        """The number of rotations."""
        return len(self._points)

    def Clear(self) -> None:
        """Remove all rotations."""
        self._points, self._tangents = [], []

    def AutoCalculate(self, auto: bool) -> None:
        """Set whether tangents follow at once when rotations change; else at RecalcTangents."""
        self._auto = bool(auto)

    def RecalcTangents(self) -> None:
        """Compute tangents anew."""
        points, last = self._points, len(self._points) - 1
        closed = last > 1 and points[0] == points[last]
        self._tangents = []
        for i, point in enumerate(points):
            before, after = points[max(i - 1, 0)], points[min(i + 1, last)]
            if closed and i in (0, last):
                before, after = points[last - 1], points[1]
            inverse = point.Inverse()
            logs = (inverse * after).Log() + (inverse * before).Log()
            self._tangents.append(point * (logs * -0.25).Exp())

    def _changed(self) -> None:
        if self._auto:
            self.RecalcTangents()
        else:
            self._tangents += [Quaterniond()] * (len(self._points) - len(self._tangents))

    def Interpolate(self, *at: float, useShortestPath: bool = True) -> Quaterniond:
        """The rotation at a share of the path, 0 to 1; or `Interpolate(index, t)`: at t in a segment.

        Raises:
            ParameterError: there is no rotation, or no such segment.
        """
        last = len(self._points) - 1
        if len(at) == 1:
            way = min(max(float(at[0]), 0.0), 1.0) * last
            index = min(int(way), max(last - 1, 0))
            t = way - index
        else:
            index, t = int(at[0]), float(at[1])
        if not 0 <= index <= last:
            raise ParameterError(f"a spline of {last + 1} rotations has no rotation {index}")
        if index == last or t == 0.0:
            return Quaterniond(self._points[index])
        if t == 1.0:
            return Quaterniond(self._points[index + 1])
        ends = self._points[index], self._tangents[index], self._tangents[index + 1], self._points[index + 1]
        return Quaterniond.Squad(t, *ends, useShortestPath)

    GetPoint, GetNumPoints, GetPointCount = Point, PointCount, PointCount
