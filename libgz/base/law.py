"""Laws: what is computed in each step, written once as functions of numbers.

A function that `law` marks is called in Python with numbers. The library may also record it: called once with `Term`s
in place of numbers, it is a list of operations, which native code repeats in each step, in the same order and to
the bit. Other functions of mathematics than those here, and decisions by a number, cannot be recorded: `where` chooses
between two numbers, and `usually` and `rarely` leave a step to Python.
"""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable
from enum import IntEnum
from pathlib import Path
from typing import Any, Protocol, TypeVar, overload

from libgz.base.errors import GazeboError

__all__ = [
    "LawError",
    "LeftToPython",
    "Number",
    "Operation",
    "Recording",
    "Term",
    "Value",
    "acos",
    "asin",
    "atan",
    "atan2",
    "clamp",
    "constant",
    "copysign",
    "cos",
    "ends",
    "floor",
    "fmod",
    "hypot",
    "is_constant",
    "is_law",
    "largest",
    "law",
    "least",
    "possible",
    "rarely",
    "same",
    "sin",
    "sqrt",
    "tan",
    "unrecorded",
    "usually",
    "where",
    "whole",
    "wrong",
]

F = TypeVar("F", bound=Callable[..., Any])
Value = TypeVar("Value", float, "Term")


class LawError(GazeboError):
    """A function that is marked as a law cannot be recorded."""


class LeftToPython(Exception):
    """A law is not recorded, as it is: Python computes it."""


class Operation(IntEnum):
    """Conditions, what is read, arithmetic, and what has effects; laws.c has the same numbers."""

    REQUIRE = 0
    EXPECT = 1
    UNMARKED = 2
    SWITCH = 3
    TEXT = 4
    TRUE = 5
    FALSE = 6
    END = 7
    BODY = 8
    JOINT = 9
    BODY_STATE = 10
    JOINT_STATE = 11
    VECTOR = 12
    LOAD = 13
    REAL_TIME = 14
    GATHER = 15
    COPY = 16
    ADD = 17
    SUBTRACT = 18
    MULTIPLY = 19
    DIVIDE = 20
    NEGATE = 21
    ABSOLUTE = 22
    LEAST = 23
    MOST = 24
    LESS = 25
    AT_MOST = 26
    EQUAL = 27
    AND = 28
    OR = 29
    SELECT = 30
    SQRT = 31
    COS = 32
    SIN = 33
    TAN = 34
    ASIN = 35
    ACOS = 36
    ATAN = 37
    ATAN2 = 38
    HYPOT = 39
    FMOD = 40
    FLOOR = 41
    COPYSIGN = 42
    STORE = 43
    SEEN = 44
    SET = 45
    EFFORT = 46
    EFFORTS = 47
    VELOCITY = 48
    WAKE = 49
    NOTE = 50
    APPEND = 51


class Recording(Protocol):
    """What notes the operations of a law."""

    def compute(self, operation: Operation, *values: Any) -> Term:
        """The result of an operation."""

    def require(self, condition: Term, holds: bool) -> None:
        """Leave steps to Python in which a condition is not as it usually is."""

    def end(self, condition: Term) -> None:
        """Leave out what follows in steps in which a condition holds."""


def law(function: F) -> F:
    """Mark a function as a law, which may be recorded and then runs natively.

    It computes with the numbers of its arguments and of `self`: constants, `Number`s, arrays of doubles, and angles,
    poses and velocities of joints and bodies. It may set `Number`s and elements of arrays, fields of interfaces, and
    motors and efforts. What it calls on `self` has to be a law, too.
    """
    function.is_law = True  # type: ignore[attr-defined]
    return function


def constant(function: F) -> F:
    """Mark a method whose result, such as a body or a kind, laws take as constant when they are recorded."""
    function.is_constant = True  # type: ignore[attr-defined]
    return function


def unrecorded(function: F) -> F:
    """Mark a method that laws may call, and that is not recorded: a law that always comes to it is left to Python."""
    function.is_unrecorded = True  # type: ignore[attr-defined]
    return function


def is_law(function: object) -> bool:
    """Whether a function, or the function of a method, was marked by `law`."""
    return bool(getattr(function, "is_law", False))


def is_constant(function: object) -> bool:
    """Whether a function, or the function of a method, was marked by `constant`."""
    return bool(getattr(function, "is_constant", False))


class Number:
    """An attribute that is a double, which laws read and set; native code knows where it is.

    Args:
        start: its value at first, in the unit of the attribute [any].
    """

    def __init__(self, start: float = 0.0) -> None:
        self._start = start

    def __set_name__(self, owner: type, name: str) -> None:
        self._place = f"_number_{name}"

    @overload
    def __get__(self, owner: None, kind: type) -> Number: ...
    @overload
    def __get__(self, owner: object, kind: type) -> float: ...
    def __get__(self, owner: object | None, kind: type) -> Number | float:
        if owner is None:
            return self
        found = owner.__dict__.get(self._place)
        return self._start if found is None else found.value

    def __set__(self, owner: object, value: float) -> None:
        self.cell(owner).value = value

    def cell(self, owner: object) -> ctypes.c_double:
        """Where the number of an object is."""
        found = owner.__dict__.get(self._place)
        if found is None:
            found = owner.__dict__[self._place] = ctypes.c_double(self._start)
        return found

    def put(self, owner: object, cell: ctypes.c_double) -> None:
        """Set where the number of an object is, before a law uses it."""
        owner.__dict__[self._place] = cell


def wrong(reason: str) -> LawError:
    """An error that names the line of the law: the innermost one outside of what records."""
    frame, own = sys._getframe(1), Path(__file__).parent.parent
    recorders = (str(own / "base" / "law.py"), str(own / "simulation" / "recorder.py"))
    while frame.f_back is not None and frame.f_code.co_filename in recorders:
        frame = frame.f_back
    return LawError(f"{frame.f_code.co_filename}:{frame.f_lineno}: the law {frame.f_code.co_name} {reason}")


_FUNCTIONS = (
    "cos, sin, tan, asin, acos, atan, atan2, sqrt, hypot, fmod, floor, copysign, where, least, largest and clamp of "
    "libgz.base.law"
)


class Term:
    """A number of a law that is recorded: what it is computed from is known, and not yet its value.

    Attributes:
        address: of the double; of the first one of an array.
        count: of an array; None of a single number.
        changes: whether the double is one that may be set, and not a result.
    """

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, recording: Recording, address: int, count: int | None = None, *, changes: bool = False) -> None:
        self.recording, self.address, self.count, self.changes = recording, address, count, changes

    def _with(self, operation: Operation, *others: Any) -> Term:
        return self.recording.compute(operation, self, *others)

    def __add__(self, other: Any) -> Term:
        return self._with(Operation.ADD, other)

    def __radd__(self, other: Any) -> Term:
        return self.recording.compute(Operation.ADD, other, self)

    def __sub__(self, other: Any) -> Term:
        return self._with(Operation.SUBTRACT, other)

    def __rsub__(self, other: Any) -> Term:
        return self.recording.compute(Operation.SUBTRACT, other, self)

    def __mul__(self, other: Any) -> Term:
        return self._with(Operation.MULTIPLY, other)

    def __rmul__(self, other: Any) -> Term:
        return self.recording.compute(Operation.MULTIPLY, other, self)

    def __truediv__(self, other: Any) -> Term:
        return self._with(Operation.DIVIDE, other)

    def __rtruediv__(self, other: Any) -> Term:
        return self.recording.compute(Operation.DIVIDE, other, self)

    def __neg__(self) -> Term:
        return self._with(Operation.NEGATE)

    def __pos__(self) -> Term:
        return self

    def __abs__(self) -> Term:
        return self._with(Operation.ABSOLUTE)

    def __mod__(self, other: Any) -> Term:
        raise wrong("uses %, whose sign is Python's own; use fmod of libgz.base.law")

    def __pow__(self, other: Any) -> Term:
        raise wrong("uses **; multiply, or use sqrt of libgz.base.law")

    def __lt__(self, other: Any) -> Term:
        return self._with(Operation.LESS, other)

    def __le__(self, other: Any) -> Term:
        return self._with(Operation.AT_MOST, other)

    def __gt__(self, other: Any) -> Term:
        return self.recording.compute(Operation.LESS, other, self)

    def __ge__(self, other: Any) -> Term:
        return self.recording.compute(Operation.AT_MOST, other, self)

    def __eq__(self, other: object) -> Any:
        return self._with(Operation.EQUAL, other)

    def __ne__(self, other: object) -> Any:
        return 1.0 - self._with(Operation.EQUAL, other)

    def __and__(self, other: Any) -> Term:
        return self._with(Operation.AND, other)

    __rand__ = __and__

    def __or__(self, other: Any) -> Term:
        return self._with(Operation.OR, other)

    __ror__ = __or__

    def __bool__(self) -> bool:
        raise wrong("decides by a number; use where, usually or rarely of libgz.base.law")

    def __float__(self) -> float:
        raise wrong(f"gives a number to a function that cannot be recorded; there are {_FUNCTIONS}")

    __int__ = __index__ = __round__ = __floor__ = __ceil__ = __trunc__ = __float__

    def __len__(self) -> int:
        if self.count is None:
            raise TypeError("a single number has no length")
        return self.count

    def __getitem__(self, index: Any) -> Term:
        count = len(self)
        if isinstance(index, slice):
            begin, end, step = index.indices(count)
            if step != 1:
                raise wrong("takes every n-th number of an array")
            return Term(self.recording, self.address + 8 * begin, max(end - begin, 0), changes=self.changes)
        if isinstance(index, int):
            if not -count <= index < count:
                raise IndexError(index)
            return Term(self.recording, self.address + 8 * (index % count), changes=self.changes)
        return self._with(Operation.GATHER, index)

    def __array_ufunc__(self, function: Any, method: str, *inputs: Any, **options: Any) -> Term:
        name = function.__name__
        if method != "__call__" or options or name not in _UFUNCS:
            raise wrong(f"calls numpy.{name}, which cannot be recorded; there are {', '.join(_UFUNCS)}")
        operation = _UFUNCS[name]
        first = next(value for value in inputs if isinstance(value, Term))
        if name.startswith("greater"):
            inputs = inputs[::-1]
        return first.recording.compute(operation, *inputs)

    def __array_function__(self, function: Any, types: Any, inputs: Any, options: Any) -> Term:
        if function.__name__ != "where" or len(inputs) != 3:
            raise wrong(f"calls numpy.{function.__name__}, which cannot be recorded; there is numpy.where")
        return where(*inputs)  # type: ignore[no-any-return]


_UFUNCS = {
    "add": Operation.ADD,
    "subtract": Operation.SUBTRACT,
    "multiply": Operation.MULTIPLY,
    "divide": Operation.DIVIDE,
    "negative": Operation.NEGATE,
    "absolute": Operation.ABSOLUTE,
    "minimum": Operation.LEAST,
    "maximum": Operation.MOST,
    "less": Operation.LESS,
    "less_equal": Operation.AT_MOST,
    "greater": Operation.LESS,
    "greater_equal": Operation.AT_MOST,
    "equal": Operation.EQUAL,
}


def _recording(*values: Any) -> Recording:
    """What notes the operations of the first term."""
    return next(value.recording for value in values if isinstance(value, Term))


def _function(operation: Operation, plain: Callable[..., float]) -> Callable[..., Any]:
    """A function of floats that takes terms, too."""

    def function(*values: Any) -> Any:
        for value in values:
            if isinstance(value, Term):
                return value.recording.compute(operation, *values)
        return plain(*values)

    function.__name__ = operation.name.lower()
    function.__doc__ = f"`math.{function.__name__}`."
    return function


sqrt, cos, sin = (_function(Operation[name], getattr(math, name.lower())) for name in ("SQRT", "COS", "SIN"))
tan, asin, acos, atan = (
    _function(Operation[name], getattr(math, name.lower())) for name in ("TAN", "ASIN", "ACOS", "ATAN")
)
atan2 = _function(Operation.ATAN2, math.atan2)
hypot = _function(Operation.HYPOT, lambda x, y: math.sqrt(x * x + y * y))  # math.hypot rounds in a way of its own
fmod, floor, copysign = (
    _function(Operation[name], getattr(math, name.lower())) for name in ("FMOD", "FLOOR", "COPYSIGN")
)


def where(condition: Any, one: Any, other: Any) -> Any:
    """`one` where a condition holds, and else `other`; both are computed."""
    if isinstance(condition, Term):
        return condition.recording.compute(Operation.SELECT, condition, one, other)
    return one if condition else other


def least(one: Any, other: Any) -> Any:
    """The smaller one of two numbers, as `min`."""
    if isinstance(one, Term) or isinstance(other, Term):
        return _recording(one, other).compute(Operation.LEAST, one, other)
    return other if other < one else one  # to call `min` takes three times as long


def largest(one: Any, other: Any) -> Any:
    """The larger one of two numbers, as `max`."""
    if isinstance(one, Term) or isinstance(other, Term):
        return _recording(one, other).compute(Operation.MOST, one, other)
    return other if other > one else one


def clamp(value: Value, limit: float) -> Value:
    """`value` within +-limit."""
    return least(largest(value, -limit), limit)  # type: ignore[no-any-return]


def whole(value: Any) -> Any:
    """The whole number towards zero, as `int`: for fields that are integers."""
    return where(value < 0.0, -floor(-value), floor(value)) if isinstance(value, Term) else int(value)


def same(one: Any, other: Any) -> Any:
    """Whether two numbers are equal, or both NaN."""
    return (one == other) | ((one != one) & (other != other))


def usually(condition: Any) -> bool:
    """Whether a condition holds; one that does in most steps. Native code leaves the other steps to Python."""
    if isinstance(condition, Term):
        condition.recording.require(condition, True)
        return True
    return bool(condition)


def rarely(condition: Any) -> bool:
    """Whether a condition holds; one that does not in most steps. Native code leaves the other steps to Python."""
    if isinstance(condition, Term):
        condition.recording.require(condition, False)
        return False
    return bool(condition)


def possible(condition: Any) -> bool:
    """Whether a condition holds, or may hold in other steps: what follows only matters where it does, by `where`."""
    return isinstance(condition, Term) or bool(condition)


def ends(condition: Any) -> bool:
    """Whether a condition holds, with which there is nothing left to do: `if ends(condition): return`.

    It stands in the law itself, not in one that this calls, and before anything is set.
    """
    if isinstance(condition, Term):
        condition.recording.end(condition)
        return False
    return bool(condition)
