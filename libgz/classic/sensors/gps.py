"""GpsSensor: position on Earth and velocity of its link."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic import msgs
from libgz.classic.math import Angle, Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.read import first
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["GpsSensor"]

_T = SensorNoiseType
POSITION_NOISE = (
    _T.GPS_POSITION_LATITUDE_NOISE_METERS,
    _T.GPS_POSITION_LONGITUDE_NOISE_METERS,
    _T.GPS_POSITION_ALTITUDE_NOISE_METERS,
)
VELOCITY_NOISE = (
    _T.GPS_VELOCITY_LATITUDE_NOISE_METERS,
    _T.GPS_VELOCITY_LONGITUDE_NOISE_METERS,
    _T.GPS_VELOCITY_ALTITUDE_NOISE_METERS,
)


class GpsSensor(LinkSensor):
    """A satellite navigation receiver. Noise is on the local position [m] and on the velocity [m/s]."""

    STATE = (
        "_place",
        "_velocity",
    )

    message_type: ClassVar[Any] = msgs.GPS
    topic_appended = True

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        gps = sdf.child("gps")
        for key, kinds in (("position_sensing", POSITION_NOISE), ("velocity_sensing", VELOCITY_NOISE)):
            self.add_axis_noise(kinds, first(gps, key), ("horizontal", "horizontal", "vertical"))
        self._place = Vector3d()  # latitude, longitude [deg], altitude [m]
        self._velocity = Vector3d()

    def Init(self) -> None:
        """Take over the world's location."""
        self._globe = self.world.SphericalCoords()

    def measure(self, elapsed: float) -> None:
        """Measure position and velocity."""
        local = self.noisy_vector(POSITION_NOISE, Vector3d(*self.world_pose().pos))
        self._place = self._globe.SphericalFromLocal(local)
        velocity = self._globe.GlobalFromLocal(self.world_velocity())
        self._velocity = self.noisy_vector(VELOCITY_NOISE, velocity)

    def message(self) -> Any:
        """The last measurement as a msgs.GPS."""
        msg = self.stamped(link_name=self.ParentName())
        msg.latitude_deg, msg.longitude_deg, msg.altitude = self._place
        msg.velocity_east, msg.velocity_north, msg.velocity_up = self._velocity
        return msg

    def Latitude(self) -> Angle:
        """Latitude [rad], north positive."""
        return Angle(math.radians(self._place.x))

    def Longitude(self) -> Angle:
        """Longitude [rad], east positive."""
        return Angle(math.radians(self._place.y))

    def Altitude(self) -> float:
        """Height above the ellipsoid [m]."""
        return float(self._place.z)

    def VelocityENU(self) -> Vector3d:
        """Velocity to the east, north and up [m/s]."""
        return Vector3d(*self._velocity)

    def VelocityEast(self) -> float:
        """[m/s]."""
        return float(self._velocity.x)

    def VelocityNorth(self) -> float:
        """[m/s]."""
        return float(self._velocity.y)

    def VelocityUp(self) -> float:
        """[m/s]."""
        return float(self._velocity.z)

    GetLatitude, GetLongitude, GetAltitude = Latitude, Longitude, Altitude
