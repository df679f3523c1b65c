"""Clock: simulated, paused and real time of a world."""

from __future__ import annotations

import time

from libgz.base.records import ClockRecord
from libgz.physics.check import finite

__all__ = ["Clock"]


class Clock(ClockRecord):
    """Sim time, which steps advance, and the time of the wall clock beside it.

    Attributes:
        sim_time: simulated time [s], pauses excluded.
        pause_time: simulated time spent paused [s]: one step for each paused step.
        iterations: steps done, pauses excluded.
        running: whether the world has started, and not ended.
        day_time: time since midnight at the start [s]; negative for the local clock's.
    """

    def __init__(self) -> None:
        super().__init__()
        self.day_time = -1.0
        self.running = False

    def start(self) -> None:
        """Start to count real time."""
        self._start, self.running = time.monotonic(), True

    def stop(self) -> None:
        """Stop to count real time."""
        self.running = False

    @property
    def real_time(self) -> float:
        """Wall-clock time since `start` [s]."""
        return time.monotonic() - self._start if self.running else 0.0

    def set(self, seconds: float) -> None:
        """Set the sim time [s].

        Raises:
            ParameterError: it is NaN or infinite.
        """
        self.sim_time = finite(seconds, "sim time [s]")

    def reset(self) -> None:
        """Set sim and pause time and the iterations to 0."""
        self.sim_time = self.pause_time = 0.0
        self.iterations = 0

    def time_of_day(self) -> float:
        """Time since midnight [s]: `day_time` plus real time, or the local clock's."""
        if self.day_time >= 0.0:
            return self.day_time + self.real_time
        now = time.localtime()
        return now.tm_hour * 3600.0 + now.tm_min * 60.0 + now.tm_sec
