"""Random numbers of the process, by the names of the old API."""

from __future__ import annotations

import random
from typing import ClassVar

__all__ = ["Rand"]


class Rand:
    """One generator for all plugins (a Mersenne twister). `Seed(n)` makes a run repeatable; without, each run differs.

    Noise of sensors does not come from here: what a plugin draws never changes what a sensor measures.
    """

    _seed: ClassVar[int] = random.SystemRandom().getrandbits(32)
    _engine: ClassVar[random.Random] = random.Random(_seed)

    @classmethod
    def Seed(cls, seed: int | None = None) -> int:
        """The seed; an argument sets it, and begins its sequence anew."""
        if seed is not None:
            cls._seed = int(seed)
            cls._engine.seed(cls._seed)
        return cls._seed

    @classmethod
    def DblUniform(cls, low: float = 0.0, high: float = 1.0) -> float:
        """A number evenly spread between `low` and `high`."""
        return cls._engine.uniform(low, high)

    @classmethod
    def DblNormal(cls, mean: float = 0.0, sigma: float = 1.0) -> float:
        """A number of the normal distribution."""
        return cls._engine.normalvariate(mean, sigma)

    @classmethod
    def IntUniform(cls, low: int, high: int) -> int:
        """A whole number from `low` to `high`, both included."""
        return cls._engine.randint(low, high)

    @classmethod
    def IntNormal(cls, mean: int, sigma: int) -> int:
        """A whole number of the normal distribution, its fraction cut off."""
        return int(cls._engine.normalvariate(mean, sigma))

    SetSeed = GetSeed = Seed
    GetDblUniform = DblUniform
    GetDblNormal = DblNormal
    GetIntUniform = IntUniform
    GetIntNormal = IntNormal
