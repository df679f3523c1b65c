"""StereoHead: two cameras side by side."""

from __future__ import annotations

from dataclasses import dataclass

from libgz.geometry import GzColor
from libgz.models.camera import RobotCameraAttributes, announce_blindness, check_clips
from libgz.physics.body import Body
from libgz.physics.geoms import BoxGeom
from libgz.simulation.model import Model
from libgz.worldfile.attributes import boolean, length, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@dataclass(frozen=True)
class StereoHeadAttributes(RobotCameraAttributes):
    """What `<model:StereoHead>` may hold."""

    baseline: float = length(0.15, above=0.0, help="distance between the cameras")
    enableImageLeft: bool = boolean(True, help="take pictures with the left camera")
    enableImageRight: bool = boolean(True, help="take pictures with the right camera")
    enableDisparityLeft: bool = boolean(True, help="compute disparities for the left camera")
    enableDisparityRight: bool = boolean(True, help="compute disparities for the right camera")


class StereoHead(Model):
    """Two cameras side by side in one housing of 0.3 kg; the origin is the centre of its bottom."""

    attributes = StereoHeadAttributes

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(StereoHeadAttributes, node)
        check_clips(node, self.values)
        body = Body(self.world)
        self.AddBody(body, True)
        housing = BoxGeom(body, self.modelSpaceId, 0.05, self.values.baseline + 0.06, 0.05)
        housing.SetRelativePosition((0.0, 0.0, 0.025))
        housing.SetMass(0.3)
        housing.SetColor(GzColor(0.3, 0.3, 0.3))

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        announce_blindness(self)
