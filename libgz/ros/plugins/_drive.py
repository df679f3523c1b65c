"""What the drives have in common: commands, odometry, transforms."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError, nearest
from libgz.base.law import Number, cos, law, sin
from libgz.classic.plugins._planar import heading
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin, set_pose
from libgz.ros.session import finite, set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model

__all__ = ["COMMAND", "COMMANDS", "COVARIANCES", "ODOMETRY", "Drive", "EncoderPose", "drive_joint"]

COMMANDS = (
    Parameter("commandTopic", "cmd_vel", "commands"),
    Parameter("odometryTopic", "odom", "odometry"),
    Parameter("odometryFrame", "odom", "frame of the odometry"),
    Parameter("robotBaseFrame", "base_footprint", "frame of the robot in it"),
)
VARIANCES = (1e-5, 1e-5, 1e-3)  # of x, y [m^2] and yaw [rad^2]
COVARIANCES = tuple(
    Parameter(f"covariance{name}", value, f"in ROS 2: variance of {name.lower()}, of pose and twist")
    for name, value in zip(("X", "Y", "Yaw"), VARIANCES, strict=True)
)
COMMAND = Endpoint("subscribes", "<commandTopic>", "geometry_msgs/Twist")
ODOMETRY = (
    Endpoint("publishes", "<odometryTopic>", "nav_msgs/Odometry"),
    Endpoint("publishes", "/tf", "tf2_msgs/TFMessage"),
)
UNKNOWN = 1e12  # variance of what a robot on the ground does not measure


class EncoderPose:
    """A pose in the plane, summed up from the ways of two wheels."""

    STATE = ("x", "y", "yaw", "way", "turn", "last", "elapsed")

    x, y, yaw = Number(), Number(), Number()
    way, turn = Number(), Number()  # of the last move [m], [rad]
    last, elapsed = Number(), Number()  # its sim time, and how long it took [s]

    def __init__(self, now: float) -> None:
        self.last = now

    @law
    def move(self, now: Any, left: Any, right: Any, radius: float, separation: float) -> None:
        """Move by the rates of the wheels [rad/s] up to a sim time [s]."""
        elapsed = now - self.last
        left, right = left * radius * elapsed, right * radius * elapsed
        turn, way = (right - left) / separation, (left + right) / 2.0
        ahead = self.yaw + turn / 2.0
        self.x, self.y, self.yaw = self.x + way * cos(ahead), self.y + way * sin(ahead), self.yaw + turn
        self.way, self.turn, self.last, self.elapsed = way, turn, now, elapsed


class Drive(RosPlugin):
    """Takes commands, and publishes odometry.

    Attributes:
        command: the last command: x, y [m/s] and turn rate [rad/s].
        odometry: the message, filled by `measure_world` or by encoders.
    """

    command: tuple[float, ...] = (0.0, 0.0, 0.0)

    def open_drive(
        self, model: Model, variances: tuple[float, float, float] = VARIANCES, *, of_twist: bool = False
    ) -> None:
        """Subscribe and advertise.

        Args:
            model: the model.
            variances: of x, y and yaw of the pose.
            of_twist: whether they are those of the twist, too.
        """
        self.model, self.world = model, model.GetWorld()
        given = self.given
        self.odometry = message_type("nav_msgs/Odometry")()
        self.odometry.header.frame_id = self.frame(given.odometryFrame)
        self.odometry.child_frame_id = self.frame(given.robotBaseFrame)
        x, y, yaw = variances
        self.odometry.pose.covariance[::7] = (x, y, UNKNOWN, UNKNOWN, UNKNOWN, yaw)
        if of_twist:
            self.odometry.twist.covariance[:] = self.odometry.pose.covariance
        self.odometry.pose.pose.orientation.w = 1.0
        self.transforms = self.ros.transforms  # advertised at once, as the original does
        self.commands = self.subscribe(given.commandTopic, "geometry_msgs/Twist", self.OnCommand)

    @property
    def variances(self) -> tuple[float, float, float]:
        """Of x, y and yaw: in ROS 2, those of the parameters COVARIANCES."""
        given = self.given
        return (given.covarianceX, given.covarianceY, given.covarianceYaw) if self.two else VARIANCES

    def OnCommand(self, message: Any) -> None:
        """A new command."""
        if finite(message):
            self.command = message.linear.x, message.linear.y, message.angular.z
            self.commanded(self.world.core.GetSimTime())

    def commanded(self, now: float) -> None:
        """A command came at sim time `now` [s]."""

    def measure_world(self) -> None:
        """Take pose and velocities of the model in the world as odometry."""
        pose, velocity = self.model.WorldPose(), self.model.WorldLinearVel()
        set_pose(self.odometry.pose.pose, pose)
        twist, (cosine, sine) = self.odometry.twist.twist, heading(pose.Rot())
        twist.linear.x = cosine * velocity.X() + sine * velocity.Y()
        twist.linear.y = cosine * velocity.Y() - sine * velocity.X()
        twist.angular.z = self.model.WorldAngularVel().Z()

    def measure_encoders(self, pose: EncoderPose) -> None:
        """Take a pose of encoders, and its last move, as odometry."""
        message = self.odometry
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        place.x, place.y, place.z = pose.x, pose.y, 0.0
        turn.x, turn.y, turn.z, turn.w = 0.0, 0.0, math.sin(pose.yaw / 2.0), math.cos(pose.yaw / 2.0)
        if pose.elapsed > 0.0:
            message.twist.twist.linear.x = abs(pose.way) / pose.elapsed
            message.twist.twist.linear.y = 0.0
            message.twist.twist.angular.z = pose.turn / pose.elapsed

    def stamp(self, now: float) -> None:
        """Set the time of the odometry."""
        set_stamp(self.odometry.header.stamp, now)

    def send_odometry_transform(self) -> None:
        """Publish the pose of the odometry on /tf."""
        message = self.odometry
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        self.ros.send_transform(
            message.header.stamp,
            message.header.frame_id,
            message.child_frame_id,
            (place.x, place.y, place.z),
            (turn.x, turn.y, turn.z, turn.w),
        )

    def send_wheel_transforms(self, joints: list[Joint], of_joints: bool = False) -> None:
        """Publish the poses of wheels on /tf; their frames are named after them, or after their joints."""
        for joint in joints:
            pose = joint.GetChild().RelativePose()
            w, x, y, z = pose.Rot()
            self.ros.send_transform(
                self.odometry.header.stamp,
                self.frame(joint.GetParent().GetName()),
                self.frame((joint if of_joints else joint.GetChild()).GetName()),
                tuple(pose.Pos()),
                (x, y, z, w),
            )


def drive_joint(model: Model, name: str, where: str, tag: str) -> Joint:
    """A joint of the model.

    Raises:
        NotFoundError: there is none of this name.
    """
    joint = model.GetJoint(name)
    if joint is None:
        known = [one.GetName() for one in model.all_joints()]
        raise NotFoundError(
            f"{where}: <{tag}> is {name!r}; model {model.GetName()!r} has {', '.join(known) or 'none'}"
            f"{nearest(name, known)}"
        )
    return joint
