"""Model: links and joints that belong together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.physics.base import Base, Entity, view_of
from libgz.classic.physics.joint import Joint, first_axes
from libgz.classic.physics.joint_controller import JointController
from libgz.classic.physics.link import Link
from libgz.classic.physics.shape import shape_of
from libgz.errors import ClosedError
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, VectorLike
from libgz.physics.geom import Geom
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.model import SdfModel
from libgz.simulation.entity import Entity as CoreModel

if TYPE_CHECKING:
    from libgz.classic.common import NumericAnimation
    from libgz.classic.physics.world import World
    from libgz.physics.body import Body
    from libgz.sdf.element import Element

__all__ = ["Model"]


class Model(Entity):
    """A view on a model of the engine: one built from SDF, or a legacy one."""

    entity_type = Base.ENTITY | Base.MODEL

    def __init__(self, world: World, core: CoreModel, parent: Model | None) -> None:
        name = core.GetId().rpartition("::")[2]
        super().__init__(world, name, parent, getattr(core, "sdf", None))
        self.core = core
        self.controller: JointController | None = None
        self.plugins: list[Any] = []  # what the server loaded for it

    def children(self) -> list[Base]:
        """Links, joints, then nested models."""
        return [*self.GetLinks(), *self.GetJoints(), *self.NestedModels()]

    # Pose and motion ---------------------------------------------------------------------------------------------

    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.core.GetPose()

    def move(self, pose: GzPose) -> None:
        """Move all links, those of nested and attached models included, as one [m]; velocities stay."""
        before = self.core.GetPose()
        for body in self._family_bodies():
            body.SetPose(GzCoordPoseAdd(GzCoordPoseSub(body.GetPose(), before), pose))
            body.Enable(True)

    def _family_bodies(self) -> Iterator[Body]:
        for model in self.family():
            yield from model.core.bodies

    def family(self) -> Iterator[Model]:
        """Itself and the models nested in it or attached to it, parents first."""
        yield self
        for model in self.NestedModels():
            yield from model.family()

    def InitialRelativePose(self) -> Pose3d:
        """The pose that a reset goes back to [m]."""
        return Pose3d(GzCoordPoseSub(self.core.initPose, self._frame()))

    def SetInitialRelativePose(self, pose: GzPose) -> None:
        """Set the pose that a reset goes back to [m]; models inside keep their places in it."""
        before, now = self.core.initPose, GzCoordPoseAdd(pose, self._frame())
        for model in self.family():
            model.core.initPose = GzCoordPoseAdd(GzCoordPoseSub(model.core.initPose, before), now)

    def WorldLinearVel(self) -> Vector3d:
        """Velocity of the first link's origin [m/s], global."""
        return self._canonical().WorldLinearVel()

    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity of the first link [rad/s], global."""
        return self._canonical().WorldAngularVel()

    def WorldLinearAccel(self) -> Vector3d:
        """Acceleration of the first link in the last step [m/s^2], global."""
        return self._canonical().WorldLinearAccel()

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration of the first link in the last step [rad/s^2], global."""
        return self._canonical().WorldAngularAccel()

    def _canonical(self) -> Link:
        return self.GetLinks()[0] if self.core.bodies else next(self.family_links())

    def SetLinearVel(self, vel: VectorLike) -> None:
        """Set the velocity of all links [m/s], global."""
        for link in self.family_links():
            link.SetLinearVel(vel)

    def SetAngularVel(self, vel: VectorLike) -> None:
        """Set the angular velocity of all links [rad/s], global."""
        for link in self.family_links():
            link.SetAngularVel(vel)

    def SetWorldTwist(self, linear: VectorLike, angular: VectorLike, updateChildren: bool = True) -> None:
        """Set both velocities of all links [m/s], [rad/s]."""
        self.SetLinearVel(linear)
        self.SetAngularVel(angular)

    def SetLinkWorldPose(self, pose: GzPose, which: str | Link) -> None:
        """Move the whole model so that one link, by name or itself, comes to a global pose [m]."""
        link = self.GetLink(which) if isinstance(which, str) else which
        if link is not None:
            offset = GzCoordPoseSub(self.core.GetPose(), link.pose())
            self.move(GzCoordPoseAdd(offset, pose))

    def ResetPhysicsStates(self) -> None:
        """Stop all links."""
        for link in self.family_links():
            link.ResetPhysicsStates()

    def Reset(self, resetType: int = 0) -> None:
        """Put it back to where it began, at rest, and reset its plugins."""
        self.core.restore()
        self.after_reset()

    def after_reset(self) -> None:
        """Its links were put back: so are its joints, their controller, and its plugins."""
        for joint in self.GetJoints():
            joint.Reset()
        for link in self.GetLinks():
            for battery in link.batteries:
                battery.ResetVoltage()
        if self.controller is not None:
            self.controller.Reset()
        with self._world.core.hold():
            for plugin in list(self.plugins):
                plugin.call("Reset")

    def GetWorldEnergyPotential(self) -> float:
        """Potential energy of all links [J]."""
        return sum(link.GetWorldEnergyPotential() for link in self.family_links())

    def GetWorldEnergyKinetic(self) -> float:
        """Energy of motion of all links [J]."""
        return sum(link.GetWorldEnergyKinetic() for link in self.family_links())

    def GetWorldEnergy(self) -> float:
        """All energy of all links [J]."""
        return self.GetWorldEnergyPotential() + self.GetWorldEnergyKinetic()

    # Links -------------------------------------------------------------------------------------------------------

    def GetLinks(self) -> list[Link]:
        """Its links in order."""
        return [self.link(body) for body in self.core.bodies]

    def link(self, body: Body) -> Link:
        """The view on a body."""
        name = self.body_name(body)
        return view_of(body, lambda: Link(self, name, body, self._element("link", name)))

    def body_name(self, body: Body) -> str:
        """The name of a link."""
        return body.bodyName or f"link_{self.core.bodies.index(body)}"

    def GetLink(self, name: str = "canonical") -> Link | None:
        """A link by name, also ``nested::link``; the first one for ``canonical``; None if there is none."""
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

    def CreateLink(self, name: str) -> Link | None:
        """Add a link without shapes, of 1 kg, at the model's pose; None if the name is taken.

        Raises:
            ClosedError: the model has left the world.
        """
        if self.core not in self._world.core.models:
            raise ClosedError(f"model {self.GetScopedName()!r} has left the world; it can be given no link")
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
        """Its joints in order."""
        cores = self.core.sdf_joints.values() if isinstance(self.core, SdfModel) else ()
        return [self.joint(core) for core in cores]

    def all_joints(self) -> Iterator[Joint]:
        """Its joints and those of nested models."""
        for model in self.family():
            yield from model.GetJoints()

    def GetJoint(self, name: str) -> Joint | None:
        """A joint by name, also ``nested::joint``; None if there is none."""
        return next((j for j in self.all_joints() if name in (j.GetName(), j.GetScopedName(), self._inside(j))), None)

    def _inside(self, part: Base) -> str:
        """The name of a part as seen from this model."""
        return part.GetScopedName().removeprefix(f"{self.GetScopedName()}::")

    def GetJointCount(self) -> int:
        """How many joints there are, those of nested models included."""
        return sum(1 for _ in self.all_joints())

    def CreateJoint(
        self, name: str | Element, kind: str = "", parent: Link | None = None, child: Link | None = None
    ) -> Joint | None:
        """Add a joint from a `<joint>` element, or by name, kind, parent and child; None if the name is taken.

        By name, its frame is the child's, and its axes are the world's z and, for a second one, x.
        """
        core, text = self.core, name if isinstance(name, str) else name.Get(str, "name")
        if not isinstance(core, SdfModel) or text in core.sdf_joints:
            return None
        if not isinstance(name, str):
            made = core.add_joint(name)
        else:
            ends = [link.body if link is not None else None for link in (parent, child)]
            made = core.make_joint(text, kind, ends[0], ends[1], *first_axes(kind))
        if made is None:
            return None
        joint = self.joint(made)
        self._world.server.joint_added(joint)
        return joint

    def joint(self, core: SdfJoint) -> Joint:
        """The view on a joint of the engine."""
        return view_of(core, lambda: Joint(self._world, self, core))

    def RemoveJoint(self, name: str) -> bool:
        """Take a joint out; whether there was one."""
        joint = self.GetJoint(name)
        if joint is None:
            return False
        joint.remove()
        return True

    def GetJointController(self) -> JointController:
        """What holds its joints at positions and velocities."""
        if self.controller is None:
            self.controller = JointController(self)
            self._world.controllers.append(self.controller)
        return self.controller

    def SetJointPosition(self, jointName: str, position: float, index: int = 0) -> None:
        """Bring a joint to a position [rad] or [m] at once."""
        self.GetJointController().SetJointPosition(jointName, position, index)

    def SetJointPositions(self, jointPositions: dict[str, float]) -> None:
        """Bring joints to positions [rad] or [m] at once."""
        self.GetJointController().SetJointPositions(jointPositions)

    def SetJointAnimation(
        self, animations: dict[str, NumericAnimation], onComplete: Callable[[], object] | None = None
    ) -> None:
        """Move joints along animations of their positions, by sim time; then call `onComplete`."""
        self._world.animations.start_joints(self, animations, onComplete)

    def StopAnimation(self) -> None:
        """Leave it, and its joints, where animations have brought them."""
        self._world.animations.stop(self)

    # Nested models -----------------------------------------------------------------------------------------------

    def NestedModels(self) -> list[Model]:
        """The models directly inside it."""
        views = (self._world.view(core) for core in self.core.children)
        return [model for model in views if model.GetParent() is self]

    def NestedModel(self, name: str) -> Model | None:
        """A model inside it by name; None if there is none."""
        return next((m for m in self.NestedModels() if name in (m.GetName(), m.GetScopedName())), None)

    def AttachStaticModel(self, model: Model, offset: GzPose) -> None:
        """Carry another model along, without weight or collision between them, at an offset [m]."""
        self._world.attach(self, model, offset)

    def DetachStaticModel(self, model: str) -> None:
        """Let go a model that was attached."""
        self._world.detach(self, model)

    # Switches ----------------------------------------------------------------------------------------------------

    def IsStatic(self) -> bool:
        """Whether it never moves by itself."""
        return bool(getattr(self.core, "static", False))

    def SetStatic(self, static: bool) -> None:
        """Hold all its links where they are, or let them go."""
        for link in self.family_links():
            link.SetStatic(static)

    def SetCollideMode(self, mode: str) -> None:
        """What it touches: ``all``, ``none``, ``sensors`` or ``ghost``."""
        for link in self.family_links():
            link.SetCollideMode(mode)

    def SetGravityMode(self, value: bool) -> None:
        """Whether gravity acts on it."""
        for link in self.family_links():
            link.SetGravityMode(value)

    def SetEnabled(self, enabled: bool) -> None:
        """Wake it, or put it to sleep."""
        for link in self.family_links():
            link.SetEnabled(enabled)

    def SetAutoDisable(self, disable: bool) -> None:
        """Whether its links may fall asleep at rest; without effect where there are joints."""
        if not self.GetJointCount():
            for link in self.family_links():
                link.SetAutoDisable(disable)

    def SetLaserRetro(self, retro: float) -> None:
        """How much it reflects of a laser."""
        for link in self.family_links():
            link.SetLaserRetro(retro)

    def SetScale(self, scale: VectorLike, publish: bool = False) -> None:
        """Make all its shapes, collisions and visuals, so many times as large as they were at first.

        Places stay, and so do meshes and masses.
        """
        for link in self.family_links():
            for geom in link.body.geoms:
                shape_of(geom).SetScale(scale)

    # Sensors and plugins -----------------------------------------------------------------------------------------

    def SensorScopedName(self, name: str) -> list[str]:
        """Full names of its sensors of this name."""
        prefix = f"{self.GetScopedName(True)}::"
        return [full for full in self._world.sensor_names() if full.startswith(prefix) and full.endswith(f"::{name}")]

    def GetSensorCount(self) -> int:
        """How many sensors it carries."""
        return sum(link.GetSensorCount() for link in self.family_links())

    def GetPluginCount(self) -> int:
        """How many `<plugin>` elements it has."""
        return sum(1 for _ in self._sdf.named("plugin")) if self._sdf is not None else 0

    def AttachPlugin(self, filename: str, name: str, sdf: Element | None = None) -> bool:
        """Load a plugin for it now; whether it runs."""
        return self._world.load_model_plugin(self, filename, name, sdf)
