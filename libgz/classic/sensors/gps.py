"""GpsSensor: where on Earth its link is, and how fast."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.classic.common import Time
from libgz.classic.math import Angle, Vector3d
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.sensor import Sensor
from libgz.geometry import GzCoordPoseAdd

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
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


class GpsSensor(Sensor):
    """A satellite navigation receiver. Noise is on the local position [m] and on the velocity [m/s]."""

    message_type: ClassVar[str] = "GPS"
    topic_behind = True

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        gps = sdf.child("gps")
        for key, kinds in (("position_sensing", POSITION_NOISE), ("velocity_sensing", VELOCITY_NOISE)):
            holder = next(gps.named(key), None)
            for axis, kind in zip(("horizontal", "horizontal", "vertical"), kinds, strict=True):
                self.add_noise(kind, next(holder.named(axis), None) if holder is not None else None)
        self._place = Vector3d()  # latitude, longitude [deg], altitude [m]
        self._velocity = Vector3d()

    def Init(self) -> None:
        """Take over where the world lies."""
        self._globe = self.world.SphericalCoords()

    def measure(self, now: float) -> bool:
        """Measure position and velocity."""
        self._measured = now
        position = GzCoordPoseAdd(self._pose, self.link.pose()).pos
        local = [self.noisy(kind, value) for kind, value in zip(POSITION_NOISE, position, strict=True)]
        self._place = self._globe.SphericalFromLocal(Vector3d(*local))
        velocity = self._globe.GlobalFromLocal(self.link.WorldLinearVel(self._pose.pos))
        self._velocity = Vector3d(
            *(self.noisy(kind, value) for kind, value in zip(VELOCITY_NOISE, velocity, strict=True))
        )
        if self.listened():
            self.publish(self.gps_message())
        return True

    def gps_message(self) -> Any:
        """The last measurement as a msgs.GPS."""
        from libgz.classic import msgs

        msg = self.new_message(link_name=self.ParentName())
        msgs.Set(msg.time, Time(self._measured))
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
