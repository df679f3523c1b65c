"""Outcome: the numbers with which a step of an environment ends."""

from __future__ import annotations

import ctypes
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.law import Number

__all__ = ["Outcome"]


class Outcome:
    """What a step of an environment ends with, and the action that it was, where a law computes it.

    Args:
        actions: numbers of an action.
        seen: numbers of an observation.
        numbers: where all of them are, one after the other, shape (m + n + 2,); None for new ones.

    Attributes:
        action: within its bounds, shape (m,).
        seen: what is observed, shape (n,); until the law sets them, the numbers of the step before.
        reward: of the step.
        ended: whether the episode has ended: 0 or 1.
    """

    STATE: ClassVar[tuple[str, ...]] = ("numbers",)

    reward = Number()
    ended = Number()

    def __init__(self, actions: int, seen: int, numbers: NDArray[np.float64] | None = None) -> None:
        if numbers is None:
            numbers = np.zeros(actions + seen + 2)
        self.numbers, self.action, self.seen = numbers, numbers[:actions], numbers[actions:-2]
        Outcome.reward.put(self, ctypes.c_double.from_buffer(numbers[-2:].data))
        Outcome.ended.put(self, ctypes.c_double.from_buffer(numbers[-1:].data))
