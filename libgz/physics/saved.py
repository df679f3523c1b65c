"""The attributes that states save: those that a class and its bases list as SAVED."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.physics.check import finite_tuple, rotation_tuple

__all__ = ["saved_names", "saved_pose", "saved_values"]

_type: Any = type  # mypy takes a class for no key of a cache


@functools.cache
def _names(kind: Any) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for base in reversed(kind.__mro__) for name in vars(base).get("SAVED", ())))


@functools.cache
def _getter(kind: Any) -> Callable[[Any], tuple[Any, ...]]:
    names = _names(kind)
    get = attrgetter(*names)
    return get if len(names) > 1 else lambda thing: (get(thing),)


def saved_names(thing: Any) -> tuple[str, ...]:
    """The names of an object's saved attributes."""
    return _names(_type(thing))


def saved_values(thing: Any) -> tuple[Any, ...]:
    """Their values, in the same order."""
    return _getter(_type(thing))(thing)


def saved_pose(numbers: Sequence[Any]) -> GzPose:
    """The pose of seven numbers in a state, which is not trusted.

    Raises:
        ParameterError: they are no pose.
    """
    return GzPose(
        GzVector(*finite_tuple(numbers[:3], 3, "a saved position")),
        GzQuatern(*rotation_tuple(numbers[3:], "a saved rotation")),
    )
