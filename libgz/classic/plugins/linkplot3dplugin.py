"""LinkPlot3DPlugin: shows the paths of links as lines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from libgz.base.errors import ParameterError
from libgz.classic import rendering
from libgz.classic.event import Events
from libgz.classic.math import Pose3d, Vector3d
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin
from libgz.classic.plugins._names import named_link

if TYPE_CHECKING:
    from libgz.classic.physics import Link, Model
    from libgz.classic.rendering import DynamicLines
    from libgz.sdf.element import Element

LEAST_DISTANCE = 0.01  # between two points of a path [m]
MOST_POINTS = 10_000  # of a path; then it begins again


@dataclass
class Path:
    """The path of a point of a link."""

    STATE: ClassVar[tuple[str, ...]] = ("last",)
    link: Link
    offset: Pose3d
    line: DynamicLines
    last: Vector3d | None = None

    def extend(self) -> None:
        """Add where the point is now, unless it has hardly moved."""
        place = (self.link.WorldPose() * self.offset).Pos()
        if self.last is not None and place.Distance(self.last) < LEAST_DISTANCE:
            return
        if self.line.PointCount() >= MOST_POINTS:
            self.line.Clear()
        self.line.AddPoint(place)
        self.last = place


class LinkPlot3DPlugin(ModelPlugin):
    """Shows the paths of points of links as lines, which cameras and windows render.

    Elements:
        frequency: of new points [Hz] (30).
        plot: one a path.
            link: the name of the link.
            pose: of the point in the link's frame [m], [rad]; its rotation has no effect.
            material: the line's colour, a material such as Gazebo/Red (Gazebo/Black).
    """

    STATE = ("due", "paths")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the links.

        Raises:
            NotFoundError: there is no such link.
            ParameterError: the frequency is not positive.
        """
        frequency = sdf.Get(float, "frequency", 30.0)[0]
        if not frequency > 0.0:
            raise ParameterError(f"{sdf.where}: <frequency> is {frequency:g} Hz; it must be positive")
        self.period, self.due = 1.0 / frequency, 0.0
        root = rendering.get_scene(model.GetWorld().Name()).WorldVisual()
        self.paths: list[Path] = []
        for element in sdf.named("plot"):
            line = root.CreateDynamicLine()
            line.setMaterial(element.Get(str, "material", "Gazebo/Black")[0].strip())
            self.paths.append(Path(named_link(model, element, "link"), element.Get(Pose3d, "pose"), line))
        self.connection = Events.ConnectWorldUpdateEnd(self.OnUpdate)

    def Reset(self) -> None:
        """Begin the paths again."""
        self.due = 0.0
        for path in self.paths:
            path.line.Clear()
            path.last = None

    def OnUpdate(self) -> None:
        """Add points, if it is time."""
        now = self.paths[0].link.GetWorld().SimTime().Double() if self.paths else 0.0
        if now + 1e-9 >= self.due:
            self.due = now + self.period
            for path in self.paths:
                path.extend()


GZ_REGISTER_MODEL_PLUGIN(LinkPlot3DPlugin)
