"""gazebo_ros_openni_kinect: images, depths and points of a depth camera."""

from __future__ import annotations

from libgz.classic.plugin import GZ_REGISTER_SENSOR_PLUGIN, SensorPlugin
from libgz.ros.plugin import Parameter
from libgz.ros.plugins._camera import CAMERA, CAMERA_ENDPOINTS, DEPTH, DEPTH_ENDPOINTS, DepthCloud

TOPICS = {
    "imageTopicName": Parameter("imageTopicName", "ir/image_raw", "images"),
    "cameraInfoTopicName": Parameter("cameraInfoTopicName", "ir/camera_info", "calibration"),
}


class GazeboRosOpenniKinect(DepthCloud, SensorPlugin):
    """Publishes the images, depths and points of a depth camera, as a Kinect with the OpenNI driver does."""

    parameters = (*(TOPICS.get(one.name, one) for one in CAMERA), *DEPTH)
    endpoints = (*CAMERA_ENDPOINTS, *DEPTH_ENDPOINTS)


GZ_REGISTER_SENSOR_PLUGIN(GazeboRosOpenniKinect)
