"""Quota: how much of what is large the objects of a world may have together, so that no file fills the memory."""

from __future__ import annotations

import functools
import weakref
from typing import Any

from libgz.base.errors import ParameterError

__all__ = ["Quota"]


class Quota:
    """An amount that objects share, such as the rays of all lasers of a world.

    An object that is closed or collected has nothing of it any more.

    Args:
        what: is shared, in the plural.
        most: that all objects may have together; SECURITY.md publishes it.

    Attributes:
        used: what they have now.
    """

    def __init__(self, what: str, most: int) -> None:
        self.what, self.most, self.used = what, most, 0
        self._owners: dict[int, tuple[weakref.ref[Any], int]] = {}

    def set(self, owner: object, amount: int) -> None:
        """Say how much an object has from now on.

        Raises:
            ParameterError: all together would have too much; the object has what it had.
        """
        key = id(owner)
        before = self._owners[key][1] if key in self._owners else 0
        if amount > before and self.used - before + amount > self.most:
            raise ParameterError(
                f"with {amount} more {self.what} the world would have {self.used - before + amount}; "
                f"at most {self.most} are allowed together"
            )
        self.used += amount - before
        if amount:
            self._owners[key] = weakref.ref(owner, functools.partial(self._forget, key)), amount
        else:
            self._owners.pop(key, None)

    def _forget(self, key: int, owner: weakref.ref[Any]) -> None:
        if self._owners.get(key, (None, 0))[0] is owner:
            self.used -= self._owners.pop(key)[1]
