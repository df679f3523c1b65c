"""Rand: random numbers of the process."""

from __future__ import annotations

import random
import struct
from typing import Any, ClassVar

__all__ = ["Rand"]

_GENERATOR = struct.Struct("625I?d")  # 624 words and their index; whether there is a spare normal number, and it


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
    def _draw(cls) -> random.Random:
        cls._used = True
        return cls._engine

    @classmethod
    def SaveState(cls) -> tuple[object, ...]:
        """Seed and generator, for a snapshot of a world."""
        if not cls._used:
            return cls._seed, None
        _, words, spare = cls._engine.getstate()
        return cls._seed, _GENERATOR.pack(*words, spare is not None, spare or 0.0)

    @classmethod
    def LoadState(cls, state: tuple[Any, ...]) -> None:
        """Take what SaveState returned."""
        if state == cls.SaveState():
            return
        seed, packed = state
        cls.Seed(seed)
        if packed is not None:
            *words, has, value = _GENERATOR.unpack(packed)
            cls._engine.setstate((cls._engine.VERSION, tuple(words), value if has else None))
            cls._used = True

    @classmethod
    def DblUniform(cls, low: float = 0.0, high: float = 1.0) -> float:
        """Return a number of the uniform distribution between `low` and `high`."""
        return cls._draw().uniform(low, high)

    @classmethod
    def DblNormal(cls, mean: float = 0.0, sigma: float = 1.0) -> float:
        """Return a number of the normal distribution."""
        return cls._draw().normalvariate(mean, sigma)

    @classmethod
    def IntUniform(cls, low: int, high: int) -> int:
        """Return a uniformly distributed integer from `low` to `high`, both included."""
        return cls._draw().randint(low, high)

    @classmethod
    def IntNormal(cls, mean: int, sigma: int) -> int:
        """Return a number of the normal distribution, truncated to an integer."""
        return int(cls._draw().normalvariate(mean, sigma))

    SetSeed = GetSeed = Seed
    GetDblUniform = DblUniform
    GetDblNormal = DblNormal
    GetIntUniform = IntUniform
    GetIntNormal = IntNormal
