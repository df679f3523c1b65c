"""States: poses and velocities of a world and its parts at one time; and the world as an SDF document."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from libgz.base.errors import NotFoundError, ParameterError, WorldFileError, nearest
from libgz.base.files import save_file
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzVector
from libgz.classic.common import Time
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.names import takes_names
from libgz.sdf.element import Element
from libgz.sdf.upgrade import NEWEST, upgraded

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.light import Light
    from libgz.classic.physics.world import Joint, Link, Model, World

__all__ = [
    "CollisionState",
    "JointState",
    "LightState",
    "LinkState",
    "ModelState",
    "State",
    "WorldState",
    "save_world",
    "world_text",
]


S = TypeVar("S", bound="State")
_Combine = Callable[[Pose3d, Pose3d], Pose3d]


def _change(new: Pose3d, old: Pose3d) -> Pose3d:
    return Pose3d(new.Pos() - old.Pos(), old.Rot().Inverse() * new.Rot())


def _changed(old: Pose3d, change: Pose3d) -> Pose3d:
    return Pose3d(old.Pos() + change.Pos(), old.Rot() * change.Rot())


def _parts(own: Sequence[S], others: Sequence[S], combine: _Combine) -> list[S]:
    """Each part combined with that of its name; those without one as they are."""
    named = {part.GetName(): part for part in others}
    return [part._combined(named[part.GetName()], combine) if part.GetName() in named else part for part in own]


@takes_names
class State:
    """A name and the times of a state.

    ``new - old`` is the change between two states of the same thing, and ``old + change`` is the new one again:
    positions, velocities and efforts are subtracted, a rotation is that from the old to the new one. Parts that only
    the first one has stay as they are.
    """

    def __init__(self, name: str = "", world: World | None = None) -> None:
        self._name = name
        self._sim = world.SimTime() if world is not None else Time()
        self._real = world.RealTime() if world is not None else Time()
        self._wall = Time.GetWallTime() if world is not None else Time()
        self._iterations = world.Iterations() if world is not None else 0

    def _take(self, part: Link | Joint | Model | Light, times: tuple[Time | int, ...]) -> None:
        """Take a name and the times of its world, or those that are given."""
        State.__init__(self, part.GetName(), part.GetWorld())
        setters: tuple[Callable[[Any], None], ...] = (self.SetRealTime, self.SetSimTime, self.SetIterations)
        for setter, time in zip(setters, times, strict=False):
            setter(time)

    def GetName(self) -> str:
        """The name."""
        return self._name

    def SetName(self, name: str) -> None:
        """Set the name."""
        self._name = name

    def GetSimTime(self) -> Time:
        """The sim time."""
        return self._sim

    def SetSimTime(self, time: Time) -> None:
        """Set the sim time."""
        self._sim = Time(time)

    def GetRealTime(self) -> Time:
        """The real time."""
        return self._real

    def SetRealTime(self, time: Time) -> None:
        """Set the real time."""
        self._real = Time(time)

    def GetWallTime(self) -> Time:
        """The wall time."""
        return self._wall

    def SetWallTime(self, time: Time) -> None:
        """Set the wall time."""
        self._wall = Time(time)

    def GetIterations(self) -> int:
        """The number of iterations."""
        return self._iterations

    def SetIterations(self, iterations: int) -> None:
        """Set the number of iterations."""
        self._iterations = int(iterations)

    def IsZero(self) -> bool:
        """Whether all that it holds is zero."""
        return True

    def __sub__(self, other: Self) -> Self:
        return self._combined(other, _change) if type(self) is type(other) else NotImplemented

    def __add__(self, other: Self) -> Self:
        return self._combined(other, _changed) if type(self) is type(other) else NotImplemented

    def _combined(self, other: Self, combine: _Combine) -> Self:
        """A state with this one's name and times, of both values."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self._name!r} at {self._sim.Double():g} s>"


class CollisionState(State):
    """The pose of a collision."""

    def __init__(self, collision: Collision | None = None) -> None:
        super().__init__(*((collision.GetName(), collision.GetWorld()) if collision else ()))
        self._pose = collision.RelativePose() if collision else Pose3d()

    def Pose(self) -> Pose3d:
        """Its pose in the link [m]."""
        return self._pose

    def IsZero(self) -> bool:
        """Whether the pose is zero."""
        return self._pose == Pose3d()

    def _combined(self, other: CollisionState, combine: _Combine) -> CollisionState:
        made = copy.copy(self)
        made._pose = combine(self._pose, other._pose)
        return made

    GetPose = Pose


@takes_names
class LinkState(State):
    """Pose and motion of a link, in the world frame."""

    def __init__(self, link: Link | None = None, *times: Time | int) -> None:
        super().__init__()
        self._pose, self._linear, self._angular = GzPose(), GzVector(), GzVector()
        self._velocity, self._acceleration, self._wrench = Pose3d(), Pose3d(), Pose3d()
        self._collisions: list[CollisionState] = []
        if link is not None:
            self.Load(link, *times)

    def Load(self, link: Link, *times: Time | int) -> None:
        """Take the state of a link, and real time, sim time and iterations if they are given."""
        self._take(link, times)
        body = link.body
        self._pose, self._linear, self._angular = body.GetPose(), body.GetLinearVel(), body.GetAngularRate()
        self._velocity = _motion(link.WorldLinearVel(), link.WorldAngularVel())
        self._acceleration = _motion(link.WorldLinearAccel(), link.WorldAngularAccel())
        self._wrench = _motion(link.WorldForce(), Vector3d())
        self._collisions = [CollisionState(collision) for collision in link.GetCollisions()]

    def Pose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self._pose)

    def Velocity(self) -> Pose3d:
        """Velocity of the origin [m/s] as the position, angular velocity [rad/s] as Euler angles, as in Gazebo."""
        return self._velocity

    def Acceleration(self) -> Pose3d:
        """Linear [m/s^2] and angular [rad/s^2] acceleration, in the same form."""
        return self._acceleration

    def Wrench(self) -> Pose3d:
        """The force at the centre of mass [N] as the position; the rotation is none, as in Gazebo."""
        return self._wrench

    def GetCollisionStateCount(self) -> int:
        """The number of its collisions."""
        return len(self._collisions)

    def GetCollisionStates(self) -> list[CollisionState]:
        """The states of its collisions."""
        return list(self._collisions)

    def GetCollisionState(self, which: int | str) -> CollisionState:
        """The state of a collision by index or name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._collisions, which, f"link {self._name!r}", "collision")

    def IsZero(self) -> bool:
        """Whether pose, velocity, acceleration and wrench are zero."""
        zero = Pose3d()
        return all(value == zero for value in (self.Pose(), self._velocity, self._acceleration, self._wrench))

    def apply(self, link: Link) -> None:
        """Set a link's pose and velocities to these."""
        link.body.SetPose(self._pose)
        link.body.SetLinearVel(self._linear)
        link.body.SetAngularVel(self._angular)

    def _combined(self, other: LinkState, combine: _Combine) -> LinkState:
        made = copy.copy(self)
        made._pose = combine(Pose3d(self._pose), Pose3d(other._pose))
        motions = ((self._linear, other._linear), (self._angular, other._angular))
        pairs = ((Pose3d(Vector3d(*one), Quaterniond()), Pose3d(Vector3d(*two), Quaterniond())) for one, two in motions)
        made._linear, made._angular = (GzVector(*combine(one, two).Pos()) for one, two in pairs)
        made._velocity = combine(self._velocity, other._velocity)
        made._acceleration = combine(self._acceleration, other._acceleration)
        made._wrench = combine(self._wrench, other._wrench)
        made._collisions = _parts(self._collisions, other._collisions, combine)
        return made

    GetPose, GetVelocity, GetAcceleration, GetWrench = Pose, Velocity, Acceleration, Wrench


class JointState(State):
    """The positions of a joint."""

    def __init__(self, joint: Joint | None = None, *times: Time | int) -> None:
        super().__init__()
        self._positions: list[float] = []
        if joint is not None:
            self.Load(joint, *times)

    def Load(self, joint: Joint, *times: Time | int) -> None:
        """Take the state of a joint, and real time, sim time and iterations if they are given."""
        self._take(joint, times)
        self._positions = [joint.Position(index) for index in range(joint.DOF())]

    def GetAngleCount(self) -> int:
        """The number of positions."""
        return len(self._positions)

    def Position(self, axis: int = 0) -> float:
        """The position of an axis [rad] or [m].

        Raises:
            ParameterError: there is no such axis.
        """
        if not 0 <= axis < len(self._positions):
            raise ParameterError(f"the state of joint {self._name!r} has no axis {axis}; it has {len(self._positions)}")
        return self._positions[axis]

    def Positions(self) -> list[float]:
        """The positions of all axes [rad] or [m]."""
        return list(self._positions)

    def IsZero(self) -> bool:
        """Whether all positions are zero."""
        return not any(self._positions)

    def _combined(self, other: JointState, combine: _Combine) -> JointState:
        made, sign = copy.copy(self), -1.0 if combine is _change else 1.0
        if len(other._positions) != len(self._positions):
            raise ParameterError(f"the states of joint {self._name!r} have different numbers of axes")
        made._positions = [a + sign * b for a, b in zip(self._positions, other._positions, strict=True)]
        return made

    GetAngle, GetAngles = Position, Positions


@takes_names
class ModelState(State):
    """Pose and motion of a model: of its links, joints and nested models."""

    def __init__(self, model: Model | None = None, *times: Time | int) -> None:
        super().__init__()
        self._pose, self._scale = Pose3d(), Vector3d(1, 1, 1)
        self._links: list[LinkState] = []
        self._joints: list[JointState] = []
        self._nested: list[ModelState] = []
        if model is not None:
            self.Load(model, *times)

    def Load(self, model: Model, *times: Time | int) -> None:
        """Take the state of a model, and real time, sim time and iterations if they are given."""
        self._take(model, times)
        self._pose, self._scale = model.WorldPose(), model.Scale()
        self._links = [LinkState(link, *times) for link in model.GetLinks()]
        self._joints = [JointState(joint, *times) for joint in model.GetJoints()]
        self._nested = [ModelState(nested, *times) for nested in model.NestedModels()]

    def Pose(self) -> Pose3d:
        """Global pose [m]."""
        return self._pose

    def Scale(self) -> Vector3d:
        """The multiple of its first size."""
        return self._scale

    def IsZero(self) -> bool:
        """Whether its pose and all states in it are zero."""
        return self._pose == Pose3d() and all(part.IsZero() for part in (*self._links, *self._joints, *self._nested))

    def GetLinkStateCount(self) -> int:
        """The number of its links."""
        return len(self._links)

    def GetLinkStates(self) -> dict[str, LinkState]:
        """The states of its links, by name."""
        return {link.GetName(): link for link in self._links}

    def HasLinkState(self, name: str) -> bool:
        """Whether there is a link of this name."""
        return any(link.GetName() == name for link in self._links)

    def GetLinkState(self, which: int | str) -> LinkState:
        """The state of a link by index or name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._links, which, f"model {self._name!r}", "link")

    def GetJointStateCount(self) -> int:
        """The number of its joints."""
        return len(self._joints)

    def GetJointStates(self) -> dict[str, JointState]:
        """The states of its joints, by name."""
        return {joint.GetName(): joint for joint in self._joints}

    def HasJointState(self, name: str) -> bool:
        """Whether there is a joint of this name."""
        return any(joint.GetName() == name for joint in self._joints)

    def GetJointState(self, which: int | str) -> JointState:
        """The state of a joint by index or name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._joints, which, f"model {self._name!r}", "joint")

    def NestedModelStateCount(self) -> int:
        """The number of models nested in it."""
        return len(self._nested)

    def NestedModelStates(self) -> dict[str, ModelState]:
        """The states of the models nested in it, by name."""
        return {model.GetName(): model for model in self._nested}

    def HasNestedModelState(self, name: str) -> bool:
        """Whether there is a nested model of this name."""
        return any(nested.GetName() == name for nested in self._nested)

    def NestedModelState(self, name: str) -> ModelState:
        """The state of a nested model by name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._nested, name, f"model {self._name!r}", "model")

    def apply(self, model: Model) -> None:
        """Set poses and velocities of a model's links to these; links that are not in the state do not change."""
        known = {link.GetName(): link for link in self._links}
        for link in model.GetLinks():
            if link.GetName() in known:
                known[link.GetName()].apply(link)
        models = {nested.GetName(): nested for nested in self._nested}
        for nested in model.NestedModels():
            if nested.GetName() in models:
                models[nested.GetName()].apply(nested)

    def _combined(self, other: ModelState, combine: _Combine) -> ModelState:
        made = copy.copy(self)
        made._pose = combine(self._pose, other._pose)
        made._scale = self._scale - other._scale if combine is _change else self._scale + other._scale
        made._links = _parts(self._links, other._links, combine)
        made._joints = _parts(self._joints, other._joints, combine)
        made._nested = _parts(self._nested, other._nested, combine)
        return made

    GetPose = Pose


class LightState(State):
    """The pose of a light."""

    def __init__(self, light: Light | None = None, *times: Time | int) -> None:
        super().__init__()
        self._pose = Pose3d()
        if light is not None:
            self.Load(light, *times)

    def Load(self, light: Light, *times: Time | int) -> None:
        """Take the state of a light, and real time, sim time and iterations if they are given."""
        self._take(light, times)
        self._pose = light.WorldPose()

    def Pose(self) -> Pose3d:
        """Global pose [m]."""
        return self._pose

    def IsZero(self) -> bool:
        """Whether the pose is zero."""
        return self._pose == Pose3d()

    def _combined(self, other: LightState, combine: _Combine) -> LightState:
        made = copy.copy(self)
        made._pose = combine(self._pose, other._pose)
        return made


@takes_names
class WorldState(State):
    """Poses and motion of all models of a world, and poses of its lights, at one time."""

    def __init__(self, world: World | None = None) -> None:
        super().__init__()
        self._models: list[ModelState] = []
        self._lights: list[LightState] = []
        if world is not None:
            self.Load(world)

    def Load(self, world: World) -> None:
        """Take the state of a world."""
        State.__init__(self, world.Name(), world)
        self._models = [ModelState(model) for model in world.Models()]
        self._lights = [LightState(light) for light in world.Lights()]

    SimTime = State.GetSimTime

    def _combined(self, other: WorldState, combine: _Combine) -> WorldState:
        made = copy.copy(self)
        made._models = _parts(self._models, other._models, combine)
        made._lights = _parts(self._lights, other._lights, combine)
        return made

    def GetModelStateCount(self) -> int:
        """The number of models."""
        return len(self._models)

    def GetModelStates(self) -> dict[str, ModelState]:
        """The states of the models, by name."""
        return {model.GetName(): model for model in self._models}

    def HasModelState(self, name: str) -> bool:
        """Whether there is a model of this name."""
        return any(model.GetName() == name for model in self._models)

    def GetModelState(self, which: int | str) -> ModelState:
        """The state of a model by index or name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._models, which, f"world {self._name!r}", "model")

    def LightStateCount(self) -> int:
        """The number of lights."""
        return len(self._lights)

    def LightStates(self) -> dict[str, LightState]:
        """The states of the lights, by name."""
        return {light.GetName(): light for light in self._lights}

    def HasLightState(self, name: str) -> bool:
        """Whether there is a light of this name."""
        return any(light.GetName() == name for light in self._lights)

    def GetLightState(self, which: int | str) -> LightState:
        """The state of a light by index or name.

        Raises:
            NotFoundError: there is none.
        """
        return _find(self._lights, which, f"world {self._name!r}", "light")

    def IsZero(self) -> bool:
        """Whether all poses, velocities and positions are zero."""
        return all(part.IsZero() for part in (*self._models, *self._lights))

    def apply(self, world: World) -> None:
        """Set the poses and velocities of a world's links; links that are not in the state do not change."""
        known = self.GetModelStates()
        for model in world.Models():
            if model.GetName() in known:
                known[model.GetName()].apply(model)


def _find(states: Sequence[S], which: int | str, holder: str, kind: str) -> S:
    if isinstance(which, int):
        if 0 <= which < len(states):
            return states[which]
        raise NotFoundError(f"the state of {holder} has no {kind} {which}; it has {len(states)}")
    names = [state.GetName() for state in states]
    if which not in names:
        raise NotFoundError(f"the state of {holder} has no {kind} {which!r}{nearest(which, names)}")
    return states[names.index(which)]


def _motion(linear: Vector3d, angular: Vector3d) -> Pose3d:
    return Pose3d(linear, Quaterniond(*angular))


MADE = ("model", "actor", "light", "population", "state")  # of what entities are made; they are written as they are now


def world_text(world: World, folder: Path | None = None) -> str:
    """A world as an SDF document with the present poses.

    Args:
        world: the world.
        folder: the folder of the document; paths of files in it stay relative.

    Raises:
        WorldFileError: the world was not made from SDF.
    """
    sdf = world.SDF()
    if sdf is None:
        raise WorldFileError(f"world {world.Name()!r} was not made from SDF")
    copy = upgraded(sdf, folder)
    for element in [child for child in copy.children if child.name in MADE]:
        copy.RemoveChild(element)
    for part in (*world.Models(), *world.Lights()):
        own = part.GetSDF()
        if own is not None:
            copy.InsertElement(_placed(upgraded(own, folder), part.pose()))
    for model in world.Models():
        placed = next((e for e in copy.named("model") if e.Get(str, "name") == model.GetName()), Element("model"))
        for link in model.GetLinks():
            for inner in placed.named("link"):
                if inner.Get(str, "name") == link.GetName():
                    _placed(inner, GzCoordPoseSub(link.pose(), model.pose()))
    return f'<?xml version="1.0"?>\n<sdf version="{NEWEST}">\n{copy.ToString("  ")}</sdf>\n'


def save_world(world: World, path: Path) -> None:
    """Write a world as SDF with the present poses.

    Raises:
        WorldFileError: the file cannot be written, or the world was not made from SDF.
    """
    try:
        save_file(path, world_text(world, path.parent).encode())
    except OSError as error:
        raise WorldFileError(f"{path}: cannot be written: {error.strerror}") from None


def _placed(element: Element, pose: GzPose) -> Element:
    (next(element.named("pose"), None) or element.AddElement("pose")).Set(pose)
    return element
