"""UpdateRate: when a model is due to act, by sim time; and OldRate, the old server's rule for it."""

from __future__ import annotations

import math
from typing import Any, ClassVar

from libgz.base.law import law
from libgz.base.records import RateRecord

__all__ = ["TIME_SLACK", "OldRate", "UpdateRate"]

TIME_SLACK = 1e-9  # [s]; the error of a sum of step times is less


class UpdateRate(RateRecord):
    """Ticks at a rate of sim time [Hz]: at the first call, then whenever a period has passed.

    The period is 1 / (rate + 1e-6), the old server's formula: 10 Hz is every fifth step of 20 ms.
    """

    STATE: ClassVar[tuple[str, ...]] = ("period", "last")

    def __init__(self, rate: float) -> None:
        super().__init__(period=1.0 / (rate + 1e-6), last=-math.inf, slack=TIME_SLACK)

    @law
    def is_due(self, now: Any) -> Any:
        """Whether `due` will say so; for laws, of rates whose period need not be exceeded."""
        elapsed = now - self.last
        return (elapsed < 0.0) | (elapsed >= self.period - self.slack)

    def due(self, now: float) -> bool:
        """Whether it is due at sim time `now` [s], also when time was set back. If so, the next period begins."""
        elapsed = now - self.last
        if 0.0 <= elapsed < self.period - self.slack or (self.beyond and elapsed == self.period):
            return False
        self.last = now
        return True


class OldRate(UpdateRate):
    """Ticks as the old server's models did: sums of step times are compared without a tolerance.

    Args:
        period: least time between two ticks [s].
        last: sim time at which the first period begins [s].
        beyond: whether a period has to be exceeded, and not only reached.
    """

    def __init__(self, period: float, last: float, beyond: bool = False) -> None:
        RateRecord.__init__(self, period=period, last=last, beyond=beyond)
