"""Sources: the numbers that native updates read in each step."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from libgz.base.errors import ParameterError

__all__ = ["address_of", "check_size"]


def check_size(source: Any, count: int) -> None:
    """Check that a source holds so many doubles.

    Raises:
        ParameterError: it does not.
    """
    if isinstance(source, np.ndarray):
        fits = source.dtype == np.float64 and source.flags.c_contiguous and source.size >= count
    else:
        record = source[0] if isinstance(source, tuple) else source
        first = address_of(source) or 0
        fits = first + 8 * count <= ctypes.addressof(record) + ctypes.sizeof(record)
    if not fits:
        raise ParameterError(f"{count} doubles, one after the other, are needed; the source has fewer or others")


def address_of(source: Any) -> int | None:
    """Where a ctypes object, a field of one, or a numpy array is."""
    if source is None:
        return None
    if isinstance(source, np.ndarray):
        return int(source.ctypes.data)
    if isinstance(source, tuple):
        record, *path = source
        offset = int(getattr(type(record), path.pop(0)).offset) if isinstance(path[0], str) else 0
        return ctypes.addressof(record) + offset + 8 * sum(path)
    return ctypes.addressof(source)
