"""gazebo_ros_ft_sensor: force and torque of a joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError, ParameterError
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import find_joint, named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import NOISE, Endpoint, Parameter, Publishing, Rate, Ticks, set_point
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.math import Vector3d
    from libgz.classic.physics import Joint, Link, Model
    from libgz.sdf.element import Element


class GazeboRosFT(Publishing, ModelPlugin):
    """Publishes the wrench that a joint applies to its child, in the child's frame, which the message names.

    In ROS 2, `<body_name>` is a link, whose whole force and torque in the world are published.
    """

    STATE = ("ticks",)

    link: Link | None
    joint: Joint

    parameters = (
        Parameter("jointName", "", "the joint"),
        Parameter("bodyName", "", "or the joint's child; in ROS 2 a link"),
        Parameter("frameName", "world", "in ROS 2: frame in the message of a link's wrench"),
        Parameter("topicName", "wrench", "wrenches"),
        NOISE,
        Parameter("updateRate", Rate(0.0), "[Hz]; 0: each iteration"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "geometry_msgs/WrenchStamped"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joint, and advertise."""
        self.open(sdf, model.GetName())
        self.world, self.link = model.GetWorld(), None
        if self.two and self.given.bodyName:
            self.link = named_link(model, ros_elements(sdf), "bodyName")
            frame = self.given.frameName
        else:
            self.joint = self._joint(model, sdf)
            self.joint.SetProvideFeedback(True)
            frame = self.joint.GetChild().GetName()
        self.ticks = Ticks(self.given.updateRate)
        self.message = message_type("geometry_msgs/WrenchStamped")()
        self.message.header.frame_id = self.frame(frame)
        self.publication = self.advertise(self.given.topicName, "geometry_msgs/WrenchStamped")
        self.run()

    def _joint(self, model: Model, sdf: Element) -> Joint:
        if self.given.jointName:
            return find_joint(model, self.given.jointName)
        if not self.given.bodyName:
            raise ParameterError(f"{sdf.where}: <plugin> has no <jointName>: the joint")
        link = named_link(model, ros_elements(sdf), "bodyName")
        joints = link.GetParentJoints()
        if not joints:
            raise NotFoundError(f"{sdf.where}: <bodyName> is {link.GetName()!r}, which is no joint's child")
        return joints[0]

    def _measured(self) -> tuple[Vector3d, Vector3d]:
        """Force [N] and torque [N m]."""
        if self.link is not None:
            return self.link.WorldForce(), self.link.WorldTorque()
        wrench = self.joint.GetForceTorque(0)
        return wrench.body2Force, wrench.body2Torque

    def work(self, now: float) -> None:
        """Publish."""
        message, deviation = self.message, self.given.gaussianNoise
        force, torque = self._measured()
        set_stamp(message.header.stamp, now)
        set_point(message.wrench.force, force, deviation)
        set_point(message.wrench.torque, torque, deviation)
        self.publication.publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosFT)
