"""SdfJoint: a joint of an SDF model: its axes, limits, damping, springs, friction, motors, and its motion."""

from __future__ import annotations

import math
from collections.abc import Iterable

from libgz.errors import GazeboError, ParameterError, nearest
from libgz.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzQuaternInverse,
    GzVector,
    GzVectorAdd,
    GzVectorCross,
    GzVectorDot,
    GzVectorMag,
    GzVectorMul,
    GzVectorSub,
    rotate,
)
from libgz.physics.body import Body
from libgz.physics.check import finite, unit_axis
from libgz.physics.couplings import Gears, PistonJoint, Thread, TieJoint
from libgz.physics.engine import Engine
from libgz.physics.joint import BallJoint, FixedJoint, HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint
from libgz.sdfworld.axis import Axis, JointPlan
from libgz.sdfworld.limits import JointLimits
from libgz.sdfworld.links import links_behind, move_links, push_links

__all__ = ["KINDS", "SdfJoint"]

KINDS: dict[str, type[Joint]] = {
    "revolute": HingeJoint,
    "prismatic": SliderJoint,
    "ball": BallJoint,
    "universal": UniversalJoint,
    "revolute2": Hinge2Joint,
    "fixed": FixedJoint,
    "screw": PistonJoint,
    "gearbox": TieJoint,
}
UNKNOWN = "is not a kind of joint here; allowed are " + ", ".join(KINDS)
PARALLEL = 0.999  # cosine from which two axes count as parallel
SKEW = 1e-3  # cosine up to which two axes are at right angles
TWO_AXES = ("universal", "revolute2", "gearbox")


def _is_real(body: Body | None) -> bool:
    return body is not None and not body.dummy


class SdfJoint(JointLimits):
    """A joint between two links, or a link and the world.

    Positive motion is that of the child against the parent, about or along the axis. A screw has two positions: the
    angle, and the way along the axis; a gearbox has the angles of parent and child against its reference body.

    Args:
        engine: where.
        plan: what to make; see `libgz.sdfworld.axis.read_joint`.

    Raises:
        ParameterError: the kind is unknown, an axis is missing, or a value is not allowed.
    """

    def __init__(self, engine: Engine, plan: JointPlan) -> None:
        if plan.kind not in KINDS:
            raise ParameterError(f"type {plan.kind!r} {UNKNOWN}{nearest(plan.kind, KINDS)}")
        self.engine = engine
        self.plan = plan
        self.name, self.kind, self.axes = plan.name, plan.kind, plan.axes
        self._check()
        self.parent, self.child = plan.parent, plan.child
        self.implicit = plan.implicit
        self.joint: Joint | None = None
        self._coupling: Thread | Gears | None = None
        self._applied, self._applied_at = [0.0, 0.0], -1  # efforts, and the number of the step they are of
        self._before, self._before_at = [0.0, 0.0], -1  # those of the push before
        self._laid: dict[int, float] = {}
        self._step_time = engine.step_time
        self._held: dict[int, bool] = {}  # implicit axes: whether stops stand for a spring
        self.acts = self._engine_pushes = False
        self._given = {}
        self._attach(plan.anchor)
        for index, axis in enumerate(self.axes):
            if axis.initial != 0.0 and self.joint is not None:
                self.set_position(axis.initial, index)

    def _check(self) -> None:
        needed = {"ball": 0, "fixed": 0}.get(self.kind, 1)
        if len(self.axes) < needed:
            raise ParameterError(f"joint {self.name!r}: a {self.kind} joint needs an <axis>")
        if self.kind in TWO_AXES and len(self.axes) == 1:
            first = self.axes[0]
            if self.kind != "gearbox":
                raise ParameterError(f"joint {self.name!r}: a {self.kind} joint needs an <axis2>")
            self.axes.append(Axis(GzVector(*first.direction)))
        if self.kind in ("universal", "revolute2") and self._cosine() > PARALLEL:
            raise ParameterError(f"joint {self.name!r}: the axes of a {self.kind} joint must not be parallel")
        if self.kind == "screw":
            del self.axes[1:]
            self.check_coupling("thread_pitch", self.plan.pitch)
        if self.kind == "gearbox":
            self.check_coupling("gearbox_ratio", self.plan.ratio)

    # Bodies ------------------------------------------------------------------------------------------------------

    def _attach(self, anchor: GzPose) -> None:
        """Make the joint between the links as they stand, with its frame at a global pose."""
        self._place(anchor)
        if not (_is_real(self.parent) or _is_real(self.child)):
            return
        try:
            self._make(anchor.pos)
        except GazeboError:  # a joint that holds nothing must not stay: ODE crashes on it
            self.detach()
            raise

    def _place(self, anchor: GzPose) -> None:
        """Note where the joint's frame lies in the child, and the axes in it."""
        frame = self.child.GetPose() if self.child is not None else GzPose()
        self._in_child = GzCoordPoseSub(anchor, frame)
        inverse = GzQuaternInverse(anchor.rot)
        self._local = [rotate(inverse, axis.direction) for axis in self.axes]

    def _make(self, anchor: GzVector) -> None:
        """Make ODE's joint between the links, at a global point."""
        if self.kind == "gearbox":
            self._attach_gears()
            self._refresh()
            return
        kind = UniversalJoint if self.kind == "revolute2" and not self._needs_hinge2() else KINDS[self.kind]
        self.joint = kind(self.engine, name=self.name)
        self._join(self.joint, anchor)
        self._set_parameters()
        if isinstance(self.joint, PistonJoint):
            self._coupling = Thread(self.joint, self.plan.pitch)
        self.provide_feedback(self.plan.feedback)
        self._refresh()

    def _cosine(self) -> float:
        """Of the angle between both axes, without its sign."""
        first, second = (axis.direction for axis in self.axes)
        return abs(GzVectorDot(first, second)) / (GzVectorMag(first) * GzVectorMag(second))

    def _needs_hinge2(self) -> bool:
        """Whether two axes are ODE's Hinge2: it has a suspension, and its axes may meet at any angle.

        But its second axis knows no stops, and it wants two bodies. Else a universal joint is the same and does more.
        """
        sprung = any(key.startswith("suspension") for key in self.plan.parameters)
        return (sprung or self._cosine() > SKEW) and _is_real(self.parent) and _is_real(self.child)

    def _join(self, joint: Joint, anchor: GzVector) -> None:
        """Anchor and axes, so that positive motion is that of the child."""
        axes = [axis.direction for axis in self.axes]
        if isinstance(joint, Hinge2Joint):
            # ODE ties the first axis to the first body, and measures the other way round.
            joint.Attach(self.parent, self.child)
            joint.SetAnchor(anchor)
            joint.SetAxes(GzVectorMul(-1.0, axes[0]), GzVectorMul(-1.0, axes[1]))
            return
        joint.Attach(self.child, self.parent)
        joint.SetAnchor(anchor)
        if isinstance(joint, HingeJoint | PistonJoint):
            joint.SetAxis(axes[0])
        elif isinstance(joint, SliderJoint):
            joint.SetAxis(*axes[0])
        elif isinstance(joint, UniversalJoint):
            # The first axis is fixed to the parent, which is ODE's second body.
            joint.SetAxis2(axes[0])
            joint.SetAxis1(axes[1])
        elif isinstance(joint, FixedJoint):
            joint.SetFixed()

    def _attach_gears(self) -> None:
        if self.parent is None or self.child is None or self.parent.dummy or self.child.dummy:
            raise ParameterError(f"joint {self.name!r}: a gearbox joins two links that move")
        directions = (self.axes[0].direction, self.axes[1].direction)
        self._coupling = Gears(self.engine, (self.parent, self.child), directions, self.plan.ratio, self.plan.reference)

    def attach(self, parent: Body | None, child: Body | None) -> None:
        """Join two links, as they stand now; None is the world. The joint's frame keeps its place in the child."""
        self.detach()
        self.parent, self.child = parent, child
        frame = child.GetPose() if child is not None else GzPose()
        anchor = GzCoordPoseAdd(self._in_child, frame)
        for axis, local in zip(self.axes, self._local, strict=True):
            axis.direction = rotate(anchor.rot, local)
        self._check()
        self._attach(anchor)

    def detach(self) -> None:
        """Let both links go; `attach` joins links again."""
        if self._coupling is not None:
            self._coupling.close()
        if self.joint is not None:
            self.joint.close()
        self.joint = self._coupling = None
        self.acts = False
        self._held.clear()

    close = detach

    def restore(self) -> None:
        """Count turns from zero again, after links were put back where they began."""
        self._held.clear()
        self._laid.clear()
        if self.attached and self.joint is not None:
            self.joint.reset_turns()
        if isinstance(self._coupling, Gears):
            self._coupling.restore()

    @property
    def attached(self) -> bool:
        """Whether it holds links together; not any more when one of them was deleted."""
        self.let_go_of_deleted()
        return self.joint is not None or self._coupling is not None

    def let_go_of_deleted(self) -> None:
        """Hold nothing any more if one of the links was deleted."""
        if self.joint is not None and not self.joint.closed:
            return  # it would have been destroyed with either link
        parent, child = self.parent, self.child
        if (parent is not None and parent.closed) or (child is not None and child.closed) or self.broken:
            self.detach()
            self.parent, self.child = (None if b is None or b.closed else b for b in (parent, child))

    # Motion ------------------------------------------------------------------------------------------------------

    def _column(self, index: int) -> int:
        """Where the position of an axis stands in the joint's row."""
        if not 0 <= index < self.dof:
            raise ParameterError(f"joint {self.name!r} has no axis {index}; it has {self.dof}")
        return 1 - index if isinstance(self.joint, UniversalJoint) else index

    def position(self, index: int = 0) -> float:
        """Angle [rad], turns counted, or position [m] of an axis; NaN for a ball or fixed joint."""
        self.let_go_of_deleted()
        if isinstance(self._coupling, Gears):
            return self._coupling.angles[self._column(index)]
        if not self.axes:
            return math.nan
        return self._sign(index) * self.joint._value(self._column(index)) if self.joint is not None else 0.0

    def _sign(self, index: int) -> float:
        """ODE measures the second angle of a Hinge2 against its own rate."""
        return -1.0 if index == 1 and isinstance(self.joint, Hinge2Joint) else 1.0

    def velocity(self, index: int = 0) -> float:
        """Rate of an axis [rad/s] or [m/s]; NaN for a ball or fixed joint."""
        self.let_go_of_deleted()
        if isinstance(self._coupling, Gears):
            return self._coupling.rates()[self._column(index)]
        if not self.axes:
            return math.nan
        return self.joint._value(2 + self._column(index)) if self.joint is not None else 0.0

    def add_force(self, effort: float, index: int = 0) -> None:
        """Push along an axis for one step [N m] or [N]; pushes of one step add up.

        It is cut to the axis' effort limit, and nothing where it would drive the axis beyond its velocity limit.

        Raises:
            ParameterError: there is no such axis, or the effort is not finite.
        """
        effort = finite(effort, "effort [N m or N]")
        self.let_go_of_deleted()
        self._column(index)
        axis = self.axes[min(index, len(self.axes) - 1)]
        if axis.effort >= 0.0:
            effort = max(-axis.effort, min(axis.effort, effort))
        if axis.velocity >= 0.0 and abs(rate := self.velocity(index)) > axis.velocity and rate * effort > 0.0:
            effort = 0.0
        if self._applied_at != self.engine.steps:
            self._before, self._before_at = self._applied, self._applied_at
            self._applied, self._applied_at = [0.0, 0.0], self.engine.steps
        self._applied[index] += effort
        self._push(effort, index)

    def force(self, index: int = 0) -> float:
        """What was pushed with in the last step that was pushed in [N m] or [N]."""
        self._column(index)
        return self._applied[index]

    def _push(self, effort: float, index: int) -> None:
        joint = self.joint
        if isinstance(self._coupling, Gears):
            body, direction = self._coupling.bodies[index], self._coupling.direction(index)
            body.AddTorque(*GzVectorMul(effort, direction))
            return
        if joint is None:
            return
        self._wake()
        if isinstance(joint, HingeJoint):
            joint.SetTorque(effort)
        elif isinstance(joint, SliderJoint):
            joint.SetSliderForce(effort)
        elif isinstance(joint, Hinge2Joint | UniversalJoint):
            first = (index == 0) == isinstance(joint, Hinge2Joint)
            joint.SetTorque(*((effort, 0.0) if first else (0.0, effort)))
        elif isinstance(joint, PistonJoint):
            self._push_screw(joint, effort, index)

    def _push_screw(self, joint: PistonJoint, effort: float, index: int) -> None:
        axis, anchor = joint.GetAxis(), self.anchor()
        for body, sign in ((self.child, 1.0), (self.parent, -1.0)):
            if body is None:
                continue
            push = GzVectorMul(sign * effort, axis)
            if index == 0:
                body.AddTorque(*push)
            else:  # ODE's own function for this turns both bodies, too
                body.AddForceAtPos(*push, *anchor)

    def _wake(self) -> None:
        for body in (self.parent, self.child):
            if body is not None and body.auto_disable:
                body.Enable(True)

    def _behind(self) -> list[Body]:
        """The links that move with the child when the joint moves."""
        return links_behind(self.child, self.parent)

    def set_position(self, position: float, index: int = 0, *, preserve_world_velocity: bool = False) -> None:
        """Move all links behind the joint so that an axis is at a position [rad] or [m], cut to its limits.

        Their velocities turn with them unless they are to be preserved.
        """
        target = finite(position, "position [rad or m]")
        column = self._column(index)
        if index < len(self.axes):
            axis = self.axes[index]
            target = max(axis.lower, min(axis.upper, target)) if axis.lower <= axis.upper else target
        if self.joint is None:
            return
        change = target - self.position(index)
        turn, slide = self._motion(change, index)
        move_links(self._behind(), self.anchor(), turn, slide, preserve_world_velocity)
        self.joint.count_turns_from(column, self._sign(index) * target)

    def set_velocity(self, velocity: float, index: int = 0) -> None:
        """Give all links behind the joint at once the velocities that make an axis move so [rad/s] or [m/s]."""
        change = finite(velocity, "velocity [rad/s or m/s]") - self.velocity(index)
        if self.joint is None:
            return
        turn, slide = self._motion(change, index)
        push_links(self._behind(), self.anchor(), turn, slide)

    def _motion(self, change: float, index: int) -> tuple[GzVector, GzVector]:
        """(rotation vector, translation), global, of a change of an axis' position."""
        axis = self.axis(min(index, len(self.axes) - 1))
        if isinstance(self.joint, SliderJoint):
            return GzVector(), GzVectorMul(change, axis)
        if isinstance(self.joint, PistonJoint):
            turn = change if index == 0 else -change * self.plan.pitch
            return GzVectorMul(turn, axis), GzVectorMul(-turn / self.plan.pitch, axis)
        return GzVectorMul(change, axis), GzVector()

    # Places ------------------------------------------------------------------------------------------------------

    def frame(self) -> GzPose:
        """Global pose of the joint's frame, which goes with the child [m]."""
        return GzCoordPoseAdd(self._in_child, self.child.GetPose() if self.child is not None else GzPose())

    def anchor(self, index: int = 0) -> GzVector:
        """Global anchor [m]; of index 1 that on the second link, which a suspension sets apart."""
        self.let_go_of_deleted()
        if index == 1 and isinstance(self.joint, Hinge2Joint):
            return self.joint.GetAnchor2()
        return self.frame().pos

    def set_frame(self, pose: GzPose) -> None:
        """Where the joint's frame is to lie in the child [m]; `attach` makes it so."""
        self._in_child = GzPose(GzVector(*pose.pos), pose.rot)

    def set_anchor(self, anchor: Iterable[float]) -> None:
        """Move the anchor to a global point [m]; positions count from where the links stand now."""
        self.let_go_of_deleted()
        frame = self.frame()
        self._again(GzPose(GzVector(*anchor), frame.rot), {})

    def axis(self, index: int = 0) -> GzVector:
        """An axis as it lies now, global."""
        self.let_go_of_deleted()
        self.axis_at(index)
        joint = self.joint
        if isinstance(joint, HingeJoint | SliderJoint | PistonJoint):
            return joint.GetAxis()
        if isinstance(joint, UniversalJoint):
            return (joint.GetAxis2, joint.GetAxis1)[index]()
        if isinstance(joint, Hinge2Joint):
            return GzVectorMul(-1.0, (joint.GetAxis1, joint.GetAxis2)[index]())
        return rotate(self.frame().rot, self._local[index])

    def local_axis(self, index: int = 0) -> GzVector:
        """An axis in the joint's frame, as it was when the joint was made."""
        self.axis_at(index)
        return GzVector(*self._local[index])

    def set_axis(self, index: int, axis: Iterable[float]) -> None:
        """Replace an axis, global; positions count from where the links stand now."""
        self.axis_at(index)
        self._again(self.frame(), {index: GzVector(*unit_axis(axis, "axis"))})

    def _again(self, frame: GzPose, new: dict[int, GzVector]) -> None:
        """Attach anew, if it holds links, with the frame at a global pose, and with new axes where there are any."""
        held = self.attached
        directions = [new.get(i) or self.axis(i) for i in range(len(self.axes))]
        self.detach()
        for axis, direction in zip(self.axes, directions, strict=True):
            axis.direction = direction
        if not held:
            self._place(frame)
            return
        self._check()
        self._attach(frame)

    # Feedback ----------------------------------------------------------------------------------------------------

    def provide_feedback(self, on: bool) -> None:
        """Whether `wrench` is filled in each step."""
        self.let_go_of_deleted()
        self.plan.feedback = on
        if self.joint is not None:
            self.joint.provide_feedback(on)
        if isinstance(self._coupling, Thread):
            self._coupling.provide_feedback(on)

    @property
    def wrench(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        """(force, torque) on the parent, then on the child, that the joint put on them in the last step.

        Forces [N]; torques about the anchor [N m]; global. Efforts of `add_force` are in it, explicit springs are not.
        """
        if not self.attached or not self.plan.feedback:
            return GzVector(), GzVector(), GzVector(), GzVector()
        force1, torque1, force2, torque2 = self._feedback()
        swap = isinstance(self.joint, Hinge2Joint)
        on_child, on_parent = ((force2, torque2), (force1, torque1)) if swap else ((force1, torque1), (force2, torque2))
        anchor = self.anchor()
        result: list[GzVector] = []
        for body, (force, torque) in ((self.parent, on_parent), (self.child, on_child)):
            if body is not None and not body.dummy:
                arm = GzVectorSub(body.GetCoMPose().pos, anchor)
                torque = GzVectorAdd(torque, GzVectorCross(arm, force))
            result += [force, torque]
        if not _is_real(self.parent):
            result[:2] = [GzVectorMul(-1.0, v) for v in result[2:]]
        elif not _is_real(self.child):
            result[2:] = [GzVectorMul(-1.0, v) for v in result[:2]]
        force, torque = self._effort_on_child(anchor)
        return (
            GzVectorSub(result[0], force),
            GzVectorSub(result[1], torque),
            GzVectorAdd(result[2], force),
            GzVectorAdd(result[3], torque),
        )

    def _feedback(self) -> tuple[GzVector, ...]:
        """What ODE tells of its joint, and of the thread that goes with it."""
        told: tuple[GzVector, ...] = self.joint.feedback if self.joint is not None else ()
        if isinstance(self._coupling, Thread):
            told = tuple(GzVectorAdd(a, b) for a, b in zip(told, self._coupling.feedback, strict=True))
        return told

    def _effort_on_child(self, anchor: GzVector) -> tuple[GzVector, GzVector]:
        """(force, torque about the anchor) of what `add_force` pushed with in the last step, global."""
        last = self.engine.steps - 1
        efforts = {self._before_at: self._before, self._applied_at: self._applied}.get(last, [0.0, 0.0])
        force, torque = GzVector(), GzVector()
        for index, effort in enumerate(efforts[: self.dof]):
            if effort == 0.0:
                continue
            push = GzVectorMul(effort, self.axis(min(index, len(self.axes) - 1)))
            if not isinstance(self.joint, SliderJoint) and not (self.kind == "screw" and index == 1):
                torque = GzVectorAdd(torque, push)
                continue
            force = GzVectorAdd(force, push)
            # A screw is pushed at its anchor, a slider along a line half way between both centres of mass.
            ends = (self.parent, self.child) if isinstance(self.joint, SliderJoint) else ()
            centres = [body.GetCoMPose().pos for body in ends if body is not None and not body.dummy]
            for centre in centres:
                arm = GzVectorMul(1.0 / len(centres), GzVectorSub(centre, anchor))
                torque = GzVectorAdd(torque, GzVectorCross(arm, push))
        return force, torque
