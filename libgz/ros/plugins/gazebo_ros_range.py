"""gazebo_ros_range: the nearest reading of a laser or a sonar."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import NOISE, Endpoint, Parameter, Rate, noise
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosRange(RosSensor, SensorPlugin):
    """Publishes the shortest of all readings."""

    parameters = (
        Parameter("topicName", "/range", "ranges"),
        Parameter("frameName", "/world", "frame of the ranges"),
        Parameter("radiation", "ultrasound", "ultrasound or infrared"),
        Parameter("fov", 0.05, "field of view in the message [rad]"),
        NOISE,
        Parameter("updateRate", Rate(0.0), "at most so many messages a second [Hz]; 0: each measurement"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "sensor_msgs/Range"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        message = self.message = message_type("sensor_msgs/Range")()
        message.header.frame_id = self.frame(self.given.frameName)
        message.radiation_type = message.ULTRASOUND if self.given.radiation == "ultrasound" else message.INFRARED
        message.field_of_view = self.given.fov
        message.min_range, message.max_range = sensor.RangeMin(), sensor.RangeMax()
        self.publication = self.advertise(self.given.topicName, "sensor_msgs/Range")
        self.begin()

    def send(self) -> None:
        """Publish the shortest reading."""
        message, sensor = self.message, self.sensor
        shortest = float(np.min(sensor.ranges())) if hasattr(sensor, "ranges") else float(sensor.Range())
        shortest = max(message.min_range, min(message.max_range, shortest))
        if shortest < message.max_range:
            shortest = min(shortest + noise(self.given.gaussianNoise), message.max_range)
        self.stamp(message)
        message.range = shortest
        self.publication.publish(message)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosRange)
