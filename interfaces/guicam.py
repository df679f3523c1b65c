"""guicam: a camera that is moved with the mouse."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.views import image, unused
from libgz.physics.check import finite_tuple
from libgz.transport.interface import Interface, View
from libgz.transport.layout import BOTH, CLIENT, SERVER, Array, Data, byte, double, int32, layout, uint32
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GAZEBO_GUICAM_MAX_IMAGE_SIZE",
    "Guicam",
    "GuicamData",
    "gz_guicam_alloc",
    "gz_guicam_close",
    "gz_guicam_create",
    "gz_guicam_destroy",
    "gz_guicam_free",
    "gz_guicam_lock",
    "gz_guicam_open",
    "gz_guicam_post",
    "gz_guicam_unlock",
]


GAZEBO_GUICAM_MAX_IMAGE_SIZE = 1024 * 768 * 3


@layout
class GuicamData(Data):
    """gz_guicam_data_t."""

    sim_time: float = double(SERVER, "s", "sim time of the last update")
    pause_time: float = double(SERVER, "s", "pause time of the last update")
    pos: Array[float] = double(SERVER, "m", "position of the camera: x, y, z", 3)
    rot: Array[float] = double(SERVER, "rad", "rotation of the camera: roll, pitch, yaw", 3)
    cmd_spot_mode: int = int32(CLIENT, "", "effect of dragging: 0 translate, 1 zoom, 2 rotate")
    cmd_spot_state: int = int32(CLIENT, "", "1 while dragging, else 0")
    cmd_spot_a: Array[float] = double(CLIENT, "px", "start of the drag: x, y", 2)
    cmd_spot_b: Array[float] = double(CLIENT, "px", "current position of the drag: x, y", 2)
    roll_lock: int = int32(BOTH, "", "1: keep the camera level")
    display_bbox: int = int32(BOTH, "", "1: render bounding boxes")
    display_axes: int = int32(BOTH, "", "1: render the axes of named bodies")
    display_com: int = int32(BOTH, "", "1: render centres of mass")
    display_skins: int = int32(BOTH, "", "1: render skins instead of collision shapes")
    display_rays: int = int32(BOTH, "", "1: render the rays of lasers and sonars")
    display_frustrums: int = int32(BOTH, "", "1: render the frustums of cameras")
    display_materials: int = int32(BOTH, "", "1: render colours")
    display_textures: int = int32(BOTH, "", "1: render textures")
    polygon_fill: int = int32(BOTH, "", "1: fill polygons; 0: render their edges only")
    shade_smooth: int = int32(BOTH, "", "1: smooth shading; 0: flat shading")
    save_frames: int = int32(BOTH, "", "1: save every image, at a client's request at most 1000")
    width: int = uint32(SERVER, "px", "width of the image")
    height: int = uint32(SERVER, "px", "height of the image")
    image: Array[int] = byte(
        SERVER, "", "red, green, blue; top row first", GAZEBO_GUICAM_MAX_IMAGE_SIZE, used="image_size"
    )
    image_size: int = uint32(SERVER, "byte", "bytes of the image")


class Guicam(Interface[GuicamData]):
    """An observer's camera."""

    type = "guicam"
    data_class = GuicamData

    pos = View("pos")
    rot = View("rot")
    all_pixels = View("image")

    @property
    def sim_time(self) -> float:
        """Sim time of the last update [s]."""
        return self.data.sim_time

    @property
    def gap(self) -> tuple[int, int]:
        """The bytes of the image that are not used."""
        return unused(self, "image", self.data.image_size)

    @property
    def image(self) -> NDArray[np.uint8]:
        """The image, shape (height, width, 3), top row first, empty until there is one; a view of the shared memory."""
        return image(self.all_pixels, self.data.width, self.data.height, self.data.image_size)

    def drag(self, mode: int, start: tuple[float, float], now: tuple[float, float]) -> None:
        """Drag the mouse until `release` is called.

        Args:
            mode: 0 translates, 1 zooms, 2 rotates.
            start: where the drag began: x, y [px].
            now: where the drag is: x, y [px].

        Raises:
            ParameterError: a number is NaN or infinite.
        """
        first, last = finite_tuple(start, 2, "start [px]"), finite_tuple(now, 2, "now [px]")
        with self.locked() as data:
            data.cmd_spot_mode = mode
            data.cmd_spot_a[:], data.cmd_spot_b[:] = first, last
            data.cmd_spot_state = 1

    def release(self) -> None:
        """End the drag; the camera keeps its pose."""
        with self.locked() as data:
            data.cmd_spot_state = 0


_functions = LegacyFunctions(Guicam)
gz_guicam_alloc = _functions.alloc
gz_guicam_free = _functions.free
gz_guicam_create = _functions.create
gz_guicam_destroy = _functions.destroy
gz_guicam_open = _functions.open
gz_guicam_close = _functions.close
gz_guicam_lock = _functions.lock
gz_guicam_unlock = _functions.unlock
gz_guicam_post = _functions.post
