"""Patience: the time that a server can spend on waiting for locks of its clients."""

from __future__ import annotations

import time

__all__ = ["Patience"]

SHARE = 0.02  # of the time
MOST = 0.04  # [s] at once


class Patience:
    """An allowance of waiting time, a small share of the time that passes: clients cannot slow the server by more."""

    def __init__(self) -> None:
        self._left = MOST
        self._updated = time.monotonic()

    def left(self, now: float) -> float:
        """How long the server can wait at a monotonic time [s]."""
        self._left = min(MOST, self._left + SHARE * (now - self._updated))
        self._updated = now
        return max(0.0, self._left)

    def spend(self, seconds: float) -> None:
        """Account for a wait [s]."""
        self._left -= seconds
