"""gazebo_ros_block_laser: scans of a laser in rows, as a cloud of points."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import NOISE, Endpoint, Parameter, Rate
from libgz.ros.plugins._cloud import directions, scan_points
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosBlockLaser(RosSensor, SensorPlugin):
    """Publishes each scan as points, with intensities in a channel."""

    parameters = (
        Parameter("topicName", "/world", "points"),
        Parameter("frameName", "/world", "frame of the points"),
        NOISE,
        Parameter("updateRate", Rate(0.0), "at most so many clouds a second [Hz]; 0: each scan"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "sensor_msgs/PointCloud"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.random = np.random.default_rng(sensor.world.core.seed)
        self.directions = directions(sensor)
        self.frame_name = self.frame(self.given.frameName)
        self.publication = self.advertise(self.given.topicName, "sensor_msgs/PointCloud")
        self.begin()

    def send(self) -> None:
        """Publish the cloud."""
        points, deviation = scan_points(self.sensor, self.directions), self.given.gaussianNoise
        values = np.asarray(self.sensor.intensities(), np.float64)
        if deviation > 0.0:
            points = points + self.random.normal(0.0, deviation, points.shape)
            values = values + self.random.normal(0.0, deviation, values.shape)
        message = message_type("sensor_msgs/PointCloud")()
        self.stamp(message)
        message.header.frame_id = self.frame_name
        point = message_type("geometry_msgs/Point32")
        message.points = [point(x=x, y=y, z=z) for x, y, z in points.tolist()]
        message.channels = [message_type("sensor_msgs/ChannelFloat32")(values=values)]
        self.publication.publish(message)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosBlockLaser)
