"""The filled part of an interface's arrays, and where the rest is."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from libgz.transport.interface import Interface

__all__ = ["filled", "image", "unused"]


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


def unused(interface: Interface[Any], name: str, count: int) -> tuple[int, int]:
    """Where the bytes of an array behind its first `count` ones begin and end in the struct.

    Args:
        interface: an open interface.
        name: of the array, whose elements are bytes.
        count: how many the server has filled; a client may have overwritten it.
    """
    field = getattr(interface.layout, name)
    return field.offset + min(max(count, 0), field.size), field.offset + field.size
