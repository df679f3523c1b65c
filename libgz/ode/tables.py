"""The state tables: arrays with one row for each body, joint and geom, which the step reads and fills.

Setters mark rows as stale, getters read a stale row from ODE first. The step gets the addresses of the arrays;
step.h describes their columns. After a step all rows are fresh.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import rotate
from libgz.base.records import TableRecord
from libgz.ode.context import StepContext
from libgz.ode.lib import OdeLibrary
from libgz.ode.types import SURFACE_COLUMNS, JointType, Surface, dInfinity

__all__ = ["BodyTable", "GeomTable", "JointTable", "Tables", "unwound"]

_FIRST_SIZE = 16  # rows

# Of a new geom: kp 1e4 N/m, no damper, infinite friction.
_DEFAULT_SURFACE = np.zeros(SURFACE_COLUMNS)
_DEFAULT_SURFACE[[Surface.KP, Surface.MU, Surface.MU2, Surface.TORSION]] = 1e4, dInfinity, dInfinity, dInfinity
_DEFAULT_SURFACE[[Surface.MAX_CONTACTS, Surface.MAX_VEL, Surface.BITS]] = 10, dInfinity, 0xFFFFFFFF
_DEFAULT_SURFACE[[Surface.GHOST_BITS, Surface.BY_PATCH]] = 0xFFFFFFFF, 1


class _Table:
    """The objects of one kind by row. Rows of closed objects are used again."""

    def __init__(self, record: TableRecord, reserved: int = 0) -> None:
        self._record = record  # for native updates
        self.objects: dict[int, Any] = {}
        self.used = reserved  # rows in use, free ones between them included
        self.size = _FIRST_SIZE  # rows of the arrays
        self.changes = 0  # grows with each row that is taken or freed
        self._free: list[int] = []
        self._made = 0  # how many there ever were
        self._numbers: dict[int, int] = {}  # of objects by row: which one of all it was

    def _count_change(self) -> None:
        self.changes += 1
        self._record.changes += 1

    def _take_row(self, thing: object) -> int:
        self._count_change()
        if self._free:
            row = self._free.pop()
        else:
            if self.used == self.size:
                self.size *= 2
                self._grow()
            row = self.used
            self.used += 1
        self.objects[row] = thing
        self._made += 1
        self._numbers[row] = self._made
        return row

    def number(self, row: int) -> int:
        """Which one of all objects that of a row was; 0 without any. No other ever has that number."""
        return self._numbers.get(row, 0)

    def census(self) -> tuple[tuple[int, ...], ...]:
        """Rows in order of construction; numbers of the objects; free rows; rows in use and objects ever made."""
        return tuple(self._numbers), tuple(self._numbers.values()), tuple(self._free), (self.used, self._made)

    def arrange(
        self, things: list[Any], rows: list[int], numbers: list[int], free: list[int], counts: tuple[int, int]
    ) -> None:
        """Give the present objects, in this order, the rows and numbers of another census.

        Their columns are not moved: the caller fills them.
        """
        self.used, self._made = counts
        self._count_change()
        while self.size < self.used:
            self.size *= 2
            self._grow()
        self.objects.clear()
        self._numbers.clear()
        for thing, row, number in zip(things, rows, numbers, strict=True):
            thing.row = row
            self.objects[row] = thing
            self._numbers[row] = number
        self._free = list(free)

    def _grow(self) -> None:
        """Double the arrays."""
        raise NotImplementedError

    def _free_row(self, row: int) -> None:
        self._count_change()
        del self.objects[row], self._numbers[row]
        self._free.append(row)


class BodyTable(_Table):
    """Bodies.

    Attributes:
        ids: ODE handles; 0 for a free row.
        com: centres of mass in the body frame [m], shape (rows, 3).
        state: see `Engine.states`, shape (rows, 16).
        motion: of the last step: linear and angular acceleration, applied force and torque, 1 if gravity acted; shape
            (rows, 13). Filled while the step records motion.
        fresh: whether `state` is up to date, a byte per row.
        values: `state` as one row of numbers: single ones are read faster than through numpy.
    """

    def __init__(self, ode_: OdeLibrary, record: TableRecord) -> None:
        super().__init__(record)
        self._ode = ode_
        self.ids = np.zeros(_FIRST_SIZE, dtype=np.uintp)
        self.com = np.zeros((_FIRST_SIZE, 3))
        self.state = np.zeros((_FIRST_SIZE, 16))
        self.motion = np.zeros((_FIRST_SIZE, 13))

    def _grow(self) -> None:
        self.ids, self.com = _doubled(self.ids), _doubled(self.com)
        self.state, self.motion = _doubled(self.state), _doubled(self.motion)

    def add(self, body: object, handle: int) -> int:
        """Register a body; returns its row."""
        row = self._take_row(body)
        self.ids[row] = handle
        self.com[row] = 0.0
        self.motion[row] = 0.0
        return row

    def remove(self, row: int) -> None:
        """Free the row of a closed body."""
        self.ids[row] = 0
        self._free_row(row)

    def publish(self, context: StepContext) -> None:
        """Hand the arrays to the step."""
        context.bodies, context.com = self.ids.ctypes.data, self.com.ctypes.data
        context.body_state, context.body_motion = self.state.ctypes.data, self.motion.ctypes.data
        context.body_count = self.used
        self.values = _flat(self.state)
        self.fresh = bytearray(self.size)
        self._after_step = b"\1" * self.size
        record = self._record
        record.bodies, record.body_state = context.bodies, context.body_state
        record.body_fresh, record.body_size = _address(self.fresh), self.size

    def step_done(self) -> None:
        """Mark all rows as a step leaves them."""
        self.fresh[:] = self._after_step

    def read(self, row: int) -> None:
        """Copy the state of one body from ODE."""
        ode_, body, state = self._ode, int(self.ids[row]), self.state[row]
        address = self.state.ctypes.data + row * state.nbytes
        # ODE writes 4 values for a position: into columns 7 - 10, before the velocity takes column 10.
        ode_.dBodyCopyPosition(body, address + 7 * 8)
        ode_.dBodyCopyQuaternion(body, address + 3 * 8)
        state[10:13] = ode_.dBodyGetLinearVel(body).contents[:3]
        state[13:16] = ode_.dBodyGetAngularVel(body).contents[:3]
        position = state[7:10].tolist()
        offset = rotate(state[3:7].tolist(), self.com[row].tolist())
        state[0:3] = [p - o for p, o in zip(position, offset, strict=True)]
        self.fresh[row] = 1


class JointTable(_Table):
    """Joints.

    Attributes:
        ids: ODE handles; 0 for a free row and for a joint without bodies, on some of which ODE crashes.
        types: `JointType`.
        state: angle or position 1 and 2 [rad or m], rate 1 and 2 [rad/s or m/s], shape (rows, 4).
        springs: stiffness, damping and reference of hinges and sliders, shape (rows, 3).
        sprung: rows with a spring or damper.
        fresh: whether `state` is up to date, a byte per row.
        values: `state` as one row of numbers.
    """

    def __init__(self, ode_: OdeLibrary, context: StepContext, record: TableRecord) -> None:
        super().__init__(record)
        self._context = context
        self._getters = _joint_getters(ode_)
        self.ids = np.zeros(_FIRST_SIZE, dtype=np.uintp)
        self.types = np.zeros(_FIRST_SIZE, dtype=np.int64)
        self.state = np.zeros((_FIRST_SIZE, 4))
        self.springs = np.zeros((_FIRST_SIZE, 3))
        self.sprung: set[int] = set()
        self.versions = np.zeros(
            _FIRST_SIZE, dtype=np.int64
        )  # of joints: they grow with each change of bodies or place
        self.edits = 0  # how often one of them grew

    def _grow(self) -> None:
        self.ids, self.types, self.versions = _doubled(self.ids), _doubled(self.types), _doubled(self.versions)
        self.state, self.springs = _doubled(self.state), _doubled(self.springs)

    def add(self, joint: object, kind: JointType) -> int:
        """Register a joint, which has no bodies yet; returns its row."""
        row = self._take_row(joint)
        self.types[row] = kind
        self.set_handle(row, 0)
        self.set_spring(row, (0.0, 0.0, 0.0))
        return row

    def remove(self, row: int) -> None:
        """Free the row of a closed joint."""
        self.ids[row] = 0
        self._free_row(row)

    def set_handle(self, row: int, handle: int) -> None:
        """Read this joint from now on; with handle 0 no more."""
        self.ids[row] = handle
        self.state[row] = 0.0

    def set_spring(self, row: int, spring: tuple[float, ...]) -> None:
        """Stiffness, damping and reference."""
        self.springs[row] = spring
        if spring[0] or spring[1]:
            self.sprung.add(row)
        else:
            self.sprung.discard(row)

    def find_sprung(self) -> None:
        """Find the rows with a spring or damper, after `springs` was changed."""
        self.sprung = {row for row in self.objects if self.springs[row, 0] or self.springs[row, 1]}

    def publish(self, context: StepContext) -> None:
        """Hand the arrays to the step."""
        context.joints, context.joint_types = self.ids.ctypes.data, self.types.ctypes.data
        context.joint_state, context.springs = self.state.ctypes.data, self.springs.ctypes.data
        context.joint_count = self.used
        self.values = _flat(self.state)
        self.fresh = bytearray(self.size)
        self._stale = bytes(self.size)
        self._after_step = b"\1" * self.size
        record = self._record
        record.joints, record.joint_state = context.joints, context.joint_state
        record.joint_fresh, record.joint_size = _address(self.fresh), self.size

    def step_done(self) -> None:
        """Mark all rows as a step leaves them."""
        self.fresh[:] = self._after_step

    def all_moved(self) -> None:
        """Mark all rows as stale."""
        self.fresh[:] = self._stale

    def read(self, row: int) -> None:
        """Copy angles and rates of one joint from ODE."""
        self.fresh[row] = 1
        self.state[row] = self.values_of(row)

    def values_of(self, row: int) -> list[float]:
        """Angles and rates of one joint in ODE, with turns counted on from those in the table, which stays as it is."""
        joint, kind, state = int(self.ids[row]), int(self.types[row]), self.state[row].tolist()
        turning = _TURNING.get(kind, ()) if self._context.count_turns else ()
        for column, get in self._getters.get(kind, ()) if joint else ():
            value = get(joint)
            state[column] = unwound(state[column], value) if column in turning else value
        return list(state)


def _joint_getters(ode_: OdeLibrary) -> dict[int, tuple[tuple[int, Callable[[int], float]], ...]]:
    """For each kind of joint: column of the state table, and the ODE function that gives its value."""
    return {
        JointType.HINGE: ((0, ode_.dJointGetHingeAngle), (2, ode_.dJointGetHingeAngleRate)),
        JointType.SLIDER: ((0, ode_.dJointGetSliderPosition), (2, ode_.dJointGetSliderPositionRate)),
        JointType.HINGE2: (
            (0, ode_.dJointGetHinge2Angle1),
            (1, ode_.dJointGetHinge2Angle2),
            (2, ode_.dJointGetHinge2Angle1Rate),
            (3, ode_.dJointGetHinge2Angle2Rate),
        ),
        JointType.UNIVERSAL: (
            (0, ode_.dJointGetUniversalAngle1),
            (1, ode_.dJointGetUniversalAngle2),
            (2, ode_.dJointGetUniversalAngle1Rate),
            (3, ode_.dJointGetUniversalAngle2Rate),
        ),
        JointType.PISTON: (
            (0, ode_.dJointGetPistonAngle),
            (1, ode_.dJointGetPistonPosition),
            (2, ode_.dJointGetPistonAngleRate),
            (3, ode_.dJointGetPistonPositionRate),
        ),
    }


# Columns with angles, which are within -pi to pi in ODE.
_TURNING: dict[int, tuple[int, ...]] = {
    JointType.HINGE: (0,),
    JointType.HINGE2: (0, 1),
    JointType.UNIVERSAL: (0, 1),
    JointType.PISTON: (0,),
}
_TURN = 6.2831853071795862  # 2 pi


def unwound(before: float, angle: float) -> float:
    """The angle that is nearest to the one before; unwind in motion.c. Python rounds halves to even, as rint does."""
    turns = (before - angle) / _TURN
    return angle + _TURN * round(turns) if math.isfinite(turns) else angle


class GeomTable(_Table):
    """Geoms. Row 0 is for ODE geoms without an object.

    Attributes:
        surface: contact properties, the columns of `Surface`.
        owner: numbers of the bodies they belong to.
        marks: 1 for each one that reflects laser beams, or has a fiducial number.
        edits: grows with each change.
    """

    def __init__(self, record: TableRecord) -> None:
        super().__init__(record, reserved=1)
        self.surface = np.tile(_DEFAULT_SURFACE, (_FIRST_SIZE, 1))
        self.owner = np.zeros(_FIRST_SIZE, dtype=np.int64)
        self.marks = np.zeros(_FIRST_SIZE, dtype=np.int8)
        self.edits = 0

    def _grow(self) -> None:
        self.surface, self.owner, self.marks = _doubled(self.surface), _doubled(self.owner), _doubled(self.marks)

    def add(self, geom: object, owner: int) -> int:
        """Register a geom of the body numbered `owner`; returns its row."""
        row = self._take_row(geom)
        self.owner[row] = owner
        self.surface[row] = _DEFAULT_SURFACE
        self.marks[row] = 0
        self.edits += 1
        return row

    def remove(self, row: int) -> None:
        """Free the row of a closed geom."""
        self.edits += 1
        self._free_row(row)

    def set_surface(self, row: int, column: int, value: float) -> None:
        """Change one contact property."""
        self.surface[row, column] = value
        self.edits += 1

    def publish(self, context: StepContext) -> None:
        """Hand the arrays to the step."""
        context.surface, context.owner = self.surface.ctypes.data, self.owner.ctypes.data
        self._record.marks = self.marks.ctypes.data


class Tables:
    """The tables of one world.

    Attributes:
        record: where all of them are, for native updates.
    """

    def __init__(self, context: StepContext, ode_: OdeLibrary) -> None:
        self._context = context
        self.record = TableRecord(context=ctypes.addressof(context))
        self.bodies = BodyTable(ode_, self.record)
        self.joints = JointTable(ode_, context, self.record)
        self.geoms = GeomTable(self.record)
        self.publish()

    @property
    def touched(self) -> bool:
        """Whether `step_done` has rows to mark."""
        return bool(self.record.touched)

    @touched.setter
    def touched(self, value: bool) -> None:
        self.record.touched = value
        if value:
            self.disturb()

    def disturb(self) -> None:
        """Have the next step compute all, even if no body was awake in the last one."""
        self._context.resting = 0

    @property
    def changes(self) -> tuple[int, int, int]:
        """Numbers that change with each object that comes or goes."""
        return self.bodies.changes, self.joints.changes, self.geoms.changes

    def publish(self) -> None:
        """Hand the arrays to the step, after one was added to."""
        self.bodies.publish(self._context)
        self.joints.publish(self._context)
        self.geoms.publish(self._context)
        self.touched = True

    def add_body(self, body: object, handle: int) -> int:
        """Register a body; returns its row."""
        row = self.bodies.add(body, handle)
        self.publish()
        return row

    def add_joint(self, joint: object, kind: JointType) -> int:
        """Register a joint; returns its row."""
        row = self.joints.add(joint, kind)
        self.publish()
        return row

    def add_geom(self, geom: object, owner: int) -> int:
        """Register a geom of the body numbered `owner`; returns its row."""
        row = self.geoms.add(geom, owner)
        self.publish()
        return row

    def set_spring(self, row: int, spring: tuple[float, ...]) -> None:
        """Stiffness, damping and reference of a joint."""
        self.joints.set_spring(row, spring)
        self.disturb()

    def attach_joint(self, row: int, handle: int) -> None:
        """Read a joint from now on; with handle 0 no more."""
        self.joints.set_handle(row, handle)
        self.joint_moved(row)

    def body_moved(self, row: int) -> None:
        """Mark a body whose state was set, and all joints, as stale."""
        self.touched = True
        self.bodies.fresh[row] = 0
        self.joints.all_moved()

    def joint_moved(self, row: int) -> None:
        """Mark a joint that was changed as stale."""
        self.joints.edits += 1
        self.joints.versions[row] += 1
        self.touched = True
        self.joints.fresh[row] = 0

    def step_done(self) -> None:
        """Mark all rows as a step leaves them."""
        self.bodies.step_done()
        self.joints.step_done()
        self.touched = False


def _doubled(table: NDArray[Any]) -> NDArray[Any]:
    return np.concatenate([table, np.zeros_like(table)])


def _address(buffer: bytearray) -> int:
    """Where a buffer is that never changes its size."""
    return ctypes.addressof(ctypes.c_char.from_buffer(buffer))


def _flat(table: NDArray[np.float64]) -> memoryview[float]:
    buffer: Any = table.reshape(-1)
    return memoryview(buffer)
