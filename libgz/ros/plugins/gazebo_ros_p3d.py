"""gazebo_ros_p3d: the true pose and velocities of a link."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import NotFoundError
from libgz.base.law import law
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.packed import PackedMessage
from libgz.ros.plugin import (
    NOISE,
    OFFSETS,
    Endpoint,
    Parameter,
    Publishing,
    Rate,
    Ticks,
    noisy,
)
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WORLD = ("", "world", "map", "/map", "/world")  # names of the world's frame


class GazeboRosP3D(Publishing, ModelPlugin):
    """Publishes pose and velocities of a link in the world, or relative to another link. Noise is on the velocities."""

    STATE = ("ticks",)

    parameters = (
        Parameter("bodyName", str, "the link"),
        Parameter("topicName", str, "the poses", ros2="odom"),
        Parameter("frameName", "world", "the world, or a link of the model whose frame they are in"),
        Parameter("updateRate", Rate(0.0), "[Hz]; 0: each iteration"),
        NOISE,
        *OFFSETS,
        Parameter("xyzOffsets", Vector3d(), "in ROS 2: as xyzOffset"),
        Parameter("rpyOffsets", Vector3d(), "in ROS 2: as rpyOffset"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "nav_msgs/Odometry"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the links, and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "bodyName")
        self.reference = None if given.frameName in WORLD else model.GetLink(given.frameName)
        if self.reference is None and given.frameName not in WORLD:
            names = ", ".join(link.GetName() for link in model.family_links())
            raise NotFoundError(f"{sdf.where}: <frameName> is {given.frameName!r}; it must be world or one of {names}")
        place = given.xyzOffset + given.xyzOffsets
        self.offset, self.turn = place, Quaterniond(*(given.rpyOffset + given.rpyOffsets))
        self.placed_elsewhere = any(place) or any(given.rpyOffset + given.rpyOffsets)
        self.ticks = Ticks(given.updateRate)
        message = message_type("nav_msgs/Odometry")()
        message.header.frame_id, message.child_frame_id = self.frame(given.frameName), given.bodyName
        message.pose.covariance[::7] = message.twist.covariance[::7] = given.gaussianNoise**2
        publication = self.advertise(given.topicName, "nav_msgs/Odometry", 5 if self.two else 1)
        self.message = PackedMessage(publication, message)
        alone = self.reference is None and given.gaussianNoise <= 0.0
        self.lawful = alone and not self.two and not model.IsStatic()
        self.run()

    @law
    def work(self, now: Any) -> None:
        """Publish."""
        pose = self.link.WorldPose()
        linear, angular = self.link.WorldLinearVel(), self.link.WorldAngularVel()
        place, turn = pose.Pos(), pose.Rot()
        if self.reference is not None:
            frame = self.reference.WorldPose()
            place = frame.Rot().RotateVectorReverse(place - frame.Pos())
            turn = turn * frame.Rot().Inverse()
            linear = frame.Rot().RotateVector(linear - self.reference.WorldLinearVel())
            angular = frame.Rot().RotateVector(angular - self.reference.WorldAngularVel())
        if self.placed_elsewhere:
            place, turn = place + self.offset, self.turn * turn
        message, (w, x, y, z) = self.message, turn
        message.stamp(now)
        message.put("pose.pose", (*place, x, y, z, w))
        message.put("twist.twist", noisy((*linear, *angular), self.given.gaussianNoise))
        message.send()


GZ_REGISTER_MODEL_PLUGIN(GazeboRosP3D)
