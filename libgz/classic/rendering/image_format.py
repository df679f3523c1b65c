"""Pixel layouts of camera images."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError, nearest

__all__ = ["bytes_per_pixel", "check_format", "pack"]

Pixels = NDArray[np.uint8]  # shape (height, width, 3), red, green, blue

RED, GREEN, BLUE = 0, 1, 2


def _bayer(order: str) -> Callable[[Pixels], NDArray[np.uint8]]:
    """Keep one colour of each pixel, by its place in the 2 x 2 pattern."""
    channels = [{"R": RED, "G": GREEN, "B": BLUE}[letter] for letter in order]

    def convert(pixels: Pixels) -> NDArray[np.uint8]:
        found = np.empty(pixels.shape[:2], dtype=np.uint8)
        for i, channel in enumerate(channels):
            found[i // 2 :: 2, i % 2 :: 2] = pixels[i // 2 :: 2, i % 2 :: 2, channel]
        return found

    return convert


def _rgb(pixels: Pixels) -> Pixels:
    return pixels


def _gray8(pixels: Pixels) -> NDArray[np.uint8]:
    return pixels[:, :, 0]  # not the brightness: OGRE, Gazebo's renderer, keeps red


def _gray16(pixels: Pixels) -> NDArray[np.uint16]:
    return pixels[:, :, 0].astype(np.uint16) * np.uint16(257)  # 255 becomes 65535


def _color16(pixels: Pixels) -> NDArray[np.uint16]:
    return pixels.astype(np.uint16) * np.uint16(257)  # 255 becomes 65535


def _with_alpha(pixels: Pixels) -> Pixels:
    return np.dstack((pixels, np.full(pixels.shape[:2], 255, dtype=np.uint8)))


# Name -> bytes of a pixel, conversion.
FORMATS: dict[str, tuple[int, Callable[[Pixels], NDArray[np.uint8] | NDArray[np.uint16]]]] = {
    "R8G8B8": (3, _rgb),
    "RGB_INT8": (3, _rgb),
    "R8G8B8A8": (4, _with_alpha),
    "RGBA_INT8": (4, _with_alpha),
    "BGRA_INT8": (4, lambda pixels: _with_alpha(pixels[:, :, ::-1])),
    "B8G8R8": (3, lambda pixels: pixels[:, :, ::-1]),
    "BGR_INT8": (3, lambda pixels: pixels[:, :, ::-1]),
    "L8": (1, _gray8),
    "L_INT8": (1, _gray8),
    "L16": (2, _gray16),
    "L_INT16": (2, _gray16),
    "L_UINT16": (2, _gray16),
    "R16G16B16": (6, _color16),
    "RGB_INT16": (6, _color16),
    "RGB_UINT16": (6, _color16),
    "BGR_INT16": (6, lambda pixels: _color16(pixels[:, :, ::-1])),
    **{f"BAYER_{order}8": (1, _bayer(order)) for order in ("RGGB", "BGGR", "GBRG", "GRBG")},
}


def check_format(name: str) -> str:
    """The name of a layout, in capitals.

    Raises:
        ParameterError: there is no such layout.
    """
    found = name.strip().upper()
    if found not in FORMATS:
        raise ParameterError(
            f"there is no image format {name!r}{nearest(found, FORMATS)}; there are {', '.join(FORMATS)}"
        )
    return found


def bytes_per_pixel(name: str) -> int:
    """The number of bytes of a pixel."""
    return FORMATS[name][0]


def pack(pixels: Pixels, name: str) -> bytes:
    """An image in a layout, top row first; numbers of 16 bits have the machine's byte order."""
    return FORMATS[name][1](pixels).tobytes()
