"""Reading a `<joint>` element: its kind, frame, axes, and ODE's parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from libgz.base.errors import NotFoundError, ParameterError
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzQuaternInverse, GzVector, rotate
from libgz.base.law import largest, law, least, possible, where
from libgz.base.visible import one_line
from libgz.physics.body import Body
from libgz.sdf.element import Element
from libgz.sdfworld.joint_record import AxisRecord

__all__ = ["IN_MODEL", "UNLIMITED", "Axis", "FindLink", "JointPlan", "lost_link", "read_joint"]

UNLIMITED = 1e16  # limits of this size and above mean none
HALF_TURN = 3.0  # [rad], a little less than pi: stops yield

NEEDED_AXES = {"revolute": 1, "prismatic": 1, "revolute2": 2, "universal": 2}  # for which ODE has defaults
IN_MODEL = ("revolute2", "screw")  # Gazebo takes their axes, given in the joint's frame, as those of the parent's model

Note = Callable[[Element, str], None]  # reports a warning about an element
FindLink = Callable[[str], Body]  # a link by its name in a file


class Axis(AxisRecord):
    """One axis of a joint. Angles [rad] for rotation, [m] for translation; efforts [N m] or [N].

    Springs and stops of a joint that is made are changed through it: `set_spring`, `set_param`.

    Args:
        direction: global, when the joint was made.
        given: False: ODE's default, fixed to the links and not to the joint's frame.
        lower: the lower limit.
        upper: the upper limit.
        effort: the largest effort; negative: no limit.
        velocity: above which efforts do not act; negative: no limit.
        damping: of the damper [N m s/rad] or [N s/m].
        friction: of the axis [N m] or [N].
        stiffness: of the spring [N m/rad] or [N/m].
        reference: where the spring rests.
        stop_stiffness: kept, as in Gazebo, and not used by ODE.
        stop_dissipation: the same.
    """

    def __init__(
        self,
        direction: GzVector,
        given: bool = True,
        lower: float = -UNLIMITED,
        upper: float = UNLIMITED,
        effort: float = -1.0,
        velocity: float = -1.0,
        damping: float = 0.0,
        friction: float = 0.0,
        stiffness: float = 0.0,
        reference: float = 0.0,
        stop_stiffness: float = 1e8,
        stop_dissipation: float = 1.0,
    ) -> None:
        self.direction, self.given = direction, given
        limits, dynamics = (lower, upper, effort, velocity), (damping, friction, stiffness, reference)
        super().__init__(*limits, *dynamics, stop_stiffness, stop_dissipation)

    @law
    def within_effort(self, effort: float) -> float:
        """An effort, at most the largest one to either side."""
        limit = self.effort
        if possible(limit >= 0.0):
            return where(limit >= 0.0, largest(-limit, least(limit, effort)), effort)  # type: ignore[no-any-return]
        return effort

    @property
    def springs(self) -> bool:
        """Whether it applies an effort by itself in every step."""
        return self.damping != 0.0 or self.stiffness != 0.0

    @property
    def wide(self) -> bool:
        """Whether a stop lies near half a turn or beyond, where ODE's angles end."""
        return HALF_TURN < abs(self.lower) < UNLIMITED or HALF_TURN < abs(self.upper) < UNLIMITED


@dataclass(eq=False, repr=False)
class JointPlan:
    """A joint to be made."""

    name: str
    kind: str
    parent: Body | None  # None: the world
    child: Body | None
    anchor: GzPose  # the joint's frame, global
    axes: list[Axis]
    pitch: float = 1.0  # of a screw [rad/m]
    ratio: float = 1.0  # of a gearbox
    reference: Body | None = None  # of a gearbox
    implicit: bool = False  # springs and dampers are solved with the constraints
    feedback: bool = False
    parameters: dict[str, float] = field(default_factory=dict)  # ODE's, by the keys of SdfJoint.set_param
    element: Element | None = None


def read_joint(element: Element, find_link: FindLink, model_pose: GzPose, note: Note) -> JointPlan:
    """Read a `<joint>`.

    Args:
        element: the `<joint>`.
        find_link: returns a link by its name.
        model_pose: global pose of the model it stands in.
        note: reports a warning about an element.

    Raises:
        NotFoundError: a link does not exist.
        ParameterError: a value is not allowed.
    """
    parent, child = (_link(element, find_link, end) for end in ("parent", "child"))
    frame = child.GetPose() if child is not None else GzPose()
    anchor = GzCoordPoseAdd(element.Get(GzPose, "pose"), frame)
    plan = JointPlan(
        element.Get(str, "name"),
        element.Get(str, "type"),
        parent,
        child,
        anchor,
        _read_axes(element, anchor, _parent_frame(parent, model_pose), note),
        pitch=element.Get(float, "thread_pitch"),
        ratio=element.Get(float, "gearbox_ratio"),
        element=element,
    )
    if plan.kind == "gearbox" and element.HasElement("gearbox_reference_body"):
        plan.reference = _link(element, find_link, "gearbox_reference_body")
    _read_ode(element, plan)
    return plan


def _link(element: Element, find_link: FindLink, end: str) -> Body | None:
    """A link by name; None for the world."""
    name = element.Get(str, end)
    if name == "world":
        return None
    try:
        return find_link(name)
    except NotFoundError as error:
        raise NotFoundError(f"joint {element.Get(str, 'name')!r}: <{end}> names link {name!r}; {error}") from None


def lost_link(element: Element, find_link: FindLink) -> str:
    """Why a `<joint>` cannot be made whose link is in an `<include>` that was not found; "" if there is no such one."""
    lost = ", ".join(f"{i.where} ({one_line(i.Get(str, 'uri').strip())})" for i in _missing_includes(element))
    for end in ("parent", "child") if lost else ():
        try:
            _link(element, find_link, end)
        except NotFoundError:
            name, link = element.Get(str, "name"), element.Get(str, end)
            return (
                f"joint {name!r}: <{end}> names link {link!r}; it may be in what was not found: the <include> at "
                f"{lost}; the joint is left out"
            )
    return ""


def _missing_includes(element: Element) -> Iterator[Element]:
    """The includes around an element that were left out."""
    above: Element | None = element.parent
    while above is not None:
        yield from above.named("include")
        above = above.parent


def _parent_frame(parent: Body | None, model_pose: GzPose) -> GzPose:
    """Global pose of the frame that SDF calls that of the parent model."""
    if parent is None:
        return GzPose()
    pose: GzPose = parent.model.GetPose() if parent.model is not None else model_pose
    return pose


def _read_axes(element: Element, anchor: GzPose, model_pose: GzPose, note: Note) -> list[Axis]:
    """The axes in global terms: in SDF 1.4 they are in the model's frame, later in the joint's by default."""
    axes: list[Axis] = []
    kind = element.Get(str, "type")
    frame = model_pose if kind in IN_MODEL else anchor
    for name, default in (("axis", GzVector(1.0, 0.0, 0.0)), ("axis2", GzVector(0.0, 1.0, 0.0))):
        if not element.HasElement(name):
            if len(axes) < NEEDED_AXES.get(kind, 0):
                note(element, f"<{name}> is missing; ODE's default is used, an axis of each link")
                axes.append(Axis(rotate(anchor.rot, default), given=False))
            continue
        axis = element.child(name)
        described = axis.description.children if axis.description is not None else {}
        in_model = "use_parent_model_frame" not in described or axis.Get(bool, "use_parent_model_frame")
        local = axis.Get(GzVector, "xyz")
        if in_model:
            local = rotate(GzQuaternInverse(anchor.rot), rotate(model_pose.rot, local))
        direction = rotate(frame.rot, local)
        if math.sqrt(sum(v * v for v in direction)) < 1e-12:
            direction = GzVector(1.0, 0.0, 0.0)  # as ODE's in Gazebo
            if kind not in ("fixed", "ball"):
                note(element, f"<{name}> is zero; 1 0 0 in the world is used instead")
        if axis.HasElement("initial_position") and axis.Get(float, "initial_position") != 0.0:
            note(
                axis, "<initial_position> has no effect, as in Gazebo; a joint begins where the poses of its links are"
            )
        dynamics, limit = axis.child("dynamics"), axis.child("limit")
        lower, upper, effort, velocity = (_number(limit, key) for key in ("lower", "upper", "effort", "velocity"))
        axes.append(
            Axis(
                direction,
                True,
                lower,
                upper,
                effort,
                velocity,
                _number(dynamics, "damping"),
                _number(dynamics, "friction"),
                _number(dynamics, "spring_stiffness"),
                _number(dynamics, "spring_reference"),
                _number(limit, "stiffness"),
                _number(limit, "dissipation"),
            )
        )
    return axes


def _number(element: Element, key: str) -> float:
    """A number limited to what ODE can use; infinity becomes that bound."""
    value = element.Get(float, key)
    if math.isnan(value):
        raise ParameterError(f"{element.where}: <{key}> is not a number")
    return max(-UNLIMITED, min(UNLIMITED, value))


def _read_ode(element: Element, plan: JointPlan) -> None:
    """Read what the file has of `<physics>`."""
    if not element.HasElement("physics"):
        return
    physics = element.child("physics")
    plan.feedback = physics.Get(bool, "provide_feedback")
    if not physics.HasElement("ode"):
        return
    ode = physics.child("ode")
    plan.feedback = plan.feedback or ode.Get(bool, "provide_feedback")
    plan.implicit = ode.Get(bool, "implicit_spring_damper") or ode.Get(bool, "cfm_damping")
    keys = {"fudge_factor": "fudge_factor", "bounce": "bounce"}
    if plan.kind != "ball":  # as in Gazebo, where SetParam alone softens it
        keys |= {"cfm": "cfm", "erp": "erp"}
    keys |= {"max_force": "fmax", "velocity": "vel"}
    for tag, key in keys.items():
        if ode.HasElement(tag):
            plan.parameters[key] = ode.Get(float, tag)
    for part, prefix in (("limit", "stop"), ("suspension", "suspension")):
        if ode.HasElement(part):
            for tag in ("cfm", "erp"):
                plan.parameters[f"{prefix}_{tag}"] = ode.child(part).Get(float, tag)
