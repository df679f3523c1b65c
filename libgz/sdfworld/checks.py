"""Warnings about contacts of SDF models that cannot carry what rests on them, with the values that would."""

from __future__ import annotations

import bisect
import math
from collections.abc import Iterable

from libgz.base.errors import Diagnostics
from libgz.ode.types import Surface
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.geoms import CylinderGeom, SphereGeom
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.standing import Solid, family_geoms, solids

__all__ = ["warn_of_contacts"]

GAP = 0.005  # [m] between solids of a stack as it is loaded
RATIO = 20.0  # of the mass of a solid to that of the one below it, which 50 iterations carry
EXACT = 80  # solids of a stack that are solved exactly at rest
STILL = 12  # likewise, that iterations hold still enough
DEEP = 0.1  # of the height of a model, to which a spring lets it sink without a warning
FIRM = 0.01  # likewise, with what is advised
ITERATIONS = 300  # that hold taller stacks still to 1 mm/s; for those of n solids n^2, if that is more


def warn_of_contacts(models: Iterable[SdfModel], diagnostics: Diagnostics) -> None:
    """Warn of models that sink into what they rest on, and of stacks that the quick solver does not hold."""
    moving = [model for model in models if not model.static and model.parent is None]
    moving = [model for model in moving if model.world.engine.gravity[2] < 0.0]
    for model in moving:
        _warn_of_sinking(model, model.world.engine, diagnostics)
    if moving and moving[0].world.engine.solver == "quick":
        _warn_of_stacks(list(solids(moving)), diagnostics)


def _points(geom: Geom) -> int:
    """How many contact points a geom has on the ground, about."""
    return 1 if isinstance(geom, SphereGeom) else 2 if isinstance(geom, CylinderGeom) else 4


def _warn_of_sinking(model: SdfModel, engine: Engine, diagnostics: Diagnostics) -> None:
    """A spring carries kp times its depth."""
    bodies = [body for member in model.nested_family() for body in member.bodies if not body.dummy]
    anchored = any(None in joint.bodies for body in bodies for joint in body.joints)
    geoms = list(family_geoms(model))
    weight = -engine.gravity[2] * sum(body.mass for body in bodies if body.GetGravityMode())
    if anchored or not geoms or weight <= 0.0 or any(body.kinematic for body in bodies):
        return
    best = max(geoms, key=lambda geom: _points(geom) * geom.surface(Surface.KP))
    kp, share = best.surface(Surface.KP), weight / (_points(best) * len(geoms))
    bounds = [geom.bounds() for geom in geoms]
    height = max(high[2] for _, high in bounds) - min(low[2] for low, _ in bounds)
    depth = share / kp if kp > 0.0 else math.inf
    soft = best.surface(Surface.MAX_VEL) > 0.0  # without velocity, contacts are hard
    if soft and height > 0.0 and depth > DEEP * height:
        firm = _round_up(share / (FIRM * height))
        diagnostics.warn(
            model.sdf,
            f"model {model.GetId()!r} sinks into what it rests on: contacts with <kp> {kp:g} carry its {weight:.3g} N "
            f"at a depth of {depth:.2g} m; <kp> {firm:g} would carry it (docs/contacts.md)",
        )


def _round_up(value: float) -> float:
    """With one digit."""
    unit = 10.0 ** math.floor(math.log10(value)) if value > 0.0 else 1.0
    return math.ceil(value / unit) * unit


def _warn_of_stacks(found: list[Solid], diagnostics: Diagnostics) -> None:
    if not found:
        return
    engine = found[0].engine
    order = sorted(found, key=lambda solid: solid.low[2])
    by_top = sorted(found, key=lambda solid: solid.high[2])
    tops = [solid.high[2] for solid in by_top]
    height: dict[int, int] = {}  # of the tallest stack that ends with a solid
    carrying: set[int] = set()
    carried, still = (EXACT, EXACT) if engine.exact_rest else (0, STILL)
    for solid in order:
        near = by_top[bisect.bisect_left(tops, solid.low[2] - GAP) : bisect.bisect_right(tops, solid.low[2] + GAP)]
        under = [b for b in near if id(b) in height and solid.is_above(b)]
        carrying.update(map(id, under))
        height[id(solid)] = 1 + max((height[id(b)] for b in under), default=0)
        light = min((b.mass for b in under), default=math.inf)
        if solid.mass > RATIO * light and height[id(solid)] > carried and engine.iterations < solid.mass / light:
            remedy = "<solver><type>world</type>" + ("" if engine.exact_rest else " or <exact_rest>true</exact_rest>")
            diagnostics.warn(
                solid.model.sdf,
                f"model {solid.model.GetId()!r} of {solid.mass:g} kg stands on one of {light:g} kg and sinks into it: "
                f"{engine.iterations} iterations cannot carry it; {remedy} would (docs/contacts.md)",
            )
    for solid in order:
        needed = max(ITERATIONS, height[id(solid)] ** 2)
        remedy = f"<solver><iters> {needed}" if engine.exact_rest else "<exact_rest>true</exact_rest>"
        if id(solid) not in carrying and height[id(solid)] > still and engine.iterations < needed:
            diagnostics.warn(
                solid.model.sdf,
                f"model {solid.model.GetId()!r} is the top of a stack of {height[id(solid)]} solids, which "
                f"{engine.iterations} iterations do not hold still; {remedy} would (docs/contacts.md)",
            )
