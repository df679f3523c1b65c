"""Pacer: keeps simulated time from running ahead of the clock on the wall."""

from __future__ import annotations

import time

from libgz.physics.check import not_negative

__all__ = ["Pacer"]

LARGEST_DEBT = 1.0  # [s]; a simulation that fell further behind does not race to catch up
LONGEST_SLEEP = 0.1  # [s]; so that a signal is noticed soon


class Pacer:
    """Sleeps until simulated time may go on.

    Args:
        speed: simulated seconds per second of real time; 0 for as fast as possible.
    """

    def __init__(self, speed: float) -> None:
        self.speed = not_negative(speed, "speed")
        self._start: float | None = None
        self._simulated_at_start = 0.0

    def ahead(self, simulated: float) -> float:
        """How long [s] to sleep before going on from `simulated` seconds; 0 if it is time."""
        if self.speed == 0.0:
            return 0.0
        now = time.monotonic()
        if self._start is None:
            self._start, self._simulated_at_start = now, simulated
        ahead = (simulated - self._simulated_at_start) / self.speed - (now - self._start)
        if ahead < -LARGEST_DEBT:
            self._start, self._simulated_at_start = now, simulated
        return max(0.0, ahead)

    def sleep(self, simulated: float) -> bool:
        """Sleep a while, 0.1 s at most; whether it is time to go on."""
        ahead = self.ahead(simulated)
        if ahead > 0.0:
            time.sleep(min(ahead, LONGEST_SLEEP))
        return ahead <= LONGEST_SLEEP
