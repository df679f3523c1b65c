"""gazebo_ros_depth_camera: images, depths and points of a depth camera."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, DEPTH, DEPTH_ENDPOINTS, DepthCloud


class GazeboRosDepthCamera(DepthCloud, SensorPlugin):
    """Publishes the images, depths and points of a depth camera; points are one row, up to the far clipping plane."""

    flat = True

    parameters = (*CAMERA, *(one for one in DEPTH if one.name != "pointCloudCutoffMax"))
    endpoints = (*CAMERA_ENDPOINTS, *DEPTH_ENDPOINTS)

    @property
    def farthest(self) -> float:
        """Without end."""
        return math.inf

    def depth_data(self) -> NDArray[np.float32]:
        """Depths [m]; where nothing is, that of the far clipping plane."""
        return np.minimum(super().depth_data(), np.float32(self.camera.FarClip()))


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosDepthCamera)
