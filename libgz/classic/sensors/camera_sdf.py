"""Cameras as a `<camera>` element describes them."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from libgz.classic.sensors.noise import Noise
from libgz.classic.sensors.read import count, number, wrong
from libgz.errors import ParameterError

if TYPE_CHECKING:
    from libgz.classic.physics import World
    from libgz.classic.rendering.camera import Camera
    from libgz.sdf.element import Element

__all__ = ["CameraPlan", "image_message"]

log = logging.getLogger("libgz.classic")

# Numbers of gazebo.common.Image's pixel formats.
PIXEL_FORMATS = {
    "L8": 1,
    "L_INT8": 1,
    "L16": 2,
    "L_INT16": 2,
    "R8G8B8": 3,
    "RGB_INT8": 3,
    "R8G8B8A8": 4,
    "R16G16B16": 6,
    "RGB_INT16": 6,
    "B8G8R8": 8,
    "BGR_INT8": 8,
    "FLOAT32": 13,
    "BAYER_RGGB8": 15,
    "BAYER_BGGR8": 16,
    "BAYER_GBRG8": 17,
    "BAYER_GRBG8": 18,
}
NARROWEST, WIDEST = 0.01, math.pi - 0.01  # [rad]
NEAREST = 0.01  # [m]


class CameraPlan:
    """What a `<camera>` says, checked.

    Raises:
        ParameterError: a value is not allowed.
    """

    def __init__(self, element: Element, depth: bool = False) -> None:
        from libgz.classic.rendering.image_format import check_format

        self.element = element
        self.hfov = number(element, "horizontal_fov", NARROWEST, WIDEST, "rad")
        image = element.child("image")
        self.width, self.height = count(image, "width"), count(image, "height")
        try:
            self.format = check_format(image.Get(str, "format"))
        except ParameterError as error:
            raise wrong(image, "format", str(error)) from None
        clip = element.child("clip")
        described = element.description.children if element.description is not None else {}
        if depth and "depth_camera" in described and element.HasElement("depth_camera"):
            clip = next(element.child("depth_camera").named("clip"), clip)
        self.near = number(clip, "near", 0.0, unit="m")
        self.far = number(clip, "far", 0.0, unit="m")
        if not self.far > self.near:
            raise wrong(clip, "far", f"is {self.far:g} m; it must be beyond <near>, {self.near:g} m")
        for key in ("distortion", "lens"):
            if element.HasElement(key) and self._matters(element.child(key)):
                log.warning("%s: <%s>: pictures are drawn without it", element.child(key).where, key)

    @staticmethod
    def _matters(element: Element) -> bool:
        return element.name != "distortion" or any(element.Get(float, key) for key in ("k1", "k2", "k3", "p1", "p2"))

    def make(self, world: World, name: str, kind: type[Camera], noise: Noise | None) -> Any:
        """The camera, of a class of `libgz.classic.rendering`."""
        near = max(self.near, NEAREST)
        camera = kind(world, name, self.width, self.height, self.hfov, near, self.far, self.format)
        save = next(self.element.named("save"), None)
        if save is not None and save.Get(bool, "enabled"):
            camera.SetSaveFramePathname(save.Get(str, "path"))
            camera.EnableSaveFrame(True)
        if noise is not None and noise.GetNoiseType() != Noise.NONE:
            camera.filters.append(lambda pixels: add_noise(pixels, noise))
        return camera


def add_noise(pixels: NDArray[np.uint8], noise: Noise) -> None:
    """Add noise to a picture in place; noise is in shares of full brightness."""
    noisy = noise.apply_all(pixels / 255.0)
    pixels[:] = np.rint(np.clip(noisy, 0.0, 1.0) * 255.0).astype(np.uint8)


def image_message(camera: Camera) -> Any:
    """A camera's last picture as a msgs.Image."""
    from libgz.classic import msgs

    msg = msgs.Image(width=camera.ImageWidth(), height=camera.ImageHeight())
    msg.pixel_format = PIXEL_FORMATS[camera.ImageFormat()]
    msg.step = camera.ImageWidth() * camera.ImageDepth()
    msg.data = camera.ImageData()
    return msg
