"""Patience: the time that a server can spend on waiting for locks of its clients."""

from __future__ import annotations

import time

from libgz.base.credit import Credit

__all__ = ["Patience"]

SHARE = 0.02  # of the time that the server works
LEAST_WORK = 0.2  # of all time: a server that keeps real time sleeps most of it, and can wait then
UPDATE_PERIOD = 0.001  # [s]
MOST = 0.02  # [s] at once


class Patience:
    """An allowance of waiting time, a small share of the processor time: clients cannot slow the server by more.

    It is not a share of all time: other processes may take most of that.
    """

    def __init__(self) -> None:
        self._credit = Credit(SHARE, MOST)
        self._updated, self._used = time.monotonic(), time.process_time()

    def left(self, now: float) -> float:
        """How long the server can wait at a monotonic time [s]."""
        passed = now - self._updated
        if passed >= UPDATE_PERIOD:
            used = time.process_time()
            self._credit.earn(max(used - self._used, LEAST_WORK * passed))
            self._updated, self._used = now, used
        return max(0.0, self._credit.left)

    def spend(self, seconds: float) -> None:
        """Account for a wait [s]."""
        self._credit.spend(seconds)
