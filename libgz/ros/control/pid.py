"""RosPid: the controller of the ROS package control_toolbox."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from libgz.base.errors import ParameterError

__all__ = ["RosPid", "number_of"]


def number_of(values: Mapping[str, Any], key: str, default: float, where: str) -> float:
    """A number among parameters.

    Raises:
        ParameterError: it is none.
    """
    value = values.get(key, default)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ParameterError(f"parameter {where}/{key} is {value!r}; it must be a number")
    try:
        return float(value)
    except OverflowError:
        raise ParameterError(f"parameter {where}/{key} is too large a number") from None


class RosPid:
    """Proportional, integral and derivative terms of an error, with their sum as the command.

    The integral term is within ±i_clamp, or i_clamp_min and i_clamp_max; 0 clamps it to nothing, as in the original.

    Args:
        values: p, i, d, i_clamp, i_clamp_min, i_clamp_max, antiwindup.
        where: the name of these parameters.
    """

    def __init__(self, values: Mapping[str, Any], where: str) -> None:
        self.p, self.i, self.d = (number_of(values, key, 0.0, where) for key in ("p", "i", "d"))
        clamp = abs(number_of(values, "i_clamp", 0.0, where))
        self.most = number_of(values, "i_clamp_max", clamp, where)
        self.least = number_of(values, "i_clamp_min", -clamp, where)
        self.antiwindup = bool(values.get("antiwindup", False))
        self.reset()

    def reset(self) -> None:
        """Forget the past."""
        self._sum = 0.0
        self._before: float | None = None

    def command(self, error: float, elapsed: float) -> float:
        """The command for an error, `elapsed` seconds after the last one."""
        if elapsed <= 0.0:
            return 0.0
        rate = (error - self._before) / elapsed if self._before is not None else 0.0
        self._before = error
        return self.command_with_rate(error, rate, elapsed)

    def command_with_rate(self, error: float, rate: float, elapsed: float) -> float:
        """The command for an error whose rate of change is known."""
        self._sum += elapsed * error
        if self.antiwindup and self.i:
            low, high = sorted((self.least / self.i, self.most / self.i))
            self._sum = max(low, min(high, self._sum))
        part = max(self.least, min(self.most, self.i * self._sum))
        return self.p * error + part + self.d * rate
