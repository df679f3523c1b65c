"""Joints as SDF joints: a child, a parent, and axes in the child's own frame."""

from __future__ import annotations

import math
from collections.abc import Callable

from lxml import etree

from libgz.base.geometry import GzCoordPositionSub, GzPose, GzQuaternInverse, GzVector, rotate
from libgz.convert.element import Notes, add, pose
from libgz.ode.types import (
    dParamFMax,
    dParamFMax2,
    dParamHiStop,
    dParamHiStop2,
    dParamLoStop,
    dParamLoStop2,
)
from libgz.physics.body import Body
from libgz.physics.joint import BallJoint, FixedJoint, HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import Hinge2Joint, UniversalJoint

__all__ = ["add_joint", "ends_of"]

NO_LIMIT = 1e16  # SDF's own number for no limit


def ends_of(joint: Joint) -> tuple[Body | None, Body | None]:
    """(child, parent); None for the world. Legacy models attach the moving body first, a wheel of a Hinge2 second."""
    first, second = (None if body is None or body.dummy else body for body in joint.bodies)
    if isinstance(joint, Hinge2Joint) or first is None:
        return second, first
    return first, second


def add_joint(
    model: etree._Element,
    joint: Joint,
    name: str,
    link_names: Callable[[Body | None], str],
    owner: str,
    notes: Notes,
) -> None:
    """Add one joint to a model.

    Args:
        model: the SDF model.
        joint: a joint between bodies that are links, or from one to the world.
        name: its name.
        link_names: name of a body's link; of None, the world.
        owner: name of the model in notes.
        notes: receives what has no counterpart.
    """
    child, parent = ends_of(joint)
    if child is None:
        return  # it connects no bodies
    kind, axes = _kind_and_axes(joint, child)
    if kind is None:
        notes.add(owner, f"joint {name} is a {type(joint).__name__}, which has no counterpart")
        return
    element = add(model, "joint", name=name, type=kind)
    add(element, "parent", link_names(parent))
    add(element, "child", link_names(child))
    place = child.GetPose()
    anchor = place.pos if isinstance(joint, SliderJoint | FixedJoint) or kind == "fixed" else joint.GetAnchor()
    add(element, "pose", pose(GzPose(GzCoordPositionSub(anchor, place.pos, place.rot))))
    # SDF measures the motion of the child; ODE's sign is opposite where the child is the second body.
    sign = 1.0 if joint.bodies[0] is child else -1.0
    for tag, (direction, value, low, high, effort) in zip(("axis", "axis2"), axes, strict=False):
        axis = add(element, tag)
        add(axis, "xyz", [round(sign * v, 12) for v in rotate(GzQuaternInverse(place.rot), direction)])
        limit = add(axis, "limit")
        add(limit, "lower", low - value if math.isfinite(low) else -NO_LIMIT)
        add(limit, "upper", high - value if math.isfinite(high) else NO_LIMIT)
        if effort > 0.0:
            add(limit, "effort", effort)
    if isinstance(joint, Hinge2Joint):
        notes.add(owner, f"joint {name} becomes a universal joint: gz-sim has no suspension as in Hinge2")


Axis = tuple[GzVector, float, float, float, float]  # global direction, present value, stops, largest force


def _kind_and_axes(joint: Joint, child: Body) -> tuple[str | None, list[Axis]]:
    """SDF's joint type and its axes: the first on the parent, the second on the child; None without a counterpart."""
    if isinstance(joint, HingeJoint | SliderJoint):
        low, high, effort = joint.GetParam(dParamLoStop), joint.GetParam(dParamHiStop), joint.GetParam(dParamFMax)
        if low == high:  # such as the joints of attached models
            return "fixed", []
        if isinstance(joint, HingeJoint):
            return "revolute", [(joint.GetAxis(), joint.GetAngle(), low, high, effort)]
        return "prismatic", [(joint.GetAxis(), joint.GetPosition(), low, high, effort)]
    if isinstance(joint, Hinge2Joint | UniversalJoint):
        one, two = joint.GetAxis1(), joint.GetAxis2()
        stops = [
            (joint.GetParam(low), joint.GetParam(high), joint.GetParam(force))
            for low, high, force in (
                (dParamLoStop, dParamHiStop, dParamFMax),
                (dParamLoStop2, dParamHiStop2, dParamFMax2),
            )
        ]
        if not isinstance(joint, UniversalJoint):  # a Hinge2 of ODE has no stops on its second axis
            stops[1] = (-math.inf, math.inf, stops[1][2])
        axes: list[Axis] = [(one, joint.GetAngle1(), *stops[0]), (two, joint.GetAngle2(), *stops[1])]
        return "universal", axes if joint.bodies[1] is child else axes[::-1]
    if isinstance(joint, BallJoint):
        return "ball", []
    return ("fixed", []) if isinstance(joint, FixedJoint) else (None, [])
