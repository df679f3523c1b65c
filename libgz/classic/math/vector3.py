"""Vector3d: a vector of three numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from numbers import Real

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzVector, VectorLike
from libgz.base.law import Term, sqrt, where
from libgz.classic.math.components import HasXYZ
from libgz.classic.math.constant import Constant
from libgz.classic.math.number import fixnan, text_of
from libgz.sdf.value import parse

__all__ = ["Vector3", "Vector3d"]

_NUMBERS = (float, int, Term)  # checked first; numpy's numbers are handled by `_operand`


def _operand(value: object) -> GzVector | None:
    """Return the components of an operand: a number three times, or three numbers; None if it is neither."""
    if isinstance(value, Term):
        return GzVector(value, value, value)  # type: ignore[arg-type]
    if isinstance(value, Real):
        number = float(value)
        return GzVector(number, number, number)
    if not isinstance(value, Iterable):
        return None
    numbers = tuple(value)
    if len(numbers) != 3 or not all(isinstance(number, Real) for number in numbers):
        return None
    return GzVector(*numbers)


class Vector3d(HasXYZ, GzVector):
    """A position [m], velocity [m/s], force [N], direction or size: x, y, z.

    - It is a `GzVector`, so every function of the engine takes it; it converts to numpy and unpacks like a tuple.
    - Operators work between vectors component by component, and with a number: `a + b`, `a * b`, `2.0 * a`, `a + 1.0`.
      They make new vectors; `a += b` binds `a` to a new one, too, and does not change other references to the old one.
    - `==` is exact, as everywhere in Python. `Equal(other, tolerance)` compares like C++'s `==`, within 1e-3.
    - Accessors exist in both spellings: `v.x`, `v.X()`, and `v.X(1.0)`, which sets it.
    - Dividing by zero raises ZeroDivisionError, as everywhere in Python.
    """

    __slots__ = ()
    __hash__ = None  # type: ignore[assignment]
    __array_priority__ = 1000.0  # so that numpy's numbers leave `number * vector` to this class

    Zero = Constant(lambda: Vector3d(0.0, 0.0, 0.0))
    One = Constant(lambda: Vector3d(1.0, 1.0, 1.0))
    UnitX = Constant(lambda: Vector3d(1.0, 0.0, 0.0))
    UnitY = Constant(lambda: Vector3d(0.0, 1.0, 0.0))
    UnitZ = Constant(lambda: Vector3d(0.0, 0.0, 1.0))
    NaN = Constant(lambda: Vector3d(math.nan, math.nan, math.nan))

    def __init__(self, x: float | VectorLike | None = None, y: float | None = None, z: float | None = None) -> None:
        """From three numbers, from a sequence of three, or zero.

        Raises:
            ParameterError: there are not three numbers.
        """
        if z is not None and y is not None:
            self.x = x  # type: ignore[assignment]
            self.y = y
            self.z = z
        elif y is None and z is None:
            self._take(x)
        else:
            raise ParameterError(f"a Vector3d takes three numbers, or none, or a vector, not {x!r}, {y!r}, {z!r}")

    def _take(self, value: float | VectorLike | None) -> None:
        if isinstance(value, GzVector):
            self.x, self.y, self.z = value.x, value.y, value.z
            return
        if value is None:
            self.x = self.y = self.z = 0.0
            return
        try:
            self.x, self.y, self.z = value  # type: ignore[misc]
        except (TypeError, ValueError):
            raise ParameterError(f"a Vector3d takes three numbers, or none, or a vector, not {value!r}") from None

    @classmethod
    def from_sdf(cls, text: str) -> Vector3d:
        """From the text of an SDF element, as in `sdf.Get(Vector3d, "offset")`.

        Raises:
            ParameterError: there are not three numbers.
        """
        return cls(*parse(GzVector, text))

    # Components ------------------------------------------------------------------------------------------------------

    def Set(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> None:
        """Set all components."""
        self.x, self.y, self.z = x, y, z

    def __iter__(self) -> Iterator[float]:
        return iter((self.x, self.y, self.z))

    def __len__(self) -> int:
        return 3

    def __getitem__(self, index: int) -> float:
        return (self.x, self.y, self.z)[index]

    def __setitem__(self, index: int, value: float) -> None:
        setattr(self, ("x", "y", "z")[index], value)

    def __repr__(self) -> str:
        return f"Vector3d({self.x!r}, {self.y!r}, {self.z!r})"

    def __str__(self) -> str:
        return text_of(self.x, self.y, self.z)

    # Arithmetic ------------------------------------------------------------------------------------------------------

    def __add__(self, other: VectorLike | float) -> Vector3d:
        o = other if isinstance(other, GzVector) else _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(self.x + o.x, self.y + o.y, self.z + o.z)

    __radd__ = __add__

    def __sub__(self, other: VectorLike | float) -> Vector3d:
        o = other if isinstance(other, GzVector) else _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(self.x - o.x, self.y - o.y, self.z - o.z)

    def __rsub__(self, other: VectorLike | float) -> Vector3d:
        o = _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(o.x - self.x, o.y - self.y, o.z - self.z)

    def __mul__(self, other: VectorLike | float) -> Vector3d:
        if isinstance(other, _NUMBERS):
            return Vector3d(self.x * other, self.y * other, self.z * other)
        o = other if isinstance(other, GzVector) else _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(self.x * o.x, self.y * o.y, self.z * o.z)

    __rmul__ = __mul__

    def __truediv__(self, other: VectorLike | float) -> Vector3d:
        if isinstance(other, _NUMBERS):
            return Vector3d(self.x / other, self.y / other, self.z / other)
        o = other if isinstance(other, GzVector) else _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(self.x / o.x, self.y / o.y, self.z / o.z)

    def __rtruediv__(self, other: VectorLike | float) -> Vector3d:
        o = _operand(other)
        if o is None:
            return NotImplemented
        return Vector3d(o.x / self.x, o.y / self.y, o.z / self.z)

    def __neg__(self) -> Vector3d:
        return Vector3d(-self.x, -self.y, -self.z)

    def __pos__(self) -> Vector3d:
        return Vector3d(self.x, self.y, self.z)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, GzVector):
            return NotImplemented
        return self.x == other.x and self.y == other.y and self.z == other.z

    def Equal(self, other: VectorLike, tolerance: float = 1e-3) -> bool:
        """Whether no component differs by more than `tolerance`; its default is that of `==` in C++."""
        x, y, z = other
        return abs(self.x - x) <= tolerance and abs(self.y - y) <= tolerance and abs(self.z - z) <= tolerance

    # Geometry --------------------------------------------------------------------------------------------------------

    def Length(self) -> float:
        """The length."""
        square = self.x * self.x + self.y * self.y + self.z * self.z
        return math.sqrt(square) if isinstance(square, float) else sqrt(square)

    def SquaredLength(self) -> float:
        """The square of the length."""
        return self.x * self.x + self.y * self.y + self.z * self.z

    def Sum(self) -> float:
        """x + y + z."""
        return self.x + self.y + self.z

    def Dot(self, other: VectorLike) -> float:
        """The dot product."""
        x, y, z = other
        return self.x * x + self.y * y + self.z * z

    def AbsDot(self, other: VectorLike) -> float:
        """The sum of the absolute products of the components."""
        x, y, z = other
        return abs(self.x * x) + abs(self.y * y) + abs(self.z * z)

    def Cross(self, other: VectorLike) -> Vector3d:
        """The cross product, this one first."""
        x, y, z = other
        return Vector3d(self.y * z - self.z * y, self.z * x - self.x * z, self.x * y - self.y * x)

    def Distance(self, x: float | VectorLike, y: float | None = None, z: float | None = None) -> float:
        """The distance to a point, given as a vector or as three numbers."""
        return (self - Vector3d(x, y, z)).Length()

    def DistToLine(self, start: VectorLike, end: VectorLike) -> float:
        """The distance to the infinite line through two points."""
        along = Vector3d(end) - start
        return along.Cross(self - start).Length() / along.Length()

    def Normalize(self) -> Vector3d:
        """Scale it to length 1, and return it; zero stays zero."""
        length = self.Length()
        length = where(length == 0.0, 1.0, length)
        self.x, self.y, self.z = self.x / length, self.y / length, self.z / length
        return self

    def Normalized(self) -> Vector3d:
        """A copy of length 1; of zero, zero."""
        return Vector3d(self.x, self.y, self.z).Normalize()

    def Perpendicular(self) -> Vector3d:
        """A vector at right angles to this one: its cross product with the x axis, or with the y axis if that is 0."""
        found = self.Cross((1.0, 0.0, 0.0))
        return found if found.SquaredLength() >= 1e-12 else self.Cross((0.0, 1.0, 0.0))

    @staticmethod
    def Normal(v1: VectorLike, v2: VectorLike, v3: VectorLike) -> Vector3d:
        """The unit normal of the triangle of three points, counter-clockwise seen from its tip."""
        return (Vector3d(v2) - v1).Cross(Vector3d(v3) - v1).Normalize()

    # Component by component ------------------------------------------------------------------------------------------

    def MaxAbs(self) -> float:
        """The largest absolute value of a component."""
        return max(map(abs, self))

    def MinAbs(self) -> float:
        """The least absolute value of a component."""
        return min(map(abs, self))

    def Round(self) -> Vector3d:
        """Round the components to integers, and return it."""
        self.x, self.y, self.z = float(round(self.x)), float(round(self.y)), float(round(self.z))
        return self

    def Rounded(self) -> Vector3d:
        """A copy with rounded components."""
        return Vector3d(self.x, self.y, self.z).Round()

    def Abs(self) -> Vector3d:
        """The absolute values."""
        return Vector3d(abs(self.x), abs(self.y), abs(self.z))

    def Max(self, other: VectorLike | None = None) -> float:
        """The largest component; with a vector, each component is first raised to that one's."""
        if other is not None:
            self.x, self.y, self.z = (max(a, b) for a, b in zip(self, other, strict=True))
        return max(self.x, self.y, self.z)

    def Min(self, other: VectorLike | None = None) -> float:
        """The smallest component; with a vector, each component is first lowered to that one's."""
        if other is not None:
            self.x, self.y, self.z = (min(a, b) for a, b in zip(self, other, strict=True))
        return min(self.x, self.y, self.z)

    def IsFinite(self) -> bool:
        """Whether no component is infinite or NaN."""
        return math.isfinite(self.x) and math.isfinite(self.y) and math.isfinite(self.z)

    def Correct(self) -> None:
        """Set infinite components and NaN to 0."""
        self.x, self.y, self.z = fixnan(self.x), fixnan(self.y), fixnan(self.z)

    GetLength = Length
    GetSquaredLength = SquaredLength
    GetSum = Sum
    GetAbs = Abs
    GetRounded = Rounded
    GetDistToLine = DistToLine
    GetPerpendicular = Perpendicular
    GetNormal = Normal
    GetMax = Max
    GetMin = Min
    SetToMax = Max
    SetToMin = Min


Vector3 = Vector3d
