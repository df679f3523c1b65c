"""Vector2d and Vector2i: vectors of two numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from numbers import Real
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.classic.math.components import Componentwise, HasXY
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import numbers_in, text_of

__all__ = ["Vector2", "Vector2d", "Vector2i"]

V = TypeVar("V", bound="Vector2d")


class Vector2d(Componentwise, HasXY):
    """A point or direction in a plane, or a pair of numbers: x, y. Operators and `==` are as in Vector3d."""

    __slots__ = ("x", "y")
    __hash__ = None  # type: ignore[assignment]
    __match_args__ = ("x", "y")

    x: float
    y: float

    Zero: Constant[Vector2d] = Constant(lambda: Vector2d(0.0, 0.0))
    One: Constant[Vector2d] = Constant(lambda: Vector2d(1.0, 1.0))

    def __init__(self, x: float | Sequence[float] | Vector2d | None = None, y: float | None = None) -> None:
        """From two numbers, from a sequence of two, or zero.

        Raises:
            ParameterError: there are not two numbers.
        """
        if y is not None:
            self.x, self.y = x, y  # type: ignore[assignment]
        elif x is None:
            self.x = self.y = 0.0
        else:
            try:
                self.x, self.y = x  # type: ignore[misc]
            except (TypeError, ValueError):
                kind = type(self).__name__
                raise ParameterError(f"a {kind} takes two numbers, or none, or a vector, not {x!r}") from None

    @classmethod
    def from_sdf(cls: type[V], text: str) -> V:
        """From the text of an SDF element.

        Raises:
            ParameterError: there are not two numbers.
        """
        return cls(*numbers_in(text, 2))

    def Set(self, x: float = 0.0, y: float = 0.0) -> None:
        """Set both components."""
        self.x, self.y = x, y

    def __iter__(self) -> Iterator[float]:
        return iter((self.x, self.y))

    def __len__(self) -> int:
        return 2

    def __getitem__(self, index: int) -> float:
        return (self.x, self.y)[index]

    def __setitem__(self, index: int, value: float) -> None:
        setattr(self, ("x", "y")[index], value)

    def __array__(self, dtype: object = None, copy: bool | None = None) -> NDArray[Any]:
        return np.array((self.x, self.y))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.x!r}, {self.y!r})"

    def __str__(self) -> str:
        return text_of(self.x, self.y)

    def _operand(self, value: object) -> tuple[float, ...] | None:
        if isinstance(value, Vector2d):
            return value.x, value.y
        if isinstance(value, Real):
            return (float(value),) * 2
        if not isinstance(value, Iterable):
            return None
        numbers = tuple(value)
        return numbers if len(numbers) == 2 and all(isinstance(number, Real) for number in numbers) else None

    def __neg__(self: V) -> V:
        return type(self)(-self.x, -self.y)

    def __eq__(self, other: object) -> bool:
        return self.x == other.x and self.y == other.y if isinstance(other, Vector2d) else NotImplemented

    def Equal(self, other: Sequence[float] | Vector2d, tolerance: float = 1e-3) -> bool:
        """Whether no component differs by more than `tolerance`."""
        x, y = other
        return abs(self.x - x) <= tolerance and abs(self.y - y) <= tolerance

    def Length(self) -> float:
        """The length."""
        return math.hypot(self.x, self.y)

    def SquaredLength(self) -> float:
        """The square of the length."""
        return self.x * self.x + self.y * self.y

    def Dot(self, other: Sequence[float] | Vector2d) -> float:
        """The dot product."""
        x, y = other
        return self.x * x + self.y * y

    def Distance(self, other: Sequence[float] | Vector2d) -> float:
        """The distance to a point."""
        return math.dist(self, tuple(other))

    def Normalize(self) -> None:
        """Scale it to length 1; zero stays zero."""
        if length := self.Length():
            self.Set(self.x / length, self.y / length)

    def Normalized(self: V) -> V:
        """A copy of length 1; of zero, zero."""
        copy = type(self)(self.x, self.y)
        copy.Normalize()
        return copy

    def IsFinite(self) -> bool:
        """Whether no component is infinite or NaN."""
        return math.isfinite(self.x) and math.isfinite(self.y)


class Vector2i(Vector2d):
    """A pair of integers, such as a pixel; fractions are truncated, also those of quotients, as in C++."""

    __slots__ = ()
    __hash__ = None

    x: int
    y: int

    Zero: Constant[Vector2i] = Constant(lambda: Vector2i(0, 0))
    One: Constant[Vector2i] = Constant(lambda: Vector2i(1, 1))

    def __init__(self, x: float | Sequence[float] | Vector2d | None = None, y: float | None = None) -> None:
        super().__init__(x, y)
        self.x, self.y = int(self.x), int(self.y)

    def X(self, value: float | None = None) -> int:
        """The x component; an argument sets it first."""
        if value is not None:
            self.x = int(value)
        return self.x

    def Y(self, value: float | None = None) -> int:
        """The y component; an argument sets it first."""
        if value is not None:
            self.y = int(value)
        return self.y

    def Set(self, x: float = 0, y: float = 0) -> None:
        """Set both components."""
        self.x, self.y = int(x), int(y)


Vector2 = Vector2d
