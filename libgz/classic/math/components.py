"""Common parts of the types that have components: accessors, and arithmetic component by component."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import add, mul, sub, truediv
from typing import TypeVar

__all__ = ["Componentwise", "HasXY", "HasXYZ"]

C = TypeVar("C", bound="Componentwise")


class HasXY:
    """Accessors of the components x and y."""

    __slots__ = ()

    x: float
    y: float

    def X(self, value: float | None = None) -> float:
        """The x component; an argument sets it first."""
        if value is not None:
            self.x = value  # type: ignore[misc]  # a slot of the subclass
        return self.x

    def Y(self, value: float | None = None) -> float:
        """The y component; an argument sets it first."""
        if value is not None:
            self.y = value  # type: ignore[misc]  # a slot of the subclass
        return self.y


class HasXYZ(HasXY):
    """Accessors of the components x, y and z."""

    __slots__ = ()

    z: float

    def Z(self, value: float | None = None) -> float:
        """The z component; an argument sets it first."""
        if value is not None:
            self.z = value  # type: ignore[misc]  # a slot of the subclass
        return self.z


class Componentwise:
    """Operators that combine each component with that of another value, or with a number."""

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0  # numpy's numbers leave `number * value` to these classes

    def __init__(self, *components: float) -> None:
        raise NotImplementedError

    def __iter__(self) -> Iterator[float]:
        raise NotImplementedError

    def _operand(self, value: object) -> Iterable[float] | None:
        """Return the components of the other operand; None if it is not allowed."""
        raise NotImplementedError

    def __add__(self: C, other: object) -> C:
        o = self._operand(other)
        return NotImplemented if o is None else type(self)(*map(add, self, o))

    __radd__ = __add__

    def __sub__(self: C, other: object) -> C:
        o = self._operand(other)
        return NotImplemented if o is None else type(self)(*map(sub, self, o))

    def __rsub__(self: C, other: object) -> C:
        o = self._operand(other)
        return NotImplemented if o is None else type(self)(*map(sub, o, self))

    def __mul__(self: C, other: object) -> C:
        o = self._operand(other)
        return NotImplemented if o is None else type(self)(*map(mul, self, o))

    __rmul__ = __mul__

    def __truediv__(self: C, other: object) -> C:
        o = self._operand(other)
        return NotImplemented if o is None else type(self)(*map(truediv, self, o))
