"""Pixels: reads images from OpenGL; natively (pixels.c) where that was built, in a third of Mesa's time."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from libgz.rendering.gl import Constant
from libgz.rendering.tape import Tape

__all__ = ["PixelReader"]


class PixelReader:
    """Reads the image in one context's current framebuffer."""

    def __init__(self, gl: Tape, native: ctypes.CDLL | None) -> None:
        self._gl = gl
        self._drop_alpha: Callable[..., None] | None = None
        if native is not None:
            self._drop_alpha = gl.recorder(ctypes.cast(native.gz_drop_alpha, ctypes.c_void_p).value or 0, "ppi")
        self._raw = np.empty((0, 0, 4), dtype=np.uint8)

    def read(self, image: NDArray[np.uint8]) -> None:
        """Fill an image, shape (height, width, 3), from GL's lower left corner on."""
        height, width, _ = image.shape
        area = (0, 0, width, height)
        if self._drop_alpha is None:
            self._gl.glReadPixels(*area, Constant.RGB, Constant.UNSIGNED_BYTE, image)
            return
        if self._raw.shape[:2] != (height, width):
            self._raw = np.empty((height, width, 4), dtype=np.uint8)
        # Mesa copies RGBA as it is, but converts RGB pixel by pixel.
        self._gl.glReadPixels(*area, Constant.RGBA, Constant.UNSIGNED_BYTE, self._raw)
        self._drop_alpha(self._raw, image, width * height)
