"""MapExtruder: walls on the outlines of a floor plan."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor, GzPose, GzQuaternFromAxis, GzVector
from libgz.legacy.model import Model
from libgz.models.contours import outlines, simplified
from libgz.models.greyimage import read_grey
from libgz.models.parts import add_body
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.physics.space import Space
from libgz.worldfile.attributes import color, declaration, file, length, number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class MapExtruderAttributes:
    """Attributes of `<model:MapExtruder>`."""

    imageFile: Path | None = file(help="image of the floor plan, x to the right and y up, its centre at the origin")
    threshold: float = number(200.0, help="grey value, 0 to 255, below which a pixel is solid")
    scale: float = number(0.1, unit="m/px", above=0.0, help="size of a pixel")
    height: float = length(1.0, above=0.0, help="height of the walls")
    width: float = length(0.1, above=0.0, help="thickness of the walls, half of it on either side of the outline")
    errBound: float = number(
        5.0, unit="px", least=0.0, help="largest deviation of a wall from the outline; larger values give fewer walls"
    )
    color: GzColor = color(1.0, 1.0, 1.0, help="colour of the walls")


class MapExtruder(Model):
    """Fixed walls on the outlines of a floor plan, one box per side.

    `walls` has the ends of all walls [m], shape (n, 2, 2).
    """

    attributes = MapExtruderAttributes
    example = """
        <model:MapExtruder>
          <id>rooms</id>
          <imageFile>example2.png</imageFile>
          <scale>0.05</scale>
          <errBound>1</errBound>
        </model:MapExtruder>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(MapExtruderAttributes, node)
        self.fixed = True
        body = add_body(self, dummy=True)
        self.walls = np.zeros((0, 2, 2))
        if not node.IsDefined("imageFile"):
            raise ParameterError("a MapExtruder needs an <imageFile>")
        if values.imageFile is not None:
            try:
                solid = read_grey(values.imageFile) < values.threshold
                self.walls = _walls(solid, values.errBound) * values.scale
            except ParameterError as error:
                node.warn(f"{error}; no walls are built")
        self._build(values, body)

    def _build(self, values: MapExtruderAttributes, body: Body) -> None:
        """Build one box per wall; walls of one part of the plan share a space, which speeds up collision detection."""
        if not len(self.walls):
            return
        parts: dict[tuple[int, ...], Space] = {}
        middles = self.walls.mean(axis=1)
        part = values.scale + 4.0 * float(np.ptp(middles, axis=0).max()) / math.sqrt(len(middles))
        for ((ax, ay), (bx, by)), (x, y) in zip(self.walls.tolist(), middles.tolist(), strict=True):
            key = (int(x // part), int(y // part))
            if key not in parts:
                parts[key] = Space(self.world.engine, parent=self.modelSpaceId)
            reach = math.hypot(bx - ax, by - ay) + values.width
            wall = BoxGeom(body, parts[key], reach, values.width, values.height)
            turn = GzQuaternFromAxis(0.0, 0.0, 1.0, math.atan2(by - ay, bx - ax))
            wall.SetRelativePose(GzPose(GzVector(x, y, values.height / 2.0), turn))
            wall.SetColor(values.color)


def _walls(solid: NDArray[np.bool_], tolerance: float) -> NDArray[np.float64]:
    """Sides of the outlines of solid pixels, relative to the image centre, x right and y up [px]; shape (n, 2, 2)."""
    rows, columns = solid.shape
    walls = [np.zeros((0, 2, 2))]
    for polygon in outlines(solid):
        corners = simplified(polygon, tolerance)
        points = np.stack([corners[:, 1] - columns / 2.0, rows / 2.0 - corners[:, 0]], axis=1)
        sides = np.stack([points, np.roll(points, -1, axis=0)], axis=1)
        walls.append(sides if len(points) > 2 else sides[:1])
    return np.concatenate(walls)
