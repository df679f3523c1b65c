"""Pose3d: a position and a rotation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, overload

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseSolve, GzPose, QuaternLike, VectorLike
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import numbers_in, text_of
from libgz.classic.math.quaternion import Quaterniond, as_quaternion
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Pose", "Pose3d"]

_new = object.__new__


def _pose(pos: Vector3d, rot: Quaterniond) -> Pose3d:
    """Return a pose of a new position and a new rotation, without copying them."""
    pose = _new(Pose3d)
    pose.pos = pos
    pose.rot = rot
    return pose


class Pose3d(GzPose):
    """A position [m] and a rotation. It is a `GzPose`, so every function of the engine takes it.

    - `A * B` is the pose B, given in frame A, in A's outer frame: X_OP * X_PQ = X_OQ.
    - `A + B` is the pose A, given in frame B, in B's outer frame: A + B = B * A.
    - `A - B` is the pose A relative to B: (A - B) + B = A.
    - `-A` is `A.Inverse()`.
    - `pose.pos` and `pose.Pos()`, `pose.rot` and `pose.Rot()` are not copies: `pose.pos.x = 1.0` changes the pose. The
      constructor copies its arguments.
    - `==` is exact; `Equal` takes a tolerance, by default that of `==` in C++.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]

    pos: Vector3d
    rot: Quaterniond

    Zero = Constant(lambda: Pose3d())

    @overload
    def __init__(self) -> None: ...
    @overload
    def __init__(self, x: GzPose | Sequence[float], /) -> None: ...
    @overload
    def __init__(self, x: VectorLike, y: QuaternLike | VectorLike, /) -> None: ...
    @overload
    def __init__(self, x: float, y: float, z: float, roll: float, pitch: float, yaw: float, /) -> None: ...
    @overload
    def __init__(self, x: float, y: float, z: float, qw: float, qx: float, qy: float, qz: float, /) -> None: ...
    def __init__(self, *parts: Any) -> None:
        """From x, y, z [m], roll, pitch, yaw [rad]; position and rotation; x, y, z, qw, qx, qy, qz; another; or zero.

        Raises:
            ParameterError: it is none of these.
        """
        self.Set(*parts)

    def Set(self, *parts: Any) -> None:
        """Set it, with the arguments of the constructor."""
        if len(parts) == 1:
            parts = (parts[0].pos, parts[0].rot) if isinstance(parts[0], GzPose) else tuple(parts[0])
        if len(parts) == 2:
            self.pos, self.rot = Vector3d(parts[0]), Quaterniond(parts[1])
        elif len(parts) in (6, 7):
            self.pos, self.rot = Vector3d(*parts[:3]), Quaterniond(*parts[3:])
        elif not parts:
            self.pos, self.rot = Vector3d(0.0, 0.0, 0.0), Quaterniond(1.0, 0.0, 0.0, 0.0)
        else:
            raise ParameterError(
                "a Pose3d takes x, y, z, roll, pitch, yaw, or a position and a rotation, or x, y, z, qw, qx, qy, qz, "
                f"or another one, not {parts!r}"
            )

    @classmethod
    def from_sdf(cls, text: str) -> Pose3d:
        """From the text of an SDF element: x y z [m], roll pitch yaw [rad].

        Raises:
            ParameterError: there are not six numbers.
        """
        return cls(numbers_in(text, 6))

    # Parts -----------------------------------------------------------------------------------------------------------

    def Pos(self) -> Vector3d:
        """The position [m]."""
        return self.pos

    def Rot(self) -> Quaterniond:
        """The rotation."""
        return self.rot

    def SetPos(self, pos: VectorLike) -> None:
        """Set the position [m]."""
        self.pos = Vector3d(pos)

    def SetRot(self, rot: QuaternLike) -> None:
        """Set the rotation."""
        self.rot = Quaterniond(rot)

    def X(self, value: float | None = None) -> float:
        """The position's x [m]; an argument sets it first."""
        return self.pos.X(value)

    def Y(self, value: float | None = None) -> float:
        """The position's y [m]; an argument sets it first."""
        return self.pos.Y(value)

    def Z(self, value: float | None = None) -> float:
        """The position's z [m]; an argument sets it first."""
        return self.pos.Z(value)

    def Roll(self) -> float:
        """The rotation about x [rad]."""
        return self.rot.Roll()

    def Pitch(self) -> float:
        """The rotation about y [rad]."""
        return self.rot.Pitch()

    def Yaw(self) -> float:
        """The rotation about z [rad]."""
        return self.rot.Yaw()

    def Reset(self) -> None:
        """Set it to zero."""
        self.Set()

    def __repr__(self) -> str:
        return f"Pose3d({self.pos!r}, {self.rot!r})"

    def __str__(self) -> str:
        return text_of(*self.pos, *self.rot.Euler())

    # Algebra ---------------------------------------------------------------------------------------------------------

    def __mul__(self, other: GzPose) -> Pose3d:
        if not isinstance(other, GzPose):
            return NotImplemented
        return _pose(self.rot.RotateVector(other.pos) + self.pos, self.rot * other.rot)

    def __rmul__(self, other: GzPose) -> Pose3d:
        return Pose3d(other) * self if isinstance(other, GzPose) else NotImplemented

    def __add__(self, other: GzPose) -> Pose3d:
        if not isinstance(other, GzPose):
            return NotImplemented
        return (other if isinstance(other, Pose3d) else Pose3d(other)) * self

    def __radd__(self, other: GzPose) -> Pose3d:
        return Pose3d(other) + self if isinstance(other, GzPose) else NotImplemented

    def __sub__(self, other: GzPose) -> Pose3d:
        if not isinstance(other, GzPose):
            return NotImplemented
        return _pose(self.CoordPositionSub(other), self.CoordRotationSub(other.rot))

    def __rsub__(self, other: GzPose) -> Pose3d:
        return Pose3d(other) - self if isinstance(other, GzPose) else NotImplemented

    def __neg__(self) -> Pose3d:
        return self.Inverse()

    def Inverse(self) -> Pose3d:
        """The pose of the outer frame in this one: A * A.Inverse() is zero."""
        back = self.rot.Inverse()
        return _pose(-back.RotateVector(self.pos), back)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GzPose):
            return NotImplemented
        return self.pos == other.pos and self.rot == other.rot

    def Equal(self, other: GzPose, tolerance: float = 1e-3) -> bool:
        """Whether no component of position and quaternion differs by more than `tolerance`."""
        return self.pos.Equal(other.pos, tolerance) and self.rot.Equal(other.rot, tolerance)

    def CoordPositionAdd(self, other: GzPose | VectorLike) -> Vector3d:
        """This position, given in the frame of a pose, in its outer frame; a vector, from this frame outwards."""
        if isinstance(other, GzPose):
            return as_quaternion(other.rot).RotateVector(self.pos) + other.pos
        return self.rot.RotateVector(other) + self.pos

    def CoordPositionSub(self, other: GzPose) -> Vector3d:
        """This position relative to the frame of a pose."""
        return as_quaternion(other.rot).RotateVectorReverse(self.pos - other.pos)

    def CoordRotationAdd(self, rot: QuaternLike) -> Quaterniond:
        """This rotation, given in a frame of rotation `rot`, in that frame's outer frame."""
        return as_quaternion(rot) * self.rot

    def CoordRotationSub(self, rot: QuaternLike) -> Quaterniond:
        """This rotation relative to `rot`."""
        return as_quaternion(rot).Inverse() * self.rot

    def CoordPoseSolve(self, other: GzPose) -> Pose3d:
        """The pose A with `self + A == other`."""
        return Pose3d(GzCoordPoseSolve(self, other))

    def RotatePositionAboutOrigin(self, rot: QuaternLike) -> Pose3d:
        """The pose with its position rotated about the origin, and its rotation unchanged."""
        return Pose3d(as_quaternion(rot).RotateVector(self.pos), self.rot)

    def IsFinite(self) -> bool:
        """Whether no component is infinite or NaN."""
        return self.pos.IsFinite() and self.rot.IsFinite()

    def Correct(self) -> None:
        """Set infinite components and NaN to 0."""
        self.pos.Correct()
        self.rot.Correct()

    def Round(self, precision: int) -> None:
        """Round all components to `precision` decimals."""
        self.pos.Set(*(round(value, precision) for value in self.pos))
        self.rot.Round(precision)

    SetX, SetY, SetZ = X, Y, Z
    GetInverse = Inverse


Pose = Pose3d
