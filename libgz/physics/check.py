"""Checks of arguments before they reach ODE, whose own assertions would end the process.

- ODE's assertions abort the process. Check arguments in Python first (`libgz/physics/check.py`);
  `tests/ode/assertions.tsv` lists what each declared function asserts, and where that is checked. A body faster than
1e7 m/s, or with a force above 1e12 N, is stopped before the step, one that comes beyond 2e9 m after it. ODE's cells are
  made wider where something lies beyond 1e8 m: it counts them in 32 bits. An assertion while solving
skips the step, one in collision skips the pair of geoms; both are reported once. What ODE had allocated and queued for
  a
skipped step is dropped: its queue is `calls.c`, for ODE's own is the process's, and cannot be emptied.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError
from libgz.base.law import Term, usually
from libgz.ode.types import JOINT_PARAMETERS

__all__ = [
    "FAR",
    "LARGEST",
    "WIDE",
    "are_parallel",
    "finite",
    "finite_tuple",
    "joint_value",
    "known_parameter",
    "not_negative",
    "perpendicular",
    "positive",
    "rotation_tuple",
    "table",
    "unit_axis",
]

# ODE ends the process where inertia overflows. In metres, kilograms and metres per second this is far inside of that,
# and far outside of any robot's world.
LARGEST = 1e9
# It also ends it if a small geom lies beyond 2^28 m, for cells of 1/8 m are counted in 32 bits; `Engine.extend_range`.
FAR = 1e8  # from the origin to a body [m]
WIDE = 1e7  # from a body to its geoms and their corners [m]

# Ranges that ODE can handle; a stop that is never reached, and a motor without limit, are infinite.
_RANGES = {
    "dParamLoStop": (-math.inf, LARGEST),
    "dParamHiStop": (-LARGEST, math.inf),
    "dParamFMax": (-math.inf, math.inf),  # those below zero are ignored
    **dict.fromkeys(("dParamVel", "dParamLoVel", "dParamHiVel", "dParamFudgeFactor"), (-LARGEST, LARGEST)),
    "dParamBounce": (0.0, LARGEST),
    **dict.fromkeys(("dParamERP", "dParamStopERP", "dParamSuspensionERP"), (0.0, LARGEST)),
    **dict.fromkeys(("dParamCFM", "dParamStopCFM", "dParamSuspensionCFM"), (0.0, 1e12)),
}
_JOINT_VALUES = {number: _RANGES[name.rstrip("2")] for number, name in JOINT_PARAMETERS.items()}


def _number(value: float, what: str) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ParameterError(f"{what} is {value!r}; it must be a number") from None


def finite(value: float, what: str) -> float:
    """`value` as a float; a number of a law that is recorded as it is.

    Raises:
        ParameterError: it is no number, NaN or infinite.
    """
    if isinstance(value, Term):
        usually(abs(value) <= sys.float_info.max)
        return value
    number = _number(value, what)
    if not math.isfinite(number):
        raise ParameterError(f"{what} is {number}; it must be finite")
    return number


def positive(value: float, what: str) -> float:
    """`value` as a float.

    Raises:
        ParameterError: it is not finite, not above zero, or above 1e9.
    """
    number = finite(value, what)
    if number <= 0.0:
        raise ParameterError(f"{what} is {number:g}; it must be above zero")
    if number > LARGEST:
        raise ParameterError(f"{what} is {number:g}; it must be at most {LARGEST:g}")
    return number


def not_negative(value: float, what: str) -> float:
    """`value` as a float; infinity is allowed.

    Raises:
        ParameterError: it is no number, NaN or below zero.
    """
    number = _number(value, what)
    if not number >= 0.0:
        raise ParameterError(f"{what} is {number:g}; it must not be negative")
    return number


def finite_tuple(values: Iterable[float], count: int, what: str, largest: float = math.inf) -> tuple[float, ...]:
    """`values` as a tuple of `count` floats.

    Raises:
        ParameterError: there are more or fewer, or one is no number, NaN, infinite, or beyond +-largest.
    """
    try:
        numbers = tuple(map(float, values))
    except (TypeError, ValueError):
        raise ParameterError(f"{what} is {values!r}; it must be {count} finite numbers") from None
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ParameterError(f"{what} is {numbers}; it must be {count} finite numbers")
    if largest < math.inf and max(map(abs, numbers)) > largest:
        raise ParameterError(f"{what} is {numbers}; its numbers must be within +-{largest:g}")
    return numbers


def table(values: ArrayLike, columns: int, what: str) -> NDArray[Any]:
    """`values` as an array of so many columns, a copy.

    Raises:
        ParameterError: they are not numbers in whole rows.
    """
    numbers = np.array(values)
    if numbers.size % columns or numbers.dtype.kind not in "biuf":
        raise ParameterError(f"{what} have shape {numbers.shape}; they must be numbers, {columns} in a row")
    return numbers.reshape(-1, columns)


def rotation_tuple(values: Iterable[float], what: str) -> tuple[float, ...]:
    """`values` as a tuple of four floats that can be scaled to length 1.

    Raises:
        ParameterError: they are zero, not finite, or beyond 1e150 or below 1e-150.
    """
    numbers = finite_tuple(values, 4, what, 1e150)
    if max(map(abs, numbers)) < 1e-150:
        raise ParameterError(f"{what} is {numbers}; a quaternion must not be zero")
    return numbers


def vector_of(first: Iterable[float] | float, rest: tuple[float, ...]) -> Iterable[float]:
    """A vector that was given as one, or as three numbers: the old API had both."""
    return (first, *rest) if isinstance(first, int | float) else first


def unit_axis(values: Iterable[float], what: str) -> tuple[float, ...]:
    """A direction of any length but zero, scaled to 1.

    Raises:
        ParameterError: it is zero or not finite.
    """
    axis = finite_tuple(values, 3, what)
    length = math.sqrt(sum(a * a for a in axis))
    if length < 1e-12:
        raise ParameterError(f"{what} is {axis}; an axis must not be zero")
    if length == math.inf:  # the squares are too large
        return unit_axis([a / max(map(abs, axis)) for a in axis], what)
    return tuple(a / length for a in axis)


def are_parallel(one: Iterable[float], two: Iterable[float]) -> bool:
    """Whether two unit vectors lie along one line."""
    return abs(sum(a * b for a, b in zip(one, two, strict=True))) > 1.0 - 1e-9


def perpendicular(axis: Iterable[float]) -> tuple[float, ...]:
    """Some unit vector at right angles to an axis."""
    x, y, z = axis
    return unit_axis((0.0, z, -y) if abs(x) < 0.9 else (-z, 0.0, x), "axis")


def known_parameter(number: int) -> int:
    """The number of a joint's parameter.

    Raises:
        ParameterError: there is no such parameter.
    """
    if number not in JOINT_PARAMETERS:
        raise ParameterError(f"joint parameter {number!r} is unknown; use dParamVel, dParamFMax and so on")
    return int(number)


def joint_value(parameter: int, value: float) -> float:
    """`value` as a float within the range of a joint's parameter.

    Raises:
        ParameterError: the parameter is unknown, or the value is out of its range.
    """
    least, most = _JOINT_VALUES.get(parameter) or _JOINT_VALUES[known_parameter(parameter)]
    number = float(value)
    if least <= number <= most:
        return number
    raise ParameterError(f"{JOINT_PARAMETERS[parameter]} is {number:g}; it must be within {least:g} and {most:g}")
