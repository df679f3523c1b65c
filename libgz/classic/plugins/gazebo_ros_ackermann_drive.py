"""gazebo_ros_ackermann_drive: drives a car with two steered wheels, without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._ackermann import AckermannWheels
from libgz.classic.plugins._ros import PeriodicPlugin, ros_elements, ros_rate, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class AckermannDrive(PeriodicPlugin):
    """Drives the wheels of a car, by efforts that act in one iteration of each period, as in the original.

    The command topic takes a Pose: x of the position is the speed [m/s], yaw of the orientation the angle of a wheel in
    the middle between the front wheels, left positive [rad]. Odometry, the pose in the world, is a PoseStamped.

    Elements, beside those of AckermannWheels, as in ROS 2:
        update_rate: of efforts and odometry [Hz] (100); 0: each iteration.
        `<ros>` with namespace and remapping of cmd_vel and odom.
    """

    STATE = ("rate", "wheels")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: the wheels have no radius, or the axles are in one place.
        """
        sdf = ros_elements(sdf)
        self.model, self.world, self.clock = model, model.GetWorld(), model.GetWorld().core.clock
        self.wheels = AckermannWheels(model, sdf)
        self.rate = UpdateRate(ros_rate(model, sdf, 100.0))
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnCmd, kind="Pose")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Stop, with the wheels straight."""
        self.wheels.stop(self.world.SimTime().Double())
        self.rate.last = -math.inf

    def OnCmd(self, message: Any) -> None:
        """A new command."""
        self.wheels.obey(message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw())

    def publish(self, now: float) -> None:
        """Apply the efforts, and publish odometry."""
        self.wheels.drive(now)
        message = msgs.PoseStamped()
        msgs.Set(message.time, self.world.SimTime())
        msgs.Set(message.pose, self.model.WorldPose())
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(AckermannDrive)
