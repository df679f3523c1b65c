"""RosSensor: activates its sensor, as the plugins of ROS did that published its measurements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class RosSensor(SensorPlugin):
    """Activates a sensor of any type, which publishes on its own topic. Elements have no effect."""

    STATE = ()

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Activate the sensor."""
        sensor.SetActive(True)


GZ_REGISTER_SENSOR_PLUGIN(RosSensor)
