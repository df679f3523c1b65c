"""Accessors of an object, found by their names: `SetX` with `X` or `GetX`, and `X(value)` that sets and gets.

    @pytest.mark.parametrize("pair", accessor_pairs(Battery("cell", 12.0)), ids=str)
    def test_what_is_set_is_read(pair):
        pair.check()

`check` sets two different values, and reads each back. Values are chosen by the annotation of the setter's last
parameter; those before it (a consumer, an axis) are given to the getter, too.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from libgz.classic.common import Time
from libgz.classic.math import Color, Matrix3d, Pose3d, Quaterniond, Vector2d, Vector3d

__all__ = ["SAMPLES", "Pair", "accessor_pairs", "same"]

# Two values for each annotation of a setter's parameter; of a union, the first part that is known counts.
SAMPLES: dict[str, tuple[Any, Any]] = {
    "float": (0.25, 0.75),
    "SupportsFloat": (0.25, 0.75),
    "int": (2, 3),
    "bool": (True, False),
    "str": ("one", "two"),
    "Time": (Time(1, 500), Time(2, 700)),
    "VectorLike": (Vector3d(0.25, 0.5, 0.75), Vector3d(1.0, 2.0, 3.0)),
    "GzVector": (Vector3d(0.25, 0.5, 0.75), Vector3d(1.0, 2.0, 3.0)),
    "Vector3d": (Vector3d(0.25, 0.5, 0.75), Vector3d(1.0, 2.0, 3.0)),
    "Vector2d": (Vector2d(0.25, 0.5), Vector2d(1.0, 2.0)),
    "QuaternLike": (Quaterniond(0.1, 0.2, 0.3), Quaterniond(0.5, 0.5, 0.5, 0.5)),
    "GzQuatern": (Quaterniond(0.1, 0.2, 0.3), Quaterniond(0.5, 0.5, 0.5, 0.5)),
    "Quaterniond": (Quaterniond(0.1, 0.2, 0.3), Quaterniond(0.5, 0.5, 0.5, 0.5)),
    "GzPose": (Pose3d(1.0, 2.0, 3.0, 0.1, 0.2, 0.3), Pose3d(4.0, 5.0, 6.0, 0.0, 0.0, 0.5)),
    "Pose3d": (Pose3d(1.0, 2.0, 3.0, 0.1, 0.2, 0.3), Pose3d(4.0, 5.0, 6.0, 0.0, 0.0, 0.5)),
    "GzHomo": (Matrix3d(2.0, 0.1, 0.2, 0.1, 3.0, 0.3, 0.2, 0.3, 4.0), Matrix3d.Identity),
    "GzColor": (Color(0.25, 0.5, 0.75, 1.0), Color(1.0, 0.0, 0.5, 0.25)),
    "Color": (Color(0.25, 0.5, 0.75, 1.0), Color(1.0, 0.0, 0.5, 0.25)),
}


def same(found: Any, wanted: Any, tolerance: float = 1e-9) -> bool:
    """Whether two values are equal; numbers, also those in sequences and poses, within a tolerance."""
    if hasattr(found, "pos") and hasattr(wanted, "pos"):
        return same(found.pos, wanted.pos, tolerance) and same(found.rot, wanted.rot, tolerance)
    if isinstance(found, Real) or isinstance(wanted, Real):
        return math.isclose(float(found), float(wanted), rel_tol=tolerance, abs_tol=tolerance)
    if isinstance(found, Iterable) and isinstance(wanted, Iterable) and not isinstance(found, str):
        ours, others = list(found), list(wanted)
        return len(ours) == len(others) and all(same(a, b, tolerance) for a, b in zip(ours, others, strict=True))
    return bool(found == wanted)


@dataclass(frozen=True)
class Pair:
    """A setter and a getter of an object.

    Attributes:
        holder: the object.
        setter, getter: names of its methods; the same one where `X(value)` sets and `X()` gets.
        before: arguments of both, before the value.
        values: what is set, one after the other.
    """

    holder: Any
    setter: str
    getter: str
    before: tuple[Any, ...]
    values: tuple[Any, ...]

    def __str__(self) -> str:
        return f"{type(self.holder).__name__}.{self.setter}-{self.getter}"

    def check(self) -> None:
        """Set each value and read it back."""
        for value in self.values:
            getattr(self.holder, self.setter)(*self.before, value)
            found = getattr(self.holder, self.getter)(*self.before)
            assert same(found, value), f"{self}: set {value!r}, read {found!r}"


def accessor_pairs(
    holder: Any,
    *,
    exceptions: Mapping[str, str] | None = None,
    values: Mapping[str, Sequence[Any]] | None = None,
    before: Mapping[str, tuple[Any, ...]] | None = None,
) -> list[Pair]:
    """All pairs of accessors that an object has.

    Args:
        holder: the object.
        exceptions: names of setters that are not checked, each with the reason. A name that is no setter is an error,
            so that the list holds nothing that is out of date.
        values: values for setters, by name, where those for the annotation do not fit.
        before: arguments before the value, by the setter's name; 0 for each that is not given.

    Raises:
        LookupError: an exception is no setter; or there is no value for a setter.
    """
    exceptions, values, before = dict(exceptions or {}), values or {}, before or {}
    pairs = []
    for setter, getters in _setters(holder):
        if exceptions.pop(setter, None) is not None:
            continue
        *first, last = _parameters(getattr(holder, setter))
        chosen = tuple(values[setter]) if setter in values else _samples(last.annotation)
        if chosen is None:
            raise LookupError(f"{type(holder).__name__}.{setter}: there is no value for {last.annotation!r}")
        arguments = before.get(setter, (0,) * len(first))
        pairs += [Pair(holder, setter, getter, arguments, chosen) for getter in getters]
    if exceptions:
        raise LookupError(f"{type(holder).__name__} has no such setters: {', '.join(exceptions)}")
    return pairs


def _setters(holder: Any) -> Iterable[tuple[str, list[str]]]:
    """Names of setters, each with those of its getters."""
    for name in dir(type(holder)):
        method = inspect.getattr_static(type(holder), name)
        if name.startswith("_") or not inspect.isfunction(method):
            continue
        if name.startswith("Set") and _parameters(getattr(holder, name)):
            word = name.removeprefix("Set")
            getters = [getter for getter in (word, f"Get{word}") if _is_method(holder, getter)]
            if getters:
                yield name, getters
        elif name == method.__name__ and _sets_and_gets(method):
            yield name, [name]


def _is_method(holder: Any, name: str) -> bool:
    return bool(name) and inspect.isfunction(inspect.getattr_static(type(holder), name, None))


def _sets_and_gets(method: Callable[..., Any]) -> bool:
    """Whether it is an accessor such as `X(self, value: float | None = None) -> float`."""
    parameters = _parameters(method)[1:]
    return len(parameters) == 1 and parameters[0].default is None


def _parameters(method: Callable[..., Any]) -> list[inspect.Parameter]:
    """The parameters that a setter is called with: all required ones, or the first."""
    parameters = list(inspect.signature(method).parameters.values())
    required = [p for p in parameters if p.default is p.empty and p.kind is not p.VAR_POSITIONAL]
    return required or parameters[:1] if inspect.ismethod(method) else parameters


def _samples(annotation: str) -> tuple[Any, ...] | None:
    return next((SAMPLES[word] for word in str(annotation).split(" | ") if word in SAMPLES), None)
