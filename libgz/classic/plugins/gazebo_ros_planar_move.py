"""gazebo_ros_planar_move: moves a model in the plane, without wheels and without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond, Vector3d
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._ros import ros_elements, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosPlanarMove(ModelPlugin):
    """Sets the velocity of a model in each iteration: forward and to the left [m/s], and its turn rate [rad/s].

    Its velocity up or down and its other turn rates are set to zero, so that it neither falls nor tilts.
    The command topic takes a Pose: x and y of the position, yaw of the orientation. Odometry, the pose in the world, is
    published as a PoseStamped.

    Elements, also under their names in ROS 2 (`<ros>` with namespace and remapping):
        commandTopic, odometryTopic: cmd_vel, odom.
        odometryRate: of odometry [Hz] (20); also publishRate.
        cmdTimeout: the model stops when no command has come for this time [s] (0: never).
        robotNamespace: before their names.
    """

    STATE = ("command", "time", "rate")

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe and advertise."""
        sdf = ros_elements(sdf)
        self.model, self.world = model, model.GetWorld()
        rate = sdf.Get(float, "publishRate", 20.0)[0]
        self.rate = UpdateRate(sdf.Get(float, "odometryRate", rate)[0])
        self.timeout = sdf.Get(float, "cmdTimeout", 0.0)[0]
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnVelMsg)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self) -> None:
        """Stop."""
        self.command, self.time = (0.0, 0.0, 0.0), 0.0  # forward, left [m/s], turn [rad/s]; when it came [s]
        self.rate.last = -math.inf

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        turn = Quaterniond(ConvertIgn(message.orientation)).Yaw()
        command = (message.position.x, message.position.y, turn)
        if all(map(math.isfinite, command)):
            self.command, self.time = command, self.world.SimTime().Double()

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Set the velocities; publish odometry, if it is time."""
        now, pose = info.simTime.Double(), self.model.WorldPose()
        if self.timeout > 0.0 and now - self.time > self.timeout:
            self.command = (0.0, 0.0, 0.0)
        forward, left, turn = self.command
        cosine, sine = math.cos(pose.Yaw()), math.sin(pose.Yaw())
        self.model.SetLinearVel(Vector3d(forward * cosine - left * sine, forward * sine + left * cosine, 0.0))
        self.model.SetAngularVel(Vector3d(0.0, 0.0, turn))
        if self.rate.due(now):
            message = msgs.PoseStamped()
            msgs.Set(message.time, info.simTime)
            msgs.Set(message.pose, pose)
            self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosPlanarMove)
