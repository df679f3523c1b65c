"""The links on one side of a joint, moved as one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from libgz.base.geometry import (
    GzPose,
    GzQuaternFromAxis,
    GzQuaternMul,
    GzVector,
    GzVectorAdd,
    GzVectorCross,
    GzVectorMag,
    GzVectorSub,
    rotate,
)
from libgz.physics.couplings import LineJoint, TieJoint

if TYPE_CHECKING:
    from libgz.physics.body import Body

__all__ = ["accelerate_links", "links_behind", "move_links", "slide_child", "turn_child"]


def links_behind(child: Body | None, parent: Body | None) -> list[Body]:
    """A joint's child and all that is joined to it; the child alone where that leads back to the parent."""
    if child is None or child.dummy:
        return []
    found: dict[Body, None] = {child: None}
    waiting = [child]
    while waiting:
        body = waiting.pop()
        for joint in body.joints:
            if isinstance(joint, LineJoint | TieJoint):
                continue
            for other in joint.bodies:
                if other is None or other.dummy or other in found or (body is child and other is parent):
                    continue
                if other is parent:
                    return [child]
                found[other] = None
                waiting.append(other)
    return list(found)


def move_links(links: Sequence[Body], anchor: GzVector, turn: GzVector, slide: GzVector, keep_velocities: bool) -> None:
    """Turn links about an anchor [m] by a rotation vector [rad], slide them [m], and stop them if asked to."""
    rotation = GzQuaternFromAxis(turn.x, turn.y, turn.z, GzVectorMag(turn))
    moved = links[0].engine.turn_bodies(links, anchor, rotation, slide, not keep_velocities) if links else 0
    for link in links[moved:]:
        pose = link.GetPose()
        arm = rotate(rotation, GzVectorSub(pose.pos, anchor))
        link.SetPose(GzPose(GzVectorAdd(GzVectorAdd(anchor, arm), slide), GzQuaternMul(rotation, pose.rot)))
        if not keep_velocities:
            link.SetLinearVel(GzVector())
            link.SetAngularVel(GzVector())


def accelerate_links(links: Iterable[Body], anchor: GzVector, turn: GzVector, slide: GzVector) -> None:
    """Add a rigid motion to the velocities of links: about an anchor [m] by a rate [rad/s], and along [m/s]."""
    for link in links:
        arm = GzVectorSub(link.GetCoMPose().pos, anchor)
        change = GzVectorAdd(GzVectorCross(turn, arm), slide)
        link.SetLinearVel(GzVectorAdd(link.GetLinearVel(), change))
        link.SetAngularVel(GzVectorAdd(link.GetAngularRate(), turn))


def turn_child(child: Body, parent: Body | None, frame: GzVector, parent_frame: GzVector, rate: GzVector) -> None:
    """Let a joint's child turn about it, with what its parent does.

    Args:
        child: it.
        parent: None is at rest.
        frame: global place of the joint on the child [m].
        parent_frame: global place of the joint on the parent [m].
        rate: against the parent [rad/s], global.
    """
    velocity = GzVector()
    if parent is not None:
        arm = GzVectorSub(parent_frame, parent.GetCoMPose().pos)
        velocity = GzVectorAdd(parent.GetLinearVel(), GzVectorCross(parent.GetAngularRate(), arm))
        rate = GzVectorAdd(parent.GetAngularRate(), rate)
    arm = GzVectorSub(child.GetCoMPose().pos, frame)
    child.SetAngularVel(rate)
    child.SetLinearVel(GzVectorAdd(velocity, GzVectorCross(rate, arm)))


def slide_child(child: Body, parent: Body | None, velocity: GzVector) -> None:
    """Let a joint's child slide [m/s], global, as fast as its parent and so much more; Gazebo leaves how it turns."""
    if parent is not None:
        arm = GzVectorSub(parent.GetPose().pos, parent.GetCoMPose().pos)
        moving = GzVectorAdd(parent.GetLinearVel(), GzVectorCross(parent.GetAngularRate(), arm))
        velocity = GzVectorAdd(moving, velocity)
    child.SetLinearVel(velocity)
