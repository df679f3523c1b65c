"""BreakableJointPlugin: a joint that breaks where it bears too much."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.classic.sensors import ForceTorqueSensor

if TYPE_CHECKING:
    from libgz.classic.sensors import Sensor
    from libgz.sdf.element import Element


class BreakableJointPlugin(SensorPlugin):
    """Detaches the joint of its force_torque sensor when the force is greater than a limit; the sensor stops.

    Elements:
        breaking_force_N: [N] (1).
    """

    STATE = ("broken",)

    def Load(self, sensor: Sensor, sdf: Element) -> None:
        """Read the limit.

        Raises:
            ParameterError: the sensor is of another type.
        """
        if not isinstance(sensor, ForceTorqueSensor):
            raise ParameterError(f"{sdf.where}: the plugin requires a force_torque sensor, not {sensor.Type()}")
        self.limit = self.LoadParam(sdf, "breaking_force_N", 1.0)
        self.sensor, self.joint, self.broken = sensor, sensor.Joint(), False
        self.connection = sensor.ConnectUpdate(self.OnUpdate)
        sensor.SetActive(True)

    def OnUpdate(self, message: Any) -> None:
        """A new wrench."""
        force = message.wrench.force
        if not self.broken and Vector3d(force.x, force.y, force.z).Length() > self.limit:
            self.broken = True
            self.joint.Detach()
            self.sensor.SetActive(False)

    def Reset(self) -> None:
        """The joint holds again."""
        self.broken = False
        self.sensor.SetActive(True)


GZ_REGISTER_SENSOR_PLUGIN(BreakableJointPlugin)
