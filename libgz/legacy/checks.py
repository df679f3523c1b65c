"""Warnings about the models of a worldfile, once they are built: attached models that overlap each other."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

from libgz.legacy.model import Model
from libgz.ode.lib import ode
from libgz.ode.types import JointType
from libgz.physics.geom import Geom

__all__ = ["warn_of_overlaps"]

TOUCH = 1e-6  # [m]; shapes that only touch do not jam each other


@dataclass(frozen=True)
class _Part:
    """A geom that can touch others, with its model and the box around it."""

    model: Model
    geom: Geom
    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @property
    def body(self) -> int:
        return 0 if self.geom.body.dummy else self.geom.body.id

    def name(self) -> str:
        model = self.model
        return f"the {type(self.geom).__name__} of body {self.geom.body.bodyName or 'unnamed'!r} of {model.GetId()!r}"


def warn_of_overlaps(models: Iterable[Model]) -> None:
    """Warn of models that are attached to one another and overlap, each pair of models once, with the deepest geoms.

    Geoms of bodies that a joint connects, such as those of a model and of the body that it is attached to, never touch.
    """
    for top in models:
        if top.parent is None and top.children:
            _warn_of_family([model for model in top.with_attached() if isinstance(model, Model)])


def _warn_of_family(family: list[Model]) -> None:
    found: dict[tuple[Model, Model], tuple[float, _Part, _Part]] = {}
    parts = {model: _parts(model) for model in family}
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


def _parts(model: Model) -> list[_Part]:
    geoms = (geom for body in model.bodies for geom in body.geoms if geom.id and geom.space is not None)
    return [_Part(model, geom, *geom.bounds()) for geom in geoms]


def _overlap(a: _Part, b: _Part) -> float:
    """How deep two geoms are inside each other, if contacts are made of them [m]."""
    if any(a.low[k] > b.high[k] or b.low[k] > a.high[k] for k in range(3)):
        return 0.0
    if not (a.body or b.body) or not _may_collide(a.geom, b.geom):
        return 0.0
    if a.body and b.body and ode().dAreConnectedExcluding(a.body, b.body, JointType.CONTACT):
        return 0.0
    return a.geom.body.engine.overlap(a.geom.id, b.geom.id)


def _may_collide(a: Geom, b: Geom) -> bool:
    """Whether the categories of two geoms, and of their spaces, let them collide."""
    pairs = [(a.id, b.id)]
    if a.space is not None and b.space is not None:
        if a.space is b.space:
            return False
        pairs.append((a.space.id, b.space.id))
    category, collide = ode().dGeomGetCategoryBits, ode().dGeomGetCollideBits
    return all(category(one) & collide(two) or category(two) & collide(one) for one, two in pairs)
