"""gazebo_ros_force: applies forces of a topic to a link, without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements, ros_topic

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosForce(ModelPlugin):
    """Applies the last Wrench of a topic to a link in each iteration, until the next one comes.

    Elements, also under their names in ROS 2 (`<ros>` with namespace and remapping):
        bodyName: the link (link_name).
        topicName: of the wrench (gazebo_ros_force).
        forceFrame: world or link (world).
        robotNamespace: before the topic's name.
    """

    STATE = ("force", "torque")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and subscribe.

        Raises:
            NotFoundError: there is no such link.
            ParameterError: forceFrame is neither world nor link.
        """
        sdf = ros_elements(sdf)
        self.link = named_link(model, sdf, "linkName" if sdf.HasElement("linkName") else "bodyName")
        frame = sdf.Get(str, "forceFrame", "world")[0].strip()
        if frame not in ("world", "link"):
            raise ParameterError(f"{sdf.where}: <force_frame> is {frame!r}; it must be world or link")
        self.relative = frame == "link"
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.subscriber = self.node.Subscribe(
            ros_topic(model, sdf, "topicName", "gazebo_ros_force"), self.OnWrench, kind="Wrench"
        )
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self) -> None:
        """Apply nothing."""
        self.force, self.torque = Vector3d(), Vector3d()

    def OnWrench(self, message: msgs.Wrench) -> None:
        """A new wrench [N], [N m]."""
        force, torque = (msgs.ConvertIgn(part) for part in (message.force, message.torque))
        if all(map(math.isfinite, (*force, *torque))):
            self.force, self.torque = force, torque

    def OnUpdate(self, _info: Any) -> None:
        """Apply the wrench."""
        if self.force == Vector3d() and self.torque == Vector3d():
            return  # let the link sleep
        if self.relative:
            self.link.AddRelativeForce(self.force)
            self.link.AddRelativeTorque(self.torque)
        else:
            self.link.AddForce(self.force)
            self.link.AddTorque(self.torque)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosForce)
