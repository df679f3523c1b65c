"""Class attributes like `Vector3d.Zero`, which nobody can spoil."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

__all__ = ["Constant"]

T = TypeVar("T")


class Constant(Generic[T]):
    """A class attribute that is made anew each time it is read.

    The types are mutable, so one shared `Vector3d.Zero` would not stay zero for long.
    """

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make

    def __get__(self, instance: object, owner: type | None = None) -> T:
        return self._make()
