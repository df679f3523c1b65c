"""Road: a strip of ground along surveyed points, with signs."""

from __future__ import annotations

from pathlib import Path

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzColor
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.models.roadfile import read_road
from libgz.physics.surfaces import RoadGeom
from libgz.worldfile.attributes import color, declaration, file, lengths, numbers, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class RoadAttributes:
    """Attributes of `<model:Road>`."""

    roadFile: Path | None = file(help="road file: lines `track ...` and `waypoint ...`, in UTM coordinates")
    roadSpacing: tuple[float, ...] = numbers(
        0.0, 1.0, unit="m", least=0.0, help="between records, 0: as in the file; and between heights across the road"
    )
    color: GzColor = color(0.7, 0.7, 0.7, help="colour")
    textureFile: Path | None = file(help="image file of the texture")
    textureSize: tuple[float, ...] = lengths(2.0, 2.0, help="size of one repetition of the texture, along and across")
    surfaceHardness: tuple[float, ...] = numbers(
        1e4, 0.0, unit="N/m, N s/m", least=0.0, infinite=1, help="spring and damper"
    )
    surfaceFriction: tuple[float, ...] = numbers(1.0, 1.0, least=0.0, infinite=2, help="Coulomb coefficients")


class Road(Model):
    """A fixed road 16 m wide along surveyed points; the world's utmOffset is subtracted from their coordinates."""

    attributes = RoadAttributes
    example = """
        <param:Global>
          <utmOffset>500000 4000000 0</utmOffset>
        </param:Global>

        <model:Road>
          <id>road1</id>
          <roadFile>road.txt</roadFile>
        </model:Road>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(RoadAttributes, node)
        self.fixed = True
        body = add_body(self, dummy=True)
        self.road = RoadGeom(body, self.modelSpaceId)
        self.road.SetColor(values.color)
        self.road.SetHardness(*values.surfaceHardness)
        self.road.SetFriction(*values.surfaceFriction)
        self.road.SetTexture2DFile(values.textureFile)
        self.road.SetTexture2DSize((*values.textureSize, 0.0))
        if not node.IsDefined("roadFile"):
            raise ParameterError("a road needs a <roadFile>")
        if values.roadFile is not None:
            try:
                self._build(values.roadFile, values.roadSpacing, node)
            except ParameterError as error:
                node.warn(f"road {str(values.roadFile)!r}: {error}; no road is built")

    def _build(self, path: Path, spacing: tuple[float, ...], node: WorldFileNode) -> None:
        """Read the file into the geom, with one warning for all invalid lines."""
        found = read_road(path, self.world.utmOffset)
        if found.damage:
            more = f", and {len(found.damage) - 1} more" if len(found.damage) > 1 else ""
            node.warn(f"road {str(path)!r}: {found.damage[0]}{more}: ignored")
        between_records, between_heights = spacing
        if between_records > 0.0:
            self.road.SetTrackSpacing(between_records)
        if between_heights > 0.0:
            self.road.SetProfileSpacing(between_heights)
        for point in found.track:
            index = self.road.AddTrackPoint(point.position, point.distance)
            for height in point.profile:
                self.road.AddProfilePoint(index, height)
        for position, text in found.signs:
            self.road.AddSign(position, text)
        self.road.UpdateMesh()
