"""Link: a rigid body of a model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.base.errors import ClosedError, ParameterError
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzVectorAdd,
    GzVectorDot,
    QuaternLike,
    VectorLike,
    rotate,
)
from libgz.base.law import law
from libgz.classic.math import Matrix3d, Pose3d, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.base import Base, Entity, view_of
from libgz.classic.physics.collision import Collision
from libgz.classic.physics.insertion import described
from libgz.classic.physics.shape import shape_of
from libgz.physics.geom import Geom
from libgz.sdfworld.model import SdfModel

if TYPE_CHECKING:
    from libgz.classic.common import Battery
    from libgz.classic.physics.inertial import Inertial
    from libgz.classic.physics.state import LinkState
    from libgz.classic.physics.world import Joint, Model
    from libgz.physics.body import Body
    from libgz.sdf.element import Element

__all__ = ["Link"]


@takes_names
class Link(Entity):
    """A view on a Body. Forces act for one step; vectors and poses are in the world frame unless stated otherwise."""

    STATE = ("inertial",)

    entity_type = Base.ENTITY | Base.LINK

    def __init__(self, model: Model, name: str, body: Body, sdf: Element | None) -> None:
        super().__init__(model.GetWorld(), name, model, sdf)
        self.model, self.body = model, body
        self._inertial: Inertial | None = None

    def children(self) -> list[Base]:
        """Its collisions."""
        return list(self.GetCollisions())

    def Load(self, sdf: Element) -> None:
        """Give a link of CreateLink what a `<link>` element has: pose, mass, collisions, visuals; its name stays.

        Raises:
            ParameterError: the link is one of the model's file, or a value is not allowed.
            WorldFileError: the element has errors; the message lists them all.
        """
        core = self.model.core
        if not isinstance(core, SdfModel) or not core.load_link(self.GetName(), described(sdf, "link")):
            raise ParameterError(
                f"link {self.GetScopedName()!r} is one of the model's file; Load takes those of CreateLink"
            )
        self._sdf, self._inertial = core.link_element(self.GetName()), None

    def Reset(self) -> None:
        """Return to the initial pose in the model, at rest."""
        self.ResetPhysicsStates()
        self.SetRelativePose(self.InitialRelativePose())

    def InitialRelativePose(self) -> Pose3d:
        """The pose in the model that a reset restores [m]."""
        core = self.model.core
        return Pose3d(core.first_place(self.body)) if isinstance(core, SdfModel) else self.RelativePose()

    def SetInitialRelativePose(self, pose: GzPose) -> None:
        """Set the pose in the model that a reset restores [m]; links of legacy models have none."""
        if isinstance(self.model.core, SdfModel):
            self.model.core.set_first_place(self.body, pose)

    def IsCanonicalLink(self) -> bool:
        """Whether it is the first link of a model, and no model around that has a link: a tree of models has one."""
        around = self.model.core.parent
        while isinstance(around, SdfModel):
            if around.bodies:
                return False
            around = around.parent
        return self.model.GetLink() is self

    # Pose and motion ---------------------------------------------------------------------------------------------

    @law
    def pose(self) -> GzPose:
        """Global pose [m]."""
        return self.body.GetPose()

    def move(self, pose: GzPose) -> None:
        """Set the global pose [m], and wake the link."""
        self.body.SetPose(pose)
        self.body.Enable(True)

    @law
    def WorldCoGPose(self) -> Pose3d:
        """Global pose of the centre of mass [m]; its rotation is the link's."""
        return Pose3d(self.body.GetCoMPose())

    GetWorldCoGPose = WorldCoGPose

    def WorldInertialPose(self) -> Pose3d:
        """Global pose of the frame of GetInertial(): at the centre of mass [m], along the axes of the moments."""
        return Pose3d(GzCoordPoseAdd(self.GetInertial().Pose(), self.body.GetPose()))

    GetWorldInertialPose = WorldInertialPose

    @law
    def WorldLinearVel(self, offset: VectorLike | None = None, q: QuaternLike | None = None) -> Vector3d:
        """Linear velocity [m/s] of the link's origin, or of a point at an offset from it [m].

        Args:
            offset: in the link's frame.
            q: the global rotation of the frame in which the offset is given instead.
        """
        pose = self.body.GetPose()
        turn = pose.rot if q is None else q
        point = pose.pos if offset is None else GzVectorAdd(pose.pos, rotate(turn, offset))
        return Vector3d(*self.body.GetPointVel(point))

    @law
    def WorldCoGLinearVel(self) -> Vector3d:
        """Linear velocity of the centre of mass [m/s]."""
        return Vector3d(*self.body.GetLinearVel())

    GetWorldCoGLinearVel = WorldCoGLinearVel

    @law
    def WorldAngularVel(self) -> Vector3d:
        """Angular velocity [rad/s]."""
        return Vector3d(*self.body.GetAngularRate())

    @law
    def SetLinearVel(self, vel: VectorLike) -> None:
        """Set the linear velocity of the centre of mass [m/s]."""
        self.body.SetLinearVel(vel)
        self.body.Enable(True)

    @law
    def SetAngularVel(self, vel: VectorLike) -> None:
        """Set the angular velocity [rad/s]."""
        self.body.SetAngularVel(vel)
        self.body.Enable(True)

    def SetWorldTwist(self, linear: VectorLike, angular: VectorLike, updateChildren: bool = True) -> None:
        """Set linear [m/s] and angular [rad/s] velocity."""
        self.SetLinearVel(linear)
        self.SetAngularVel(angular)

    def WorldLinearAccel(self) -> Vector3d:
        """Linear acceleration of the centre of mass in the last step [m/s^2]; zero before the first one."""
        return Vector3d(*self.body.GetLinearAccel())

    def WorldAngularAccel(self) -> Vector3d:
        """Angular acceleration in the last step [rad/s^2]; zero before the first one."""
        return Vector3d(*self.body.GetAngularAccel())

    # Forces ------------------------------------------------------------------------------------------------------

    @law
    def AddForce(self, force: VectorLike) -> None:
        """Add a force at the centre of mass [N]."""
        self._wake()
        self.body.AddForce(*force)

    @law
    def AddRelativeForce(self, force: VectorLike) -> None:
        """Add a force at the centre of mass [N], given in the link frame."""
        self._wake()
        self.body.AddRelForce(*force)

    @law
    def AddForceAtWorldPosition(self, force: VectorLike, pos: VectorLike) -> None:
        """Add a force [N] at a point [m], both in the world frame."""
        self._wake()
        self.body.AddForceAtPos(*force, *pos)

    @law
    def AddForceAtRelativePosition(self, force: VectorLike, relPos: VectorLike) -> None:
        """Add a force in the world frame [N] at a point relative to the centre of mass, along the link's axes [m]."""
        self._wake()
        self.body.AddForceAtRelPos(*force, *relPos)

    @law
    def AddLinkForce(self, force: VectorLike, offset: VectorLike = (0.0, 0.0, 0.0)) -> None:
        """Add a force [N] at a point [m], both in the link frame."""
        self._wake()
        pose = self.body.GetPose()
        point = GzVectorAdd(pose.pos, rotate(pose.rot, offset))
        self.body.AddForceAtPos(*rotate(pose.rot, force), *point)

    @law
    def AddTorque(self, torque: VectorLike) -> None:
        """Add a torque [N m]."""
        self._wake()
        self.body.AddTorque(*torque)

    @law
    def AddRelativeTorque(self, torque: VectorLike) -> None:
        """Add a torque [N m], given in the link frame."""
        self._wake()
        self.body.AddRelTorque(*torque)

    def SetForce(self, force: VectorLike) -> None:
        """Replace the force that acts in the next step [N]."""
        self._wake()
        self.body.SetForce(force)

    def SetTorque(self, torque: VectorLike) -> None:
        """Replace the torque that acts in the next step [N m]."""
        self._wake()
        self.body.SetTorque(*torque)

    def WorldForce(self) -> Vector3d:
        """The whole force at the centre of mass in the last step [N]: applied, gravity, joints and contacts.

        Forces that were added since act in the next step.
        """
        if self.body.kinematic:
            return Vector3d(*self.body.GetAppliedForce()) + Vector3d(*self.body.GetWeight())
        return Vector3d(*self.body.GetLinearAccel()) * self.body.mass

    def WorldTorque(self) -> Vector3d:
        """The whole torque about the centre of mass in the last step [N m]: applied, gyroscopic, joints and contacts.

        Torques that were added since act in the next step.
        """
        if self.body.kinematic:
            return Vector3d(*self.body.GetAppliedTorque())
        return self.WorldInertiaMatrix() * Vector3d(*self.body.GetAngularAccel())

    def RelativeForce(self) -> Vector3d:
        """WorldForce in the link frame [N]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldForce()))

    def RelativeTorque(self) -> Vector3d:
        """WorldTorque in the link frame [N m]."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldTorque()))

    GetWorldForce = WorldForce
    GetWorldTorque = WorldTorque
    GetRelativeForce = RelativeForce
    GetRelativeTorque = RelativeTorque

    @law
    def _wake(self) -> None:
        self.body.Enable(True)

    def MoveFrame(self, worldReferenceFrameSrc: GzPose, worldReferenceFrameDst: GzPose) -> None:
        """Move it as a frame moves from one global pose to another [m], and stop it."""
        self.SetWorldPose(GzCoordPoseAdd(GzCoordPoseSub(self.pose(), worldReferenceFrameSrc), worldReferenceFrameDst))
        self.SetWorldTwist((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))

    def ResetPhysicsStates(self) -> None:
        """Set velocities, force and torque to zero."""
        self.body.SetLinearVel((0.0, 0.0, 0.0))
        self.body.SetAngularVel((0.0, 0.0, 0.0))
        self.body.SetForce((0.0, 0.0, 0.0))
        self.body.SetTorque(0.0, 0.0, 0.0)

    # Mass --------------------------------------------------------------------------------------------------------

    def GetInertial(self) -> Inertial:
        """Mass and inertia: the same object at each call. Changes to it act at UpdateMass."""
        if self._inertial is None:
            from libgz.classic.physics.inertial import Inertial

            self._inertial = Inertial(self.body, self._sdf)
            self._world.server.activity.edited[self] = None
        return self._inertial

    @property
    def inertial(self) -> Inertial:
        """The same, for states."""
        return self.GetInertial()

    def forget_edits(self) -> None:
        """Take mass and inertia from the file and the body: a state is loaded that has no changes of them."""
        if self._inertial is not None:
            self._inertial.forget()

    def SetInertial(self, inertial: Inertial) -> None:
        """Set mass and inertia to a copy of these values, at once.

        Raises:
            ParameterError: no body can have them; the link keeps its own.
        """
        own = self.GetInertial()
        own.copy_from(inertial)
        own.apply()

    def UpdateMass(self) -> None:
        """Make the changes of GetInertial() act.

        Raises:
            ParameterError: no body can have these values; link and GetInertial() keep those before the changes.
        """
        if self._inertial is not None:
            self._inertial.apply()

    def WorldInertiaMatrix(self) -> Matrix3d:
        """The matrix of inertia about the centre of mass [kg m^2], along the world's axes."""
        mass = self.body.GetMass()
        turn = np.array([rotate(self.body.GetRotation(), axis) for axis in np.eye(3)]).T
        inertia = np.array(mass.I[:12]).reshape(3, 4)[:, :3]
        return Matrix3d(*(turn @ inertia @ turn.T).ravel().tolist())

    GetWorldInertiaMatrix = WorldInertiaMatrix

    def WorldAngularMomentum(self) -> Vector3d:
        """Angular momentum about the centre of mass [kg m^2/s]."""
        return Vector3d(*(self.WorldInertiaMatrix() * self.WorldAngularVel()))

    def GetWorldEnergyPotential(self) -> float:
        """Potential energy in the gravity field, relative to the world's origin [J]."""
        gravity = self._world.core.engine.gravity
        return -self.body.mass * GzVectorDot(gravity, self.body.GetCoMPose().pos)

    def GetWorldEnergyKinetic(self) -> float:
        """Kinetic energy [J]."""
        return self.body.GetKineticEnergy()

    def GetWorldEnergy(self) -> float:
        """The sum of potential and kinetic energy [J]."""
        return self.GetWorldEnergyPotential() + self.GetWorldEnergyKinetic()

    # Switches ----------------------------------------------------------------------------------------------------

    def IsStatic(self) -> bool:
        """Whether its model is static, or SetStatic made it so."""
        return self.body.dummy or self.body.made_static

    def SetLinkStatic(self, static: bool) -> None:
        """Make it kinematic and stop it, or dynamic again."""
        self.SetKinematic(static)
        if static:
            self.ResetPhysicsStates()

    def SetGravityMode(self, mode: bool) -> None:
        """Enable or disable gravity for it."""
        self.body.SetGravityMode(mode)

    def GetGravityMode(self) -> bool:
        """Whether gravity acts on it."""
        return bool(self.body.GetGravityMode())

    def SetWindMode(self, mode: bool) -> None:
        """Put it into the wind, or out of it."""
        self.body.in_wind = bool(mode)

    def WindMode(self) -> bool:
        """Whether it is in the wind."""
        return self.body.in_wind

    def WorldWindLinearVel(self) -> Vector3d:
        """The wind that acts on it [m/s], in the world frame; zero if it is not in the wind, or wind is disabled."""
        return self._world.Wind().at_link(self)

    def RelativeWindLinearVel(self) -> Vector3d:
        """The wind that acts on it [m/s], in its own frame."""
        return Vector3d(*self.WorldPose().rot.RotateVectorReverse(self.WorldWindLinearVel()))

    SetWindEnabled = SetWindMode

    def SetKinematic(self, kinematic: bool) -> None:
        """Make it kinematic: moved by its velocity only, not by forces."""
        self.body.set_kinematic(kinematic)

    def GetKinematic(self) -> bool:
        """Whether it is kinematic: moved by its velocity only, not by forces."""
        return self.body.kinematic

    def SetEnabled(self, enable: bool) -> None:
        """Wake it, or put it to sleep (auto-disabled)."""
        self.body.Enable(enable)

    def GetEnabled(self) -> bool:
        """Whether it is awake; one that is static always is."""
        return self.body.IsEnabled() or self.IsStatic()

    def SetLinearDamping(self, damping: float) -> None:
        """Set the fraction of linear velocity that is lost in each step."""
        self.body.set_damping(damping, self.body.damping[1])

    def SetAngularDamping(self, damping: float) -> None:
        """Set the fraction of angular velocity that is lost in each step."""
        self.body.set_damping(self.body.damping[0], damping)

    def GetLinearDamping(self) -> float:
        """The fraction of linear velocity that is lost in each step."""
        return self.body.damping[0]

    def GetAngularDamping(self) -> float:
        """The fraction of angular velocity that is lost in each step."""
        return self.body.damping[1]

    def SetAutoDisable(self, disable: bool) -> None:
        """Enable or disable auto-disable: sleep while at rest."""
        self.body.set_auto_disable(disable)

    def SetSelfCollide(self, collide: bool) -> None:
        """Enable or disable contacts with other links of its model.

        Raises:
            ClosedError: the link was removed.
        """
        if self.body.closed:  # a space made for it now would never be removed
            raise ClosedError(f"link {self.GetScopedName()!r} was removed")
        if isinstance(self.model.core, SdfModel):
            self.model.core.set_self_collide(self.body, bool(collide))

    def GetSelfCollide(self) -> bool:
        """Whether it has contacts with other links of its model."""
        core = self.model.core
        return isinstance(core, SdfModel) and core.self_collides(self.body)

    def UpdateSurface(self) -> None:
        """Without effect: changes of a collision's surface act at once."""

    def SetScale(self, scale: VectorLike) -> None:
        """Scale its shapes, collisions and visuals, to this multiple of their first sizes."""
        for geom in self.body.geoms:
            shape_of(geom).SetScale(scale)

    def SetState(self, state: LinkState) -> None:
        """Set pose and velocity to those of a state."""
        state.apply(self)

    def SetCollideMode(self, mode: str) -> None:
        """Set the collide mode of its collisions; see Collision.SetCollideMode."""
        for collision in self.GetCollisions():
            collision.SetCollideMode(mode)

    def SetLaserRetro(self, retro: float) -> None:
        """Set the laser retro value of its collisions."""
        for collision in self.GetCollisions():
            collision.SetLaserRetro(retro)

    def SetStatic(self, static: bool) -> None:
        """Make it kinematic and stop it, or dynamic again."""
        self.SetLinkStatic(static)
        self.body.made_static = bool(static)

    # Batteries ---------------------------------------------------------------------------------------------------

    @property
    def batteries(self) -> list[Battery]:
        """Its batteries, in the order of the file."""
        return self._world.server.activity.batteries_of(self)

    def Battery(self, which: str | int) -> Battery | Any:
        """A battery by name or index; None if there is none."""
        if isinstance(which, int):
            return self.batteries[which] if 0 <= which < len(self.batteries) else None
        return next((battery for battery in self.batteries if battery.Name() == which), None)

    def BatteryCount(self) -> int:
        """The number of its batteries."""
        return len(self.batteries)

    # Children and joints -----------------------------------------------------------------------------------------

    def GetModel(self) -> Model:
        """The model."""
        return self.model

    def GetCollisions(self) -> list[Collision]:
        """Its collisions, in the order of the file."""
        return [self._collision(geom) for geom in self.body.geoms if geom.space is not None]

    def _collision(self, geom: Geom) -> Collision:
        return view_of(geom, lambda: Collision(self, geom))

    def GetCollision(self, which: str | int) -> Collision | Any:
        """A collision by name or index; None if there is none."""
        found = self.GetChild(which)
        return found if isinstance(found, Collision) else None

    def GetCollisionById(self, id: int) -> Collision | Any:
        """A collision by its GetId(); None if there is none."""
        return next((collision for collision in self.GetCollisions() if collision.GetId() == id), None)

    def visuals(self) -> list[Geom]:
        """The geoms that are rendered and have no contacts."""
        return [geom for geom in self.body.geoms if geom.space is None]

    def Visuals(self) -> dict[int, Any]:
        """The messages of type Visual that describe its `<visual>` elements, by the ids of these."""
        message = self._world.server.described(self)
        own = f"{self.GetScopedName()}::"
        return {visual.id: visual for visual in message.visual if visual.name.startswith(own)}

    def GetParentJoints(self) -> list[Joint]:
        """The joints that have it as child."""
        return [joint for joint in self._all_joints() if joint.GetChild() is self]

    def GetChildJoints(self) -> list[Joint]:
        """The joints that have it as parent."""
        return [joint for joint in self._all_joints() if joint.GetParent() is self]

    def GetParentJointsLinks(self) -> list[Link]:
        """The parent links of GetParentJoints."""
        return [link for joint in self.GetParentJoints() if (link := joint.GetParent()) is not None]

    def GetChildJointsLinks(self) -> list[Link]:
        """The child links of GetChildJoints."""
        return [link for joint in self.GetChildJoints() if (link := joint.GetChild()) is not None]

    def _all_joints(self) -> list[Joint]:
        return [joint for model in self._world.Models() for joint in model.all_joints()]

    def GetSensorCount(self) -> int:
        """The number of its sensors."""
        return len(self._sensor_names())

    def GetSensorName(self, index: int) -> str:
        """The scoped name of a sensor by index; an empty string if there is none."""
        names = self._sensor_names()
        return names[index] if 0 <= index < len(names) else ""

    def _sensor_names(self) -> list[str]:
        prefix = f"{self.GetScopedName(True)}::"
        return [name for name in self._world.server.sensor_names() if name.startswith(prefix)]
