"""gazebo_ros_ackermann_drive: drives a car with two steered wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._ackermann import AckermannDrive
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, ODOMETRY, Drive
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosAckermannDrive(Drive, AckermannDrive):
    """An AckermannDrive, with its elements: takes a speed and the angle of a wheel in the middle, angular z [rad]."""

    STATE = ("command", "ticks", "pids", "last", "travelled")

    parameters = (
        *COMMANDS,
        Parameter("updateRate", Rate(100.0), "of odometry [Hz]"),
        Parameter("publishTf", False, "publish odometry (in ROS 2 publish_odom)"),
        Parameter("publishOdomTF", False, "publish its transform"),
        Parameter("publishWheelTF", False, "publish the wheels' transforms"),
        Parameter("publishDistance", False, "publish the way that was travelled"),
        Parameter("publishSteerangle", False, "publish the angle of a wheel in the middle"),
    )
    endpoints = (
        COMMAND,
        *ODOMETRY,
        Endpoint("publishes", "distance", "std_msgs/Float32"),
        Endpoint("publishes", "steerangle", "std_msgs/Float32"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, subscribe and advertise.

        Raises:
            NotFoundError: there is no such joint.
            ParameterError: the wheels have no radius, or the axles are in one place.
        """
        self.open(sdf, model.GetName())
        self.find(model, ros_elements(sdf))
        given = self.given
        self.ticks, self.travelled = Ticks(given.updateRate), 0.0
        self.Reset()
        self.open_drive(model, 1e-5, 1e-5, 1e-3)
        self.publication = self.publish(given.odometryTopic, "nav_msgs/Odometry") if given.publishTf else None
        self.distances = self.publish("distance", "std_msgs/Float32") if given.publishDistance else None
        self.turns = self.publish("steerangle", "std_msgs/Float32") if given.publishSteerangle else None
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Stop, with the wheels straight."""
        self.command, self.last, self.travelled = (0.0, 0.0), 0.0, 0.0
        for pid in self.pids:
            pid.Reset()

    def OnCommand(self, message: Any) -> None:
        """A new command; backwards, the angle has the other sign."""
        self.obey(message.linear.x, math.copysign(1.0, message.linear.x) * message.angular.z)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Apply the efforts; publish, if it is time."""
        now = info.simTime.Double()
        rate = sum(joint.GetVelocity(0) for joint in self.rear) / 2.0
        self.travelled += abs(rate) * self.radius * max(now - self.last, 0.0)
        self.drive(now)
        if not self.ticks.due(now):
            return
        self.stamp(now)
        self.measure_world()
        if self.publication is not None and self.publication.listened:
            self.publication.publish(self.odometry)
        if self.given.publishOdomTF:
            self.send_odometry_transform()
        if self.given.publishWheelTF:
            self.send_wheel_transforms([*self.rear, *self.steered])
        number = message_type("std_msgs/Float32")
        if self.distances is not None and self.distances.listened:
            self.distances.publish(number(data=self.travelled))
        if self.turns is not None and self.turns.listened:
            self.turns.publish(number(data=sum(joint.Position(0) for joint in self.steered) / 2.0))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosAckermannDrive)
