"""gazebo_ros_diff_drive: drives a model with two wheels, or several on each side."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, ODOMETRY, Drive, EncoderPose, drive_joint
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element

REACHED = 0.01  # [m/s]; nearer to the wanted speed, the acceleration is not limited


class GazeboRosDiffDrive(Drive, Periodic, ModelPlugin):
    """Turns the wheels by their motors, and publishes odometry of the world or of the wheels."""

    STATE = ("command", "ticks", "pose", "speeds")

    own_namespace = True
    parameters = (
        *COMMANDS,
        Parameter("leftJoint", [], "joints of the left wheels (left_joint)"),
        Parameter("rightJoint", [], "joints of the right wheels (right_joint)"),
        Parameter("wheelSeparation", 0.34, "between left and right [m]"),
        Parameter("wheelDiameter", 0.15, "[m]"),
        Parameter("wheelAcceleration", 0.0, "most change of a wheel's speed [m/s^2]; 0: at once"),
        Parameter("wheelTorque", 5.0, "of each motor [N m]"),
        Parameter("updateRate", Rate(100.0), "of commands and odometry [Hz]"),
        Parameter("odometrySource", "world", "world or encoder; in ROS 2, 1 or 0"),
        Parameter("publishTf", True, "publish odometry (in ROS 2 publish_odom)", ros2=False),
        Parameter("publishOdomTF", True, "publish its transform (in ROS 2 publish_odom_tf)", ros2=False),
        Parameter("publishWheelTF", False, "publish the wheels' transforms"),
        Parameter("publishWheelJointState", False, "publish the wheels' joint states"),
    )
    endpoints = (COMMAND, *ODOMETRY, Endpoint("publishes", "joint_states", "sensor_msgs/JointState"))

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        source = {"0": "encoder", "1": "world"}.get(given.odometrySource, given.odometrySource)
        if source not in ("world", "encoder"):
            raise ParameterError(f"{sdf.where}: <odometrySource> is {source!r}; it must be world or encoder")
        if not (given.wheelSeparation > 0.0 and given.wheelDiameter > 0.0):
            raise ParameterError(f"{sdf.where}: <wheelSeparation> and <wheelDiameter> must be positive")
        self.encoders, self.radius = source == "encoder", given.wheelDiameter / 2.0
        left, right = given.leftJoint or ["left_joint"], given.rightJoint or ["right_joint"]
        self.left = [drive_joint(model, name, sdf.where, "leftJoint") for name in left]
        self.right = [drive_joint(model, name, sdf.where, "rightJoint") for name in right]
        for joint in (*self.left, *self.right):
            joint.SetParam("fmax", 0, given.wheelTorque)
        self.ticks, self.pose = Ticks(given.updateRate), EncoderPose(model.GetWorld().core.GetSimTime())
        self.speeds = (0.0, 0.0)
        self.open_drive(model, 1e-5, 1e-5, 1e-3)
        self.publication = self.publish(given.odometryTopic, "nav_msgs/Odometry") if given.publishTf else None
        self.joint_states = None
        if given.publishWheelJointState:
            self.joint_states = self.publish("joint_states", "sensor_msgs/JointState", 1000)
        self.run()

    def Reset(self) -> None:
        """Stop, with odometry at zero."""
        self.command, self.speeds = (0.0, 0.0, 0.0), (0.0, 0.0)
        self.pose = EncoderPose(self.world.core.GetSimTime())
        for joint in (*self.left, *self.right):
            joint.SetParam("fmax", 0, self.given.wheelTorque)

    @law
    def measure(self, now: Any) -> None:
        """Add the ways of the wheels since the last iteration."""
        if self.encoders:
            left, right = (joints[0].GetVelocity(0) for joints in (self.left, self.right))
            self.pose.move(now, left, right, self.radius, self.given.wheelSeparation)

    def work(self, now: float) -> None:
        """Run the wheels; publish."""
        self.stamp(now)
        self._publish()
        if self.given.publishWheelTF:
            self.send_wheel_transforms([*self.left, *self.right])
        if self.joint_states is not None and self.joint_states.listened:
            joints = [*self.right, *self.left]
            message = message_type("sensor_msgs/JointState")()
            message.header.stamp = self.odometry.header.stamp
            message.name = [joint.GetName() for joint in joints]
            message.position = [joint.Position(0) for joint in joints]
            self.joint_states.publish(message)
        self._run()

    def _publish(self) -> None:
        """Publish odometry and its transform to those who listen."""
        heard = self.publication is not None and self.publication.listened
        moves = self.given.publishOdomTF and self.transforms.listened
        if heard or moves:
            self.measure_encoders(self.pose) if self.encoders else self.measure_world()
        if moves:
            self.send_odometry_transform()
        if self.publication is not None and heard:
            self.publication.publish(self.odometry)

    def _run(self) -> None:
        """Set the speeds of the motors."""
        speed, _, turn = self.command
        half = turn * self.given.wheelSeparation / 2.0
        wanted = speed - half, speed + half
        present = tuple(joints[0].GetVelocity(0) * self.radius for joints in (self.left, self.right))
        most = self.given.wheelAcceleration / self.given.updateRate if self.given.updateRate > 0.0 else 0.0
        if most > 0.0 and all(abs(want - is_) >= REACHED for want, is_ in zip(wanted, present, strict=True)):
            changes = (max(-most, min(most, want - is_)) for want, is_ in zip(wanted, present, strict=True))
            left, right = (before + change for before, change in zip(self.speeds, changes, strict=True))
            self.speeds = left, right
        else:
            self.speeds = wanted
        for joints, at in zip((self.left, self.right), self.speeds, strict=True):
            _run_all(joints, at / self.radius)


def _run_all(joints: list[Joint], rate: float) -> None:
    for joint in joints:
        joint.SetParam("vel", 0, rate)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosDiffDrive)
