"""Changes: finds what has changed in the memory of interfaces; natively (changes.c), where that was built."""

from __future__ import annotations

import ctypes
import logging
import struct
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.recording.frames import Kind, frame

__all__ = ["Changes", "Piece", "apply_patches"]

log = logging.getLogger("libgz.recording")

_PATCH = struct.Struct("<II")  # offset and length


class _Row(ctypes.Structure):
    """struct row."""

    _fields_ = [
        ("memory", ctypes.c_void_p),
        ("shadow", ctypes.c_void_p),
        ("size", ctypes.c_int64),
        ("channel", ctypes.c_int64),
        ("seen", ctypes.c_int64),
        ("keys", ctypes.c_void_p),
        ("key_count", ctypes.c_int64),
    ]


class Piece(NamedTuple):
    """Memory to look at.

    Attributes:
        memory: a buffer.
        channel: number of its channel in the log.
        keys: offset and size of parts that change whenever something else does, so that the rest need not be compared
            each time; empty to compare everything.
    """

    memory: Any
    channel: int
    keys: tuple[tuple[int, int], ...] = ()


@lru_cache
def _library() -> Any:
    """The native part, or None where it was not built."""
    path = next(iter(sorted(Path(__file__).parent.glob("_changes*.so"))), None)
    if path is None:
        return None
    try:
        library = ctypes.PyDLL(str(path))  # it takes less time than to release the interpreter lock
    except OSError as error:
        log.debug("changes are found in Python: %s", error)
        return None
    library.gz_changes.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p, ctypes.c_int64]
    library.gz_changes.restype = ctypes.c_int64
    return library


class Changes:
    """Looks at pieces of memory.

    Args:
        pieces: of memory.
        former: an object that looked before, at some of them. A channel always has pieces of one size.
        native: whether the native part is used, if there is one.
    """

    def __init__(self, pieces: list[Piece], former: Changes | None = None, native: bool = True) -> None:
        self._memories = [np.frombuffer(piece.memory, dtype=np.uint8) for piece in pieces]
        self._channels = [piece.channel for piece in pieces]
        self._keys = [np.array(piece.keys, dtype=np.int64).reshape(-1, 2) for piece in pieces]
        self._turn = 0
        # By channel: address of the memory, and what it was at the last look, which is what the writer has.
        self.shadows: dict[int, tuple[int, NDArray[np.uint8]]] = dict(former.shadows) if former is not None else {}
        self._seen: list[bool] = []
        for memory, channel in zip(self._memories, self._channels, strict=True):
            address, shadow = self.shadows.get(channel, (0, np.zeros_like(memory)))
            self._seen.append(address == memory.ctypes.data)
            self.shadows[channel] = memory.ctypes.data, shadow
        self._library = _library() if native else None
        if self._library is not None:
            self._prepare()

    def _prepare(self) -> None:
        self._rows = (_Row * len(self._memories))(
            *(
                _Row(
                    memory.ctypes.data,
                    self.shadows[channel][1].ctypes.data,
                    len(memory),
                    channel,
                    seen,
                    keys.ctypes.data,
                    len(keys),
                )
                for memory, channel, seen, keys in zip(
                    self._memories, self._channels, self._seen, self._keys, strict=True
                )
            )
        )
        most = sum(len(memory) + len(memory) // 8 + 64 for memory in self._memories)
        self._out = (ctypes.c_char * max(most, 1))()
        self._view = memoryview(self._out).cast("B")
        self._arguments = ctypes.addressof(self._rows), len(self._memories), ctypes.addressof(self._out)

    def take(self) -> bytes | memoryview:
        """The frames of what has changed since the last call; valid until the next one."""
        if self._library is not None:
            self._turn += 1
            return self._view[: self._library.gz_changes(*self._arguments, self._turn)]
        found = []
        for i, (memory, channel) in enumerate(zip(self._memories, self._channels, strict=True)):
            now, shadow = memory.tobytes(), self.shadows[channel][1]
            if self._seen[i] and now == shadow.tobytes():
                continue
            self._seen[i] = True
            shadow[:] = np.frombuffer(now, dtype=np.uint8)
            found.append(frame(Kind.PATCH, channel, _PATCH.pack(0, len(now)) + now))
        return b"".join(found)


def apply_patches(target: bytearray, patches: bytes) -> None:
    """Write what has changed into a copy of the memory."""
    at = 0
    while at < len(patches):
        offset, length = _PATCH.unpack_from(patches, at)
        at += _PATCH.size
        target[offset : offset + length] = patches[at : at + length]
        at += length
