"""AltimeterSensor: how far its link has risen since the start, and how fast it rises."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import Sensor
from libgz.geometry import GzCoordPoseAdd

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["AltimeterSensor"]

POSITION = SensorNoiseType.ALTIMETER_POSITION_NOISE_METERS
VELOCITY = SensorNoiseType.ALTIMETER_VELOCITY_NOISE_METERS_PER_S


class AltimeterSensor(Sensor):
    """An altimeter; 0 is the height at which it began."""

    message_type: ClassVar[str] = "Altimeter"
    topic_behind = True

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        altimeter = sdf.child("altimeter")
        self.add_noise(POSITION, next(altimeter.named("vertical_position"), None))
        self.add_noise(VELOCITY, next(altimeter.named("vertical_velocity"), None))
        self._reference = self._altitude = self._velocity = 0.0

    def Init(self) -> None:
        """Count from the present height."""
        self._reference = self._height()

    def _height(self) -> float:
        return float(GzCoordPoseAdd(self._pose, self.link.pose()).pos.z)

    def measure(self, now: float) -> bool:
        """Measure."""
        self._measured = now
        self._altitude = self.noisy(POSITION, self._height() - self._reference)
        self._velocity = self.noisy(VELOCITY, self.link.WorldLinearVel(self._pose.pos).z)
        if self.listened():
            self.publish(self.altimeter_message())
        return True

    def altimeter_message(self) -> Any:
        """The last measurement as a msgs.Altimeter."""
        from libgz.classic import msgs

        msg = self.new_message(vertical_position=self._altitude, vertical_velocity=self._velocity)
        msg.vertical_reference = self._reference
        msgs.Set(msg.time, Time(self._measured))
        return msg

    def Altitude(self) -> float:
        """Height above the reference [m]."""
        return self._altitude

    def VerticalVelocity(self) -> float:
        """[m/s]."""
        return self._velocity

    def ReferenceAltitude(self) -> float:
        """The height that counts as 0 [m], global."""
        return self._reference

    def SetReferenceAltitude(self, refAlt: float) -> None:
        """Set the height that counts as 0 [m], global."""
        self._altitude -= refAlt - self._reference
        self._reference = float(refAlt)
