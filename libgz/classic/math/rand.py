"""Rand: random numbers of the process."""

from __future__ import annotations

import random
from typing import Any, ClassVar

__all__ = ["Rand"]


class Rand:
    """One generator for all plugins (a Mersenne twister). `Seed(n)` makes runs repeatable; otherwise each run differs.

    Sensors have generators of their own: random numbers of a plugin do not change the noise of sensors.
    """

    _seed: ClassVar[int] = random.SystemRandom().getrandbits(32)
    _engine: ClassVar[random.Random] = random.Random(_seed)
    _used: ClassVar[bool] = False  # whether there were numbers since it was seeded

    @classmethod
    def Seed(cls, seed: int | None = None) -> int:
        """Return the seed; an argument sets it and restarts the sequence."""
        if seed is not None:
            cls._seed = int(seed)
            cls._engine.seed(cls._seed)
            cls._used = False
        return cls._seed

    @classmethod
    def SaveState(cls) -> tuple[object, ...]:
        """Seed and generator, for a snapshot of a world."""
        return cls._seed, cls._engine.getstate() if cls._used else None

    @classmethod
    def LoadState(cls, state: tuple[Any, ...]) -> None:
        """Take what SaveState returned."""
        cls.Seed(state[0])
        if state[1] is not None:
            cls._engine.setstate(state[1])
            cls._used = True

    @classmethod
    def DblUniform(cls, low: float = 0.0, high: float = 1.0) -> float:
        """Return a number of the uniform distribution between `low` and `high`."""
        cls._used = True
        return cls._engine.uniform(low, high)

    @classmethod
    def DblNormal(cls, mean: float = 0.0, sigma: float = 1.0) -> float:
        """Return a number of the normal distribution."""
        cls._used = True
        return cls._engine.normalvariate(mean, sigma)

    @classmethod
    def IntUniform(cls, low: int, high: int) -> int:
        """Return a uniformly distributed integer from `low` to `high`, both included."""
        cls._used = True
        return cls._engine.randint(low, high)

    @classmethod
    def IntNormal(cls, mean: int, sigma: int) -> int:
        """Return a number of the normal distribution, truncated to an integer."""
        cls._used = True
        return int(cls._engine.normalvariate(mean, sigma))

    SetSeed = GetSeed = Seed
    GetDblUniform = DblUniform
    GetDblNormal = DblNormal
    GetIntUniform = IntUniform
    GetIntNormal = IntNormal
