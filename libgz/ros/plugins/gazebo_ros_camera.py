"""gazebo_ros_camera: images of a camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, RosCamera
from libgz.ros.plugins._sensor import model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosCamera(RosCamera, SensorPlugin):
    """Publishes the images of a camera, and its calibration."""

    parameters = CAMERA
    endpoints = CAMERA_ENDPOINTS

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.open_camera(sensor.Camera())
        self.begin()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosCamera)
