"""Battery: the voltage of a link, and its consumers."""

from __future__ import annotations

import logging
from collections.abc import Callable

from libgz.base.errors import NotFoundError
from libgz.physics.check import finite, not_negative
from libgz.simulation.event import Callback

__all__ = ["Battery"]

log = logging.getLogger("libgz.classic")


class Battery:
    """A battery. Its voltage is constant unless `SetUpdateFunc` sets a rule.

    Args:
        name: the name, unique in its link.
        voltage: the initial voltage [V].

    Raises:
        ParameterError: the voltage is negative or not finite.
    """

    STATE = ("_voltage", "_loads", "_next")

    def __init__(self, name: str, voltage: float) -> None:
        self._name = name
        self._initial = self._voltage = not_negative(voltage, "voltage [V]")
        self._loads: dict[int, float] = {}
        self._next = 0  # number of the next consumer
        self._rule: Callback | None = None

    def Name(self) -> str:
        """The name."""
        return self._name

    def InitVoltage(self) -> float:
        """The initial voltage [V]."""
        return self._initial

    def Voltage(self) -> float:
        """The voltage [V]."""
        return self._voltage

    def AddConsumer(self) -> int:
        """Add a consumer, and return its number."""
        number, self._next = self._next, self._next + 1
        self._loads[number] = 0.0
        return number

    def RemoveConsumer(self, consumer: int) -> bool:
        """Remove a consumer; whether it existed."""
        return self._loads.pop(consumer, None) is not None

    def SetPowerLoad(self, consumer: int, load: float) -> bool:
        """Set the power load of a consumer [W]; whether it exists.

        Raises:
            ParameterError: the load is not finite.
        """
        if consumer in self._loads:
            self._loads[consumer] = finite(load, "power load [W]")
        return consumer in self._loads

    def PowerLoad(self, consumer: int) -> float:
        """The power load of a consumer [W].

        Raises:
            NotFoundError: there is no such consumer.
        """
        if consumer not in self._loads:
            known = ", ".join(map(str, self._loads)) or "none"
            raise NotFoundError(f"battery {self._name!r} has no consumer {consumer}; there are {known}")
        return self._loads[consumer]

    def PowerLoads(self) -> dict[int, float]:
        """The power loads of all consumers [W], by number."""
        return dict(self._loads)

    def SetUpdateFunc(self, rule: Callable[[Battery], float] | None) -> None:
        """Set the function `rule(battery)` that returns the voltage [V] in each step; None for a constant voltage.

        Raises:
            ParameterError: it cannot be called.
        """
        what = f"the rule of battery {self._name!r}"
        self._rule = Callback(what, rule, _voltage) if rule is not None else None

    def Update(self) -> None:
        """Apply the rule; the world calls this in every iteration."""
        if self._rule is not None:
            self._voltage = self._rule(self, otherwise=self._voltage)

    def ResetVoltage(self) -> None:
        """Restore the initial voltage; the world calls this when it is reset."""
        self._voltage = self._initial


def _voltage(value: float) -> float:
    return max(0.0, finite(value, "voltage [V]"))
