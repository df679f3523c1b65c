"""The mathematics of Gazebo classic: vectors, quaternions, poses, inertia, and others.

The names are those of ignition::math (`Vector3d`, `v.X()`, `q.Euler()`) and of the older gazebo::math (`Vector3`,
`v.x`, `q.GetAsEuler()`). The names of Python's own `math` (`sin`, `pi`, ...) are available, too, because
`from libgz.classic import math` hides that module.
"""

from __future__ import annotations

import math as _math
from typing import Any

from libgz.classic.math.angle import Angle
from libgz.classic.math.box import AxisAlignedBox, Box
from libgz.classic.math.color import Color
from libgz.classic.math.inertial import Inertiald, MassMatrix3d
from libgz.classic.math.matrix3 import Matrix3, Matrix3d
from libgz.classic.math.number import (
    IGN_DTOR,
    IGN_NORMALIZE,
    IGN_PI,
    IGN_PI_2,
    IGN_PI_4,
    IGN_RTOD,
    NAN_D,
    clamp,
    equal,
    fixnan,
    isnan,
    precision,
)
from libgz.classic.math.pid import PID
from libgz.classic.math.pose import Pose, Pose3d
from libgz.classic.math.quaternion import Quaternion, Quaterniond
from libgz.classic.math.rand import Rand
from libgz.classic.math.vector2 import Vector2, Vector2d, Vector2i
from libgz.classic.math.vector3 import Vector3, Vector3d

__all__ = [
    "IGN_DTOR",
    "IGN_NORMALIZE",
    "IGN_PI",
    "IGN_PI_2",
    "IGN_PI_4",
    "IGN_RTOD",
    "NAN_D",
    "PID",
    "Angle",
    "AxisAlignedBox",
    "Box",
    "Color",
    "Inertiald",
    "MassMatrix3d",
    "Matrix3",
    "Matrix3d",
    "Pose",
    "Pose3d",
    "Quaternion",
    "Quaterniond",
    "Rand",
    "Vector2",
    "Vector2d",
    "Vector2i",
    "Vector3",
    "Vector3d",
    "clamp",
    "equal",
    "fixnan",
    "isnan",
    "precision",
]


def __getattr__(name: str) -> Any:
    if name.startswith("_") or not hasattr(_math, name):
        raise AttributeError(f"module 'libgz.classic.math' has no attribute {name!r}")
    return getattr(_math, name)
