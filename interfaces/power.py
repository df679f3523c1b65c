"""power: the voltages of a robot's batteries."""

from __future__ import annotations

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.transport.interface import View
from libgz.transport.layout import SERVER, Array, double, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "Power",
    "PowerData",
    "gz_power_alloc",
    "gz_power_close",
    "gz_power_create",
    "gz_power_destroy",
    "gz_power_free",
    "gz_power_lock",
    "gz_power_open",
    "gz_power_post",
    "gz_power_unlock",
]


@layout
class PowerData(SampleData):
    """gz_power_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    levels: Array[float] = double(SERVER, "V", "voltage of each battery; only the first is used", 10)


class Power(SampleInterface[PowerData]):
    """Battery levels."""

    type = "power"
    data_class = PowerData

    levels = View("levels")

    @property
    def level(self) -> float:
        """Voltage of the first battery [V]."""
        return float(self.data.levels[0])


_functions = LegacyFunctions(Power)
gz_power_alloc = _functions.alloc
gz_power_free = _functions.free
gz_power_create = _functions.create
gz_power_destroy = _functions.destroy
gz_power_open = _functions.open
gz_power_close = _functions.close
gz_power_lock = _functions.lock
gz_power_unlock = _functions.unlock
gz_power_post = _functions.post
