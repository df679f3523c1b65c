"""gazebo_ros_actor_command: an actor that walks by commands, without ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Angle, Pose3d, Quaterniond, Vector3d, clamp
from libgz.classic.physics import Actor, TrajectoryInfo
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WALKING = "walking"
MODES = ("velocity", "path")
LARGEST = 1e3  # [m/s] and [rad/s] of a command


class GazeboRosActorCommand(ModelPlugin):
    """Moves an actor with its animation "walking", by velocities or along a path.

    In the mode `velocity` the velocity topic takes a Pose: x of the position [m/s] forwards, yaw of the orientation
    [rad/s] to the left; it is valid until the next one. In the mode `path` the path topic takes a PosesStamped, whose
    places are walked to one after the other: it turns to each, then walks straight.

    Elements:
        follow_mode: velocity or path (velocity).
        vel_topic, path_topic: (/cmd_vel, /cmd_path).
        animation_factor: time of the animation per distance [s/m] (4).
        linear_velocity, angular_velocity: on a path [m/s], [rad/s] (1, 2.5).
        linear_tolerance: at which a place is reached [m] (0.1).
        angular_tolerance: of the direction, up to which it walks on a path [rad] (0.0872).
        default_rotation: of the skin, as roll, and from its front to the actor's yaw [rad] (1.57).
    """

    STATE = ("command", "path", "last")

    def Load(self, model: Model, sdf: Element) -> None:
        """Begin with the animation, and subscribe.

        Raises:
            ParameterError: the model is no actor, or a value is not allowed.
        """
        if not isinstance(model, Actor):
            raise ParameterError(f"{sdf.where}: this plugin moves an <actor>; {model.GetName()!r} is a model")
        self.actor, self.world = model, model.GetWorld()
        self.mode = sdf.Get(str, "follow_mode", "velocity")[0].strip()
        if self.mode not in MODES:
            raise ParameterError(f"{sdf.where}: <follow_mode> is {self.mode!r}; allowed are {', '.join(MODES)}")
        self.factor = sdf.Get(float, "animation_factor", 4.0)[0]
        self.speed, self.turn = sdf.Get(float, "linear_velocity", 1.0)[0], sdf.Get(float, "angular_velocity", 2.5)[0]
        self.near = sdf.Get(float, "linear_tolerance", 0.1)[0]
        self.aligned = sdf.Get(float, "angular_tolerance", 0.0872)[0]
        self.upright = sdf.Get(float, "default_rotation", 1.57)[0]
        self.node = transport.Node()
        self.node.Init(self.world.Name())
        topic = sdf.Get(str, "vel_topic", "/cmd_vel")[0].strip()
        self.subscribers = [
            self.node.Subscribe(topic, self.OnVelocity, kind="Pose"),
            self.node.Subscribe(sdf.Get(str, "path_topic", "/cmd_path")[0].strip(), self.OnPath, kind="Pose_V"),
        ]
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Stand."""
        self.command = (0.0, 0.0)
        self.path: list[tuple[float, float]] = []
        self.last = self.world.SimTime().Double()
        self.actor.SetCustomTrajectory(TrajectoryInfo(type=WALKING, duration=1.0))

    def OnVelocity(self, message: Any) -> None:
        """Take a command."""
        command = message.position.x, msgs.ConvertIgn(message.orientation).Yaw()
        if all(map(math.isfinite, command)):
            self.command = clamp(command[0], -LARGEST, LARGEST), clamp(command[1], -LARGEST, LARGEST)

    def OnPath(self, message: Any) -> None:
        """Take a path in place of the present one."""
        places = [(pose.position.x, pose.position.y) for pose in message.pose]
        if all(math.isfinite(value) for place in places for value in place):
            self.path = places

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Walk for a step."""
        now = info.simTime.Double()
        step, self.last = now - self.last, now
        pose = self.actor.WorldPose()
        heading = pose.Rot().Yaw() - self.upright
        speed, turn = self.command if self.mode == "velocity" else self._towards(pose.Pos(), heading, step)
        heading += turn * step
        moved = Vector3d(math.cos(heading), math.sin(heading), 0.0) * (speed * step)
        place = Pose3d(pose.Pos() + moved, Quaterniond(self.upright, 0.0, heading + self.upright))
        self.actor.SetWorldPose(place)
        self.actor.SetScriptTime(self.actor.ScriptTime() + abs(speed) * step * self.factor)

    def _towards(self, here: Vector3d, heading: float, step: float) -> tuple[float, float]:
        """Speed and turn rate on the path [m/s], [rad/s]."""
        while self.path and math.dist(self.path[0], (here.X(), here.Y())) <= self.near:
            self.path.pop(0)
        if not self.path or not step > 0.0:
            return 0.0, 0.0
        turn = Angle(math.atan2(self.path[0][1] - here.Y(), self.path[0][0] - here.X()) - heading)
        turn.Normalize()
        rate = clamp(turn.Radian() / step, -self.turn, self.turn)
        return (self.speed if abs(turn.Radian()) <= self.aligned else 0.0), rate


GZ_REGISTER_MODEL_PLUGIN(GazeboRosActorCommand)
