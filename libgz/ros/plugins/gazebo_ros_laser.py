"""gazebo_ros_laser: scans of a laser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosLaser(RosSensor, SensorPlugin):
    """Publishes each scan of a ray or gpu_ray sensor. Readings beyond the range are infinite."""

    parameters = (
        Parameter("topicName", "/world", "scans"),
        Parameter("frameName", "/world", "frame of the scans"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "sensor_msgs/LaserScan"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf)
        message = self.message = message_type("sensor_msgs/LaserScan")()
        message.header.frame_id = self.frame(self.given.frameName)
        message.angle_min, message.angle_max = sensor.AngleMin().Radian(), sensor.AngleMax().Radian()
        message.angle_increment = sensor.AngleResolution()
        message.range_min, message.range_max = sensor.RangeMin(), sensor.RangeMax()
        self.publication = self.advertise(self.given.topicName, "sensor_msgs/LaserScan")
        self.packed: PackedMessage | None = None
        self.begin()

    def send(self) -> None:
        """Publish the scan."""
        ranges, intensities = self.sensor.ranges(), self.sensor.intensities()
        if self.packed is None:
            self.message.ranges, self.message.intensities = ranges, intensities
            self.packed = PackedMessage(self.publication, self.message)
        self.packed.stamp(self.measured)
        self.packed.put_array("ranges", ranges)
        self.packed.put_array("intensities", intensities)
        self.packed.send()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosLaser)
