"""The mathematics of Gazebo classic: vectors, quaternions, poses, inertia, and others.

The names are those of ignition::math (`Vector3d`, `v.X()`, `q.Euler()`) and of the older gazebo::math (`Vector3`,
`v.x`, `q.GetAsEuler()`). The names of Python's own `math` (`sin`, `pi`, ...) are available, too, because
`from libgz.classic import math` hides that module.
"""

from __future__ import annotations

import math as _math
from typing import Any

from libgz.classic.api import without
from libgz.classic.math.angle import Angle
from libgz.classic.math.box import AxisAlignedBox, Box
from libgz.classic.math.color import Color
from libgz.classic.math.filters import (
    BiQuad,
    BiQuadVector3,
    OnePole,
    OnePoleQuaternion,
    OnePoleVector3,
    RollingMean,
)
from libgz.classic.math.inertial import Inertiald, MassMatrix3d
from libgz.classic.math.matrix3 import Matrix3, Matrix3d
from libgz.classic.math.matrix4 import Matrix4, Matrix4d
from libgz.classic.math.number import (
    IGN_BOX_VOLUME,
    IGN_CYLINDER_VOLUME,
    IGN_DTOR,
    IGN_NORMALIZE,
    IGN_PI,
    IGN_PI_2,
    IGN_PI_4,
    IGN_RTOD,
    IGN_SPHERE_VOLUME,
    IGN_SQRT2,
    INF_D,
    INF_F,
    INF_I32,
    MAX_D,
    MAX_I32,
    MAX_UI32,
    MIN_D,
    MIN_I32,
    NAN_D,
    NAN_F,
    clamp,
    equal,
    fixnan,
    greaterOrNearEqual,
    isEven,
    isnan,
    isOdd,
    isPowerOfTwo,
    lessOrNearEqual,
    mean,
    parseFloat,
    parseInt,
    precision,
    roundUpMultiple,
    roundUpPowerOfTwo,
    sgn,
    signum,
    variance,
)
from libgz.classic.math.oriented_box import OrientedBox, OrientedBoxd
from libgz.classic.math.pid import PID
from libgz.classic.math.plane import Plane, Planed, PlaneSide
from libgz.classic.math.pose import Pose, Pose3d
from libgz.classic.math.quaternion import Quaternion, Quaterniond
from libgz.classic.math.rand import Rand
from libgz.classic.math.spline import RotationSpline, Spline
from libgz.classic.math.vector2 import Vector2, Vector2d, Vector2i
from libgz.classic.math.vector3 import Vector3, Vector3d

__all__ = [
    "IGN_BOX_VOLUME",
    "IGN_CYLINDER_VOLUME",
    "IGN_DTOR",
    "IGN_NORMALIZE",
    "IGN_PI",
    "IGN_PI_2",
    "IGN_PI_4",
    "IGN_RTOD",
    "IGN_SPHERE_VOLUME",
    "IGN_SQRT2",
    "INF_D",
    "INF_F",
    "INF_I32",
    "MAX_D",
    "MAX_I32",
    "MAX_UI32",
    "MIN_D",
    "MIN_I32",
    "NAN_D",
    "NAN_F",
    "PID",
    "Angle",
    "AxisAlignedBox",
    "BiQuad",
    "BiQuadVector3",
    "Box",
    "Color",
    "Inertiald",
    "MassMatrix3d",
    "Matrix3",
    "Matrix3d",
    "Matrix4",
    "Matrix4d",
    "OnePole",
    "OnePoleQuaternion",
    "OnePoleVector3",
    "OrientedBox",
    "OrientedBoxd",
    "Plane",
    "PlaneSide",
    "Planed",
    "Pose",
    "Pose3d",
    "Quaternion",
    "Quaterniond",
    "Rand",
    "RollingMean",
    "RotationSpline",
    "Spline",
    "Vector2",
    "Vector2d",
    "Vector2i",
    "Vector3",
    "Vector3d",
    "clamp",
    "equal",
    "fixnan",
    "greaterOrNearEqual",
    "isEven",
    "isOdd",
    "isPowerOfTwo",
    "isnan",
    "lessOrNearEqual",
    "mean",
    "parseFloat",
    "parseInt",
    "precision",
    "roundUpMultiple",
    "roundUpPowerOfTwo",
    "sgn",
    "signum",
    "variance",
]


_missing = without(__name__)


def __getattr__(name: str) -> Any:
    if name.startswith("_") or not hasattr(_math, name):
        return _missing(name)
    return getattr(_math, name)
