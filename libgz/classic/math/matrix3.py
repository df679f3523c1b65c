"""Matrix3d: a matrix of three rows and three columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any, overload

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzHomo, GzHomoFromQuatern, GzQuatern, GzVector, VectorLike
from libgz.classic.math.constant import Constant
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.row_matrix import RowMatrix
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Matrix3", "Matrix3d"]

Rows = Sequence[Sequence[float]]


class Matrix3d(RowMatrix, GzHomo):
    """A matrix, `m[row][column]` or `m(row, column)`; inertias and rotations. `Matrix3d()` is all zeros, as in C++.

    It is a `GzHomo`; `Matrix3d(q)` is the rotation matrix of a quaternion, and `Quaterniond(m)` the inverse conversion.
    """

    __slots__ = ()

    Identity = Constant(lambda: Matrix3d(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0))
    Zero = Constant(lambda: Matrix3d())

    def __init__(self, *parts: Any) -> None:
        """From nine numbers, row by row; from three rows of three; from a quaternion; from another; or zero.

        Raises:
            ParameterError: it is none of these.
        """
        if len(parts) == 9:
            rows: Any = (parts[0:3], parts[3:6], parts[6:9])
        elif len(parts) == 1 and isinstance(parts[0], GzQuatern):
            rows = GzHomoFromQuatern(Quaterniond(parts[0]).Normalize()).m
        elif len(parts) == 1:
            rows = parts[0].m if isinstance(parts[0], GzHomo) else parts[0]
        else:
            rows = parts or ((0.0,) * 3,) * 3
        try:
            self.m = [[float(value) for value in row] for row in rows]
        except TypeError:
            self.m = []
        if [len(row) for row in self.m] != [3, 3, 3]:
            raise ParameterError(f"a Matrix3d takes nine numbers, three rows, a quaternion or a matrix, not {parts!r}")

    def Set(self, *parts: Any) -> None:
        """Set one number, `Set(row, column, value)`, or all of them, from the constructor's arguments."""
        if len(parts) == 3 and isinstance(parts[0], int):
            self.m[parts[0]][parts[1]] = float(parts[2])
        else:
            self.m = Matrix3d(*parts).m

    def Column(self, column: int) -> Vector3d:
        """A column."""
        return Vector3d(self.m[0][column], self.m[1][column], self.m[2][column])

    def SetCol(self, column: int, vector: VectorLike) -> None:
        """Set a column."""
        for row, value in zip(self.m, vector, strict=True):
            row[column] = float(value)

    def Axes(self, x: VectorLike, y: VectorLike, z: VectorLike) -> None:
        """Set the columns."""
        self.SetCol(0, x)
        self.SetCol(1, y)
        self.SetCol(2, z)

    def Axis(self, axis: VectorLike, angle: float) -> None:
        """Set it to a rotation by an angle [rad] about an axis."""
        self.m = Matrix3d(Quaterniond(axis, angle)).m

    def From2Axes(self, v1: VectorLike, v2: VectorLike) -> None:
        """Set it to the shortest rotation that turns the direction v1 into v2."""
        rotation = Quaterniond()
        rotation.From2Axes(v1, v2)
        self.m = Matrix3d(rotation).m

    def __add__(self, other: GzHomo) -> Matrix3d:
        if not isinstance(other, GzHomo):
            return NotImplemented
        return Matrix3d([[a + b for a, b in zip(r, s, strict=True)] for r, s in zip(self.m, other.m, strict=True)])

    def __sub__(self, other: GzHomo) -> Matrix3d:
        if not isinstance(other, GzHomo):
            return NotImplemented
        return Matrix3d([[a - b for a, b in zip(r, s, strict=True)] for r, s in zip(self.m, other.m, strict=True)])

    @overload
    def __mul__(self, other: GzHomo | float) -> Matrix3d: ...
    @overload
    def __mul__(self, other: GzVector) -> Vector3d: ...
    def __mul__(self, other: GzHomo | GzVector | float) -> Matrix3d | Vector3d:
        if isinstance(other, GzVector):
            return Vector3d(*(r[0] * other.x + r[1] * other.y + r[2] * other.z for r in self.m))
        if isinstance(other, GzHomo):
            columns = tuple(zip(*other.m, strict=True))
            return Matrix3d([[r[0] * c[0] + r[1] * c[1] + r[2] * c[2] for c in columns] for r in self.m])
        if isinstance(other, Real):
            return Matrix3d([[value * float(other) for value in row] for row in self.m])
        return NotImplemented

    @overload
    def __rmul__(self, other: float) -> Matrix3d: ...
    @overload
    def __rmul__(self, other: GzVector) -> Vector3d: ...
    def __rmul__(self, other: GzVector | float) -> Matrix3d | Vector3d:
        if isinstance(other, GzVector):
            return self.Transposed() * other  # the vector is a row
        if isinstance(other, Real):
            return self * float(other)
        return NotImplemented

    def __matmul__(self, other: GzHomo | GzVector) -> Matrix3d | Vector3d:
        return self * other if isinstance(other, GzHomo | GzVector) else NotImplemented

    def __eq__(self, other: object) -> bool:
        return self.m == other.m if isinstance(other, GzHomo) else NotImplemented

    def Equal(self, other: GzHomo, tolerance: float = 1e-6) -> bool:
        """Whether no number differs by more than `tolerance`."""
        pairs = (zip(r, s, strict=True) for r, s in zip(self.m, other.m, strict=True))
        return all(abs(a - b) <= tolerance for row in pairs for a, b in row)

    def Determinant(self) -> float:
        """The determinant."""
        return Vector3d(self.m[0]).Dot(Vector3d(self.m[1]).Cross(self.m[2]))

    def Inverse(self) -> Matrix3d:
        """The inverse, by cofactors.

        Raises:
            ParameterError: it has none.
        """
        a, b, c = (Vector3d(row) for row in self.m)
        columns = b.Cross(c), c.Cross(a), a.Cross(b)
        determinant = a.Dot(columns[0])
        if determinant == 0.0 or not math.isfinite(determinant):
            raise ParameterError(f"{self!r} has no inverse: its determinant is {determinant}")
        return Matrix3d(list(zip(*columns, strict=True))) * (1.0 / determinant)

    SetAxes = SetFromAxes = Axes
    SetFromAxis = SetFromAxisAngle = Axis


Matrix3 = Matrix3d
