"""Schedule: when a sensor measures."""

from __future__ import annotations

import ctypes
from typing import Any

from libgz.base.law import largest, law, where

__all__ = ["Schedule"]

TOLERANCE = 1e-9  # [s] sim times are sums of steps, and may miss a due time by less than this


class Schedule(ctypes.Structure):
    """Times of a sensor, as laws use them.

    Attributes:
        period: between two measurements [s]; 0: one in each iteration.
        updated, measured: sim times of the last update and measurement [s].
        delay: how much later than it was due the last update was [s]; the next one comes earlier by that.
        due: earliest sim time of the next measurement [s].
    """

    STATE = ("period", "updated", "measured", "delay", "due")

    _fields_ = [(name, ctypes.c_double) for name in STATE]

    period: float
    updated: float
    measured: float
    delay: float
    due: float

    def set_period(self, period: float) -> None:
        """Set the time between two measurements [s]."""
        self.period = period
        self._wait()

    @law
    def settle(self, now: Any) -> None:
        """Note that an update is over.

        Late by more than a period: it was idle, or steps are longer. There is nothing to catch up with.
        """
        late = largest(0.0, now - self.updated + self.delay - self.period)
        self.delay = where((late > TOLERANCE) & (late < self.period), late, 0.0)
        self.updated = now
        self._wait()

    @law
    def _wait(self) -> None:
        self.due = self.updated + largest(self.period - self.delay - TOLERANCE, TOLERANCE)

    def forget(self) -> None:
        """Forget the times, because the clock was set back."""
        self.updated = self.measured = self.delay = 0.0
        self._wait()
