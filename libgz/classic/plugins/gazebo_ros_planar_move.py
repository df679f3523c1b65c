"""gazebo_ros_planar_move: moves a model in the plane, without wheels and without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import law, rarely, unrecorded
from libgz.classic import msgs, transport
from libgz.classic.common.time import sim_nanoseconds
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._planar import PlanarMotion
from libgz.classic.plugins._ros import ros_elements, ros_topic
from libgz.simulation.rate import UpdateRate

if TYPE_CHECKING:
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

    STATE = ("motion", "rate")

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe and advertise."""
        sdf = ros_elements(sdf)
        self.model, self.world = model, model.GetWorld()
        rate = sdf.Get(float, "publishRate", 20.0)[0]
        self.rate = UpdateRate(sdf.Get(float, "odometryRate", rate)[0])
        timeout: float = sdf.Get(float, "cmdTimeout", 0.0)[0]
        self.motion = PlanarMotion(model, timeout if timeout > 0.0 else math.inf)
        self.clock = self.world.core.clock
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        self.publisher = self.node.Advertise(msgs.PoseStamped, ros_topic(model, sdf, "odometryTopic", "odom"))
        self.subscriber = self.node.Subscribe(
            ros_topic(model, sdf, "commandTopic", "cmd_vel"), self.OnVelMsg, kind="Pose"
        )
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
        self.Reset()

    def Reset(self) -> None:
        """Stop."""
        self.motion.command(0.0, 0.0, 0.0, 0.0)
        self.rate.last = -math.inf

    def OnVelMsg(self, message: Any) -> None:
        """A new command."""
        turn = Quaterniond(ConvertIgn(message.orientation)).Yaw()
        command = (message.position.x, message.position.y, turn)
        if all(map(math.isfinite, command)):
            self.motion.command(*command, self.world.SimTime().Double())

    @law
    def OnUpdate(self) -> None:
        """Set the velocities; publish odometry, if it is time."""
        now = sim_nanoseconds(self.clock) / 1e9
        self.motion.move(now)
        if rarely(self.rate.is_due(now)):
            self._publish(now)

    @unrecorded
    def _publish(self, now: float) -> None:
        self.rate.due(now)
        message = msgs.PoseStamped()
        msgs.Set(message.time, self.world.SimTime())
        msgs.Set(message.pose, self.model.WorldPose())
        self.publisher.Publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosPlanarMove)
