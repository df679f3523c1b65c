"""Clock: what time it is in a world."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable

from libgz.legacy.settings import GlobalAttributes
from libgz.physics.check import finite

__all__ = ["Clock"]


class Clock:
    """Base of World: simulated, paused and real time."""

    settings: GlobalAttributes

    def __init__(self) -> None:
        self.iterations = 0  # steps done, pauses excluded
        self._simTime = self._pauseTime = 0.0
        # What callbacks of update events are given.
        self.update_info: Callable[[], object] = self._first_update_info
        self._start: float | None = None  # on the monotonic clock; None while the world does not run

    def GetSimTime(self) -> float:
        """Simulated time [s], pauses excluded."""
        return self._simTime

    def GetPauseTime(self) -> float:
        """Simulated time spent paused [s]: one step for each paused step."""
        return self._pauseTime

    def GetRealTime(self) -> float:
        """Wall-clock time since Initialize [s]."""
        return 0.0 if self._start is None else time.monotonic() - self._start

    def GetWallTime(self) -> float:
        """Unix time [s]."""
        return time.time()

    def _first_update_info(self) -> object:
        # By name, for classic stands above this package; it brings its own update_info.
        importlib.import_module("libgz.classic.server").attach(self)
        return self.update_info()

    def reset_time(self) -> None:
        """Set sim and pause time and the iterations to 0."""
        self._simTime = self._pauseTime = 0.0
        self.iterations = 0

    def set_sim_time(self, seconds: float) -> None:
        """Set the sim time [s].

        Raises:
            ParameterError: it is NaN or infinite.
        """
        self._simTime = finite(seconds, "sim time [s]")

    def GetDayTime(self) -> float:
        """Time since midnight [s]: the world's dayTime plus real time, or the local clock's."""
        if self.settings.dayTime >= 0.0:
            return self.settings.dayTime + self.GetRealTime()
        now = time.localtime()
        return now.tm_hour * 3600.0 + now.tm_min * 60.0 + now.tm_sec
