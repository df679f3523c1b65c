"""Credit: time that may be spent on something, which comes as a share of the time that passes."""

from __future__ import annotations

import math

__all__ = ["Credit"]


class Credit:
    """Seconds that may be spent.

    Args:
        share: of the time that passes, which is added.
        most: that may be left [s]; so much is, at first.
        debt: what is counted at most of what took longer than was left [s].

    Attributes:
        left: What may be spent now [s]; negative in debt.
    """

    def __init__(self, share: float, most: float, debt: float = math.inf) -> None:
        self.left = self._most = most
        self._share, self._debt = share, debt

    @property
    def wait(self) -> float:
        """How long it is until something is left [s]."""
        return max(-self.left, 0.0) / self._share

    def earn(self, passed: float) -> None:
        """Add the share of what has passed [s]."""
        self.left = min(self._most, self.left + self._share * max(passed, 0.0))

    def spend(self, seconds: float) -> None:
        """Take what was spent [s]."""
        self.left = max(self.left - seconds, -self._debt)
