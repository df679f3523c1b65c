"""Tally: how often clients did something wrong, by cause, and when to log it."""

from __future__ import annotations

import math
from collections.abc import Hashable

__all__ = ["Tally"]


class Tally:
    """Counts by cause. Each cause is logged at its first time, at the hundredth, and then at every tenfold count.

    So no client can fill the log.

    Args:
        most: how many causes are counted apart, where clients can make up new ones; further ones count as one.
    """

    def __init__(self, most: float = math.inf) -> None:
        self._most = most
        self._counts: dict[Hashable, list[int]] = {}  # cause -> count, count at which it is logged next

    def due(self, cause: Hashable, times: int = 1) -> bool:
        """Count `cause`; whether to log it now."""
        entry = self._counts.get(cause)
        if entry is None:
            entry = self._counts.setdefault(self._key(cause), [0, 1])
        entry[0] += times
        if entry[0] < entry[1]:
            return False
        entry[1] = 100
        while entry[1] <= entry[0]:
            entry[1] *= 10
        return True

    def unlogged(self, cause: Hashable) -> int:
        """How many more times of `cause` are counted without being logged."""
        count, next_ = self._counts.get(self._key(cause), (0, 1))
        return next_ - count - 1

    def _key(self, cause: Hashable) -> Hashable:
        """The cause that counts: itself, or that of all further ones."""
        return cause if cause in self._counts or len(self._counts) < self._most else None

    def times(self, cause: Hashable) -> str:
        """The end of a message: how often, from the second time on."""
        count = self._counts.get(self._key(cause), (0,))[0]
        return f" ({count} times so far)" if count > 1 else ""
