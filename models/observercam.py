"""ObserverCam: the camera of user interfaces, which the user moves with the mouse."""

from __future__ import annotations

import math
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import (
    GzCoordPoseAdd,
    GzCoordPoseSub,
    GzPose,
    GzPosePointAt,
    GzQuaternFromEuler,
    GzQuaternToEuler,
    GzVector,
    GzVectorAdd,
    rotate,
)
from libgz.interfaces.guicam import GAZEBO_GUICAM_MAX_IMAGE_SIZE, Guicam, GuicamData
from libgz.legacy.model import Model
from libgz.models.camera import CameraAttributes, FrameSaver, check_optics, make_eye
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.rendering.camera import Camera as Eye
from libgz.simulation.rate import UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import boolean, declaration, length, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode


@declaration
class ObserverCamAttributes(CameraAttributes):
    """Attributes of `<model:ObserverCam>`."""

    farClip: float = length(100.0, above=0.0, help="far clipping distance")
    displayBBox: bool = boolean(False, help="render bounding boxes")
    displayAxes: bool = boolean(False, help="render the axes of named bodies")
    displayCoM: bool = boolean(False, help="render centres of mass")
    displayRays: bool = boolean(False, help="render the rays of lasers and sonars")
    displayFrustrums: bool = boolean(False, help="render the view frustums of cameras")
    displayMaterials: bool = boolean(True, help="render colours")
    displayTextures: bool = boolean(True, help="render textures")
    displaySkins: bool = boolean(True, help="render skins instead of the shapes that they replace")
    polygonFill: bool = boolean(True, help="fill polygons; false: render their edges only")
    shadeSmooth: bool = boolean(True, help="smooth shading; false: flat shading")
    rollLock: bool = boolean(True, help="keep the camera level")


# Switches of the interface -> attributes of the worldfile, which are also the options of the rendering camera.
SWITCHES = {
    "display_bbox": "displayBBox",
    "display_axes": "displayAxes",
    "display_com": "displayCoM",
    "display_skins": "displaySkins",
    "display_rays": "displayRays",
    "display_frustrums": "displayFrustrums",
    "display_materials": "displayMaterials",
    "display_textures": "displayTextures",
    "polygon_fill": "polygonFill",
    "shade_smooth": "shadeSmooth",
}
TRANSLATE, ZOOM, ROTATE = range(3)
MOST_FRAMES = 1000  # images that a camera saves at the request of clients


class Spot(NamedTuple):
    """A drag of the mouse: from pixel a to pixel b."""

    mode: int
    a: tuple[float, float]
    b: tuple[float, float]


class ObserverCam(Model):
    """The camera of user interfaces.

    It has no shape; nested in another model, it moves with that model. With `saveFrames` it saves every image; at the
    request of clients, `save_frames`, at most 1000.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "saver", "switches", "_requested", "_distance", "_dragging")

    attributes = ObserverCamAttributes
    interfaces = ("guicam",)
    example = """
        <model:ObserverCam>
          <id>observer</id>
          <xyz>-3 0 1.5</xyz>
          <rpy>0 20 0</rpy>
        </model:ObserverCam>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(ObserverCamAttributes, node)
        check_optics(node, self.values, GAZEBO_GUICAM_MAX_IMAGE_SIZE)
        add_body(self, dummy=True)
        self.guicam = Guicam()
        self.eye: Eye | None = None
        self.rate = UpdateRate(self.values.updateRate)
        self.saver = FrameSaver(self.values.savePath)
        self.spot: Spot | None = None
        self._requested = 0  # images saved at a client's request
        self._distance = 0.0  # to the point under the spot when the drag began [m]

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.eye = make_eye(self, self.values)
        self.guard = Guard(f"guicam.{self.GetId()}")
        serve(self, self.guicam)
        data = self.guicam.data
        data.width, data.height = self.eye.GetImageSize()
        named = {**SWITCHES, "roll_lock": "rollLock", "save_frames": "saveFrames"}
        self.switches: dict[str, bool] = {field: getattr(self.values, name) for field, name in named.items()}
        for field, value in self.switches.items():
            setattr(data, field, int(value))

    def Fini(self) -> None:  # noqa: D102
        self.guicam.destroy()
        if self.eye is not None:
            self.eye.close()
            self.eye = None

    def Update(self, step: float) -> None:  # noqa: D102
        now = self.world.GetSimTime() + self.world.GetPauseTime()
        eye = self.eye
        if eye is None or eye.blind or not self.rate.due(now) or not self.guicam.lock():
            return
        data = self.guicam.data
        spot = self._read_spot(data)
        for field in self.switches:
            self._read_switch(data, field)
        self.guicam.unlock()
        for field, attribute in SWITCHES.items():
            setattr(eye.options, attribute, self.switches[field])
        self._drag(eye, spot, self.switches["roll_lock"])
        image = eye.Update()
        self._publish(eye)
        if self.switches["save_frames"]:
            self._save(image)

    def _save(self, image: NDArray[np.uint8]) -> None:
        """Save an image; at a client's request there is a limit, so that no client can fill the disk."""
        if not self.values.saveFrames:
            if self._requested == MOST_FRAMES:
                self.guard.warn("save_frames", "is 1, but {} images were saved", "is ignored", MOST_FRAMES)
                return
            self._requested += 1
        self.saver.save(image)

    def _read_switch(self, data: GuicamData, field: str) -> None:
        """Take a switch from the interface, or restore it there."""
        value, old = getattr(data, field), self.switches[field]
        if value != old:
            new = self.switches[field] = self.guard.switch(field, value, old)
            setattr(data, field, int(new))

    def _read_spot(self, data: GuicamData) -> Spot | None:
        """The drag in progress, or None."""
        if data.cmd_spot_state != 1:
            return None
        names = ("cmd_spot_a[0]", "cmd_spot_a[1]", "cmd_spot_b[0]", "cmd_spot_b[1]")
        old = (*self.spot.a, *self.spot.b) if self.spot is not None else (0.0,) * 4
        wanted = (*data.cmd_spot_a, *data.cmd_spot_b)
        ax, ay, bx, by = (self.guard.number(n, w, o, 1e4) for n, w, o in zip(names, wanted, old, strict=True))
        return Spot(data.cmd_spot_mode, (ax, ay), (bx, by))

    def _drag(self, eye: Eye, spot: Spot | None, level: bool) -> None:
        """Set the pose of the rendering camera; when the drag ends, move the model there."""
        if spot is not None and self.spot is None:
            eye.SetPose(self.GetPose())
            eye.Update()
            self._distance = self._depth_at(eye, spot)
        if spot is not None:
            pose = GzCoordPoseAdd(camera_delta(eye, spot, self._distance), self.GetPose())
            eye.SetPose(_levelled(pose) if level else pose)
        elif self.spot is not None:
            parent, pose = self.parentBody, eye.GetPose()
            self.world.SetModelPose(self, pose if parent is None else GzCoordPoseSub(pose, parent.GetPose()))
        else:
            eye.SetPose(self.GetPose())
        self.spot = spot

    @property
    def _dragging(self) -> tuple[Any, ...] | None:
        """The drag in progress, as plain data, with the pose of the rendering camera."""
        if self.spot is None or self.eye is None:
            return None
        return self.spot.mode, self.spot.a, self.spot.b, self.eye.GetPose()

    @_dragging.setter
    def _dragging(self, value: tuple[Any, ...] | None) -> None:
        self.spot = None
        if value is not None and self.eye is not None:
            mode, a, b, pose = value
            self.spot = Spot(mode, a, b)
            self.eye.SetPose(pose)

    def _depth_at(self, eye: Eye, spot: Spot) -> float:
        """Depth of the point at the start of a drag [m]; the far clip for the sky."""
        column = min(max(int(spot.a[0]), 0), eye.width - 1)
        row = min(max(int(spot.a[1]), 0), eye.height - 1)
        return min(float(eye.depth[row, column]), eye.far)

    def _publish(self, eye: Eye) -> None:
        if not self.guicam.lock():
            return
        data, pose, image = self.guicam.data, eye.GetPose(), eye.image
        data.sim_time, data.pause_time = self.world.GetSimTime(), self.world.GetPauseTime()
        data.width, data.height = eye.GetImageSize()  # a client may have overwritten it
        data.pos[:], data.rot[:] = tuple(pose.pos), tuple(GzQuaternToEuler(pose.rot))
        self.guicam.array("image")[: image.size] = image.reshape(-1)
        data.image_size = image.size
        self.guicam.unlock()
        self.guicam.post()


def camera_delta(eye: Eye, spot: Spot, distance: float) -> GzPose:
    """How a drag moves a camera, as a pose in its own frame [m].

    Translating keeps the grabbed point, `distance` [m] away, under the mouse; zooming moves along the line of sight so
    that the point stays at the mouse's row of the image; rotating turns by the angle between the two pixels.
    """
    wide, high = (size / (2.0 * eye.view.focal) for size in (eye.width, eye.height))
    (ax, ay), (bx, by) = ((2.0 * x / eye.width - 1.0, 1.0 - 2.0 * y / eye.height) for x, y in (spot.a, spot.b))
    if spot.mode == TRANSLATE:
        return GzPose(GzVector(0.0, distance * wide * (bx - ax), -distance * high * (by - ay)))
    if spot.mode == ZOOM:
        forward = distance - distance * abs(ay) / (abs(by) + 1e-16)
        return GzPose(GzVector(max(distance - 0.5 * eye.far, min(forward, distance - 2.0 * eye.near)), 0.0, 0.0))
    if spot.mode == ROTATE:
        turn = GzQuaternFromEuler(0.0, math.atan((by - ay) * high), math.atan((bx - ax) * wide))
        return GzPose(GzVector(), turn)
    return GzPose()


def _levelled(pose: GzPose) -> GzPose:
    """The same line of sight with a level horizon."""
    ahead = rotate(pose.rot, (1.0, 0.0, 0.0))
    if abs(ahead.z) > 0.9999:
        return pose
    return GzPosePointAt(pose.pos, GzVectorAdd(pose.pos, ahead), GzVector(0.0, 0.0, 1.0))
