"""The public names of libgz.classic.math, and the one module that each comes from."""

from typing import Any

from libgz.classic.math.angle import Angle as Angle
from libgz.classic.math.box import AxisAlignedBox as AxisAlignedBox, Box as Box
from libgz.classic.math.color import Color as Color
from libgz.classic.math.filters import (
    BiQuad as BiQuad,
    BiQuadVector3 as BiQuadVector3,
    OnePole as OnePole,
    OnePoleQuaternion as OnePoleQuaternion,
    OnePoleVector3 as OnePoleVector3,
    RollingMean as RollingMean,
)
from libgz.classic.math.inertial import Inertiald as Inertiald, MassMatrix3d as MassMatrix3d
from libgz.classic.math.matrix3 import Matrix3 as Matrix3, Matrix3d as Matrix3d
from libgz.classic.math.matrix4 import Matrix4 as Matrix4, Matrix4d as Matrix4d
from libgz.classic.math.number import (
    IGN_BOX_VOLUME as IGN_BOX_VOLUME,
    IGN_CYLINDER_VOLUME as IGN_CYLINDER_VOLUME,
    IGN_DTOR as IGN_DTOR,
    IGN_NORMALIZE as IGN_NORMALIZE,
    IGN_PI as IGN_PI,
    IGN_PI_2 as IGN_PI_2,
    IGN_PI_4 as IGN_PI_4,
    IGN_RTOD as IGN_RTOD,
    IGN_SPHERE_VOLUME as IGN_SPHERE_VOLUME,
    IGN_SQRT2 as IGN_SQRT2,
    INF_D as INF_D,
    INF_F as INF_F,
    INF_I32 as INF_I32,
    MAX_D as MAX_D,
    MAX_I32 as MAX_I32,
    MAX_UI32 as MAX_UI32,
    MIN_D as MIN_D,
    MIN_I32 as MIN_I32,
    NAN_D as NAN_D,
    NAN_F as NAN_F,
    clamp as clamp,
    equal as equal,
    fixnan as fixnan,
    greaterOrNearEqual as greaterOrNearEqual,
    isEven as isEven,
    isnan as isnan,
    isOdd as isOdd,
    isPowerOfTwo as isPowerOfTwo,
    lessOrNearEqual as lessOrNearEqual,
    mean as mean,
    parseFloat as parseFloat,
    parseInt as parseInt,
    precision as precision,
    roundUpMultiple as roundUpMultiple,
    roundUpPowerOfTwo as roundUpPowerOfTwo,
    sgn as sgn,
    signum as signum,
    variance as variance,
)
from libgz.classic.math.oriented_box import OrientedBox as OrientedBox, OrientedBoxd as OrientedBoxd
from libgz.classic.math.pid import PID as PID
from libgz.classic.math.plane import Plane as Plane, Planed as Planed, PlaneSide as PlaneSide
from libgz.classic.math.pose import Pose as Pose, Pose3d as Pose3d
from libgz.classic.math.quaternion import Quaternion as Quaternion, Quaterniond as Quaterniond
from libgz.classic.math.rand import Rand as Rand
from libgz.classic.math.spline import RotationSpline as RotationSpline, Spline as Spline
from libgz.classic.math.vector2 import Vector2 as Vector2, Vector2d as Vector2d, Vector2i as Vector2i
from libgz.classic.math.vector3 import Vector3 as Vector3, Vector3d as Vector3d

def __getattr__(name: str) -> Any: ...
