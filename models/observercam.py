"""ObserverCam: the camera through which people watch a world."""

from __future__ import annotations

from dataclasses import dataclass

from libgz.models.camera import CameraAttributes, announce_blindness, check_clips
from libgz.physics.body import Body
from libgz.simulation.model import Model
from libgz.worldfile.attributes import boolean, length, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@dataclass(frozen=True)
class ObserverCamAttributes(CameraAttributes):
    """What `<model:ObserverCam>` may hold."""

    farClip: float = length(100.0, above=0.0, help="farthest that is drawn")
    displayBBox: bool = boolean(False, help="draw bounding boxes")
    displayAxes: bool = boolean(False, help="draw the axes of named bodies")
    displayCoM: bool = boolean(False, help="draw centres of mass")
    displayRays: bool = boolean(False, help="draw the rays of lasers and sonars")
    displayFrustrums: bool = boolean(False, help="draw what cameras see")
    displayMaterials: bool = boolean(True, help="draw colours")
    displayTextures: bool = boolean(True, help="draw textures")
    displaySkins: bool = boolean(True, help="draw skins instead of the shapes below")
    polygonFill: bool = boolean(True, help="fill polygons; false: draw their edges")
    shadeSmooth: bool = boolean(True, help="shade smoothly; false: flat")
    rollLock: bool = boolean(True, help="keep the camera level")


class ObserverCam(Model):
    """The camera through which people watch a world.

    It has no body; it may be nested, and then goes with its parent.
    """

    attributes = ObserverCamAttributes
    example = """
        <model:ObserverCam>
          <id>observer</id>
          <xyz>-3 0 1.5</xyz>
          <rpy>0 20 0</rpy>
        </model:ObserverCam>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(ObserverCamAttributes, node)
        check_clips(node, self.values)
        self.AddBody(Body(self.world, dummy=True), True)

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        announce_blindness(self)
