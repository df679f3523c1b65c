"""gazebo_ros_velodyne_laser: scans of a laser in rows, as points with intensity, ring and time."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import NOISE, Endpoint, Parameter
from libgz.ros.plugins._cloud import directions, scan_points
from libgz.ros.plugins._sensor import RosSensor, model_of
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.sdf.element import Element

POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")])
KINDS = {"<f4": 7, "<u2": 4}  # PointField.FLOAT32, UINT16


class GazeboRosVelodyneLaser(RosSensor, SensorPlugin):
    """Publishes each scan as points; those out of range are left out, or NaN in an organized cloud."""

    parameters = (
        Parameter("topicName", "/points", "points"),
        Parameter("frameName", "/world", "frame of the points"),
        Parameter("organize_cloud", False, "keep the rows, with NaN where nothing is seen"),
        Parameter("min_range", 0.0, "nearest point [m]"),
        Parameter("max_range", math.inf, "farthest point [m]"),
        Parameter("min_intensity", -math.inf, "least intensity of a point"),
        NOISE,
    )
    endpoints = (Endpoint("publishes", "<topicName>", "sensor_msgs/PointCloud2"),)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf)
        self.random = np.random.default_rng(sensor.world.core.seed)
        self.directions = directions(sensor)
        self.frame_name = self.frame(self.given.frameName)
        self.publication = self.advertise(self.given.topicName, "sensor_msgs/PointCloud2")
        self.begin()

    def send(self) -> None:
        """Publish the cloud."""
        given, (rows, columns) = self.given, self.directions.shape[:2]
        ranges = np.asarray(self.sensor.ranges(), np.float64)
        values = np.asarray(self.sensor.intensities(), np.float64)
        seen = np.isfinite(ranges) & (ranges > given.min_range) & (ranges < given.max_range)
        seen &= values >= given.min_intensity
        places = scan_points(self.sensor, self.directions)
        if given.gaussianNoise > 0.0:
            places = places + self.random.normal(0.0, given.gaussianNoise, places.shape)
        points = np.zeros(len(ranges), POINT)
        points["x"], points["y"], points["z"] = places.T
        points["intensity"], points["ring"] = values, np.repeat(np.arange(rows), columns)
        if given.organize_cloud:
            for axis in "xyz":
                points[axis][~seen] = math.nan
        else:
            points = points[seen]
        message = message_type("sensor_msgs/PointCloud2")()
        self.stamp(message)
        message.header.frame_id = self.frame_name
        message.height, message.width = (rows, columns) if given.organize_cloud else (1, len(points))
        field = message_type("sensor_msgs/PointField")
        kinds: Mapping[str, Any] = POINT.fields or {}
        message.fields = [
            field(name=name, offset=kind[1], datatype=KINDS[kind[0].str], count=1) for name, kind in kinds.items()
        ]
        message.point_step, message.row_step = POINT.itemsize, POINT.itemsize * message.width
        message.is_dense, message.data = bool(seen.all()) or not given.organize_cloud, points.tobytes()
        self.publication.publish(message)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosVelodyneLaser)
