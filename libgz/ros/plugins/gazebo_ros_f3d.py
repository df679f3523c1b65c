"""gazebo_ros_f3d: the force and torque on a link."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Publishing, Ticks, set_point
from libgz.ros.session import set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosF3D(Publishing, ModelPlugin):
    """Publishes the force and torque that are applied to a link, in the world's frame, each iteration."""

    STATE = ()

    parameters = (
        Parameter("bodyName", str, "the link"),
        Parameter("topicName", str, "wrenches"),
        Parameter("frameName", "world", "frame in the message"),
    )
    endpoints = (Endpoint("publishes", "<topicName>", "geometry_msgs/WrenchStamped"),)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and advertise."""
        self.open(sdf, model.GetName())
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "bodyName")
        self.ticks = Ticks(0.0)
        self.message = message_type("geometry_msgs/WrenchStamped")()
        self.message.header.frame_id = self.frame(self.given.frameName)
        self.publication = self.advertise(self.given.topicName, "geometry_msgs/WrenchStamped")
        self.run()

    def work(self, now: float) -> None:
        """Publish."""
        set_stamp(self.message.header.stamp, now)
        set_point(self.message.wrench.force, self.link.WorldForce())
        set_point(self.message.wrench.torque, self.link.WorldTorque())
        self.publication.publish(self.message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosF3D)
