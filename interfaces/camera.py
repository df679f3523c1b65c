"""camera: the images of a camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import image, unused
from libgz.transport.interface import View
from libgz.transport.layout import SERVER, Array, byte, double, layout, uint32
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_CAMERA_MAX_IMAGE_SIZE",
    "Camera",
    "CameraData",
    "CameraDataOld",
    "gz_camera_alloc",
    "gz_camera_close",
    "gz_camera_create",
    "gz_camera_destroy",
    "gz_camera_free",
    "gz_camera_lock",
    "gz_camera_open",
    "gz_camera_post",
    "gz_camera_unlock",
]


GAZEBO_CAMERA_MAX_IMAGE_SIZE = 640 * 480 * 3


@layout
class CameraData(SampleData):
    """gz_camera_data_t."""

    time: float = double(SERVER, "s", "sim time of this image")
    width: int = uint32(SERVER, "px", "width of the image; set before the first image")
    height: int = uint32(SERVER, "px", "height of the image")
    image_size: int = uint32(SERVER, "byte", "bytes of the image; 0 until the first image")
    image: Array[int] = byte(
        SERVER, "", "red, green, blue; top row first", GAZEBO_CAMERA_MAX_IMAGE_SIZE, used="image_size"
    )


@layout
class CameraDataOld(SampleData):
    """gz_camera_data_t of version 0x050: an image has at most 320 by 240 pixels."""

    time: float = double(SERVER, "s", "sim time of this image")
    width: int = uint32(SERVER, "px", "width of the image; set before the first image")
    height: int = uint32(SERVER, "px", "height of the image")
    image_size: int = uint32(SERVER, "byte", "bytes of the image; 0 until the first image")
    image: Array[int] = byte(SERVER, "", "red, green, blue; top row first", 320 * 240 * 3, used="image_size")


class Camera(SampleInterface[CameraData]):
    """A camera's latest image."""

    type = "camera"
    data_class = CameraData
    older = {0x050: CameraDataOld}

    all_pixels = View("image")

    @property
    def gap(self) -> tuple[int, int]:
        """The bytes of the image that are not used."""
        return unused(self, "image", self.data.image_size)

    @property
    def image(self) -> NDArray[np.uint8]:
        """The image, shape (height, width, 3), top row first, empty until there is one; a view of the shared memory."""
        return image(self.all_pixels, self.data.width, self.data.height, self.data.image_size)


_functions = LegacyFunctions(Camera)
gz_camera_alloc = _functions.alloc
gz_camera_free = _functions.free
gz_camera_create = _functions.create
gz_camera_destroy = _functions.destroy
gz_camera_open = _functions.open
gz_camera_close = _functions.close
gz_camera_lock = _functions.lock
gz_camera_unlock = _functions.unlock
gz_camera_post = _functions.post
