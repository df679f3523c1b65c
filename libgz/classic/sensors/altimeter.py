"""AltimeterSensor: height and vertical velocity of its link, relative to the start."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic import msgs
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.read import first
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["AltimeterSensor"]

POSITION = SensorNoiseType.ALTIMETER_POSITION_NOISE_METERS
VELOCITY = SensorNoiseType.ALTIMETER_VELOCITY_NOISE_METERS_PER_S


class AltimeterSensor(LinkSensor):
    """An altimeter; 0 is its height at the start."""

    STATE = (
        "_reference",
        "_altitude",
        "_velocity",
    )

    message_type: ClassVar[Any] = msgs.Altimeter
    topic_appended = True

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        altimeter = sdf.child("altimeter")
        self.add_noise(POSITION, first(altimeter, "vertical_position"))
        self.add_noise(VELOCITY, first(altimeter, "vertical_velocity"))
        self._reference = self._altitude = self._velocity = 0.0

    def Init(self) -> None:
        """Take the present height as the reference."""
        self._reference = self._height()

    def _height(self) -> float:
        return float(self.world_pose().pos.z)

    def measure(self, elapsed: float) -> None:
        """Measure height and velocity."""
        self._altitude = self.noisy(POSITION, self._height() - self._reference)
        self._velocity = self.noisy(VELOCITY, self.world_velocity().z)

    def message(self) -> Any:
        """The last measurement as a msgs.Altimeter."""
        msg = self.stamped(vertical_position=self._altitude, vertical_velocity=self._velocity)
        msg.vertical_reference = self._reference
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
