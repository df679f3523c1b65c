"""What all camera models share: attributes, the rendering camera, and serving and saving of images."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import GzPose
from libgz.interfaces.camera import GAZEBO_CAMERA_MAX_IMAGE_SIZE, Camera
from libgz.legacy.model import Model
from libgz.models.serving import serve
from libgz.physics.body import Body
from libgz.physics.geoms import FrustrumGeom
from libgz.rendering.camera import Camera as Eye, horizontal_view
from libgz.rendering.image import write_pnm
from libgz.simulation.entity import Entity
from libgz.simulation.plan import Plan
from libgz.simulation.rate import UpdateRate
from libgz.worldfile.attributes import angle, boolean, declaration, integer, length, number, numbers, text
from libgz.worldfile.node import WorldFileNode

__all__ = [
    "CameraAttributes",
    "CameraServer",
    "FrameSaver",
    "RobotCameraAttributes",
    "add_frustum",
    "check_optics",
    "eye_of",
    "make_eye",
    "set_view",
]

log = logging.getLogger("libgz.models")


@declaration
class CameraAttributes:
    """Attributes of every camera."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="images per second of sim time")
    imageSize: tuple[float, ...] = numbers(320, 240, unit="px", least=1, help="width and height of the image")
    hfov: float = angle(60.0, above=0.0, most=179.0, help="horizontal field of view")
    nearClip: float = length(0.5, least=0.01, help="near clipping distance")
    farClip: float = length(50.0, above=0.0, help="far clipping distance")
    renderMethod: str = text("auto", help="without effect: rendering is always off-screen")
    zBufferDepth: int = integer(16, unit="bit", help="without effect: depth buffers always have at least 24 bits")
    savePath: str = text(".", help="directory for saved images")
    saveFrames: bool = boolean(False, help="save every image")


@declaration
class RobotCameraAttributes(CameraAttributes):
    """Attributes of a camera with a body."""

    useFrustrum: bool = boolean(True, help="let observers display the view frustum")


def check_optics(node: WorldFileNode, values: CameraAttributes, most: int = GAZEBO_CAMERA_MAX_IMAGE_SIZE) -> None:
    """Report errors of the worldfile: the far clip is not beyond the near clip, or an image exceeds `most` bytes."""
    if values.farClip <= values.nearClip:
        node.error(f"farClip {values.farClip:g} m is not allowed; it must be above nearClip, {values.nearClip:g} m")
    width, height = map(int, values.imageSize)
    if width * height * 3 > most:
        node.error(f"imageSize {width} {height} is not allowed; the interface holds {most // 3} pixels")


def make_eye(model: Model, values: CameraAttributes) -> Eye:
    """The rendering camera of a model; the first one of a world creates an OpenGL context.

    Raises:
        LibraryError: OpenGL is not available.
    """
    width, height = map(int, values.imageSize)
    eye = Eye(model.world, width, height, near=values.nearClip, far=values.farClip)
    eye.options.displaySkins = True
    set_view(model, eye, values.hfov)
    return eye


def eye_of(model: Entity) -> Eye | None:
    """The rendering camera of a camera model, the left one of two; None if it has none, or none yet."""
    for owner in (model, getattr(model, "camera", None)):
        eye = getattr(owner, "eye", None) or getattr(owner, "eyes", {}).get("left")
        if isinstance(eye, Eye):
            return eye
    return None


def set_view(model: Model, eye: Eye, hfov: float) -> None:
    """Set the field of view [rad]: the horizontal one, or with the quirk verticalHfov the vertical one."""
    vertical = "verticalHfov" in model.world.engine.quirks
    eye.SetFOV(horizontal_view(hfov, eye.width, eye.height) if vertical else hfov)


def add_frustum(model: Model, body: Body, values: RobotCameraAttributes, pose: GzPose) -> FrustrumGeom | None:
    """The view frustum that observers can display, at a pose on a body; None if the worldfile disables it."""
    if not values.useFrustrum or values.farClip <= values.nearClip:
        return None
    width, height = values.imageSize[:2]
    frustum = FrustrumGeom(body, model.modelSpaceId, width / height, values.nearClip, values.farClip)
    frustum.SetFOV(values.hfov)
    frustum.SetRelativePose(pose, updateCoM=False)
    return frustum


class FrameSaver:
    """Writes numbered images, 0000.pnm and on, to a directory, which is created with the first one."""

    STATE: ClassVar[tuple[str, ...]] = ("count",)

    def __init__(self, directory: str) -> None:
        self.directory = Path(directory)
        self.count = 0
        self._failed = False

    def save(self, image: NDArray[np.uint8]) -> None:
        """Write one image; a failure is logged once, and the frame is skipped."""
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            write_pnm(self.directory / f"{self.count:04d}.pnm", image)
        except (GazeboError, OSError) as error:
            if not self._failed:
                log.error("%s", error)
            self._failed = True
        self.count += 1


class CameraServer:
    """The camera of a model: renders images at its rate of sim time, serves them through `camera`, and saves them.

    Attributes:
        eye: the rendering camera, with `image`, `depth` and `segmentation`; None before `Init` and after `Fini`.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "saver")

    def __init__(self, model: Model, values: CameraAttributes) -> None:
        self.model, self.values = model, values
        self.interface = Camera()
        self.rate = UpdateRate(values.updateRate)
        self.saver = FrameSaver(values.savePath)
        self.eye: Eye | None = None
        self._taken: float | None = None  # time of the image that is not published yet [s]

    def Init(self) -> None:
        """Create the rendering camera and the interface.

        Raises:
            LibraryError: OpenGL is not available.
            ParameterError: the image does not fit into the interface of this wire version.
        """
        model = self.model
        self.eye = make_eye(model, self.values)
        serve(model, self.interface)
        width, height = self.eye.GetImageSize()
        capacity = self.interface.array("image").size
        if width * height * 3 > capacity:  # only in version 0x050, whose limit is below that of check_optics
            raise ParameterError(
                f"model {model.GetId()!r}: imageSize {width} {height} is not allowed; "
                f"the camera interface of this wire version holds {capacity // 3} pixels"
            )
        self.interface.data.width, self.interface.data.height = width, height

    def plan_update(self, plan: Plan, look: Callable[[], None]) -> None:
        """Add to a model's plan that an image is taken when one is due.

        Args:
            plan: of the model.
            look: calls `take` with the pose and the field of view of that moment.
        """
        eye = self.eye
        if eye is None or eye.blind:
            return
        if eye.threaded:
            plan.call(self._publish_ready)
        with plan.due(self.rate):
            plan.call(look)

    def take(self, pose: GzPose, hfov: float) -> None:
        """Begin an image from a global pose [m] with a field of view [rad]; in a step, it is served at its end."""
        eye = self.eye
        if eye is None:
            return
        self._publish_taken()
        set_view(self.model, eye, hfov)
        eye.SetPose(pose)
        eye.Start()
        self._taken = self.model.world.GetSimTime()
        if not eye.threaded:
            self.model.world.agenda.after_step(self._publish_taken, eye.pending)

    def _publish_ready(self) -> None:
        """Publish the image that is being rendered beside the world, once it is complete."""
        if self.eye is not None and self.eye.ready:
            self._publish_taken()

    def _publish_taken(self) -> None:
        """Publish the image that is not published yet, if there is one, when it is complete."""
        if self._taken is not None and self.eye is not None:
            self._publish(self.eye, self._taken)

    def _publish(self, eye: Eye, taken: float) -> None:
        """Serve and save the image of a sim time [s]."""
        self._taken = None
        image = eye.Finish()
        if self.interface.lock():  # rendered before, so that clients wait for the copy only
            self.interface.array("image")[: image.size] = image.reshape(-1)
            data = self.interface.data
            data.width, data.height = eye.GetImageSize()  # a client may have overwritten it
            data.image_size = image.size
            data.time = taken
            self.interface.unlock()
            self.interface.post()
        if self.values.saveFrames:
            self.saver.save(image)

    def SaveState(self) -> object:
        """Nothing: an image that is not published yet is published now."""
        self._publish_taken()
        return None

    def LoadState(self, state: object) -> None:
        """Drop an image that is not published yet."""
        if self.eye is not None and self._taken is not None:
            self.eye.Finish()
        self._taken = None

    def Fini(self) -> None:
        """Destroy the interface and the rendering camera."""
        self._publish_taken()
        if self.eye is not None:
            self.eye.close()
            self.eye = None
        self.interface.destroy()
