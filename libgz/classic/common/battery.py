"""Battery: the voltage of a link, and what draws power from it."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable

from libgz.errors import NotFoundError
from libgz.physics.check import finite, not_negative
from libgz.simulation.event import Callback

__all__ = ["Battery"]

log = logging.getLogger("libgz.classic")


class Battery:
    """A battery. Its voltage stays what it is until `SetUpdateFunc` brings a rule.

    Args:
        name: of it in its link.
        voltage: at the start [V].
    """

    def __init__(self, name: str, voltage: float) -> None:
        self._name = name
        self._initial = self._voltage = not_negative(voltage, "voltage [V]")
        self._loads: dict[int, float] = {}
        self._numbers = itertools.count()
        self._rule: Callback | None = None

    def Name(self) -> str:
        """The name."""
        return self._name

    def InitVoltage(self) -> float:
        """The voltage at the start [V]."""
        return self._initial

    def Voltage(self) -> float:
        """The voltage now [V]."""
        return self._voltage

    def AddConsumer(self) -> int:
        """Add something that draws power; its number."""
        number = next(self._numbers)
        self._loads[number] = 0.0
        return number

    def RemoveConsumer(self, consumer: int) -> bool:
        """Take a consumer out; whether there was one."""
        return self._loads.pop(consumer, None) is not None

    def SetPowerLoad(self, consumer: int, load: float) -> bool:
        """Set what a consumer draws [W]; whether there is such a consumer."""
        if consumer in self._loads:
            self._loads[consumer] = finite(load, "power load [W]")
        return consumer in self._loads

    def PowerLoad(self, consumer: int) -> float:
        """What a consumer draws [W].

        Raises:
            NotFoundError: there is no such consumer.
        """
        if consumer not in self._loads:
            known = ", ".join(map(str, self._loads)) or "none"
            raise NotFoundError(f"battery {self._name!r} has no consumer {consumer}; there are {known}")
        return self._loads[consumer]

    def PowerLoads(self) -> dict[int, float]:
        """What all consumers draw [W], by number."""
        return dict(self._loads)

    def SetUpdateFunc(self, rule: Callable[[Battery], float] | None) -> None:
        """Let `rule(battery)` give the voltage [V] of each step; None: it stays.

        Raises:
            ParameterError: it cannot be called.
        """
        what = f"the rule of battery {self._name!r}"
        self._rule = Callback(what, rule, _voltage) if rule is not None else None

    def Update(self) -> None:
        """Follow the rule; the world calls this in every iteration."""
        if self._rule is not None:
            self._voltage = self._rule(self, otherwise=self._voltage)

    def ResetVoltage(self) -> None:
        """Go back to the voltage of the start; the world calls this when it is reset."""
        self._voltage = self._initial


def _voltage(value: float) -> float:
    return max(0.0, finite(value, "voltage [V]"))
