"""Updates: the work of all models in a step, as rows that one native call works through.

Each line of the entities' plans becomes a row. The native code stops at a row that it cannot do, such as an exchange
with an interface whose lock a client holds, or whose command has changed; Python does that line, and the native code
continues after it. Where rows are switched off, `MasterUpdate` does all. Both give the same numbers to the last bit.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any, NamedTuple, Protocol

from libgz.base.errors import USER_ERRORS, pass_interrupt
from libgz.base.law import LeftToPython, is_law
from libgz.base.records import BeginRecord, JobRecord, Kind, LawRecord, PublishRecord, Row, UpdatesRecord
from libgz.ode.step import LONGEST
from libgz.physics.engine import Engine
from libgz.simulation.clock import Clock
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Line, Plan, overrides
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.simulation.recorder import Recorder
from libgz.simulation.running_code import names
from libgz.transport.interface import Interface
from libgz.transport.server import LocalServer

__all__ = ["LawCall", "UpdateRows", "run_exchanges"]


class Updated(Protocol):
    """An entity, as the rows use it."""

    failed: BaseException | None

    def GetId(self) -> str:
        """Its name."""

    def _entity_plan(self, plan: Plan) -> None:
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


Twin = Callable[[float], object]  # does a row in Python; its argument is the length of the step [s]


def _raise(error: BaseException, _step: float) -> None:
    raise error


def _nothing(_step: float) -> None:
    """The twin of rows that native code can always do."""


class _Line(NamedTuple):
    """What Python knows of a row."""

    entity: Any
    twin: Twin
    rate: Any = None  # of a row that is about one


class UpdateRows:
    """The rows of a world. They are built before a step if anything that they depend on has changed since.

    Args:
        world: the world.

    Attributes:
        valid: whether they are those of the present world; whoever changes parts of a model sets it to False.
        updating: the entities that have something to do in a step, in order.
        begin, end: where the rows of the entities are.
        physics: the row of the physics step; those from `end` to it are of companions.
        tail: where the rows begin that report the step.
        job: all rows, done natively for so many steps as Python has nothing to do in.
        run_all: does that job, in this thread.
        count: of all rows.
        builds: how often they were built.
        native: whether native code does the rows.
    """

    def __init__(self, world: HasUpdates) -> None:
        self.world = world
        self.valid = False
        self._enabled = True
        self.updating: list[Any] = []
        self.begin = self.end = self.physics = self.tail = self.count = self.builds = 0
        self._run, self._prepare = world.engine.native.updates()
        self.native = True
        self._entity: Updated | None = None
        self._recorded: dict[Any, Any] = {}  # the laws of the rows, by what they are of
        self._recording: dict[Any, Any] = {}  # those of the rows that are being built
        self.clear()

    def close(self) -> None:
        """Drop the rows and what was recorded: it refers to the memory of interfaces, which is to be unmapped."""
        self.clear()
        self._recorded, self._recording = {}, {}

    def clear(self) -> None:
        """Drop all rows, and what they point to."""
        self.valid = False
        self._record: Any = None
        self.job = JobRecord()
        self.run_all: Callable[[], object] = lambda: None
        self._rows: list[Row] = []
        self._lines: list[_Line] = []
        self._kept: list[object] = []
        self._starts: dict[int, int] = {}  # the first row of each entity that has one
        self._ends: dict[int, int] = {}  # the row after its last one
        self._unmet: set[int] = set()  # rows that Python did last, and whose condition did not hold
        self.updating = []
        self.begin = self.end = self.physics = self.tail = self.count = 0

    @property
    def enabled(self) -> bool:
        """Whether native code does the rows where it can; off for tests."""
        return self._enabled

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self._enabled = value
        self.native = value

    # Plans as rows ---------------------------------------------------------------------------------------------------

    def _add_plan(self, entity: Updated) -> None:
        """The rows of an entity."""
        plan = Plan()
        entity._entity_plan(plan)
        if all(line.rate is None or _is_known(line.rate) for line in plan.lines):
            self.follow(plan)
        else:
            self.python(entity.MasterUpdate)

    def follow(self, plan: Plan) -> None:
        """The rows of the lines of a plan."""
        starts, jumps = [], []  # the first row of each line; the rows that may jump, and the lines to which they do
        for line in plan.lines:
            starts.append(len(self._rows))
            if line.rate is not None:
                self._add(Kind.DUE, line.rate, _nothing)
                self._lines[-1] = self._lines[-1]._replace(rate=line.rate)
            elif line.bundle is not None:
                self._add(Kind.CAST, line.bundle.record(), line.run, line.bundle)
            elif line.post is not None:
                self._add(Kind.POST, line.post.posting(), line.run)
            elif line.law is None or not self._add_law(line):
                self.python(self._deciding(line) if line.conditional else line.run)
            if line.end:
                jumps.append((starts[-1], line.end))
        starts.append(len(self._rows))
        for row, end in jumps:
            self._rows[row].jump = starts[end]

    def _deciding(self, line: Line) -> Twin:
        """The twin of a line on which others depend."""
        number = len(self._rows)

        def decide(step: float) -> None:
            self._unmet.discard(number)
            if not line.run(step):
                self._unmet.add(number)

        return decide

    def _add_law(self, line: Line) -> bool:
        """A row for a law; false where Python has to do it."""
        interface, method = line.interface, line.law or _nothing
        recorder = Recorder() if interface is None else Exchange(interface)
        if isinstance(recorder, Exchange):
            if not recorder.interface.link.memory:
                return False
            if line.unless is not None:
                line.unless(recorder)
        body = Recorder(interface)
        key = (
            id(getattr(method, "__self__", None)),
            getattr(method, "__func__", method),
            id(interface),
            line.arguments,
        )
        if not ((known := self._recorded.get(key)) and recorder.take(known)):
            data = () if interface is None else (interface.data,)
            step = (body.number(self.world.engine.tables.record, "step"),) if line.stepped else ()
            try:
                body.record(method, *data, *step, *line.arguments)
            except LeftToPython:
                return False
            known = body
            if not recorder.take(body):
                return False  # what it is taken from differs each time that it is asked
        self._recording[key] = known
        if interface is None and not line.conditional and not recorder.operations and not recorder.effects:
            return True  # such as `act` of a robot that does nothing then
        if line.conditional:
            self.share(self._deciding(line), recorder, conditional=True)
        else:
            self.share(line.run, recorder, retried=line.unless is None)
        return True

    def python(self, twin: Twin) -> None:
        """A row that Python always does."""
        self._add(Kind.PYTHON, None, twin)

    def share(self, twin: Twin, recorder: Recorder, *, retried: bool = False, conditional: bool = False) -> None:
        """Do what was recorded; with an interface, under its lock.

        Args:
            twin: does it in Python; without the lock, it does nothing then.
            recorder: has recorded it.
            retried: whether native code may do it after all, once Python has the lock.
            conditional: whether the rows up to its `jump` depend on what the law returned.
        """
        part, kept = recorder.result(conditional=conditional)
        interface = recorder.interface
        memory = interface.memory if interface is not None and interface.link.memory else None  # stays mapped meanwhile
        if retried and interface is not None:
            twin = partial(self._share_again, len(self._rows), interface, twin)
        self._add(Kind.LAW, part, twin, memory, kept)

    def _share_again(self, number: int, interface: Interface[Any], twin: Twin, step: float) -> None:
        """Wait for the lock and repair the file, which native code leaves to Python, and do the row natively after all.

        A twin takes many times as long, and a client can have the native row refused in each step.
        """
        if self.valid and interface.link.memory and interface.lock() and self.run(number, number + 1) > number:
            return  # it has released the lock
        twin(step)

    def _add(self, kind: Kind, part: Any, twin: Twin, *kept: object) -> None:
        self._rows.append(Row(kind, 0, None if part is None else ctypes.addressof(part)))
        self._lines.append(_Line(self._entity, twin))
        self._kept.append((part, kept))

    def exchange(self, name: str, interface: Interface[Any], make: Callable[[], Exchange]) -> Exchange:
        """An exchange of the world itself, which stays the same as long as the interface has the same memory."""
        key = (name, id(interface), interface.link.memory)
        found = self._recording[key] = self._recorded.get(key) or make()
        return found

    # What the world adds ---------------------------------------------------------------------------------------------

    @contextmanager
    def building(self) -> Iterator[UpdateRows]:
        """Build all rows, in the order of a step."""
        self.clear()
        self.valid = True  # false again if what is called meanwhile changes something
        self._recording = {}
        yield self
        self._recorded = self._recording
        self.builds += 1
        self.count = len(self._rows)
        rows = (Row * self.count)(*self._rows)
        tables, clock = self.world.engine.tables.record, self.world.clock
        wanted = self.world.engine.lock.wanted
        record = UpdatesRecord(*(ctypes.addressof(part) for part in (tables, clock, rows, wanted)))
        self._kept.append((rows, record, tables, clock, wanted))
        self._record = ctypes.byref(record)
        self.job = JobRecord(ctypes.addressof(record), self.count, seconds=LONGEST)
        self.run_all = self._prepare(self.job)

    def begin_step(self, period: int, at_start: bool, twin: Twin) -> None:
        """Count the step.

        Args:
            period: after so many steps Python does that.
            at_start: whether sim time grows now, and not in `advance`.
            twin: does it in Python.
        """
        self._beginning = BeginRecord(period, at_start)
        self._add(Kind.BEGIN, self._beginning, twin)

    def entities(self) -> None:
        """The rows of all entities; those from `begin` to `end`."""
        self.begin = len(self._rows)
        for entity in self.world.entities:
            if isinstance(entity.failed, BaseException):
                continue
            self._entity, start = entity, len(self._rows)
            try:
                self._add_plan(entity)
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
        self.physics = len(self._rows)
        self._add(Kind.ADVANCE, self._beginning, twin)

    def end_physics(self) -> None:
        """What follows, from `tail` on, only reports the step."""
        self.tail = len(self._rows)

    def publish(self, twin: Twin, record: PublishRecord) -> None:
        """Copy the states for other processes."""
        self._add(Kind.PUBLISH, record, twin)

    def post(self, twin: Twin) -> None:
        """Wake the clients."""
        self._add(Kind.POST, self.world.gz_server.posting(), twin)

    def laws_hold(self) -> bool:
        """Whether all that the laws of the rows take as constant is as it was when they were recorded."""
        return all(recorder.holds() for recorder in self._recorded.values())

    # Run -------------------------------------------------------------------------------------------------------------

    def run(self, begin: int, end: int) -> int:
        """Do rows natively, from one up to another; the number of the one that Python has to do, or `end`."""
        run: Any = self._run
        return int(run(self._record, begin, end))

    def line(self, number: int) -> _Line:
        """Whose a row is, and how Python does it."""
        return self._lines[number]

    def after_twin(self, number: int) -> int:
        """The row that follows one that Python has done."""
        return self._rows[number].jump if number in self._unmet else number + 1

    def next_in_python(self, number: int) -> int:
        """The row after one, where Python does all: what is not due is left out."""
        number = self.after_twin(number)
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


def run_exchanges(world: HasRows, exchanges: Sequence[tuple[Exchange, Callable[[], object]]]) -> Callable[[], None]:
    """A function that does exchanges now, each of them natively or in Python; the caller holds the lock."""
    records: list[LawRecord] = []
    kept: list[object] = []
    for exchange, _ in exchanges:
        record, points_to = exchange.result()
        records.append(record)
        kept.append((points_to, exchange.interface.memory))
    rows = (Row * len(records))(*(Row(Kind.LAW, 0, ctypes.addressof(record)) for record in records))
    tables, clock, count = world.engine.tables.record, world.clock, len(records)
    table = UpdatesRecord(*(ctypes.addressof(part) for part in (tables, clock, rows)))
    function, _ = world.engine.native.updates()

    def run(number: int) -> int:
        """The number of the next exchange that Python has to do."""
        return int(function(ctypes.byref(table), number, count)) if world.rows.native else number

    def exchange_all(_kept: object = (records, kept, rows)) -> None:
        number = run(0)
        while number < count:
            exchanges[number][1]()
            number = run(number + 1)

    return exchange_all


class LawCall:
    """A law that is computed between steps: natively where that is possible, else in Python.

    It is recorded again when what it takes as constant has changed.

    Args:
        world: of the bodies and joints that it uses.
        method: the law, a method without arguments that uses no interface. Python always computes one that is none.

    Attributes:
        world: the world.
    """

    def __init__(self, world: HasRows, method: Callable[[], object]) -> None:
        self.world, self._method = world, method
        self._native = is_law(method)
        self._recorder: Recorder | None = None
        self._run: Callable[[], int] | None = None  # None: Python computes it
        self._address = 0
        self._kept: object = None
        self._refused = -1  # how often the rows had been built when it could not be recorded

    @property
    def address(self) -> int:
        """Of its `LawRecord`, for a job; 0 where Python has to compute it now."""
        return self._address if self._is_recorded() else 0

    def _is_recorded(self) -> bool:
        """Whether native code can compute it now."""
        rows = self.world.rows
        if not (self._native and rows.native):
            return False
        if (self._recorder is None or not self._recorder.holds()) and self._refused != rows.builds:
            self._record_again()
        return self._run is not None

    def _record_again(self) -> None:
        recorder = Recorder()
        self._recorder = self._run = None
        try:
            recorder.record(self._method)
        except LeftToPython:
            self._refused = self.world.rows.builds
            return
        self._recorder, (record, kept) = recorder, recorder.result()
        self._address = ctypes.addressof(record)
        row = (Row * 1)(Row(Kind.LAW, 0, self._address))
        tables, clock = self.world.engine.tables.record, self.world.clock
        table = UpdatesRecord(*(ctypes.addressof(part) for part in (tables, clock, row)))
        run, _ = self.world.engine.native.updates()
        self._run = partial(run, ctypes.byref(table), ctypes.c_int64(0), ctypes.c_int64(1))
        self._kept = (record, kept, row)

    def __call__(self) -> None:
        """Compute it; the caller holds the world's lock."""
        if not self._is_recorded() or self._run is None or not self._run():
            self._method()


def _is_known(rate: UpdateRate) -> bool:
    """Whether native code finds as the rate does when it is due."""
    return type(rate) in (UpdateRate, OldRate) and not overrides(rate, UpdateRate, "due")


def _what_runs(values: Mapping[str, Any]) -> str:
    return f"the physics step of {len(values['self'].world.engine.bodies)} bodies"


names(UpdateRows.run, _what_runs)
