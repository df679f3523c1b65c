"""Values in SDF: parsing, checking and formatting of text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, Protocol, TypeVar, runtime_checkable

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor, GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector

__all__ = ["check", "exact_pose", "format_value", "parse", "repaired"]

T = TypeVar("T")


def _numbers(text: str, count: int, least: int) -> list[float]:
    """`least` to `count` numbers, padded with zeros."""
    values = [float(token) for token in text.split()]
    if not least <= len(values) <= count or any(map(math.isnan, values)):
        raise ValueError(text)
    return values + [0.0] * (count - len(values))


def _bool(text: str) -> bool:
    word = text.strip().lower()
    if word not in ("true", "1", "false", "0", ""):
        raise ValueError(text)
    return word in ("true", "1")


def _int(text: str) -> int:
    return int(text.strip() or "0", 0)


def _float(text: str) -> float:
    value = float(text.strip() or 0.0)
    if math.isnan(value):
        raise ValueError(text)
    return value


def _vector(text: str) -> GzVector:
    return GzVector(*_numbers(text, 3, 0 if not text.strip() else 2))


def _pose(text: str) -> GzPose:
    """x y z [m], roll pitch yaw [rad]: qz(yaw) qy(pitch) qx(roll), the same convention as in legacy worlds."""
    x, y, z, roll, pitch, yaw = numbers = _numbers(text, 6, 0 if not text.strip() else 6)
    if not all(map(math.isfinite, numbers)):
        raise ValueError(text)
    return GzPose(GzVector(x, y, z), GzQuaternFromEuler(roll, pitch, yaw))


def _color(text: str) -> GzColor:
    values = [float(token) for token in text.split()] or [0.0, 0.0, 0.0]
    if len(values) not in (3, 4):
        raise ValueError(text)
    return GzColor(*values)


_PARSERS: dict[type, Callable[[str], Any]] = {
    str: str,
    bool: _bool,
    int: _int,
    float: _float,
    GzVector: _vector,
    GzPose: _pose,
    GzColor: _color,
}
# Type in the description -> Python type, and what is allowed in words.
_KINDS: dict[str, tuple[type, str]] = {
    "string": (str, "text"),
    "bool": (bool, "true, false, 1 or 0"),
    "int": (int, "a whole number"),
    "unsigned int": (int, "a whole number"),
    "double": (float, "a number"),
    "vector2d": (GzVector, "2 numbers"),
    "vector2i": (GzVector, "2 numbers"),
    "vector3": (GzVector, "3 numbers"),
    "pose": (GzPose, "6 finite numbers: x y z [m] roll pitch yaw [rad]"),
    "color": (GzColor, "3 or 4 numbers"),
    "time": (str, "seconds and nanoseconds"),
}


@runtime_checkable
class FromSdf(Protocol):
    """A class whose objects can be read from the text of an element."""

    @classmethod
    def from_sdf(cls, text: str) -> Any:
        """The value of a text.

        Raises:
            ValueError: the text is no such value.
        """


def parse(kind: type[T], text: str) -> T:
    """The value of `text` as a `kind`.

    Args:
        kind: str, bool, int, float, GzVector, GzPose, GzColor, or a class with a class method `from_sdf(text)`.
        text: from the file.

    Raises:
        ParameterError: the text is no such value, or the kind is unknown.
    """
    reader: Callable[[str], T] | None = _PARSERS.get(kind)
    if reader is None and isinstance(kind, type) and issubclass(kind, FromSdf):
        reader = kind.from_sdf
    if reader is None:
        names = ", ".join(k.__name__ for k in _PARSERS)
        raise ParameterError(f"{kind!r} is not a type of SDF values; use {names}, or a class with from_sdf(text)")
    try:
        return reader(text)
    except ValueError:
        raise ParameterError(f"{text.strip()!r} is not a {kind.__name__}") from None


def check(kind: str, text: str) -> str:
    """What is allowed, if `text` is not of the described kind; an empty string if it is."""
    if kind not in _KINDS:
        return ""
    python_type, allowed = _KINDS[kind]
    try:
        parse(python_type, text)
    except ParameterError:
        return allowed
    return ""


# Type in the description -> how many numbers its text has, at most.
_LENGTHS = {"double": 1, "int": 1, "unsigned int": 1, "vector2d": 2, "vector2i": 2, "vector3": 3, "pose": 6, "color": 4}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def repaired(kind: str, text: str) -> str:
    """The text that Gazebo classic reads in place of one that `check` refuses; empty if there is none.

    It reads the number that a word begins with, takes missing numbers as 0, and ignores those beyond the last.
    """
    found = [_NUMBER.match(word) for word in text.replace(",", " ").split()]
    words = [match[0] for match in found if match is not None]
    if kind not in _LENGTHS or not found or len(words) < len(found):
        return ""
    words = words[: _LENGTHS[kind]]
    if kind in ("int", "unsigned int"):
        return str(int(float(words[0]))) if math.isfinite(float(words[0])) else ""
    least = 3 if kind == "color" else _LENGTHS[kind]
    usable = " ".join(words + ["0"] * (least - len(words)))
    return "" if check(kind, usable) else usable


def exact_pose(pose: GzPose) -> str:
    """A pose as text, to the last bit of its numbers."""
    return " ".join(repr(float(v) + 0.0) for v in (*pose.pos, *GzQuaternToEuler(pose.rot)))


def format_value(value: Any) -> str:
    """A value as text of a file."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, GzPose):
        return " ".join(f"{v + 0.0:.12g}" for v in (*value.pos, *GzQuaternToEuler(value.rot)))
    if isinstance(value, GzVector | GzColor):
        return " ".join(f"{v + 0.0:.12g}" for v in value)
    return repr(value) if isinstance(value, float) else str(value)
