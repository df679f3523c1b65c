"""gazebo_ros_ft_sensor: publishes the force and torque of a joint, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_joint, named_link
from libgz.classic.plugins._ros import noisy, ros_elements, ros_rate, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Joint, Model
    from libgz.sdf.element import Element


class GazeboRosFT(ModelPlugin):
    """Publishes a WrenchStamped: `body2Force` and `body2Torque` of a joint's GetForceTorque, in the child's frame.

    A joint that carries the weight of its child upwards has a negative z.

    Elements, also under their names in ROS 2 (update_rate, `<ros>` with namespace and remapping):
        jointName: the joint; or bodyName, the child of it.
        topicName: (wrench).
        gaussianNoise: standard deviation [N], [N m] (0).
        updateRate: [Hz] (0: every iteration).
        robotNamespace: before the topic's name.
    """

    STATE = ("rate",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joint, and advertise.

        Raises:
            NotFoundError: there is no such joint or link, or the link is no joint's child.
        """
        sdf = ros_elements(sdf)
        self.world, self.joint = model.GetWorld(), self._joint(model, sdf)
        self.joint.SetProvideFeedback(True)
        self.noise = sdf.Get(float, "gaussianNoise", 0.0)[0]
        self.rate = UpdateRate(ros_rate(model, sdf, 0.0))
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.WrenchStamped, ros_topic(model, sdf, "topicName", "wrench"))
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def _joint(self, model: Model, sdf: Element) -> Joint:
        if sdf.HasElement("jointName"):
            return named_joint(model, sdf, "jointName")
        link = named_link(model, sdf, "bodyName")
        joints = link.GetParentJoints()
        if not joints:
            raise NotFoundError(f"{sdf.where}: <bodyName> is {link.GetName()!r}, which is no joint's child")
        return joints[0]

    def OnUpdate(self) -> None:
        """Publish, if it is time."""
        now = self.world.SimTime()
        if not self.rate.due(now.Double()):
            return
        wrench = self.joint.GetForceTorque(0)
        message = msgs.WrenchStamped()
        msgs.Set(message.time, now)
        msgs.Set(message.wrench.force, noisy(wrench.body2Force, self.noise))
        msgs.Set(message.wrench.torque, noisy(wrench.body2Torque, self.noise))
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosFT)
