"""gazebo_ros_vacuum_gripper: a link that pulls links near it, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements, ros_topic

if TYPE_CHECKING:
    from collections.abc import Iterator

    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element

STRONGEST = 20.0  # [N]


class GazeboRosVacuumGripper(ModelPlugin):
    """While it is on, a force of 1 N m / distance, at most 20 N, pulls links of other models towards its own link.

    They take over its velocity. The switch topic takes an Int, 0 or 1; the grasping topic has an Int, 1 while a link is
    within reach.

    Elements, also under their names in ROS 2 (`<ros>` with namespace and remapping):
        bodyName: the link (link_name).
        fixed: names of models that are left alone, several.
        maxDistance: how near the origins of links must be [m] (0.05).
        topicName: of the grasping state (grasping); the switch is on the topic switch.
        robotNamespace: before their names.
    """

    STATE = ("enabled", "grasping")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, subscribe and advertise.

        Raises:
            NotFoundError: there is no such link.
        """
        sdf = ros_elements(sdf)
        self.model, self.world = model, model.GetWorld()
        self.link = named_link(model, sdf, "linkName" if sdf.HasElement("linkName") else "bodyName")
        self.fixed = {model.GetName(), *(element.Get(str).strip() for element in sdf.named("fixed"))}
        self.reach = sdf.Get(float, "maxDistance", 0.05)[0]
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.Int, ros_topic(model, sdf, "topicName", "grasping"))
        self.subscriber = self.node.Subscribe(ros_topic(model, sdf, "switchTopic", "switch"), self.OnSwitch, kind="Int")
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self) -> None:
        """Switch it off."""
        self.enabled, self.grasping = False, False

    def OnSwitch(self, message: Any) -> None:
        """Switch it on or off."""
        self.enabled = bool(message.data)

    def _near(self) -> Iterator[tuple[Link, Any]]:
        """Links within reach, with the vector to the gripper [m]."""
        place = self.link.WorldPose().Pos()
        for model in self.world.Models():
            if model.GetName() not in self.fixed and not model.IsStatic():
                for link in model.GetLinks():
                    way = place - link.WorldPose().Pos()
                    if way.Length() <= self.reach:
                        yield link, way

    def OnUpdate(self, _info: Any) -> None:
        """Apply the forces, and publish whether a link is held."""
        found = list(self._near()) if self.enabled else []
        for link, way in found:
            distance = way.Length()
            link.SetWorldTwist(self.link.WorldLinearVel(), self.link.WorldAngularVel())
            if distance > 0.0:
                link.AddForce(way * (min(STRONGEST, 1.0 / distance) / distance))
        if bool(found) != self.grasping:
            self.grasping = bool(found)
            self.publisher.Publish(msgs.Int(data=int(self.grasping)))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosVacuumGripper)
