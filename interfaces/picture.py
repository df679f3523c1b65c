"""Pictures in an interface's memory, as arrays."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

__all__ = ["picture"]


def picture(pixels: NDArray[Any], width: int, height: int, size: int, channels: int = 3) -> NDArray[Any]:
    """A view of shape (height, width, channels), or (height, width) for one channel; empty if there is no picture.

    Args:
        pixels: the interface's whole array.
        width, height: [px].
        size: how many elements of the array the server says are filled.
        channels: values per pixel.
    """
    count = width * height * channels
    if not 0 < count <= min(size, len(pixels)):
        width = height = count = 0
    shape = (height, width, channels) if channels > 1 else (height, width)
    return pixels[:count].reshape(shape)
