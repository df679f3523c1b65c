"""Distribution: random numbers as a table of a file or of Python describes them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from libgz.base.errors import ParameterError, nearest

__all__ = ["KINDS", "Distribution"]


LARGEST = 1e18  # of a number; whole ones have 64 bits


@dataclass(frozen=True)
class _Kind:
    count: int | None  # how many numbers describe it; None: any from 1
    sample: Callable[[np.random.Generator, Sequence[Any]], Any]
    help: str


def _loguniform(random: np.random.Generator, values: Sequence[float]) -> float:
    low, high = math.log(values[0]), math.log(values[1])
    return float(math.exp(random.uniform(low, high)))


KINDS: dict[str, _Kind] = {
    "uniform": _Kind(2, lambda random, v: float(random.uniform(v[0], v[1])), "[low, high]"),
    "loguniform": _Kind(2, _loguniform, "[low, high], both above 0: the logarithm is uniform"),
    "normal": _Kind(2, lambda random, v: float(random.normal(v[0], v[1])), "[mean, standard deviation]"),
    "integers": _Kind(2, lambda random, v: int(random.integers(int(v[0]), int(v[1]) + 1)), "[least, most]"),
    "choice": _Kind(None, lambda random, v: v[int(random.integers(len(v)))], "[one, another, ...]"),
}


class Distribution:
    """One of `KINDS` with its numbers, such as ``Distribution("uniform", [0.5, 1.5])``.

    Raises:
        ParameterError: there is no such kind, or the numbers do not fit it.
    """

    def __init__(self, kind: str, values: Sequence[Any]) -> None:
        if kind not in KINDS:
            raise ParameterError(
                f"there is no distribution {kind!r}; there are {', '.join(KINDS)}{nearest(kind, KINDS)}"
            )
        self.kind, self.values = kind, list(values)
        wanted = KINDS[kind].count
        if not self.values or wanted not in (None, len(self.values)):
            raise ParameterError(f"{kind} is {list(values)}; it takes {KINDS[kind].help}")
        if kind != "choice":
            self._check_numbers()

    def _check_numbers(self) -> None:
        numbers = [isinstance(value, int | float) and abs(value) <= LARGEST for value in self.values]
        first, second = self.values
        ordered = all(numbers) and (second >= 0.0 if self.kind == "normal" else first <= second)
        whole = self.kind != "integers" or all(float(value).is_integer() for value in self.values)
        if not ordered or not whole or (self.kind == "loguniform" and first <= 0.0):
            raise ParameterError(f"{self.kind} is {self.values}; it takes {KINDS[self.kind].help}, within ±{LARGEST:g}")

    @classmethod
    def of(cls, given: Any, what: str) -> Distribution:
        """The distribution that a value describes.

        Args:
            given: a Distribution; a table ``{"uniform": [0.5, 1.5]}``; a tuple ``("uniform", 0.5, 1.5)``; or a list,
                one of whose elements is chosen.
            what: its name in messages.

        Raises:
            ParameterError: it describes none.
        """
        try:
            if isinstance(given, cls):
                return given
            if isinstance(given, Mapping) and len(given) == 1:
                ((kind, values),) = given.items()
                return cls(
                    str(kind), values if isinstance(values, Sequence) and not isinstance(values, str) else [values]
                )
            if isinstance(given, tuple) and given and isinstance(given[0], str):
                return cls(given[0], given[1:])
            if isinstance(given, list):
                return cls("choice", given)
        except ParameterError as error:
            raise ParameterError(f"{what}: {error}") from None
        forms = ", ".join(f"{kind} = {about.help}" for kind, about in KINDS.items())
        raise ParameterError(f"{what} is {given!r}; a distribution is a table of one kind: {forms}")

    def sample(self, random: np.random.Generator) -> Any:
        """A random value."""
        return KINDS[self.kind].sample(random, self.values)

    def __repr__(self) -> str:
        return f"Distribution({self.kind!r}, {self.values!r})"
