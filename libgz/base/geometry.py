"""Vectors, quaternions and poses in the conventions of Gazebo 0.4 - 0.7.

- Frames: x forward, y left, z up; metres and radians.
- Quaternions are ``(u, x, y, z)``, the scalar first.
- Euler angles are roll, pitch, yaw about the fixed axes x, y, z in that order: q = qz(yaw) qy(pitch) qx(roll).
- ``GzCoordPoseAdd(b, a)`` expresses pose b, given in frame a, in the frame that a is given in.

The structs are mutable and iterate like tuples; every function takes any sequence of the right length.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.law import asin, atan2, cos, rarely, sin

__all__ = [
    "DTOR",
    "NORMALIZE",
    "RTOD",
    "GzColor",
    "GzCoordPoseAdd",
    "GzCoordPoseSolve",
    "GzCoordPoseSub",
    "GzCoordPositionAdd",
    "GzCoordPositionSub",
    "GzCoordRotationAdd",
    "GzCoordRotationSub",
    "GzHomo",
    "GzHomoFromQuatern",
    "GzHomoInverse",
    "GzHomoMul",
    "GzPose",
    "GzPoseFinite",
    "GzPoseOf",
    "GzPosePointAt",
    "GzPoseSet",
    "GzQuatern",
    "GzQuaternFinite",
    "GzQuaternFromAxis",
    "GzQuaternFromEuler",
    "GzQuaternFromHomo",
    "GzQuaternIdent",
    "GzQuaternInverse",
    "GzQuaternMul",
    "GzQuaternNormal",
    "GzQuaternScale",
    "GzQuaternSet",
    "GzQuaternSetVector",
    "GzQuaternToAxis",
    "GzQuaternToEuler",
    "GzVector",
    "GzVectorAdd",
    "GzVectorCross",
    "GzVectorDot",
    "GzVectorFinite",
    "GzVectorMag",
    "GzVectorMul",
    "GzVectorSet",
    "GzVectorSetQuatern",
    "GzVectorSub",
    "GzVectorUnit",
    "GzVectorZero",
    "VectorLike",
    "place_of",
    "pose_text",
    "rotate",
]

VectorLike: TypeAlias = "Sequence[float] | GzVector | NDArray[np.float64]"
QuaternLike: TypeAlias = "Sequence[float] | GzQuatern | NDArray[np.float64]"


STEEP = 0.99  # sine of a pitch from which the plain formulas of Euler angles are not used
LOCKED = 1e-10  # [rad] nearer than this to a pitch of 90 degrees, roll and yaw cannot be distinguished


class _Record:
    """Comparison and text of the structs below. `dataclass` alone would compile them for each, at every start."""

    __slots__: tuple[str, ...] = ()
    # The fields' names, as dataclasses give them; `__slots__` of a subclass would name only its own.
    __match_args__: tuple[str, ...] = ()
    __hash__ = None  # type: ignore[assignment]

    def __eq__(self, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in self.__match_args__)

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.__match_args__)
        return f"{type(self).__qualname__}({values})"


_struct = dataclass(init=False, repr=False, eq=False)


class _Struct(_Record):
    """Iteration, indexing and numpy conversion for the structs below."""

    __slots__: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[float]:
        raise NotImplementedError  # each subclass has its own, which takes a third of the time

    def __len__(self) -> int:
        return len(self.__match_args__)

    def __getitem__(self, index: int) -> float:
        return float(getattr(self, self.__match_args__[index]))

    def __array__(self, dtype: object = None, copy: bool | None = None) -> NDArray[np.float64]:
        return np.array(tuple(self), dtype=np.float64)


@_struct
class GzVector(_Struct):
    """A position [m] or direction: x forward, y left, z up."""

    __slots__ = ("x", "y", "z")
    x: float
    y: float
    z: float

    def __init__(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> None:
        self.x, self.y, self.z = x, y, z

    def __iter__(self) -> Iterator[float]:
        return iter((self.x, self.y, self.z))


@_struct
class GzQuatern(_Struct):
    """A rotation as a unit quaternion, the scalar `u` first."""

    __slots__ = ("u", "x", "y", "z")
    u: float
    x: float
    y: float
    z: float

    def __init__(self, u: float = 1.0, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> None:
        self.u, self.x, self.y, self.z = u, x, y, z

    def __iter__(self) -> Iterator[float]:
        return iter((self.u, self.x, self.y, self.z))


@_struct
class GzPose(_Record):
    """A position [m] and a rotation."""

    __slots__ = ("pos", "rot")
    pos: GzVector
    rot: GzQuatern

    def __init__(self, pos: GzVector | None = None, rot: GzQuatern | None = None) -> None:
        self.pos = GzVector() if pos is None else pos
        self.rot = GzQuatern() if rot is None else rot


def GzPoseOf(value: GzPose | Sequence[float]) -> GzPose:
    """A pose as it is, or one of six numbers: position [m], and roll, pitch, yaw [rad].

    Raises:
        ParameterError: it is neither.
    """
    if hasattr(value, "pos") and hasattr(value, "rot"):
        return value  # type: ignore[return-value]
    try:
        x, y, z, roll, pitch, yaw = map(float, value)
    except (TypeError, ValueError):
        what = "a GzPose or Pose3d, or six numbers: x y z [m], roll pitch yaw [rad]"
        raise ParameterError(f"the pose is {value!r}; it must be {what}") from None
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


@_struct
class GzColor(_Struct):
    """Red, green, blue and alpha; ordinarily 0 to 1, and never clamped."""

    __slots__ = ("a", "b", "g", "r")
    r: float
    g: float
    b: float
    a: float

    def __init__(self, r: float = 0.0, g: float = 0.0, b: float = 0.0, a: float = 1.0) -> None:
        self.r, self.g, self.b, self.a = r, g, b, a

    def __iter__(self) -> Iterator[float]:
        return iter((self.r, self.g, self.b, self.a))


@_struct
class GzHomo(_Record):
    """A rotation matrix `m`, three rows of three."""

    __slots__ = ("m",)
    m: list[list[float]]

    def __init__(self, m: list[list[float]] | None = None) -> None:
        self.m = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] if m is None else m


def RTOD(r: float) -> float:
    """Radians to degrees."""
    return r * 180.0 / math.pi


def DTOR(d: float) -> float:
    """Degrees to radians."""
    return d * math.pi / 180.0


def NORMALIZE(a: float) -> float:
    """The angle `a` [rad] brought into (-pi, pi]."""
    return atan2(sin(a), cos(a))  # type: ignore[no-any-return]


# Vectors ---------------------------------------------------------------------------------------------------------


def GzVectorZero() -> GzVector:
    """The zero vector."""
    return GzVector()


def GzVectorSet(x: float, y: float, z: float) -> GzVector:
    """A vector from its components."""
    return GzVector(x, y, z)


def GzVectorSetQuatern(q: QuaternLike) -> GzVector:
    """The vector part of a quaternion."""
    _, x, y, z = q
    return GzVector(x, y, z)


def GzVectorAdd(b: VectorLike, a: VectorLike) -> GzVector:
    """b + a."""
    bx, by, bz = b
    ax, ay, az = a
    return GzVector(bx + ax, by + ay, bz + az)


def GzVectorSub(b: VectorLike, a: VectorLike) -> GzVector:
    """b - a."""
    bx, by, bz = b
    ax, ay, az = a
    return GzVector(bx - ax, by - ay, bz - az)


def GzVectorMul(s: float, a: VectorLike) -> GzVector:
    """The vector `a` times `s`."""
    x, y, z = a
    return GzVector(s * x, s * y, s * z)


def GzVectorMag(a: VectorLike) -> float:
    """The length of `a`."""
    x, y, z = a
    return math.sqrt(x * x + y * y + z * z)


def GzVectorUnit(a: VectorLike) -> GzVector:
    """The unit vector along `a`; of a zero vector, NaN."""
    length = GzVectorMag(a)
    return GzVectorMul(1.0 / length, a) if length else GzVector(math.nan, math.nan, math.nan)


def GzVectorCross(a: VectorLike, b: VectorLike) -> GzVector:
    """The cross product a x b."""
    ax, ay, az = a
    bx, by, bz = b
    return GzVector(ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx)


def GzVectorDot(a: VectorLike, b: VectorLike) -> float:
    """The dot product."""
    ax, ay, az = a
    bx, by, bz = b
    return float(ax * bx + ay * by + az * bz)


def GzVectorFinite(a: VectorLike) -> bool:
    """Whether no component is infinite or NaN."""
    return all(map(math.isfinite, a))


# Quaternions -----------------------------------------------------------------------------------------------------


def GzQuaternIdent() -> GzQuatern:
    """No rotation."""
    return GzQuatern()


def GzQuaternSet(u: float, x: float, y: float, z: float) -> GzQuatern:
    """A quaternion from its components, the scalar first."""
    return GzQuatern(u, x, y, z)


def GzQuaternSetVector(v: VectorLike) -> GzQuatern:
    """The pure quaternion (0, v)."""
    x, y, z = v
    return GzQuatern(0.0, x, y, z)


def GzQuaternFinite(a: QuaternLike) -> bool:
    """Whether no component is infinite or NaN."""
    return all(map(math.isfinite, a))


def GzQuaternInverse(a: QuaternLike) -> GzQuatern:
    """The conjugate, which inverts a unit quaternion."""
    u, x, y, z = a
    return GzQuatern(u, -x, -y, -z)


def GzQuaternNormal(a: QuaternLike) -> GzQuatern:
    """`a` scaled to unit length."""
    u, x, y, z = a
    s = math.sqrt(u * u + x * x + y * y + z * z)
    return GzQuatern(u / s, x / s, y / s, z / s)


def GzQuaternFromAxis(x: float, y: float, z: float, angle: float) -> GzQuatern:
    """A rotation by `angle` [rad] about an axis of any length; about a zero axis, none."""
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return GzQuatern()
    s = math.sin(angle / 2.0) / length
    return GzQuaternNormal((math.cos(angle / 2.0), s * x, s * y, s * z))


def GzQuaternToAxis(q: QuaternLike) -> GzQuatern:
    """The angle [rad] as `u` and, as x, y, z, the vector part unchanged: not of unit length."""
    u, x, y, z = q
    return GzQuatern(2.0 * math.acos(min(1.0, max(-1.0, u))), x, y, z)


def GzQuaternFromEuler(roll: float, pitch: float, yaw: float) -> GzQuatern:
    """qz(yaw) qy(pitch) qx(roll), angles in [rad]."""
    cr, sr = math.cos(roll / 2.0), math.sin(roll / 2.0)
    cp, sp = math.cos(pitch / 2.0), math.sin(pitch / 2.0)
    cy, sy = math.cos(yaw / 2.0), math.sin(yaw / 2.0)
    return GzQuaternNormal(
        (
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        )
    )


def GzQuaternToEuler(q: QuaternLike) -> GzVector:
    """Roll, pitch, yaw [rad] of a unit quaternion; at a pitch of 90 degrees yaw is 0."""
    u, x, y, z = q
    sine = -2.0 * (x * z - u * y)
    if rarely(abs(sine) > STEEP):
        return _steep_euler(u, x, y, z)
    roll = atan2(2.0 * (y * z + u * x), u * u - x * x - y * y + z * z)
    yaw = atan2(2.0 * (x * y + u * z), u * u + x * x - y * y - z * z)
    return GzVector(roll, asin(sine), yaw)


def _steep_euler(u: float, x: float, y: float, z: float) -> GzVector:
    """The same for a steep pitch, where the plain formulas are imprecise.

    The method is that of Bernardes and Viollet, PLoS ONE 17 (2022) e0276302.
    """
    up, down = math.hypot(u + y, x - z), math.hypot(u - y, x + z)
    total, difference = math.atan2(x + z, u - y), math.atan2(x - z, u + y)
    pitch = 2.0 * math.atan2(up, down) - math.pi / 2.0
    if min(up, down) < LOCKED * max(up, down):  # roll and yaw turn about one axis: all of it is roll
        return GzVector(NORMALIZE(2.0 * (difference if up > down else total)), pitch, 0.0)
    return GzVector(NORMALIZE(total + difference), pitch, NORMALIZE(total - difference))


def GzQuaternMul(a: QuaternLike, b: QuaternLike) -> GzQuatern:
    """The Hamilton product a b: rotate by b, then by a."""
    au, ax, ay, az = a
    bu, bx, by, bz = b
    return GzQuatern(
        au * bu - ax * bx - ay * by - az * bz,
        au * bx + ax * bu + ay * bz - az * by,
        au * by - ax * bz + ay * bu + az * bx,
        au * bz + ax * by - ay * bx + az * bu,
    )


def GzQuaternScale(s: float, a: QuaternLike) -> GzQuatern:
    """The rotation about the same axis, its angle times `s`."""
    angle, x, y, z = GzQuaternToAxis(a)
    return GzQuaternFromAxis(x, y, z, s * angle)


def GzHomoFromQuatern(q: QuaternLike) -> GzHomo:
    """The rotation matrix of a unit quaternion."""
    u, x, y, z = q
    return GzHomo(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - u * z), 2 * (x * z + u * y)],
            [2 * (x * y + u * z), 1 - 2 * (x * x + z * z), 2 * (y * z - u * x)],
            [2 * (x * z - u * y), 2 * (y * z + u * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def GzQuaternFromHomo(h: GzHomo) -> GzQuatern:
    """The unit quaternion of a rotation matrix, stable at every angle (the four-case method of Shepperd, 1978)."""
    m = h.m
    trace = m[0][0] + m[1][1] + m[2][2]
    candidates = (trace, m[0][0], m[1][1], m[2][2])
    case = candidates.index(max(candidates))
    if case == 0:
        q = (1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
    elif case == 1:
        q = (m[2][1] - m[1][2], 1.0 + m[0][0] - m[1][1] - m[2][2], m[0][1] + m[1][0], m[0][2] + m[2][0])
    elif case == 2:
        q = (m[0][2] - m[2][0], m[0][1] + m[1][0], 1.0 + m[1][1] - m[0][0] - m[2][2], m[1][2] + m[2][1])
    else:
        q = (m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], 1.0 + m[2][2] - m[0][0] - m[1][1])
    return GzQuaternNormal(q)


def GzHomoInverse(h: GzHomo) -> GzHomo:
    """The inverse of a rotation matrix, its transpose."""
    return GzHomo([[h.m[column][row] for column in range(3)] for row in range(3)])


def GzHomoMul(h: GzHomo, v: VectorLike) -> GzVector:
    """The matrix applied to a vector."""
    x, y, z = v
    return GzVector(*(row[0] * x + row[1] * y + row[2] * z for row in h.m))


def rotate(q: QuaternLike, v: VectorLike) -> GzVector:
    """The vector `v` rotated by the unit quaternion `q`: v + 2 w (w x v) in the form v + u t + w x t, t = 2 w x v."""
    u, x, y, z = q
    vx, vy, vz = v
    tx, ty, tz = 2.0 * (y * vz - z * vy), 2.0 * (z * vx - x * vz), 2.0 * (x * vy - y * vx)
    return GzVector(
        vx + u * tx + (y * tz - z * ty),
        vy + u * ty + (z * tx - x * tz),
        vz + u * tz + (x * ty - y * tx),
    )


# Poses -----------------------------------------------------------------------------------------------------------


def GzPoseSet(pos: VectorLike, rot: QuaternLike) -> GzPose:
    """A pose from position and rotation, both copied."""
    return GzPose(GzVector(*pos), GzQuatern(*rot))


def GzPoseFinite(a: GzPose) -> bool:
    """Whether no component is infinite or NaN."""
    return GzVectorFinite(a.pos) and GzQuaternFinite(a.rot)


def GzPosePointAt(pos: VectorLike, at: VectorLike, up: VectorLike) -> GzPose:
    """The pose at `pos` whose x axis points towards `at` and whose z axis is as near to `up` as possible."""
    x = GzVectorUnit(GzVectorSub(at, pos))
    y = GzVectorUnit(GzVectorCross(up, x))
    z = GzVectorCross(x, y)
    return GzPose(GzVector(*pos), GzQuaternFromHomo(GzHomo([[a, b, c] for a, b, c in zip(x, y, z, strict=True)])))


def GzCoordPositionAdd(bpos: VectorLike, apos: VectorLike, arot: QuaternLike) -> GzVector:
    """The position `bpos`, given in the frame (apos, arot), expressed in that frame's outer frame."""
    return GzVectorAdd(apos, rotate(arot, bpos))


def GzCoordPositionSub(bpos: VectorLike, apos: VectorLike, arot: QuaternLike) -> GzVector:
    """The position `bpos` relative to the frame (apos, arot)."""
    return rotate(GzQuaternInverse(arot), GzVectorSub(bpos, apos))


def GzCoordRotationAdd(b: QuaternLike, a: QuaternLike) -> GzQuatern:
    """The rotation b, given in the frame a, expressed in a's outer frame: a b."""
    return GzQuaternMul(a, b)


def GzCoordRotationSub(b: QuaternLike, a: QuaternLike) -> GzQuatern:
    """The rotation b relative to a: the inverse of a, times b."""
    return GzQuaternMul(GzQuaternInverse(a), b)


def GzCoordPoseAdd(b: GzPose, a: GzPose) -> GzPose:
    """c = b + a: the pose b, given in frame a, expressed in a's outer frame."""
    return GzPose(GzCoordPositionAdd(b.pos, a.pos, a.rot), GzCoordRotationAdd(b.rot, a.rot))


def GzCoordPoseSub(b: GzPose, a: GzPose) -> GzPose:
    """c = b - a: the pose b relative to a."""
    return GzPose(GzCoordPositionSub(b.pos, a.pos, a.rot), GzCoordRotationSub(b.rot, a.rot))


def GzCoordPoseSolve(ba: GzPose, b: GzPose) -> GzPose:
    """The frame a for which b = ba + a."""
    rot = GzQuaternMul(b.rot, GzQuaternInverse(ba.rot))
    return GzPose(GzVectorSub(b.pos, rotate(rot, ba.pos)), rot)


_READERS = ("WorldPose", "world_pose", "GetPose")  # methods that return a global pose


def place_of(thing: Any) -> str:
    """Global pose of an object for its `repr`, as `pose_text` writes it; empty where it has none."""
    read = next((read for name in _READERS if (read := getattr(thing, name, None)) is not None), None)
    try:
        pose = read() if read is not None else None
    except (GazeboError, AttributeError, NotImplementedError, TypeError):
        return ""  # it is closed, not whole yet, or means something else by that name
    return pose_text(pose.pos, GzQuaternToEuler(pose.rot)) if isinstance(pose, GzPose) else ""


def pose_text(position: Iterable[float], angles: Iterable[float]) -> str:
    """A position [m] and roll, pitch, yaw [rad] for a `repr`: `` at (1, 2, 0.5) m, rpy (0, 0, 90) deg``."""
    numbers = ", ".join(f"{part + 0.0:.4g}" for part in position)
    degrees = ", ".join(f"{math.degrees(part) + 0.0:.4g}" for part in angles)
    return f" at ({numbers}) m, rpy ({degrees}) deg"
