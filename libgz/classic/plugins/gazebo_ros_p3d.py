"""gazebo_ros_p3d: publishes the true pose of a link, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import PeriodicPlugin, noisy, ros_elements, ros_rate, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WORLD = ("", "world", "map", "/map", "/world")  # names of the world's frame


class GazeboRosP3D(PeriodicPlugin):
    """Publishes the pose of a link as a PoseStamped.

    Elements, also under their names in ROS 2 (update_rate, `<ros>` with namespace and remapping):
        bodyName: the link.
        topicName: of the pose (odom).
        frameName: the world, or a link of the model whose frame the pose is in (world).
        xyzOffset, rpyOffset: added to it [m], [rad]; also xyzOffsets, rpyOffsets.
        gaussianNoise: standard deviation of each coordinate [m] (0).
        updateRate: [Hz] (0: every iteration).
        robotNamespace: before the topic's name.
    """

    STATE = ("rate",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the links, and advertise.

        Raises:
            NotFoundError: there is no such link.
        """
        sdf = ros_elements(sdf)
        self.link, frame = named_link(model, sdf, "bodyName"), sdf.Get(str, "frameName").strip()
        self.frame = None if frame in WORLD else model.GetLink(frame)
        if self.frame is None and frame not in WORLD:
            names = ", ".join(link.GetName() for link in model.family_links())
            raise NotFoundError(f"{sdf.where}: <frameName> is {frame!r}; it must be world or one of {names}")
        place, turn = (
            sdf.Get(Vector3d, f"{name}Offsets" if sdf.HasElement(f"{name}Offsets") else f"{name}Offset")
            for name in ("xyz", "rpy")
        )
        self.offset = Pose3d(place, Quaterniond(*turn))
        self.noise = sdf.Get(float, "gaussianNoise", 0.0)[0]
        self.rate = UpdateRate(ros_rate(model, sdf, 0.0))
        self.clock = model.GetWorld().core.clock
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "topicName", "odom"))
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def publish(self, now: float) -> None:
        """Publish the pose."""
        pose = self.link.WorldPose()
        if self.frame is not None:
            pose = pose - self.frame.WorldPose()
        place = noisy(pose.Pos() + self.offset.Pos(), self.noise)
        message = msgs.PoseStamped()
        msgs.Set(message.time, now)
        msgs.Set(message.pose, Pose3d(place, self.offset.Rot() * pose.Rot()))
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosP3D)
