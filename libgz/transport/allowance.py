"""Allowance: what messages of other processes may take between two steps, of time and of changes of worlds."""

from __future__ import annotations

import threading
import time

from libgz.base.credit import Credit

__all__ = ["Allowance", "Share"]

BURST = 0.1  # [s] that may be spent at once
DEBT = 0.5  # [s] that are counted of what took longer: who inserts a large world may command it soon after
CHANGES = 16  # of worlds
SHARE = 0.2  # of the time, for what other threads do about messages before they are delivered


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

    def charge(self, seconds: float) -> None:
        """So much was spent in other threads [s]."""
        self._credit.spend(seconds)

    @property
    def left(self) -> bool:
        """Whether one more message may be delivered; others wait for the next step."""
        return self._credit.left > 0.0 and self.changes < CHANGES

    def _passed(self) -> float:
        before, self._since = self._since, time.monotonic()
        return self._since - before


class Share:
    """Time of the processor that threads may spend on what comes in: a share of the time that passes."""

    def __init__(self) -> None:
        self._credit, self._since = Credit(SHARE, BURST, DEBT), time.monotonic()
        self._spent = self._taken = 0.0
        self._lock = threading.Lock()

    def spend(self, seconds: float) -> None:
        """So much was spent [s]."""
        with self._lock:
            self._earn()
            self._credit.spend(seconds)
            self._spent += seconds

    @property
    def wait(self) -> float:
        """How long it is until something may be spent [s]; 0.0: it may be now."""
        with self._lock:
            self._earn()
            return self._credit.wait

    def take_spent(self) -> float:
        """What was spent since the last call [s]; for one thread."""
        before, self._taken = self._taken, self._spent
        return self._taken - before

    def _earn(self) -> None:
        before, self._since = self._since, time.monotonic()
        self._credit.earn(self._since - before)
