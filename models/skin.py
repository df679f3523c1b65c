"""Skins: meshes that are rendered instead of a model's shapes."""

from __future__ import annotations

from pathlib import Path

from libgz.base.geometry import GzPose, GzVector, GzVectorSub
from libgz.legacy.model import Model
from libgz.physics.geom import Geom
from libgz.worldfile.attributes import declaration, file, rotation, vector

__all__ = ["SkinAttributes", "add_skin"]


@declaration
class SkinAttributes:
    """Attributes of a model with a skin."""

    skinFile: Path | None = file(help="mesh that is rendered instead of the model's shapes")
    skinXyz: GzVector = vector((0.0, 0.0, 0.0), help="position of the mesh, relative to the model's origin")
    skinRpy: GzPose = rotation(help="rotation of the mesh")
    skinScale: GzVector = vector((1.0, 1.0, 1.0), unit="", help="scale of the mesh")


def add_skin(model: Model, geom: Geom, values: SkinAttributes) -> None:
    """Attach the skin to a geom of the canonical body; the other geoms are not rendered then.

    If the skin cannot be read, all geoms are rendered.
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
