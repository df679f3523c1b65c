"""Timer: a stopwatch."""

from __future__ import annotations

import time

from libgz.classic.common.time import Time

__all__ = ["Timer"]


class Timer:
    """A stopwatch on real time. `Start` continues after `Stop`; `Reset` sets it to zero."""

    __slots__ = ("_elapsed", "_started")

    def __init__(self) -> None:
        self._elapsed = 0
        self._started: int | None = None

    def Start(self) -> None:
        """Start it; no effect if it runs."""
        if self._started is None:
            self._started = time.monotonic_ns()

    def Stop(self) -> None:
        """Stop it."""
        self._elapsed = self.GetElapsed().nanoseconds
        self._started = None

    def Reset(self) -> None:
        """Stop it and set it to zero."""
        self._elapsed = 0
        self._started = None

    def GetRunning(self) -> bool:
        """Whether it runs."""
        return self._started is not None

    def GetElapsed(self) -> Time:
        """The time for which it has run."""
        running = 0 if self._started is None else time.monotonic_ns() - self._started
        return Time.from_nanoseconds(self._elapsed + running)

    def __repr__(self) -> str:
        return f"<Timer {self.GetElapsed().Double():.3f} s, {'running' if self.GetRunning() else 'stopped'}>"

    Running, Elapsed = GetRunning, GetElapsed
