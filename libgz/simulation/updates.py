"""Updates: the work of all models in a step, as rows that one native call works through.

An entity describes its update as rows, in order (`Entity.MasterRows`). Each row has a twin in Python: the native code
stops at a row that it cannot do, such as an exchange with an interface whose lock a client holds, or whose command has
changed; Python does that row, and the native code continues after it. Where the step is not native, `MasterUpdate` does
all. Both give the same numbers to the last bit.
"""

from __future__ import annotations

import contextlib
import ctypes
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import USER_ERRORS, ParameterError, nearest, pass_interrupt
from libgz.base.geometry import STEEP
from libgz.ode.lib import ode
from libgz.ode.records import (
    AxisRecord,
    BatteryRecord,
    BeginRecord,
    BicycleRecord,
    CastRecord,
    DifferentialRecord,
    Kind,
    MotionRecord,
    OdometryRecord,
    PublishRecord,
    Row,
    ScannerRecord,
    ServoRecord,
    ShareRecord,
    SpringRecord,
    SwitchRecord,
    TextRecord,
    TransferRecord,
    UpdatesRecord,
    VectorRecord,
    What,
)
from libgz.physics.body import Body
from libgz.physics.check import LARGEST
from libgz.physics.engine import Engine
from libgz.physics.joint import HingeJoint, Joint
from libgz.physics.rays import RayProximity
from libgz.simulation.clock import Clock
from libgz.simulation.formula import Formula, Term
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.simulation.running_code import names
from libgz.simulation.sources import address_of, check_size
from libgz.transport.interface import Interface
from libgz.transport.layout import Field, Struct, fields_of
from libgz.transport.server import LocalServer

__all__ = ["Exchange", "JointAxis", "UpdateRows", "is_plain", "replaced", "run_shares", "set_part"]


class Updated(Protocol):
    """An entity, as the rows use it."""

    failed: BaseException | None

    def GetId(self) -> str:
        """Its name."""

    def MasterRows(self, rows: UpdateRows) -> None:
        """Add what it does in a step."""

    def MasterUpdate(self, step: float) -> None:
        """Do it in Python, in a step of a length [s]."""

    def motors_off(self) -> None:
        """Switch its motors off."""


class HasUpdates(Protocol):
    """A world, as the rows use it."""

    engine: Engine
    clock: Clock
    gz_server: LocalServer
    entities: list[Any]


_ELEMENT = re.compile(r"(\w+)\[(\d+)\]\.(\w+)")

Twin = Callable[[float], object]  # does a row in Python; its argument is the length of the step [s]


NO_HANDLE = (1 << 64) - 1  # which no joint has: Python does the row, and raises ClosedError


class JointAxis(NamedTuple):
    """An axis of a joint: 1, or 2 of joints with two."""

    joint: Joint
    number: int = 1

    def record(self) -> AxisRecord:
        """For native code."""
        return AxisRecord(self.joint.row, NO_HANDLE if self.joint.closed else self.joint.id, self.number - 1)


def replaced(thing: object, kind: type, *names: str) -> bool:
    """Whether an object has other methods of these names than the class `kind`, by a subclass or by itself."""
    own = vars(thing)
    return any(name in own or getattr(type(thing), name) is not getattr(kind, name) for name in names)


def is_plain(thing: object, kind: type, *names: str) -> bool:
    """Whether an object is of a class, not of a subclass, and has no methods of these names of its own."""
    return type(thing) is kind and not replaced(thing, kind, *names)


def set_part(model: Any, name: str, value: object) -> None:
    """The `__setattr__` of models: their rows are built again after an attribute of `ROW_PARTS` was set."""
    object.__setattr__(model, name, value)
    if name in model.ROW_PARTS:
        model.world.update_rows_changed()


def _raise(error: BaseException, _step: float) -> None:
    raise error


def _nothing(_step: float) -> None:
    """The twin of rows that native code can always do."""


# Conditions that clients meet, or do not.
OF_CLIENTS = (What.REQUIRE, What.EXPECT_INT, What.EXPECT_DOUBLE, What.SWITCH, What.TEXT)


class _Line(NamedTuple):
    """What Python knows of a row."""

    entity: Any
    twin: Twin
    rate: Any = None  # of a row that is about one


class Exchange:
    """What a row exchanges with an interface, under its lock: conditions, then numbers that are written.

    Where a condition is not met, nothing is written, and the twin of the row does all. `source` is what the row reads
    in each step: a ctypes object; a number in one, as ``(object, field)``, ``(object, field, index)`` or
    ``(array, index)``; or a numpy array.

    Methods that name a field raise ParameterError if the interface has no such field, or the numbers do not fit in it.

    Args:
        interface: which is open on a server.
    """

    def __init__(self, interface: Interface[Any]) -> None:
        self.interface = interface
        self.transfers: list[TransferRecord] = []
        self.kept: list[object] = []  # what the transfers point to

    def require(self, source: Any) -> None:
        """Condition: an int64 of ours is not 0."""
        self._add(What.REQUIRE, 0, source)

    def expect(self, name: str, source: Any, index: int = 0) -> None:
        """Condition: an int or a double of the interface is equal to an int64 or a double of ours."""
        whole = self._is_double(name)
        self._add(What.EXPECT_DOUBLE if whole else What.EXPECT_INT, self._place(name, index), source)

    def switch(self, name: str, record: SwitchRecord, count: int = 1) -> None:
        """Condition: an int that clients set to 1 is 0.

        Any other number is no command but overwritten memory, and is set to 0.

        Args:
            name: of the field.
            record: how often that may happen before Python has to warn, by `Guard.switch_record`.
            count: how many ints, from this one on, are set to 0 then.
        """
        self._add(What.SWITCH, self._place(name), record, count)

    def text(self, name: str, seen: ctypes.Array[ctypes.c_char], time: str) -> None:
        """Condition: there is no text, or one that clients may still be writing, for it has changed.

        Args:
            name: of the field.
            seen: the text at the last exchange that found one; zeros: none. It is updated.
            time: the field to which the sim time [s] is written when a text is found.
        """
        size = len(seen)
        place = self._place(name, 0, size)
        found = ctypes.create_string_buffer(size)
        self.kept.append((seen, found))
        self._add(What.TEXT, place, TextRecord(address_of(seen), address_of(found), size, self._place(time)), size)

    def unmarked(self, cast: CastRecord) -> None:
        """Condition: no ray hit a geom that reflects or has a fiducial number."""
        self._add(What.UNMARKED, 0, cast)

    def now(self, name: str = "time") -> None:
        """Write the sim time [s]."""
        self._add(What.NOW, self._place(name), None)

    def real_time(self, name: str) -> None:
        """Write the real time since the start of the world [s]."""
        self._add(What.REAL_TIME, self._place(name), None)

    def integer(self, name: str, value: int, count: int = 1) -> None:
        """Write a constant to an int, or to the first `count` of an array."""
        self._add(What.INTS, self._place(name, 0, count), ctypes.c_int32(value), count, 4)

    def doubles(self, name: str, source: Any, count: int = 1, index: int = 0, stride: int = 1) -> None:
        """Write doubles, from `index` on, at every `stride`-th place."""
        check_size(source, count)
        self._add(What.DOUBLES, self._place(name, index, count, stride), source, count, 8 * stride)

    def nearest(self, name: str, ranges: NDArray[np.float64], limit: float) -> None:
        """Write ranges, none larger than a limit [m]."""
        check_size(ranges, len(ranges))
        self._add(What.NEAREST, self._place(name, 0, len(ranges)), ranges, len(ranges), 8, limit)

    def readings(self, name: str, scanner: ScannerRecord, count: int, *kept: object) -> None:
        """Write the readings of a scanner, which points into what is `kept`."""
        self.kept.append(kept)
        self._add(What.READINGS, self._place(name, 0, count), scanner, count, 8)

    def angle(self, name: str, axis: JointAxis) -> None:
        """Write the angle of an axis [rad]."""
        self._add(What.ANGLE, self._place(name), axis.record())

    def rate(self, name: str, axis: JointAxis) -> None:
        """Write the rate of an axis [rad/s]."""
        self._add(What.RATE, self._place(name), axis.record())

    def vector(self, name: str, joint: Joint, function: str, scale: float = 1.0) -> None:
        """Write a vector of a joint, such as its anchor, times a number.

        Args:
            name: of the field.
            joint: whose it is.
            function: of ODE, such as ``dJointGetHingeAnchor``.
            scale: the number.
        """
        handle = NO_HANDLE if joint.closed else joint.id
        vector = VectorRecord(joint.row, handle, ode().address(function), scale)
        self._add(What.VECTOR, self._place(name, 0, 3), vector)

    def store(self, target: NDArray[Any], source: Any) -> None:
        """Write doubles to a view of the interface's memory, as numbers of its type."""
        self._view(What.STORE, target, source)

    def fetch(self, target: Any, source: NDArray[Any]) -> None:
        """Read a view of the interface's memory, as doubles."""
        self._view(What.FETCH, source, target)

    def _view(self, what: What, view: NDArray[Any], numbers: Any) -> None:
        """Transfer the numbers of a view of one dimension."""
        check_size(numbers, len(view))
        offset = view.ctypes.data - int(self.interface.link.memory)
        self._add(what, offset, numbers, len(view), view.strides[0])
        self.transfers[-1].type = ord(view.dtype.char)

    def _is_double(self, name: str) -> bool:
        return bool(self._number(name)[0].ctype is ctypes.c_double)

    def _number(self, name: str) -> tuple[Field, Any, int]:
        """The declaration of a field, its struct, and where that begins; ``joints[2].angle`` is a field of an element.

        Raises:
            ParameterError: the interface has none of this name, or not so many elements.
        """
        layout: Any = self.interface.layout
        begin, known = 0, fields_of(layout)
        match = _ELEMENT.fullmatch(name)
        if match and match[1] in known and issubclass(known[match[1]].ctype, Struct):
            array: Any = dict(layout._fields_)[match[1]]
            index = int(match[2])
            if index >= array._length_:
                raise ParameterError(f"{match[1]} has {array._length_} elements, so no {name}")
            begin = getattr(layout, match[1]).offset + index * ctypes.sizeof(array._type_)
            layout, known, name = array._type_, known[match[1]].ctype.declared, match[3]
        if name not in known:
            what = f"{self.interface.type}.{self.interface.id}"
            raise ParameterError(f"{what} has no field {name!r}; it has {', '.join(known)}{nearest(name, known)}")
        return known[name], layout, begin

    def _place(self, name: str, index: int = 0, count: int = 1, stride: int = 1) -> int:
        """Where numbers of a field begin.

        Raises:
            ParameterError: there is no such field, or it has not so many numbers.
        """
        field, layout, begin = self._number(name)
        size, place = ctypes.sizeof(field.ctype), getattr(layout, name.rpartition(".")[2])
        if index < 0 or (index + (count - 1) * stride + 1) * size > place.size:
            raise ParameterError(f"{name} has the shape {field.shape}: {count} numbers from {index} on do not fit")
        return int(begin + place.offset) + index * size

    def _add(self, what: What, offset: int, source: Any, count: int = 1, stride: int = 0, limit: float = 0.0) -> None:
        self.kept.append(source)
        self.transfers.append(TransferRecord(what, offset, count, stride, address_of(source), limit))


class UpdateRows:
    """The rows of a world. They are built before a step if anything that they depend on has changed since.

    Args:
        world: the world.

    Attributes:
        valid: whether they are those of the present world; whoever changes parts of a model sets it to False.
        updating: the entities that have something to do in a step, in order.
        begin, end: where the rows of the entities are.
        tail: where the rows begin that report the step.
        run_all: does all rows natively, for so many `steps` as Python has nothing to do in; the number of the row that
            Python has to do, or `count`.
        steps: how many steps `run_all` makes at most, and then how many of them are left; a ctypes number.
        count: of all rows.
        native: whether native code does the rows.
    """

    def __init__(self, world: HasUpdates) -> None:
        self.world = world
        self.valid = False
        self._enabled = True
        self.updating: list[Any] = []
        self.begin = self.end = self.tail = self.count = 0
        self.steps = ctypes.c_int64(1)
        self._run, self._prepare = world.engine.native.updates()
        self.native = True
        self._entity: Updated | None = None
        self.clear()

    def clear(self) -> None:
        """Drop all rows, and what they point to."""
        self.valid = False
        self._record: Any = None
        self.run_all: Callable[[], int] = lambda: 0
        self._rows: list[Row] = []
        self._lines: list[_Line] = []
        self._kept: list[object] = []
        self._starts: dict[int, int] = {}  # the first row of each entity that has one
        self._ends: dict[int, int] = {}  # the row after its last one
        self.updating = []
        self.begin = self.end = self.tail = self.count = 0

    @property
    def enabled(self) -> bool:
        """Whether native code does the rows where it can; off for tests."""
        return self._enabled

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self._enabled = value
        self.native = value

    # What entities add -----------------------------------------------------------------------------------------------

    def python(self, twin: Twin) -> None:
        """A row that Python always does."""
        self._add(Kind.PYTHON, None, twin)

    @contextlib.contextmanager
    def due(self, rate: UpdateRate) -> Iterator[None]:
        """The rows that are added inside are done only when a rate is due."""
        self._add(Kind.DUE, rate, _nothing)
        self._lines[-1] = self._lines[-1]._replace(rate=rate)
        head = self._rows[-1]
        yield
        head.jump = len(self._rows)

    @staticmethod
    def knows(rate: object) -> bool:
        """Whether a rate is one that rows can be due at."""
        return any(is_plain(rate, kind, "due") for kind in (UpdateRate, OldRate))

    def differential(
        self,
        twin: Twin,
        odometry: OdometryRecord,
        battery: BatteryRecord | None,
        sides: tuple[Sequence[JointAxis], Sequence[JointAxis]],
        *,
        diameter: float,
        separation: float,
        normalise: bool,
        encoders: tuple[Any, float] | None = None,
        lean: Any = None,
    ) -> None:
        """Odometry, battery and encoders from the rates of wheels on the left and the right side.

        Args:
            twin: does the row in Python.
            odometry: advances.
            battery: is drained; None: there is none.
            sides: the axes of the wheels.
            diameter: of the wheels [m].
            separation: of the sides [m].
            normalise: whether the yaw stays within +-pi.
            encoders: an array of two counts, and the counts per turn of a wheel.
            lean: a rate that is added to those of the wheels [rad/s], a double; None: there is none.
        """
        left, right = sides
        if not left or not right:
            self.python(twin)
            return
        counts, per_turn = encoders if encoders is not None else (None, 0.0)
        axes = self._axes((*left, *right))
        part = DifferentialRecord(
            odometry=address_of(odometry),
            battery=address_of(battery),
            axes=address_of(axes),
            left=len(left),
            right=len(right),
            diameter=diameter,
            separation=separation,
            normalise=normalise,
            counts=address_of(counts),
            counts_per_turn=per_turn,
            lean=address_of(lean),
        )
        self._add(Kind.DIFFERENTIAL, part, twin, odometry, battery, axes, counts, lean)

    def bicycle(
        self,
        twin: Twin,
        odometry: OdometryRecord,
        driven: Sequence[JointAxis],
        steered: Sequence[JointAxis],
        radius: float,
        base: float,
    ) -> None:
        """Odometry from the rates of driven wheels of a radius [m] and the angles of others, a base [m] before them."""
        axes = self._axes((*driven, *steered))
        part = BicycleRecord(address_of(odometry), address_of(axes), len(driven), len(steered), radius, base)
        self._add(Kind.BICYCLE, part, twin, odometry, axes)

    def servo(
        self, twin: Twin, axis: JointAxis, target: Any, *, parameter: int, sign: float, gain: float, damping: float
    ) -> None:
        """Set the velocity of a motor: `gain` times the error of the angle, minus `damping` times the rate.

        Args:
            twin: does the row in Python.
            axis: to turn.
            target: the wanted angle [rad], a double; a source, as for `Exchange`.
            parameter: the joint's parameter of the velocity.
            sign: of the angle: 1 or -1.
            gain: [1/s].
            damping: share of the rate.
        """
        part = ServoRecord(
            axis=axis.record(),
            set=axis.joint.setter,
            parameter=parameter,
            target=address_of(target),
            sign=sign,
            gain=gain,
            damping=damping,
            most=LARGEST,
        )
        self._add(Kind.SERVO, part, twin, target)

    def spring(self, twin: Twin, hinge: HingeJoint, stiffness: float) -> None:
        """Apply a torque of minus `stiffness` [N m/rad] times the angle of a hinge."""
        part = SpringRecord(JointAxis(hinge).record(), hinge.torque_adder, -stiffness)
        self._add(Kind.SPRING, part, twin)

    def motion(self, twin: Twin, body: Body, record: MotionRecord) -> None:
        """Pose, attitude and velocities of a body; where it is a dummy, Python finds them."""
        if body.dummy or body.closed:
            self.python(twin)
            return
        record.body, record.handle, record.steep = body.row, body.id, STEEP
        self._add(Kind.MOTION, record, twin)

    def step_of(self, formula: Formula) -> Term:
        """The length of a step [s], as a term of a formula."""
        return formula.read((self.world.engine.tables.record, "step"))

    def formula(self, twin: Twin, formula: Formula) -> None:
        """Arithmetic, with what it sets and applies."""
        part, kept = formula.record()
        self._add(Kind.FORMULA, part, twin, kept)

    def cast(self, twin: Twin, bundle: RayProximity) -> CastRecord | None:
        """Cast rays from where their body is; None, and Python does it, where the body is a dummy."""
        part = None if bundle.body.dummy or replaced(bundle, RayProximity, "Update") else bundle.record()
        if part is None:
            self.python(twin)
        else:
            self._add(Kind.CAST, part, twin, bundle)
        return part

    def share(self, twin: Twin, exchange: Exchange) -> None:
        """Exchange numbers with an interface under its lock.

        While a client keeps the lock, and what the exchange requires is there, it is left out.

        Args:
            twin: does the row in Python; without the lock, it does nothing then.
            exchange: what it does.
        """
        transfers = (TransferRecord * len(exchange.transfers))(*exchange.transfers)
        link = exchange.interface.link
        part = ShareRecord(address_of(link), address_of(transfers), len(transfers))
        memory = exchange.interface.memory if link.memory else None  # stays mapped as long as the row is used
        if memory is not None and not any(transfer.what in OF_CLIENTS for transfer in transfers):
            twin = partial(self._share_again, len(self._rows), exchange.interface, twin)
        self._add(Kind.SHARE, part, twin, link, memory, transfers, exchange.kept)

    def _share_again(self, number: int, interface: Interface[Any], twin: Twin, step: float) -> None:
        """Wait for the lock and repair the file, which native code leaves to Python, and do the row natively after all.

        A twin takes many times as long, and a client can have the native row refused in each step.
        """
        if self.valid and interface.link.memory and interface.lock() and self.run(number, number + 1) > number:
            return  # it has released the lock
        twin(step)

    @staticmethod
    def _axes(axes: Sequence[JointAxis]) -> Any:
        return (AxisRecord * len(axes))(*(axis.record() for axis in axes))

    def _add(self, kind: Kind, part: Any, twin: Twin, *kept: object) -> None:
        self._rows.append(Row(kind, 0, address_of(part)))
        self._lines.append(_Line(self._entity, twin))
        self._kept.append((part, kept))

    # What the world adds ---------------------------------------------------------------------------------------------

    @contextlib.contextmanager
    def building(self) -> Iterator[UpdateRows]:
        """Build all rows, in the order of a step."""
        self.clear()
        self.valid = True  # false again if what is called meanwhile changes something
        yield self
        self.count = len(self._rows)
        rows = (Row * self.count)(*self._rows)
        tables, clock = self.world.engine.tables.record, self.world.clock
        wanted = self.world.engine.lock.wanted
        record = UpdatesRecord(address_of(tables), address_of(clock), address_of(rows), address_of(wanted))
        self._kept.append((rows, record, tables, clock, wanted))
        self._record = ctypes.byref(record)
        if self._prepare is not None:
            self.run_all = self._prepare(self._record, self.count, self.steps)

    def begin_step(self, period: int, at_start: bool) -> None:
        """Count the step.

        Args:
            period: after so many steps Python does that.
            at_start: whether sim time grows now, and not in `advance`.
        """
        self._beginning = BeginRecord(period, at_start)
        self._add(Kind.BEGIN, self._beginning, _nothing)

    def entities(self) -> None:
        """The rows of all entities; those from `begin` to `end`."""
        self.begin = len(self._rows)
        for entity in self.world.entities:
            if isinstance(entity.failed, BaseException):
                continue
            self._entity, start = entity, len(self._rows)
            try:
                entity.MasterRows(self)
            except USER_ERRORS as error:
                pass_interrupt(error)
                del self._rows[start:], self._lines[start:]
                self.python(partial(_raise, error))  # in the step, so that the model is stopped like others that fail
            if len(self._rows) > start:
                self.updating.append(entity)
                self._starts[id(entity)], self._ends[id(entity)] = start, len(self._rows)
        self._entity = None
        self.end = len(self._rows)

    def advance(self, twin: Twin) -> None:
        """The physics step; the twin recovers from what went wrong in it."""
        self._add(Kind.ADVANCE, self._beginning, _nothing)
        self._add(Kind.SETTLE, None, twin)

    def end_physics(self) -> None:
        """What follows, from `tail` on, only reports the step."""
        self.tail = len(self._rows)

    def publish(self, twin: Twin, record: PublishRecord) -> None:
        """Copy the states for other processes."""
        self._add(Kind.PUBLISH, record, twin)

    def post(self, twin: Twin) -> None:
        """Wake the clients."""
        self._add(Kind.POST, self.world.gz_server.posting(), twin)

    # Run -------------------------------------------------------------------------------------------------------------

    def run(self, begin: int, end: int) -> int:
        """Do rows natively, from one up to another; the number of the one that Python has to do, or `end`."""
        run: Any = self._run
        return int(run(self._record, begin, end))

    def line(self, number: int) -> _Line:
        """Whose a row is, and how Python does it."""
        return self._lines[number]

    def next_in_python(self, number: int) -> int:
        """The row after one, where Python does all: what is not due is left out."""
        number += 1
        while number < self.end and self._rows[number].kind == Kind.DUE:
            row = self._rows[number]
            due = self._lines[number].rate.due(self.world.clock.sim_time)
            number = number + 1 if due else row.jump
        return number

    def end_of(self, entity: Updated) -> int:
        """The number of the row after the last one of an entity."""
        return self._ends[id(entity)]

    def after(self, entity: Updated) -> list[Any]:
        """The entities that are updated after one."""
        return self.updating[self.updating.index(entity) + 1 :]

    def first_of(self, entities: Sequence[Updated]) -> int:
        """The number of the first row of those of the entities that have rows."""
        return next((self._starts[id(entity)] for entity in entities if id(entity) in self._starts), self.end)


class HasRows(Protocol):
    """A world, as exchanges outside of steps use it."""

    engine: Engine
    clock: Clock
    rows: UpdateRows


def run_shares(world: HasRows, shares: Sequence[tuple[Exchange, Callable[[], object]]]) -> Callable[[], None]:
    """A function that does exchanges now, each of them natively or by its twin in Python; the caller holds the lock."""
    records, kept = [], []
    for exchange, _ in shares:
        transfers = (TransferRecord * len(exchange.transfers))(*exchange.transfers)
        link = exchange.interface.link
        records.append(ShareRecord(address_of(link), address_of(transfers), len(transfers)))
        kept.append((transfers, link, exchange.interface.memory))
    rows = (Row * len(records))(*(Row(Kind.SHARE, 0, address_of(record)) for record in records))
    tables, clock, count = world.engine.tables.record, world.clock, len(records)
    record = UpdatesRecord(address_of(tables), address_of(clock), address_of(rows))
    function, _ = world.engine.native.updates()

    def run(number: int) -> int:
        """The number of the next exchange that Python has to do."""
        return int(function(ctypes.byref(record), number, count)) if world.rows.native else number

    def share(_kept: object = (records, kept, rows)) -> None:
        number = run(0)
        while number < count:
            shares[number][1]()
            number = run(number + 1)

    return share


def _what_runs(values: Mapping[str, Any]) -> str:
    return f"the physics step of {len(values['self'].world.engine.bodies)} bodies"


names(UpdateRows.run, _what_runs)
