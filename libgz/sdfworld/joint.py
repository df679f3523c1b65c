"""SdfJoint: a joint of an SDF model: its axes, limits, damping, springs, friction, motors, and its motion."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Sequence
from operator import attrgetter
from typing import Any

from libgz.base.errors import GazeboError, ParameterError, nearest
from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzQuaternInverse,
    GzVector,
    GzVectorAdd,
    GzVectorCross,
    GzVectorMul,
    GzVectorSub,
    rotate,
)
from libgz.base.law import constant, largest, law, least, possible, usually, where
from libgz.ode.context import HeldEffort
from libgz.physics.body import Body
from libgz.physics.check import finite, finite_tuple, unit_axis
from libgz.physics.couplings import Gears
from libgz.physics.engine import Engine
from libgz.physics.joint import Joint
from libgz.physics.saved import saved_pose
from libgz.sdf.element import Element
from libgz.sdfworld.axis import HALF_TURN, UNLIMITED, Axis, JointPlan
from libgz.sdfworld.joint_record import PARAMETERS, RANGES, JointRecord
from libgz.sdfworld.links import accelerate_links, links_behind, move_links, slide_child, turn_child
from libgz.sdfworld.mechanism import (
    RATIOS,
    GearboxMechanism,
    HingeMechanism,
    Links,
    Mechanism,
    SliderMechanism,
    check_ratio,
    mechanism_class,
    ode_number,
)
from libgz.simulation.recorder import Recorder, recorded_as

__all__ = ["Place", "SdfJoint", "place_of"]

Place = tuple[str, int] | None  # of a link in a world: the id of its entity, its number there; None is the world
FindPlace = Callable[[Place], Body | None]

TURN = 2.0 * math.pi
# h^2 k / m and h d / m up to which an implicit spring and damper are applied as efforts, which is stable up to 4 and 2.
GENTLE = 0.05
# What an axis has beside its direction.
NUMBERS = (
    *("given", "lower", "upper", "effort", "velocity", "damping", "friction", "stiffness", "reference"),
    *("stop_stiffness", "stop_dissipation"),
)
# Keys of a gearbox that may change in each step: of the parent's angle, of the child's, which is Gazebo's first, and of
# both.
GEARS = ("reference_angle2", "reference_angle1", "ratio")


# What a state has of a joint.
_VECTOR, _TURN = ("x", "y", "z"), ("u", "x", "y", "z")
_numbers_of_vector = attrgetter(*_VECTOR)
_numbers_of_axis = attrgetter(*(f"direction.{name}" for name in _VECTOR), *NUMBERS)
_description = attrgetter(
    *(f"plan.{name}" for name in ("kind", "implicit", "parameters", "pitch", "ratio", "feedback")),
    *("acts", "_engine_springs", "_step_time", "record.given", "_stop_turns", "_spring_stops"),
    *(
        f"{frame}.{part}.{name}"
        for frame in ("_in_child", "_in_parent")
        for part, names in (("pos", _VECTOR), ("rot", _TURN))
        for name in names
    ),
)


def _number(column: int) -> Callable[..., Any]:
    """What laws record of a position or rate: a number of the engine's joint where it is one."""

    def read(recorder: Recorder, joint: SdfJoint, index: int = 0) -> Any:
        plain = recorder.joint_of(joint.plain_joint, joint.engine)
        if plain is not None and not index:
            return recorder.state(plain, Joint, column)
        return recorder.call(SdfJoint.velocity if column else SdfJoint.position, joint, index)

    return read


class SdfJoint:
    """A joint between two links, or a link and the world.

    Positive motion is that of the child against the parent, about or along the axis; of a `revolute2`, as in Gazebo,
    that of the parent against the child. A screw has two positions: the angle, and the way along the axis; a gearbox
    has the angles of parent and child against its reference body.

    While it holds links together it has a `Mechanism` of its kind.

    Args:
        engine: where.
        plan: what to make; see `libgz.sdfworld.axis.read_joint`.

    Attributes:
        dof: how many positions there are.
        acts: whether `update` has anything to do.
        on_change: called when that changes, and when it is attached or detached.
        table: the `JointTable` that has it; None for none.
        number: that in the table.

    Raises:
        ParameterError: the kind is unknown, an axis is missing, or a value is not allowed.
    """

    def __init__(self, engine: Engine, plan: JointPlan) -> None:
        self.links = Links(plan.parent, plan.child)
        kind = mechanism_class(plan, self.links)
        kind.check(plan)
        self.dof = kind.dof(plan)
        self.engine = engine
        self.plan = plan
        self.name, self.kind, self.axes = plan.name, plan.kind, plan.axes
        self.implicit = plan.implicit
        self.acts = False
        self.on_change: Callable[[], None] | None = None
        self.facade: Any = None
        self.number = 0
        self.table: object = None
        self._mechanism: Mechanism | None = None
        self.record = JointRecord(self.axes, self.dof)
        self._engine_springs = False  # whether the engine applies its springs
        self._stop_turns: dict[int, float] = {}  # axis -> turns [rad] that its stops were set for
        self._spring_stops: dict[int, bool] = {}  # axis -> whether two stops at one place act as its spring
        self._step_time = engine.step_time  # [s] that `_refresh` has used
        self._attach(plan.anchor)

    @property
    @constant
    def parent(self) -> Body | None:
        """The parent link; None is the world."""
        return self.links.parent

    @property
    @constant
    def child(self) -> Body | None:
        """The child link; None is the world."""
        return self.links.child

    @property
    @constant
    def joint(self) -> Joint | None:
        """ODE's joint while it holds links together; a gearbox has none."""
        return self._mechanism.joint if self._mechanism is not None else None

    def axis_at(self, index: int) -> Axis:
        """An axis; a screw's second motion has none of its own.

        Raises:
            ParameterError: there is none of this index.
        """
        if not 0 <= index < len(self.axes):
            raise ParameterError(f"joint {self.name!r} has no axis {index}; it has {len(self.axes)}")
        return self.axes[index]

    def _check_index(self, index: int) -> None:
        if not 0 <= index < self.dof:
            raise ParameterError(f"joint {self.name!r} has no axis {index}; it has {self.dof}")

    # Links -----------------------------------------------------------------------------------------------------------

    def _attach(self, anchor: GzPose) -> None:
        """Make the mechanism between the links as they stand, with the joint's frame at a global pose."""
        self._place(anchor)
        if not self.links.movable:
            return
        try:
            self._mechanism = mechanism_class(self.plan, self.links)(self.engine, self.plan, self.links, anchor.pos)
            if not all(axis.given for axis in self.axes):
                self._place(anchor)  # ODE's axes are known now
            if self.joint is not None:
                self._set_parameters()
                self.provide_feedback(self.plan.feedback)
            self._refresh()
            self._changed()
        except GazeboError:  # a joint that holds nothing must not stay: ODE crashes on it
            self.detach()
            raise

    def _place(self, anchor: GzPose) -> None:
        """Note where the joint's frame lies in the child, and the axes in it."""
        frame = self.child.GetPose() if self.child is not None else GzPose()
        self._in_child = GzCoordPoseSub(anchor, frame)
        self._in_parent = GzCoordPoseSub(anchor, self.parent.GetPose() if self.parent is not None else GzPose())
        inverse = GzQuaternInverse(anchor.rot)
        self._local = [rotate(inverse, axis.direction) for axis in self.axes]

    def attach(self, parent: Body | None, child: Body | None) -> None:
        """Join two links, as they stand now; None is the world. The joint's frame keeps its place in the child."""
        self.detach()
        self.links = Links(parent, child)
        frame = child.GetPose() if child is not None else GzPose()
        anchor = GzCoordPoseAdd(self._in_child, frame)
        for axis, local in zip(self.axes, self._local, strict=True):
            axis.direction = rotate(anchor.rot, local)
        mechanism_class(self.plan, self.links).check(self.plan)
        self._attach(anchor)

    def detach(self) -> None:
        """Release both links; `attach` joins links again."""
        if self._mechanism is not None:
            self._mechanism.close()
        self._mechanism = None
        self._set_acts(False)
        self._changed()

    close = detach

    # State -----------------------------------------------------------------------------------------------------------

    def save(self, holder: Element) -> tuple[Any, ...]:
        """Its state as plain data, beside its efforts, and what the engine has of its ODE joints.

        Args:
            holder: what contains the `<joint>` elements of the file that will be found again.
        """
        self.release_deleted()
        links, mechanism = self.links, self._mechanism
        return (
            None if mechanism is None else type(mechanism).__name__,
            (place_of(links.parent), place_of(links.child), place_of(self.plan.reference)),
            _description(self),
            [_numbers_of_axis(axis) for axis in self.axes],
            [_numbers_of_vector(axis) for axis in self._local],
            self.plan.element is not None and self.plan.element.GetParent() is holder,
        )

    @property
    def efforts(self) -> bytes:
        """The efforts of the last two steps that had some, each with the number of its step; kept in states."""
        return self.record.efforts

    @classmethod
    def load_efforts(cls, joints: Iterable[SdfJoint], packed: bytes) -> None:
        """Give joints the efforts that they had, those of one after those of the other."""
        size = JointRecord.EFFORTS
        for joint, start in zip(joints, range(0, len(packed) - size + 1, size), strict=False):
            joint.record.efforts = packed[start : start + size]

    @classmethod
    def saved_plan(cls, name: str, state: Sequence[Any], find: FindPlace, element: Element | None) -> JointPlan:
        """What to make for a joint that a state has; `element` is the file's of this name."""
        mechanism, (parent, child, reference), described, axes, *_ = state
        kind, implicit, parameters, pitch, ratio, feedback, *_ = described
        made = [Axis(GzVector(*numbers[:3]), *numbers[3:]) for numbers in axes]
        frame = find(child) or find(parent)
        anchor = frame.GetPose() if frame is not None else GzPose()
        return JointPlan(
            name,
            kind,
            find(parent) if mechanism is not None else None,
            find(child) if mechanism is not None else None,
            anchor,
            made,
            pitch,
            ratio,
            find(reference),
            implicit,
            feedback,
            dict(parameters),
            element if state[-1] else None,
        )

    def fits(self, name: str, number: int, state: Sequence[Any]) -> bool:
        """Whether it is the joint of a state: of the same name, number and kind."""
        return (self.name, self.number, self.kind, self.implicit) == (name, number, *state[2][:2])

    def load(self, state: Sequence[Any], find: FindPlace) -> None:
        """Take a state that `save` returned: of this joint, or of one of this name that was removed since.

        The engine sets the numbers of ODE's joints, later.

        Args:
            state: the state.
            find: returns a link by its place.
        """
        self.release_deleted()
        name, (*ends, _), (_, _, _, pitch, ratio, feedback, *flags), axes, local, _ = state
        plan, tables, frames = self.plan, flags[3:6], (flags[6:13], flags[13:])
        finite_tuple((pitch, ratio, flags[2]), 3, "pitch, ratio and step")
        plan.pitch, plan.ratio = pitch, ratio
        self._in_child, self._in_parent = map(saved_pose, frames)
        self._local = [GzVector(*finite_tuple(axis, 3, "an axis")) for axis in local]
        for axis, numbers in zip(self.axes, axes, strict=True):
            axis.direction = GzVector(*finite_tuple(numbers[:3], 3, "an axis"))
            for key, number in zip(NUMBERS, numbers[3:], strict=True):
                setattr(axis, key, number)
        self.record.given, self._stop_turns, self._spring_stops = map(dict, tables)
        present = type(self._mechanism).__name__ if self._mechanism is not None else None
        if (present, [place_of(self.parent), place_of(self.child)]) != (name, ends):
            self._rejoin(name is not None, Links(*map(find, ends)))
        if plan.feedback != feedback:
            self.provide_feedback(feedback)
        for axis, numbers in zip(self.axes, axes, strict=True):
            axis.direction = GzVector(*numbers[:3])
        self.acts, self._engine_springs, self._step_time = flags[:3]
        self.record.given, self._stop_turns, self._spring_stops = map(dict, tables)

    def _rejoin(self, holds: bool, links: Links) -> None:
        """Release what it holds, and join other links as they stand, if it `holds` links at all."""
        self.detach()
        self.links = links
        if holds:
            places = self._in_child, self._in_parent, self._local
            self.attach(links.parent, links.child)
            self._in_child, self._in_parent, self._local = places

    def restore(self) -> None:
        """Count turns from zero again, after links were returned to where they began."""
        self._spring_stops.clear()
        self._stop_turns.clear()
        if self.attached and self._mechanism is not None:
            self._mechanism.restore()

    @property
    def attached(self) -> bool:
        """Whether it holds links together; not any more when one of them was deleted."""
        self.release_deleted()
        return self._mechanism is not None

    def release_deleted(self) -> None:
        """Detach if one of the links was deleted."""
        mechanism = self._mechanism
        if mechanism is not None and mechanism.joint is not None and not mechanism.joint.closed:
            return  # it would have been destroyed with either link
        deleted = any(body is not None and body.closed for body in (self.parent, self.child))
        if deleted or (mechanism is not None and mechanism.closed):
            self.detach()
            self.links = Links(*(None if b is None or b.closed else b for b in (self.parent, self.child)))

    # Motion ----------------------------------------------------------------------------------------------------------

    @recorded_as(_number(0))
    @law
    def position(self, index: int = 0) -> float:
        """Angle [rad], turns counted, or position [m] of an axis; NaN for a ball or fixed joint, as in Gazebo."""
        mechanism = self._live_mechanism
        if not self.axes:
            return math.nan
        if mechanism is None:
            return 0.0
        if index:
            self._index_checked(index)
        return mechanism.position(index)

    def count_from(self, position: float, index: int = 0) -> None:
        """Count turns of an axis from a position on [rad]."""
        self._check_index(index)
        if self._mechanism is not None:
            self._mechanism.count_from(position, index)

    @recorded_as(_number(2))
    @law
    def velocity(self, index: int = 0) -> float:
        """Rate of an axis [rad/s] or [m/s]; 0 for a ball or fixed joint."""
        mechanism = self._live_mechanism
        if not self.axes or mechanism is None:
            return 0.0
        if index:
            self._index_checked(index)
        return mechanism.velocity(index)

    def plain_joint(self) -> Joint | None:
        """The engine's joint, if position and rate are its first ones as they are: a hinge or slider."""
        if not isinstance(self._mechanism, HingeMechanism | SliderMechanism) or self._mechanism.closed:
            return None
        return self._mechanism.joint

    @law
    def add_force(self, effort: float, index: int = 0) -> None:
        """Apply an effort to an axis for one step [N m] or [N]; those of one step add up.

        It is limited to the axis' effort limit, and zero where it would drive the axis beyond its velocity limit.

        Raises:
            ParameterError: there is no such axis, or the effort is not finite.
        """
        effort, axis = finite(effort, "effort [N m or N]"), self._axis_of(index)
        effort, limited = axis.within_effort(effort), axis.velocity >= 0.0
        if possible(limited):
            rate = self.velocity(index)
            effort = where(limited & (abs(rate) > axis.velocity) & (rate * effort > 0.0), 0.0, effort)
        self.record.add_effort(effort, index, self.engine)
        self._apply(effort, index)

    @constant
    def _axis_of(self, index: int) -> Axis:
        """The axis that a position belongs to."""
        self.release_deleted()
        self._check_index(index)
        return self.axes[min(index, len(self.axes) - 1)]

    def write_held(self, held: HeldEffort, effort: float) -> bool:
        """Write what `add_force` does on the first axis for `Engine.hold`; false where more than the effort decides."""
        mechanism, axis = self._mechanism, self.axes[0]
        if mechanism is None or not mechanism.holds or (joint := mechanism.joint) is None or joint.closed:
            return False
        if axis.velocity >= 0.0:
            return False
        held.wakes = 1
        return joint.write_held(held, axis.within_effort(effort))

    def was_held(self, effort: float, steps: int) -> None:
        """Note the effort of a number of steps that are over, as `add_force` notes it."""
        self.record.held(effort, steps, self.engine.steps - 1)

    def force(self, index: int = 0) -> float:
        """The effort of the last step in which one was applied [N m] or [N]."""
        self._check_index(index)
        return self.record.effort(index)

    @law
    def _apply(self, effort: float, index: int) -> None:
        mechanism = self._live_mechanism
        if mechanism is None:
            return
        for body in (self.parent, self.child):
            if body is not None:
                body.wake()
        mechanism.apply(effort, index, self.anchor)

    def set_position(self, position: float, index: int = 0, *, preserve_world_velocity: bool = False) -> None:
        """Move all links behind the joint so that an axis is at a position [rad] or [m], within its limits.

        They stop there, unless their velocities in the world frame are to be preserved.
        """
        target = finite(position, "position [rad or m]")
        self._check_index(index)
        if index < len(self.axes):
            axis = self.axes[index]
            target = max(axis.lower, min(axis.upper, target)) if axis.lower <= axis.upper else target
        if self._mechanism is None or self.joint is None:
            return
        turn, slide = self._motion(target - self.position(index), index)
        move_links(links_behind(self.child, self.parent), self.anchor(), turn, slide, preserve_world_velocity)
        self._mechanism.count_from(target, index)

    @law
    def set_velocity(self, velocity: float, index: int = 0) -> None:
        """Set at once the velocity of an axis [rad/s] or [m/s].

        As in Gazebo, a hinge or universal joint gives its child the velocity that the parent's motion and this one make
        of it, a slider the velocity without the rate. Of other kinds all links behind the joint are accelerated.

        Raises:
            ParameterError: there is no such axis, or the velocity is not finite.
        """
        if not usually(abs(velocity) <= sys.float_info.max):
            raise ParameterError(f"joint {self.name!r}: a velocity [rad/s or m/s] of {velocity!r} is not finite")
        if self._live_joint is None:
            return
        self._index_checked(index)
        mechanism: Any = self._mechanism
        child = self._moving_child
        if child is not None and mechanism.moves == "turning":
            rate = self._motion(velocity, index)[0]
            for other in self._other_axes(index):
                rate = GzVectorAdd(rate, self._motion(mechanism.velocity(other), other)[0])
            turn_child(child, self.parent, self._frame().pos, self.parent_frame().pos, rate)
        elif child is not None and mechanism.moves == "sliding":
            slide_child(child, self.parent, self._motion(velocity, index)[1])
        else:
            turn, slide = self._motion(velocity - mechanism.velocity(index), index)
            accelerate_links(self._behind(), self._frame().pos, turn, slide)

    @property
    @constant
    def _moving_child(self) -> Body | None:
        return None if self.child is None or self.child.dummy else self.child

    @constant
    def _other_axes(self, index: int) -> list[int]:
        return [other for other in range(len(self.axes)) if other != index]

    @constant
    def _index_checked(self, index: int) -> None:
        self._check_index(index)

    @constant
    def _axis_checked(self, index: int) -> None:
        self.axis_at(index)

    @constant
    def _behind(self) -> list[Body]:
        return links_behind(self.child, self.parent)

    @law
    def _frame(self) -> GzPose:
        child = self.child
        return GzCoordPoseAdd(self._in_child, GzPose() if child is None else child.GetPose())

    @law
    def _motion(self, change: float, index: int) -> tuple[GzVector, GzVector]:
        """(rotation vector, translation), global, of a change of an axis' position."""
        number = min(index, len(self.axes) - 1)
        self._axis_checked(number)
        mechanism = self._mechanism
        if mechanism is None:
            return GzVector(), GzVector()
        axis = mechanism.axis(number)
        if axis is None:
            axis = rotate(self._frame().rot, self._local[number])
        return mechanism.motion(change, index, axis)

    # Places ----------------------------------------------------------------------------------------------------------

    def frame(self) -> GzPose:
        """Global pose of the joint's frame, which is fixed to the child [m]."""
        return self._frame()

    @law
    def parent_frame(self) -> GzPose:
        """Global pose of what was the joint's frame when it was attached, and is fixed to the parent [m]."""
        return GzCoordPoseAdd(self._in_parent, self.parent.GetPose() if self.parent is not None else GzPose())

    @property
    def frame_in_child(self) -> GzPose:
        """Pose of the joint's frame in the child [m]."""
        return GzPose(GzVector(*self._in_child.pos), self._in_child.rot)

    def anchor(self, index: int = 0) -> GzVector:
        """Global anchor [m]; of index 1 that on the second link, which a suspension moves apart."""
        self.release_deleted()
        second = self._mechanism.second_anchor() if self._mechanism is not None and index == 1 else None
        return self.frame().pos if second is None else second

    def set_frame(self, pose: GzPose) -> None:
        """Where the joint's frame is to lie in the child [m]; `attach` makes it so."""
        self._in_child = GzPose(GzVector(*pose.pos), pose.rot)

    def set_anchor(self, anchor: Iterable[float]) -> None:
        """Move the anchor to a global point [m]; positions count from where the links stand now."""
        self.release_deleted()
        self._attach_anew(GzPose(GzVector(*anchor), self.frame().rot), {})

    def axis(self, index: int = 0) -> GzVector:
        """An axis as it lies now, global."""
        self.release_deleted()
        self.axis_at(index)
        axis = self._mechanism.axis(index) if self._mechanism is not None else None
        return rotate(self.frame().rot, self._local[index]) if axis is None else axis

    def local_axis(self, index: int = 0) -> GzVector:
        """An axis in the joint's frame, as it was when the joint was made."""
        self.axis_at(index)
        return GzVector(*self._local[index])

    def set_axis(self, index: int, axis: Iterable[float]) -> None:
        """Replace an axis, global; positions count from where the links stand now."""
        self.axis_at(index)
        self._attach_anew(self.frame(), {index: GzVector(*unit_axis(axis, "axis"))})

    def _attach_anew(self, frame: GzPose, new: dict[int, GzVector]) -> None:
        """Attach again, if it is attached, with the frame at a global pose and with new axes where there are any."""
        held = self.attached
        directions = [new.get(i) or self.axis(i) for i in range(len(self.axes))]
        self.detach()
        for index, (axis, direction) in enumerate(zip(self.axes, directions, strict=True)):
            axis.direction, axis.given = direction, axis.given or index in new
        if not held:
            self._place(frame)
            return
        mechanism_class(self.plan, self.links).check(self.plan)
        self._attach(frame)

    # Parameters ------------------------------------------------------------------------------------------------------

    def _number(self, key: str, index: int) -> int | None:
        """ODE's number of a parameter; None where this joint has no such parameter."""
        if self._mechanism is None:
            return ode_number(key, index)
        return self._mechanism.number(key, index)

    @constant
    def _known_number(self, key: str, index: int) -> int:
        number = self._number(key, index)
        if number is None:
            known = ", ".join((*PARAMETERS, "friction", "thread_pitch", "gearbox_ratio"))
            raise ParameterError(
                f"joint {self.name!r}: a {self.kind} joint has no {key!r} of axis {index}; keys are {known}"
                + nearest(key, PARAMETERS)
            )
        return number

    def _set_parameters(self) -> None:
        """Stops, friction, ODE's parameters of the file, and what users have set."""
        users = self.record.given
        for index, axis in enumerate(self.axes):
            self._set_stops(index)
            if axis.friction > 0.0 and self._number("vel", index) is not None:
                self.set_param("friction", axis.friction, index)
        for key, value in self.plan.parameters.items():
            for index in range(max(1, len(self.axes))):
                if self._number(key, index) is not None and (value != 0.0 or key not in ("fmax", "vel")):
                    self.set_param(key, value, index)
        for (key, index), value in users.items():  # set before the joint was attached anew
            if self._number(key, index) is not None:
                self.set_param(key, value, index)

    def get_param(self, key: str, index: int = 0) -> float:
        """A parameter by its classic key; see `set_param`.

        Raises:
            ParameterError: there is no such key, or this kind of joint has none.
        """
        if key in ("hi_stop", "lo_stop", "friction"):
            if index == 1 and self.kind == "screw":
                return 0.0
            axis = self.axis_at(index)
            return {"hi_stop": axis.upper, "lo_stop": axis.lower, "friction": axis.friction}[key]
        if key in ("thread_pitch", "gearbox_ratio"):
            return self.plan.pitch if key == "thread_pitch" else self.plan.ratio
        if key in GEARS:
            gears = self._gears(key)
            return gears.ratio if key == "ratio" else gears.references[GEARS.index(key)]
        number = self._known_number(key, index)
        return self.joint.GetParam(number) if self.attached and self.joint is not None else 0.0

    def _gears(self, key: str) -> Gears:
        """The gears of a gearbox.

        Raises:
            ParameterError: it is no gearbox, or holds no links together.
        """
        if not isinstance(self._mechanism, GearboxMechanism):
            raise ParameterError(f"joint {self.name!r}: {key!r} is a key of gearboxes; this is a {self.kind} joint")
        return self._mechanism.gears

    def set_param(self, key: str, value: float, index: int = 0) -> None:
        """Set a parameter by its classic key.

        fmax [N m or N] and vel [rad/s or m/s] are the motor; hi_stop, lo_stop [rad or m]; friction [N m or N]; erp,
        cfm, stop_erp, stop_cfm, suspension_erp, suspension_cfm, fudge_factor, bounce; thread_pitch [rad/m], which has
        no effect on a screw that is attached, as in Gazebo; gearbox_ratio, from which on the angles of
        a gearbox count anew; ratio of a gearbox, which leaves the angles, and reference_angle1 of the child,
        reference_angle2 of the parent [rad], from which they count.

        Raises:
            ParameterError: there is no such key, this kind of joint has none, or the value is NaN.
        """
        number = float(value)
        if math.isnan(number):
            raise ParameterError(f"joint {self.name!r}: {key} is NaN")
        self.release_deleted()
        if key == "hi_stop":
            self.axis_at(index).upper = number
            self._stops_changed(index)
        elif key == "lo_stop":
            self.axis_at(index).lower = number
            self._stops_changed(index)
        elif key == "friction":
            # Friction is a motor with the target velocity zero.
            self.axis_at(index).friction = number
            self.set_param("vel", 0.0, index)
            self.set_param("fmax", number, index)
        elif key == "thread_pitch":
            check_ratio(self.name, key, number)
            self.plan.pitch = number  # as in Gazebo 11.1, the thread that there is keeps its own
        elif key == "gearbox_ratio":
            check_ratio(self.name, key, number)
            self.plan.ratio = number
            if isinstance(self._mechanism, GearboxMechanism):
                self._mechanism.gears.set_ratio(number)
        elif key in GEARS:
            gears, most = self._gears(key), RATIOS["gearbox_ratio"][1]
            number = min(max(number, -most), most)
            if key == "ratio":
                gears.vary_ratio(number)
            else:
                index = GEARS.index(key)
                gears.references = [*gears.references[:index], number, *gears.references[index + 1 :]]
        else:
            ode_parameter = self._known_number(key, index)
            least, most = RANGES.get(key, (-math.inf, math.inf))
            number = min(max(number, least), most)
            self.record.set_parameter(key, index, number)
            if self.joint is not None:
                self.joint.SetParam(ode_parameter, number)

    @law
    def run_motor(self, rate: float) -> None:
        """Set the velocity of the first axis' motor [rad/s or m/s], as `set_param("vel", rate)` does."""
        joint = self._live_joint
        if joint is None:
            return
        low, high = RANGES["vel"]
        number = least(largest(rate, low), high)
        self.record.set_parameter("vel", 0, number)
        joint.SetParam(self._known_number("vel", 0), number)

    @property
    @constant
    def _live_mechanism(self) -> Mechanism | None:
        self.release_deleted()
        return self._mechanism

    @property
    @constant
    def _live_joint(self) -> Joint | None:
        self.release_deleted()
        return self.joint

    # Stops -----------------------------------------------------------------------------------------------------------

    def _turns(self, index: int) -> float:
        """Whole turns of an axis [rad], which ODE does not count."""
        turning = self._mechanism is not None and self._mechanism.turns(index)
        return TURN * round(self.position(index) / TURN) if turning else 0.0

    def _stops_changed(self, index: int) -> None:
        self._set_stops(index)
        self._refresh()

    def _set_stops(self, index: int) -> None:
        """Set ODE's stops to an axis' limits, in its own count of turns."""
        axis, turns = self.axes[index], self._turns(index)
        low = axis.lower - turns if abs(axis.lower) < UNLIMITED else -math.inf
        high = axis.upper - turns if abs(axis.upper) < UNLIMITED else math.inf
        if turns or (axis.wide and self._mechanism is not None and self._mechanism.turns(index)):
            # A stop that is half a turn away or more is none, unless the axis lies beyond it: it turns towards it.
            low = min(low, math.pi) if low >= -math.pi else -math.inf
            high = max(high, -math.pi) if high <= math.pi else math.inf
        self._set_ode_stops(index, low, high)
        self._spring_stops[index] = False
        self._stop_turns[index] = turns

    def _set_ode_stops(self, index: int, low: float, high: float) -> None:
        low_number, high_number = self._number("lo_stop", index), self._number("hi_stop", index)
        if self.joint is None or low_number is None or high_number is None:
            return
        for number, value in ((high_number, high), (low_number, low), (high_number, high)):
            self.joint.SetParam(number, value)

    def set_limits(self, index: int, *, effort: float | None = None, velocity: float | None = None) -> None:
        """Set the largest effort [N m or N], and the velocity [rad/s or m/s] above which efforts do not act."""
        axis = self.axis_at(index)
        axis.effort = axis.effort if effort is None else effort
        axis.velocity = axis.velocity if velocity is None else velocity

    # Springs ---------------------------------------------------------------------------------------------------------

    def set_spring(self, index: int, stiffness: float, damping: float, reference: float = 0.0) -> None:
        """Spring [N m/rad or N/m] and damper [N m s/rad or N s/m] about a reference [rad or m]."""
        axis = self.axis_at(index)
        axis.stiffness, axis.damping = finite(stiffness, "stiffness"), finite(damping, "damping")
        self.release_deleted()
        axis.reference = finite(reference, "reference")
        if self.joint is not None:
            self._set_stops(index)
        self._refresh()

    def _refresh(self) -> None:
        """Decide what applies springs: the engine the explicit ones of hinges and sliders, `update` all others.

        An implicit spring that is gentle is explicit, too: solved with the constraints it would lose energy.
        """
        self._engine_springs, self._step_time = False, self.engine.step_time
        mechanism, joint = self._mechanism, self.joint
        if mechanism is not None and joint is not None and mechanism.engine_springs:
            axis = self.axes[0]
            self._engine_springs = not self.implicit or self._gentle(axis)
            share = float(self._engine_springs)
            joint.set_spring(share * axis.stiffness, share * abs(axis.damping), axis.reference)
            if self._engine_springs and self._spring_stops.get(0):
                self._end_spring_stops(0)
        springs = any(axis.springs for axis in self.axes) and (self.implicit or not self._engine_springs)
        turning = mechanism is None or mechanism.turns(0)
        wide = turning and any(axis.wide for axis in self.axes)
        self._set_acts((mechanism is not None and mechanism.must_update) or springs or wide)

    def _set_acts(self, value: bool) -> None:
        if value != self.acts:
            self.acts = value
            self._changed()

    def _changed(self) -> None:
        """What acts, or holds links together, has changed."""
        if self.on_change is not None:
            self.on_change()

    def _gentle(self, axis: Axis) -> bool:
        """Whether spring and damper are far from what would be unstable with steps of this length."""
        ends = [body for body in self.links.movable if not body.kinematic]
        if not ends:
            return False
        turning, step = self._mechanism is not None and self._mechanism.turns(0), self.engine.step_time
        inertias = [min(b.GetMass().I[i] for i in (0, 5, 10)) if turning else b.mass for b in ends]
        inertia = 1.0 / sum(1.0 / value for value in inertias)
        return max(step * step * abs(axis.stiffness), step * abs(axis.damping)) <= GENTLE * inertia

    def update(self) -> None:
        """Apply what the joint does by itself in the coming step: springs, dampers, threads, gears."""
        if not self.attached or self._mechanism is None:
            return
        if self.implicit and self.engine.step_time != self._step_time:
            self._refresh()
        self._mechanism.update()
        if self.joint is None:
            return
        for index, axis in enumerate(self.axes):
            if axis.springs and not self._engine_springs and not (self.implicit and self._spring_by_stops(index, axis)):
                spring = axis.stiffness * (axis.reference - self.position(index))
                self._apply(spring - abs(axis.damping) * self.velocity(index), index)
            if axis.wide and not self._spring_stops.get(index):
                near = abs(self._mechanism.position(index) - self._stop_turns.get(index, math.inf)) < HALF_TURN
                if not near and self._turns(index) != self._stop_turns.get(index):
                    self._set_stops(index)

    def _spring_by_stops(self, index: int, axis: Axis) -> bool:
        """Let two stops at one place act as spring and damper, unless a limit is met; whether that is possible.

        erp = h k / (h k + d), cfm = 1 / (h k + d), as for contacts.
        """
        at, turns = self.position(index), self._turns(index)
        target = axis.reference - turns if axis.stiffness else at - turns
        if self._number("lo_stop", index) is None or (turns and abs(target) > HALF_TURN):
            return False
        if not axis.lower < at < axis.upper:
            if self._spring_stops.get(index):
                self._end_spring_stops(index)
            return True
        spring = self.engine.step_time * axis.stiffness
        total = spring + abs(axis.damping)
        acts = self._spring_stops.get(index)  # and so most numbers are what they were in the last step
        for key, value in (("stop_erp", spring / total), ("stop_cfm", 1.0 / total)):
            if not acts or self.record.parameter(key, index) != value:
                self.set_param(key, value, index)
        if not (acts and axis.stiffness and self._has_ode_stops(index, target)):
            self._set_ode_stops(index, target, target)
        if not acts:
            self._spring_stops[index] = True
        return True

    def _has_ode_stops(self, index: int, at: float) -> bool:
        """Whether both of ODE's stops are at one place."""
        numbers = self._number("lo_stop", index), self._number("hi_stop", index)
        return self.joint is not None and all(n is not None and self.joint.GetParam(n) == at for n in numbers)

    def _end_spring_stops(self, index: int) -> None:
        """Let the stops be limits again."""
        self._set_stops(index)
        for key, default in (("stop_erp", 0.2), ("stop_cfm", 0.0)):
            self.set_param(key, self.plan.parameters.get(key, default), index)

    # Feedback --------------------------------------------------------------------------------------------------------

    def provide_feedback(self, on: bool) -> None:
        """Whether `wrench` is filled in each step."""
        self.release_deleted()
        self.plan.feedback = on
        if self._mechanism is not None:
            self._mechanism.provide_feedback(on)

    @property
    def wrench(self) -> tuple[GzVector, GzVector, GzVector, GzVector]:
        """(force, torque) on the parent, then on the child, that the joint applied to them in the last step.

        Forces [N]; torques about the anchor [N m]; global. Efforts of `add_force` are in it, explicit springs are not.
        """
        if not self.attached or not self.plan.feedback or self._mechanism is None:
            return GzVector(), GzVector(), GzVector(), GzVector()
        on_child, on_parent = self._mechanism.feedback()
        anchor, movable = self.anchor(), self.links.movable
        result: list[GzVector] = []
        for body, (force, torque) in ((self.parent, on_parent), (self.child, on_child)):
            if body is not None and body in movable:
                arm = GzVectorSub(body.GetCoMPose().pos, anchor)
                torque = GzVectorAdd(torque, GzVectorCross(arm, force))
            result += [force, torque]
        if self.parent not in movable:
            result[:2] = [GzVectorMul(-1.0, v) for v in result[2:]]
        elif self.child not in movable:
            result[2:] = [GzVectorMul(-1.0, v) for v in result[:2]]
        force, torque = self._effort_on_child(self._mechanism, anchor)
        return (
            GzVectorSub(result[0], force),
            GzVectorSub(result[1], torque),
            GzVectorAdd(result[2], force),
            GzVectorAdd(result[3], torque),
        )

    def _effort_on_child(self, mechanism: Mechanism, anchor: GzVector) -> tuple[GzVector, GzVector]:
        """(force, torque about the anchor) of what `add_force` applied in the last step, global."""
        efforts = self.record.efforts_of(self.engine.steps - 1)
        force, torque = GzVector(), GzVector()
        for index, effort in enumerate(efforts[: self.dof]):
            if effort == 0.0:
                continue
            applied = GzVectorMul(mechanism.sense * effort, self.axis(min(index, len(self.axes) - 1)))
            if not mechanism.is_force(index):
                torque = GzVectorAdd(torque, applied)
                continue
            force = GzVectorAdd(force, applied)
            centres = [body.GetCoMPose().pos for body in self.links.movable] if mechanism.between_centres else []
            for centre in centres:
                arm = GzVectorMul(1.0 / len(centres), GzVectorSub(centre, anchor))
                torque = GzVectorAdd(torque, GzVectorCross(arm, applied))
        return force, torque


def place_of(body: Body | None) -> Place:
    """Where a link stands in its world; None for the world itself."""
    if body is None or body.model is None:
        return None
    return body.model.GetId(), body.model.bodies.index(body)
