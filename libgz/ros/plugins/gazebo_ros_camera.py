"""gazebo_ros_camera: images of a camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, DEPTH, DEPTH_ENDPOINTS, DepthCloud, RosCamera
from libgz.ros.plugins._sensor import model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosCamera(DepthCloud, SensorPlugin):
    """Publishes the images of a camera, and its calibration; in ROS 2, depths and points of a depth camera, too."""

    parameters = (*CAMERA, *DEPTH)
    endpoints = (*CAMERA_ENDPOINTS, *(one._replace(verb="in ROS 2 publishes") for one in DEPTH_ENDPOINTS))

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.open_camera(sensor.Camera())
        self.deep = self.two and sensor.Type() == "depth"
        if self.deep:
            self.open_depths()
        self.begin()

    def send(self) -> None:
        """Publish all that has subscribers."""
        (DepthCloud if self.deep else RosCamera).send(self)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosCamera)
