"""gazebo_ros_ray_sensor: scans, points or a range of a ray sensor, as ROS 2 has them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._cloud import directions, scan_points
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element

KINDS = {
    one.rpartition("/")[2].lower(): one
    for one in ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud", "sensor_msgs/PointCloud2", "sensor_msgs/Range")
}
RADIATIONS = {"ultrasound": 0, "infrared": 1}
FLOAT32 = 7  # of PointField


class GazeboRosRaySensor(RosSensor, SensorPlugin):
    """Publishes each measurement as a message of the type that `<output_type>` names.

    A LaserScan is the row in the middle; a Range is the nearest reading.
    """

    parameters = (
        Parameter("topicName", "~/out", "measurements"),
        Parameter("frameName", "", "frame of the measurements (the link's name)"),
        Parameter("outputType", "sensor_msgs/PointCloud2", f"of the messages: {', '.join(KINDS.values())}"),
        Parameter("radiationType", "infrared", "of a Range: ultrasound or infrared"),
        Parameter("minIntensity", 0.0, "intensities of points that are less become this one"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "<outputType>"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf)
        kind = KINDS.get(self.given.outputType.rpartition("/")[2].lower())
        if kind is None:
            raise ParameterError(
                f"{sdf.where}: <output_type> is {self.given.outputType!r}; it must be a message of "
                + ", ".join(KINDS.values())
            )
        message = self.message = message_type(kind)()
        message.header.frame_id = self.frame_of(self.given.frameName)
        self._fill = getattr(self, f"_fill_{kind.rpartition('/')[2].lower()}")
        if kind.endswith("Scan"):
            message.angle_min, message.angle_max = sensor.AngleMin().Radian(), sensor.AngleMax().Radian()
            message.angle_increment = sensor.AngleResolution()
            message.range_min, message.range_max = sensor.RangeMin(), sensor.RangeMax()
        elif kind.endswith("Range"):
            if self.given.radiationType not in RADIATIONS:
                raise ParameterError(
                    f"{sdf.where}: <radiation_type> is {self.given.radiationType!r}; it must be ultrasound or infrared"
                )
            message.radiation_type = RADIATIONS[self.given.radiationType]
            message.field_of_view = max(
                sensor.AngleMax().Radian() - sensor.AngleMin().Radian(),
                sensor.VerticalAngleMax().Radian() - sensor.VerticalAngleMin().Radian(),
            )
            message.min_range, message.max_range = sensor.RangeMin(), sensor.RangeMax()
        else:
            self.along = directions(sensor)
        self.publication = self.advertise(self.given.topicName, kind)
        self.begin()

    def send(self) -> None:
        """Publish the measurement."""
        self.stamp(self.message)
        self._fill(self.message)
        self.publication.publish(self.message)

    def _fill_laserscan(self, message: Any) -> None:
        sensor = self.sensor
        middle = slice((begin := sensor.VerticalRangeCount() // 2 * sensor.RangeCount()), begin + sensor.RangeCount())
        message.ranges = np.asarray(sensor.ranges()[middle], np.float32)
        message.intensities = np.maximum(np.asarray(sensor.intensities()[middle], np.float32), 0.0)

    def _fill_range(self, message: Any) -> None:
        message.range = float(min(self.sensor.ranges(), default=math.inf))

    def _points(self) -> NDArray[np.float32]:
        """Rows of x, y, z [m] and intensity of what is seen."""
        points = scan_points(self.sensor, self.along)
        strength = np.maximum(np.asarray(self.sensor.intensities(), np.float64), self.given.minIntensity)
        seen = np.isfinite(points).all(axis=1)
        rows: NDArray[np.float32] = np.column_stack([points, strength])[seen].astype(np.float32)
        return rows

    def _fill_pointcloud(self, message: Any) -> None:
        rows, point = self._points(), message_type("geometry_msgs/Point32")
        message.points = [point(x=x, y=y, z=z) for x, y, z in rows[:, :3].tolist()]
        channel = message_type("sensor_msgs/ChannelFloat32")
        message.channels = [channel(name="intensity", values=rows[:, 3])]

    def _fill_pointcloud2(self, message: Any) -> None:
        rows, field = self._points(), message_type("sensor_msgs/PointField")
        names = ("x", "y", "z", "intensity")
        message.fields = [
            field(name=name, offset=4 * index, datatype=FLOAT32, count=1) for index, name in enumerate(names)
        ]
        message.height, message.width, message.point_step = 1, len(rows), 16
        message.row_step, message.is_dense = 16 * len(rows), True
        message.data = rows.astype("<f4").tobytes()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosRaySensor)
