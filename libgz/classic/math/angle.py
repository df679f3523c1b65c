"""Angle: an angle in radians or degrees."""

from __future__ import annotations

import math
from numbers import Real

from libgz.base.geometry import NORMALIZE
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import numbers_in, text_of

__all__ = ["Angle"]


def _radian(value: object) -> float | None:
    if isinstance(value, Angle):
        return value.radian
    return float(value) if isinstance(value, Real) else None


class Angle:
    """An angle [rad]. `float(angle)` and `angle()` are its value; arithmetic with numbers works.

    `==` and the other comparisons are exact, with angles and with numbers [rad]. `Equal` takes a tolerance.
    """

    __slots__ = ("radian",)
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0

    Zero = Constant(lambda: Angle(0.0))
    Pi = Constant(lambda: Angle(math.pi))
    HalfPi = Constant(lambda: Angle(math.pi / 2.0))
    TwoPi = Constant(lambda: Angle(2.0 * math.pi))

    def __init__(self, radian: float | Angle = 0.0) -> None:
        self.radian = float(radian)

    @classmethod
    def from_sdf(cls, text: str) -> Angle:
        """From the text of an SDF element [rad]."""
        return cls(*numbers_in(text, 1))

    def Radian(self, value: float | None = None) -> float:
        """The angle [rad]; an argument sets it first."""
        if value is not None:
            self.radian = float(value)
        return self.radian

    def Degree(self, value: float | None = None) -> float:
        """The angle [degrees]; an argument sets it first."""
        if value is not None:
            self.radian = math.radians(value)
        return math.degrees(self.radian)

    def Normalize(self) -> None:
        """Wrap it to (-pi, pi]."""
        self.radian = NORMALIZE(self.radian)

    def Normalized(self) -> Angle:
        """A copy wrapped to (-pi, pi]."""
        return Angle(NORMALIZE(self.radian))

    def Equal(self, other: float | Angle, tolerance: float = 1e-3) -> bool:
        """Whether it differs by no more than `tolerance` [rad]; whole turns are differences, too."""
        return abs(self.radian - float(other)) <= tolerance

    def __float__(self) -> float:
        return self.radian

    def __call__(self) -> float:
        """The angle [rad]."""
        return self.radian

    def __repr__(self) -> str:
        return f"Angle({self.radian!r})"

    def __str__(self) -> str:
        return text_of(self.radian)

    def __add__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(self.radian + o)

    __radd__ = __add__

    def __sub__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(self.radian - o)

    def __rsub__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(o - self.radian)

    def __mul__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(self.radian * o)

    __rmul__ = __mul__

    def __truediv__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(self.radian / o)

    def __rtruediv__(self, other: object) -> Angle:
        o = _radian(other)
        return NotImplemented if o is None else Angle(o / self.radian)

    def __neg__(self) -> Angle:
        return Angle(-self.radian)

    def __abs__(self) -> Angle:
        return Angle(abs(self.radian))

    def __eq__(self, other: object) -> bool:
        o = _radian(other)
        return NotImplemented if o is None else self.radian == o

    def __lt__(self, other: object) -> bool:
        o = _radian(other)
        return NotImplemented if o is None else self.radian < o

    def __le__(self, other: object) -> bool:
        o = _radian(other)
        return NotImplemented if o is None else self.radian <= o

    def __gt__(self, other: object) -> bool:
        o = _radian(other)
        return NotImplemented if o is None else self.radian > o

    def __ge__(self, other: object) -> bool:
        o = _radian(other)
        return NotImplemented if o is None else self.radian >= o

    SetRadian = SetFromRadian = GetAsRadian = Radian
    SetDegree = SetFromDegree = GetAsDegree = Degree
