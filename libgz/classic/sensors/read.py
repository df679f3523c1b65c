"""Reading a `<sensor>`: values with their bounds; others are substituted, with a warning that has the line."""

from __future__ import annotations

import logging
import math
from collections.abc import Collection, Iterable

from libgz.base.errors import Diagnostic, ParameterError, nearest
from libgz.sdf.element import Element

__all__ = [
    "UNSET",
    "choice",
    "clip",
    "count",
    "custom_topic",
    "first",
    "known_children",
    "number",
    "substituted",
    "wrong",
]

log = logging.getLogger("libgz.classic")

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


def substituted(element: Element, key: str, message: str) -> None:
    """Report a value that is not allowed, and what is used instead, as a warning: ``file:line: <key>: message``."""
    log.warning("%s", wrong(element, key, message))


def number(element: Element, key: str, least: float = -math.inf, most: float = math.inf, unit: str = "") -> float:
    """A finite number within bounds; one beyond them is substituted by the nearest bound, with a warning."""
    value = element.Get(float, key)
    if least <= value <= most and math.isfinite(value):
        return value
    usable = min(max(value, least), most)
    if not math.isfinite(usable):
        usable = float(_default(element, key) or 0.0)
    words = [f"{word} {bound:g}" for word, bound in (("at least", least), ("at most", most)) if math.isfinite(bound)]
    allowed, unit = " and ".join(words) or "finite", unit and f" {unit}"
    substituted(element, key, f"is {value:g}{unit}; it must be {allowed}{unit}: {usable:g} is used")
    return usable


def _default(element: Element, key: str) -> str:
    """The default of a child."""
    known = element.description.children.get(key) if element.description is not None else None
    return known.default if known is not None else ""


def clip(element: Element, low: str, high: str, nearest_low: float = 0.0) -> tuple[float, float]:
    """Two distances [m], the second beyond the first, and no more than `FARTHEST`: ``inf`` means no limit.

    What is not so is substituted, with a warning; the first one is at least `nearest_low`.
    """
    near, far = max(number(element, low, 0.0, FARTHEST / 2.0, unit="m"), nearest_low), element.Get(float, high)
    far = min(far, FARTHEST) if far > 0.0 else number(element, high, 0.0, unit="m")
    if not far > near:
        usable = (nearest_low, far) if far > nearest_low else (near, FARTHEST)
        must = f"is {far:g} m; it must be beyond <{low}>, {near:g} m"
        substituted(element, high, f"{must}: {usable[0]:g} m to {usable[1]:g} m are used")
        return usable
    return near, far


def count(element: Element, key: str, least: int = 1, most: int | None = None) -> int:
    """A whole number of at least so much; a smaller one is substituted, with a warning.

    Raises:
        ParameterError: there are more than libgz holds.
    """
    value = element.Get(int, key)
    if most is not None and value > most:
        raise wrong(element, key, f"is {value}; it must be at most {most}")
    if value < least:
        substituted(element, key, f"is {value}; it must be at least {least}: {least} is used")
    return max(value, least)


def choice(element: Element, key: str, allowed: Iterable[str], otherwise: str) -> str:
    """One of several words; another one is substituted by `otherwise`, with a warning."""
    known = list(allowed)
    value = element.Get(str, key)
    if value in known:
        return value
    words = f"is {value!r}; allowed are {', '.join(known)}{nearest(value, known)}"
    substituted(element, key, f"{words}: {otherwise!r} is used")
    return otherwise


def custom_topic(element: Element) -> str:
    """The `<topic>` of an element; an empty string for none and for the default."""
    value = element.Get(str, "topic") if element.HasElement("topic") else ""
    return "" if value in UNSET else value
