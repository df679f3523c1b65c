"""Timer: a stopwatch."""

from __future__ import annotations

import time

from libgz.base.errors import ParameterError
from libgz.classic.common.time import Time

__all__ = ["Timer"]


class Timer:
    """A stopwatch on real time. `Start` continues after `Stop`; `Reset` sets it to zero.

    Args:
        maxTime: at which it ends; None: never.
        countdown: whether it counts down from there to zero.

    Raises:
        ParameterError: a countdown without a time.
    """

    __slots__ = ("_countdown", "_elapsed", "_most", "_started")

    def __init__(self, maxTime: Time | float | None = None, countdown: bool = False) -> None:
        if countdown and maxTime is None:
            raise ParameterError("a countdown needs the time from which it counts: Timer(maxTime, True)")
        self._most = Time(maxTime).nanoseconds if maxTime is not None else None
        self._countdown = bool(countdown)
        self._elapsed = 0
        self._started: int | None = None

    def Start(self) -> None:
        """Start it; no effect if it runs."""
        if self._started is None:
            self._started = time.monotonic_ns()

    def Stop(self) -> None:
        """Stop it."""
        self._elapsed = self._run()
        self._started = None

    def Reset(self) -> None:
        """Stop it and set it to zero."""
        self._elapsed = 0
        self._started = None

    def GetRunning(self) -> bool:
        """Whether it runs: from Start to Stop, or until its maximum time."""
        return self._started is not None and (self._most is None or self._run() < self._most)

    def _run(self) -> int:
        """For how long it has run [ns]."""
        running = 0 if self._started is None else time.monotonic_ns() - self._started
        total = self._elapsed + running
        return total if self._most is None else min(total, self._most)

    def GetElapsed(self) -> Time:
        """The time for which it has run; of a countdown, the time that remains."""
        run = self._run()
        return Time.from_nanoseconds((self._most or 0) - run if self._countdown else run)

    def __repr__(self) -> str:
        return f"<Timer {self.GetElapsed().Double():.3f} s, {'running' if self.GetRunning() else 'stopped'}>"

    Running, Elapsed = GetRunning, GetElapsed
