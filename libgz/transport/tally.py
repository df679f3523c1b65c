"""Tally: how often clients did something wrong, by cause, and when to log it."""

from __future__ import annotations

from collections.abc import Hashable

__all__ = ["Tally"]


class Tally:
    """Counts by cause. Each cause is logged at its first time and then at every tenfold count.

    So no client can fill the log.
    """

    def __init__(self) -> None:
        self._counts: dict[Hashable, int] = {}
        self._next: dict[Hashable, int] = {}

    def due(self, cause: Hashable, times: int = 1) -> bool:
        """Count `cause`; whether to log it now."""
        count = self._counts[cause] = self._counts.get(cause, 0) + times
        limit = self._next.get(cause, 1)
        if count < limit:
            return False
        while limit <= count:
            limit *= 10
        self._next[cause] = limit
        return True

    def times(self, cause: Hashable) -> str:
        """The end of a message: how often, from the second time on."""
        count = self._counts.get(cause, 0)
        return f" ({count} times so far)" if count > 1 else ""
