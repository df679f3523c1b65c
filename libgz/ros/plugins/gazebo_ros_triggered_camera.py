"""gazebo_ros_triggered_camera: images of a camera, one for each message of a trigger."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, RosCamera
from libgz.ros.plugins._sensor import model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosTriggeredCamera(RosCamera, SensorPlugin):
    """Publishes the next image after each message of the trigger."""

    parameters = (*CAMERA, Parameter("triggerTopicName", "image_trigger", "triggers"))
    endpoints = (*CAMERA_ENDPOINTS, Endpoint("subscribes", "<cameraName>/<triggerTopicName>", "std_msgs/Empty"))

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise and subscribe."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        self.open_camera(sensor.Camera())
        self.open_trigger(self.given.triggerTopicName)
        self.begin()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosTriggeredCamera)
