"""Base and Entity: what models, links, collisions, joints and lights have in common."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from libgz.classic.math import AxisAlignedBox, Pose3d, Vector3d
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose

if TYPE_CHECKING:
    from libgz.classic.common import PoseAnimation
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World
    from libgz.sdf.element import Element

__all__ = ["Base", "Entity", "find_named", "view_of"]

V = TypeVar("V")

_ids = itertools.count(1)


def view_of(core: Any, make: Callable[[], V]) -> V:
    """The one view on an object of the engine, made when it is first asked for."""
    found: V | None = core.__dict__.get("classic_view")
    if found is None:
        found = core.__dict__["classic_view"] = make()
    return found


class Base:
    """Something with a name in a world."""

    # EntityType, as in Gazebo.
    BASE: ClassVar[int] = 0x00000000
    ENTITY: ClassVar[int] = 0x00000001
    MODEL: ClassVar[int] = 0x00000002
    LINK: ClassVar[int] = 0x00000004
    COLLISION: ClassVar[int] = 0x00000008
    LIGHT: ClassVar[int] = 0x00000010
    VISUAL: ClassVar[int] = 0x00000020
    JOINT: ClassVar[int] = 0x00000040
    SHAPE: ClassVar[int] = 0x00010000

    entity_type: ClassVar[int] = 0

    def __init__(self, world: World, name: str, parent: Base | None, sdf: Element | None = None) -> None:
        self._world, self._name, self._parent, self._sdf = world, name, parent, sdf
        self._number = next(_ids)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.GetScopedName()!r}>"

    def GetName(self) -> str:
        """The name in what is around it."""
        return self._name

    Name = GetName

    def SetName(self, name: str) -> None:
        """Rename it."""
        self._name = name

    def GetScopedName(self, prependWorldName: bool = False) -> str:
        """The names from the model down to this, joined by ``::``."""
        name = self.GetName()
        parent = self._parent
        while parent is not None:
            name = f"{parent.GetName()}::{name}"
            parent = parent._parent
        return f"{self._world.Name()}::{name}" if prependWorldName else name

    ScopedName = GetScopedName

    def GetWorld(self) -> World:
        """The world."""
        return self._world

    def GetParent(self) -> Base | None:
        """What it is a part of; None at the top."""
        return self._parent

    def GetParentId(self) -> int:
        """The parent's number, or 0."""
        return self._parent.GetId() if self._parent is not None else 0

    def GetParentModel(self) -> Model | None:
        """The model that it belongs to, itself included."""
        found: Base | None = self
        while found is not None and not found.HasType(Base.MODEL):
            found = found._parent
        return found  # type: ignore[return-value]

    def GetSDF(self) -> Element | None:
        """The element it was built from; None if there was none."""
        return self._sdf

    def GetId(self) -> int:
        """A number that nothing else has."""
        return self._number

    def GetType(self) -> int:
        """All of Base.MODEL, Base.LINK ... that it is, added up."""
        return self.entity_type

    def HasType(self, kind: int) -> bool:
        """Whether it is of this kind; everything is a BASE."""
        return self.entity_type & kind == kind

    def children(self) -> list[Base]:
        """What is a part of it, in the order of the file."""
        return []

    def GetChildCount(self) -> int:
        """How many parts it has."""
        return len(self.children())

    def GetChild(self, which: int | str) -> Base | None:
        """A part by index or name; None if there is none."""
        parts = self.children()
        if isinstance(which, int):
            return parts[which] if 0 <= which < len(parts) else None
        return next((part for part in parts if which in (part.GetName(), part.GetScopedName())), None)

    def GetByName(self, name: str) -> Base | None:
        """Itself, or something in it, by its name or scoped name; None if there is none."""
        return find_named(self.tree(), name)

    BaseByName = GetByName

    def tree(self) -> Iterator[Base]:
        """Itself and everything in it."""
        yield self
        for part in self.children():
            yield from part.tree()

    def Print(self, prefix: str = "") -> str:
        """The names of it and everything in it, a line each."""
        return f"{prefix}{self.GetName()}\n" + "".join(part.Print(prefix + "  ") for part in self.children())


def find_named(parts: Iterable[Base], name: str) -> Base | None:
    """The part of this scoped name, else the first of this name: a model is not mistaken for another one's link."""
    first = None
    for part in parts:
        if part.GetScopedName() == name:
            return part
        if first is None and part.GetName() == name:
            first = part
    return first


class Entity(Base):
    """Something with a place in the world."""

    entity_type = Base.ENTITY
    visual: Any = None  # set by libgz.classic.rendering

    # Pose: the engine's is asked for and set through these two.

    def pose(self) -> GzPose:
        """Global pose [m] of the engine."""
        raise NotImplementedError

    def move(self, pose: GzPose) -> None:
        """Put it to a global pose [m]; velocities stay."""
        raise NotImplementedError

    def _frame(self) -> GzPose:
        """Global pose of what it is a part of [m]."""
        return self._parent.pose() if isinstance(self._parent, Entity) else GzPose()

    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.pose())

    GetWorldPose = WorldPose

    def SetWorldPose(self, pose: GzPose, notify: bool = True, publish: bool = True) -> None:
        """Move it to a global pose [m]; velocities stay."""
        self.move(pose)

    def RelativePose(self) -> Pose3d:
        """Pose in what it is a part of [m]."""
        return Pose3d(GzCoordPoseSub(self.pose(), self._frame()))

    GetRelativePose = RelativePose

    def SetRelativePose(self, pose: GzPose, notify: bool = True, publish: bool = True) -> None:
        """Move it to a pose in what it is a part of [m]."""
        self.move(GzCoordPoseAdd(pose, self._frame()))

    def InitialRelativePose(self) -> Pose3d:
        """The pose that a reset goes back to [m]."""
        return self.RelativePose()

    GetInitialRelativePose = InitialRelativePose

    def IsStatic(self) -> bool:
        """Whether it never moves by itself."""
        return False

    def SetStatic(self, static: bool) -> None:
        """Hold it where it is, or let it go; what never moves by itself stays as it is."""

    # Velocity ----------------------------------------------------------------------------------------------------

    def WorldLinearVel(self) -> Vector3d:
        """Velocity of the frame's origin [m/s], global."""
        return Vector3d()

    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s], global."""
        return Vector3d()

    def RelativeLinearVel(self) -> Vector3d:
        """Velocity of the frame's origin along its own axes [m/s]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldLinearVel()))

    def RelativeAngularVel(self) -> Vector3d:
        """Angular velocity about its own axes [rad/s]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldAngularVel()))

    def WorldLinearAccel(self) -> Vector3d:
        """Acceleration in the last step [m/s^2], global."""
        return Vector3d()

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step [rad/s^2], global."""
        return Vector3d()

    def RelativeLinearAccel(self) -> Vector3d:
        """Acceleration in the last step along its own axes [m/s^2]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldLinearAccel()))

    def RelativeAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step about its own axes [rad/s^2]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldAngularAccel()))

    # The old names look the new ones up, so that kinds of entities need not repeat them.

    def GetWorldLinearVel(self, *offset: Vector3d) -> Vector3d:
        """The old name of WorldLinearVel."""
        return self.WorldLinearVel(*offset)

    def GetWorldAngularVel(self) -> Vector3d:
        """The old name of WorldAngularVel."""
        return self.WorldAngularVel()

    def GetWorldLinearAccel(self) -> Vector3d:
        """The old name of WorldLinearAccel."""
        return self.WorldLinearAccel()

    def GetWorldAngularAccel(self) -> Vector3d:
        """The old name of WorldAngularAccel."""
        return self.WorldAngularAccel()

    GetRelativeLinearVel = RelativeLinearVel
    GetRelativeAngularVel = RelativeAngularVel
    GetRelativeLinearAccel = RelativeLinearAccel
    GetRelativeAngularAccel = RelativeAngularAccel

    # What is below -----------------------------------------------------------------------------------------------

    def BoundingBox(self) -> AxisAlignedBox:
        """The smallest box along the world's axes around all its collisions [m]."""
        box = AxisAlignedBox()
        for part in self.children():
            if isinstance(part, Entity):
                box.Merge(part.BoundingBox())
        return box

    def GetBoundingBox(self) -> AxisAlignedBox:
        """The old name of BoundingBox."""
        return self.BoundingBox()

    CollisionBoundingBox = GetBoundingBox

    def GetNearestEntityBelow(self) -> tuple[float, str]:
        """(distance [m], scoped name) of the collision below its lowest point; (1000, "") for none."""
        box = self.BoundingBox()
        bottom = min(self.pose().pos.z, box.Min().z) if self.children() else self.pose().pos.z
        where = self.pose().pos
        return self._world.ray_down(Vector3d(where.x, where.y, bottom - 1e-5), self)

    def PlaceOnNearestEntityBelow(self) -> None:
        """Lower it until it stands on what is below."""
        distance, name = self.GetNearestEntityBelow()
        if name:
            pose = self.pose()
            pose.pos.z -= distance
            self.move(pose)

    PlaceOnEntity = PlaceOnNearestEntityBelow

    # Animation ---------------------------------------------------------------------------------------------------

    def SetAnimation(self, animation: PoseAnimation, onComplete: Callable[[], object] | None = None) -> None:
        """Move it along an animation of poses in what it is a part of, by sim time; then call `onComplete`."""
        self._world.animations.start(self, animation, onComplete)

    def StopAnimation(self) -> None:
        """Leave it where its animation has brought it."""
        self._world.animations.stop(self)
