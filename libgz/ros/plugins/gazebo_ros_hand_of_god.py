"""gazebo_ros_hand_of_god: pulls a link to a frame of TF, as a spring and a damper do."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.law import Number, law
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link
from libgz.classic.plugins._ros import ros_elements
from libgz.ros.plugin import Endpoint, Parameter, Periodic, Ticks
from libgz.ros.session import finite, set_stamp
from libgz.ros.types import message_type

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WORLD = "world"
MOST_FRAMES, LONGEST_CHAIN = 1000, 64  # that are kept; between the world and the desired frame
LONGEST_NAME = 1000  # characters of a frame that is kept


class GazeboRosHandOfGod(Periodic, ModelPlugin):
    """Pulls a link, without gravity, to the frame ``<frame>_desired``, and publishes ``<frame>_actual``, both in world.

    The desired frame is that of the last transforms that came, also by way of others between it and the world.
    """

    STATE = ("frames", "known")

    known = Number()  # 1: there is a desired pose

    parameters = (
        Parameter("linkName", str, "the link"),
        Parameter("frameId", "hog", "frames are named after it: hog for hog_desired and hog_actual", ros2="world"),
        Parameter("kl", 200.0, "force of the spring [N/m]"),
        Parameter("ka", 200.0, "torque of the spring [N m/rad]"),
    )
    endpoints = (
        Endpoint("subscribes", "/tf", "tf2_msgs/TFMessage"),
        Endpoint("subscribes", "/tf_static", "tf2_msgs/TFMessage"),
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
        self.frames: dict[str, tuple[str, tuple[float, ...], tuple[float, ...]]] = {}  # parent, place, turn
        self.stamp = message_type("std_msgs/Header")().stamp
        self.actual = self.ros.transforms(self.own_node)  # advertised at once, as the original does
        static: dict[str, Any] = {"durability": "transient_local"} if self.two else {}
        self.transforms = [
            self.subscribe("/tf", "tf2_msgs/TFMessage", self.OnTransforms, 100),
            self.subscribe("/tf_static", "tf2_msgs/TFMessage", self.OnTransforms, 100, **static),
        ]
        self.ticks = Ticks(0.0)
        self.run()

    def OnTransforms(self, message: Any) -> None:
        """Transforms have come."""
        for one in message.transforms:
            parent, child = one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")
            place, turn = one.transform.translation, one.transform.rotation
            kept = child in self.frames or len(self.frames) < MOST_FRAMES
            if kept and max(len(parent), len(child)) <= LONGEST_NAME and finite(one):
                self.frames[child] = parent, (place.x, place.y, place.z), (turn.w, turn.x, turn.y, turn.z)
        self.known = float(self.desired() is not None)

    def Reset(self) -> None:
        """Let it loose until the next transform."""
        self.frames.clear()
        self.known = 0.0

    def desired(self) -> Pose3d | None:
        """The pose of the desired frame in the world; None as long as it is not known."""
        frame, found = f"{self.given.frameId}_desired", Pose3d()
        for _ in range(LONGEST_CHAIN):
            if frame == WORLD:
                return found
            if frame not in self.frames:
                break
            frame, place, turn = self.frames[frame]
            rotation = Quaterniond(*turn)
            rotation.Normalize()
            found = Pose3d(Vector3d(*place) + rotation.RotateVector(found.Pos()), rotation * found.Rot())
        return None

    @law
    def wanted(self) -> Any:
        """Once the desired pose is known."""
        return self.known > 0.0

    def work(self, now: float) -> None:
        """Pull, and publish the pose."""
        pose, desired = self.link.WorldPose(), self.desired()
        if desired is None:
            return
        given, (linear, angular) = self.given, self.damping
        away = desired.Pos() - pose.Pos()
        turn = (pose.Rot().Inverse() * desired.Rot()).Log()
        rate = pose.Rot().RotateVectorReverse(self.link.WorldAngularVel())
        self.link.AddForce(away * given.kl - self.link.WorldLinearVel() * linear)
        self.link.AddRelativeTorque(Vector3d(turn.X(), turn.Y(), turn.Z()) * given.ka - rate * angular)
        set_stamp(self.stamp, now)
        w, x, y, z = pose.Rot()
        frame = f"{self.given.frameId}_actual"
        self.ros.send_transform(self.stamp, WORLD, frame, tuple(pose.Pos()), (x, y, z, w), self.own_node)


GZ_REGISTER_MODEL_PLUGIN(GazeboRosHandOfGod)
