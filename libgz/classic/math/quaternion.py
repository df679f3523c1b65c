"""Quaterniond: a rotation as a unit quaternion, the scalar first."""

from __future__ import annotations

import math
from collections.abc import Iterator
from numbers import Real
from typing import Any, overload

from libgz.base.errors import ParameterError
from libgz.base.geometry import (
    GzHomo,
    GzQuatern,
    GzQuaternFromAxis,
    GzQuaternFromEuler,
    GzQuaternFromHomo,
    GzQuaternToEuler,
    GzVector,
    QuaternLike,
    VectorLike,
)
from libgz.classic.math.components import HasXYZ
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import fixnan, numbers_in, text_of
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Quaternion", "Quaterniond", "as_quaternion"]


class Quaterniond(HasXYZ, GzQuatern):
    """A rotation as a quaternion w, x, y, z. It is a `GzQuatern`, so every function of the engine takes it.

    - `a * b` rotates by b, then by a; `q * v` is v rotated.
    - Euler angles are roll, pitch, yaw [rad] about the fixed axes x, y, z: q = qz(yaw) qy(pitch) qx(roll).
    - Inverse and rotations are correct for any length but 0; q and -q are the same rotation, but not `==`.
    - `==` is exact; `Equal` takes a tolerance, by default that of `==` in C++.
    - `str` gives roll, pitch and yaw, like C++'s stream operator.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0

    Identity = Constant(lambda: Quaterniond(1.0, 0.0, 0.0, 0.0))
    Zero = Constant(lambda: Quaterniond(0.0, 0.0, 0.0, 0.0))

    @overload
    def __init__(self, w: None = None) -> None: ...
    @overload
    def __init__(self, w: float, x: float, y: float, z: float) -> None: ...
    @overload
    def __init__(self, w: float, x: float, y: float) -> None: ...
    @overload
    def __init__(self, w: VectorLike, x: float) -> None: ...
    @overload
    def __init__(self, w: QuaternLike | VectorLike | GzHomo) -> None: ...
    def __init__(self, w: Any = None, x: Any = None, y: Any = None, z: Any = None) -> None:
        """From w, x, y, z; roll, pitch, yaw [rad]; an axis and an angle [rad]; another one; a matrix; or no rotation.

        A vector or any three numbers are roll, pitch, yaw; any four numbers are w, x, y, z.

        Raises:
            ParameterError: it is none of these.
        """
        if z is not None:
            self.u, self.x, self.y, self.z = w, x, y, z
        elif isinstance(w, GzQuatern):
            self.u, self.x, self.y, self.z = w.u, w.x, w.y, w.z
        elif y is not None:
            self.Set(*GzQuaternFromEuler(w, x, y))
        elif x is not None:
            self.Axis(w, x)
        elif w is None:
            self.u, self.x, self.y, self.z = 1.0, 0.0, 0.0, 0.0
        else:
            self.Set(*_from_one(w))

    @classmethod
    def from_sdf(cls, text: str) -> Quaterniond:
        """From the text of an SDF element: roll, pitch, yaw [rad], or w, x, y, z.

        Raises:
            ParameterError: there are neither three numbers nor four.
        """
        return cls(numbers_in(text, 3, 4))

    # Components ------------------------------------------------------------------------------------------------------

    @property
    def w(self) -> float:
        """The scalar, which the engine calls u."""
        return self.u

    @w.setter
    def w(self, value: float) -> None:
        self.u = value

    def W(self, value: float | None = None) -> float:
        """The scalar; an argument sets it first."""
        if value is not None:
            self.u = value
        return self.u

    def Set(self, w: float, x: float, y: float, z: float) -> None:
        """Set all components."""
        self.u, self.x, self.y, self.z = w, x, y, z

    def SetToIdentity(self) -> None:
        """Set it to no rotation."""
        self.Set(1.0, 0.0, 0.0, 0.0)

    def __iter__(self) -> Iterator[float]:
        return iter((self.u, self.x, self.y, self.z))

    def __len__(self) -> int:
        return 4

    def __getitem__(self, index: int) -> float:
        return (self.u, self.x, self.y, self.z)[index]

    def __repr__(self) -> str:
        return f"Quaterniond({self.u!r}, {self.x!r}, {self.y!r}, {self.z!r})"

    def __str__(self) -> str:
        return text_of(*self.Euler())

    # Angles and axes -------------------------------------------------------------------------------------------------

    def Euler(
        self, roll: float | VectorLike | None = None, pitch: float | None = None, yaw: float | None = None
    ) -> Vector3d:
        """Roll, pitch, yaw [rad]; with arguments (a vector, or three numbers), it is set to them first.

        At a pitch of 90 degrees yaw is 0.
        """
        if roll is not None:
            angles = Vector3d(roll, pitch, yaw)
            self.Set(*GzQuaternFromEuler(angles.x, angles.y, angles.z))
        return Vector3d(*GzQuaternToEuler(self))

    def Roll(self) -> float:
        """The rotation about x [rad]."""
        return self.Euler().x

    def Pitch(self) -> float:
        """The rotation about y [rad], -pi/2 to pi/2."""
        return self.Euler().y

    def Yaw(self) -> float:
        """The rotation about z [rad]."""
        return self.Euler().z

    @staticmethod
    def EulerToQuaternion(
        roll: float | VectorLike, pitch: float | None = None, yaw: float | None = None
    ) -> Quaterniond:
        """The rotation of roll, pitch, yaw [rad], given as a vector or as three numbers."""
        angles = Vector3d(roll, pitch, yaw)
        return Quaterniond(angles.x, angles.y, angles.z)

    def Axis(self, x: float | VectorLike, y: float, z: float | None = None, angle: float | None = None) -> None:
        """Set it to a rotation about an axis of any length: `Axis(x, y, z, angle)` or `Axis(vector, angle)` [rad]."""
        if z is None or angle is None:
            axis, angle = Vector3d(x), y
        else:
            axis = Vector3d(x, y, z)
        self.Set(*GzQuaternFromAxis(axis.x, axis.y, axis.z, angle))

    def AxisAngle(self) -> tuple[Vector3d, float]:
        """The unit axis and the angle [rad], 0 to 2 pi; of no rotation, the x axis and 0."""
        length = math.sqrt(self.x * self.x + self.y * self.y + self.z * self.z)
        if length == 0.0:
            return Vector3d(1.0, 0.0, 0.0), 0.0
        return Vector3d(self.x / length, self.y / length, self.z / length), 2.0 * math.atan2(length, self.u)

    def XAxis(self) -> Vector3d:
        """The direction of the rotated x axis."""
        return self.RotateVector((1.0, 0.0, 0.0))

    def YAxis(self) -> Vector3d:
        """The direction of the rotated y axis."""
        return self.RotateVector((0.0, 1.0, 0.0))

    def ZAxis(self) -> Vector3d:
        """The direction of the rotated z axis."""
        return self.RotateVector((0.0, 0.0, 1.0))

    def SetFromMatrix(self, mat: GzHomo) -> None:
        """Set it to the rotation of a matrix."""
        self.Set(*Quaterniond(mat))

    Matrix = SetFromMatrix

    def From2Axes(self, v1: VectorLike, v2: VectorLike) -> None:
        """Set it to the shortest rotation from direction v1 to v2; for opposite ones, to one of the half turns."""
        a, b = Vector3d(v1).Normalize(), Vector3d(v2).Normalize()
        middle = a + b
        if middle.SquaredLength() < 1e-12:
            self.Set(0.0, *a.Perpendicular().Normalize())
            return
        middle.Normalize()
        self.Set(a.Dot(middle), *a.Cross(middle))
        self.Normalize()

    def Scale(self, scale: float) -> None:
        """Multiply the angle of the rotation, and keep its axis."""
        axis, angle = self.AxisAngle()
        self.Axis(axis, angle * scale)

    # Algebra ---------------------------------------------------------------------------------------------------------

    def __add__(self, other: QuaternLike) -> Quaterniond:
        if not isinstance(other, GzQuatern):
            return NotImplemented
        return Quaterniond(self.u + other.u, self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: QuaternLike) -> Quaterniond:
        if not isinstance(other, GzQuatern):
            return NotImplemented
        return Quaterniond(self.u - other.u, self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> Quaterniond:
        return Quaterniond(-self.u, -self.x, -self.y, -self.z)

    @overload
    def __mul__(self, other: GzQuatern | float) -> Quaterniond: ...
    @overload
    def __mul__(self, other: GzVector) -> Vector3d: ...
    def __mul__(self, other: GzQuatern | GzVector | float) -> Quaterniond | Vector3d:
        if isinstance(other, GzQuatern):
            u, x, y, z = self.u, self.x, self.y, self.z
            bu, bx, by, bz = other.u, other.x, other.y, other.z
            return Quaterniond(
                u * bu - x * bx - y * by - z * bz,
                u * bx + x * bu + y * bz - z * by,
                u * by - x * bz + y * bu + z * bx,
                u * bz + x * by - y * bx + z * bu,
            )
        if isinstance(other, GzVector):
            return self.RotateVector(other)
        if isinstance(other, Real):
            s = float(other)
            return Quaterniond(self.u * s, self.x * s, self.y * s, self.z * s)
        return NotImplemented

    def __rmul__(self, other: float) -> Quaterniond:
        if not isinstance(other, Real):
            return NotImplemented
        return self * float(other)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GzQuatern):
            return NotImplemented
        return self.u == other.u and self.x == other.x and self.y == other.y and self.z == other.z

    def Equal(self, other: QuaternLike, tolerance: float = 1e-3) -> bool:
        """Whether no component differs by more than `tolerance`."""
        return all(abs(a - b) <= tolerance for a, b in zip(self, other, strict=True))

    def Dot(self, other: QuaternLike) -> float:
        """The sum of the products of the components."""
        w, x, y, z = other
        return self.u * w + self.x * x + self.y * y + self.z * z

    def Normalize(self) -> Quaterniond:
        """Scale it to length 1, and return it; of length 0, it becomes no rotation."""
        length = math.sqrt(self.Dot(self))
        if length == math.inf and all(map(math.isfinite, self)):  # the squares overflow, not the length
            largest = max(map(abs, self))
            self.Set(*(value / largest for value in self))
            length = math.sqrt(self.Dot(self))
        if length == 0.0:
            self.SetToIdentity()
        else:
            self.Set(self.u / length, self.x / length, self.y / length, self.z / length)
        return self

    def Normalized(self) -> Quaterniond:
        """A copy of length 1."""
        return Quaterniond(self.u, self.x, self.y, self.z).Normalize()

    def Inverse(self) -> Quaterniond:
        """The inverse rotation; of length 0, no rotation."""
        s = self.u * self.u + self.x * self.x + self.y * self.y + self.z * self.z
        if s == 0.0:
            return Quaterniond(1.0, 0.0, 0.0, 0.0)
        return Quaterniond(self.u / s, -self.x / s, -self.y / s, -self.z / s)

    def Invert(self) -> None:
        """Replace it by the inverse rotation."""
        self.Set(*self.Inverse())

    def RotateVector(self, vector: VectorLike) -> Vector3d:
        """The vector, rotated."""
        u, x, y, z = self.u, self.x, self.y, self.z
        vx, vy, vz = (vector.x, vector.y, vector.z) if isinstance(vector, GzVector) else vector
        # v + (u t + w x t) / |q|^2 with t = 2 w x v, w the vector part.
        s = 2.0 / (u * u + x * x + y * y + z * z)
        tx, ty, tz = s * (y * vz - z * vy), s * (z * vx - x * vz), s * (x * vy - y * vx)
        return Vector3d(
            vx + u * tx + (y * tz - z * ty),
            vy + u * ty + (z * tx - x * tz),
            vz + u * tz + (x * ty - y * tx),
        )

    def RotateVectorReverse(self, vector: VectorLike) -> Vector3d:
        """The vector, rotated by the inverse."""
        return Quaterniond(self.u, -self.x, -self.y, -self.z).RotateVector(vector)

    def Log(self) -> Quaterniond:
        """The logarithm of a unit quaternion: scalar 0, and half the angle [rad] along the axis."""
        length = math.sqrt(self.x * self.x + self.y * self.y + self.z * self.z)
        s = math.atan2(length, self.u) / length if length else 0.0
        return Quaterniond(0.0, self.x * s, self.y * s, self.z * s)

    def Exp(self) -> Quaterniond:
        """The unit quaternion whose logarithm this is; the scalar is ignored."""
        half = math.sqrt(self.x * self.x + self.y * self.y + self.z * self.z)
        s = math.sin(half) / half if half else 1.0
        return Quaterniond(math.cos(half), self.x * s, self.y * s, self.z * s)

    @staticmethod
    def Slerp(t: float, p: QuaternLike, q: QuaternLike, shortestPath: bool = False) -> Quaterniond:
        """Interpolate between two rotations on a great circle (Shoemake, SIGGRAPH 1985).

        Args:
            t: 0 gives p, 1 gives q.
            p: the first rotation.
            q: the second rotation.
            shortestPath: use -q instead of q if it is nearer.
        """
        start, end = Quaterniond(*p), Quaterniond(*q)
        if shortestPath and start.Dot(end) < 0.0:
            end = -end
        return start * ((start.Inverse() * end).Log() * t).Exp()

    @staticmethod
    def Squad(
        t: float, p: QuaternLike, a: QuaternLike, b: QuaternLike, q: QuaternLike, shortestPath: bool = False
    ) -> Quaterniond:
        """Interpolate from p to q on a curve with inner points a and b (Shoemake, SIGGRAPH course notes, 1987)."""
        outer = Quaterniond.Slerp(t, p, q, shortestPath)
        return Quaterniond.Slerp(2.0 * t * (1.0 - t), outer, Quaterniond.Slerp(t, a, b))

    def Integrate(self, angularVelocity: VectorLike, dt: float) -> Quaterniond:
        """This rotation after `dt` [s] at a constant angular velocity [rad/s] in the outer frame."""
        x, y, z = angularVelocity
        h = dt / 2.0
        return Quaterniond(0.0, x * h, y * h, z * h).Exp() * self

    def Round(self, precision: int) -> None:
        """Round the components to `precision` decimals."""
        self.Set(*(round(value, precision) for value in self))

    def IsFinite(self) -> bool:
        """Whether no component is infinite or NaN."""
        return all(map(math.isfinite, self))

    def Correct(self) -> None:
        """Set infinite components and NaN to 0; if all are 0 then, set it to no rotation."""
        self.Set(*map(fixnan, self))
        if not any(self):
            self.SetToIdentity()

    GetAsEuler = Euler
    SetFromEuler = Euler
    SetFromAxis = SetFromAxisAngle = Axis
    GetAsAxis = AxisAngle
    ToAxis = AxisAngle
    GetRoll = Roll
    GetPitch = Pitch
    GetYaw = Yaw
    GetInverse = Inverse
    GetXAxis = XAxis
    GetYAxis = YAxis
    GetZAxis = ZAxis
    GetLog = Log
    GetExp = Exp


def as_quaternion(rot: QuaternLike) -> Quaterniond:
    """Return a Quaterniond: the argument itself if it is one, else a copy."""
    return rot if isinstance(rot, Quaterniond) else Quaterniond(rot)


def _from_one(value: Any) -> GzQuatern:
    if isinstance(value, GzHomo):
        return GzQuaternFromHomo(value)
    try:
        numbers = tuple(value)
    except TypeError:
        numbers = ()
    if len(numbers) == 4:
        return GzQuatern(*numbers)
    if len(numbers) == 3:
        return GzQuaternFromEuler(*numbers)
    raise ParameterError(
        "a Quaterniond takes w, x, y, z, or roll, pitch, yaw, or an axis and an angle, or another one, "
        f"or a matrix, not {value!r}"
    )


Quaternion = Quaterniond
