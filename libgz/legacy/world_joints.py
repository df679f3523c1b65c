"""World joints: joints that attach a model's bodies to the world; like the model, they are built around the origin."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from libgz.base.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzVector, rotate
from libgz.physics.joint import BallJoint, FixedJoint, HingeJoint, Joint, SliderJoint
from libgz.physics.two_axes import UniversalJoint

if TYPE_CHECKING:
    from libgz.legacy.model import Model

__all__ = ["move_with_world_joints"]


def move_with_world_joints(model: Model, place: Callable[[], None]) -> None:
    """Move a model that was built to its place by calling `place`, and its world joints with it.

    ODE keeps such a joint's anchor in the world, and would pull the model back to it.
    """
    before = model.GetPose()
    held = [joint for joint in model.joints if any(body is None or body.dummy for body in joint.bodies)]
    moves = [move for move in (_move_of(joint) for joint in held) if move is not None]
    place()
    motion = GzCoordPoseSub(GzPose(), before)
    after = model.GetPose()

    def point(p: GzVector) -> GzVector:
        return GzCoordPoseAdd(GzCoordPoseAdd(GzPose(p), motion), after).pos

    def direction(d: GzVector) -> GzVector:
        return rotate(after.rot, rotate(motion.rot, d))

    for move in moves:
        move(point, direction)


_Turn = Callable[[GzVector], GzVector]


def _move_of(joint: Joint) -> Callable[[_Turn, _Turn], None] | None:
    """A function that moves a joint, given how points and directions move; None if the joint has no place."""
    if isinstance(joint, HingeJoint):
        hinge, anchor, axis = joint, joint.GetAnchor(), joint.GetAxis()

        def move_hinge(point: _Turn, direction: _Turn) -> None:
            hinge.SetAnchor(point(anchor))
            hinge.SetAxis(direction(axis))

        return move_hinge
    if isinstance(joint, UniversalJoint):
        universal, centre, first, second = joint, joint.GetAnchor(), joint.GetAxis1(), joint.GetAxis2()

        def move_universal(point: _Turn, direction: _Turn) -> None:
            universal.SetAnchor(point(centre))
            universal.SetAxis1(direction(first))
            universal.SetAxis2(direction(second))

        return move_universal
    if isinstance(joint, SliderJoint):
        slider, way = joint, joint.GetAxis()
        return lambda point, direction: slider.SetAxis(*direction(way))
    if isinstance(joint, BallJoint):
        ball, socket = joint, joint.GetAnchor()
        return lambda point, direction: ball.SetAnchor(point(socket))
    if isinstance(joint, FixedJoint):
        fixed = joint
        return lambda point, direction: fixed.SetFixed()
    return None
