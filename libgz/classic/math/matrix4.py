"""Matrix4d: a matrix of four rows and four columns; rotation and translation."""

from __future__ import annotations

from numbers import Real
from typing import Any, overload

import numpy as np

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzHomo, GzPose, GzQuatern, GzVector, VectorLike
from libgz.classic.math.constant import Constant
from libgz.classic.math.matrix3 import Matrix3d
from libgz.classic.math.pose import Pose3d
from libgz.classic.math.quaternion import Quaterniond
from libgz.classic.math.row_matrix import RowMatrix
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Matrix4", "Matrix4d"]


class Matrix4d(RowMatrix):
    """A matrix, `m[row][column]` or `m(row, column)`. `Matrix4d()` is all zeros, as in C++."""

    __slots__ = ("m",)

    Identity = Constant(lambda: Matrix4d(np.eye(4).tolist()))
    Zero = Constant(lambda: Matrix4d())

    def __init__(self, *parts: Any) -> None:
        """From 16 numbers, row by row; from four rows of four; from a quaternion, a pose or another; or zero.

        Raises:
            ParameterError: it is none of these.
        """
        if len(parts) == 16:
            rows: Any = (parts[0:4], parts[4:8], parts[8:12], parts[12:16])
        elif len(parts) == 1 and isinstance(parts[0], GzPose | GzQuatern):
            pose = Pose3d(parts[0]) if isinstance(parts[0], GzPose) else Pose3d(Vector3d(), Quaterniond(parts[0]))
            turn = Matrix3d(pose.Rot())
            rows = [[*row, place] for row, place in zip(turn.m, pose.Pos(), strict=True)] + [[0.0, 0.0, 0.0, 1.0]]
        elif len(parts) == 1:
            rows = parts[0].m if isinstance(parts[0], Matrix4d) else parts[0]
        else:
            rows = parts or ((0.0,) * 4,) * 4
        self.m: list[list[float]]
        try:
            self.m = [[float(value) for value in row] for row in rows]
        except TypeError:
            self.m = []
        if [len(row) for row in self.m] != [4, 4, 4, 4]:
            raise ParameterError(
                f"a Matrix4d takes 16 numbers, four rows, a quaternion, a pose or a matrix, not {parts!r}"
            )

    def Set(self, *parts: Any) -> None:
        """Set all numbers, from the constructor's arguments."""
        self.m = Matrix4d(*parts).m

    def SetTranslation(self, *vector: Any) -> None:
        """Set the translation [m], a vector or three numbers."""
        for row, value in zip(self.m[:3], Vector3d(*vector), strict=True):
            row[3] = value

    def Translation(self) -> Vector3d:
        """The translation [m]."""
        return Vector3d(*(row[3] for row in self.m[:3]))

    def _turn(self) -> Matrix3d:
        return Matrix3d([row[:3] for row in self.m[:3]])

    def Rotation(self) -> Quaterniond:
        """The rotation."""
        return Quaterniond(self._turn())

    def EulerRotation(self, firstSolution: bool = True) -> Vector3d:
        """Roll, pitch and yaw of the rotation [rad], one of the two solutions."""
        roll, pitch, yaw = self.Rotation().Euler()
        if firstSolution:
            return Vector3d(roll, pitch, yaw)
        return Vector3d(roll + np.pi, np.pi - pitch, yaw + np.pi)

    def Pose(self) -> Pose3d:
        """Translation and rotation [m]."""
        return Pose3d(self.Translation(), self.Rotation())

    def Scale(self, *factors: Any) -> None:
        """Set the diagonal, a vector or three numbers."""
        for i, value in enumerate(Vector3d(*factors)):
            self.m[i][i] = value

    def IsAffine(self) -> bool:
        """Whether the last row is 0 0 0 1."""
        return self.m[3] == [0.0, 0.0, 0.0, 1.0]

    def TransformAffine(self, vector: VectorLike) -> Vector3d:
        """The point that it moves a point to [m].

        Raises:
            ParameterError: the matrix is not affine.
        """
        if not self.IsAffine():
            raise ParameterError(f"{self!r} is not affine: its last row must be 0 0 0 1")
        return self * Vector3d(vector)

    def Determinant(self) -> float:
        """The determinant."""
        return float(np.linalg.det(np.array(self.m)))

    def Inverse(self) -> Matrix4d:
        """The inverse.

        Raises:
            ParameterError: it has none.
        """
        try:
            return Matrix4d(np.linalg.inv(np.array(self.m)).tolist())
        except np.linalg.LinAlgError:
            raise ParameterError(f"{self!r} has no inverse: its determinant is {self.Determinant()}") from None

    @classmethod
    def LookAt(
        cls, eye: VectorLike, target: VectorLike = (0.0, 0.0, 0.0), up: VectorLike = (0.0, 0.0, 1.0)
    ) -> Matrix4d:
        """The pose at `eye` whose x axis points at `target` [m], and whose z axis is as near to `up` as can be."""
        place = Vector3d(eye)
        front = (Vector3d(target) - place).Normalize()
        front = front if front.Length() > 0.0 else Vector3d(1.0, 0.0, 0.0)
        upwards = Vector3d(up).Normalize()
        left = upwards.Cross(front)
        if left.Length() < 1e-9:  # it looks along `up`
            left = front.Perpendicular()
        left.Normalize()
        above = front.Cross(left)
        rows = [[a, b, c, d] for a, b, c, d in zip(front, left, above, place, strict=True)]
        return cls([*rows, [0.0, 0.0, 0.0, 1.0]])

    def __eq__(self, other: object) -> bool:
        return self.m == other.m if isinstance(other, Matrix4d) else NotImplemented

    def Equal(self, other: Matrix4d, tolerance: float = 1e-6) -> bool:
        """Whether no number differs by more than `tolerance`."""
        return bool(np.allclose(self.m, other.m, rtol=0.0, atol=tolerance))

    @overload
    def __mul__(self, other: Matrix4d | GzHomo | float) -> Matrix4d: ...
    @overload
    def __mul__(self, other: GzVector) -> Vector3d: ...
    def __mul__(self, other: Matrix4d | GzHomo | GzVector | float) -> Matrix4d | Vector3d:
        if isinstance(other, GzVector):  # a point: its fourth component is 1
            return Vector3d(*(r[0] * other.x + r[1] * other.y + r[2] * other.z + r[3] for r in self.m[:3]))
        if isinstance(other, GzHomo):  # a rotation
            rows = [[*row, 0.0] for row in other.m] + [[0.0, 0.0, 0.0, 1.0]]
            return self * Matrix4d(rows)
        if isinstance(other, Matrix4d):
            return Matrix4d((np.array(self.m) @ np.array(other.m)).tolist())
        if isinstance(other, Real):
            return Matrix4d([[value * float(other) for value in row] for row in self.m])
        return NotImplemented

    __matmul__ = __mul__
    SetTranslate = Translate = SetTranslation
    GetTranslation, GetRotation, GetAsPose, GetEulerRotation = Translation, Rotation, Pose, EulerRotation


Matrix4 = Matrix4d
