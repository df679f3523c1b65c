"""Reading a `<sensor>`: values with their bounds; errors name file and line."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

from libgz.base.errors import Diagnostic, ParameterError, nearest
from libgz.sdf.element import Element

__all__ = ["UNSET", "choice", "clip", "count", "custom_topic", "first", "known_children", "number", "wrong"]

FARTHEST = 1e6  # [m], of a range without limit
UNSET = ("", "__default__", "__default_topic__")


def first(element: Element | None, name: str) -> Element | None:
    """The first child of that name; None if there is none, or no element."""
    return next(element.named(name), None) if element is not None else None


def known_children(element: Element) -> Collection[str]:
    """The children that the element's SDF version describes."""
    return element.description.children if element.description is not None else ()


def wrong(element: Element, key: str, message: str) -> ParameterError:
    """The error of a value that is not allowed: ``file:line: <key>: message``; `key` is a child of the element."""
    place = first(element, key) or element
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


def clip(element: Element, low: str, high: str) -> tuple[float, float]:
    """Two distances [m], the second beyond the first, and no more than `FARTHEST`: ``inf`` means no limit.

    Raises:
        ParameterError: they are not, or one is negative.
    """
    near, far = number(element, low, 0.0, unit="m"), element.Get(float, high)
    far = FARTHEST if far == math.inf else number(element, high, 0.0, unit="m")
    if not far > near:
        raise wrong(element, high, f"is {far:g} m; it must be beyond <{low}>, {near:g} m")
    return near, far


def count(element: Element, key: str, least: int = 1, most: int | None = None) -> int:
    """A whole number within bounds.

    Raises:
        ParameterError: it is outside of them.
    """
    value = element.Get(int, key)
    if value < least or (most is not None and value > most):
        allowed = f"at least {least}" if most is None or value < least else f"at most {most}"
        raise wrong(element, key, f"is {value}; it must be {allowed}")
    return value


def choice(element: Element, key: str, allowed: Iterable[str]) -> str:
    """One of several words.

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
