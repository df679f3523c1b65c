"""What all camera models have in common: their attributes, and the pictures they take, serve and save."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.errors import GazeboError, ParameterError
from libgz.geometry import GzPose
from libgz.interfaces.camera import GAZEBO_CAMERA_MAX_IMAGE_SIZE, Camera
from libgz.legacy.model import Model
from libgz.physics.body import Body
from libgz.physics.geoms import FrustrumGeom
from libgz.rendering.camera import Camera as Eye, horizontal_view
from libgz.rendering.image import write_pnm
from libgz.simulation.rate import UpdateRate
from libgz.worldfile.attributes import angle, boolean, integer, length, number, numbers, text
from libgz.worldfile.node import WorldFileNode

__all__ = [
    "CameraAttributes",
    "CameraServer",
    "FrameSaver",
    "RobotCameraAttributes",
    "add_frustum",
    "check_optics",
    "make_eye",
    "set_view",
]

log = logging.getLogger("libgz.models")


@dataclass(frozen=True)
class CameraAttributes:
    """What every camera's element may hold."""

    updateRate: float = number(10.0, unit="Hz", least=0.0, help="pictures per second of sim time")
    imageSize: tuple[float, ...] = numbers(320, 240, unit="px", least=1, help="width and height of the picture")
    hfov: float = angle(60.0, above=0.0, most=179.0, help="horizontal field of view")
    nearClip: float = length(0.5, least=0.01, help="nearest that is drawn")
    farClip: float = length(50.0, above=0.0, help="farthest that is drawn")
    renderMethod: str = text("auto", help="accepted: pictures are always drawn off-screen")
    zBufferDepth: int = integer(16, unit="bit", help="accepted: depth buffers always have 24 bits or more")
    savePath: str = text(".", help="directory for saved pictures")
    saveFrames: bool = boolean(False, help="save every picture")


@dataclass(frozen=True)
class RobotCameraAttributes(CameraAttributes):
    """The same for a camera that others can see."""

    useFrustrum: bool = boolean(True, help="let observers see what the camera sees")


def check_optics(node: WorldFileNode, values: CameraAttributes, most: int = GAZEBO_CAMERA_MAX_IMAGE_SIZE) -> None:
    """Errors of the worldfile if the far clip is not beyond the near one, or a picture is over `most` bytes."""
    if values.farClip <= values.nearClip:
        node.error(f"farClip {values.farClip:g} m is not allowed; it must be above nearClip, {values.nearClip:g} m")
    width, height = map(int, values.imageSize)
    if width * height * 3 > most:
        node.error(f"imageSize {width} {height} is not allowed; the interface holds {most // 3} pixels")


def make_eye(model: Model, values: CameraAttributes) -> Eye:
    """The camera that a model sees through; the first of a world opens an OpenGL context.

    Raises:
        LibraryError: the chosen OpenGL does not work here.
    """
    width, height = map(int, values.imageSize)
    eye = Eye(model.world, width, height, near=values.nearClip, far=values.farClip)
    eye.options.displaySkins = True
    set_view(model, eye, values.hfov)
    return eye


def set_view(model: Model, eye: Eye, hfov: float) -> None:
    """Set the field of view [rad] as the worldfile means it: horizontal, or with the quirk verticalHfov vertical."""
    vertical = "verticalHfov" in model.world.engine.quirks
    eye.SetFOV(horizontal_view(hfov, eye.width, eye.height) if vertical else hfov)


def add_frustum(model: Model, body: Body, values: RobotCameraAttributes, pose: GzPose) -> FrustrumGeom | None:
    """What observers can be shown of a camera's view, from its pose on a body; None if the file wants none."""
    if not values.useFrustrum or values.farClip <= values.nearClip:
        return None
    width, height = values.imageSize[:2]
    frustum = FrustrumGeom(body, model.modelSpaceId, width / height, values.nearClip, values.farClip)
    frustum.SetFOV(values.hfov)
    frustum.SetRelativePose(pose, updateCoM=False)
    return frustum


class FrameSaver:
    """Writes numbered pictures, 0000.pnm and on, into a directory that the first one makes."""

    def __init__(self, directory: str) -> None:
        self.directory = Path(directory)
        self.count = 0
        self._failed = False

    def save(self, image: NDArray[np.uint8]) -> None:
        """Write one picture; where that fails the frame is lost, which is told once."""
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            write_pnm(self.directory / f"{self.count:04d}.pnm", image)
        except (GazeboError, OSError) as error:
            if not self._failed:
                log.error("%s", error)
            self._failed = True
        self.count += 1


class CameraServer:
    """The camera of a model: takes pictures at its rate of sim time, serves them through `camera`, and saves them.

    Attributes:
        eye: the camera itself, with `image`, `depth` and `segmentation`; None before `init` and after `fini`.
    """

    def __init__(self, model: Model, values: CameraAttributes) -> None:
        self.model, self.values = model, values
        self.interface = Camera()
        self.rate = UpdateRate(values.updateRate)
        self.saver = FrameSaver(values.savePath)
        self.eye: Eye | None = None
        self._taken: float | None = None  # when the picture was taken that is not served yet [s]

    def init(self) -> None:
        """Open the eye and make the interface.

        Raises:
            LibraryError: the chosen OpenGL does not work here.
            ParameterError: the interface of this wire version cannot hold such a picture.
        """
        model = self.model
        self.eye = make_eye(model, self.values)
        server = model.world.gz_server
        self.interface.create(server, model.GetId(), model.GetName(), model.GetIntId(), model.GetParentIntId())
        width, height = self.eye.GetImageSize()
        room = self.interface.array("image").size
        if width * height * 3 > room:  # only that of 0x050 is smaller than what check_optics lets through
            raise ParameterError(
                f"model {model.GetId()!r}: imageSize {width} {height} is not allowed; "
                f"the camera interface of this wire version holds {room // 3} pixels"
            )
        self.interface.data.width, self.interface.data.height = width, height

    def update(self, pose: GzPose, hfov: float) -> bool:
        """Take a picture from a global pose [m] with a field of view [rad], if it is time; whether it was."""
        eye, now = self.eye, self.model.world.GetSimTime()
        if eye is None or eye.blind:
            return False
        due = self.rate.due(now)
        if self._taken is not None and (due or eye.ready):
            self._publish(eye, self._taken)
        if due:
            set_view(self.model, eye, hfov)
            eye.SetPose(pose)
            eye.Start()
            self._taken = now
            if not eye.threaded:
                self._publish(eye, now)
        return due

    def _publish(self, eye: Eye, taken: float) -> None:
        """Serve and save the picture that was taken at a sim time [s]."""
        self._taken = None
        image = eye.Finish()
        if self.interface.lock():  # drawn before, so that clients wait for no more than the copy
            self.interface.array("image")[: image.size] = image.reshape(-1)
            self.interface.data.image_size = image.size
            self.interface.data.time = taken
            self.interface.unlock()
            self.interface.post()
        if self.values.saveFrames:
            self.saver.save(image)

    def fini(self) -> None:
        """Take the interface away and close the eye."""
        if self.eye is not None:
            if self._taken is not None:
                self._publish(self.eye, self._taken)
            self.eye.close()
            self.eye = None
        self.interface.destroy()
