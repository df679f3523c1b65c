"""Battery: a voltage that decreases with time and travel, and its power interface."""

from __future__ import annotations

from typing import ClassVar

from libgz.base.law import Number, law, where
from libgz.interfaces.power import Power, PowerData
from libgz.legacy.model import Model
from libgz.models.device import Device
from libgz.models.serving import serve
from libgz.simulation.plan import Plan

__all__ = ["Battery"]


class Battery(Device):
    """A robot's battery. Its voltage does not fall below zero; an empty battery does not stop the robot.

    Args:
        model: the robot.
        level: voltage at the start [V].
        curve: voltage lost with time [V/s] and with squared wheel travel [V/m^2].
    """

    STATE: ClassVar[tuple[str, ...]] = ("level",)

    interface: Power
    level = Number()  # voltage [V]

    def __init__(self, model: Model, level: float, curve: tuple[float, ...]) -> None:
        self.level, self.curve, self.model = level, tuple(curve), model
        self.interface = Power()

    def Init(self) -> None:
        """Create the interface under the model's id."""
        serve(self.model, self.interface)
        self.interface.data.levels[0] = self.level

    @law
    def drain(self, step: float, left: float, right: float) -> None:
        """Subtract the voltage lost in a step [s] in which the wheels of the sides travelled `left` and `right` [m]."""
        with_time, with_travel = self.curve
        level = self.level - (with_time * step + with_travel * (left * left + right * right))
        self.level = where(level > 0.0, level, 0.0)

    @law
    def publish(self, data: PowerData) -> None:
        """Write the voltage to the interface."""
        data.time = self.model.world.GetSimTime()
        data.levels[0] = self.level

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        plan.exchange(self.interface, self.publish)
