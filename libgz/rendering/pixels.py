"""Pixels: reads images from OpenGL; natively (pixels.c) where that was built, in a third of Mesa's time."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from libgz.rendering.gl import GL, Constant
from libgz.rendering.native import address, find_native

__all__ = ["PixelReader", "find_drop_alpha"]

DropAlpha = Callable[[int, int, int], None]  # from address, to address, number of pixels


def find_drop_alpha() -> DropAlpha | None:
    """The native function, or None where it was not built."""
    native = find_native()
    if native is None:
        return None
    function = native.gz_drop_alpha
    function.argtypes, function.restype = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t], None
    return function


class PixelReader:
    """Reads the image in one context's current framebuffer."""

    def __init__(self, gl: GL) -> None:
        self._gl, self._drop_alpha = gl, find_drop_alpha()
        self._raw = np.empty((0, 0, 4), dtype=np.uint8)

    def read(self, image: NDArray[np.uint8]) -> None:
        """Fill an image, shape (height, width, 3), from GL's lower left corner on."""
        height, width, _ = image.shape
        area = (0, 0, width, height)
        if self._drop_alpha is None:
            self._gl.glReadPixels(*area, Constant.RGB, Constant.UNSIGNED_BYTE, image.ctypes.data)
            return
        if self._raw.shape[:2] != (height, width):
            self._raw = np.empty((height, width, 4), dtype=np.uint8)
        # Mesa copies RGBA as it is, but converts RGB pixel by pixel.
        self._gl.glReadPixels(*area, Constant.RGBA, Constant.UNSIGNED_BYTE, address(self._raw))
        self._drop_alpha(address(self._raw), address(image), width * height)
