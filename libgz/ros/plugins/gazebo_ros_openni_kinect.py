"""gazebo_ros_openni_kinect: images, depths and points of a depth camera."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Parameter
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, DEPTH, DEPTH_ENDPOINTS, DepthCloud
from libgz.ros.plugins._sensor import model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element

TOPICS = {
    "imageTopicName": Parameter("imageTopicName", "ir/image_raw", "images"),
    "cameraInfoTopicName": Parameter("cameraInfoTopicName", "ir/camera_info", "calibration"),
}


class GazeboRosOpenniKinect(DepthCloud, SensorPlugin):
    """Publishes the images, depths and points of a depth camera, as a Kinect with the OpenNI driver does."""

    parameters = (*(TOPICS.get(one.name, one) for one in CAMERA), *DEPTH)
    endpoints = (*CAMERA_ENDPOINTS, *DEPTH_ENDPOINTS)

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.open_camera(sensor.Camera())
        self.open_depths()
        self.begin()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosOpenniKinect)
