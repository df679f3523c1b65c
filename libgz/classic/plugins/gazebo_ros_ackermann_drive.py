"""gazebo_ros_ackermann_drive: drives a car with two steered wheels, without ROS."""

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._ackermann import AckermannDrive

GZ_REGISTER_MODEL_PLUGIN(AckermannDrive)
