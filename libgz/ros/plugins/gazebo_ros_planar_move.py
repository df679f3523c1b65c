"""gazebo_ros_planar_move: moves a model in the plane, without wheels."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.law import law, rarely, unrecorded
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._planar import PlanarMotion
from libgz.ros.plugin import Parameter, Periodic, Rate, Ticks
from libgz.ros.plugins._drive import COMMAND, COMMANDS, COVARIANCES, ODOMETRY, Drive, Motion

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


class GazeboRosPlanarMove(Drive, Periodic, ModelPlugin):
    """Sets the velocity of a model, in ROS 1 in each iteration; odometry is its pose in the world.

    In ROS 1, odometry has a height of zero, and velocities by differences of poses; in ROS 2 it has those of the model.
    """

    STATE = ("motion", "moves", "ticks", "before", "then")

    parameters = (
        *COMMANDS,
        Parameter("updateRate", Rate(0.0), "in ROS 2: of velocities [Hz]; 0: each iteration", ros2=Rate(20.0)),
        Parameter("odometryRate", Rate(20.0), "of odometry [Hz] (in ROS 2 publish_rate); 0: none"),
        Parameter("publishTf", True, "in ROS 2 (publish_odom): publish odometry"),
        Parameter("publishOdomTF", True, "in ROS 2 (publish_odom_tf): publish its transform"),
        Parameter("cmdTimeout", -1.0, "the model stops when no command has come for this time [s]; negative: never"),
        *COVARIANCES,
    )
    endpoints = (COMMAND, *ODOMETRY)

    def Load(self, model: Model, sdf: Element) -> None:
        """Subscribe and advertise."""
        self.open(sdf, model.GetName())
        given = self.given
        self.ticks, self.moves = Ticks(given.odometryRate), Ticks(given.updateRate if self.two else 0.0)
        self.motion = PlanarMotion(model, given.cmdTimeout if given.cmdTimeout >= 0.0 else math.inf)
        self.open_drive(model, self.variances, of_twist=self.two)
        self.advertise_odometry(publish=given.publishTf or not self.two, transform=given.publishOdomTF or not self.two)
        self.velocity = (0.0, 0.0, 0.0)
        self.before, self.then = model.WorldPose(), self.world.core.GetSimTime()
        self.run()

    def Reset(self) -> None:
        """Stop."""
        self.motion.command(0.0, 0.0, 0.0, 0.0)
        self.before, self.then = self.model.WorldPose(), self.world.core.GetSimTime()

    def commanded(self, now: float) -> None:
        """A command came at sim time `now` [s]."""
        self.motion.command(self.command.ahead, self.command.aside, self.command.turn, now)

    @law
    def wanted(self) -> Any:
        """Whether there is odometry."""
        return self.given.odometryRate > 0.0

    @law
    def measure(self, now: Any) -> None:
        """Set the velocities, if it is time."""
        if self.moves.endless:
            self.motion.move(now)
        elif rarely(self.moves.is_due(now)):
            self._move(now)

    @unrecorded
    def _move(self, now: float) -> None:
        self.moves.due(now)
        self.motion.move(now)

    def work(self, now: float) -> None:
        """Publish odometry and its transform."""
        motion = self.motion_in_world() if self.two else self._differentiated(now)
        self.publish_transforms(now, motion)
        x, y, _ = motion.place
        self.publish_odometry(now, motion if self.two else motion._replace(place=(x, y, 0.0)))

    def _differentiated(self, now: float) -> Motion:
        """The pose, and the difference from the one before as its velocities."""
        pose, elapsed = self.model.WorldPose(), now - self.then
        (x, y, z), (w, i, j, k), yaw = pose.Pos(), pose.Rot(), pose.Rot().Yaw()
        if elapsed > 0.0:
            moved = (pose.Pos() - self.before.Pos()) / elapsed
            self.velocity = (
                math.cos(yaw) * moved.X() + math.sin(yaw) * moved.Y(),
                math.cos(yaw) * moved.Y() - math.sin(yaw) * moved.X(),
                math.remainder(yaw - self.before.Rot().Yaw(), 2.0 * math.pi) / elapsed,
            )
        self.before, self.then = pose, now
        return Motion((x, y, z), (i, j, k, w), self.velocity)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosPlanarMove)
