"""gazebo_ros_skid_steer_drive: drives a model with four wheels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, ODOMETRY, Drive, drive_joint

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WHEELS = ("leftFrontJoint", "leftRearJoint", "rightFrontJoint", "rightRearJoint")


class GazeboRosSkidSteerDrive(Drive, Periodic, ModelPlugin):
    """Turns the wheels by their motors, and publishes the model's pose in the world as odometry."""

    STATE = ("command", "ticks")

    parameters = (
        *COMMANDS,
        Parameter("leftFrontJoint", "left_front_joint", "joint of a wheel"),
        Parameter("leftRearJoint", "left_rear_joint", "joint of a wheel"),
        Parameter("rightFrontJoint", "right_front_joint", "joint of a wheel"),
        Parameter("rightRearJoint", "right_rear_joint", "joint of a wheel"),
        Parameter("wheelSeparation", 0.4, "between left and right [m]"),
        Parameter("wheelDiameter", 0.15, "[m]"),
        Parameter("torque", 5.0, "of each motor [N m]"),
        Parameter("updateRate", Rate(100.0), "of commands and odometry [Hz]"),
        Parameter("broadcastTF", False, "publish the transform of the odometry"),
        Parameter("covarianceX", 1e-4, "variance of x; also covariance_x"),
        Parameter("covarianceY", 1e-4, "variance of y; also covariance_y"),
        Parameter("covarianceYaw", 1e-2, "variance of yaw; also covariance_yaw"),
    )
    endpoints = (COMMAND, *ODOMETRY)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        if not given.wheelDiameter > 0.0:
            raise ParameterError(f"{sdf.where}: <wheelDiameter> must be positive")
        self.joints = [drive_joint(model, getattr(given, tag), sdf.where, tag) for tag in WHEELS]
        for joint in self.joints:
            joint.SetParam("fmax", 0, given.torque)
        self.ticks = Ticks(given.updateRate)
        self.open_drive(model, (given.covarianceX, given.covarianceY, given.covarianceYaw), of_twist=True)
        self.advertise_odometry(transform=given.broadcastTF)
        self.lawful = not self.two
        self.run()

    def Reset(self) -> None:
        """Stop."""
        self.command.give()
        for joint in self.joints:
            joint.SetParam("fmax", 0, self.given.torque)

    @law
    def work(self, now: Any) -> None:
        """Publish; run the wheels."""
        if self.heard:
            motion = self.motion_in_world()
            self.publish_transforms(now, motion)
            self.publish_odometry(now, motion)
        ahead, half = self.command.ahead, self.command.turn * self.given.wheelSeparation / 2.0
        for joint, speed in zip(self.joints, (ahead - half, ahead - half, ahead + half, ahead + half), strict=True):
            joint.core.run_motor(speed / (self.given.wheelDiameter / 2.0))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosSkidSteerDrive)
