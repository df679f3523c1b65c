"""Class attributes like `Vector3d.Zero` that cannot be modified."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

__all__ = ["Constant"]

T = TypeVar("T")


class Constant(Generic[T]):
    """A class attribute that returns a new object at each access, for the types are mutable."""

    def __init__(self, make: Callable[[], T]) -> None:
        self._make = make

    def __get__(self, instance: object, owner: type | None = None) -> T:
        return self._make()
