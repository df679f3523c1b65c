"""Pictures in files: textures read, frames written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.errors import GazeboError

__all__ = ["pyramid", "read_image", "write_image", "write_pnm"]


def read_image(path: Path) -> NDArray[np.uint8]:
    """A picture of any kind that pillow reads (PNG, JPEG, PPM ...), shape (height, width, 3), top row first.

    Raises:
        GazeboError: the file cannot be read, or is damaged.
    """
    from PIL import Image

    try:
        with Image.open(path) as picture:
            return np.asarray(picture.convert("RGB"))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise GazeboError(f"picture {path} cannot be read: {error}") from None


def pyramid(pixels: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """A picture, and each next one half as wide and high, down to a single pixel."""
    from PIL import Image

    found, picture = [np.ascontiguousarray(pixels)], Image.fromarray(pixels)
    while max(picture.size) > 1:
        width, height = picture.size
        picture = picture.resize((max(width // 2, 1), max(height // 2, 1)), Image.Resampling.BOX)
        found.append(np.ascontiguousarray(picture))
    return found


def write_image(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, shape (height, width, 3), top row first, in the format that the file's name asks for.

    Raises:
        GazeboError: the file cannot be written, or its name asks for no known format.
    """
    from PIL import Image

    try:
        Image.fromarray(pixels).save(path)
    except (OSError, ValueError) as error:
        raise GazeboError(f"picture {path} cannot be written: {error}") from None


def write_pnm(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write a picture, shape (height, width, 3), top row first, as the old server's saved frames are.

    Raises:
        GazeboError: the file cannot be written.
    """
    height, width, _ = pixels.shape
    try:
        path.write_bytes(f"P6\n# Gazebo\n{width} {height}\n255\n".encode() + pixels.tobytes())
    except OSError as error:
        raise GazeboError(f"unable to open file {path} for writing: {error.strerror}") from None
