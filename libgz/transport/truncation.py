"""Truncation: lets a process survive clients that truncate mapped files; natively (truncation.c), where that was built.

Without the native part, the length of a file is restored when its lock is taken, and a truncation in the very moment of
an access ends the process.
"""

from __future__ import annotations

import ctypes
import logging
import mmap
import weakref
from functools import lru_cache
from pathlib import Path

__all__ = ["Watch", "watch"]

log = logging.getLogger("libgz.transport")


class _Counts(ctypes.Structure):
    """struct counts."""

    _fields_ = [("recovered", ctypes.c_int64), ("lost", ctypes.c_int64)]

    recovered: int
    lost: int


class Watch:
    """A watched mapping; it ends when its memory is unmapped.

    Attributes:
        counts: how often access to the memory failed: `recovered`, after which the file was extended, and `lost`, pages
            that clients share no more.
    """

    def __init__(self, library: ctypes.CDLL, memory: mmap.mmap, row: int) -> None:
        self.counts = _Counts.from_address(row)
        self._library, self._row = library, row
        # Views may keep the memory mapped for longer than its interface is open.
        weakref.finalize(memory, library.gz_truncation_forget, row).atexit = False

    def release(self) -> None:
        """The descriptor of the file is about to be closed."""
        self._library.gz_truncation_release(self._row)


@lru_cache
def _library() -> ctypes.CDLL | None:
    """The native part, or None where it was not built."""
    path = Path(__file__).with_name("_truncation.so")
    if not path.exists():
        return None
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        log.warning("truncated interface files can end this process: %s", error)
        return None
    library.gz_truncation_watch.argtypes = [ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int]
    library.gz_truncation_watch.restype = ctypes.c_void_p
    for function in (library.gz_truncation_release, library.gz_truncation_forget):
        function.argtypes = [ctypes.c_void_p]
        function.restype = None
    return library


def watch(memory: mmap.mmap, descriptor: int) -> Watch | None:
    """Survive the truncation of a mapped file from now on; None where that is impossible.

    Args:
        memory: the whole file.
        descriptor: of the file, open for writing; `Watch.release` comes before it is closed.
    """
    library = _library()
    if library is None:
        return None
    address = ctypes.addressof(ctypes.c_char.from_buffer(memory))
    row = library.gz_truncation_watch(address, len(memory), descriptor)
    return None if row is None else Watch(library, memory, row)
