"""Views of the filled part of an interface's arrays."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

__all__ = ["filled", "image"]


def filled(array: NDArray[Any], count: int) -> NDArray[Any]:
    """A view of the first `count` elements, of all if there are fewer; empty if the count is negative.

    Args:
        array: the interface's whole array.
        count: how many elements the server has filled.
    """
    return array[: max(count, 0)]


def image(pixels: NDArray[Any], width: int, height: int, size: int, channels: int = 3) -> NDArray[Any]:
    """A view of shape (height, width, channels), or (height, width) for one channel; empty if there is no image.

    Args:
        pixels: the interface's whole array.
        width: of the image [px].
        height: of the image [px].
        size: how many elements of the array the server has filled.
        channels: values per pixel.
    """
    count = width * height * channels
    if not 0 < count <= min(size, len(pixels)):
        width = height = count = 0
    shape = (height, width, channels) if channels > 1 else (height, width)
    return pixels[:count].reshape(shape)
