"""SphericalCoordinates: the position of a world on the Earth.

The Earth is the ellipsoid of the World Geodetic System 1984 (NIMA TR8350.2, third edition, table 3.1). Geodetic
coordinates are converted to earth-centred ones by the closed formula, and back by two iterations of Bowring's formula
(Survey Review 28, 1985).
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import ClassVar

from libgz.base.errors import ParameterError
from libgz.base.geometry import VectorLike
from libgz.classic.math.angle import Angle
from libgz.classic.math.vector3 import Vector3d
from libgz.classic.names import takes_names

__all__ = ["SphericalCoordinates"]

_A = 6378137.0  # half the larger axis [m]
_FLATTENING = 1.0 / 298.257223563
_B = _A * (1.0 - _FLATTENING)
_E2 = _FLATTENING * (2.0 - _FLATTENING)  # first eccentricity, squared
_EP2 = _E2 / (1.0 - _E2)  # second eccentricity, squared
_MEAN_RADIUS = 6371000.0  # of the sphere that distances are measured on [m]


class _Surface(IntEnum):
    EARTH_WGS84 = 1


class _Frame(IntEnum):
    SPHERICAL = 1
    ECEF = 2
    GLOBAL = 3
    LOCAL = 4


@takes_names
class SphericalCoordinates:
    """Converts between the frame of a world and latitude, longitude and elevation.

    Frames, by name or number:

    - SPHERICAL: latitude, longitude [rad], elevation above the ellipsoid [m];
    - ECEF: earth-centred, earth-fixed: x through latitude and longitude 0, z through the north pole [m];
    - GLOBAL: east, north, up from the reference point [m];
    - LOCAL: the world; its x axis points as far north of east as the heading says [m].

    GLOBAL and LOCAL are flat: at a distance of 10 km the ground lies 8 m below z = 0.
    """

    SurfaceType: ClassVar[type[_Surface]] = _Surface
    CoordinateType: ClassVar[type[_Frame]] = _Frame
    EARTH_WGS84 = _Surface.EARTH_WGS84
    SPHERICAL, ECEF, GLOBAL, LOCAL = _Frame

    def __init__(
        self,
        surface: int = EARTH_WGS84,
        latitude: float | Angle = 0.0,
        longitude: float | Angle = 0.0,
        elevation: float = 0.0,
        heading: float | Angle = 0.0,
    ) -> None:
        """Set the position of the world's origin.

        Args:
            surface: EARTH_WGS84.
            latitude: of the origin, north positive [rad].
            longitude: of the origin, east positive [rad].
            elevation: of the origin above the ellipsoid [m].
            heading: of the world's x axis, from east towards north [rad].

        Raises:
            ParameterError: the surface is unknown.
        """
        self.SetSurfaceType(surface)
        self._latitude, self._longitude = Angle(latitude), Angle(longitude)
        self._elevation, self._heading = float(elevation), Angle(heading)
        self._place()

    def _place(self) -> None:
        """Compute the reference point and the directions east, north and up in ECEF."""
        lat, lon = self._latitude.radian, self._longitude.radian
        sin_lat, cos_lat, sin_lon, cos_lon = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
        self._origin = _ecef_from_spherical(Vector3d(lat, lon, self._elevation))
        self._east = Vector3d(-sin_lon, cos_lon, 0.0)
        self._north = Vector3d(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat)
        self._up = Vector3d(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat)

    @staticmethod
    def Convert(surface: str | int) -> str | _Surface:
        """The surface of a name, or the name of a surface.

        Raises:
            ParameterError: it is unknown.
        """
        if isinstance(surface, str) and surface in _Surface.__members__:
            return _Surface[surface]
        if surface in list(_Surface):
            return _Surface(surface).name
        raise ParameterError(f"surface {surface!r} is not known; EARTH_WGS84 is")

    # The reference point ---------------------------------------------------------------------------------------------

    def Surface(self) -> _Surface:
        """The surface."""
        return self._surface

    def SetSurfaceType(self, surface: int) -> None:
        """Set the surface.

        Raises:
            ParameterError: it is unknown.
        """
        if surface not in list(_Surface):
            raise ParameterError(f"surface {surface!r} is not known; EARTH_WGS84 is")
        self._surface = _Surface(surface)

    def LatitudeReference(self) -> Angle:
        """The latitude of the origin."""
        return Angle(self._latitude)

    def SetLatitudeReference(self, angle: float | Angle) -> None:
        """Set the latitude of the origin [rad]."""
        self._latitude = Angle(angle)
        self._place()

    def LongitudeReference(self) -> Angle:
        """The longitude of the origin."""
        return Angle(self._longitude)

    def SetLongitudeReference(self, angle: float | Angle) -> None:
        """Set the longitude of the origin [rad]."""
        self._longitude = Angle(angle)
        self._place()

    def ElevationReference(self) -> float:
        """The elevation of the origin [m]."""
        return self._elevation

    def SetElevationReference(self, elevation: float) -> None:
        """Set the elevation of the origin [m]."""
        self._elevation = float(elevation)
        self._place()

    def HeadingOffset(self) -> Angle:
        """The heading of the world's x axis, from east towards north."""
        return Angle(self._heading)

    def SetHeadingOffset(self, angle: float | Angle) -> None:
        """Set the heading of the world's x axis, from east towards north [rad]."""
        self._heading = Angle(angle)

    # Conversions -----------------------------------------------------------------------------------------------------

    def SphericalFromLocal(self, xyz: VectorLike) -> Vector3d:
        """Latitude, longitude [degrees] and elevation [m] of a point of the world [m]."""
        at = self.PositionTransform(xyz, _Frame.LOCAL, _Frame.SPHERICAL)
        return Vector3d(math.degrees(at.x), math.degrees(at.y), at.z)

    def LocalFromSpherical(self, spherical: VectorLike) -> Vector3d:
        """The point of the world [m] at a latitude, longitude [degrees] and elevation [m]."""
        latitude, longitude, elevation = spherical
        at = (math.radians(latitude), math.radians(longitude), elevation)
        return self.PositionTransform(at, _Frame.SPHERICAL, _Frame.LOCAL)

    def GlobalFromLocal(self, velocity: VectorLike) -> Vector3d:
        """East, north and up [m/s] of a velocity in the world [m/s]."""
        return self.VelocityTransform(velocity, _Frame.LOCAL, _Frame.GLOBAL)

    def LocalFromGlobal(self, velocity: VectorLike) -> Vector3d:
        """A velocity in the world [m/s] from east, north and up [m/s]."""
        return self.VelocityTransform(velocity, _Frame.GLOBAL, _Frame.LOCAL)

    @staticmethod
    def Distance(
        latitude_a: float | Angle, longitude_a: float | Angle, latitude_b: float | Angle, longitude_b: float | Angle
    ) -> float:
        """The distance of two points [rad] on a sphere of radius 6371 km [m], by the haversine formula."""
        lat_a, lon_a, lat_b, lon_b = map(float, (latitude_a, longitude_a, latitude_b, longitude_b))
        h = math.sin((lat_b - lat_a) / 2.0) ** 2
        h += math.cos(lat_a) * math.cos(lat_b) * math.sin((lon_b - lon_a) / 2.0) ** 2
        return 2.0 * _MEAN_RADIUS * math.asin(min(1.0, math.sqrt(h)))

    def PositionTransform(self, position: VectorLike, source: int, target: int) -> Vector3d:
        """A position in another frame.

        Args:
            position: in the source frame, in its units.
            source: SPHERICAL, ECEF, GLOBAL or LOCAL.
            target: the same.

        Raises:
            ParameterError: a frame is unknown.
        """
        source, target = _frame(source), _frame(target)
        at = Vector3d(position)
        if source == _Frame.SPHERICAL:
            at = _ecef_from_spherical(at)
        elif source != _Frame.ECEF:
            at = self._origin + self._outwards(at, source)
        if target == _Frame.SPHERICAL:
            return _spherical_from_ecef(at)
        return at if target == _Frame.ECEF else self._inwards(at - self._origin, target)

    def VelocityTransform(self, velocity: VectorLike, source: int, target: int) -> Vector3d:
        """A velocity [m/s] in another frame; directions are those at the reference point.

        Raises:
            ParameterError: a frame is unknown, or SPHERICAL, in which there are no velocities.
        """
        source, target = _frame(source), _frame(target)
        if _Frame.SPHERICAL in (source, target):
            raise ParameterError("there are no velocities in the frame SPHERICAL; use ECEF, GLOBAL or LOCAL")
        v = Vector3d(velocity)
        if source != _Frame.ECEF:
            v = self._outwards(v, source)
        return v if target == _Frame.ECEF else self._inwards(v, target)

    def _outwards(self, v: Vector3d, source: int) -> Vector3d:
        """A direction of LOCAL or GLOBAL in ECEF."""
        if source == _Frame.LOCAL:
            v = _turned(v, self._heading.radian)
        return self._east * v.x + self._north * v.y + self._up * v.z

    def _inwards(self, v: Vector3d, target: int) -> Vector3d:
        """A direction of ECEF in LOCAL or GLOBAL."""
        enu = Vector3d(self._east.Dot(v), self._north.Dot(v), self._up.Dot(v))
        return _turned(enu, -self._heading.radian) if target == _Frame.LOCAL else enu

    def __eq__(self, other: object) -> bool:
        return self._values() == other._values() if isinstance(other, SphericalCoordinates) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def _values(self) -> tuple[float, ...]:
        return self._surface, self._latitude.radian, self._longitude.radian, self._elevation, self._heading.radian

    def __repr__(self) -> str:
        names = ("latitude", "longitude", "elevation", "heading")
        values = ", ".join(f"{name}={value!r}" for name, value in zip(names, self._values()[1:], strict=True))
        return f"SphericalCoordinates({values})"

    GetSurfaceType = Surface
    GetLatitudeReference = LatitudeReference
    GetLongitudeReference = LongitudeReference
    GetElevationReference = ElevationReference
    GetHeadingOffset = HeadingOffset


def _frame(number: int) -> _Frame:
    if number not in list(_Frame):
        raise ParameterError(f"frame {number!r} is not known; use SPHERICAL, ECEF, GLOBAL or LOCAL")
    return _Frame(number)


def _turned(v: Vector3d, angle: float) -> Vector3d:
    """Rotate a vector about z."""
    c, s = math.cos(angle), math.sin(angle)
    return Vector3d(v.x * c - v.y * s, v.x * s + v.y * c, v.z)


def _ecef_from_spherical(at: Vector3d) -> Vector3d:
    sin_lat, cos_lat = math.sin(at.x), math.cos(at.x)
    normal = _A / math.sqrt(1.0 - _E2 * sin_lat * sin_lat)  # radius of curvature from west to east
    across = (normal + at.z) * cos_lat
    return Vector3d(across * math.cos(at.y), across * math.sin(at.y), (normal * (1.0 - _E2) + at.z) * sin_lat)


def _spherical_from_ecef(at: Vector3d) -> Vector3d:
    p = math.hypot(at.x, at.y)
    beta = math.atan2(at.z * _A, p * _B)  # reduced latitude, first guess
    latitude = 0.0
    for _ in range(2):
        latitude = math.atan2(at.z + _EP2 * _B * math.sin(beta) ** 3, p - _E2 * _A * math.cos(beta) ** 3)
        beta = math.atan2((1.0 - _FLATTENING) * math.sin(latitude), math.cos(latitude))
    sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
    # Height along the normal, a form that holds at the poles as well.
    height = p * cos_lat + at.z * sin_lat - _A * math.sqrt(1.0 - _E2 * sin_lat * sin_lat)
    return Vector3d(latitude, math.atan2(at.y, at.x), height)
