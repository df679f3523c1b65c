"""Solids that stand on each other as they are loaded, and those that rounding keeps a hair above what they stand on."""

from __future__ import annotations

import bisect
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from libgz.base.geometry import GzPose, GzVector
from libgz.physics.engine import Engine
from libgz.physics.geom import Geom
from libgz.physics.geoms import PlaneGeom
from libgz.sdfworld.model import SdfModel

__all__ = ["Solid", "family_geoms", "set_down", "solids"]

ROUNDING = 1e-7  # [m] between solids that are meant to touch
OVERLAP = 1e-9  # [m] of solids that touch
STRAIGHT = 1.0 - 1e-12  # of the vertical component of a ground's normal


class Solid(NamedTuple):
    """A model of one body of bounded size that nothing but contacts holds."""

    model: SdfModel
    engine: Engine
    mass: float
    low: tuple[float, ...]
    high: tuple[float, ...]

    def is_above(self, other: Solid) -> bool:
        """Whether the boxes around both overlap, seen from above."""
        return all(self.low[k] < other.high[k] and other.low[k] < self.high[k] for k in (0, 1))


def family_geoms(model: SdfModel) -> Iterator[Geom]:
    """All geoms of a model, and of those nested in it, that can touch anything."""
    for member in model.nested_family():
        for body in member.bodies:
            yield from (geom for geom in body.geoms if geom.id and geom.space is not None)


def solids(models: Iterable[SdfModel]) -> Iterator[Solid]:
    """Those of the models that are solids."""
    for model in models:
        geoms = list(family_geoms(model))
        single = len(model.bodies) == 1 and not model.nested and not model.bodies[0].joints
        bounded = not any(isinstance(geom, PlaneGeom) for geom in geoms)
        if single and geoms and bounded and not model.bodies[0].dummy:
            corners = [geom.bounds() for geom in geoms]
            low = tuple(min(corner[0][k] for corner in corners) for k in range(3))
            high = tuple(max(corner[1][k] for corner in corners) for k in range(3))
            yield Solid(model, model.world.engine, model.bodies[0].mass, low, high)


def set_down(added: Iterable[SdfModel]) -> None:
    """Lower solids by less than a micrometre so that they touch what they stand on.

    Numbers like 0.3 are rounded, and a stack of such boxes has gaps of 1e-16 m. Without contacts all above a gap would
    fall for a step, by 4 mm at 20 ms, and fall apart.
    """
    moving = sorted(solids(model for model in added if not model.static and model.parent is None), key=_foot)
    if not moving or not moving[0].engine.exact_rest or moving[0].engine.gravity[2] >= 0.0:
        return
    below = [*_floors(moving), *moving]
    below.sort(key=_top)
    tops = [_top(solid) for solid in below]
    lowered: dict[int, float] = {}  # [m] by solid
    for solid in moving:
        foot = _foot(solid)
        near = below[bisect.bisect_left(tops, foot - ROUNDING) : bisect.bisect_right(tops, foot + ROUNDING)]
        under = [b for b in near if b is not solid and solid.is_above(b)]
        gap = min((foot - _top(b) + lowered.get(id(b), 0.0) for b in under), default=-1.0)
        # What stands on the ground to the bit stays, and touches it at depth 0.
        if gap > 0.0 or (gap > -OVERLAP and all(b.mass for b in under)):
            lowered[id(solid)] = down = gap + OVERLAP
            pose = solid.model.GetPose()
            x, y, z = pose.pos
            solid.model.SetPose(GzPose(GzVector(x, y, z - down), pose.rot))
            solid.model.initPose = solid.model.GetPose()


def _foot(solid: Solid) -> float:
    return solid.low[2]


def _top(solid: Solid) -> float:
    return solid.high[2]


def _floors(moving: list[Solid]) -> Iterator[Solid]:
    """What else solids may stand on, a geom each; planes only if they are level."""
    feet = [_foot(solid) for solid in moving]
    low = (*(min(solid.low[k] for solid in moving) for k in (0, 1)), min(feet) - 2.0 * ROUNDING)
    high = (*(max(solid.high[k] for solid in moving) for k in (0, 1)), max(feet) + 2.0 * ROUNDING)
    own = {id(solid.model) for solid in moving}
    for geom in moving[0].engine.geoms_near(low, high):
        model = geom.body.model
        if isinstance(model, SdfModel) and id(model) not in own:
            bottom, top = geom.bounds()
            if isinstance(geom, PlaneGeom):
                if geom.normal.z < STRAIGHT:
                    continue
                top = (*top[:2], geom.altitude)
            yield Solid(model, model.world.engine, 0.0, bottom, top)
