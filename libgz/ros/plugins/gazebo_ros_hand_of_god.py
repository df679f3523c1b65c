"""gazebo_ros_hand_of_god: pulls a link to a frame of TF, as a spring and a damper do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, RosPlugin
from libgz.ros.session import finite, set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WORLD = "world"


class GazeboRosHandOfGod(RosPlugin, ModelPlugin):
    """Pulls a link, without gravity, to the frame ``<frame>_desired``, and publishes ``<frame>_actual``, both in world.

    Transforms from world to the desired frame are obeyed; not chains of transforms.
    """

    STATE = ("desired",)

    parameters = (
        Parameter("linkName", str, "the link"),
        Parameter("frameId", "world", "frames are named after it: hog for hog_desired and hog_actual"),
        Parameter("kl", 200.0, "force of the spring [N/m]"),
        Parameter("ka", 200.0, "torque of the spring [N m/rad]"),
    )
    endpoints = (
        Endpoint("subscribes", "/tf", "tf2_msgs/TFMessage"),
        Endpoint("publishes", "/tf", "tf2_msgs/TFMessage"),
    )

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the link, and subscribe.

        Raises:
            ParameterError: a gain is negative.
        """
        self.open(sdf, model.GetName())
        given = self.given
        if not (0.0 <= given.kl < math.inf and 0.0 <= given.ka < math.inf):
            raise ParameterError(
                f"{sdf.where}: <kl> and <ka> are {given.kl:g} and {given.ka:g}; they must not be negative"
            )
        self.world, self.link = model.GetWorld(), named_link(model, ros_elements(sdf), "linkName")
        self.link.SetGravityMode(False)
        inertial = self.link.GetInertial()
        self.damping = 2.0 * math.sqrt(given.kl * inertial.GetMass()), 2.0 * math.sqrt(given.ka * inertial.IXX())
        self.desired: Pose3d | None = None
        self.stamp = message_type("std_msgs/Header")().stamp
        self.transforms = self.subscribe("/tf", "tf2_msgs/TFMessage", self.OnTransforms, 100)
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def OnTransforms(self, message: Any) -> None:
        """Transforms have come."""
        for one in message.transforms:
            names = one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")
            if names == (WORLD, f"{self.given.frameId}_desired") and finite(one):
                place, turn = one.transform.translation, one.transform.rotation
                rotation = Quaterniond(turn.w, turn.x, turn.y, turn.z)
                rotation.Normalize()
                self.desired = Pose3d(Vector3d(place.x, place.y, place.z), rotation)

    def Reset(self) -> None:
        """Let it loose until the next transform."""
        self.desired = None

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Pull, and publish the pose."""
        pose = self.link.WorldPose()
        if self.desired is not None:
            given, (linear, angular) = self.given, self.damping
            away = self.desired.Pos() - pose.Pos()
            turn = (pose.Rot().Inverse() * self.desired.Rot()).Log()
            rate = pose.Rot().RotateVectorReverse(self.link.WorldAngularVel())
            self.link.AddForce(away * given.kl - self.link.WorldLinearVel() * linear)
            self.link.AddRelativeTorque(Vector3d(turn.X(), turn.Y(), turn.Z()) * given.ka - rate * angular)
        set_stamp(self.stamp, self.world.core.GetSimTime())
        w, x, y, z = pose.Rot()
        self.ros.send_transform(self.stamp, WORLD, f"{self.given.frameId}_actual", tuple(pose.Pos()), (x, y, z, w))


GZ_REGISTER_MODEL_PLUGIN(GazeboRosHandOfGod)
