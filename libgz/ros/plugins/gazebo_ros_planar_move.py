"""gazebo_ros_planar_move: moves a model in the plane, without wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.classic.event import Events
from libgz.classic.math import Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.ros.plugin import Parameter, Rate, Ticks, set_pose
from libgz.ros.plugins._drive import COMMAND, COMMANDS, ODOMETRY, Drive

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosPlanarMove(Drive, ModelPlugin):
    """Sets the velocity of a model in each iteration; odometry is its pose in the world, with z at zero."""

    STATE = ("command", "time", "ticks", "before", "then")

    parameters = (
        *COMMANDS,
        Parameter("odometryRate", Rate(20.0), "of odometry [Hz]; 0: none"),
        Parameter("cmdTimeout", -1.0, "the model stops when no command has come for this time [s]; negative: never"),
    )
    endpoints = (COMMAND, *ODOMETRY)

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe and advertise."""
        self.open(sdf, model.GetName())
        self.ticks, self.time = Ticks(self.given.odometryRate), 0.0
        self.open_drive(model, 1e-5, 1e-5, 1e-3)
        self.publication = self.publish(self.given.odometryTopic, "nav_msgs/Odometry")
        self.before, self.then = model.WorldPose(), self.world.core.GetSimTime()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Stop."""
        self.command, self.time = (0.0, 0.0, 0.0), 0.0
        self.before, self.then = self.model.WorldPose(), self.world.core.GetSimTime()

    def commanded(self, now: float) -> None:
        """A command came at sim time `now` [s]."""
        self.time = now

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Set the velocities; publish odometry, if it is time."""
        now, pose = self.world.core.GetSimTime(), self.model.WorldPose()
        if self.given.cmdTimeout >= 0.0 and now - self.time > self.given.cmdTimeout:
            self.command = (0.0, 0.0, 0.0)
        forward, left, turn = self.command
        yaw = pose.Rot().Yaw()
        cosine, sine = math.cos(yaw), math.sin(yaw)
        self.model.SetLinearVel(Vector3d(forward * cosine - left * sine, left * cosine + forward * sine, 0.0))
        self.model.SetAngularVel(Vector3d(0.0, 0.0, turn))
        if self.given.odometryRate > 0.0 and self.ticks.due(now):
            self._publish(now)

    def _publish(self, now: float) -> None:
        pose, elapsed = self.model.WorldPose(), now - self.then
        self.stamp(now)
        message, yaw = self.odometry, pose.Rot().Yaw()
        set_pose(message.pose.pose, pose)
        self.send_odometry_transform()
        message.pose.pose.position.z = 0.0
        if elapsed > 0.0:
            moved = (pose.Pos() - self.before.Pos()) / elapsed
            twist = message.twist.twist
            twist.linear.x = math.cos(yaw) * moved.X() + math.sin(yaw) * moved.Y()
            twist.linear.y = math.cos(yaw) * moved.Y() - math.sin(yaw) * moved.X()
            twist.angular.z = math.remainder(yaw - self.before.Rot().Yaw(), 2.0 * math.pi) / elapsed
        self.before, self.then = pose, now
        if self.publication.listened:
            self.publication.publish(message)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosPlanarMove)
