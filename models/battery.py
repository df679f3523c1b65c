"""Battery: a voltage that decreases with time and travel, and its power interface."""

from __future__ import annotations

from typing import ClassVar

from libgz.interfaces.power import Power
from libgz.legacy.model import Model
from libgz.models.serving import serve
from libgz.ode.records import BatteryRecord
from libgz.simulation.updates import Exchange, UpdateRows, is_plain

__all__ = ["Battery"]


class Battery(BatteryRecord):
    """A robot's battery. Its voltage does not fall below zero; an empty battery does not stop the robot.

    Args:
        model: the robot.
        level: voltage at the start [V].
        curve: voltage lost with time [V/s] and with squared wheel travel [V/m^2].
    """

    STATE: ClassVar[tuple[str, ...]] = ("level",)

    def __init__(self, model: Model, level: float, curve: tuple[float, ...]) -> None:
        super().__init__(level=level, curve=tuple(curve))
        self.model = model
        self.interface = Power()

    def Init(self) -> None:
        """Create the interface under the model's id."""
        serve(self.model, self.interface)
        self.interface.data.levels[0] = self.level

    def drain(self, step: float, left: float, right: float) -> None:
        """Subtract the voltage lost in a step [s] in which the wheels of the sides travelled `left` and `right` [m]."""
        with_time, with_travel = self.curve
        level = self.level - (with_time * step + with_travel * (left * left + right * right))
        self.level = level if level > 0.0 else 0.0

    def Update(self, now: float) -> None:
        """Publish, at sim time `now` [s]."""
        if self.interface.lock():
            self.interface.data.time = now
            self.interface.data.levels[0] = self.level
            self.interface.unlock()

    def MasterRows(self, rows: UpdateRows) -> None:
        """Describe `Update` as a row."""
        if not is_plain(self, Battery, "Update"):
            rows.python(self._update)
            return
        exchange = Exchange(self.interface)
        exchange.now()
        exchange.doubles("levels", (self, "level"))
        rows.share(self._update, exchange)

    def _update(self, _step: float) -> None:
        self.Update(self.model.world.GetSimTime())

    def Fini(self) -> None:
        """Destroy the interface."""
        self.interface.destroy()
