"""Bodies that overlap are set apart, in Python: the same work as set_apart in step.c."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterable, Sequence

from libgz.ode.context import StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.tables import Tables
from libgz.ode.types import Mass

__all__ = ["Overlap", "set_apart"]

# Explained in step.c.
_ROUNDS, _YIELDING, _SPARED = 10, 0.25, 2.0


class Overlap:
    """A contact point that may not push its bodies apart as fast as it should.

    Args:
        body1, body2: handles; 0 for the world.
        normal: into body1.
        depth: by which they are set apart [m].
        softness: of their springs [m/N].
    """

    __slots__ = ("body1", "body2", "depth", "normal", "share", "softness")

    def __init__(self, body1: int, body2: int, normal: Sequence[float], depth: float, softness: float) -> None:
        self.body1, self.body2, self.normal, self.depth, self.softness = body1, body2, normal, depth, softness
        self.share = 0.0


class _Group:
    """Bodies that joints connect; they are moved together."""

    __slots__ = ("mass", "root", "shift")

    def __init__(self) -> None:
        self.root = self
        self.mass = 0.0
        self.shift = [0.0, 0.0, 0.0]

    def find(self) -> _Group:
        """The one that stands for all."""
        found = self
        while found.root is not found:
            found = found.root
        return found

    def reach(self, normal: Sequence[float]) -> float:
        """How far it is moved along a normal [m]."""
        return normal[0] * self.shift[0] + normal[1] * self.shift[1] + normal[2] * self.shift[2]

    def move(self, normal: Sequence[float], distance: float) -> None:
        for k in range(3):
            self.shift[k] += normal[k] * distance


def set_apart(context: StepContext, tables: Tables, overlaps: Iterable[Overlap], held: set[int]) -> None:
    """Move bodies that overlap, and all that joints connect them with.

    Args:
        context: of the step.
        tables: of bodies and joints.
        overlaps: of this step.
        held: handles of bodies that a joint connects with the world.
    """
    ode_ = ode()
    groups = _groups(ode_, context, tables, held)
    x, y, z = context.gravity
    for overlap in overlaps:
        masses = [group.mass for group in _both(groups, overlap) if group is not None]
        spared = _SPARED * overlap.softness * min(masses, default=0.0) * math.sqrt(x * x + y * y + z * z)
        overlap.depth = max(0.0, overlap.depth - spared)
    for _ in range(_ROUNDS):
        for overlap in overlaps:
            _balance(overlap, *_both(groups, overlap))
    for body in groups:
        group = _movable(groups, body)
        if group is None or not group.reach(group.shift) > 0.0:
            continue
        p = ode_.dBodyGetPosition(body).contents
        ode_.dBodySetPosition(body, *(p[k] + group.shift[k] for k in range(3)))


def _groups(ode_: OdeLibrary, context: StepContext, tables: Tables, held: set[int]) -> dict[int, _Group]:
    """find_groups in step.c."""
    groups = {body: _Group() for body in tables.bodies.ids[: context.body_count].tolist() if body}
    for joint in tables.joints.ids[: context.joint_count].tolist():
        one, two = (groups.get(ode_.dJointGetBody(joint, k) or 0) for k in (0, 1)) if joint else (None, None)
        if one is not None and two is not None:
            two.find().root = one.find()
    mass = Mass()
    for body, group in groups.items():
        ode_.dBodyGetMass(body, ctypes.addressof(mass))
        group.find().mass += mass.mass
    for body, group in groups.items():
        if body in held or ode_.dBodyIsKinematic(body):
            group.find().mass = 0.0
    return groups


def _movable(groups: dict[int, _Group], body: int) -> _Group | None:
    """group_of in step.c."""
    group = groups[body].find() if body else None
    return group if group is not None and group.mass > 0.0 else None


def _both(groups: dict[int, _Group], overlap: Overlap) -> tuple[_Group | None, _Group | None]:
    return _movable(groups, overlap.body1), _movable(groups, overlap.body2)


def _balance(overlap: Overlap, one: _Group | None, two: _Group | None) -> None:
    """balance in step.c."""
    if one is two:
        return
    lightness = (1.0 / one.mass if one is not None else 0.0) + (1.0 / two.mass if two is not None else 0.0)
    missing = overlap.depth
    if one is not None:
        missing -= one.reach(overlap.normal)
    if two is not None:
        missing += two.reach(overlap.normal)
    share = max(0.0, overlap.share + (missing / lightness - _YIELDING * overlap.share) / (1.0 + _YIELDING))
    if one is not None:
        one.move(overlap.normal, (share - overlap.share) / one.mass)
    if two is not None:
        two.move(overlap.normal, -(share - overlap.share) / two.mass)
    overlap.share = share
