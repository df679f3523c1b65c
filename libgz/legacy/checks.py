"""Warnings about the models of a worldfile, once they are built: overlaps, and contacts that do not come to rest."""

from __future__ import annotations

import bisect
import itertools
import math
from collections.abc import Iterable
from typing import NamedTuple

from libgz.base.geometry import rotate
from libgz.legacy.model import Model
from libgz.ode.lib import ode
from libgz.ode.types import JointType, Surface
from libgz.physics.body import Body
from libgz.physics.geom import Geom
from libgz.physics.geoms import CylinderGeom
from libgz.worldfile.node import WorldFileNode

__all__ = ["Part", "may_touch", "parts_of", "warn_of_contacts", "warn_of_overlaps"]

TOUCH = 1e-6  # [m]; shapes that only touch do not jam each other
SPRINGS = 4  # contact points that carry a solid
SINKING = 0.1  # share of its height
QUIET_STEP = 5e-4  # [s]: with it all tilted cylinders that were tried came to rest, at the usual kp
UPRIGHT = 4.5e-4  # [rad]: within it ODE gives a standing cylinder several contact points
STACK = 4  # solids; three hold
GAP = 0.005  # [m] between solids of a stack as it is loaded


class Part(NamedTuple):
    """A geom that can touch others, with its model and the box around it."""

    model: Model
    geom: Geom
    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @property
    def body(self) -> int:
        """ODE's handle of its body; 0 for the world."""
        return 0 if self.geom.body.dummy else self.geom.body.id

    def name(self) -> str:
        """What messages call it."""
        model = self.model
        return f"the {type(self.geom).__name__} of body {self.geom.body.bodyName or 'unnamed'!r} of {model.GetId()!r}"


def warn_of_overlaps(models: Iterable[Model]) -> set[frozenset[Model]]:
    """Warn of models that are attached to one another and overlap, each pair of models once, with the deepest geoms.

    Geoms of bodies that a joint connects, such as those of a model and of the body that it is attached to, never touch.

    Returns:
        These pairs.
    """
    pairs: set[frozenset[Model]] = set()
    for top in models:
        if top.parent is None and top.children:
            pairs |= _warn_of_family([model for model in top.with_attached() if isinstance(model, Model)])
    return pairs


def _warn_of_family(family: list[Model]) -> set[frozenset[Model]]:
    found: dict[tuple[Model, Model], tuple[float, Part, Part]] = {}
    parts = {model: parts_of(model) for model in family}
    for one, two in itertools.combinations(family, 2):
        for a, b in itertools.product(parts[one], parts[two]):
            depth = _overlap(a, b)
            if depth > TOUCH and depth > found.get((one, two), (0.0,))[0]:
                found[one, two] = depth, a, b
    for (one, two), (depth, a, b) in found.items():
        if two.node is None:
            continue
        where = f" (line {one.node.line})" if one.node is not None else ""
        two.node.warn(
            f"{b.name()} overlaps {a.name()}{where} by {depth:.2g} m: attached models collide, and jam each other; "
            "move one of them"
        )
    return {frozenset(pair) for pair in found}


def parts_of(model: Model) -> list[Part]:
    """The geoms of a model that can touch others."""
    geoms = (geom for body in model.bodies for geom in body.geoms if geom.id and geom.space is not None)
    return [Part(model, geom, *geom.bounds()) for geom in geoms]


def _overlap(a: Part, b: Part) -> float:
    """How deep two geoms are inside each other, if contacts are made of them [m]."""
    if any(a.low[k] > b.high[k] or b.low[k] > a.high[k] for k in range(3)) or not may_touch(a, b):
        return 0.0
    return a.geom.body.engine.overlap(a.geom.id, b.geom.id)


def may_touch(a: Part, b: Part) -> bool:
    """Whether contacts are made of two geoms where they touch."""
    if not (a.body or b.body) or not _may_collide(a.geom, b.geom):
        return False
    return not (a.body and b.body and ode().dAreConnectedExcluding(a.body, b.body, JointType.CONTACT))


def _may_collide(a: Geom, b: Geom) -> bool:
    """Whether the categories of two geoms, and of their spaces, let them collide."""
    pairs = [(a.id, b.id)]
    if a.space is not None and b.space is not None:
        if a.space is b.space:
            return False
        pairs.append((a.space.id, b.space.id))
    category, collide = ode().dGeomGetCategoryBits, ode().dGeomGetCollideBits
    return all(category(one) & collide(two) or category(two) & collide(one) for one, two in pairs)


def warn_of_contacts(models: Iterable[Model]) -> None:
    """Warn of solids whose contacts cannot come to rest with their springs, the step time and the solver.

    The rule of contacts is the old server's; docs/contacts.md has values that hold.
    """
    solids = [solid for solid in map(_solid, models) if solid is not None]
    for solid in solids:
        _warn_of_sinking(solid)
        _warn_of_wobbling(solid)
    _warn_of_stacks(solids)


class _Solid(NamedTuple):
    """A model of one body that nothing but contacts holds."""

    node: WorldFileNode
    model: Model
    body: Body
    geoms: list[Geom]
    low: tuple[float, ...]
    high: tuple[float, ...]


def _solid(model: Model) -> _Solid | None:
    if model.parent is not None or model.node is None or len(model.bodies) != 1:
        return None
    body = model.GetBody()
    geoms = [geom for geom in body.geoms if geom.id and geom.space is not None]
    if body.dummy or body.joints or not geoms or not body.GetGravityMode() or body.engine.gravity[2] >= 0.0:
        return None
    corners = [geom.bounds() for geom in geoms]
    low = tuple(min(corner[0][k] for corner in corners) for k in range(3))
    high = tuple(max(corner[1][k] for corner in corners) for k in range(3))
    return _Solid(model.node, model, body, geoms, low, high)


def _warn_of_sinking(solid: _Solid) -> None:
    """A body rests where its springs carry its weight, about four of them."""
    spring = max(geom.surface(Surface.KP) for geom in solid.geoms)
    depth = solid.body.mass * -solid.body.engine.gravity[2] / (SPRINGS * spring)
    height = solid.high[2] - solid.low[2]
    if depth > SINKING * height:
        enough = spring * depth / (0.01 * height)
        solid.node.warn(
            f"sinks about {depth:.2g} m into the ground: contacts of kp {spring:g} N/m cannot carry its "
            f"{solid.body.mass:g} kg; its kp should be above {enough:.1g} N/m (docs/contacts.md)"
        )


def _warn_of_wobbling(solid: _Solid) -> None:
    """ODE gives a tilted cylinder one contact point, on its rim, until it stands upright to 4.5e-4 rad.

    A step that turns it by more than that makes it rock from one side of the rim to the other for ever.
    """
    cylinder = solid.geoms[0]
    if len(solid.geoms) != 1 or not isinstance(cylinder, CylinderGeom):
        return
    tilt = math.acos(min(1.0, abs(rotate(cylinder.GetPose().rot, (0.0, 0.0, 1.0)).z)))
    if not UPRIGHT < tilt < math.atan2(2.0 * cylinder.radius, cylinder.length):
        return
    if solid.body.engine.step_time > QUIET_STEP:
        solid.node.warn(
            f"is a tilted cylinder, which can wobble on its rim without end at a stepTime of "
            f"{solid.body.engine.step_time:g} s; set it down upright (docs/contacts.md)"
        )


def _warn_of_stacks(solids: list[_Solid]) -> None:
    """ODE's exact solver fails on the many contact points of a stack; the bodies are thrown about then."""
    if not solids or solids[0].body.engine.solver == "quick":
        return
    for stack in _stacks(solids):
        names = ", ".join(repr(solid.model.GetId()) for solid in stack[:3])
        stack[-1].node.warn(
            f"is the top of a stack of {len(stack)} solids ({names}{', ...' if len(stack) > 3 else ''}), which the "
            "exact solver does not hold: it falls, or flies apart; use the quick solver (gazebo --solver quick, "
            'World(solver="quick")) and a damper kd (docs/contacts.md)'
        )


def _stacks(solids: list[_Solid]) -> list[list[_Solid]]:
    """The stacks of at least STACK solids, each from the bottom to a top that carries nothing."""
    order = sorted(range(len(solids)), key=lambda i: solids[i].low[2])
    by_top = sorted(range(len(solids)), key=lambda i: solids[i].high[2])
    tops = [solids[i].high[2] for i in by_top]
    below: dict[int, list[int]] = {}  # the longest stack that ends with a solid
    carrying: set[int] = set()
    for i in order:
        a = solids[i]
        near = by_top[bisect.bisect_left(tops, a.low[2] - GAP) : bisect.bisect_right(tops, a.low[2] + GAP)]
        under = [j for j in near if j in below and _stands_on(a, solids[j])]
        carrying.update(under)
        below[i] = [*max((below[j] for j in under), key=len, default=[]), i]
    return [
        [solids[j] for j in stack] for i, stack in sorted(below.items()) if i not in carrying and len(stack) >= STACK
    ]


def _stands_on(a: _Solid, b: _Solid) -> bool:
    return all(a.low[k] < b.high[k] and b.low[k] < a.high[k] for k in (0, 1))
