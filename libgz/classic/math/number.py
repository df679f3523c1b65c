"""Functions on numbers."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence
from typing import TypeVar

from libgz.base.errors import ParameterError
from libgz.base.geometry import DTOR, NORMALIZE, RTOD

__all__ = [
    "IGN_BOX_VOLUME",
    "IGN_CYLINDER_VOLUME",
    "IGN_DTOR",
    "IGN_NORMALIZE",
    "IGN_PI",
    "IGN_PI_2",
    "IGN_PI_4",
    "IGN_RTOD",
    "IGN_SPHERE_VOLUME",
    "IGN_SQRT2",
    "INF_D",
    "INF_F",
    "INF_I32",
    "MAX_D",
    "MAX_I32",
    "MAX_UI32",
    "MIN_D",
    "MIN_I32",
    "NAN_D",
    "NAN_F",
    "clamp",
    "equal",
    "fixnan",
    "greaterOrNearEqual",
    "isEven",
    "isOdd",
    "isPowerOfTwo",
    "isnan",
    "lessOrNearEqual",
    "mean",
    "numbers_in",
    "parseFloat",
    "parseInt",
    "precision",
    "roundUpMultiple",
    "roundUpPowerOfTwo",
    "sgn",
    "signum",
    "text_of",
    "variance",
]

N = TypeVar("N", int, float)

NAN_D = NAN_F = math.nan
INF_D = INF_F = math.inf
MAX_D, MIN_D = sys.float_info.max, sys.float_info.min
MAX_I32, MIN_I32, MAX_UI32, INF_I32 = 2**31 - 1, -(2**31), 2**32 - 1, 2**31 - 1
IGN_SQRT2 = math.sqrt(2.0)
IGN_PI = math.pi
IGN_PI_2 = math.pi / 2.0
IGN_PI_4 = math.pi / 4.0
IGN_DTOR = DTOR
IGN_RTOD = RTOD
IGN_NORMALIZE = NORMALIZE


def clamp(value: N, low: N, high: N) -> N:
    """`value`, but not below `low` and not above `high`."""
    return max(min(value, high), low)


def equal(a: float, b: float, epsilon: float = 1e-6) -> bool:
    """Whether two numbers differ by no more than `epsilon`."""
    return abs(a - b) <= epsilon


def isnan(value: float) -> bool:
    """Whether a number is NaN."""
    return math.isnan(value)


def fixnan(value: float) -> float:
    """The number, or 0 for NaN and the infinities."""
    return value if math.isfinite(value) else 0.0


def precision(value: float, digits: int) -> float:
    """The number rounded to `digits` decimals."""
    return round(value, digits)


def IGN_SPHERE_VOLUME(radius: float) -> float:
    """The volume of a sphere [m^3]."""
    return 4.0 / 3.0 * math.pi * radius**3


def IGN_CYLINDER_VOLUME(radius: float, length: float) -> float:
    """The volume of a cylinder [m^3]."""
    return math.pi * radius**2 * length


def IGN_BOX_VOLUME(x: float, y: float, z: float) -> float:
    """The volume of a box [m^3]."""
    return x * y * z


def lessOrNearEqual(a: float, b: float, epsilon: float = 1e-6) -> bool:
    """Whether a is not above b by more than `epsilon`."""
    return a < b + epsilon


def greaterOrNearEqual(a: float, b: float, epsilon: float = 1e-6) -> bool:
    """Whether a is not below b by more than `epsilon`."""
    return a > b - epsilon


def isEven(value: int) -> bool:
    """Whether a number is even."""
    return value % 2 == 0


def isOdd(value: int) -> bool:
    """Whether a number is odd."""
    return value % 2 != 0


def signum(value: float) -> int:
    """-1, 0 or 1."""
    return (value > 0) - (value < 0)


sgn = signum


def mean(values: Sequence[float]) -> float:
    """The mean; 0 for none, as in Gazebo."""
    return math.fsum(values) / len(values) if len(values) else 0.0


def variance(values: Sequence[float]) -> float:
    """The mean of the squares of the distances from the mean; 0 for none."""
    centre = mean(values)
    return mean([(value - centre) ** 2 for value in values])


def isPowerOfTwo(value: int) -> bool:
    """Whether a number is a power of two."""
    return value > 0 and value & (value - 1) == 0


def roundUpPowerOfTwo(value: int) -> int:
    """The least power of two that is not below a number; 1 for 0."""
    return 1 << max(0, value - 1).bit_length()


def roundUpMultiple(value: int, multiple: int) -> int:
    """The least multiple that is not below a number; the number itself for a multiple of 0."""
    return value if multiple == 0 else -(-value // abs(multiple)) * abs(multiple)


def parseInt(text: str) -> int:
    """A whole number at the start of a text; 0 without one, as C's `atoi`."""
    found = re.match(r"\s*[+-]?\d+", text)
    return int(found.group()) if found is not None else 0


def parseFloat(text: str) -> float:
    """A number at the start of a text; NaN without one."""
    found = re.match(r"\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", text)
    return float(found.group()) if found is not None else math.nan


def text_of(*values: float) -> str:
    """Format numbers for display: at most six decimals, separated by spaces, without minus zero."""
    return " ".join(f"{round(value, 6) + 0.0:.15g}" for value in values)


def numbers_in(text: str, *counts: int) -> list[float]:
    """Read the numbers in a text of a file; an empty text means zeros, as many as the first count.

    Raises:
        ParameterError: the text has a word that is not a number, or none of the allowed counts.
    """
    words = text.split() or ["0"] * counts[0]
    allowed = " or ".join(map(str, counts))
    try:
        values = [float(word) for word in words]
    except ValueError:
        raise ParameterError(f"{text.strip()!r} is not {allowed} numbers") from None
    if len(values) not in counts or any(map(math.isnan, values)):
        raise ParameterError(f"{text.strip()!r} is not {allowed} numbers")
    return values
