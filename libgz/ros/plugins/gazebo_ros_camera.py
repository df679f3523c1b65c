"""gazebo_ros_camera: images of a camera."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Endpoint, Parameter
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, DEPTH, DEPTH_ENDPOINTS, DepthCloud, RosCamera, open_each
from libgz.ros.plugins._sensor import model_of

if TYPE_CHECKING:
    from libgz.sdf.element import Element


class GazeboRosCamera(DepthCloud, SensorPlugin):
    """Publishes the images of a camera, and its calibration.

    In ROS 2, it also publishes depths and points of a depth camera, and images of the cameras of a multicamera; with
    `<triggered>`, one image of each camera for each message of `image_trigger`.
    """

    parameters = (*CAMERA, *DEPTH, Parameter("triggered", False, "in ROS 2: publish images for triggers only"))
    endpoints = (
        *CAMERA_ENDPOINTS,
        *(one._replace(verb="in ROS 2 publishes") for one in DEPTH_ENDPOINTS),
        Endpoint("in ROS 2 subscribes", "<cameraName>/image_trigger", "std_msgs/Empty"),
    )

    def Load(self, sensor: Any, sdf: Element) -> None:
        """Advertise."""
        self.open(sdf, model_of(sensor))
        self.open_sensor(sensor, sdf, self.given.updateRate)
        several = self.two and sensor.Type() == "multicamera"
        self.parts = open_each(self, sensor, sdf) if several else []
        self.deep = self.two and sensor.Type() == "depth"
        if several:
            self.camera_space = self.given.cameraName or sensor.Name()
        else:
            self.open_camera(sensor.Camera())
        if self.deep:
            self.open_depths()
        if self.two and self.given.triggered:
            self.open_trigger("image_trigger")
        if self.two:
            rate = float(sensor.UpdateRate())
            given = self.node_parameters.declare(
                "update_rate", rate, "of the camera [Hz]; 0: each iteration", self._check_rate, sensor.SetUpdateRate
            )
            if given != rate:
                sensor.SetUpdateRate(given)
        self.begin()

    def _check_rate(self, rate: float) -> None:
        if self.wanted is not None:
            raise ParameterError("Cannot set update rate for triggered camera")
        if not math.isfinite(rate):
            raise ParameterError(f"update_rate is {rate}; it must be finite")

    def send(self) -> None:
        """Publish all that has subscribers."""
        if not self.parts:
            (DepthCloud if self.deep else RosCamera).send(self)
        elif self.wanted != 0:
            for part in self.parts:
                part.send()
            self.count_image()


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosCamera)
