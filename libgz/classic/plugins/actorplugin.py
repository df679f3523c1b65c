"""ActorPlugin: an actor that walks to targets and around obstacles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from libgz.base.errors import ParameterError
from libgz.classic.event import Events
from libgz.classic.math import Angle, Pose3d, Quaterniond, Rand, Vector3d, clamp
from libgz.classic.physics import Actor, TrajectoryInfo
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element

WALKING = "walking"
SPEED = 0.8  # [m/s] for a target weight of 1
UPRIGHT = 1.5707  # [rad] roll of a skin whose height is along y; its front is along -y of the actor's yaw
REACHED = 0.3  # [m] from a target, at which the next one is chosen
FREE = 2.0  # [m] between a new target, the old one, and models
NEAR = 4.0  # [m] at which models are avoided
SWERVE = math.radians(10.0)  # beyond which the actor turns before it walks
TURN = 0.001  # of the remaining angle that it turns by in a step
AREA = (-3.0, -10.0, 3.5, 2.0)  # [m] x and y, least and most, as in Gazebo
TRIES = 1000


class ActorPlugin(ModelPlugin):
    """Lets an actor walk to a target, then to targets at random, and around the models in its way.

    It walks at 0.8 m/s times the target weight, slower or faster near obstacles.

    Elements:
        target: the first one [m] (0 -5 and the actor's height).
        target_weight: how strongly it is attracted (1.15).
        obstacle_weight: how strongly models nearer than 4 m repel it [m] (1.5).
        animation_factor: time of the animation per distance [s/m] (4.5).
        ignore_obstacles: `model`, several: those that it does not avoid.
        area: least x, least y, most x, most y of where it walks [m] (-3 -10 3.5 2); not in Gazebo.
    """

    STATE = ("target", "last")

    def Load(self, model: Model, sdf: Element) -> None:
        """Begin with the animation "walking".

        Raises:
            ParameterError: the model is no actor, or has no such animation, or the area is empty.
        """
        if not isinstance(model, Actor):
            raise ParameterError(f"{sdf.where}: this plugin moves an <actor>; {model.GetName()!r} is a model")
        self.actor, self.world = model, model.GetWorld()
        self.height = model.WorldPose().Pos().Z()
        self.start = sdf.Get(Vector3d, "target", Vector3d(0.0, -5.0, self.height))[0]
        self.start.Z(self.height)
        self.target_weight = sdf.Get(float, "target_weight", 1.15)[0]
        self.obstacle_weight = sdf.Get(float, "obstacle_weight", 1.5)[0]
        self.animation_factor = sdf.Get(float, "animation_factor", 4.5)[0]
        ignored = sdf.GetElement("ignore_obstacles")
        self.ignored = {model.GetName(), *(e.Get(str) for e in (ignored.named("model") if ignored is not None else ()))}
        words = sdf.Get(str, "area", " ".join(map(str, AREA)))[0].split()
        try:
            self.area = [float(word) for word in words]
        except ValueError:
            self.area = []
        if len(self.area) != 4 or not (self.area[0] < self.area[2] and self.area[1] < self.area[3]):
            raise ParameterError(
                f"{sdf.where}: <area> is {' '.join(words)!r}; it must be least x, least y, most x, most y"
            )
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def Reset(self) -> None:
        """Walk to the first target."""
        self.target, self.last = Vector3d(self.start), self.world.SimTime().Double()
        self.actor.SetCustomTrajectory(TrajectoryInfo(type=WALKING, duration=1.0))

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Walk for a step."""
        now = info.simTime.Double()
        step, self.last = now - self.last, now
        pose = self.actor.WorldPose()
        if Vector3d(self.target - pose.Pos()).Length() < REACHED:
            self.target = self._next_target()
        way = self._around_obstacles(Vector3d(self.target - pose.Pos()).Normalize() * self.target_weight, pose)
        here, heading = Vector3d(pose.Pos()), pose.Rot().Yaw()
        turn = Angle(math.atan2(way.Y(), way.X()) + UPRIGHT - heading)
        turn.Normalize()
        if abs(turn.Radian()) > SWERVE:
            heading += TURN * turn.Radian()
        else:
            here, heading = here + way * (SPEED * step), heading + turn.Radian()
        west, south, east, north = self.area
        place = Vector3d(clamp(here.X(), west, east), clamp(here.Y(), south, north), self.height)
        walked = place.Distance(pose.Pos())
        self.actor.SetWorldPose(Pose3d(place, Quaterniond(UPRIGHT, 0.0, heading)))
        self.actor.SetScriptTime(self.actor.ScriptTime() + walked * self.animation_factor)

    def _obstacles(self) -> list[Vector3d]:
        return [model.WorldPose().Pos() for model in self.world.Models() if model.GetName() not in self.ignored]

    def _around_obstacles(self, way: Vector3d, pose: Pose3d) -> Vector3d:
        """The way, bent by the models that are near: each repels by the obstacle weight over its distance."""
        for place in self._obstacles():
            offset = Vector3d(place - pose.Pos())
            distance = offset.Length()
            if 0.0 < distance < NEAR:
                way = way - offset * (self.obstacle_weight / distance**2)
        return way

    def _next_target(self) -> Vector3d:
        """A place at random, away from the last target and from models; the last one if there is none."""
        west, south, east, north = self.area
        obstacles = self._obstacles()
        for _ in range(TRIES):
            place = Vector3d(Rand.DblUniform(west, east), Rand.DblUniform(south, north), self.height)
            if all(place.Distance(other) >= FREE for other in (self.target, *obstacles)):
                return place
        return self.target


GZ_REGISTER_MODEL_PLUGIN(ActorPlugin)
