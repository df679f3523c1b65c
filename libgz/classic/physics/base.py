"""Base and Entity: the base classes of the views: worlds, models, links, collisions, joints and lights."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzPoseOf, VectorLike, place_of
from libgz.base.law import law
from libgz.classic.math import AxisAlignedBox, Pose3d, Vector3d
from libgz.classic.names import takes_names

if TYPE_CHECKING:
    from libgz.classic.common import PoseAnimation
    from libgz.classic.physics.world import Link, Model, World
    from libgz.sdf.element import Element

__all__ = ["Base", "Entity", "find_named", "view_of"]

V = TypeVar("V")
BELOW = 1e-5  # [m] below an entity where a ray down begins


def view_of(core: Any, make: Callable[[], V]) -> V:
    """The one view on an object of the engine, its attribute `view`; created on first use."""
    if core.facade is None:
        core.facade = make()
    view: V = core.facade
    return view


@takes_names
class Base:
    """A named object of a world."""

    # EntityType, as in Gazebo.
    BASE: ClassVar[int] = 0
    ENTITY: ClassVar[int] = 1 << 0
    MODEL: ClassVar[int] = 1 << 1
    LINK: ClassVar[int] = 1 << 2
    COLLISION: ClassVar[int] = 1 << 3
    LIGHT: ClassVar[int] = 1 << 4
    VISUAL: ClassVar[int] = 1 << 5
    JOINT: ClassVar[int] = 1 << 6
    BALL_JOINT: ClassVar[int] = 1 << 7
    HINGE2_JOINT: ClassVar[int] = 1 << 8
    HINGE_JOINT: ClassVar[int] = 1 << 9
    SLIDER_JOINT: ClassVar[int] = 1 << 10
    SCREW_JOINT: ClassVar[int] = 1 << 11
    UNIVERSAL_JOINT: ClassVar[int] = 1 << 12
    GEARBOX_JOINT: ClassVar[int] = 1 << 13
    FIXED_JOINT: ClassVar[int] = 1 << 14
    ACTOR: ClassVar[int] = 1 << 15
    SHAPE: ClassVar[int] = 1 << 16
    BOX_SHAPE: ClassVar[int] = 1 << 17
    CYLINDER_SHAPE: ClassVar[int] = 1 << 18
    HEIGHTMAP_SHAPE: ClassVar[int] = 1 << 19
    MAP_SHAPE: ClassVar[int] = 1 << 20
    MULTIRAY_SHAPE: ClassVar[int] = 1 << 21
    RAY_SHAPE: ClassVar[int] = 1 << 22
    PLANE_SHAPE: ClassVar[int] = 1 << 23
    SPHERE_SHAPE: ClassVar[int] = 1 << 24
    MESH_SHAPE: ClassVar[int] = 1 << 25
    POLYLINE_SHAPE: ClassVar[int] = 1 << 26
    SENSOR_COLLISION: ClassVar[int] = 1 << 27

    entity_type: ClassVar[int] = 0

    def __init__(self, world: World, name: str, parent: Base | None, sdf: Element | None = None) -> None:
        self._world, self._name, self._parent, self._sdf = world, name, parent, sdf

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.GetScopedName()!r}{place_of(self)}>"

    def GetName(self) -> str:
        """The name, unique within the parent."""
        return self._name

    Name = GetName

    def SetName(self, name: str) -> None:
        """Set the name."""
        self._world.server.ids.rename(self, name)

    def GetScopedName(self, prependWorldName: bool = False) -> str:
        """The names from the top-level model down to this object, joined by ``::``."""
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

    def GetParent(self) -> Base | Any:
        """The parent: the world for top-level models and lights; None for the world."""
        return self._parent if self._parent is not None or self is self._world else self._world

    def container(self) -> Base | Any:
        """What contains it: its parent, and of a joint, whose parent is a link, the model."""
        return self.GetParent()

    def GetParentId(self) -> int:
        """The id of the parent; 0 for the world."""
        parent = self.GetParent()
        return parent.GetId() if parent is not None else 0

    def model_around(self) -> Model | Any:
        """The nearest model among the object itself and its parents; None if there is none."""
        found: Base | None = self
        while found is not None and not found.HasType(Base.MODEL):
            found = found._parent
        return found

    def GetParentModel(self) -> Model | Any:
        """A model itself; of its parts, as in Gazebo, the top-level model around all nested ones; None for others."""
        found = self.model_around()
        while found is not None and found is not self and found._parent is not None:
            found = found._parent
        return found

    def GetSDF(self) -> Element | Any:
        """The SDF element it was built from, or None."""
        return self._sdf

    def GetId(self) -> int:
        """The id, unique in its world; it is given when it is first asked for."""
        return self._world.server.ids.of(self)

    def GetType(self) -> int:
        """The bit mask of its types: Base.ENTITY, Base.MODEL and so on."""
        return self.entity_type

    def HasType(self, kind: int) -> bool:
        """Whether it is of this type; everything is a BASE."""
        return self.GetType() & kind == kind

    def Init(self) -> None:
        """Without effect: what stands in a world acts from its construction on."""

    def children(self) -> list[Base]:
        """The children, in the order of the file."""
        return []

    def GetChildCount(self) -> int:
        """The number of children."""
        return len(self.children())

    def GetChild(self, which: int | str) -> Base | Any:
        """A child by index or name, or None."""
        parts = self.children()
        if isinstance(which, int):
            return parts[which] if 0 <= which < len(parts) else None
        return next((part for part in parts if which in (part.GetName(), part.GetScopedName())), None)

    def RemoveChild(self, which: int | str | Base) -> None:
        """Remove a child by index, name or view: a model, a light or a joint; does nothing if it is not a child.

        Raises:
            ParameterError: it is a link or a collision, which end with their model.
        """
        child = which if isinstance(which, Base) else self.GetChild(which)
        if child is None or not any(part is child for part in self.children()):
            return
        remove = getattr(child, "remove", None)
        if remove is None:
            raise ParameterError(
                f"{child.GetScopedName()} is a {type(child).__name__}; models, lights and joints can be removed"
            )
        remove()

    def GetByName(self, name: str) -> Base | Any:
        """The object itself or a descendant, by name or scoped name; None if there is none."""
        return find_named(self.tree(), name)

    BaseByName = GetByName

    def tree(self) -> Iterator[Base]:
        """The object itself and all descendants, parents first."""
        yield self
        for part in self.children():
            yield from part.tree()

    def Print(self, prefix: str = "") -> str:
        """The names of the object and all descendants, one per line."""
        return f"{prefix}{self.GetName()}\n" + "".join(part.Print(prefix + "  ") for part in self.children())

    def FillMsg(self, msg: Any) -> None:
        """Fill a message with what describes it: that of a model, link, joint, collision or light has its type's name.

        Raises:
            ParameterError: no message describes it.
        """
        described = self._world.server.described(self)
        if described is None:
            raise ParameterError(f"no message describes {self.GetScopedName()}, a {type(self).__name__}")
        msg.CopyFrom(described)


def find_named(parts: Iterable[Base], name: str) -> Base | None:
    """The object with this scoped name, else the first with this name; None if there is none."""
    first = None
    for part in parts:
        if part.GetScopedName() == name:
            return part
        if first is None and part.GetName() == name:
            first = part
    return first


@takes_names
class Entity(Base):
    """An object with a pose."""

    entity_type = Base.ENTITY
    _initial: Pose3d | None = None  # as SetInitialRelativePose set it, where no reset restores it
    visual: Any = None  # set by libgz.classic.rendering

    # Pose: subclasses read and write the engine's pose in these two methods.

    @law
    def pose(self) -> GzPose:
        """Global pose [m]."""
        raise NotImplementedError

    def move(self, pose: GzPose) -> None:
        """Set the global pose [m]; velocities stay."""
        raise NotImplementedError

    @law
    def _frame(self) -> GzPose:
        """Global pose of the parent [m]."""
        return self._parent.pose() if isinstance(self._parent, Entity) else GzPose()

    @law
    def WorldPose(self) -> Pose3d:
        """Global pose [m]."""
        return Pose3d(self.pose())

    GetWorldPose = WorldPose

    def DirtyPose(self) -> Pose3d:
        """The pose that the engine has, which `WorldPose` returns, too: none waits to be taken over."""
        return self.WorldPose()

    GetDirtyPose = DirtyPose

    def SetWorldPose(self, pose: GzPose, notify: bool = True, publish: bool = True) -> None:
        """Set the global pose [m], also as six numbers; velocities stay."""
        self.move(GzPoseOf(pose))

    @law
    def RelativePose(self) -> Pose3d:
        """Pose relative to the parent [m]."""
        return Pose3d(GzCoordPoseSub(self.pose(), self._frame()))

    GetRelativePose = RelativePose

    def SetRelativePose(self, pose: GzPose, notify: bool = True, publish: bool = True) -> None:
        """Set the pose relative to the parent [m], also as six numbers."""
        self.move(GzCoordPoseAdd(GzPoseOf(pose), self._frame()))

    def InitialRelativePose(self) -> Pose3d:
        """The pose relative to the parent that a reset restores [m]."""
        return Pose3d(self._initial) if self._initial is not None else self.RelativePose()

    def SetInitialRelativePose(self, pose: GzPose) -> None:
        """Set the pose that InitialRelativePose returns [m]; a reset restores it of models and links."""
        self._initial = Pose3d(pose)

    def IsCanonicalLink(self) -> bool:
        """Whether it is the link that the model's frame is fixed to."""
        return False

    def GetInitialRelativePose(self) -> Pose3d:
        """The old name of InitialRelativePose."""
        return self.InitialRelativePose()

    def IsStatic(self) -> bool:
        """Whether it is static."""
        return False

    def SetStatic(self, static: bool) -> None:
        """Make it static, or dynamic again; without effect on entities of static models and on lights."""

    # Velocity ----------------------------------------------------------------------------------------------------

    def WorldLinearVel(self) -> Vector3d:
        """Linear velocity of the frame's origin [m/s], in the world frame."""
        return Vector3d()

    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s], in the world frame."""
        return Vector3d()

    def RelativeLinearVel(self) -> Vector3d:
        """Linear velocity of the frame's origin [m/s], in its own frame."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldLinearVel()))

    def RelativeAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s], in its own frame."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldAngularVel()))

    def WorldLinearAccel(self) -> Vector3d:
        """Linear acceleration in the last step [m/s^2], in the world frame."""
        return Vector3d()

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step [rad/s^2], in the world frame."""
        return Vector3d()

    def RelativeLinearAccel(self) -> Vector3d:
        """Linear acceleration in the last step [m/s^2], in its own frame."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldLinearAccel()))

    def RelativeAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step [rad/s^2], in its own frame."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldAngularAccel()))

    def SetWorldTwist(self, linear: VectorLike, angular: VectorLike, updateChildren: bool = True) -> None:
        """Set linear [m/s] and angular [rad/s] velocity of a link or of all links of a model, in the world frame."""

    # The old names call the new ones, so that subclasses override the new ones only.

    def GetWorldLinearVel(self, *offset: Any) -> Vector3d:
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

    # Entities below ----------------------------------------------------------------------------------------------

    def BoundingBox(self) -> AxisAlignedBox:
        """The axis-aligned bounding box of all its collisions [m], in the world frame."""
        box = AxisAlignedBox()
        for part in self.children():
            if isinstance(part, Entity):
                box.Merge(part.BoundingBox())
        return box

    def GetBoundingBox(self) -> AxisAlignedBox:
        """The old name of BoundingBox."""
        return self.BoundingBox()

    def CollisionBoundingBox(self) -> AxisAlignedBox:
        """The axis-aligned bounding box of all collisions below it [m], in the world frame."""
        if self.HasType(Base.COLLISION):
            return self.BoundingBox()
        box = AxisAlignedBox()
        for part in self.tree():
            if part.HasType(Base.COLLISION) and isinstance(part, Entity):
                box.Merge(part.BoundingBox())
        return box

    GetCollisionBoundingBox = CollisionBoundingBox

    def GetChildLink(self, name: str) -> Link | Any:
        """A link below it by name or scoped name; None if there is none."""
        return find_named((part for part in self.tree() if part.HasType(Base.LINK)), name)

    def GetChildCollision(self, name: str) -> Base | Any:
        """A collision below it by name or scoped name; None if there is none."""
        return find_named((part for part in self.tree() if part.HasType(Base.COLLISION)), name)

    def GetNearestEntityBelow(self) -> tuple[float, str]:
        """(distance [m], scoped name) of the nearest collision below its lowest point; (1000, "") for none."""
        box = self.BoundingBox()
        bottom = min(self.pose().pos.z, box.Min().z) if self.children() else self.pose().pos.z
        where = self.pose().pos
        return self._world.ray_down(Vector3d(where.x, where.y, bottom - BELOW), self)

    def PlaceOnNearestEntityBelow(self) -> None:
        """Lower it onto the nearest entity below."""
        distance, name = self.GetNearestEntityBelow()
        if name:
            pose = self.pose()
            pose.pos.z -= distance + BELOW
            self.move(pose)

    def PlaceOnEntity(self, name: str) -> None:
        """Put it onto another entity, in the middle of that one's place and on top of its bounding box.

        Raises:
            NotFoundError: the world has no entity of this name.
        """
        below = self._world.EntityByName(name)
        if below is None:
            raise NotFoundError(f"the world has no entity {name!r} on which {self.GetScopedName()} could be placed")
        pose, box = below.WorldPose(), self.BoundingBox()
        pose.pos.z = below.BoundingBox().Max().z + box.Size().z / 2.0
        self.SetWorldPose(pose)

    # Animation ---------------------------------------------------------------------------------------------------

    def SetAnimation(self, animation: PoseAnimation, onComplete: Callable[[], object] | None = None) -> None:
        """Play an animation of its pose relative to the parent, in sim time; call `onComplete` at the end."""
        self._world.server.activity.animations.start(self, animation, onComplete)

    def StopAnimation(self) -> None:
        """Stop its animation; it stays at the present pose."""
        self._world.server.activity.animations.stop(self)
