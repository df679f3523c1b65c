"""TrackedVehiclePlugin: base class of plugins that drive a vehicle on two tracks."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Quaterniond
from libgz.classic.msgs import ConvertIgn
from libgz.classic.plugin import ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.sdf.element import Element

__all__ = ["TrackedVehiclePlugin"]


class TrackedVehiclePlugin(ModelPlugin):
    """Receives commands, and computes the speeds of both tracks.

    ~/<namespace>/cmd_vel_twist takes a Twist: linear.x is the speed [m/s], angular.z the turn rate [rad/s];
    ~/<namespace>/cmd_vel a Pose in its place. As in Gazebo, **a positive rate turns to the right**: the left track runs
    with speed + rate * separation / (2 * efficiency). ~/<namespace>/tracks_speed has the speeds, a Vector2d of left and
    right [m/s], when they change. A command is valid until the next one.

    Elements:
        robot_namespace: of the topics (the model's name).
        steering_efficiency: share of the difference of the tracks' speeds that becomes rotation (0.5).
        tracks_separation: [m] (0.4).
        max_linear_speed: of the vehicle and of each track [m/s] (1).
        max_angular_speed: [rad/s] (1).
        track_mu, track_mu2: friction coefficients along and across the tracks; by default those of the file.
    """

    STATE: ClassVar[tuple[str, ...]] = ("speeds",)

    speeds = (0.0, 0.0)  # of the left and the right track [m/s]

    def listen(self, model: Model, sdf: Element) -> None:
        """Read the common elements, and subscribe.

        Raises:
            ParameterError: a number is out of its range.
        """
        space = self.LoadParam(sdf, "robot_namespace", model.GetName()).strip("/")
        self.efficiency = self.LoadParam(sdf, "steering_efficiency", 0.5)
        self.separation = self.LoadParam(sdf, "tracks_separation", 0.4)
        self.fastest = self.LoadParam(sdf, "max_linear_speed", 1.0)
        self.fastest_turn = self.LoadParam(sdf, "max_angular_speed", 1.0)
        for what, value in (
            ("Steering efficiency", self.efficiency),
            ("Tracks separation", self.separation),
            ("Maximum linear speed", self.fastest),
        ):
            if not value > 0.0:
                raise ParameterError(f"{sdf.where}: {what} must be positive; it is {value:g}")
        if not self.fastest_turn >= 0.0:
            raise ParameterError(
                f"{sdf.where}: Maximum angular speed must be non-negative; it is {self.fastest_turn:g}"
            )
        self.friction = [
            sdf.Get(float, tag) if sdf.HasElement(tag) else None for tag in ("track_mu", "track_mu2")
        ]  # along and across
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Vector2d, f"~/{space}/tracks_speed")
        self.subscribers = [
            self.node.Subscribe(f"~/{space}/cmd_vel", self.OnVelMsg, kind="Pose"),
            self.node.Subscribe(f"~/{space}/cmd_vel_twist", self.OnTwistMsg, kind="Twist"),
        ]
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def set_friction(self, link: Link) -> None:
        """Give the collisions of a track or wheel the friction of the file."""
        for collision in link.GetCollisions():
            pyramid = collision.GetSurface().FrictionPyramid()
            for value, setter in zip(self.friction, (pyramid.SetMuPrimary, pyramid.SetMuSecondary), strict=True):
                if value is not None:
                    setter(value)

    def OnVelMsg(self, message: Any) -> None:
        """A new command, as a Pose."""
        self._drive(message.position.x, Quaterniond(ConvertIgn(message.orientation)).Yaw())

    def OnTwistMsg(self, message: Any) -> None:
        """A new command, as a Twist."""
        self._drive(message.linear.x, message.angular.z)

    def _drive(self, speed: float, turn: float) -> None:
        if not (math.isfinite(speed) and math.isfinite(turn)):
            return
        speed, turn = _limited(speed, self.fastest), _limited(turn, self.fastest_turn)
        half = turn * self.separation / 2.0 / self.efficiency
        self.speeds = _limited(speed + half, self.fastest), _limited(speed - half, self.fastest)
        self.publisher.Publish(msgs.Vector2d(x=self.speeds[0], y=self.speeds[1]))

    def Reset(self) -> None:
        """Stop."""
        self.speeds = (0.0, 0.0)

    def OnUpdate(self) -> None:
        """Run the tracks; called in every iteration."""
        raise NotImplementedError


def _limited(value: float, most: float) -> float:
    return min(max(value, -most), most)
