"""MovingWindowFilter: the mean of the last values."""

from __future__ import annotations

from collections import deque
from typing import Any

__all__ = ["MovingWindowFilter"]


class MovingWindowFilter:
    """The mean of the last values: numbers, vectors, or whatever can be added and divided."""

    STATE = ("_values",)

    def __init__(self, windowSize: int = 4) -> None:
        self._values: deque[Any] = deque(maxlen=max(1, int(windowSize)))

    def Update(self, value: Any) -> None:
        """Take a value."""
        self._values.append(value)

    def Get(self) -> Any:
        """The mean; 0 without values."""
        if not self._values:
            return 0.0
        first, *others = self._values
        return sum(others, start=first) * (1.0 / len(self._values))

    def GetWindowSize(self) -> int:
        """The number of values that count."""
        return self._values.maxlen or 1

    def SetWindowSize(self, size: int) -> None:
        """Set the number of values that count, and remove all."""
        self._values = deque(maxlen=max(1, int(size)))

    def GetWindowFilled(self) -> bool:
        """Whether there are as many values as count."""
        return len(self._values) == self._values.maxlen
