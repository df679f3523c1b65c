"""Checks of arguments before they reach ODE, whose own assertions would end the process."""

from __future__ import annotations

import math
from collections.abc import Iterable

from libgz.errors import ParameterError

__all__ = ["LARGEST", "finite", "finite_tuple", "not_negative", "positive", "rotation_tuple", "unit_axis"]

# ODE ends the process where bounding boxes leave the whole numbers that a double holds, or inertia overflows. In
# metres, kilograms and metres per second this is far inside of that, and far outside of any robot's world.
LARGEST = 1e9


def finite(value: float, what: str) -> float:
    """`value` as a float.

    Raises:
        ParameterError: it is NaN or infinite.
    """
    number = float(value)
    if not math.isfinite(number):
        raise ParameterError(f"{what} is {number}; it must be finite")
    return number


def positive(value: float, what: str) -> float:
    """`value` as a float.

    Raises:
        ParameterError: it is not finite, not above zero, or absurdly large.
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
        ParameterError: it is NaN or below zero.
    """
    number = float(value)
    if not number >= 0.0:
        raise ParameterError(f"{what} is {number:g}; it must not be negative")
    return number


def finite_tuple(values: Iterable[float], count: int, what: str, largest: float = math.inf) -> tuple[float, ...]:
    """`values` as a tuple of `count` floats.

    Raises:
        ParameterError: there are more or fewer, or one is NaN, infinite, or beyond +-largest.
    """
    numbers = tuple(map(float, values))
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise ParameterError(f"{what} is {numbers}; it must be {count} finite numbers")
    if largest < math.inf and max(map(abs, numbers)) > largest:
        raise ParameterError(f"{what} is {numbers}; its numbers must be within +-{largest:g}")
    return numbers


def rotation_tuple(values: Iterable[float], what: str) -> tuple[float, ...]:
    """`values` as a tuple of four floats that can be scaled to length 1.

    Raises:
        ParameterError: they are zero, not finite, or absurdly large or small.
    """
    numbers = finite_tuple(values, 4, what, 1e150)
    if max(map(abs, numbers)) < 1e-150:
        raise ParameterError(f"{what} is {numbers}; a quaternion must not be zero")
    return numbers


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
