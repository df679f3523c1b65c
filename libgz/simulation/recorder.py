"""Recorder: calls a law once, and notes the operations that native code repeats in each step.

In place of `self`, and of all objects that are reached from there, the law gets `Traced` ones: where it reads a double
they give a `Term`, where it calls a law they record that, too, and where it sets something they note an effect. What is
no double is taken as it is when the law is recorded. Native code does the effects when all else is done: so a step
that it leaves to Python has changed nothing.
"""

from __future__ import annotations

import ctypes
import sys
import types
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.base.law import LeftToPython, Number, Operation, Term, is_constant, is_law, wrong
from libgz.base.records import LawRecord, OperationRecord, TableRecord
from libgz.ode.lib import ode
from libgz.ode.types import dParamVel, dParamVel2
from libgz.physics.body import Body, point_velocity
from libgz.physics.check import LARGEST
from libgz.physics.engine import Engine
from libgz.physics.joint import AxisJoint, HingeJoint, Joint, SliderJoint
from libgz.physics.rays import RayProximity
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint
from libgz.transport.interface import Interface, View

__all__ = ["Recorder", "recorded_as"]

F = TypeVar("F", bound=Callable[..., Any])

_BLOCK = 64  # doubles that are made at once
_STATES = {Body: 16, Joint: 4}  # numbers of a row of the tables
_TYPES = "dfiIHB"  # of numbers in interfaces, as numpy's letters
_PLAIN = (bool, int, float, str, bytes, frozenset, type, types.ModuleType, GzVector, GzQuatern, GzPose)


class Traced:
    """An object, as a law sees it that is recorded."""

    __slots__ = ("_traced", "_traced_by")

    def __init__(self, recorder: Recorder, traced: Any) -> None:
        object.__setattr__(self, "_traced_by", recorder)
        object.__setattr__(self, "_traced", traced)

    @property  # type: ignore[misc]
    def __class__(self) -> Any:  # so that `super()` and `isinstance` find that of the object
        return type(self._traced)

    def __getattr__(self, name: str) -> Any:
        return self._traced_by.get(self._traced, name)

    def __setattr__(self, name: str, value: Any) -> None:
        self._traced_by.set(self._traced, name, value)


class Cells(Term):
    """An array of doubles that a law may set."""

    def __init__(self, recorder: Recorder, view: NDArray[np.float64]) -> None:
        super().__init__(recorder, view.ctypes.data, len(view), changes=True)
        self.recorder, self.view = recorder, view

    def __getitem__(self, index: Any) -> Term:
        if isinstance(index, np.ndarray):
            return super().__getitem__(index)
        return self.recorder.read(self.view[index, ...])

    def __setitem__(self, index: Any, value: Any) -> None:
        self.recorder.assign(self.view[index, ...], value)


class Places:
    """An array in the memory of the interface."""

    def __init__(self, recorder: Recorder, view: NDArray[Any]) -> None:
        self.recorder, self.view = recorder, view

    def __len__(self) -> int:
        return len(self.view)

    def __getitem__(self, index: Any) -> Any:
        view = self.view[(*index, ...)] if isinstance(index, tuple) else self.view[index, ...]
        return self.recorder.read(view) if view.ndim == 0 else Places(self.recorder, view)

    def __setitem__(self, index: Any, value: Any) -> None:
        self.recorder.assign(self.view[(*index, ...)] if isinstance(index, tuple) else self.view[index, ...], value)


class Recorder:
    """Notes the operations of one law.

    Args:
        interface: whose fields it reads and sets, under the lock; None: it needs none.
    """

    def __init__(self, interface: Interface[Any] | None = None) -> None:
        self.interface = interface
        link = interface.link if interface is not None else None
        self._memory = (int(link.memory), int(link.size)) if link is not None and link.memory else (0, 0)
        self.operations: list[bytes] = []  # of `OperationRecord`s, which are copied in one piece then
        self.effects: list[bytes] = []
        self.kept: list[object] = [interface]  # what the operations point to
        self._written: dict[int, Term] = {}  # what doubles of ours are set to
        self._states: dict[int, int] = {}  # where the numbers of a body or joint are
        self._constants: dict[bytes, int] = {}
        self._recorded: Any = None  # the function of the law
        self._next, self._left = 0, 0
        self.moved: set[tuple[int, int]] = set()  # bodies whose velocities the law sets, and their columns
        self.returned: int | None = None  # where the number is that the law returned
        self._taken: dict[tuple[int, str], tuple[Any, str, Any]] = {}  # attributes that were taken as they are
        self._found: list[tuple[types.MethodType, Any, Any]] = []  # what methods returned: method, arguments, result
        self._handles: dict[int, tuple[Any, int, int]] = {}  # bodies and joints, with handle and row
        self._made: list[tuple[Callable[[], Any], Any]] = []  # what holds as long as an engine has the same objects
        self._engines: dict[int, tuple[TableRecord, int]] = {}  # tables, and what they counted when that was seen

    def record(self, function: Callable[..., Any], *arguments: Any) -> None:
        """Call a law, a method.

        Raises:
            LeftToPython: Python has to compute it: it is none, or uses something that is none.
            LawError: it cannot be recorded; the message has the line.
        """
        self.kept.append(function)
        self._recorded = getattr(function, "__func__", None)
        returned = self.wrap(function)(*[self.wrap(argument) for argument in arguments])
        self.returned = self._operand(returned)[0] if isinstance(returned, (Term, bool)) else None

    def result(self, *, conditional: bool = False) -> tuple[LawRecord, object]:
        """For native code; and what has to be kept as long as that is used.

        Args:
            conditional: whether rows depend on what the law returned.
        """
        every = (*self.operations, *self.effects)
        operations = (OperationRecord * len(every)).from_buffer_copy(b"".join(every))
        link = self.interface.link if self.interface is not None else None
        address = None if link is None else ctypes.addressof(link)
        record = LawRecord(address, ctypes.addressof(operations), len(every), self.returned if conditional else None)
        return record, (operations, link, self.kept)

    def take(self, other: Recorder) -> bool:
        """Take what another one recorded, unless that has changed since: to record takes a hundred times as long."""
        if self._memory != other._memory or not other.holds():
            return False
        self.operations += other.operations
        self.effects += other.effects
        self.returned = other.returned
        self.kept.append(other.kept)
        for thing, name, _ in other._taken.values():
            watched = getattr(thing, "__dict__", {}).get("_watched")
            if watched is not None:
                watched.add(name)  # where it is set, the law is recorded again
        return True

    def holds(self) -> bool:
        """Whether objects are as they were when they were recorded."""
        for tables, changes in self._engines.values():
            if tables.changes != changes:
                if not self._has_objects():
                    return False
                break
        for method, values, found in self._found:
            if not _is_as(found, method(*values)):
                return False
        for thing, name, before in self._taken.values():
            now = getattr(thing, name, None)
            if now is before or (type(now) is types.MethodType and now == before):  # as nearly all are
                continue
            if not _is_as(before, now):
                return False
        return True

    def _has_objects(self) -> bool:
        """Whether bodies and joints are those that were recorded; they change only when rows are taken or freed."""
        for thing, id_, row in self._handles.values():
            if thing.closed or (thing.id, thing.row) != (id_, row):
                return False
        if any(find() is not found for find, found in self._made):
            return False
        self._engines = {key: (tables, tables.changes) for key, (tables, _) in self._engines.items()}
        return True

    # Operations --------------------------------------------------------------------------------------------------

    def compute(self, operation: Operation, *values: Any) -> Term:
        """The result of an operation on numbers and arrays.

        Raises:
            LawError: a value is no number, or arrays have different sizes.
        """
        if operation == Operation.GATHER:
            array, indices = values
            if not isinstance(indices, np.ndarray) or indices.dtype != np.int64 or indices.ndim != 1:
                raise wrong("takes numbers of an array by something else than an array of integers")
            if indices.size and not 0 <= indices.min() <= indices.max() < len(array):
                raise wrong(f"takes numbers of an array of {len(array)} that are not there")
            indices = np.ascontiguousarray(indices)
            self.kept.append(indices)
            operands, count = [(self._operand(array)[0], 1), (indices.ctypes.data, 1)], len(indices)
            shape: int | None = count
        else:
            found = [self._operand(value) for value in values]
            sizes = {size for _, size in found if size is not None}
            if len(sizes) > 1:
                raise wrong(f"computes with arrays of the sizes {', '.join(map(str, sorted(sizes)))}")
            shape = next(iter(sizes), None)
            count = 1 if shape is None else shape
            operands = [(address, 0 if size is None else 1) for address, size in found]
        result = self._registers(count)
        self._add(self.operations, operation, operands, result, count)
        return Term(self, result, shape)

    def require(self, condition: Term, holds: bool) -> None:
        """Leave steps to Python in which a condition is not as it usually is."""
        address, size = self._operand(condition)
        if size is not None:
            raise wrong("expects something of an array; take its numbers apart")
        self._add(self.operations, Operation.TRUE if holds else Operation.FALSE, [(address, 0)])

    def end(self, condition: Term) -> None:
        """Leave out what follows in steps in which a condition holds."""
        address, size = self._operand(condition)
        if size is not None:
            raise wrong("ends by an array; take its numbers apart")
        if self.effects:
            raise wrong("ends after it has set something")
        if sys._getframe(2).f_code is not getattr(self._recorded, "__code__", None):
            raise wrong("ends in a part of a law")
        self._add(self.operations, Operation.END, [(address, 0)])

    def add(self, operation: Operation, **values: Any) -> None:
        """Note a condition or an effect as it is."""
        effect = operation >= Operation.STORE
        (self.effects if effect else self.operations).append(bytes(OperationRecord(code=operation, **values)))

    def _add(
        self,
        to: list[bytes],
        operation: Operation,
        operands: list[tuple[int, int]],
        result: int | None = None,
        count: int = 1,
    ) -> None:
        padded = [*operands, (None, 0), (None, 0)][:3]
        addresses, strides = [address for address, _ in padded], [stride for _, stride in padded]
        to.append(bytes(OperationRecord(operation, count, tuple(strides), 0, *addresses, result)))

    def _registers(self, count: int) -> int:
        """The address of so many doubles, mostly next to those before."""
        if count > self._left:
            block = (ctypes.c_double * max(count, _BLOCK))()
            self.kept.append(block)
            self._next, self._left = ctypes.addressof(block), len(block)
        address = self._next
        self._next, self._left = address + 8 * count, self._left - count
        return address

    def _operand(self, value: Any) -> tuple[int, int | None]:
        """Where a number or the numbers of an array are, and how many; None: a single number."""
        if isinstance(value, Term):
            if value.recording is not self:
                raise wrong("uses a number of another law")
            return self._all(value) if isinstance(value, Cells) else value.address, value.count
        if isinstance(value, Places):
            term = self.read(value.view)
            return term.address, term.count
        if isinstance(value, np.ndarray) and value.ndim == 1 and value.dtype in (np.float64, np.int64):
            array = np.ascontiguousarray(value, dtype=np.float64)
            self.kept.append(array)
            return array.ctypes.data, len(array)
        if isinstance(value, (bool, int, float, np.number, np.bool_)):
            return self._constant(float(value)), None
        raise wrong(f"computes with {value!r}, which is no number")

    def _constant(self, value: float) -> int:
        key = bytes(ctypes.c_double(value))
        if key not in self._constants:
            address = self._registers(1)
            ctypes.c_double.from_address(address).value = value
            self._constants[key] = address
        return self._constants[key]

    # Memory ------------------------------------------------------------------------------------------------------

    def _offset(self, address: int) -> int | None:
        """Where in the interface an address is."""
        begin, size = self._memory
        return address - begin if begin <= address < begin + size else None

    def read(self, view: NDArray[Any]) -> Term:
        """A number, or an array of one dimension, as it is in each step."""
        address, shape = view.ctypes.data, None if view.ndim == 0 else len(view)
        count = 1 if shape is None else shape
        offset = self._offset(address)
        if offset is not None:
            if view.dtype.char not in _TYPES or view.ndim > 1:
                raise wrong("reads what is no number, or an array of several dimensions")
            result = self._registers(count)
            stride, kind = view.strides[0] if view.ndim else 0, ord(view.dtype.char)
            self.add(Operation.LOAD, count=count, strides=(1, stride, 0), type=kind, two=offset, result=result)
            return Term(self, result, shape)
        if view.dtype != np.float64 or not view.flags.c_contiguous:
            raise wrong("reads an array that is not one of doubles, one after the other")
        self.kept.append(view)
        if shape is None:
            written = self._written.get(address)
            return Term(self, address, changes=True) if written is None else written
        return Cells(self, view)

    def _all(self, cells: Cells) -> int:
        """The address of the numbers of an array as the law has set them so far."""
        count = len(cells)
        if not any(cells.address + 8 * i in self._written for i in range(count)):
            return cells.address
        result = self._registers(count)
        for i in range(count):
            self._add(self.operations, Operation.COPY, [(cells[i].address, 0)], result + 8 * i)
        return result

    def put(self, memory: NDArray[np.uint8], at: int, kind: str, value: Any) -> None:
        """Set a number in bytes of ours that is of any type, by numpy's letter, and that no law reads."""
        if self.interface is not None or kind not in _TYPES:
            raise LeftToPython(kind)
        self.kept.append(memory)
        self.add(Operation.STORE, count=1, type=ord(kind), one=self.address(value), two=memory.ctypes.data + at)

    def append(self, data: NDArray[np.uint8], to: NDArray[np.uint8], begin: Any) -> None:
        """Copy bytes to where others begin; Python does the law where they do not fit."""
        self.kept += [data, to]
        self.require(begin + data.size <= to.size, True)
        place = self.address(begin)
        self.add(Operation.APPEND, count=data.size, one=data.ctypes.data, two=to.ctypes.data, three=place)

    def number(self, record: ctypes.Structure, name: str) -> Term:
        """A double in a struct, as it is in each step."""
        return self.read(self._view(record, name))

    def assign(self, view: NDArray[Any], value: Any) -> None:
        """Set numbers in the interface, or of ours."""
        if isinstance(value, (list, tuple, GzVector, GzQuatern)) and any(isinstance(v, Term) for v in value):
            numbers = tuple(value)
            if view.ndim == 0 or len(numbers) != len(view):
                raise wrong(f"sets {len(view) if view.ndim else 1} numbers to {len(numbers)}")
            for i, one in enumerate(numbers):
                self.assign(view[i, ...], one)
        elif view.ndim > 1:
            rows = np.broadcast_to(np.asarray(value, dtype=np.float64), view.shape)
            for i, row in enumerate(rows):
                self.assign(view[i, ...], row)
        else:
            self._assign(view, value)

    def _assign(self, view: NDArray[Any], value: Any) -> None:
        count, target = view.size, view.ctypes.data
        if isinstance(value, (list, tuple, GzVector, GzQuatern)):
            value = np.array(tuple(value), dtype=np.float64)
        source, size = self._operand(value)
        if size is not None and (view.ndim == 0 or size != count):
            raise wrong(f"sets {count} numbers to {size}")
        source = self._unchanged(value, source, 1 if size is None else size)
        stride, offset = 0 if size is None else 1, self._offset(target)
        if offset is not None:
            if view.dtype.char not in _TYPES:
                raise wrong("sets what is no number")
            strides, kind = (stride, view.strides[0] if view.ndim else 0, 0), ord(view.dtype.char)
            self.add(Operation.STORE, count=count, strides=strides, type=kind, one=source, two=offset)
            return
        if view.dtype != np.float64 or not view.flags.c_contiguous:
            raise wrong("sets an array that is not one of doubles, one after the other")
        self.kept.append(view)
        self._add(self.effects, Operation.COPY, [(source, stride)], target, count)
        changes = isinstance(value, Term) and value.changes
        for i in range(count):
            self._written[target + 8 * i] = Term(self, source + 8 * stride * i, changes=changes)

    def _unchanged(self, value: Any, source: int, count: int) -> int:
        """Where numbers are that an effect reads, and that no earlier effect has set."""
        changes = isinstance(value, Term) and value.changes
        if not changes or not any(source + 8 * i in self._written for i in range(count)):
            return source
        result = self._registers(count)
        self._add(self.operations, Operation.COPY, [(source, 1)], result, count)
        return result

    # Objects -----------------------------------------------------------------------------------------------------

    def get(self, thing: Any, name: str) -> Any:
        """An attribute of an object, as the law sees it."""
        static = _static(type(thing), name)
        if isinstance(static, Number):
            return self.read(_cell(static.cell(thing)))
        if isinstance(thing, ctypes.c_double):
            return self.read(_cell(thing))
        if isinstance(thing, ctypes.Structure) and isinstance(static, _FIELD):
            return self._field(thing, name)
        if isinstance(static, View):
            return self._array(getattr(thing, name))
        if isinstance(static, property):
            if is_law(static.fget) and static.fget is not None:
                return static.fget(Traced(self, thing))
            if not is_constant(static.fget):
                raise self._no_law(thing, name)
        value = getattr(thing, name)
        self._taken.setdefault((id(thing), name), (thing, name, _noted(value)))
        return self.wrap(value)

    def set(self, thing: Any, name: str, value: Any) -> None:
        """Set an attribute of an object."""
        static = _static(type(thing), name)
        if isinstance(static, Number):
            self.assign(_cell(static.cell(thing)), value)
        elif isinstance(thing, ctypes.c_double):
            self.assign(_cell(thing), value)
        elif isinstance(thing, ctypes.Structure) and isinstance(static, _FIELD):
            self.assign(self._view(thing, name), value)
        else:
            raise wrong(f"sets {name}, which is no number of native code; declare it: {name} = Number()")

    def _view(self, record: ctypes.Structure, name: str) -> NDArray[Any]:
        """A field of a struct as an array."""
        try:
            offset, shape, kind = _layout(type(record), name)
            return np.ndarray(shape, kind, buffer=memoryview(record).cast("B")[offset:])
        except (TypeError, ValueError) as error:
            raise wrong(f"uses {name}, which is no number or array of numbers") from error

    def _field(self, record: ctypes.Structure, name: str) -> Any:
        value = getattr(record, name)
        if isinstance(value, ctypes.Array) and issubclass(value._type_, ctypes.Structure):
            return [Traced(self, element) for element in value]
        view = self._view(record, name)
        return self._array(view) if view.ndim else self.read(view)

    def _array(self, view: NDArray[Any]) -> Any:
        return Places(self, view) if view.ndim != 1 or self._offset(view.ctypes.data) is not None else self.read(view)

    def wrap(self, value: Any) -> Any:
        """A value that is reached from an object, as the law sees it."""
        if value is None or isinstance(value, (*_PLAIN, Term, Places)) or type(value) is Traced:
            return value
        if isinstance(value, types.MethodType):
            return self._method(value)
        if isinstance(value, types.FunctionType):
            return value if is_law(value) else self._refuse(self._no_law(None, value.__name__))
        if isinstance(value, np.ndarray):
            doubles = value.dtype == np.float64 and value.ndim == 1 and value.flags.c_contiguous
            return self.read(value) if doubles else value
        if isinstance(value, ctypes.Array):
            return self.read(np.frombuffer(memoryview(value), np.float64)) if value._type_ is ctypes.c_double else value
        if type(value) in (list, tuple):
            return type(value)(self.wrap(one) for one in value)
        return Traced(self, value)

    def _method(self, method: types.MethodType) -> Callable[..., Any]:
        function, owner = method.__func__, method.__self__
        if function in _PRIMITIVES:
            return partial(_PRIMITIVES[function], self, owner)
        if is_law(function):
            return types.MethodType(function, Traced(self, owner))
        if is_constant(function):
            return partial(self._find, method)
        return self._refuse(self._no_law(owner, self._name_of(method)))

    def _find(self, method: types.MethodType, *values: Any) -> Any:
        found = method(*values)
        self._found.append((method, values, _noted(found)))
        return self.wrap(found)

    @staticmethod
    def _name_of(method: types.MethodType) -> str:
        """The name under which its class has a method."""
        every = (item for kind in type(method.__self__).__mro__ for item in vars(kind).items())
        return next((name for name, value in every if value is method.__func__), method.__name__)

    @staticmethod
    def _refuse(error: Exception) -> Callable[..., Any]:
        def refuse(*_values: Any, **_options: Any) -> Any:
            raise error

        return refuse

    @staticmethod
    def _no_law(owner: Any, name: str) -> Exception:
        """What is raised where a law uses a method that is none: if it stands in for one that is, Python does both."""
        unrecorded = getattr(getattr(type(owner), name, None), "is_unrecorded", False)
        kinds = type(owner).__mro__
        if owner is None or unrecorded or any(_is_recorded(vars(kind).get(name)) for kind in kinds):
            return LeftToPython(name)
        return wrong(f"uses {type(owner).__name__}.{name}, which is no law; mark it with @law")

    # Bodies and joints ---------------------------------------------------------------------------------------------

    def state(self, thing: Any, kind: type, column: int) -> Term:
        """A number of a body or joint in the engine's tables."""
        if thing.row < 0 or thing.closed or self._has_moved(thing, column):
            raise LeftToPython(repr(thing))
        if id(thing) not in self._states:
            result = self._registers(_STATES[kind])
            operation = Operation.BODY_STATE if kind is Body else Operation.JOINT_STATE
            self.add(operation, one=thing.id, two=thing.row, result=result)
            self._states[id(thing)] = result
            self._hold(thing)
        return Term(self, self._states[id(thing)] + 8 * column)

    def _has_moved(self, thing: Any, column: int) -> bool:
        """Whether the law has set what it reads now: native code has that only after all effects."""
        if isinstance(thing, Joint):
            return any((id(body), at) in self.moved for body in thing.bodies for at in (10, 13))
        return any((id(thing), at) in self.moved and at <= column < at + 3 for at in (10, 13))

    def states(self, body: Body, begin: int, end: int) -> list[Term]:
        """Numbers of a body."""
        return [self.state(body, Body, column) for column in range(begin, end)]

    def handle(self, thing: Any, operation: Operation) -> int:
        """Make it a condition that a body or joint is still there."""
        if thing.row < 0 or thing.closed:
            raise LeftToPython(repr(thing))
        self.add(operation, one=thing.id, two=thing.row)
        self._hold(thing)
        return int(thing.id)

    def _hold(self, thing: Any) -> None:
        """Note which body or joint it is."""
        self._handles[id(thing)] = (thing, thing.id, thing.row)
        self._watch(thing.engine)

    def _watch(self, engine: Engine) -> None:
        tables = engine.tables.record
        self._engines.setdefault(id(tables), (tables, tables.changes))

    def joint_of(self, find: Callable[[], Joint | None], engine: Engine) -> Joint | None:
        """What a function finds that depends on nothing but which objects an engine has."""
        found = find()
        self._made.append((find, found))
        self._watch(engine)
        return found

    def call(self, function: Callable[..., Any], thing: Any, *values: Any) -> Any:
        """What a law computes."""
        return function(Traced(self, thing), *values)

    def address(self, value: Any) -> int:
        """Where a number is that an effect uses."""
        address, size = self._operand(value)
        if size is not None:
            raise wrong("applies an array; take its numbers apart")
        return self._unchanged(value, address, 1)

    def limited(self, value: Any, most: float) -> int:
        """The address of a number, which has to be within +-most."""
        address = self.address(value)
        self.require(abs(Term(self, address)) <= most, True)
        return address

    def vector(self, joint: Joint, function: str) -> GzVector:
        """What a function of ODE finds for a joint, such as its anchor."""
        if joint.closed:
            raise LeftToPython(repr(joint))
        result = self._registers(4)
        self.add(Operation.VECTOR, one=joint.id, two=joint.row, three=ode().address(function), result=result)
        self._hold(joint)
        terms: Any = [Term(self, result + 8 * i) for i in range(3)]
        return GzVector(*terms)


def _static(kind: type, name: str) -> Any:
    """What a class has under a name, as it stands there."""
    return next((vars(base)[name] for base in kind.__mro__ if name in vars(base)), None)


def _cell(number: ctypes.c_double) -> NDArray[np.float64]:
    """A number as an array without dimensions."""
    return np.ndarray((), np.float64, buffer=memoryview(number).cast("B"))


def _noted(value: Any) -> Any:
    """A value, to be compared later: the elements of a list, which may change."""
    return tuple(value) if isinstance(value, list) else value


def _is_as(before: Any, now: Any) -> bool:
    """Whether a value is as it was noted."""
    if now is before:
        return True
    if isinstance(now, (list, tuple)) and isinstance(before, tuple):
        return len(before) == len(now) and all(map(_is_as, before, now))
    return isinstance(now, (types.MethodType, bool, int, float, str)) and type(now) is type(before) and now == before


@lru_cache(1024)
def _layout(struct: type[ctypes.Structure], name: str) -> tuple[int, tuple[int, ...], Any]:
    """Where a field of a struct is, its shape, and numpy's type of its numbers."""
    shape: tuple[int, ...] = ()
    kind = next(fields[name] for base in struct.__mro__ if name in (fields := dict(vars(base).get("_fields_", ()))))
    while hasattr(kind, "_length_"):
        shape, kind = (*shape, kind._length_), kind._type_
    return getattr(struct, name).offset, shape, np.dtype(kind)


def recorded_as(recording: Callable[..., Any]) -> Callable[[F], F]:
    """Mark a method of which laws record what a function says that is called with the recorder and its arguments."""

    def mark(function: F) -> F:
        _PRIMITIVES[function] = recording
        return function

    return mark


def _is_recorded(value: object) -> bool:
    function = value.fget if isinstance(value, property) else value
    return is_law(function) or is_constant(function) or (callable(function) and function in _PRIMITIVES)


# What laws do with bodies, joints and rays -------------------------------------------------------------------------


def _joint_number(column: int) -> Callable[..., Term]:
    return lambda recorder, joint: recorder.state(joint, Joint, column)


def _set_param(recorder: Recorder, joint: Joint, parameter: int, value: Any) -> None:
    if parameter not in (dParamVel, dParamVel2):
        raise wrong("sets another parameter than dParamVel and dParamVel2")
    source, handle = recorder.limited(value, LARGEST), recorder.handle(joint, Operation.JOINT)
    recorder.add(Operation.SET, one=source, two=joint.setter, type=int(parameter), result=handle)


def _joint_effort(function: str) -> Callable[..., None]:
    def add(recorder: Recorder, joint: Joint, effort: Any) -> None:
        source, handle = recorder.limited(effort, sys.float_info.max), recorder.handle(joint, Operation.JOINT)
        recorder.add(Operation.EFFORT, one=source, two=ode().address(function), result=handle)

    return add


def _body_pose(recorder: Recorder, body: Body) -> GzPose:
    x, y, z, *rotation = recorder.states(body, 0, 7)
    position: Any = (x, y, z)
    return GzPose(GzVector(*position), GzQuatern(*rotation))  # type: ignore[arg-type]


def _body_vector(begin: int) -> Callable[..., GzVector]:
    def vector(recorder: Recorder, body: Body) -> GzVector:
        numbers: Any = recorder.states(body, begin, begin + 3)
        return GzVector(*numbers)

    return vector


def _point_velocity(recorder: Recorder, body: Body, point: Any) -> GzVector:
    numbers: Any = recorder.states(body, 7, 16)
    return point_velocity(numbers, point)


def _body_effort(function: str) -> Callable[..., None]:
    def add(recorder: Recorder, body: Body, *values: Any) -> None:
        handle, vector = recorder.handle(body, Operation.BODY), recorder._registers(len(values))
        for i, value in enumerate(values):
            source = recorder.limited(value, sys.float_info.max)
            recorder._add(recorder.operations, Operation.COPY, [(source, 0)], vector + 8 * i)
        address = ode().address(function)
        recorder.add(Operation.EFFORTS, count=len(values), one=vector, two=address, result=handle)

    return add


def _wake(recorder: Recorder, body: Body) -> None:
    recorder.add(Operation.WAKE, result=recorder.handle(body, Operation.BODY))


def _enable(recorder: Recorder, body: Body, enable: Any) -> None:
    if enable is not True:
        raise wrong("puts a body to sleep")
    recorder.add(Operation.WAKE, type=1, result=recorder.handle(body, Operation.BODY))


def _com_pose(recorder: Recorder, body: Body) -> GzPose:
    u, qx, qy, qz, x, y, z = recorder.states(body, 3, 10)
    position: Any = (x, y, z)
    rotation: Any = (u, qx, qy, qz)
    return GzPose(GzVector(*position), GzQuatern(*rotation))


def _set_velocity(function: str, column: int) -> Callable[..., None]:
    def set_velocity(recorder: Recorder, body: Body, velocity: Any) -> None:
        handle, vector = recorder.handle(body, Operation.BODY), recorder._registers(3)
        for i, value in enumerate(velocity):
            source = recorder.limited(value, LARGEST)
            recorder._add(recorder.operations, Operation.COPY, [(source, 0)], vector + 8 * i)
        address = ode().address(function)
        recorder.add(Operation.VELOCITY, one=vector, two=address, three=body.row, type=column, result=handle)
        recorder.moved.add((id(body), column))

    return set_velocity


def _unmarked(recorder: Recorder, rays: RayProximity) -> bool:
    record = rays.record()
    recorder.kept += [record, rays]
    recorder.add(Operation.UNMARKED, one=ctypes.addressof(record))
    return True


def _vector(function: str) -> Callable[..., GzVector]:
    return lambda recorder, joint: recorder.vector(joint, function)


def _hinge_vector(name: str) -> Callable[..., GzVector]:
    def vector(recorder: Recorder, joint: Joint) -> GzVector:
        kinds = {HingeJoint: "Hinge", UniversalJoint: "Universal", Hinge2Joint: "Hinge2"}
        if type(joint) not in kinds:
            raise LeftToPython(repr(joint))
        return recorder.vector(joint, f"dJointGet{kinds[type(joint)]}{name}")

    return vector


_FIELD: Any = type(LawRecord.count)

_PRIMITIVES: dict[Any, Callable[..., Any]] = {
    AxisJoint.GetAngle: _joint_number(0),
    AxisJoint.GetAngleRate: _joint_number(2),
    Hinge2Joint.GetAngle1: _joint_number(0),
    Hinge2Joint.GetAngle2: _joint_number(1),
    Hinge2Joint.GetAngle1Rate: _joint_number(2),
    Hinge2Joint.GetAngle2Rate: _joint_number(3),
    UniversalJoint.GetAngleRate1: _joint_number(2),
    UniversalJoint.GetAngleRate2: _joint_number(3),
    UniversalJoint.GetAxis1: _vector("dJointGetUniversalAxis1"),
    UniversalJoint.GetAxis2: _vector("dJointGetUniversalAxis2"),
    Joint.GetAnchor: _hinge_vector("Anchor"),
    AxisJoint.GetAxis: _hinge_vector("Axis"),
    Joint.SetParam: _set_param,
    HingeJoint.SetParam: _set_param,
    HingeJoint.SetTorque: _joint_effort("dJointAddHingeTorque"),
    SliderJoint.SetSliderForce: _joint_effort("dJointAddSliderForce"),
    SliderJoint.GetAxis: _vector("dJointGetSliderAxis"),
    Body.GetPose: _body_pose,
    Body.GetLinearVel: _body_vector(10),
    Body.GetAngularRate: _body_vector(13),
    Body.GetPointVel: _point_velocity,
    Body.GetCoMPose: _com_pose,
    Body.SetLinearVel: _set_velocity("dBodySetLinearVel", 10),
    Body.SetAngularVel: _set_velocity("dBodySetAngularVel", 13),
    Joint._value: lambda recorder, joint, column: recorder.state(joint, Joint, column),
    Body.Enable: _enable,
    Body.wake: _wake,
    Body.AddForce: _body_effort("dBodyAddForce"),
    Body.AddTorque: _body_effort("dBodyAddTorque"),
    Body.AddForceAtPos: _body_effort("dBodyAddForceAtPos"),
    Body.AddForceAtRelPos: _body_effort("dBodyAddForceAtRelPos"),
    Body.AddRelForce: _body_effort("dBodyAddRelForce"),
    Body.AddRelTorque: _body_effort("dBodyAddRelTorque"),
    RayProximity.unmarked: _unmarked,
}
