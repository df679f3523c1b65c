"""Joint: a joint between two links, or a link and the world: its motion, forces and limits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzCoordPoseSub, GzPose, GzQuaternInverse, GzVector, GzVectorDot, VectorLike, rotate
from libgz.base.law import law
from libgz.classic.math import Pose3d, Quaterniond, Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.base import Base
from libgz.classic.physics.contact import JointWrench
from libgz.physics.check import finite
from libgz.sdfworld.axis import IN_MODEL, Axis
from libgz.sdfworld.model import SdfModel

if TYPE_CHECKING:
    from libgz.classic.physics.link import Link
    from libgz.classic.physics.world import Model, World
    from libgz.physics.body import Body
    from libgz.sdfworld.joint import SdfJoint
    from libgz.simulation.event import Connection

__all__ = ["FIRST_PITCH", "Joint", "first_axes"]


# Of a screw that is made at run time, as in Gazebo, where only the elements of a file set one.
FIRST_PITCH = -1.0


def first_axes(kind: str) -> list[Axis]:
    """The axes of a joint of a kind that is made at run time, until they are set: ODE's, as in Gazebo.

    The axis is x of the child; those of a universal joint are y of the parent and x of the child, of a `revolute2` x of
    the parent and y of the child. Both axes of a gearbox are z of the world, for Gazebo's are not defined.
    """
    x, y, z = GzVector(1.0, 0.0, 0.0), GzVector(0.0, 1.0, 0.0), GzVector(0.0, 0.0, 1.0)
    pairs = {"ball": [], "fixed": [], "universal": [y, x], "revolute2": [x, y], "gearbox": [z, z]}
    return [Axis(axis, given=kind == "gearbox") for axis in pairs.get(kind, [x])]


# The kinds by their numbers in msgs.Joint.Type, which begin with 1.
JOINT_KINDS = ("revolute", "revolute2", "prismatic", "universal", "ball", "screw", "gearbox", "fixed")


KIND_BITS = {
    "revolute": Base.HINGE_JOINT,
    "revolute2": Base.HINGE2_JOINT,
    "prismatic": Base.SLIDER_JOINT,
    "universal": Base.UNIVERSAL_JOINT,
    "ball": Base.BALL_JOINT,
    "screw": Base.SCREW_JOINT,
    "gearbox": Base.GEARBOX_JOINT,
    "fixed": Base.FIXED_JOINT,
}


@takes_names
class Joint(Base):
    """A view on a joint of the engine. Angles in [rad], positions in [m], efforts in [N m] or [N]."""

    entity_type = Base.JOINT

    def __init__(self, world: World, model: Model | None, core: SdfJoint) -> None:
        super().__init__(world, core.name, model, core.plan.element)
        self.core = core
        self.anchored = True  # whether its anchor has been set

    def Init(self) -> None:
        """Move the anchor of a joint that `Model.CreateJoint` made by name to the child's origin, unless it was set."""
        link = self.GetChild() or self.GetParent()
        if not self.anchored and link is not None:
            self.SetAnchor(0, link.WorldPose().Pos())

    def GetType(self) -> int:
        """The bit mask of its types: Base.JOINT, and its kind such as Base.HINGE_JOINT."""
        return Base.JOINT | KIND_BITS.get(self.core.kind, 0)

    def GetMsgType(self) -> int:
        """The kind of joint, a number of msgs.Joint.Type: 1 for a revolute one."""
        return JOINT_KINDS.index(self.core.kind) + 1

    def DOF(self) -> int:
        """The number of its axes."""
        return self.core.dof

    GetAngleCount = DOF

    def _number(self, index: int) -> int:
        """The number of an axis in the engine's joint: a screw has one for both motions."""
        return 0 if index == 1 and self.core.kind == "screw" else index

    def _axis(self, index: int) -> Axis:
        """An axis; a screw's second motion has the first one's, a ball or fixed joint one without any value.

        Raises:
            ParameterError: there is none of this index.
        """
        if not self.core.axes:
            return Axis(GzVector(), True, math.nan, math.nan, 0.0, 0.0, stop_stiffness=0.0, stop_dissipation=0.0)
        return self.core.axis_at(self._number(index))

    def _limits(self, index: int) -> Axis:
        """The axis with the limits of a motion: those of a screw are of its angle, the way along the axis has none."""
        return Axis(GzVector()) if index == 1 and self.core.kind == "screw" else self._axis(index)

    # Motion ------------------------------------------------------------------------------------------------------

    @law
    def Position(self, index: int = 0) -> float:
        """The position of an axis [rad] or [m]."""
        return self.core.position(index)

    GetAngle = Position

    def SetPosition(self, index: int, position: float, preserveWorldVelocity: bool = False) -> bool:
        """Move the child, and the links connected to it, to a position at once; returns False for an invalid axis.

        They are stopped, unless their velocities in the world frame are to be preserved.
        """
        if not 0 <= index < self.core.dof or not self.core.attached:
            return False
        self.core.set_position(position, index, preserve_world_velocity=preserveWorldVelocity)
        return True

    SetAngle = SetPosition

    @law
    def GetVelocity(self, index: int) -> float:
        """The velocity of an axis [rad/s] or [m/s]."""
        return self.core.velocity(index)

    @law
    def SetVelocity(self, index: int, vel: float) -> None:
        """Set the velocity of the child relative to the parent [rad/s] or [m/s]."""
        self.core.set_velocity(vel, index)

    # Forces ------------------------------------------------------------------------------------------------------

    @law
    def SetForce(self, index: int, effort: float) -> None:
        """Apply an effort, clamped to the effort limit, for the next step; several calls add up."""
        self.core.add_force(effort, index)

    def GetForce(self, index: int) -> float:
        """The effort accumulated for the next step; 0 for a ball or fixed joint."""
        return self.core.force(index) if self.core.axes else 0.0

    def GetForceTorque(self, index: int = 0) -> JointWrench:
        """Forces and torques of the links on the joint in the last step: 1 the parent, 2 the child, in the link frames.

        A joint that carries a child's weight upwards has body1Force.z > 0, as in Gazebo. Efforts of SetForce are
        included. Recorded from the first call on, or from `<provide_feedback>` or SetProvideFeedback.
        """
        values = []
        force1, torque1, force2, torque2 = self._wrench()
        for body, pair in ((self.core.parent, (force1, torque1)), (self.core.child, (force2, torque2))):
            turn = GzQuaternInverse(body.GetRotation()) if body is not None else None
            values += [-Vector3d(*(rotate(turn, v) if turn is not None else v)) for v in pair]
        return JointWrench(*values)

    def SetProvideFeedback(self, enable: bool) -> None:
        """Enable or disable recording of the forces for GetForceTorque."""
        self.core.provide_feedback(enable)

    def _wrench(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        if not self.core.plan.feedback:
            self.core.provide_feedback(True)
        return self.core.wrench

    def LinkForce(self, index: int) -> Vector3d:
        """The force of the joint on the parent (0) or child (1) [N], in the world frame.

        Raises:
            ParameterError: the index is neither.
        """
        return self._of_link(0, index)

    def LinkTorque(self, index: int) -> Vector3d:
        """The torque of the joint on the parent (0) or child (1) about the anchor [N m], in the world frame."""
        return self._of_link(1, index)

    def _of_link(self, which: int, index: int) -> Vector3d:
        """The force (0) or torque (1) on the parent (0) or child (1)."""
        if index not in (0, 1):
            raise ParameterError(f"joint {self.GetName()!r} has links 0, the parent, and 1, the child; not {index!r}")
        return Vector3d(*self._wrench()[2 * int(index) + which])

    GetLinkForce, GetLinkTorque = LinkForce, LinkTorque

    # Limits ------------------------------------------------------------------------------------------------------

    def LowerLimit(self, index: int = 0) -> float:
        """The lower limit; -1e16: none."""
        return self._limits(index).lower

    def UpperLimit(self, index: int = 0) -> float:
        """The upper limit; 1e16: none."""
        return self._limits(index).upper

    def SetLowerLimit(self, index: int, limit: float) -> None:
        """Set the lower limit."""
        self.core.set_param("lo_stop", limit, index)

    def SetUpperLimit(self, index: int, limit: float) -> None:
        """Set the upper limit."""
        self.core.set_param("hi_stop", limit, index)

    GetLowStop = GetLowerLimit = LowerLimit
    GetHighStop = GetUpperLimit = UpperLimit
    SetLowStop, SetHighStop = SetLowerLimit, SetUpperLimit

    def GetEffortLimit(self, index: int) -> float:
        """The effort limit of SetForce; negative: none."""
        return self._limits(index).effort

    def SetEffortLimit(self, index: int, effort: float) -> None:
        """Set the effort limit of SetForce; negative: none."""
        self.core.set_limits(index, effort=float(effort))

    def GetVelocityLimit(self, index: int) -> float:
        """The velocity above which SetForce has no effect; negative: none."""
        return self._axis(index).velocity

    def SetVelocityLimit(self, index: int, velocity: float) -> None:
        """Set the velocity above which SetForce has no effect; negative: none."""
        self.core.set_limits(index, velocity=float(velocity))

    def GetStopStiffness(self, index: int) -> float:
        """The `<stiffness>` of a limit [N m/rad] or [N/m]; it is kept, and has no effect with ODE."""
        return self._axis(index).stop_stiffness

    def SetStopStiffness(self, index: int, stiffness: float) -> None:
        """Set the stiffness of a limit [N m/rad] or [N/m]; it is kept, and has no effect with ODE."""
        self._axis(index).stop_stiffness = finite(stiffness, "stop stiffness")

    def GetStopDissipation(self, index: int) -> float:
        """The `<dissipation>` of a limit; it is kept, and has no effect with ODE."""
        return self._axis(index).stop_dissipation

    def SetStopDissipation(self, index: int, dissipation: float) -> None:
        """Set the dissipation of a limit; it is kept, and has no effect with ODE."""
        self._axis(index).stop_dissipation = finite(dissipation, "stop dissipation")

    # Damping and springs -----------------------------------------------------------------------------------------

    def GetDamping(self, index: int) -> float:
        """The damping [N m s/rad] or [N s/m]."""
        return self._axis(index).damping

    GetDampingCoefficient = GetDamping

    def SetDamping(self, index: int, damping: float) -> None:
        """Set the damping [N m s/rad] or [N s/m]."""
        axis = self._axis(index)
        self.core.set_spring(index, axis.stiffness, damping, axis.reference)

    def GetStiffness(self, index: int) -> float:
        """The stiffness of the spring [N m/rad] or [N/m]."""
        return self._axis(index).stiffness

    def SetStiffness(self, index: int, stiffness: float) -> None:
        """Set the stiffness of the spring [N m/rad] or [N/m]."""
        axis = self._axis(index)
        self.core.set_spring(index, stiffness, axis.damping, axis.reference)

    def SetStiffnessDamping(self, index: int, stiffness: float, damping: float, reference: float = 0.0) -> None:
        """Set stiffness, damping, and the rest position of the spring."""
        self.core.set_spring(index, stiffness, damping, reference)

    def GetSpringReferencePosition(self, index: int) -> float:
        """The rest position of the spring."""
        return self._axis(index).reference

    def GetWorldEnergyPotentialSpring(self, index: int) -> float:
        """The energy in the spring of an axis [J]."""
        axis = self._axis(index)
        return 0.5 * axis.stiffness * (self.core.position(index) - axis.reference) ** 2 if axis.stiffness else 0.0

    # Parameters --------------------------------------------------------------------------------------------------

    def SetParam(self, key: str, index: int, value: Any) -> bool:
        """Set a parameter such as ``"fmax"``, ``"vel"``, ``"friction"``, ``"hi_stop"``, ``"stop_erp"``; returns True.

        Raises:
            ParameterError: there is no such parameter.
        """
        self.core.set_param(key, float(value), index)
        return True

    def GetParam(self, key: str, index: int) -> float:
        """The value of a parameter.

        Raises:
            ParameterError: there is no such parameter.
        """
        return self.core.get_param(key, index)

    SetAttribute, GetAttribute = SetParam, GetParam

    def GetMaxForce(self, index: int) -> float:
        """The maximum effort of its motor, the parameter ``"fmax"`` [N m] or [N]."""
        return self.GetParam("fmax", index)

    def SetMaxForce(self, index: int, force: float) -> None:
        """Set the maximum effort of its motor, the parameter ``"fmax"`` [N m] or [N]."""
        self.SetParam("fmax", index, force)

    # Geometry ----------------------------------------------------------------------------------------------------

    def Anchor(self, index: int = 0) -> Vector3d:
        """The anchor [m], in the world frame; index 1: on the child, which differs where there is a suspension."""
        return Vector3d(*self.core.anchor(index))

    def SetAnchor(self, index: int, anchor: VectorLike) -> None:
        """Set the anchor [m], in the world frame."""
        self.core.set_anchor(anchor)
        self.anchored = True

    def GlobalAxis(self, index: int) -> Vector3d:
        """An axis, in the world frame."""
        return Vector3d(*(self.core.axis(self._number(index)) if self.core.axes else GzVector()))

    def LocalAxis(self, index: int) -> Vector3d:
        """An axis, in the joint frame."""
        return Vector3d(*(self.core.local_axis(self._number(index)) if self.core.axes else GzVector()))

    def SetAxis(self, index: int, axis: VectorLike) -> None:
        """Set an axis, in the joint's frame; of ``revolute2`` and ``screw``, as in Gazebo, in the parent's model."""
        parent = self.GetParent()
        if self.core.kind not in IN_MODEL:
            frame = self.WorldPose().Rot()
        else:
            frame = parent.GetModel().WorldPose().Rot() if parent is not None else Quaterniond()
        self.core.set_axis(index, frame.RotateVector(Vector3d(*axis)))

    GetAnchor, GetGlobalAxis, GetLocalAxis = Anchor, GlobalAxis, LocalAxis

    def WorldPose(self) -> Pose3d:
        """Global pose of the joint's frame, which is fixed to the child [m]."""
        return Pose3d(self.core.frame())

    def ParentWorldPose(self) -> Pose3d:
        """Global pose of the frame that is fixed to the parent, and coincided with the joint's at Attach [m]."""
        return Pose3d(self.core.parent_frame())

    def AnchorErrorPose(self) -> Pose3d:
        """The joint's frame relative to that of the parent [m]: its motion, and the error of its constraints."""
        return Pose3d(GzCoordPoseSub(self.core.frame(), self.core.parent_frame()))

    def InitialAnchorPose(self) -> Pose3d:
        """Pose of the joint's frame in the child [m]: the `<pose>` of the joint."""
        return Pose3d(self.core.frame_in_child)

    def AxisFrame(self, index: int) -> Quaterniond:
        """Global rotation of the frame of LocalAxis: that of the joint; none for a ball or fixed joint."""
        if self._axis(index) and not self.core.axes:
            return Quaterniond()
        return self.WorldPose().Rot()

    def AxisFrameOffset(self, index: int) -> Quaterniond:
        """Rotation of the frame of LocalAxis in the joint's frame: none."""
        self._axis(index)
        return Quaterniond()

    GetWorldPose, GetParentWorldPose, GetInitialAnchorPose = WorldPose, ParentWorldPose, InitialAnchorPose
    GetAnchorErrorPose, GetAxisFrame, GetAxisFrameOffset = AnchorErrorPose, AxisFrame, AxisFrameOffset

    def InertiaRatio(self, axis: VectorLike | int) -> float:
        """The child's over the parent's moment of inertia about an axis by index, or a vector in the world frame."""
        direction = self.GlobalAxis(axis) if isinstance(axis, int) else axis
        if not self.core.axes:
            return 0.0
        moments = []
        for link in (self.GetParent(), self.GetChild()):
            rows = link.WorldInertiaMatrix().m if link is not None else []
            moments.append(sum(a * GzVectorDot(row, direction) for a, row in zip(direction, rows, strict=False)))
        return moments[1] / moments[0] if moments[0] else 0.0

    GetInertiaRatio = InertiaRatio

    # Links -------------------------------------------------------------------------------------------------------

    def GetJointLink(self, index: int) -> Link | Any:
        """The child link (0) or the parent link (1), of a `revolute2` the other way round; None for the world."""
        if self.core.kind == "revolute2":
            return {0: self.GetParent, 1: self.GetChild}.get(index, lambda: None)()
        return {0: self.GetChild, 1: self.GetParent}.get(index, lambda: None)()

    def GetParent(self) -> Link | Any:
        """The parent link; None for the world, and for a joint that is detached or whose link was deleted."""
        return self._link(self.core.parent)

    def container(self) -> Base | Any:
        """The model that contains it."""
        return super().GetParent()

    def GetChild(self, which: int | str | None = None) -> Link | Any:
        """The child link; None for the world, and for a joint that is detached or whose link was deleted."""
        return self._link(self.core.child)

    def _link(self, body: Body | None) -> Link | None:
        found: Link | None = self._world.link_of(body) if body is not None and self.core.attached else None
        return found

    def Attach(self, parent: Link | None, child: Link | None) -> None:
        """Connect two links; None is the world."""
        self.core.attach(parent.body if parent is not None else None, child.body if child is not None else None)

    def Detach(self) -> None:
        """Disconnect both links."""
        self.core.detach()

    def AreConnected(self, one: Link, two: Link) -> bool:
        """Whether it connects these two links."""
        return {one, two} == {self.GetParent(), self.GetChild()}

    def Load(self, parent: Link | None, child: Link | None, pose: GzPose | None = None) -> None:
        """Connect two links, None is the world, with the joint frame at a pose relative to the child [m]."""
        if pose is not None:
            self.core.set_frame(pose)
        self.Attach(parent, child)
        if self._parent is None and (child or parent) is not None:
            self.SetModel((child or parent).model)  # type: ignore[union-attr]

    def SetModel(self, model: Model) -> None:
        """Add it to a model, which updates it and deletes it when the model is deleted."""
        if self._parent is model or not isinstance(model.core, SdfModel):
            return
        joints, core = model.core.sdf_joints, self.core
        before = self.model_around()
        if before is not None and isinstance(before.core, SdfModel):
            self._world.server.joint_removed(self)
            before.core.sdf_joints.release(core.name)
        while joints.get(core.name, core) is not core:  # the name is taken
            core.name += "_"
        self._parent = model
        joints.add(core)
        self._world.server.joint_added(self)

    def Fini(self) -> None:
        """Remove it from its model and destroy it."""
        self.remove()

    def remove(self) -> None:
        """Remove it from its model and its controllers, and destroy it with its sensors."""
        model = self.model_around()
        if model is not None and isinstance(model.core, SdfModel):
            model.core.remove_joint(self.core.name)
        self.core.close()
        self._world.server.joint_removed(self)

    def Reset(self) -> None:
        """Reset the count of turns to zero; poses of links are restored by the reset of the model."""
        self.core.restore()

    def ConnectJointUpdate(self, callback: Callable[[], object]) -> Connection:
        """Call `callback` in each iteration, before physics."""
        return self._world.server.activity.joint_update.Connect(callback)
