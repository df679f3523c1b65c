"""LinearBatteryPlugin: the voltage of a battery as it discharges."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.plugin import ModelPlugin
from libgz.classic.plugins._names import named_battery, named_link

if TYPE_CHECKING:
    from libgz.classic.common import Battery
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

__all__ = ["LinearBatteryPlugin"]

EMPTY = 1e-3  # [V]; below, the voltage is zero from then on
HOUR = 3600.0  # [s]


class LinearBatteryPlugin(ModelPlugin):
    """Computes a battery's voltage from the loads on it: V = e0 + e1 (1 - q / c) - r i.

    The current i is the power of all consumers divided by the voltage, smoothed with the time constant tau; the
    charge q decreases by it. `libLinearBatteryConsumerPlugin.so` and `battery.AddConsumer()` are consumers.

    Elements:
        link_name, battery_name: link and name of the battery.
        open_circuit_voltage_constant_coef, open_circuit_voltage_linear_coef: e0 and e1 [V].
        initial_charge, capacity: initial q, and c [A h].
        resistance: r [ohm].
        smooth_current_tau: tau [s].
    """

    STATE = ("charge", "current")

    def Load(self, model: Model, sdf: Element) -> None:
        """Read the parameters, and set the update function of the battery."""
        self.physics = model.GetWorld().Physics()
        battery = named_battery(named_link(model, sdf), sdf)
        self.e0 = sdf.Get(float, "open_circuit_voltage_constant_coef")
        self.e1 = sdf.Get(float, "open_circuit_voltage_linear_coef")
        self.initial, self.capacity = sdf.Get(float, "initial_charge"), sdf.Get(float, "capacity")
        self.resistance, self.tau = sdf.Get(float, "resistance"), sdf.Get(float, "smooth_current_tau")
        for tag, value in (("capacity", self.capacity), ("smooth_current_tau", self.tau)):
            if not value > 0.0:
                raise ParameterError(f"{sdf.where}: <{tag}> is {value:g}; it must be positive")
        self.Reset()
        battery.SetUpdateFunc(self.voltage)

    def voltage(self, battery: Battery) -> float:
        """The voltage after a step [V]."""
        before, step = battery.Voltage(), self.physics.GetMaxStepSize()
        if before < EMPTY:
            return 0.0
        current = sum(battery.PowerLoads().values()) / before
        self.current += (current - self.current) * step / self.tau
        self.charge -= self.current * step / HOUR
        return self.e0 + self.e1 * (1.0 - self.charge / self.capacity) - self.resistance * self.current

    def Reset(self) -> None:
        """Restore the initial charge."""
        self.charge, self.current = self.initial, 0.0
