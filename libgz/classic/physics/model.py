"""Model: links, joints and nested models."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ClosedError
from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, VectorLike
from libgz.base.law import constant, law
from libgz.classic.math import AxisAlignedBox, Pose3d, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.base import Base, Entity, view_of
from libgz.classic.physics.gripper import Gripper
from libgz.classic.physics.joint import FIRST_PITCH, Joint, first_axes
from libgz.classic.physics.link import Link
from libgz.physics.geom import Geom
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.model import SdfModel
from libgz.simulation.entity import Entity as CoreModel

if TYPE_CHECKING:
    from libgz.classic.common import NumericAnimation
    from libgz.classic.physics.joint_controller import JointController
    from libgz.classic.physics.state import ModelState
    from libgz.classic.physics.world import World
    from libgz.physics.body import Body
    from libgz.sdf.element import Element

__all__ = ["Model"]


@takes_names
class Model(Entity):
    """A view on a model of the engine: one built from SDF, or a legacy model."""

    entity_type = Base.ENTITY | Base.MODEL

    def __init__(self, world: World, core: CoreModel, parent: Model | None) -> None:
        name = core.GetId().rpartition("::")[2]
        super().__init__(world, name, parent, getattr(core, "sdf", None))
        self.core = core

    def children(self) -> list[Base]:
        """Links, joints, then nested models."""
        return [*self.GetLinks(), *self.GetJoints(), *self.NestedModels()]

    # Pose and motion ---------------------------------------------------------------------------------------------

    @law
    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.core.GetPose()

    def move(self, pose: GzPose) -> None:
        """Set the global pose [m]: all links, those of nested models too, move with it; velocities stay."""
        before = self.core.GetPose()
        for body in self._family_bodies():
            body.SetPose(GzCoordPoseAdd(GzCoordPoseSub(body.GetPose(), before), pose))
            body.Enable(True)

    def _family_bodies(self) -> Iterator[Body]:
        for model in self.family():
            yield from model.core.bodies

    def family(self) -> Iterator[Model]:
        """The model and all models nested in it, parents first."""
        yield self
        for model in self.NestedModels():
            yield from model.family()

    def InitialRelativePose(self) -> Pose3d:
        """The pose relative to the parent that a reset restores [m]."""
        return Pose3d(GzCoordPoseSub(self.core.initPose, self._first_frame()))

    def _first_frame(self) -> GzPose:
        """Where a reset puts the parent [m]."""
        return self._parent.core.initPose if isinstance(self._parent, Model) else GzPose()

    def remove(self) -> None:
        """Remove it from the world, with all nested models; in a callback, at the end of the iteration."""
        self._world.RemoveModel(self)

    def SetInitialRelativePose(self, pose: GzPose) -> None:
        """Set the pose that a reset restores, relative to the parent [m]; nested models keep their relative poses."""
        before, now = self.core.initPose, GzCoordPoseAdd(pose, self._first_frame())
        for model in self.family():
            model.core.initPose = GzCoordPoseAdd(GzCoordPoseSub(model.core.initPose, before), now)

    @law
    def WorldLinearVel(self) -> Vector3d:
        """Linear velocity of the canonical link's origin [m/s], in the world frame."""
        return self._canonical().WorldLinearVel()

    @law
    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity of the canonical link [rad/s], in the world frame."""
        return self._canonical().WorldAngularVel()

    def WorldLinearAccel(self) -> Vector3d:
        """Linear acceleration of the canonical link in the last step [m/s^2], in the world frame."""
        return self._canonical().WorldLinearAccel()

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration of the canonical link in the last step [rad/s^2], in the world frame."""
        return self._canonical().WorldAngularAccel()

    def RelativeLinearVel(self) -> Vector3d:
        """Linear velocity of the canonical link's origin [m/s], in that link's frame."""
        return self._canonical().RelativeLinearVel()

    def RelativeAngularVel(self) -> Vector3d:
        """Angular velocity of the canonical link [rad/s], in its frame."""
        return self._canonical().RelativeAngularVel()

    def RelativeLinearAccel(self) -> Vector3d:
        """Linear acceleration of the canonical link in the last step [m/s^2], in its frame."""
        return self._canonical().RelativeLinearAccel()

    def RelativeAngularAccel(self) -> Vector3d:
        """Angular acceleration of the canonical link in the last step [rad/s^2], in its frame."""
        return self._canonical().RelativeAngularAccel()

    GetRelativeLinearVel, GetRelativeAngularVel = RelativeLinearVel, RelativeAngularVel
    GetRelativeLinearAccel, GetRelativeAngularAccel = RelativeLinearAccel, RelativeAngularAccel

    @constant
    def _canonical(self) -> Link:
        """The one canonical link of a tree of models: the first of the outermost one that has a link."""
        tree: list[Model] = [self]
        while isinstance(parent := tree[0].GetParent(), Model):
            tree.insert(0, parent)
        return next((m.link(m.core.bodies[0]) for m in tree if m.core.bodies), None) or next(self.family_links())

    @law
    def SetLinearVel(self, vel: VectorLike) -> None:
        """Set the linear velocity of its own links [m/s], in the world frame; those of nested models keep theirs."""
        for link in self.GetLinks():
            link.SetLinearVel(vel)

    @law
    def SetAngularVel(self, vel: VectorLike) -> None:
        """Set the angular velocity of its own links [rad/s], in the world frame; those of nested models keep theirs."""
        for link in self.GetLinks():
            link.SetAngularVel(vel)

    def SetWorldTwist(self, linear: VectorLike, angular: VectorLike, updateChildren: bool = True) -> None:
        """Set linear [m/s] and angular [rad/s] velocity of all links, in the world frame."""
        self.SetLinearVel(linear)
        self.SetAngularVel(angular)

    def SetLinkWorldPose(self, pose: GzPose, which: str | Link) -> None:
        """Move the whole model so that a link, given by name or view, has a global pose [m]."""
        link = self.GetLink(which) if isinstance(which, str) else which
        if link is not None:
            offset = GzCoordPoseSub(self.core.GetPose(), link.pose())
            self.move(GzCoordPoseAdd(offset, pose))

    def ResetPhysicsStates(self) -> None:
        """Set velocities, forces and torques of all links to zero."""
        for link in self.family_links():
            link.ResetPhysicsStates()

    def Reset(self, resetType: int = 0) -> None:
        """Return it to its initial pose at rest, and reset controllers, batteries and plugins.

        As in Gazebo its links keep their places in it, and its joints their positions; `World.Reset` restores those.
        """
        self.SetRelativePose(self.InitialRelativePose())
        self.ResetPhysicsStates()
        self._reset_parts()

    def restore(self) -> None:
        """Reset it, with all links, also those of nested models, where they were at the beginning."""
        self.core.restore()
        self._reset_parts()

    def _reset_parts(self) -> None:
        for joint in self.GetJoints():
            joint.Reset()
        self._world.server.activity.reset_model(self)
        self._world.server.plugins.reset_of(self)

    def GetWorldEnergyPotential(self) -> float:
        """Potential energy of its own links and of the springs of its own joints [J]."""
        springs = sum(joint.GetWorldEnergyPotentialSpring(i) for joint in self.GetJoints() for i in range(joint.DOF()))
        return springs + sum(link.GetWorldEnergyPotential() for link in self.GetLinks())

    def GetWorldEnergyKinetic(self) -> float:
        """Kinetic energy of its own links [J]."""
        return sum(link.GetWorldEnergyKinetic() for link in self.GetLinks())

    def GetWorldEnergy(self) -> float:
        """The sum of potential and kinetic energy [J]."""
        return self.GetWorldEnergyPotential() + self.GetWorldEnergyKinetic()

    # Links -------------------------------------------------------------------------------------------------------

    @constant
    def GetLinks(self) -> list[Link]:
        """Its links, in the order of the file."""
        return [self.link(body) for body in self.core.bodies]

    def link(self, body: Body) -> Link:
        """The view on a body."""
        return view_of(body, lambda: self._new_link(body))

    def _new_link(self, body: Body) -> Link:
        name = self.body_name(body)
        return Link(self, name, body, self._element("link", name))

    def body_name(self, body: Body) -> str:
        """The name of a link."""
        return body.bodyName or f"link_{self.core.bodies.index(body)}"

    def GetLink(self, name: str = "canonical") -> Link | Any:
        """A link by name or ``nested::link``; None if there is none.

        ``canonical`` is the first link of the outermost model around it that has links.
        """
        links = self.GetLinks()
        if name == "canonical":
            return self._canonical()
        found = next((link for link in links if name in (link.GetName(), link.GetScopedName())), None)
        model, separator, rest = name.partition("::")
        if found is None and separator:
            inner = self if model == self.GetName() else self.NestedModel(model)
            return inner.GetLink(rest) if inner is not None else None
        return found

    def family_links(self) -> Iterator[Link]:
        """Its links and those of nested models."""
        for model in self.family():
            yield from model.GetLinks()

    def CreateLink(self, name: str) -> Link | Any:
        """Add a link without shapes, of 1 kg, at the model's pose; None if the name is taken.

        Raises:
            ClosedError: the model was removed from the world.
        """
        if self.core not in self._world.core.models:
            raise ClosedError(f"model {self.GetScopedName()!r} was removed from the world; no link can be added to it")
        if self.GetLink(name) is not None or not isinstance(self.core, SdfModel):
            return None
        return self.link(self.core.create_link(name))

    def _element(self, kind: str, name: str) -> Element | None:
        sdf = self._sdf
        return next((e for e in sdf.named(kind) if e.Get(str, "name") == name), None) if sdf is not None else None

    def geom_name(self, geom: Geom) -> str:
        """The name of a collision or visual."""
        names = self.core.geom_names if isinstance(self.core, SdfModel) else {}
        return names.get(geom) or f"geom_{geom.body.geoms.index(geom)}"

    def geom_sdf(self, geom: Geom) -> Element | None:
        """The element of a collision or visual; None if there was none."""
        link = self._element("link", self.body_name(geom.body))
        kind, name = ("visual" if geom.space is None else "collision"), self.geom_name(geom)
        return next((e for e in link.named(kind) if e.Get(str, "name") == name), None) if link is not None else None

    # Joints ------------------------------------------------------------------------------------------------------

    def GetJoints(self) -> list[Joint]:
        """Its joints, in the order of the file."""
        cores = self.core.sdf_joints.values() if isinstance(self.core, SdfModel) else ()
        return [self.joint(core) for core in cores]

    def all_joints(self) -> Iterator[Joint]:
        """Its joints and those of nested models."""
        for model in self.family():
            yield from model.GetJoints()

    def GetJoint(self, name: str) -> Joint | Any:
        """A joint by name or ``nested::joint``; None if there is none."""
        return next((j for j in self.all_joints() if name in (j.GetName(), j.GetScopedName(), self._inside(j))), None)

    def _inside(self, part: Base) -> str:
        """The name of a descendant, relative to this model."""
        return part.GetScopedName().removeprefix(f"{self.GetScopedName()}::")

    def GetJointCount(self) -> int:
        """The number of its joints, without those of nested models."""
        return len(self.GetJoints())

    def CreateJoint(
        self, name: str | Element, kind: str = "", parent: Link | None = None, child: Link | None = None
    ) -> Joint | None:
        """Add a joint from a `<joint>` element, or by name, kind, parent and child; None if the name is taken.

        By name, anchor and axes are ODE's, as in Gazebo, until SetAnchor and SetAxis change them, or Init moves the
        anchor to the child's origin. The anchor is the child's centre of mass, of ``revolute2`` the parent's, of
        ``fixed`` the child's origin. The axis is x of the child; axes of ``universal`` are y of the parent and x of the
        child, of ``revolute2`` x of the parent and y of the child, of ``gearbox`` z of the world. The thread_pitch of
        a ``screw`` is -1.
        """
        core, text = self.core, name if isinstance(name, str) else name.Get(str, "name")
        if not isinstance(core, SdfModel) or text in core.sdf_joints:
            return None
        if not isinstance(name, str):
            made = core.add_joint(name)
        else:
            ends = [link.body if link is not None else None for link in (parent, child)]
            made = core.make_joint(text, kind, ends[0], ends[1], *first_axes(kind), pitch=FIRST_PITCH)
        if made is None:
            return None
        joint = self.joint(made)
        joint.anchored = not isinstance(name, str)
        self._world.server.joint_added(joint)
        return joint

    def joint(self, core: SdfJoint) -> Joint:
        """The view on a joint of the engine."""
        return view_of(core, lambda: Joint(self._world, self, core))

    def RemoveJoint(self, name: str) -> bool:
        """Remove a joint; returns whether there was one."""
        joint = self.GetJoint(name)
        if joint is None:
            return False
        joint.remove()
        return True

    def GetJointController(self) -> JointController:
        """The controller of its joints, created on first use."""
        return self._world.server.activity.controller_of(self)

    def SetJointPosition(self, jointName: str, position: float, index: int = 0) -> None:
        """Set the position of a joint [rad] or [m] at once."""
        self.GetJointController().SetJointPosition(jointName, position, index)

    def SetJointPositions(self, jointPositions: dict[str, float]) -> None:
        """Set the positions of joints [rad] or [m] at once."""
        self.GetJointController().SetJointPositions(jointPositions)

    def SetJointAnimation(
        self, animations: dict[str, NumericAnimation], onComplete: Callable[[], object] | None = None
    ) -> None:
        """Play animations of joint positions, in sim time; call `onComplete` at the end."""
        self._world.server.activity.animations.start_joints(self, animations, onComplete)

    def StopAnimation(self) -> None:
        """Stop its animations; the model and its joints stay at their present positions."""
        self._world.server.activity.animations.stop(self)

    # Nested models -----------------------------------------------------------------------------------------------

    def NestedModels(self) -> list[Model]:
        """The models nested directly in it."""
        views = (self._world.view(core) for core in self.core.children)
        return [model for model in views if model.GetParent() is self]

    def NestedModel(self, name: str) -> Model | Any:
        """A nested model by name; None if there is none."""
        return next((m for m in self.NestedModels() if name in (m.GetName(), m.GetScopedName())), None)

    def AttachStaticModel(self, model: Model, offset: GzPose) -> None:
        """Move another model with this one, at an offset [m]; there are no forces between them."""
        self._world.server.activity.attach(self, model, offset)

    def DetachStaticModel(self, model: str) -> None:
        """Undo AttachStaticModel for a model by name."""
        self._world.server.activity.detach(self, model)

    # Switches ----------------------------------------------------------------------------------------------------

    def IsStatic(self) -> bool:
        """Whether it never moves by itself: as its file says, or since SetStatic."""
        if getattr(self.core, "static", False):
            return True
        made = [link.IsStatic() for link in self.family_links()]
        return bool(made) and all(made)

    def SetStatic(self, static: bool) -> None:
        """Make all its links kinematic and stop them, or dynamic again."""
        for link in self.family_links():
            link.SetStatic(static)

    def SetCollideMode(self, mode: str) -> None:
        """Set the collide mode of all its collisions; see Collision.SetCollideMode."""
        for link in self.family_links():
            link.SetCollideMode(mode)

    def SetGravityMode(self, value: bool) -> None:
        """Enable or disable gravity for its own links."""
        for link in self.GetLinks():
            link.SetGravityMode(value)

    def SetEnabled(self, enabled: bool) -> None:
        """Wake its own links, or put them to sleep (auto-disabled)."""
        for link in self.GetLinks():
            link.SetEnabled(enabled)

    def SetAutoDisable(self, disable: bool) -> None:
        """Enable or disable auto-disable, sleep while at rest; without effect on models with joints."""
        for link in self._sleepers():
            link.SetAutoDisable(disable)

    def _sleepers(self) -> Iterator[Link]:
        """The links that may be auto-disabled: of models without joints."""
        for model in self.family():
            if not model.GetJoints():
                yield from (link for link in model.GetLinks() if not link.body.joints)

    def GetAutoDisable(self) -> bool:
        """Whether one of its links sleeps at rest."""
        return any(link.body.auto_disable for link in self._sleepers())

    def BoundingBox(self) -> AxisAlignedBox:
        """The axis-aligned bounding box of its own links [m], in the world frame; CollisionBoundingBox has all."""
        box = AxisAlignedBox()
        for link in self.GetLinks():
            box.Merge(link.BoundingBox())
        return box

    def SetSelfCollide(self, self_collide: bool) -> None:
        """Enable or disable contacts between its links."""
        for link in self.family_links():
            link.SetSelfCollide(self_collide)

    def GetSelfCollide(self) -> bool:
        """Whether all its links have contacts with each other."""
        links = list(self.family_links())
        return bool(links) and all(link.GetSelfCollide() for link in links)

    def SetState(self, state: ModelState) -> None:
        """Set poses and velocities of links to those of a state, those of nested models too."""
        state.apply(self)

    def SetLaserRetro(self, retro: float) -> None:
        """Set the laser retro value of all its collisions."""
        for link in self.family_links():
            link.SetLaserRetro(retro)

    def SetScale(self, scale: VectorLike, publish: bool = False) -> None:
        """Scale all its shapes, collisions and visuals, to this multiple of their first sizes.

        Poses, meshes and masses do not change.
        """
        for link in self.family_links():
            link.SetScale(scale)

    def Scale(self) -> Vector3d:
        """The multiple of the first sizes that SetScale has set."""
        geoms = (geom for link in self.family_links() for geom in link.body.geoms)
        return Vector3d(*next((geom.scale for geom in geoms), (1.0, 1.0, 1.0)))

    def SetWindMode(self, mode: bool) -> None:
        """Put its own links into the wind, or out of it."""
        for link in self.GetLinks():
            link.SetWindMode(mode)

    def WindMode(self) -> bool:
        """Whether all its own links are in the wind."""
        links = self.GetLinks()
        return bool(links) and all(link.WindMode() for link in links)

    # Grippers ----------------------------------------------------------------------------------------------------

    def GetGripperCount(self) -> int:
        """The number of its grippers."""
        return len(self._grippers())

    def GetGripper(self, which: int | str) -> Gripper | Any:
        """A gripper by index or name; None if there is none."""
        found = self._grippers()
        if isinstance(which, int):
            return found[which] if 0 <= which < len(found) else None
        return next((gripper for gripper in found if gripper.GetName() == which), None)

    def _grippers(self) -> list[Gripper]:
        cores = self.core.grippers.values() if isinstance(self.core, SdfModel) else ()
        return [view_of(core, functools.partial(Gripper, self, core)) for core in cores]

    # Sensors and plugins -----------------------------------------------------------------------------------------

    def SensorScopedName(self, name: str) -> list[str]:
        """The full scoped names of its sensors with this name."""
        prefix = f"{self.GetScopedName(True)}::"
        return [
            full for full in self._world.server.sensor_names() if full.startswith(prefix) and full.endswith(f"::{name}")
        ]

    def GetSensorCount(self) -> int:
        """The number of sensors on its links."""
        return sum(link.GetSensorCount() for link in self.family_links())

    def GetPluginCount(self) -> int:
        """The number of its `<plugin>` elements."""
        return sum(1 for _ in self._sdf.named("plugin")) if self._sdf is not None else 0

    def AttachPlugin(self, filename: str, name: str, sdf: Element | None = None) -> bool:
        """Load a plugin for it now; returns whether it runs."""
        return self._world.server.plugins.load_for_model(self, filename, name, sdf)
