"""gazebo_ros_multicamera: images of several cameras of one sensor, such as a stereo pair."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, open_each
from libgz.ros.plugins._sensor import RosSensor, model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosMultiCamera(RosSensor, SensorPlugin):
    """Publishes the images of all cameras."""

    parameters = CAMERA
    endpoints = CAMERA_ENDPOINTS

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.parts = open_each(self, sensor, sdf)
        self.begin()

    def send(self) -> None:
        """Publish all images."""
        for part in self.parts:
            part.send()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosMultiCamera)
