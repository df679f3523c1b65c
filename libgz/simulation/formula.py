"""Formulas: control laws that are written once, as arithmetic, and computed in Python or by native updates.

A law is a function of numbers. Called with floats it is computed in Python; called with the terms of a `Formula` it is
recorded, operation by operation, and `UpdateRows.formula` has native code do the same operations in the same order.
"""

from __future__ import annotations

import ctypes
from enum import IntEnum
from typing import Any, TypeVar

from libgz.ode.records import FormulaRecord, OperationRecord, numbers
from libgz.physics.body import Body
from libgz.physics.joint import HingeJoint
from libgz.simulation.sources import address_of, check_size

__all__ = ["Formula", "Number", "Term", "clamp"]


class Operation(IntEnum):
    """Conditions, arithmetic, and what has effects; updates.c has the same numbers."""

    REQUIRE = 0
    AT_LEAST = 1
    FINITE = 2
    BODY = 3
    JOINT = 4
    ADD = 5
    SUBTRACT = 6
    MULTIPLY = 7
    DIVIDE = 8
    NEGATE = 9
    LEAST = 10
    MOST = 11
    COPY = 12
    EFFORT = 13
    EFFORTS = 14


class Term:
    """A number of a formula: what it is computed from is known, and not yet its value."""

    def __init__(self, formula: Formula, address: int) -> None:
        self._formula, self.address = formula, address

    def _with(self, operation: Operation, other: Term | float) -> Term:
        return self._formula.compute(operation, self, other)

    def __add__(self, other: Term | float) -> Term:
        return self._with(Operation.ADD, other)

    def __radd__(self, other: float) -> Term:
        return self._formula.compute(Operation.ADD, other, self)

    def __sub__(self, other: Term | float) -> Term:
        return self._with(Operation.SUBTRACT, other)

    def __rsub__(self, other: float) -> Term:
        return self._formula.compute(Operation.SUBTRACT, other, self)

    def __mul__(self, other: Term | float) -> Term:
        return self._with(Operation.MULTIPLY, other)

    def __rmul__(self, other: float) -> Term:
        return self._formula.compute(Operation.MULTIPLY, other, self)

    def __truediv__(self, other: Term | float) -> Term:
        return self._with(Operation.DIVIDE, other)

    def __rtruediv__(self, other: float) -> Term:
        return self._formula.compute(Operation.DIVIDE, other, self)

    def __neg__(self) -> Term:
        return self._formula.compute(Operation.NEGATE, self, self)

    def clamp(self, limit: float) -> Term:
        """Within +-limit."""
        return self._with(Operation.MOST, -limit)._with(Operation.LEAST, limit)


Number = TypeVar("Number", float, Term)


def clamp(value: Number, limit: float) -> Number:
    """`value` within +-limit."""
    return value.clamp(limit) if isinstance(value, Term) else min(max(value, -limit), limit)


class Formula:
    """Arithmetic for native updates: conditions, terms, and what is set or applied with them.

    Where a condition is not met, nothing is set or applied, and the twin of the row does all. `source` is what the row
    reads in each step, as for `Exchange`.
    """

    def __init__(self) -> None:
        self._conditions: list[OperationRecord] = []
        self._operations: list[OperationRecord] = []
        self._effects: list[OperationRecord] = []
        self._kept: list[object] = []

    # Conditions and numbers --------------------------------------------------------------------------------------

    def require(self, source: Any) -> None:
        """Condition: an int64 is not 0."""
        self._kept.append(source)
        self._conditions.append(OperationRecord(Operation.REQUIRE, address_of(source)))

    def at_least(self, source: Any, limit: float) -> None:
        """Condition: a double is not below a limit."""
        self._conditions.append(OperationRecord(Operation.AT_LEAST, self.read(source).address, self._constant(limit)))

    def read(self, source: Any) -> Term:
        """A double, as it is in each step.

        Raises:
            ParameterError: the source holds no double.
        """
        check_size(source, 1)
        self._kept.append(source)
        return Term(self, address_of(source) or 0)

    def compute(self, operation: Operation, one: Term | float, two: Term | float) -> Term:
        """The result of an operation."""
        places = [number.address if isinstance(number, Term) else self._constant(number) for number in (one, two)]
        result = Term(self, self._constant(0.0))
        self._operations.append(OperationRecord(operation, *places, result.address))
        return result

    def _constant(self, value: float) -> int:
        """The address of a number of its own."""
        place = ctypes.c_double(value)
        self._kept.append(place)
        return ctypes.addressof(place)

    # Effects -----------------------------------------------------------------------------------------------------

    def set(self, target: Any, value: Term | float) -> None:
        """Set a double of ours."""
        check_size(target, 1)
        self._kept.append(target)
        self._copy(value, address_of(target) or 0)

    def _copy(self, value: Term | float, target: int) -> None:
        source = value.address if isinstance(value, Term) else self._constant(value)
        self._effects.append(OperationRecord(Operation.COPY, source, None, target))

    def torque(self, hinge: HingeJoint, value: Term) -> None:
        """Add a torque about the axis of a hinge for one step [N m]."""
        handle = None if hinge.closed else hinge.id
        self._conditions.append(OperationRecord(Operation.JOINT, handle, hinge.row))
        self._operations.append(OperationRecord(Operation.FINITE, value.address))
        self._effects.append(OperationRecord(Operation.EFFORT, value.address, hinge.torque_adder, handle))

    def force(self, body: Body, x: Term, y: Term, z: Term) -> None:
        """Add a force along the body's own axes for one step [N]."""
        self._effort(body, body.force_adder, (x, y, z))

    def body_torque(self, body: Body, x: Term, y: Term, z: Term) -> None:
        """Add a torque about the body's own axes for one step [N m]."""
        self._effort(body, body.torque_adder, (x, y, z))

    def _effort(self, body: Body, adder: int, values: tuple[Term, ...]) -> None:
        handle, vector = None if body.closed else body.id, numbers(3)()
        self._kept.append(vector)
        self._conditions.append(OperationRecord(Operation.BODY, handle, body.row))
        for i, value in enumerate(values):
            self._operations.append(OperationRecord(Operation.FINITE, value.address))
            self._copy(value, ctypes.addressof(vector) + 8 * i)
        self._effects.append(OperationRecord(Operation.EFFORTS, ctypes.addressof(vector), adder, handle))

    def record(self) -> tuple[FormulaRecord, object]:
        """For native code; and what has to be kept as long as that is used."""
        all_operations = (*self._conditions, *self._operations, *self._effects)
        operations = (OperationRecord * len(all_operations))(*all_operations)
        return FormulaRecord(ctypes.addressof(operations), len(operations)), (operations, self._kept)
