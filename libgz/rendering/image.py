"""Image files: textures are read, frames are written."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.physics.image_files import open_image

__all__ = ["depth_text", "jpeg_text", "pyramid", "read_image", "write_image", "write_pnm"]


def read_image(path: Path, *, alpha: bool = False) -> NDArray[np.uint8]:
    """Read an image of any format that pillow supports (PNG, JPEG, PPM ...), shape (height, width, 3), top row first.

    Args:
        path: of the file.
        alpha: whether there is a fourth channel, with the alpha.

    Raises:
        GazeboError: the file cannot be read, or is damaged.
    """
    with open_image(path) as file:
        return np.asarray(file.convert("RGBA" if alpha else "RGB"))


def pyramid(pixels: NDArray[np.uint8]) -> list[NDArray[np.uint8]]:
    """An image and its halved copies, down to a single pixel."""
    from PIL import Image

    found, image = [np.ascontiguousarray(pixels)], Image.fromarray(pixels)
    while max(image.size) > 1:
        width, height = image.size
        image = image.resize((max(width // 2, 1), max(height // 2, 1)), Image.Resampling.BOX)
        found.append(np.ascontiguousarray(image))
    return found


def write_image(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write an image, shape (height, width, 3), top row first, in the format of the file's suffix.

    Raises:
        GazeboError: the file cannot be written, or its suffix is unknown.
    """
    from PIL import Image

    try:
        Image.fromarray(pixels).save(path)
    except (OSError, ValueError) as error:
        raise GazeboError(f"image {path} cannot be written: {error}") from None


def write_pnm(path: Path, pixels: NDArray[np.uint8]) -> None:
    """Write an image, shape (height, width, 3), top row first, in the old server's format of saved frames.

    Raises:
        GazeboError: the file cannot be written.
    """
    height, width, _ = pixels.shape
    try:
        path.write_bytes(f"P6\n# Gazebo\n{width} {height}\n255\n".encode() + pixels.tobytes())
    except OSError as error:
        raise GazeboError(f"unable to open file {path} for writing: {error.strerror}") from None


def depth_text(depths: NDArray[np.float32], height: int, width: int) -> str:
    """Depths [m] as a JPEG in base64, from white, the nearest, to black, the farthest; empty if there are none yet."""
    if depths.size != height * width:
        return ""
    seen = np.isfinite(depths)
    low, high = (float(depths[seen].min()), float(depths[seen].max())) if seen.any() else (0.0, 0.0)
    share = (high - np.where(seen, depths, high)) / max(high - low, 1e-6)
    return jpeg_text(np.round(255.0 * share).astype(np.uint8).tobytes(), height, width)


def jpeg_text(data: bytes | None, height: int, width: int) -> str:
    """A frame of bytes as JPEG in base64; empty if there is none yet, or it has no colours that a page can show."""
    pixels = np.frombuffer(data or b"", np.uint8)
    channels, rest = divmod(pixels.size, max(height * width, 1))
    if channels not in (1, 3) or rest:
        return ""
    from PIL import Image

    shape, file = (height, width) if channels == 1 else (height, width, 3), io.BytesIO()
    Image.fromarray(pixels.reshape(shape)).convert("RGB").save(file, "JPEG", quality=80)
    return base64.b64encode(file.getvalue()).decode()
