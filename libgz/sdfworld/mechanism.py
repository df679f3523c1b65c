"""Mechanisms: what holds the two links of an SDF joint together, a class per kind of joint.

A new kind of joint is a class here and a row in `MECHANISMS`.

- In classic worlds angles count their turns (`Engine.count_turns`, `unwind` in `motion.c`); ODE's are between -pi and
  pi. A joint with a stop beyond that gives ODE the stop that is near, before each step.
- ODE has neither screws nor gears. Both are made of a *line joint*, one row of the solver that keeps two bodies from
  moving along one line, placed along a thread's flank or a tooth before each step. A gearbox has a *rack*: a body
  without shape that both gears mesh with.
- ODE writes beside its arrays where a hinge's stops are removed while one is reached: `HingeJoint.SetParam`.
- A `revolute2` without suspension is ODE's universal joint, whose second axis knows stops.
- Explicit springs and dampers of hinges and sliders are applied by the engine; all others in `SdfJoint.update`.
- Links without joints and sensors are auto-disabled at rest. A contact, an effort, a new pose or velocity, other
  gravity,
  and any static geom that moves or is removed wakes them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from libgz.base.errors import ParameterError, nearest
from libgz.base.geometry import GzVector, GzVectorAdd, GzVectorDot, GzVectorMag, GzVectorMul
from libgz.base.law import constant, law
from libgz.physics.body import Body
from libgz.physics.couplings import Gears, PistonJoint, Thread
from libgz.physics.engine import Engine
from libgz.physics.joint import BallJoint, FixedJoint, HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint
from libgz.sdfworld.axis import Axis, JointPlan
from libgz.sdfworld.joint_record import PARAMETERS

__all__ = [
    "MECHANISMS",
    "RATIOS",
    "GearboxMechanism",
    "Links",
    "Mechanism",
    "ScrewMechanism",
    "check_ratio",
    "mechanism_class",
    "ode_number",
]

SECOND = 0x100  # from the parameters of ODE's first axis to those of its second
PARALLEL = 0.999  # cosine from which two axes count as parallel
SKEW = 1e-3  # cosine up to which two axes are at right angles

Wrench = tuple[GzVector, GzVector]  # force [N], torque about the centre of mass [N m]


@dataclass(eq=False, repr=False)
class Links:
    """The two links of a joint; None is the world."""

    parent: Body | None
    child: Body | None

    @property
    def movable(self) -> list[Body]:
        """Those that are no part of the world, the parent first."""
        return [body for body in (self.parent, self.child) if body is not None and not body.dummy]


def ode_number(key: str, index: int) -> int | None:
    """ODE's number of a parameter of a joint with one axis; None where there is no such parameter."""
    return PARAMETERS.get(key) if index == 0 or key.startswith("suspension") else None


def cosine(axes: list[Axis]) -> float:
    """Of the angle between both axes, without its sign."""
    first, second = (axis.direction for axis in axes)
    return abs(GzVectorDot(first, second)) / (GzVectorMag(first) * GzVectorMag(second))


class Mechanism:
    """Base of all kinds, and all that a kind with one ODE joint needs.

    Positive motion is that of the child against the parent, about or along the axis; if `sense` is -1, as in Gazebo for
    `revolute2`, that of the parent against the child.

    Args:
        engine: where.
        plan: the joint.
        links: what it joins, as they stand.
        anchor: global point of the joint's frame [m].
    """

    needed_axes: ClassVar[int] = 1
    ode_class: ClassVar[type[Joint]]
    sense: ClassVar[float] = 1.0
    holds: ClassVar[bool] = False  # whether the engine can hold an effort over several steps
    engine_springs: ClassVar[bool] = False  # whether the engine applies springs of its own to this kind
    moves: ClassVar[str] = ""  # "turning" or "sliding": how a velocity that is set moves the child alone, as in Gazebo

    joint: Joint | None

    def __init__(self, engine: Engine, plan: JointPlan, links: Links, anchor: GzVector) -> None:
        self.plan, self.links = plan, links
        self.joint = joint = self.ode_class(engine, name=plan.name)
        try:
            self.join(joint, anchor, [axis.direction if axis.given else None for axis in plan.axes])
            for index, axis in enumerate(plan.axes):
                if not axis.given:
                    axis.direction = self.axis(index) or axis.direction
        except BaseException:  # a joint that holds nothing must not stay: ODE crashes on it
            joint.close()
            raise

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        """Attach ODE's joint, and set its anchor and axes; None is an axis that keeps ODE's default."""
        joint.Attach(self.links.child, self.links.parent)
        joint.SetAnchor(anchor)

    @classmethod
    def check(cls, plan: JointPlan) -> None:
        """Complete and check the axes of a plan.

        Raises:
            ParameterError: an axis is missing, or a value is not allowed.
        """
        if len(plan.axes) < cls.needed_axes:
            raise ParameterError(f"joint {plan.name!r}: a {plan.kind} joint needs an <axis>")

    @staticmethod
    def dof(plan: JointPlan) -> int:
        """How many positions a joint of this kind has."""
        return len(plan.axes)

    @staticmethod
    def turns(index: int) -> bool:
        """Whether a position is an angle."""
        return True

    @property
    def closed(self) -> bool:
        """Whether a link that it held was deleted."""
        return self.joint is None or self.joint.closed

    def close(self) -> None:
        """Destroy it."""
        if self.joint is not None:
            self.joint.close()

    # State -----------------------------------------------------------------------------------------------------------

    @constant
    def column(self, index: int) -> int:
        """Column of a position in the joint's row of the engine's table."""
        return index

    @law
    def position(self, index: int) -> float:
        """Angle [rad], turns counted, or position [m]."""
        return self.joint._value(self.column(index)) if self.joint is not None else 0.0

    @law
    def velocity(self, index: int) -> float:
        """Rate [rad/s] or [m/s]."""
        return self.joint._value(2 + self.column(index)) if self.joint is not None else 0.0

    def count_from(self, position: float, index: int) -> None:
        """Write a position into the engine's table: turns are counted from it."""
        if self.joint is not None:
            self.joint.count_turns_from(self.column(index), position)

    def restore(self) -> None:
        """Count turns from zero again."""
        if self.joint is not None:
            self.joint.reset_turns()

    def update(self) -> None:
        """Prepare the coming step."""

    @property
    def must_update(self) -> bool:
        """Whether `update` has anything to do."""
        return False

    # Motion ----------------------------------------------------------------------------------------------------------

    @law
    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        """Apply an effort for one step [N m] or [N]; `anchor` returns the joint's, global [m]."""

    @law
    def axis(self, index: int) -> GzVector | None:
        """An axis as it lies now, global; None if it is fixed to the child."""
        return None

    def second_anchor(self) -> GzVector | None:
        """The global anchor on the second link [m], where that is another point."""
        return None

    @law
    def motion(self, change: float, index: int, axis: GzVector) -> tuple[GzVector, GzVector]:
        """(rotation vector, translation), global, of a change of a position."""
        return GzVectorMul(self.sense * change, axis), GzVector()

    def number(self, key: str, index: int) -> int | None:
        """ODE's number of a parameter, by classic's key; None where this kind has no such parameter."""
        return ode_number(key, index)

    # Feedback --------------------------------------------------------------------------------------------------------

    def provide_feedback(self, on: bool) -> None:
        """Whether `feedback` is filled in each step."""
        if self.joint is not None:
            self.joint.provide_feedback(on)

    def feedback(self) -> tuple[Wrench, Wrench]:
        """What it put on the child, and on the parent, in the last step; global."""
        if self.joint is None:
            return (GzVector(), GzVector()), (GzVector(), GzVector())
        force1, torque1, force2, torque2 = self.joint.feedback
        return (force1, torque1), (force2, torque2)

    def is_force(self, index: int) -> bool:
        """Whether an effort is a force [N], not a torque [N m]."""
        return False

    @property
    def between_centres(self) -> bool:
        """Whether forces act half way between both centres of mass, not at the anchor."""
        return False


class HingeMechanism(Mechanism):
    """`revolute`: one axis of rotation."""

    ode_class = HingeJoint
    moves = "turning"
    engine_springs = holds = True
    joint: HingeJoint

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, axes)
        if axes[0] is not None:
            self.joint.SetAxis(axes[0])

    @law
    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        self.joint.SetTorque(effort)

    @law
    def axis(self, index: int) -> GzVector:
        return self.joint.GetAxis()


class SliderMechanism(Mechanism):
    """`prismatic`: one axis of translation."""

    ode_class = SliderJoint
    moves = "sliding"
    engine_springs = holds = True
    joint: SliderJoint

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, axes)
        if axes[0] is not None:
            self.joint.SetAxis(*axes[0])

    @staticmethod
    def turns(index: int) -> bool:
        return False

    @law
    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        self.joint.SetSliderForce(effort)

    @law
    def axis(self, index: int) -> GzVector:
        return self.joint.GetAxis()

    @law
    def motion(self, change: float, index: int, axis: GzVector) -> tuple[GzVector, GzVector]:
        return GzVector(), GzVectorMul(change, axis)

    def is_force(self, index: int) -> bool:
        return True

    @property
    def between_centres(self) -> bool:
        return True


class BallMechanism(Mechanism):
    """`ball`: free to turn about a point. Of ODE's parameters it has the softness of the joint itself."""

    needed_axes = 0
    ode_class = BallJoint

    def number(self, key: str, index: int) -> int | None:
        return PARAMETERS[key] if key in ("erp", "cfm") and index == 0 else None


class FixedMechanism(Mechanism):
    """`fixed`: no freedom at all, and no parameters; in Gazebo `<cfm>` and `<erp>` do not soften it."""

    needed_axes = 0
    ode_class = FixedJoint
    joint: FixedJoint

    @classmethod
    def check(cls, plan: JointPlan) -> None:
        super().check(plan)
        plan.axes.clear()  # one in the file has no effect

    def number(self, key: str, index: int) -> int | None:
        return None

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, axes)
        self.joint.SetFixed()


class _TwoAxes(Mechanism):
    """A kind with two axes of rotation."""

    @classmethod
    def check(cls, plan: JointPlan) -> None:
        super().check(plan)
        if len(plan.axes) == 1:
            raise ParameterError(f"joint {plan.name!r}: a {plan.kind} joint needs an <axis2>")
        if all(axis.given for axis in plan.axes) and cosine(plan.axes) > PARALLEL:
            raise ParameterError(f"joint {plan.name!r}: the axes of a {plan.kind} joint must not be parallel")


class UniversalMechanism(_TwoAxes):
    """`universal`: the first axis is fixed to the parent, ODE's second body."""

    ode_class = UniversalJoint
    moves = "turning"
    joint: UniversalJoint

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, axes)
        if axes[0] is not None:
            self.joint.SetAxis2(axes[0])
        if axes[1] is not None:
            self.joint.SetAxis1(axes[1])

    @constant
    def column(self, index: int) -> int:
        return 1 - index

    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        if index == 0:
            self.joint.SetTorque(0.0, effort)
        else:
            self.joint.SetTorque(effort, 0.0)

    def axis(self, index: int) -> GzVector:
        return self.joint.GetAxis2() if index == 0 else self.joint.GetAxis1()

    def number(self, key: str, index: int) -> int | None:
        return _two_numbers(key, index, first_group=1)


class SteeredMechanism(UniversalMechanism):
    """`revolute2` where a universal joint is the same, with the sense of Gazebo's `revolute2`."""

    sense = -1.0
    moves = ""

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, [GzVectorMul(-1.0, axis) if axis is not None else None for axis in axes])

    def axis(self, index: int) -> GzVector:
        return GzVectorMul(-1.0, super().axis(index))


class Hinge2Mechanism(_TwoAxes):
    """`revolute2` with a suspension, or with axes that meet at any angle.

    ODE ties its first axis to the first body; the second angle it measures against its own rate.
    """

    sense = -1.0
    ode_class = Hinge2Joint
    joint: Hinge2Joint

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        joint.Attach(self.links.parent, self.links.child)
        joint.SetAnchor(anchor)
        first, second = axes
        if first is not None and second is not None:
            self.joint.SetAxes(first, second)
        elif first is not None:
            self.joint.SetAxis1(first)
        elif second is not None:
            self.joint.SetAxis2(second)

    def position(self, index: int) -> float:
        angle = super().position(index)
        return -angle if index == 1 else angle

    def count_from(self, position: float, index: int) -> None:
        super().count_from(-position if index == 1 else position, index)

    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        if index == 0:
            self.joint.SetTorque(effort, 0.0)
        else:
            self.joint.SetTorque(0.0, effort)

    def axis(self, index: int) -> GzVector:
        return self.joint.GetAxis1() if index == 0 else self.joint.GetAxis2()

    def second_anchor(self) -> GzVector:
        return self.joint.GetAnchor2()

    def number(self, key: str, index: int) -> int | None:
        return _two_numbers(key, index, first_group=0)

    def feedback(self) -> tuple[Wrench, Wrench]:
        on_parent, on_child = super().feedback()
        return on_child, on_parent


class ScrewMechanism(Mechanism):
    """`screw`: an angle, and the way along the axis that a thread makes of it."""

    ode_class = PistonJoint
    joint: PistonJoint

    def __init__(self, engine: Engine, plan: JointPlan, links: Links, anchor: GzVector) -> None:
        super().__init__(engine, plan, links, anchor)
        self.thread = Thread(self.joint, plan.pitch)

    def join(self, joint: Joint, anchor: GzVector, axes: list[GzVector | None]) -> None:
        super().join(joint, anchor, axes)
        if axes[0] is not None:
            self.joint.SetAxis(axes[0])

    @classmethod
    def check(cls, plan: JointPlan) -> None:
        super().check(plan)
        del plan.axes[1:]
        check_ratio(plan.name, "thread_pitch", plan.pitch)

    @staticmethod
    def dof(plan: JointPlan) -> int:
        return 2

    @staticmethod
    def turns(index: int) -> bool:
        return index == 0

    @property
    def closed(self) -> bool:
        return self.thread.broken or super().closed

    def close(self) -> None:
        self.thread.close()
        super().close()

    def update(self) -> None:
        self.thread.update()

    @property
    def must_update(self) -> bool:
        return True

    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        axis = self.joint.GetAxis()
        for body, sign in ((self.links.child, 1.0), (self.links.parent, -1.0)):
            if body is None:
                continue
            applied = GzVectorMul(sign * effort, axis)
            if index == 0:
                body.AddTorque(*applied)
            else:  # ODE's own function for this turns both bodies, too
                body.AddForceAtPos(*applied, *anchor())

    def axis(self, index: int) -> GzVector:
        return self.joint.GetAxis()

    def motion(self, change: float, index: int, axis: GzVector) -> tuple[GzVector, GzVector]:
        turn = change if index == 0 else -change * self.thread.pitch
        return GzVectorMul(turn, axis), GzVectorMul(-turn / self.thread.pitch, axis)

    def number(self, key: str, index: int) -> int | None:
        return _two_numbers(key, index, first_group=1)  # group 1 of ODE's piston is the sliding

    def provide_feedback(self, on: bool) -> None:
        super().provide_feedback(on)
        self.thread.provide_feedback(on)

    def feedback(self) -> tuple[Wrench, Wrench]:
        force1, torque1, force2, torque2 = (
            GzVectorAdd(a, b) for a, b in zip(self.joint.feedback, self.thread.feedback, strict=True)
        )
        return (force1, torque1), (force2, torque2)

    def is_force(self, index: int) -> bool:
        return index == 1


class GearboxMechanism(Mechanism):
    """`gearbox`: the angles of parent and child against a reference body, in a fixed ratio. It has no ODE joint.

    As in Gazebo, axis 0 is the child's, and axis 1 the parent's, which is the first of the gears.
    """

    def __init__(self, engine: Engine, plan: JointPlan, links: Links, anchor: GzVector) -> None:
        if len(links.movable) < 2 or links.parent is None or links.child is None:
            raise ParameterError(f"joint {plan.name!r}: a gearbox joins two links that move")
        self.plan, self.links, self.engine = plan, links, engine
        self.joint = None
        directions = (plan.axes[1].direction, plan.axes[0].direction)
        self.gears = Gears(engine, (links.parent, links.child), directions, plan.ratio, plan.reference)

    @classmethod
    def check(cls, plan: JointPlan) -> None:
        super().check(plan)
        if len(plan.axes) == 1:
            plan.axes.append(Axis(GzVector(*plan.axes[0].direction)))
        check_ratio(plan.name, "gearbox_ratio", plan.ratio)

    @property
    def closed(self) -> bool:
        return self.gears.broken

    def close(self) -> None:
        self.gears.close()

    def position(self, index: int) -> float:
        return self.gears.angles[1 - index]

    def velocity(self, index: int) -> float:
        return self.gears.rates()[1 - index]

    def restore(self) -> None:
        self.gears.restore()

    def update(self) -> None:
        self.gears.update(self.engine.step_time)

    @property
    def must_update(self) -> bool:
        return True

    def apply(self, effort: float, index: int, anchor: Callable[[], GzVector]) -> None:
        gear = 1 - index
        self.gears.bodies[gear].AddTorque(*GzVectorMul(effort, self.gears.direction(gear)))


MECHANISMS: dict[str, type[Mechanism]] = {
    "revolute": HingeMechanism,
    "prismatic": SliderMechanism,
    "ball": BallMechanism,
    "universal": UniversalMechanism,
    "revolute2": SteeredMechanism,  # or Hinge2Mechanism: `mechanism_class`
    "fixed": FixedMechanism,
    "screw": ScrewMechanism,
    "gearbox": GearboxMechanism,
}
RATIOS = {"thread_pitch": (1e-5, 1e9), "gearbox_ratio": (1e-4, 1e4)}


def mechanism_class(plan: JointPlan, links: Links) -> type[Mechanism]:
    """What can make a joint between two links.

    A `revolute2` is ODE's Hinge2 where it has a suspension, or axes that are not at right angles. But that knows no
    stops of the second axis, and wants two bodies; else a universal joint is the same and does more.

    Raises:
        ParameterError: the kind is unknown.
    """
    if plan.kind not in MECHANISMS:
        known = ", ".join(MECHANISMS)
        raise ParameterError(
            f"type {plan.kind!r} is not a kind of joint here; allowed are {known}{nearest(plan.kind, MECHANISMS)}"
        )
    if plan.kind == "revolute2" and len(links.movable) == 2 and len(plan.axes) == 2:
        sprung = any(key.startswith("suspension") for key in plan.parameters)
        default = not all(
            axis.given for axis in plan.axes
        )  # ODE's of a Hinge2 are others than those of a universal joint
        if sprung or default or cosine(plan.axes) > SKEW:
            return Hinge2Mechanism
    return MECHANISMS[plan.kind]


def check_ratio(name: str, key: str, value: float) -> None:
    """Check the pitch of a screw or the ratio of a gearbox.

    Raises:
        ParameterError: it is zero, or absurdly small or large.
    """
    least, most = RATIOS[key]
    if not least <= abs(value) <= most:
        raise ParameterError(f"joint {name!r}: {key} is {value:g}; its size must be {least:g} to {most:g}")


def _two_numbers(key: str, index: int, first_group: int) -> int | None:
    """ODE's number of a parameter of one of two axes; the first one's group of numbers is 0 or 1."""
    base = PARAMETERS.get(key)
    if base is None or key.startswith("suspension"):
        return base
    return base + SECOND * (first_group ^ index) if index in (0, 1) else None
