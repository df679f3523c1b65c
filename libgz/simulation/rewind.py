"""Rewind: the states of the last seconds of a world."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

from libgz.base.errors import StateError

__all__ = ["Rewind"]

SLACK = 1e-9  # [s]; the error of a sum of step times is less
MEGABYTE = 1 << 20


class _Moment(NamedTuple):
    sim_time: float  # [s]
    state: bytes


class Rewind:
    """A ring of states, a fixed sim time apart.

    Args:
        seconds: how far it reaches back [s of sim time].
        interval: between two states [s]; 0 for a state after each step.
        megabytes: what all states may take together; when they take more, the oldest ones go.
    """

    def __init__(self, seconds: float, interval: float, megabytes: float) -> None:
        self.seconds, self.interval = seconds, interval
        self._most = megabytes * MEGABYTE
        self._moments: deque[_Moment] = deque()
        self._size = 0
        self._failed_at = -math.inf  # sim time [s]
        self._failing = False  # since the last state that was kept

    @property
    def reach(self) -> float:
        """The sim time of the oldest state [s].

        Raises:
            StateError: there is none yet.
        """
        if not self._moments:
            raise StateError("no state was kept yet to rewind to")
        return self._moments[0].sim_time

    def due(self, now: float) -> bool:
        """Whether a state is to be kept at sim time `now` [s]; those of later times are dropped."""
        while self._moments and self._moments[-1].sim_time > now + SLACK:
            self._drop(self._moments.pop())
        if self._failed_at > now + SLACK:
            self._failed_at = -math.inf
        passed = now - max(self._failed_at, self._moments[-1].sim_time if self._moments else -math.inf)
        return passed > SLACK and passed >= self.interval - SLACK

    def keep(self, now: float, state: bytes) -> None:
        """Add a state of sim time `now` [s]."""
        self._failing = False
        self._moments.append(_Moment(now, state))
        self._size += len(state)
        while len(self._moments) > 1 and (
            self._size > self._most or self._moments[1].sim_time <= now - self.seconds + SLACK
        ):
            self._drop(self._moments.popleft())

    def fail(self, now: float) -> bool:
        """Leave out the state of sim time `now` [s], which cannot be saved; whether that is new."""
        before, self._failing, self._failed_at = self._failing, True, now
        return not before

    def _drop(self, moment: _Moment) -> None:
        self._size -= len(moment.state)

    def clear(self) -> None:
        """Drop all states."""
        self._moments.clear()
        self._size = 0

    def at(self, sim_time: float) -> bytes:
        """The last state at or before a sim time [s].

        Raises:
            StateError: it is before the oldest one.
        """
        for moment in reversed(self._moments):
            if moment.sim_time <= sim_time + SLACK:
                return moment.state
        raise StateError(f"sim time {sim_time:g} s is before the oldest state that was kept, of {self.reach:g} s")
