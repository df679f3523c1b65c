"""ODE's structs and numbers, as Debian's double-precision libode 0.16 lays them out."""

from __future__ import annotations

import ctypes
import enum
import math

__all__ = [
    "Contact",
    "ContactGeom",
    "ContactMode",
    "ContactRule",
    "GeomClass",
    "JointFeedback",
    "JointType",
    "Mass",
    "SurfaceParameters",
    "dInfinity",
]

dInfinity = math.inf

Vector4 = ctypes.c_double * 4
Matrix3 = ctypes.c_double * 12


class Mass(ctypes.Structure):
    """dMass: mass [kg], centre of mass [m], inertia [kg m^2] as a 3 x 4 matrix."""

    _fields_ = [("mass", ctypes.c_double), ("c", Vector4), ("I", Matrix3)]


class SurfaceParameters(ctypes.Structure):
    """dSurfaceParameters: elasticity and friction of a contact."""

    _fields_ = [
        ("mode", ctypes.c_int),
        *(
            (name, ctypes.c_double)
            for name in (
                "mu",
                "mu2",
                "rho",
                "rho2",
                "rhoN",
                "bounce",
                "bounce_vel",
                "soft_erp",
                "soft_cfm",
                "motion1",
                "motion2",
                "motionN",
                "slip1",
                "slip2",
            )
        ),
    ]


class ContactGeom(ctypes.Structure):
    """dContactGeom: one point where two geoms touch; `depth` is the distance along a ray."""

    _fields_ = [
        ("pos", Vector4),
        ("normal", Vector4),
        ("depth", ctypes.c_double),
        ("g1", ctypes.c_void_p),
        ("g2", ctypes.c_void_p),
        ("side1", ctypes.c_int),
        ("side2", ctypes.c_int),
    ]


class Contact(ctypes.Structure):
    """dContact: what a contact joint is made from."""

    _fields_ = [("surface", SurfaceParameters), ("geom", ContactGeom), ("fdir1", Vector4)]


class JointFeedback(ctypes.Structure):
    """dJointFeedback: force [N] and torque about the centre of mass [N m] that a joint put on its bodies in a step."""

    _fields_ = [("f1", Vector4), ("t1", Vector4), ("f2", Vector4), ("t2", Vector4)]


class ContactMode(enum.IntFlag):
    """Bits of `SurfaceParameters.mode`."""

    MU2 = 0x001
    FDIR1 = 0x002
    BOUNCE = 0x004
    SOFT_ERP = 0x008
    SOFT_CFM = 0x010
    MOTION1 = 0x020
    MOTION_N = 0x080
    SLIP1 = 0x100
    SLIP2 = 0x200
    ROLLING = 0x400
    APPROX1_N = 0x4000  # torsion in proportion to the normal force
    APPROX1 = 0x3000  # pyramid along both friction directions, as dContactApprox1 was in ODE 0.5


class GeomClass(enum.IntEnum):
    """Classes of geoms that the step distinguishes."""

    SPHERE = 0
    BOX = 1
    CAPSULE = 2
    CYLINDER = 3
    PLANE = 4
    RAY = 5


class ContactRule(enum.IntEnum):
    """How contact points become contact joints.

    Both make a spring and damper of kp and kd. LEGACY, the rule of Gazebo 0.5 to 0.7, uses the smaller mu in both
    directions and bounces with the larger coefficient. CLASSIC, that of Gazebo 1 to 11, has mu2, a friction direction,
    slip, torsion, a limited push-out velocity, a minimum depth and bits, and bounces with the smaller coefficient.
    """

    LEGACY = 0
    CLASSIC = 1


class Surface(enum.IntEnum):
    """Columns of the surface table; those from MU2 on count under the classic contact rule only."""

    KP = 0  # [N/m]
    KD = 1  # [N s/m]
    MU = 2
    BOUNCE = 3
    MU2 = 4
    SLIP1 = 5
    SLIP2 = 6
    BOUNCE_VEL = 7  # [m/s]
    FDIR1 = 8  # three columns, in the geom's frame; zero: not used
    MAX_CONTACTS = 11
    MAX_VEL = 12  # [m/s] at which a penetration is pushed out at most
    MIN_DEPTH = 13  # [m] of penetration that is not corrected
    BITS = 14  # a pair without a common bit does not touch
    GHOST = 15  # 1: contact points are recorded, without joints
    GHOST_BITS = 16  # a pair with a ghost and without a common bit of these has no contact points
    TORSION = 17  # coefficient of friction about the normal
    BY_PATCH = 18  # 1: torsion depends on the patch radius, 0: on the surface radius and the depth
    PATCH_RADIUS = 19  # [m]
    RADIUS = 20  # [m] of the surface's curvature; 0 is flat
    COMPLIANCE = 21  # [1/Pa] (1 - nu^2) / E of an elastic surface; 0: not elastic
    CURVATURE = 22  # [1/m] of the shape of an elastic surface; 0: flat
    TRACK = 23  # 1: the surface runs round the axis FDIR1, as a track; 2: and what it carries turns about a pivot
    TRACK_SPEED = 24  # [m/s] at which it runs, by the right-hand rule; MU acts along its way, or round the pivot
    PIVOT = 25  # three columns, global [m]


SURFACE_COLUMNS = 28


class JointType(enum.IntEnum):
    """dJointType."""

    BALL = 1
    HINGE = 2
    SLIDER = 3
    CONTACT = 4
    UNIVERSAL = 5
    HINGE2 = 6
    FIXED = 7
    AMOTOR = 9
    PISTON = 14
    DBALL = 15


# dParamLoStop and so on, written out for editors and type checkers.
dParamLoStop, dParamHiStop, dParamVel, dParamLoVel, dParamHiVel, dParamFMax, dParamFudgeFactor = range(0x000, 0x007)
dParamBounce, dParamCFM, dParamStopERP, dParamStopCFM = range(0x007, 0x00B)
dParamSuspensionERP, dParamSuspensionCFM, dParamERP = range(0x00B, 0x00E)
dParamLoStop2, dParamHiStop2, dParamVel2, dParamLoVel2, dParamHiVel2, dParamFMax2, dParamFudgeFactor2 = range(
    0x100, 0x107
)
dParamBounce2, dParamCFM2, dParamStopERP2, dParamStopCFM2 = range(0x107, 0x10B)
dParamSuspensionERP2, dParamSuspensionCFM2, dParamERP2 = range(0x10B, 0x10E)

JOINT_PARAMETERS: dict[int, str] = {number: name for name, number in globals().copy().items() if name[:6] == "dParam"}
