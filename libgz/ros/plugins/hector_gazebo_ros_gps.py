"""hector_gazebo_ros_gps: where a link is on the Earth, and how fast it moves."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Publishing, Rate, Ticks, noise, set_point
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

RADIUS, FLATTENING = 6378137.0, 1.0 / 298.257223563  # of the Earth by WGS 84 [m]
ECCENTRICITY2 = 2.0 * FLATTENING - FLATTENING**2
HOUR = 3600.0  # [s]
DIAGONAL_KNOWN = 2  # covariances
ERRORS = (
    ("Offset", Vector3d(), "constant error"),
    ("Drift", Vector3d(), "standard deviation of an error that changes slowly"),
    ("DriftFrequency", Vector3d(1 / HOUR, 1 / HOUR, 1 / HOUR), "of these changes [Hz]"),
    ("GaussianNoise", Vector3d(), "standard deviation of the noise"),
    ("ScaleError", Vector3d(1.0, 1.0, 1.0), "factor"),
)


def _parameters(prefix: str, what: str) -> tuple[Parameter, ...]:
    names = (f"{prefix}{name}" if prefix else f"{name[0].lower()}{name[1:]}" for name, _, _ in ERRORS)
    return tuple(
        Parameter(name, default, f"of the {what}: {meaning}")
        for name, (_, default, meaning) in zip(names, ERRORS, strict=True)
    )


class HectorGazeboRosGps(Publishing, ModelPlugin):
    """Publishes latitude, longitude and height of a link, and its velocity to the north and west."""

    STATE = ("ticks", "position_drift", "velocity_drift", "last")

    position, velocity = _parameters("", "position [m]"), _parameters("velocity", "velocity [m/s]")
    parameters = (
        Parameter("bodyName", str, "the link"),
        Parameter("frameId", "/world", "the frame in the messages"),
        Parameter("topicName", "fix", "positions"),
        Parameter("velocityTopicName", "fix_velocity", "velocities"),
        Parameter("updateRate", Rate(4.0), "[Hz]; 0: each iteration"),
        Parameter("referenceLatitude", 49.9, "of the world's origin [deg]"),
        Parameter("referenceLongitude", 8.9, "of the world's origin [deg]"),
        Parameter("referenceHeading", 0.0, "of the world's x axis, clockwise from north [deg]"),
        Parameter("referenceAltitude", 0.0, "of the world's origin [m]"),
        Parameter("useWorldSphericalCoordinates", False, "take the reference of the world's <spherical_coordinates>"),
        Parameter("status", 0, "in the messages"),
        Parameter("service", 0, "in the messages"),
        *position,
        *velocity,
    )
    endpoints = (
        Endpoint("publishes", "<topicName>", "sensor_msgs/NavSatFix"),
        Endpoint("publishes", "<velocityTopicName>", "geometry_msgs/Vector3Stamped"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "bodyName")
        self.ticks = Ticks(given.updateRate)
        self._set_reference(sdf)
        self.fix: Any = message_type("sensor_msgs/NavSatFix")()
        self.moved: Any = message_type("geometry_msgs/Vector3Stamped")()
        self.fix.header.frame_id = self.moved.header.frame_id = given.frameId
        self.fix.status.status, self.fix.status.service = given.status, given.service
        self.fix.position_covariance_type = DIAGONAL_KNOWN
        drift, spread = given.drift, given.gaussianNoise
        self.fix.position_covariance[::4] = [a * a + b * b for a, b in zip(drift, spread, strict=True)]
        self.fixes = self.advertise(given.topicName, "sensor_msgs/NavSatFix", 10)
        self.velocities = self.advertise(given.velocityTopicName, "geometry_msgs/Vector3Stamped", 10)
        self.Reset()
        self.run()

    def _set_reference(self, sdf: Element) -> None:
        given, surface = self.given, self.world.SphericalCoords()
        heading = math.radians(given.referenceHeading)
        if given.useWorldSphericalCoordinates:
            if not sdf.HasElement("referenceLatitude"):
                given.referenceLatitude = surface.LatitudeReference().Degree()
            if not sdf.HasElement("referenceLongitude"):
                given.referenceLongitude = surface.LongitudeReference().Degree()
            if not sdf.HasElement("referenceAltitude"):
                given.referenceAltitude = surface.GetElevationReference()
            if not sdf.HasElement("referenceHeading"):  # in SDF, it is counter-clockwise from east
                heading = math.pi / 2.0 - surface.HeadingOffset().Radian()
        self.north, self.west = math.cos(heading), math.sin(heading)
        latitude = math.radians(given.referenceLatitude)
        share = 1.0 / (1.0 - ECCENTRICITY2 * math.sin(latitude) ** 2)
        vertical = RADIUS * math.sqrt(share)
        self.radius_north, self.radius_east = vertical * (1.0 - ECCENTRICITY2) * share, vertical * math.cos(latitude)

    def Reset(self) -> None:
        """Begin again."""
        self.last = self.world.core.GetSimTime()
        self.position_drift, self.velocity_drift = (
            Vector3d(*map(noise, values)) for values in (self.given.drift, self.given.velocityDrift)
        )

    def work(self, now: float) -> None:
        """Publish."""
        elapsed, self.last = now - self.last, now
        self.velocity_drift = self._drifted(self.velocity_drift, self.velocity, elapsed)
        velocity = self._measured(self.link.WorldLinearVel(), self.velocity_drift, self.velocity)
        self.position_drift = self._drifted(self.position_drift, self.position, elapsed)
        x, y, z = self._measured(self.link.WorldPose().Pos(), self.position_drift, self.position)
        self.position_drift = self.position_drift + self.velocity_drift * elapsed
        fix, moved, given, north, west = self.fix, self.moved, self.given, self.north, self.west
        set_stamp(fix.header.stamp, now)
        set_stamp(moved.header.stamp, now)
        fix.latitude = given.referenceLatitude + math.degrees((north * x + west * y) / self.radius_north)
        fix.longitude = given.referenceLongitude - math.degrees((north * y - west * x) / self.radius_east)
        fix.altitude = given.referenceAltitude + z
        along, across, up = velocity
        set_point(moved.vector, Vector3d(north * along + west * across, north * across - west * along, up))
        self.fixes.publish(fix)
        self.velocities.publish(moved)

    def _values(self, parameters: tuple[Parameter, ...]) -> list[Any]:
        return [getattr(self.given, one.name) for one in parameters]

    def _drifted(self, drift: Vector3d, parameters: tuple[Parameter, ...], elapsed: float) -> Vector3d:
        _, spread, frequency, _, _ = self._values(parameters)
        return Vector3d(
            *(
                math.exp(-elapsed * f) * value + elapsed * noise(math.sqrt(2.0 * f) * s)
                for value, s, f in zip(drift, spread, map(abs, frequency), strict=True)
            )
        )

    def _measured(self, value: Vector3d, drift: Vector3d, parameters: tuple[Parameter, ...]) -> Vector3d:
        offset, _, _, spread, scale = self._values(parameters)
        rows = zip(value, scale, offset, drift, spread, strict=True)
        return Vector3d(*(v * s + o + d + noise(n) for v, s, o, d, n in rows))


GZ_REGISTER_MODEL_PLUGIN(HectorGazeboRosGps)
