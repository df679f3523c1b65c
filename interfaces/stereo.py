"""stereo: the images and disparities of a stereo camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import image
from libgz.transport.interface import View
from libgz.transport.layout import SERVER, Array, byte, double, float32, layout, uint32
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_STEREO_MAX_DISPARITY_SIZE",
    "GAZEBO_STEREO_MAX_RGB_SIZE",
    "Stereo",
    "StereoData",
    "gz_stereo_alloc",
    "gz_stereo_close",
    "gz_stereo_create",
    "gz_stereo_destroy",
    "gz_stereo_free",
    "gz_stereo_lock",
    "gz_stereo_open",
    "gz_stereo_post",
    "gz_stereo_unlock",
]


GAZEBO_STEREO_MAX_RGB_SIZE = 640 * 480 * 3
GAZEBO_STEREO_MAX_DISPARITY_SIZE = 640 * 480


@layout
class StereoData(SampleData):
    """gz_stereo_data_t."""

    time: float = double(SERVER, "s", "sim time of these images")
    width: int = uint32(SERVER, "px", "width of the images")
    height: int = uint32(SERVER, "px", "height of the images")
    left_image_size: int = uint32(SERVER, "byte", "bytes of the left image")
    left_image: Array[int] = byte(
        SERVER, "", "red, green, blue; top row first", GAZEBO_STEREO_MAX_RGB_SIZE, used="left_image_size"
    )
    right_image_size: int = uint32(SERVER, "byte", "bytes of the right image")
    right_image: Array[int] = byte(
        SERVER, "", "red, green, blue; top row first", GAZEBO_STEREO_MAX_RGB_SIZE, used="right_image_size"
    )
    left_disparity_size: int = uint32(SERVER, "", "number of left disparities: width times height")
    left_disparity: Array[float] = float32(
        SERVER, "px", "shift to the right image", GAZEBO_STEREO_MAX_DISPARITY_SIZE, used="left_disparity_size"
    )
    right_disparity_size: int = uint32(SERVER, "", "number of right disparities")
    right_disparity: Array[float] = float32(
        SERVER, "px", "shift to the left image", GAZEBO_STEREO_MAX_DISPARITY_SIZE, used="right_disparity_size"
    )


class Stereo(SampleInterface[StereoData]):
    """A stereo camera's latest images and disparities."""

    type = "stereo"
    data_class = StereoData

    all_left_pixels = View("left_image")
    all_right_pixels = View("right_image")
    all_left_disparities = View("left_disparity")
    all_right_disparities = View("right_disparity")

    @property
    def left_image(self) -> NDArray[np.uint8]:
        """The left image, shape (height, width, 3), top row first; a view of the shared memory."""
        return image(self.all_left_pixels, self.data.width, self.data.height, self.data.left_image_size)

    @property
    def right_image(self) -> NDArray[np.uint8]:
        """The right image, shape (height, width, 3), top row first; a view of the shared memory."""
        return image(self.all_right_pixels, self.data.width, self.data.height, self.data.right_image_size)

    @property
    def left_disparity(self) -> NDArray[np.float32]:
        """Shift of each left pixel in the right image [px], shape (height, width); a view of the shared memory."""
        data = self.data
        return image(self.all_left_disparities, data.width, data.height, data.left_disparity_size, 1)

    @property
    def right_disparity(self) -> NDArray[np.float32]:
        """Shift of each right pixel in the left image [px], shape (height, width); a view of the shared memory."""
        data = self.data
        return image(self.all_right_disparities, data.width, data.height, data.right_disparity_size, 1)


_functions = LegacyFunctions(Stereo)
gz_stereo_alloc = _functions.alloc
gz_stereo_free = _functions.free
gz_stereo_create = _functions.create
gz_stereo_destroy = _functions.destroy
gz_stereo_open = _functions.open
gz_stereo_close = _functions.close
gz_stereo_lock = _functions.lock
gz_stereo_unlock = _functions.unlock
gz_stereo_post = _functions.post
