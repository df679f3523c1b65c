"""Reading a `<sensor>`: values with their bounds; what is wrong is told with file and line."""

from __future__ import annotations

import math
from collections.abc import Iterable

from libgz.errors import Diagnostic, ParameterError, nearest
from libgz.sdf.element import Element

__all__ = ["choice", "count", "custom_topic", "number", "wrong"]

UNSET = ("", "__default__", "__default_topic__")


def wrong(element: Element, key: str, message: str) -> ParameterError:
    """The error of a value that is not allowed: ``file:line: <key>: message``; `key` is a child of the element."""
    place = next(element.named(key), element)
    return ParameterError(str(Diagnostic(place.file or "<string>", place.line, key, message, "error")))


def number(element: Element, key: str, least: float = -math.inf, most: float = math.inf, unit: str = "") -> float:
    """A number within bounds.

    Raises:
        ParameterError: it is outside of them, or not finite.
    """
    value = element.Get(float, key)
    if not (least <= value <= most and math.isfinite(value)):
        words = [
            f"{word} {bound:g}" for word, bound in (("at least", least), ("at most", most)) if math.isfinite(bound)
        ]
        allowed = " and ".join(words) or "finite"
        raise wrong(element, key, f"is {value:g}{unit and ' ' + unit}; it must be {allowed}{unit and ' ' + unit}")
    return value


def count(element: Element, key: str, least: int = 1) -> int:
    """A whole number with a lower bound.

    Raises:
        ParameterError: it is below.
    """
    value = element.Get(int, key)
    if value < least:
        raise wrong(element, key, f"is {value}; it must be at least {least}")
    return value


def choice(element: Element, key: str, allowed: Iterable[str]) -> str:
    """One of some words.

    Raises:
        ParameterError: it is none of them.
    """
    known = list(allowed)
    value = element.Get(str, key)
    if value not in known:
        raise wrong(element, key, f"is {value!r}; allowed are {', '.join(known)}{nearest(value, known)}")
    return value


def custom_topic(element: Element) -> str:
    """The `<topic>` of an element; an empty string for none and for the default."""
    value = element.Get(str, "topic") if element.HasElement("topic") else ""
    return "" if value in UNSET else value
