"""GroundPlane: an infinite, rigid plane."""

from __future__ import annotations

import math
from pathlib import Path

from libgz.base.geometry import GzColor, GzVector
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.physics.geoms import PlaneGeom
from libgz.worldfile.attributes import color, declaration, file, length, lengths, numbers, read, vector
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class GroundPlaneAttributes:
    """Attributes of `<model:GroundPlane>`."""

    normal: GzVector = vector((0.0, 0.0, 1.0), unit="", help="normal of the plane")
    height: float = length(0.0, help="height of the plane along its normal")
    color: GzColor = color(0.0, 0.5, 0.0, help="colour")
    textureFile: Path | None = file(help="image file of the texture")
    textureSize: tuple[float, ...] = lengths(2.0, 2.0, help="size of one repetition of the texture")
    surfaceHardness: tuple[float, ...] = numbers(
        math.inf, 0.0, unit="N/m, N s/m", least=0.0, infinite=1, help="spring and damper"
    )
    surfaceFriction: tuple[float, ...] = numbers(1.0, 1.0, least=0.0, infinite=2, help="Coulomb coefficients")


class GroundPlane(Model):
    """The ground, an infinite, rigid plane.

    `height` and `normal` place it; `xyz` and `rpy` have no effect.
    """

    attributes = GroundPlaneAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(GroundPlaneAttributes, node)
        for name, moves in ("xyz", values.normal), ("rpy", (1.0, 1.0, 0.0)):  # other shifts and turns do not show
            child = node.GetChild(name)
            if child is not None and any(a * b for a, b in zip(node.GetPosition(name), moves, strict=True)):
                child.warn("has no effect on a GroundPlane; <height> and <normal> place it")
        self.fixed = True
        body = add_body(self, dummy=True)
        self.plane = PlaneGeom(body, self.modelSpaceId, values.height, values.normal)
        self.plane.SetColor(values.color)
        self.plane.SetHardness(*values.surfaceHardness)
        self.plane.SetFriction(*values.surfaceFriction)
        self.plane.SetTexture2DFile(values.textureFile)
        self.plane.SetTexture2DSize((*values.textureSize, 0.0))
