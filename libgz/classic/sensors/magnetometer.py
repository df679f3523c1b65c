"""MagnetometerSensor: the world's magnetic field along its own axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic import msgs
from libgz.classic.math import Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["MagnetometerSensor"]

NOISE = (
    SensorNoiseType.MAGNETOMETER_X_NOISE_TESLA,
    SensorNoiseType.MAGNETOMETER_Y_NOISE_TESLA,
    SensorNoiseType.MAGNETOMETER_Z_NOISE_TESLA,
)


class MagnetometerSensor(LinkSensor):
    """A compass for three axes."""

    STATE = ("_field",)

    message_type: ClassVar[Any] = msgs.Magnetometer
    topic_appended = True

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.add_axis_noise(NOISE, sdf.child("magnetometer"), "xyz")
        self._field = Vector3d()

    def measure(self, elapsed: float) -> None:
        """Measure the field."""
        field = self.world_rotation().RotateVectorReverse(self.world.MagneticField())
        self._field = self.noisy_vector(NOISE, field)

    def message(self) -> Any:
        """The last measurement as a msgs.Magnetometer."""
        msg = self.stamped()
        msgs.Set(msg.field_tesla, self._field)
        return msg

    def MagneticField(self) -> Vector3d:
        """The field along its axes [T]."""
        return Vector3d(*self._field)
