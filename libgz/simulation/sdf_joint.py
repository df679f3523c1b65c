"""SdfJoint: a joint of an SDF model: its axes, limits, damping, springs and friction."""

from __future__ import annotations

import math
from dataclasses import dataclass

from libgz.errors import NotFoundError, ParameterError
from libgz.geometry import GzCoordPoseAdd, GzPose, GzVector, rotate
from libgz.ode.types import dParamFMax, dParamFMax2, dParamHiStop, dParamHiStop2, dParamLoStop, dParamLoStop2, dParamVel
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.joint import BallJoint, FixedJoint, Hinge2Joint, HingeJoint, Joint, SliderJoint, UniversalJoint
from libgz.sdf.element import Element

__all__ = ["KINDS", "Axis", "SdfJoint"]

UNLIMITED = 1e16  # limits from here on mean none
KINDS: dict[str, type[Joint]] = {
    "revolute": HingeJoint,
    "prismatic": SliderJoint,
    "ball": BallJoint,
    "universal": UniversalJoint,
    "revolute2": Hinge2Joint,
    "fixed": FixedJoint,
}
UNKNOWN = "is not a kind of joint here; allowed are " + ", ".join(KINDS)


@dataclass
class Axis:
    """One axis of a joint. Angles [rad] for rotation, [m] for translation; efforts [N m] or [N]."""

    direction: GzVector  # global, when the joint was made
    lower: float = -UNLIMITED
    upper: float = UNLIMITED
    effort: float = -1.0  # negative: no limit
    velocity: float = -1.0
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    reference: float = 0.0

    @property
    def acts(self) -> bool:
        """Whether it pushes by itself in every step."""
        return self.damping != 0.0 or self.stiffness != 0.0


class SdfJoint:
    """A joint between two links, or a link and the world.

    Args:
        engine: where.
        element: the `<joint>`.
        links: the model's links by name.
        model_pose: global pose of the model.

    Raises:
        NotFoundError: a link does not exist.
        ParameterError: the kind is unknown, or a value is not allowed.
    """

    def __init__(self, engine: Engine, element: Element, links: dict[str, Body], model_pose: GzPose) -> None:
        self.name = element.Get(str, "name")
        self.kind = element.Get(str, "type")
        if self.kind not in KINDS:
            raise ParameterError(f"type {self.kind!r} {UNKNOWN}")
        self.parent, self.child = (self._link(element, links, end) for end in ("parent", "child"))
        anchor = self._anchor(element)
        self.axes = self._read_axes(element, anchor, model_pose)
        self.joint = KINDS[self.kind](engine, name=self.name)
        self._attach(anchor.pos)
        self._set_limits()

    @staticmethod
    def _link(element: Element, links: dict[str, Body], end: str) -> Body | None:
        """A link by name; None for the world."""
        name = element.Get(str, end).strip()
        if name == "world":
            return None
        if name not in links:
            known = ", ".join(links) or "none"
            raise NotFoundError(f"joint {element.Get(str, 'name')!r}: <{end}> names link {name!r}; there are {known}")
        return links[name]

    def _anchor(self, element: Element) -> GzPose:
        """The global pose of the joint's frame, which is given in the child link."""
        child = self.child.GetPose() if self.child is not None else GzPose()
        return GzCoordPoseAdd(element.Get(GzPose, "pose"), child)

    @staticmethod
    def _read_axes(element: Element, anchor: GzPose, model_pose: GzPose) -> list[Axis]:
        """The axes in global terms: in SDF 1.4 they are of the model's frame, later of the joint's unless told."""
        axes = []
        for name in ("axis", "axis2"):
            if not element.HasElement(name):
                continue
            axis = element.child(name)
            described = axis.description.children if axis.description is not None else {}
            in_model = "use_parent_model_frame" not in described or axis.Get(bool, "use_parent_model_frame")
            frame = model_pose if in_model else anchor
            dynamics, limit = axis.child("dynamics"), axis.child("limit")
            axes.append(
                Axis(
                    rotate(frame.rot, axis.Get(GzVector, "xyz")),
                    limit.Get(float, "lower"),
                    limit.Get(float, "upper"),
                    limit.Get(float, "effort"),
                    limit.Get(float, "velocity"),
                    dynamics.Get(float, "damping"),
                    dynamics.Get(float, "friction"),
                    dynamics.Get(float, "spring_stiffness"),
                    dynamics.Get(float, "spring_reference"),
                )
            )
        return axes

    def _attach(self, anchor: GzVector) -> None:
        """Join the links so that positive motion is that of the child, about or along the axis."""
        joint = self.joint
        if isinstance(joint, Hinge2Joint):
            # ODE ties the first axis to the first body, and measures the other way round.
            joint.Attach(self.parent, self.child)
            joint.SetAnchor(anchor)
            joint.SetAxis1([-v for v in self.axes[0].direction])
            joint.SetAxis2([-v for v in self.axes[1].direction])
            return
        joint.Attach(self.child, self.parent)
        joint.SetAnchor(anchor)
        if isinstance(joint, HingeJoint):
            joint.SetAxis(self.axes[0].direction)
        elif isinstance(joint, SliderJoint):
            joint.SetAxis(*self.axes[0].direction)
        elif isinstance(joint, UniversalJoint):
            # The first axis is fixed to the parent, which is ODE's second body.
            joint.SetAxis2(self.axes[0].direction)
            joint.SetAxis1(self.axes[1].direction)
        elif isinstance(joint, FixedJoint):
            joint.SetFixed()

    def _set_limits(self) -> None:
        """Stops and friction; friction is a motor that wants to stand still."""
        if isinstance(self.joint, BallJoint | FixedJoint):
            return
        parameters = ((dParamLoStop, dParamHiStop, dParamFMax), (dParamLoStop2, dParamHiStop2, dParamFMax2))
        ordered = reversed(self.axes) if isinstance(self.joint, UniversalJoint) else self.axes
        for axis, (low, high, force) in zip(ordered, parameters, strict=False):
            for parameter, value in ((high, axis.upper), (low, axis.lower), (high, axis.upper)):
                if abs(value) < UNLIMITED:
                    self.joint.SetParam(parameter, value)
            if axis.friction > 0.0:
                self.joint.SetParam(force, axis.friction)
        if self.axes and self.axes[0].friction > 0.0:
            self.joint.SetParam(dParamVel, 0.0)

    # Motion ------------------------------------------------------------------------------------------------------

    def position(self, index: int = 0) -> float:
        """Angle [rad] or position [m] of an axis."""
        joint = self.joint
        if isinstance(joint, HingeJoint):
            return joint.GetAngle()
        if isinstance(joint, SliderJoint):
            return joint.GetPosition()
        if isinstance(joint, Hinge2Joint):
            return (joint.GetAngle1, joint.GetAngle2)[index]()
        if isinstance(joint, UniversalJoint):
            return (joint.GetAngle2, joint.GetAngle1)[index]()
        return math.nan

    def velocity(self, index: int = 0) -> float:
        """Rate of an axis [rad/s] or [m/s]."""
        joint = self.joint
        if isinstance(joint, HingeJoint):
            return joint.GetAngleRate()
        if isinstance(joint, SliderJoint):
            return joint.GetPositionRate()
        if isinstance(joint, Hinge2Joint):
            return (joint.GetAngle1Rate, joint.GetAngle2Rate)[index]()
        if isinstance(joint, UniversalJoint):
            return (joint.GetAngleRate2, joint.GetAngleRate1)[index]()
        return math.nan

    def add_force(self, effort: float, index: int = 0) -> None:
        """Push along an axis for one step [N m] or [N]."""
        joint = self.joint
        if isinstance(joint, HingeJoint):
            joint.SetTorque(effort)
        elif isinstance(joint, SliderJoint):
            joint.SetSliderForce(effort)
        elif isinstance(joint, Hinge2Joint | UniversalJoint):
            first = (index == 0) == isinstance(joint, Hinge2Joint)
            joint.SetTorque(*((effort, 0.0) if first else (0.0, effort)))

    @property
    def acts(self) -> bool:
        """Whether `update` has anything to do."""
        return any(axis.acts for axis in self.axes)

    def update(self) -> None:
        """Damping and springs, for one step: -damping velocity + stiffness (reference - position)."""
        for index, axis in enumerate(self.axes):
            if axis.acts:
                push = axis.stiffness * (axis.reference - self.position(index)) - axis.damping * self.velocity(index)
                self.add_force(push, index)

    def close(self) -> None:
        """Destroy the joint."""
        self.joint.close()
