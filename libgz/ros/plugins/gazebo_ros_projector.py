"""gazebo_ros_projector: passes switches and textures on to the topic of a projector."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

NAME = "texture_projector"


class GazeboRosProjector(RosPlugin, ModelPlugin):
    """Publishes msgs.Projector on the projector's topic of Gazebo; what projectors project is not rendered."""

    parameters = (
        Parameter("projector", "", "names of link and projector: link/projector"),
        Parameter("projectorTopicName", "", "1 and 0 switch it on and off"),
        Parameter("textureTopicName", "", "names of textures"),
        Parameter("projectorLink", "projector_link", "in ROS 2: the link"),
        Parameter("projectorName", "projector", "in ROS 2: the projector"),
    )
    endpoints = (
        Endpoint("subscribes", "<projectorTopicName>", "std_msgs/Int32"),
        Endpoint("subscribes", "<textureTopicName>", "std_msgs/String"),
        Endpoint("in ROS 2 subscribes", "switch", "std_msgs/Bool"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Advertise the projector's topic, and subscribe."""
        self.open(sdf, model.GetName())
        given = self.given
        place = f"{given.projectorLink}/{given.projectorName}" if self.two else given.projector
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Projector, f"~/{model.GetName()}/{place}")
        wanted = {
            given.projectorTopicName: ("std_msgs/Int32", self.OnSwitch),
            given.textureTopicName: ("std_msgs/String", self.OnTexture),
        }
        if self.two:
            wanted = {"switch": ("std_msgs/Bool", self.OnSwitch)}
        self.subscriptions = [self.subscribe(topic, *how) for topic, how in wanted.items() if topic]

    def OnSwitch(self, message: Any) -> None:
        """Switch it on or off."""
        self.publisher.Publish(msgs.Projector(name=NAME, enabled=bool(message.data)))

    def OnTexture(self, message: Any) -> None:
        """Give it another texture."""
        self.publisher.Publish(msgs.Projector(name=NAME, texture=message.data))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosProjector)
