"""gazebo_ros_skid_steer_drive: drives a model with four wheels, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._ros import ros_joints
from libgz.classic.plugins._ros_drive import RosDrive

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element


class GazeboRosSkidSteerDrive(RosDrive):
    """Drives a model with four wheels, by its command topic or its position interface, as GazeboRosDiffDrive does.

    Elements:
        leftFrontJoint, leftRearJoint, rightFrontJoint, rightRearJoint: names of the wheels' joints (left_front_joint,
            left_rear_joint, right_front_joint, right_rear_joint).
        wheelSeparation, wheelDiameter: [m]; as built, if they are missing.
        torque: maximum torque of each wheel [N m] (5); also wheelTorque.
        updateRate: of commands and odometry [Hz] (100).
        commandTopic, odometryTopic: cmd_vel, odom.
        robotNamespace: before their names.
    """

    def wheels(self, model: Model, sdf: Element) -> tuple[list[Joint], list[Joint]]:
        """The joints of the left and the right side."""
        left, right = (
            [
                joint
                for end in ("Front", "Rear")
                for joint in ros_joints(model, sdf, f"{side}{end}Joint", f"{side}_{end.lower()}_joint")
            ]
            for side in ("left", "right")
        )
        return left, right


GZ_REGISTER_MODEL_PLUGIN(GazeboRosSkidSteerDrive)
