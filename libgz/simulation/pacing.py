"""Pacer: keeps sim time from running ahead of real time."""

from __future__ import annotations

import ctypes
import time

from libgz.base.records import PaceRecord
from libgz.physics.check import not_negative

__all__ = ["Pacer"]

LARGEST_DEBT = 1.0  # [s]; a simulation that is further behind does not try to catch up
LONGEST_SLEEP = 0.1  # [s]; so that a signal is noticed soon
LONGEST_RUN = 0.05  # [s] of steps without Python, for the same reason; to look costs as much as many idle steps


class Pacer:
    """Sleeps until the next step is due in real time.

    Args:
        speed: simulated seconds per second of real time; 0 for as fast as possible.
    """

    def __init__(self, speed: float) -> None:
        self.speed = not_negative(speed, "speed")
        self._record = PaceRecord(self.speed, debt=LARGEST_DEBT, longest=LONGEST_RUN)
        self._started = False

    @property
    def pace(self) -> int | None:
        """The address for native code of its speed and start; None where steps are not paced."""
        return ctypes.addressof(self._record) if self.speed > 0.0 and self._started else None

    def _begin(self, now: float, simulated: float) -> None:
        self._record.start, self._record.simulated, self._started = now, simulated, True

    def ahead(self, simulated: float) -> float:
        """How long [s] to sleep before the step after `simulated` seconds of sim time; 0 if it is due."""
        if self.speed == 0.0:
            return 0.0
        now = time.monotonic()
        if not self._started:
            self._begin(now, simulated)
        ahead = (simulated - self._record.simulated) / self.speed - (now - self._record.start)
        if ahead < -LARGEST_DEBT:
            self._begin(now, simulated)
        return max(0.0, ahead)

    def sleep(self, simulated: float) -> bool:
        """Sleep, 0.1 s at most; whether the next step is due."""
        ahead = self.ahead(simulated)
        if ahead > 0.0:
            time.sleep(min(ahead, LONGEST_SLEEP))
        return ahead <= LONGEST_SLEEP
