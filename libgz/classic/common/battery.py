"""Battery: the voltage of a link, and what draws power from it."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable

from libgz.errors import NotFoundError
from libgz.physics.check import finite, not_negative
from libgz.simulation.event import Owner, owner
from libgz.simulation.plugins import own_traceback

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
        self._rule: Callable[[Battery], float] | None = None
        self._by: Owner | None = None  # whose rule it is

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
        """Let `rule(battery)` give the voltage [V] of each step; None: it stays."""
        self._rule, self._by = rule, owner.get()

    def Update(self) -> None:
        """Follow the rule; the world calls this in every iteration."""
        if self._rule is None:
            return
        token = owner.set(self._by)
        try:
            self._voltage = max(0.0, finite(self._rule(self), "voltage [V]"))
        except Exception as fault:  # noqa: BLE001 - a plugin's
            self._failed(fault)
        finally:
            owner.reset(token)

    def _failed(self, fault: Exception) -> None:
        """The rule raised: it is reported, and the voltage stays from now on."""
        self._rule, where = None, f"the rule of battery {self._name!r}"
        if self._by is not None:
            self._by.stop(where, fault)
        else:
            log.error("%s failed and is followed no more:\n%s", where, own_traceback(fault))

    def ResetVoltage(self) -> None:
        """Go back to the voltage of the start; the world calls this when it is reset."""
        self._voltage = self._initial
