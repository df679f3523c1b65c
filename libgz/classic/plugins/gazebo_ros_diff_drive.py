"""gazebo_ros_diff_drive: drives a model with two wheels, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._ros import ros_joints
from libgz.classic.plugins._ros_drive import RosDrive

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element


class GazeboRosDiffDrive(RosDrive):
    """Drives a model with two wheels, or several on each side, by its command topic or its position interface.

    The topic takes a Pose: x of the position is the speed [m/s], yaw of the orientation the turn rate, left positive
    [rad/s]. The interface is called as the model. Odometry, from zero at the start, is published as a PoseStamped.

    Elements, also under their names in ROS 2 (left_joint, max_wheel_torque, `<ros>` with namespace and remapping):
        leftJoint, rightJoint: names of the wheels' joints, several of each (left_joint, right_joint).
        wheelSeparation, wheelDiameter: [m]; as built, if they are missing.
        wheelTorque: maximum torque of each wheel [N m] (5); also torque.
        wheelAcceleration: most change of the wheels' speed [m/s^2] (0: none).
        updateRate: of commands and odometry [Hz] (100).
        commandTopic, odometryTopic: cmd_vel, odom.
        robotNamespace: before their names.
    """

    def wheels(self, model: Model, sdf: Element) -> tuple[list[Joint], list[Joint]]:
        """The joints of the left and the right side."""
        return ros_joints(model, sdf, "leftJoint", "left_joint"), ros_joints(model, sdf, "rightJoint", "right_joint")


GZ_REGISTER_MODEL_PLUGIN(GazeboRosDiffDrive)
