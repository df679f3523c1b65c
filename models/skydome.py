"""SkyDome: a sky whose colours change with the time of day."""

from __future__ import annotations

from pathlib import Path

from libgz.base.geometry import GzColor
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.physics.geoms import DomeGeom
from libgz.worldfile.attributes import boolean, color, declaration, file, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class SkyDomeAttributes:
    """Attributes of `<model:SkyDome>`."""

    toneMap: Path | None = file(help="image of the sky's colours: midnight to midnight, zenith to horizon")
    timeLapse: bool = boolean(True, help="whether the sky changes with sim time")
    color: GzColor = color(0.0, 0.0, 0.0, help="without effect")


class SkyDome(Model):
    """A sky whose colours change with the time of day. It takes no part in collisions."""

    attributes = SkyDomeAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(SkyDomeAttributes, node)
        self.fixed = True
        body = add_body(self, dummy=True)
        self.dome = DomeGeom(body, self.modelSpaceId)
        self.dome.SetTexture2DFile(self.values.toneMap)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.dome.SetDayTime(self.world.GetDayTime())

    def SaveState(self) -> tuple[float, float]:
        """Time since midnight at the start, and time since the start [s]."""
        return self.dome.start, self.dome.elapsed

    def LoadState(self, state: tuple[float, float]) -> None:
        """Return to these times."""
        start, elapsed = state
        self.dome.SetDayTime(start)
        self.dome.SetElapsedTime(elapsed)

    def Update(self, step: float) -> None:  # noqa: D102
        if self.values.timeLapse:
            self.dome.SetElapsedTime(self.world.GetSimTime())
