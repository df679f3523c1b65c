"""StereoHead: two cameras side by side."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose, GzVector
from libgz.interfaces.stereo import Stereo
from libgz.legacy.model import Model
from libgz.models.camera import FrameSaver, RobotCameraAttributes, add_frustum, check_optics, make_eye, set_view
from libgz.models.parts import GREY, add_body, fit
from libgz.models.serving import serve
from libgz.physics.geoms import BoxGeom
from libgz.rendering.camera import Camera as Eye
from libgz.rendering.disparity import disparities
from libgz.simulation.rate import UpdateRate
from libgz.worldfile.attributes import boolean, declaration, length, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class StereoHeadAttributes(RobotCameraAttributes):
    """Attributes of `<model:StereoHead>`."""

    baseline: float = length(0.15, above=0.0, help="distance between the optical centres")
    enableImageLeft: bool = boolean(True, help="render images of the left camera")
    enableImageRight: bool = boolean(True, help="render images of the right camera")
    enableDisparityLeft: bool = boolean(True, help="compute disparities for the left camera")
    enableDisparityRight: bool = boolean(True, help="compute disparities for the right camera")


LENS = (0.025, 0.025)  # x and z of the optical centres [m]


class StereoHead(Model):
    """Two cameras side by side in one housing of 0.3 kg; the origin is the centre of its bottom."""

    STATE: ClassVar[tuple[str, ...]] = ("rate", "savers")

    attributes = StereoHeadAttributes
    interfaces = ("stereo",)

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = values = read(StereoHeadAttributes, node)
        check_optics(node, values)
        body = add_body(self)
        fit(BoxGeom(body, self.modelSpaceId, 0.05, values.baseline + 0.06, 0.05), (0.0, 0.0, 0.025), 0.3, GREY)
        x, z = LENS
        self.places = {
            side: GzPose(GzVector(x, sign * values.baseline / 2.0, z)) for side, sign in (("left", 1), ("right", -1))
        }
        for place in self.places.values():
            add_frustum(self, body, values, place)
        self.stereo = Stereo()
        self.eyes: dict[str, Eye] = {}
        self.savers = {side: FrameSaver(f"{values.savePath}/{side}") for side in self.places}
        self.rate = UpdateRate(values.updateRate)
        self.images = {"left": values.enableImageLeft, "right": values.enableImageRight}
        self.disparities = {"left": values.enableDisparityLeft, "right": values.enableDisparityRight}

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        for side in self.places:
            self.eyes[side] = make_eye(self, self.values)
        serve(self, self.stereo)
        self.stereo.data.width, self.stereo.data.height = self.eyes["left"].GetImageSize()

    def Fini(self) -> None:  # noqa: D102
        self.stereo.destroy()
        for eye in self.eyes.values():
            eye.close()
        self.eyes.clear()

    def Update(self, step: float) -> None:  # noqa: D102
        now = self.world.GetSimTime()
        if not self.eyes or self.eyes["left"].blind or not self.rate.due(now):
            return
        wanted = any(self.disparities.values())
        depths: dict[str, NDArray[np.float32]] = {}
        for side, eye in self.eyes.items():
            set_view(self, eye, self.values.hfov)
            eye.SetPose(self.GetBody().global_pose(self.places[side]))
            if wanted:
                depths[side] = np.empty((eye.height, eye.width), dtype=np.float32)
                eye.Update(depths[side])
            elif self.images[side]:
                eye.Update()
        found: dict[str, NDArray[np.float32]] = {}
        if wanted:
            focal = self.eyes["left"].view.focal
            both = disparities(depths["left"], depths["right"], focal, self.values.baseline)
            found = dict(zip(depths, both, strict=True))
        self._publish(now, found)

    def _publish(self, now: float, found: dict[str, NDArray[np.float32]]) -> None:
        if not self.stereo.lock():
            return
        data = self.stereo.data
        data.width, data.height = self.eyes["left"].GetImageSize()  # a client may have overwritten it
        for side, eye in self.eyes.items():
            if self.images[side]:
                self.stereo.array(f"{side}_image")[: eye.image.size] = eye.image.reshape(-1)
                setattr(data, f"{side}_image_size", eye.image.size)
            if self.disparities[side]:
                values = found[side].reshape(-1)
                self.stereo.array(f"{side}_disparity")[: values.size] = values
                setattr(data, f"{side}_disparity_size", values.size)
        data.time = now
        self.stereo.unlock()
        self.stereo.post()
        for side, eye in self.eyes.items():
            if self.values.saveFrames and self.images[side]:
                self.savers[side].save(eye.image)
