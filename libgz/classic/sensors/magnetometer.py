"""MagnetometerSensor: the world's magnetic field along its own axes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.math import Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import Sensor

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["MagnetometerSensor"]

NOISE = (
    SensorNoiseType.MAGNETOMETER_X_NOISE_TESLA,
    SensorNoiseType.MAGNETOMETER_Y_NOISE_TESLA,
    SensorNoiseType.MAGNETOMETER_Z_NOISE_TESLA,
)


class MagnetometerSensor(Sensor):
    """A compass for three axes."""

    message_type: ClassVar[str] = "Magnetometer"
    topic_behind = True

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        magnetometer = sdf.child("magnetometer")
        for axis, kind in zip("xyz", NOISE, strict=True):
            self.add_noise(kind, next(magnetometer.named(axis), None))
        self._field = Vector3d()

    def measure(self, now: float) -> bool:
        """Measure."""
        self._measured = now
        turn = self.link.WorldPose().rot * self._pose.rot
        field = turn.RotateVectorReverse(self.world.MagneticField())
        self._field = Vector3d(*(self.noisy(kind, value) for kind, value in zip(NOISE, field, strict=True)))
        if self.listened():
            self.publish(self.magnetometer_message())
        return True

    def magnetometer_message(self) -> Any:
        """The last measurement as a msgs.Magnetometer."""
        from libgz.classic import msgs

        msg = self.new_message()
        msgs.Set(msg.time, Time(self._measured))
        msgs.Set(msg.field_tesla, self._field)
        return msg

    def MagneticField(self) -> Vector3d:
        """The field along its axes [T]."""
        return Vector3d(*self._field)
