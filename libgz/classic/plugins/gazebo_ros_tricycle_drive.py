"""gazebo_ros_tricycle_drive: drives a model with one driven and steered wheel, without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._position_drive import positive
from libgz.classic.plugins._ros import PeriodicPlugin, ros_elements, ros_joints, ros_rate, ros_topic
from libgz.classic.plugins._wheels import radius_of
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosTricycleDrive(PeriodicPlugin):
    """Turns and steers the front wheel by motors.

    The command topic takes a Pose: x of the position is the speed of the front wheel [m/s], yaw of the orientation its
    angle, left positive [rad]. Odometry, the pose in the world, is published as a PoseStamped.

    Elements, also under their names in ROS 2 (`<ros>` with namespace and remapping):
        steeringJoint, actuatedWheelJoint: of the front wheel (front_steering_joint, front_wheel_joint).
        actuatedWheelDiameter: [m] (that of its shape); also wheelDiameter.
        wheelTorque: maximum torque of both motors [N m] (5).
        wheelAcceleration: most change of the speed [m/s^2] (0: at once).
        steeringSpeed: of the steering [rad/s] (1); also maxSteeringSpeed.
        steeringAngleTolerance: [rad] (0.01).
        updateRate: of commands and odometry [Hz] (100).
        commandTopic, odometryTopic: cmd_vel, odom.
        robotNamespace: before their names.
    """

    STATE = ("command", "speed", "rate")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: a torque, speed or diameter is not positive.
        """
        sdf = ros_elements(sdf)
        self.model = model
        (self.steering,) = ros_joints(model, sdf, "steeringJoint", "front_steering_joint")
        (self.wheel,) = ros_joints(model, sdf, "actuatedWheelJoint", "front_wheel_joint")
        diameters = ("actuatedWheelDiameter", "wheelDiameter")
        given = next((tag for tag in diameters if sdf.HasElement(tag)), diameters[0])
        self.radius = positive(sdf, given, 2.0 * radius_of(self.wheel.GetChild())) / 2.0
        self.torque = positive(sdf, "wheelTorque", 5.0)
        self.acceleration = sdf.Get(float, "wheelAcceleration", 0.0)[0]
        turning = "maxSteeringSpeed" if sdf.HasElement("maxSteeringSpeed") else "steeringSpeed"
        self.turning, self.tolerance = positive(sdf, turning, 1.0), positive(sdf, "steeringAngleTolerance", 0.01)
        rate = ros_rate(model, sdf, 100.0)
        self.rate, self.period = UpdateRate(rate), 1.0 / rate
        self.clock = model.GetWorld().core.clock
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(
            ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnVelMsg, kind="Pose"
        )
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self) -> None:
        """Stop, with the wheel straight."""
        self.command, self.speed = (0.0, 0.0), 0.0  # speed [m/s] and angle [rad]; the present speed
        self.rate.last = -math.inf

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        speed, angle = message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw()
        if math.isfinite(speed) and math.isfinite(angle):
            self.command = speed, angle

    def publish(self, now: float) -> None:
        """Set the motors, and publish odometry."""
        wanted, angle = self.command
        most = self.acceleration * self.period
        self.speed = max(self.speed - most, min(wanted, self.speed + most)) if most > 0.0 else wanted
        error = angle - self.steering.Position(0)
        turn = 0.0 if abs(error) < self.tolerance else max(-self.turning, min(self.turning, error / self.period))
        for joint, rate in ((self.wheel, self.speed / self.radius), (self.steering, turn)):
            joint.SetParam("fmax", 0, self.torque)
            joint.SetParam("vel", 0, rate)
        message = msgs.PoseStamped()
        msgs.Set(message.time, now)
        msgs.Set(message.pose, self.model.WorldPose())
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosTricycleDrive)
