"""Allowance: what messages of other processes may take between two steps, of time and of changes of worlds."""

from __future__ import annotations

import time

from libgz.base.credit import Credit

__all__ = ["Allowance"]

BURST = 0.1  # [s] that may be spent at once
DEBT = 0.5  # [s] that are counted of what took longer: who inserts a large world may command it soon after
CHANGES = 16  # of worlds


class Allowance:
    """As much time as has passed otherwise: the steps of worlds get half of it, however many messages come.

    Attributes:
        changes: deferred changes of worlds that messages have led to since `begin`; who delivers them counts.
    """

    def __init__(self) -> None:
        self._credit, self._since, self.changes = Credit(1.0, BURST, DEBT), time.monotonic(), 0

    def begin(self) -> None:
        """What has passed since the last call was not spent."""
        self._credit.earn(self._passed())
        self.changes = 0

    def spend(self) -> None:
        """What has passed since the last call was spent."""
        self._credit.spend(self._passed())

    @property
    def left(self) -> bool:
        """Whether one more message may be delivered; others wait for the next step."""
        return self._credit.left > 0.0 and self.changes < CHANGES

    def _passed(self) -> float:
        before, self._since = self._since, time.monotonic()
        return self._since - before
