"""gazebo_ros_joint_state_publisher: publishes positions of joints, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._names import find_joint
from libgz.classic.plugins._ros import PeriodicPlugin, ros_elements, ros_rate, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosJointStatePublisher(PeriodicPlugin):
    """Publishes a Param_V: for each joint a Param with its name and position [rad] or [m].

    Elements, also under their names in ROS 2 (update_rate, `<ros>` with namespace and remapping):
        jointName: names of joints, separated by commas; none: all of the model.
        updateRate: [Hz] (100).
        robotNamespace: before the topic's name, joint_states.
    """

    STATE = ("rate",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the joints, and advertise."""
        sdf = ros_elements(sdf)
        names = [name.strip() for element in sdf.named("jointName") for name in element.Get(str).split(",")]
        self.joints = [find_joint(model, name) for name in names if name] or list(model.all_joints())
        self.rate = UpdateRate(ros_rate(model, sdf, 100.0))
        self.clock = model.GetWorld().core.clock
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Param_V, ros_topic(model, sdf, "topicName", "joint_states"))
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def publish(self, now: float) -> None:
        """Publish the positions."""
        message = msgs.Param_V()
        for joint in self.joints:
            if joint.DOF():
                param = message.param.add()
                param.name = joint.GetName()
                param.value.type, param.value.double_value = msgs.Any.DOUBLE, joint.Position(0)
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosJointStatePublisher)
