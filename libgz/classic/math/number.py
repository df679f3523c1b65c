"""Functions on numbers."""

from __future__ import annotations

import math
from typing import TypeVar

from libgz.errors import ParameterError
from libgz.geometry import DTOR, NORMALIZE, RTOD

__all__ = [
    "IGN_DTOR",
    "IGN_NORMALIZE",
    "IGN_PI",
    "IGN_PI_2",
    "IGN_PI_4",
    "IGN_RTOD",
    "NAN_D",
    "clamp",
    "equal",
    "fixnan",
    "isnan",
    "numbers_in",
    "precision",
    "text_of",
]

N = TypeVar("N", int, float)

NAN_D = math.nan
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
