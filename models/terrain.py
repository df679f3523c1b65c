"""Terrain: hills from a terrain file or from a height map."""

from __future__ import annotations

import math
from pathlib import Path

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor
from libgz.legacy.model import Model
from libgz.models.greyimage import read_grey
from libgz.models.gzb import read_gzb
from libgz.models.parts import add_body
from libgz.physics.surfaces import TerrainGeom
from libgz.worldfile.attributes import color, declaration, file, length, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class TerrainAttributes:
    """Attributes of `<model:Terrain>`."""

    terrainFile: Path | None = file(help="terrain file (.gzb)")
    dataFile: Path | None = file(
        help="height map image, instead of a terrain file; its middle is the origin, its first row at +y"
    )
    elevationScale: float = length(1.0, help="height of white pixels in a height map")
    vertexSpacing: float = length(1.0, above=0.0, help="distance between the pixels of a height map")
    textureRepeat: tuple[float, ...] = numbers(
        1.0, 1.0, above=0.0, help="repetitions of the texture over a height map, in x and in y"
    )
    color: GzColor = color(0.7, 0.7, 0.7, help="colour")
    textureFile: Path | None = file(help="image file of the texture")
    surfaceHardness: tuple[float, ...] = numbers(
        math.inf, 0.0, unit="N/m, N s/m", least=0.0, infinite=1, help="spring and damper"
    )
    surfaceFriction: tuple[float, ...] = numbers(1.0, 1.0, least=0.0, infinite=2, help="Coulomb coefficients")


class Terrain(Model):
    """Fixed ground from a terrain file or a height map.

    The origin is that of the terrain file, which is usually a corner, or the middle of the height map.
    """

    attributes = TerrainAttributes
    example = """
        <model:Terrain>
          <id>hills</id>
          <terrainFile>terrain.gzb</terrainFile>
          <xyz>-32 -32 0.01</xyz>
        </model:Terrain>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(TerrainAttributes, node)
        self.fixed = True
        body = add_body(self, dummy=True)
        self.ground = TerrainGeom(body, self.modelSpaceId)
        if not (node.IsDefined("terrainFile") or node.IsDefined("dataFile")):
            raise ParameterError("a terrain needs a <terrainFile> (.gzb), or a <dataFile> with a height map")
        try:
            self._build(values, node)
        except ParameterError as error:
            node.warn(f"{error}; no ground is built")
        self.ground.SetColor(values.color)
        self.ground.SetHardness(*values.surfaceHardness)
        self.ground.SetFriction(*values.surfaceFriction)
        self.ground.SetTexture2DFile(values.textureFile)

    def _build(self, values: TerrainAttributes, node: WorldFileNode) -> None:
        """Load the mesh and warn of damage; a missing file was reported when the attributes were read."""
        if values.terrainFile is not None:
            terrain = read_gzb(values.terrainFile)
            if terrain.damage:
                node.warn(f"terrain {str(values.terrainFile)!r} is damaged: {'; '.join(terrain.damage)}")
            self.ground.Load(terrain.vertices, terrain.strip, terrain.triangles)
        elif values.dataFile is not None:
            heights = read_grey(values.dataFile)[::-1] * (values.elevationScale / 255.0)
            in_x, in_y = values.textureRepeat
            self.ground.LoadGrid(heights, values.vertexSpacing, (in_x, in_y), centred=True)
