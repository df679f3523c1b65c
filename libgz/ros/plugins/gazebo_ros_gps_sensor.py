"""gazebo_ros_gps_sensor: positions of a GPS receiver."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element

POSITION_NOISES = (
    SensorNoiseType.GPS_POSITION_LATITUDE_NOISE_METERS,
    SensorNoiseType.GPS_POSITION_LONGITUDE_NOISE_METERS,
    SensorNoiseType.GPS_POSITION_ALTITUDE_NOISE_METERS,
)
DIAGONAL_KNOWN = 2  # of NavSatFix


class GazeboRosGpsSensor(RosSensor, SensorPlugin):
    """Publishes position and velocity of a gps sensor."""

    parameters = (
        Parameter("frameName", "", "frame of the positions (the link's name)"),
        Parameter("topicName", "fix", "positions", ros2="~/out"),
        Parameter("velocityTopicName", "vel", "velocities", ros2="~/vel"),
    )
    endpoints = (
        Endpoint("publishes", "<topicName>", "sensor_msgs/NavSatFix"),
        Endpoint("publishes", "<velocityTopicName>", "geometry_msgs/Vector3Stamped"),
    )

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf)
        name = self.frame(self.given.frameName or str(sensor.ParentName()).rpartition("::")[2])
        self.fix, self.velocity = (
            message_type(kind)() for kind in ("sensor_msgs/NavSatFix", "geometry_msgs/Vector3Stamped")
        )
        self.fix.header.frame_id = self.velocity.header.frame_id = name
        self.fix.status.status, self.fix.status.service = 0, 1
        if self.two:
            self.fix.position_covariance[::4] = [self.variance(kind) for kind in POSITION_NOISES]
            self.fix.position_covariance_type = DIAGONAL_KNOWN
        self.fixes = self.advertise(self.given.topicName, "sensor_msgs/NavSatFix")
        self.velocities = self.advertise(self.given.velocityTopicName, "geometry_msgs/Vector3Stamped")
        self.begin()

    def send(self) -> None:
        """Publish."""
        sensor, fix, velocity = self.sensor, self.fix, self.velocity
        self.stamp(fix)
        fix.latitude, fix.longitude = sensor.Latitude().Degree(), sensor.Longitude().Degree()
        fix.altitude = sensor.Altitude()
        self.fixes.publish(fix)
        self.stamp(velocity)
        moved: Vector3d = sensor.VelocityENU()
        velocity.vector.x, velocity.vector.y, velocity.vector.z = moved
        self.velocities.publish(velocity)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosGpsSensor)
