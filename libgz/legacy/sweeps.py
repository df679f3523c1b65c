"""Warnings about attached models that overlap when a joint moves, such as a camera that pans into its neighbour."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Collection, Iterable, Iterator

from libgz.base.geometry import GzPose, GzQuatern, GzQuaternFromAxis, GzQuaternMul, GzVector, rotate
from libgz.legacy.checks import Part, may_touch, parts_of
from libgz.legacy.model import Model
from libgz.ode.lib import ode
from libgz.ode.types import dParamHiStop, dParamLoStop
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CapsuleGeom, CylinderGeom, SphereGeom
from libgz.physics.joint import HingeJoint, Joint, SliderJoint

__all__ = ["warn_of_sweeps"]

TOUCH = 1e-4  # [m]; less is no overlap
SHORTEST = 1e-6  # [rad or m]; a joint with less range does not move
GAP = 0.01  # [m] between a model and what it stands on
POSITIONS = 24  # of a joint that are tried, to each side of where it is


def warn_of_sweeps(models: Iterable[Model], known: Collection[frozenset[Model]]) -> None:
    """Warn of attached models that overlap when one of their joints moves between its stops, the others at rest.

    Each joint and pair of models is warned of once, with the position that is nearest. What a model is attached to or
    stands on is no neighbour of it. Nothing in the world moves: copies of geoms do.

    Args:
        models: of the world, or those that were added.
        known: pairs of models that overlap at rest.
    """
    for top in models:
        if top.parent is None and top.children:
            family = [model for model in top.with_attached() if isinstance(model, Model)]
            parts = {model: parts_of(model) for model in family}
            for model in family:
                for joint in model.joints:
                    if isinstance(joint, HingeJoint | SliderJoint):
                        _warn_of_joint(model, joint, parts, known)


def _warn_of_joint(
    model: Model,
    joint: HingeJoint | SliderJoint,
    parts: dict[Model, list[Part]],
    known: Collection[frozenset[Model]],
) -> None:
    positions = _positions(joint)
    if not positions:
        return
    moving, sign = _moved(joint, list(parts))
    near: dict[tuple[Model, Model], tuple[float, Part, Part]] = {}
    for own in parts:
        mine = [a for a in parts[own] if a.geom.body in moving]
        others = [
            b
            for other in (parts if mine else ())
            if other is not own and {own, other} not in known and not _carries(other, own, parts)
            for b in parts[other]
            if b.geom.body not in moving
        ]
        for a in mine:
            if others:
                for position, b in _hits(joint, [sign * p for p in positions], a, others):
                    if abs(position) < abs(near.get((own, b.model), (math.inf,))[0]):
                        near[own, b.model] = sign * position, a, b
    for (_, other), (position, a, b) in near.items():
        if model.node is None:
            continue
        where = f" (line {other.node.line})" if other.node is not None else ""
        by = (
            f"turns by {math.degrees(position):.0f} degrees"
            if isinstance(joint, HingeJoint)
            else f"moves {position:.2g} m"
        )
        name = f"its joint {joint.name!r}" if joint.name else "one of its joints"
        model.node.warn(
            f"when {name} {by}, {a.name()} overlaps {b.name()}{where}: attached models collide, so that it "
            "cannot move farther; move one of them"
        )


def _carries(other: Model, own: Model, parts: dict[Model, list[Part]]) -> bool:
    """Whether a model is attached to another, or stands on it: its head cannot be meant to pass through that."""
    parent = own.parent
    while parent is not None:
        if parent is other:
            return True
        parent = parent.parent
    return any(
        abs(a.low[2] - b.high[2]) < GAP and all(a.low[k] < b.high[k] and b.low[k] < a.high[k] for k in (0, 1))
        for a in parts[own]
        for b in parts[other]
    )


def _positions(joint: HingeJoint | SliderJoint) -> list[float]:
    """Where to try a joint, relative to where it is, nearest first [rad or m]; empty if its range is not known."""
    now = joint.GetAngle() if isinstance(joint, HingeJoint) else joint.GetPosition()
    low, high = joint.GetParam(dParamLoStop), joint.GetParam(dParamHiStop)
    if isinstance(joint, HingeJoint) and joint.commanded is not None:
        low, high = max(low, joint.commanded[0]), min(high, joint.commanded[1])
    if not (math.isfinite(low) and math.isfinite(high)):
        return []
    return [
        (limit - now) * k / POSITIONS
        for k in range(1, POSITIONS + 1)
        for limit in (low, high)
        if abs(limit - now) > 1e-6
    ]


def _moved(joint: Joint, family: list[Model]) -> tuple[set[Body], int]:
    """(bodies that a joint moves, 1 or -1: along or against its axis); no bodies if it is in a loop.

    They are those on its side away from the top of the family.
    """
    one, two = joint.bodies
    for start, other, sign in ((one, two, 1), (two, one, -1)):
        if start is None or start.dummy:
            continue
        found, waiting = {start}, [start]
        while waiting:
            body = waiting.pop()
            linked = [
                b for link in body.joints if link is not joint for b in link.bodies if b is not None and not b.dummy
            ]
            carried = [b for model in family if model.parentBody is body for b in model.bodies]
            new = [b for b in (*linked, *carried) if b not in found]
            found.update(new)
            waiting += new
        if other not in found and not any(body in found for body in family[0].bodies[:1]):
            return found, sign
    return set(), 1


def _hits(
    joint: HingeJoint | SliderJoint, positions: list[float], a: Part, others: list[Part]
) -> Iterator[tuple[float, Part]]:
    """(first position, part) for each part that a part reaches when its joint moves."""
    reached = _reach(joint, positions, a)
    near = [
        b for b in others if may_touch(a, b) and _distance(b, reached[0]) < reached[1] and not _touch(a.geom.id, a, b)
    ]
    copy = _copy(a.geom) if near else None
    if copy is None:
        return
    lib, place = ode(), _ode_pose(a.geom)
    try:
        for position in positions:
            pose = _displaced(joint, position, place)
            lib.dGeomSetPosition(copy, *pose.pos)
            lib.dGeomSetQuaternion(copy, (ctypes.c_double * 4)(*pose.rot))
            for b in [b for b in near if _touch(copy, a, b)]:
                near.remove(b)
                yield position, b
            if not near:
                return
    finally:
        lib.dGeomDestroy(copy)


def _touch(handle: int, a: Part, b: Part) -> bool:
    return a.geom.body.engine.overlap(handle, b.geom.id) > TOUCH


def _reach(joint: HingeJoint | SliderJoint, positions: list[float], a: Part) -> tuple[GzVector, float]:
    """(centre, radius) of a sphere around all that a part reaches [m]."""
    corners = [
        GzVector(x, y, z) for x in (a.low[0], a.high[0]) for y in (a.low[1], a.high[1]) for z in (a.low[2], a.high[2])
    ]
    if isinstance(joint, HingeJoint):
        centre, more = joint.GetAnchor(), 0.0
    else:
        centre, more = (
            GzVector(*(0.5 * (low + high) for low, high in zip(a.low, a.high, strict=True))),
            max(map(abs, positions)),
        )
    return centre, more + max(math.dist(centre, corner) for corner in corners)


def _distance(b: Part, centre: GzVector) -> float:
    """Of a point from the box around a part [m]."""
    nearest = (min(max(c, low), high) for c, low, high in zip(centre, b.low, b.high, strict=True))
    return math.dist(tuple(nearest), centre)


def _displaced(joint: HingeJoint | SliderJoint, position: float, pose: GzPose) -> GzPose:
    """A pose, moved along a joint's axis by an angle [rad] or a distance [m]."""
    axis = joint.GetAxis()
    if isinstance(joint, SliderJoint):
        return GzPose(GzVector(*(p + position * k for p, k in zip(pose.pos, axis, strict=True))), pose.rot)
    turn, anchor = GzQuaternFromAxis(axis.x, axis.y, axis.z, position), joint.GetAnchor()
    arm = rotate(turn, tuple(p - q for p, q in zip(pose.pos, anchor, strict=True)))
    return GzPose(GzVector(*(p + q for p, q in zip(anchor, arm, strict=True))), GzQuaternMul(turn, pose.rot))


def _ode_pose(geom: Geom) -> GzPose:
    """Where ODE's shape is, which may be turned against the geom."""
    lib, rotation = ode(), (ctypes.c_double * 4)()
    position = lib.dGeomGetPosition(geom.id)
    lib.dGeomGetQuaternion(geom.id, rotation)
    return GzPose(GzVector(*position.contents[:3]), GzQuatern(*rotation))


def _copy(geom: Geom) -> int | None:
    """A geom of ODE of the same shape, in no space and of no body; None for shapes that are not swept."""
    lib = ode()
    match geom:
        case BoxGeom():
            handle = lib.dCreateBox(None, *geom.size)
        case SphereGeom():
            handle = lib.dCreateSphere(None, geom.radius)
        case CylinderGeom():
            handle = lib.dCreateCylinder(None, geom.radius, geom.length)
        case CapsuleGeom():
            handle = lib.dCreateCapsule(None, geom.radius, geom.length)
        case _:
            return None
    lib.dGeomSetData(handle, geom.row)
    return int(handle)
