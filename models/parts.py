"""Parts: what the built-in robots are put together from, besides their wheels."""

from __future__ import annotations

from typing import TypeVar

from libgz.geometry import GzColor, GzPose, GzQuatern, GzVector, VectorLike
from libgz.physics.geom import Geom

__all__ = ["BLACK", "DARK", "GREY", "RED", "fit"]

BLACK = GzColor(0.0, 0.0, 0.0)
DARK = GzColor(0.1, 0.1, 0.1)
GREY = GzColor(0.3, 0.3, 0.3)
RED = GzColor(1.0, 0.0, 0.0)

G = TypeVar("G", bound=Geom)


def fit(geom: G, position: VectorLike, mass: float, color: GzColor, rotation: GzQuatern | None = None) -> G:
    """Place a geom in its body's frame [m], and give it a mass [kg] and a colour; the geom itself."""
    geom.SetRelativePose(GzPose(GzVector(*position), rotation or GzQuatern()))
    geom.SetMass(mass)
    geom.SetColor(color)
    return geom
