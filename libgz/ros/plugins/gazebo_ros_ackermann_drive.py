"""gazebo_ros_ackermann_drive: drives a car with two steered wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import Number, hypot, law
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._ackermann import AckermannWheels
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, COVARIANCES, ODOMETRY, Drive, send_transform
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosAckermannDrive(Drive, Periodic, ModelPlugin):
    """Drives AckermannWheels, with their elements: linear x is the speed, angular z the angle of a wheel in the middle.

    Efforts act in one iteration of each period, as in the original.
    """

    STATE = ("wheels", "ticks", "x", "y", "travelled")

    x, y = Number(), Number()  # of the last iteration [m]
    travelled = Number()  # [m]

    parameters = (
        *COMMANDS,
        Parameter("updateRate", Rate(100.0), "of efforts and odometry [Hz]"),
        Parameter("publishTf", False, "publish odometry (in ROS 2 publish_odom)"),
        Parameter("publishOdomTF", False, "publish its transform"),
        Parameter("publishWheelTF", False, "publish the wheels' transforms"),
        Parameter("publishDistance", False, "publish the way that was travelled"),
        Parameter("publishSteerangle", False, "publish the angle of a wheel in the middle"),
        *COVARIANCES,
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
        self.wheels = AckermannWheels(model, ros_elements(sdf))
        given = self.given
        self.ticks = Ticks(given.updateRate)
        self.open_drive(model, self.variances, of_twist=self.two)
        self.advertise_odometry(publish=given.publishTf, transform=given.publishOdomTF)
        links = [joint.GetChild() for joint in self.wheels.joints] if given.publishWheelTF else []
        base = self.odometry.child_frame_id
        self.frames = [
            (link, self.ros.pack_transform(base, self.frame(link.GetName()), node=self.own_node)) for link in links
        ]
        self.distances = self.publish("distance", "std_msgs/Float32") if given.publishDistance else None
        self.turns = self.publish("steerangle", "std_msgs/Float32") if given.publishSteerangle else None
        self.Reset()
        self.run()

    def Reset(self) -> None:
        """Stop, with the wheels straight."""
        self.wheels.stop(self.world.core.GetSimTime())
        self.x, self.y, _ = self.model.WorldPose().Pos()
        self.travelled = 0.0

    def OnCommand(self, message: Any) -> None:
        """A new command; backwards, the angle has the other sign."""
        self.wheels.obey(message.linear.x, math.copysign(1.0, message.linear.x) * message.angular.z)

    @law
    def measure(self, now: Any) -> None:
        """Add the way in the plane since the last iteration."""
        if self.distances is not None:
            x, y, _ = self.model.WorldPose().Pos()
            self.travelled = self.travelled + hypot(x - self.x, y - self.y)
            self.x, self.y = x, y

    def work(self, now: float) -> None:
        """Publish, and apply the efforts."""
        number = message_type("std_msgs/Float32")
        if self.distances is not None and self.distances.listened:
            self.distances.publish(number(data=self.travelled))
        if self.heard:
            motion = self.motion_in_world()
            self.publish_odometry(now, motion)
            self.publish_transforms(now, motion)
        if self.transforms.listened:
            self._send_wheel_transforms(now)
        if self.turns is not None and self.turns.listened:
            self.turns.publish(number(data=self.wheels.angle()))
        self.wheels.drive(now)

    def _send_wheel_transforms(self, now: float) -> None:
        """Publish the poses of wheels, and of what steers them, in the frame of the robot."""
        base = self.model.WorldPose()
        for link, message in self.frames:
            pose = link.WorldPose() - base
            w, x, y, z = pose.Rot()
            send_transform(message, now, pose.Pos(), (x, y, z, w))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosAckermannDrive)
