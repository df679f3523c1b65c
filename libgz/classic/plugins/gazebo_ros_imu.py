"""gazebo_ros_imu: publishes orientation, rate and acceleration of a link, without ROS."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import noisy, ros_elements, ros_rate, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosImu(ModelPlugin):
    """Publishes an IMU message for a link.

    It has the orientation in the world, and angular rate and specific force in the link's frame.

    Elements, also under their names in ROS 2 (update_rate, `<ros>` with namespace and remapping):
        bodyName: the link.
        topicName: (imu).
        xyzOffset, rpyOffset: added to the pose [m], [rad].
        gaussianNoise: standard deviation of rates and accelerations [rad/s], [m/s^2] (0).
        updateRate: [Hz] (0: every iteration).
        robotNamespace: before the topic's name.
    """

    STATE = ("rate",)

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and advertise."""
        sdf = ros_elements(sdf)
        self.world = model.GetWorld()
        self.link = named_link(model, sdf, "bodyName")
        self.offset = Pose3d(sdf.Get(Vector3d, "xyzOffset"), Quaterniond(*sdf.Get(Vector3d, "rpyOffset")))
        self.noise = sdf.Get(float, "gaussianNoise", 0.0)[0]
        self.rate = UpdateRate(ros_rate(model, sdf, 0.0))
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.IMU, ros_topic(model, sdf, "topicName", "imu"))
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def OnUpdate(self) -> None:
        """Publish, if it is time."""
        now = self.world.SimTime()
        if not self.rate.due(now.Double()):
            return
        turn = self.offset.Rot() * self.link.WorldPose().Rot()
        rate = turn.RotateVectorReverse(self.link.WorldAngularVel())
        force = turn.RotateVectorReverse(self.link.WorldLinearAccel() - self.world.Gravity())
        message = msgs.IMU(entity_name=self.link.GetScopedName())
        msgs.Set(message.stamp, now)
        msgs.Set(message.orientation, turn)
        msgs.Set(message.angular_velocity, noisy(rate, self.noise))
        msgs.Set(message.linear_acceleration, noisy(force, self.noise))
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosImu)
