"""Values in SDF: parsing, checking and formatting of text."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from typing import Any, Protocol, TypeVar, runtime_checkable

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor, GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector

__all__ = ["check", "exact_pose", "format_value", "parse", "repaired", "starts_with_numbers"]

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
    lengths = _LENGTHS.get(kind)
    try:
        if lengths is None or lengths == (1,):
            _PARSERS[python_type](text)
            return ""
        numbers = list(map(float, text.split()))
    except ValueError:
        return allowed
    fits = not numbers or (len(numbers) in lengths and all(map(math.isfinite, numbers)))
    return "" if fits else allowed


def _is_finite(word: str) -> bool:
    return math.isfinite(float(word))


# Type in the description -> how many numbers its text has.
_LENGTHS = {
    "double": (1,),
    "int": (1,),
    "unsigned int": (1,),
    "vector2d": (2,),
    "vector2i": (2,),
    "vector3": (3,),
    "pose": (6,),
    "color": (3, 4),
}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_NAN = re.compile(r"[+-]?nan\b", re.IGNORECASE)


def repaired(kind: str, text: str, default: str) -> str:
    """The text that Gazebo classic reads in place of one that `check` refuses; empty where it refuses it, too.

    It reads the number that a word begins with, takes 0 for missing numbers and for those from a word on that is none,
    ignores those beyond the last, and takes words other than true and 1 as false. It calculates with a NaN, which is
    replaced by the default here, and so is a list without any number.
    """
    if kind == "bool":
        return "false"
    if kind not in _LENGTHS or not text.strip():
        return ""
    lengths = _LENGTHS[kind]
    found = [_NUMBER.match(word) for word in text.replace(",", " ").split()]
    words = [match[0] if match is not None else "nan" for match in found]
    words = list(itertools.takewhile(_is_finite, words))
    if not words:
        usable = default if lengths != (1,) or (kind == "double" and _NAN.match(text.strip())) else ""
    elif kind in ("int", "unsigned int"):
        usable = str(int(float(words[0]))) if math.isfinite(float(words[0])) else ""
    else:
        words = words[: lengths[-1]]
        usable = " ".join(words + ["0"] * (lengths[0] - len(words)))
    return "" if check(kind, usable) else usable


def starts_with_numbers(text: str) -> bool:
    """Whether each word of a text begins with a number."""
    return all(map(_NUMBER.match, text.replace(",", " ").split()))


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
