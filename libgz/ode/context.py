"""What both forms of the step work on, and what they promise."""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable
from ctypes import c_double, c_int64, c_uint64, c_void_p
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.geometry import rotate
from libgz.ode.lib import OdeLibrary
from libgz.ode.types import JointType

__all__ = [
    "CONTACT",
    "MAX_CONTACTS",
    "MOST_CONTACTS",
    "NO_HIT",
    "Motions",
    "RayScan",
    "Step",
    "StepContext",
    "Tables",
    "push_joint",
    "read_body",
    "read_joint",
    "watch_body",
]

MAX_CONTACTS = 10  # of a pair of geoms
MOST_CONTACTS = 250  # of a pair of geoms in worlds of classic, which keep the deepest of them
FASTEST, STRONGEST = 1e7, 1e12  # [m/s], [rad/s]; [N], [N m]: bodies beyond have run away
LOST_SPEED = 2e9  # [m/s], [rad/s]: after a step, bodies beyond have run away
NO_HIT = sys.float_info.max  # [m], the range of a ray that hits nothing
_VECTOR = (np.float64, (3,))
# A contact point of a step: rows of its geoms; where it is [m], the unit normal, which points into the first geom, how
# deep it is [m]; force [N] and torque about the centre of mass [N m] on the body of either geom. All global.
CONTACT = np.dtype(
    [
        ("geom1", np.int64),
        ("geom2", np.int64),
        ("position", *_VECTOR),
        ("normal", *_VECTOR),
        ("depth", np.float64),
        ("force1", *_VECTOR),
        ("torque1", *_VECTOR),
        ("force2", *_VECTOR),
        ("torque2", *_VECTOR),
    ]
)


class StepContext(ctypes.Structure):
    """What both forms of the step work on; mirrors `context` in step.c, where the fields are explained."""

    _fields_ = [
        ("world", c_void_p),
        ("space", c_void_p),
        ("contacts", c_void_p),
        ("ray", c_void_p),
        ("probe", c_void_p),
        ("stand_in", c_void_p),
        ("no_cylinder_pairs", c_int64),
        ("step", c_double),
        ("quick", c_int64),
        ("contact_rule", c_int64),
        ("count_turns", c_int64),
        ("check_divergence", c_int64),
        ("seed", c_uint64),
        ("steps", c_int64),
        ("contact_count", c_int64),
        ("max_contacts", c_int64),
        ("cone", c_int64),
        ("gravity", c_double * 3),
        ("record", c_int64),
        ("record_count", c_int64),
        ("record_room", c_int64),
        ("records", c_void_p),
        ("pending", c_void_p),
        ("surface", c_void_p),
        ("owner", c_void_p),
        ("body_count", c_int64),
        ("bodies", c_void_p),
        ("com", c_void_p),
        ("body_state", c_void_p),
        ("watch", c_int64),
        ("body_start", c_void_p),
        ("joint_count", c_int64),
        ("joints", c_void_p),
        ("joint_types", c_void_p),
        ("joint_state", c_void_p),
        ("springs", c_void_p),
        ("halted", c_int64),
        ("gave_up", c_int64),
        ("farthest", c_double),
        ("careful", c_int64),
        ("lost", c_int64),
        ("baffled", c_int64),
        ("baffled_by", c_int64 * 2),
    ]


class Tables(Protocol):
    """The numpy arrays behind the addresses in a `StepContext`; rows are described in step.c."""

    surface: NDArray[np.float64]
    owner: NDArray[np.int64]
    com: NDArray[np.float64]
    body_state: NDArray[np.float64]
    body_start: NDArray[np.float64]
    joint_state: NDArray[np.float64]
    springs: NDArray[np.float64]
    pushing: set[int]  # rows of joints with a spring or damper
    joint_types: NDArray[np.int64]
    body_ids: NDArray[np.uintp]
    joint_ids: NDArray[np.uintp]
    surface_edits: int


NOT_ALL_WELL = 2  # what a step returns besides 1 and 0: what happened stands in the context


class RayScan(NamedTuple):
    """Rays of a sensor, and what they meet.

    Attributes:
        frame: position [m] and quaternion of the sensor, shape (7,), global.
        rays: start [m], unit direction and length [m] of each ray in that frame, shape (n, 7).
        owner: number of the body whose geoms the rays do not see; 0 for none.
        ranges: out, distance from the start [m], shape (n,); the largest float where nothing was hit.
        rows: out, row of the geom that was hit, shape (n,); -1 for none.
    """

    frame: NDArray[np.float64]
    rays: NDArray[np.float64]
    owner: int
    ranges: NDArray[np.float64]
    rows: NDArray[np.int64]


class Step(Protocol):
    """Either form."""

    name: str
    reads_all: bool  # whether step() leaves all states copied out

    def step(self) -> int:
        """Both halves; 1: all is well, 0: out of memory, NOT_ALL_WELL: see `Engine._mend`."""

    def collide(self) -> None:
        """The first half: find contacts and make joints of them."""

    def solve(self) -> int:
        """The second half: move everything, empty the contact group; returns what `step` does."""

    @property
    def release(self) -> Callable[[], object]:
        """Gives back what was allocated; the callable holds no reference to the engine."""

    def contacts(self) -> NDArray[np.void]:
        """A copy of the contact points recorded in this step, as `CONTACT`; without forces until `solve`."""

    def read(self) -> None:
        """Copy all body and joint states into the tables."""

    def forget(self, geom: int) -> None:
        """Drop what is remembered of a geom, because it was destroyed or given to another body."""

    def scanner(self, scan: RayScan) -> Callable[[], object]:
        """A scan ready to be made, again and again; see gz_scan in step.c."""


def read_body(ode_: OdeLibrary, tables: Tables, row: int) -> None:
    """Copy the state of one body out of ODE into its row."""
    body = int(tables.body_ids[row])
    state = tables.body_state[row]
    address = tables.body_state.ctypes.data + row * state.nbytes
    # ODE writes 4 values for a position: into columns 7 - 10, before the velocity takes column 10.
    ode_.dBodyCopyPosition(body, address + 7 * 8)
    ode_.dBodyCopyQuaternion(body, address + 3 * 8)
    state[10:13] = ode_.dBodyGetLinearVel(body).contents[:3]
    state[13:16] = ode_.dBodyGetAngularVel(body).contents[:3]
    position = state[7:10].tolist()
    offset = rotate(state[3:7].tolist(), tables.com[row].tolist())
    state[0:3] = [p - o for p, o in zip(position, offset, strict=True)]


_TURN = 6.2831853071795862  # 2 pi


def _unwind(before: float, angle: float) -> float:
    """The angle that is nearest to the one before; unwind in step.c. Python rounds halves to even, as rint does."""
    turns = (before - angle) / _TURN
    return angle + _TURN * round(turns) if math.isfinite(turns) else angle


def watch_body(ode_: OdeLibrary, tables: Tables, row: int) -> None:
    """Note what a body does, and what is done to it, as a step begins; watch_bodies in step.c."""
    body = int(tables.body_ids[row])
    state = tables.body_start[row]
    for column, get in enumerate(
        (ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel, ode_.dBodyGetForce, ode_.dBodyGetTorque)
    ):
        state[3 * column : 3 * column + 3] = get(body).contents[:3]


def read_joint(ode_: OdeLibrary, tables: Tables, row: int, *, unwind: bool = False) -> None:
    """Copy angles and rates of one joint out of ODE into its row; with `unwind`, angles count their turns."""
    joint, kind = int(tables.joint_ids[row]), int(tables.joint_types[row])
    if not joint:
        return
    state = tables.joint_state[row]
    before = state[:2].tolist()
    if kind == JointType.HINGE:
        state[0], state[2] = ode_.dJointGetHingeAngle(joint), ode_.dJointGetHingeAngleRate(joint)
    elif kind == JointType.SLIDER:
        state[0], state[2] = ode_.dJointGetSliderPosition(joint), ode_.dJointGetSliderPositionRate(joint)
    elif kind in _TWO_VALUES:
        state[:] = [getattr(ode_, f"dJointGet{what}")(joint) for what in _TWO_VALUES[kind]]
    if unwind and kind != JointType.SLIDER:
        state[0] = _unwind(before[0], state[0])
        if kind in (JointType.HINGE2, JointType.UNIVERSAL):
            state[1] = _unwind(before[1], state[1])


class Motions:
    """What ODE keeps of bodies, looked at in place: a call for each number would take as long as the step."""

    def __init__(self, ode_: OdeLibrary) -> None:
        self._ode = ode_
        self._places: dict[int, tuple[tuple[Any, float, float], ...]] = {}  # of a body; another at its address fits

    def _look(self, body: int) -> tuple[tuple[Any, float, float], ...]:
        """Three numbers each, how large they may be before a step, and after it."""
        ode_ = self._ode
        self._places[body] = tuple(
            ((c_double * 3).from_address(ctypes.addressof(get(body).contents)), before, after)
            for get, before, after in (
                (ode_.dBodyGetPosition, math.inf, math.inf),
                (ode_.dBodyGetLinearVel, FASTEST, LOST_SPEED),
                (ode_.dBodyGetAngularVel, FASTEST, LOST_SPEED),
                (ode_.dBodyGetForce, STRONGEST, math.inf),
                (ode_.dBodyGetTorque, STRONGEST, math.inf),
            )
        )
        return self._places[body]

    def halt(self, body: int) -> bool:
        """Halt a body if it runs away; halt_runaways in step.c."""
        for (x, y, z), most, _ in self._places.get(body) or self._look(body):
            if not (-most <= x <= most and -most <= y <= most and -most <= z <= most):
                break
        else:
            return False
        ode_ = self._ode
        for put in (ode_.dBodySetLinearVel, ode_.dBodySetAngularVel, ode_.dBodySetForce, ode_.dBodySetTorque):
            put(body, 0.0, 0.0, 0.0)
        return True

    def is_lost(self, body: int, farthest: float) -> bool:
        """Whether a step brought a body where no robot comes [m]; read_bodies in step.c."""
        for (x, y, z), _, most in (self._places.get(body) or self._look(body))[:3]:
            limit = min(most, farthest)
            if not (-limit <= x <= limit and -limit <= y <= limit and -limit <= z <= limit):
                return True
            farthest = math.inf  # for the first three are the place
        return False


def push_joint(ode_: OdeLibrary, tables: Tables, row: int, *, unwind: bool) -> None:
    """What the spring and damper of a hinge or slider do in the coming step; push_joints in step.c."""
    joint, kind = int(tables.joint_ids[row]), int(tables.joint_types[row])
    stiffness, damping, reference = tables.springs[row].tolist()
    if kind == JointType.HINGE:
        at = ode_.dJointGetHingeAngle(joint)
        if unwind:
            at = _unwind(float(tables.joint_state[row, 0]), at)
        rate = ode_.dJointGetHingeAngleRate(joint)
        ode_.dJointAddHingeTorque(joint, stiffness * (reference - at) - damping * rate)
    elif kind == JointType.SLIDER:
        at, rate = ode_.dJointGetSliderPosition(joint), ode_.dJointGetSliderPositionRate(joint)
        ode_.dJointAddSliderForce(joint, stiffness * (reference - at) - damping * rate)


_TWO_VALUES: dict[int, tuple[str, str, str, str]] = {
    JointType.HINGE2: ("Hinge2Angle1", "Hinge2Angle2", "Hinge2Angle1Rate", "Hinge2Angle2Rate"),
    JointType.UNIVERSAL: ("UniversalAngle1", "UniversalAngle2", "UniversalAngle1Rate", "UniversalAngle2Rate"),
    JointType.PISTON: ("PistonAngle", "PistonPosition", "PistonAngleRate", "PistonPositionRate"),
}
