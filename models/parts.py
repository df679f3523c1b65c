"""Bodies and shapes that the built-in models are assembled from, and common colours."""

from __future__ import annotations

from typing import TypeVar

from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector, VectorLike
from libgz.legacy.model import Model
from libgz.physics.body import Body
from libgz.physics.geom import Geom

__all__ = ["BLACK", "DARK", "GREY", "RED", "add_body", "fit"]

BLACK = GzColor(0.0, 0.0, 0.0)
DARK = GzColor(0.1, 0.1, 0.1)
GREY = GzColor(0.3, 0.3, 0.3)
RED = GzColor(1.0, 0.0, 0.0)

G = TypeVar("G", bound=Geom)


def add_body(model: Model, name: str | None = None, *, dummy: bool = False) -> Body:
    """A new body of a model; without a name it is the canonical one.

    Args:
        model: the model that gets the body.
        name: of the body.
        dummy: whether the body takes no part in physics.
    """
    body = Body(model.world, name, dummy=dummy)
    model.AddBody(body, canonical=name is None)
    return body


def fit(
    geom: G, position: VectorLike, mass: float, color: GzColor | None = None, rotation: GzQuatern | None = None
) -> G:
    """Set the place of a geom in its body's frame [m], its mass [kg] and its colour; return the geom."""
    geom.SetRelativePose(GzPose(GzVector(*position), rotation or GzQuatern()))
    geom.SetMass(mass)
    if color is not None:
        geom.SetColor(color)
    return geom
