"""RaySensorNoisePlugin: noise of a laser that grows with the range."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError
from libgz.classic.math import Rand
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin

if TYPE_CHECKING:
    from libgz.classic.sensors import Sensor
    from libgz.sdf.element import Element

SHARE = 0.005  # of a range, at most


class RaySensorNoisePlugin(SensorPlugin):
    """Adds up to 0.5 % of a range to it, and takes as much from the next one, in turn.

    The sensor, ray or gpu_ray, has `<noise>` with the type custom.
    """

    STATE = ("sign",)

    def Load(self, sensor: Sensor, sdf: Element) -> None:
        """Set the noise of the sensor.

        Raises:
            NotFoundError: the sensor has no noise of the type custom.
        """
        self.sign = 1.0
        noise = next((model for model in sensor.noises.values() if hasattr(model, "SetCustomNoiseCallback")), None)
        if noise is None:
            raise NotFoundError(
                f"{sdf.where}: No noise found: sensor {sensor.Name()!r} needs <noise><type>custom</type></noise>"
            )
        noise.SetCustomNoiseCallback(self.OnApplyNoise)

    def Reset(self) -> None:
        """Begin with a range that becomes shorter, as at the start."""
        self.sign = 1.0

    def OnApplyNoise(self, value: float) -> float:
        """The noisy value of a range [m]."""
        self.sign = -self.sign
        return value + self.sign * Rand.DblUniform(0.0, SHARE) * value


GZ_REGISTER_SENSOR_PLUGIN(RaySensorNoisePlugin)
