"""Skins: a mesh that is drawn in place of a model's shapes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from libgz.geometry import GzPose, GzVector, GzVectorSub
from libgz.legacy.model import Model
from libgz.physics.geom import Geom
from libgz.worldfile.attributes import file, rotation, vector

__all__ = ["SkinAttributes", "clothe"]


@dataclass(frozen=True)
class SkinAttributes:
    """What the element of a model with a skin may hold."""

    skinFile: Path | None = file(help="mesh to draw in place of the model's shapes")
    skinXyz: GzVector = vector((0.0, 0.0, 0.0), help="place of the mesh, from the model's origin")
    skinRpy: GzPose = rotation(help="rotation of the mesh")
    skinScale: GzVector = vector((1.0, 1.0, 1.0), unit="", help="scale of the mesh")


def clothe(model: Model, geom: Geom, values: SkinAttributes) -> None:
    """Put the skin on a geom of the canonical body, counted from the model's origin; nothing else is drawn then.

    If it cannot be read, all shapes are drawn.
    """
    if values.skinFile is None:
        return
    geom.SetSkinFile(values.skinFile)
    geom.SetSkinPose(GzPose(GzVectorSub(values.skinXyz, geom.GetRelativePose().pos), values.skinRpy.rot))
    geom.SetSkinScale(values.skinScale)
    for body in model.bodies:
        for other in body.geoms:
            if other is not geom:
                other.SetSkinNull(True, values.skinFile)
