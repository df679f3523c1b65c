"""CameraPlan: a camera as a `<camera>` element describes it."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzVector
from libgz.classic import msgs
from libgz.classic.common import Image
from libgz.classic.rendering.camera import Camera
from libgz.classic.rendering.image_format import check_format
from libgz.classic.sensors.noise import Noise
from libgz.classic.sensors.read import UNSET, clip, count, first, known_children, number, substituted, wrong
from libgz.rendering.camera import LONGEST_SIDE, MOST_PIXELS
from libgz.rendering.lens import Distortion, Intrinsics, Lens

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.sdf.element import Element

__all__ = ["NARROWEST", "WIDEST", "CameraPlan", "image_message"]

log = logging.getLogger("libgz.classic")

C = TypeVar("C", bound=Camera)

DEFAULT_FORMAT = "R8G8B8"
NARROWEST, WIDEST = 0.01, math.pi - 0.01  # [rad]
NEAREST = 0.01  # [m]


class CameraPlan:
    """The checked values of a `<camera>`.

    Args:
        element: the `<camera>`.
        noise: on its images; None for none.
        depth: whether the clipping distances of `<depth_camera>` apply.
        widest: horizontal field of view that it can have [rad]; a plain lens has less than pi.

    Raises:
        ParameterError: a value is not allowed.
    """

    def __init__(self, element: Element, noise: Noise | None, depth: bool = False, widest: float = WIDEST) -> None:
        self.element, self.noise = element, noise
        self.pose = element.Get(GzPose, "pose")  # in the sensor [m]
        self.hfov = number(element, "horizontal_fov", NARROWEST, widest, "rad")
        image = element.child("image")
        self.width, self.height = (count(image, key, most=LONGEST_SIDE) for key in ("width", "height"))
        most = MOST_PIXELS if widest < math.pi else MOST_PIXELS // 4  # a direction is kept for each pixel
        if self.width * self.height > most:
            size = f"{self.width} x {self.height}"
            raise wrong(image, "width", f"the image has {size} px; {most} px in all are allowed")
        try:
            self.format = check_format(image.Get(str, "format"))
        except ParameterError as error:
            log.warning("%s; the camera uses %s", wrong(image, "format", str(error)), DEFAULT_FORMAT)
            self.format = DEFAULT_FORMAT
        self.lens = self._lens() if widest < math.pi else None
        distances = element.child("clip")
        if depth and "depth_camera" in known_children(element) and element.HasElement("depth_camera"):
            distances = first(element.child("depth_camera"), "clip") or distances
        self.near, self.far = clip(distances, "near", "far", NEAREST)

    def _lens(self) -> Lens | None:
        """What `<lens><intrinsics>` and `<distortion>` do to images; None without them."""
        lens, bent = first(self.element, "lens"), first(self.element, "distortion")
        pinhole = first(lens, "intrinsics")
        intrinsics, distortion = None, None
        if pinhole is not None:
            intrinsics = Intrinsics(*(pinhole.Get(float, key) for key in ("fx", "fy", "cx", "cy", "s")))
        if bent is not None:
            center = bent.Get(GzVector, "center")
            numbers = {key: bent.Get(float, key) for key in ("k1", "k2", "k3", "p1", "p2")}
            distortion = Distortion(**numbers, center=(center.x, center.y))
        if intrinsics is None and not distortion:
            return None
        try:
            return Lens(self.width, self.height, self.hfov, intrinsics, distortion)
        except ParameterError as error:
            substituted(pinhole or self.element, "intrinsics", f"{error}: the lens is not used")
            return None

    def make(self, world: World, name: str, kind: type[C]) -> C:
        """A camera of the given class."""
        camera = kind(world, name, self.width, self.height, self.hfov, self.near, self.far, self.format)
        camera.core.lens = self.lens
        save, noise = first(self.element, "save"), self.noise
        if save is not None and save.Get(bool, "enabled"):
            path = save.Get(str, "path")
            camera.SetSaveFramePathname("" if path in UNSET else path)
            camera.EnableSaveFrame(True)
        if noise is not None and noise.GetNoiseType() != Noise.NONE:
            camera.filters.append(lambda pixels: add_noise(pixels, noise))
        return camera


def add_noise(pixels: NDArray[np.uint8], noise: Noise) -> None:
    """Add noise to an image in place, in shares of full brightness."""
    noisy = noise.apply_all(pixels / 255.0)
    pixels[:] = np.rint(np.clip(noisy, 0.0, 1.0) * 255.0).astype(np.uint8)


def image_message(camera: Camera) -> Any:
    """A camera's last image as a msgs.Image."""
    msg = msgs.Image(width=camera.ImageWidth(), height=camera.ImageHeight())
    msg.pixel_format = Image.ConvertPixelFormat(camera.ImageFormat())
    msg.step = camera.ImageWidth() * camera.ImageDepth()
    msg.data = camera.ImageData()
    return msg
