"""gazebo_ros_tricycle_drive: drives a model with one driven and steered wheel."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.law import law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, ODOMETRY, Drive, EncoderPose, Motion, drive_joint
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosTricycleDrive(Drive, Periodic, ModelPlugin):
    """Turns and steers the front wheel: of a command, linear x is its speed [m/s], angular z its angle [rad]."""

    STATE = ("command", "ticks", "pose")

    own_namespace = True
    parameters = (
        *COMMANDS[:-1],
        Parameter("robotBaseFrame", "base_link", "frame of the robot in it"),
        Parameter("steeringJoint", "front_steering_joint", "steers the front wheel"),
        Parameter("actuatedWheelJoint", "front_wheel_joint", "turns the front wheel"),
        Parameter("encoderWheelLeftJoint", "left_wheel_joint", "of the left rear wheel"),
        Parameter("encoderWheelRightJoint", "right_wheel_joint", "of the right rear wheel"),
        Parameter("actuatedWheelDiameter", 0.15, "[m]"),
        Parameter("encoderWheelDiameter", 0.15, "[m]"),
        Parameter("encoderWheelSeparation", 0.5, "[m]"),
        Parameter("wheelSeparation", 0.0, "in ROS 2: as encoderWheelSeparation [m]"),
        Parameter("wheelTorque", 5.0, "of both motors [N m]", ros2=0.15),
        Parameter(
            "wheelAcceleration", 0.0, "most change of the wheel's rate where it sinks [rad/s^2]; in ROS 2, grows"
        ),
        Parameter("wheelDeceleration", 0.0, "the same where it grows; in ROS 2, sinks; 0: that of wheelAcceleration"),
        Parameter("wheelSpeedTolerance", 0.01, "[rad/s]"),
        Parameter("steeringSpeed", 0.0, "[rad/s]; 0: the angle is set at once"),
        Parameter("steeringAngleTolerance", 0.01, "[rad]"),
        Parameter("updateRate", Rate(100.0), "of commands and odometry [Hz]"),
        Parameter("odometrySource", "world", "world or encoder; in ROS 2, 1 or 0"),
        Parameter("publishTf", True, "in ROS 2 (publish_odom): publish odometry and its transform", ros2=False),
        Parameter("publishWheelTF", False, "publish the wheels' transforms"),
        Parameter("publishWheelJointState", False, "publish the wheels' joint states"),
    )
    endpoints = (COMMAND, *ODOMETRY, Endpoint("publishes", "joint_states", "sensor_msgs/JointState"))

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.steering, self.wheel, self.left, self.right = (
            drive_joint(model, getattr(given, tag), sdf.where, tag)
            for tag in ("steeringJoint", "actuatedWheelJoint", "encoderWheelLeftJoint", "encoderWheelRightJoint")
        )
        self.separation = given.wheelSeparation or given.encoderWheelSeparation
        if not (given.actuatedWheelDiameter > 0.0 and self.separation > 0.0):
            raise ParameterError(f"{sdf.where}: <actuatedWheelDiameter> and <encoderWheelSeparation> must be positive")
        for joint in (self.wheel, self.steering):
            joint.SetParam("fmax", 0, given.wheelTorque)
        self.encoders = given.odometrySource in ("encoder", "0")
        self.ticks, self.pose = Ticks(given.updateRate), EncoderPose(model.GetWorld().core.GetSimTime())
        self.open_drive(model)
        publishes = given.publishTf or not self.two
        joints = self.joints = [self.steering, self.wheel, self.left, self.right]
        wheels = joints if given.publishWheelTF else ()
        self.advertise_odometry(publish=publishes, transform=publishes, wheels=wheels, of_joints=True)
        self.joint_states = None
        if given.publishWheelJointState:
            self.joint_states = self.publish("joint_states", "sensor_msgs/JointState", 1000)
        self.run()

    def Reset(self) -> None:
        """Stop, with odometry at zero."""
        self.command.give()
        self.pose = EncoderPose(self.world.core.GetSimTime())

    @law
    def measure(self, now: Any) -> None:
        """Add the ways of the rear wheels since the last iteration."""
        if self.encoders:
            given = self.given
            # As in the original, whose worlds may have swapped the joints for it: turns to the left count to the right.
            right, left = (joint.GetVelocity(0) for joint in (self.left, self.right))
            self.pose.move(now, left, right, given.encoderWheelDiameter / 2.0, self.separation)

    def work(self, now: float) -> None:
        """Run the motors; publish."""
        if self.heard:
            motion = self._motion_of_wheels() if self.encoders else self.motion_in_world()
            self.publish_transforms(now, motion)
            self.publish_odometry(now, motion)
        joints = self.joints
        if self.joint_states is not None and self.joint_states.listened:
            message = message_type("sensor_msgs/JointState")()
            set_stamp(message.header.stamp, now)
            message.name = [joint.GetName() for joint in joints]
            message.position = [joint.Position(0) for joint in joints]
            message.velocity = [joint.GetVelocity(0) for joint in joints]
            message.effort = [joint.GetForce(0) for joint in joints]
            self.joint_states.publish(message)
        self._run(1.0 / self.given.updateRate if self.given.updateRate > 0.0 else self.world.core.engine.step_time)

    def _motion_of_wheels(self) -> Motion:
        """Encoders give the velocity in the frame of the odometry, as in the original."""
        pose, motion = self.pose, self.motion_of_encoders(self.pose)
        if pose.elapsed <= 0.0:
            return motion
        speed, ahead = pose.way / pose.elapsed, pose.yaw - pose.turn / 2.0
        return motion._replace(velocity=(speed * math.cos(ahead), speed * math.sin(ahead), motion.velocity[2]))

    def _run(self, period: float) -> None:
        """Set the speed of the wheel, and its angle."""
        given = self.given
        speed, angle = self.command.ahead, self.command.turn
        wanted, present = speed / (given.actuatedWheelDiameter / 2.0), self.wheel.GetVelocity(0)
        up, down = given.wheelAcceleration, given.wheelDeceleration or given.wheelAcceleration
        if up > 0.0 or (self.two and down > 0.0):
            if not self.two:  # ROS 1 has them the other way round
                up, down = down, up
            if abs(wanted - present) < given.wheelSpeedTolerance:
                wanted = present
            else:
                wanted = max(present - down * period, min(present + up * period, wanted))
        self.wheel.SetParam("vel", 0, wanted)
        angle = max(-math.pi / 2.0, min(math.pi / 2.0, angle))
        error = angle - self.steering.Position(0)
        if given.steeringSpeed > 0.0:
            turning = 0.0 if abs(error) < given.steeringAngleTolerance else math.copysign(given.steeringSpeed, error)
            self.steering.SetParam("vel", 0, turning)
        else:
            self.steering.SetPosition(0, angle, True)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosTricycleDrive)
