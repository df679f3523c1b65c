"""Outcome: the numbers with which a step of an environment ends, where a law computes them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.base.law import Number

__all__ = ["Outcome"]


class Outcome:
    """What a law computes at the end of a step, and the action that it was.

    Args:
        actions: numbers of an action.
        seen: numbers of an observation.

    Attributes:
        action: within its bounds, shape (m,).
        seen: what is observed, shape (n,); until the law sets them, the numbers of the step before.
        reward: of the step.
        ended: whether the episode has ended: 0 or 1.
    """

    reward = Number()
    ended = Number()

    def __init__(self, actions: int, seen: int) -> None:
        self.action: NDArray[np.float64] = np.zeros(actions)
        self.seen: NDArray[np.float64] = np.zeros(seen)
