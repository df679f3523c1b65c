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

from libgz.base.records import LinkRecord
from libgz.recording.frames import END_FRAME, Kind, frame, tick_frame
from libgz.transport.layout import Part

__all__ = ["Changes", "Moments", "Piece", "apply_patches"]

log = logging.getLogger("libgz.recording")

_PATCH = struct.Struct("<II")  # offset and length
_SPARE = 1 << 16  # [byte] that may wait besides a step


class _Row(ctypes.Structure):
    """struct row."""

    _fields_ = [
        ("memory", ctypes.c_void_p),
        ("shadow", ctypes.c_void_p),
        ("size", ctypes.c_int64),
        ("channel", ctypes.c_int64),
        ("seen", ctypes.c_int64),
        ("writes", ctypes.c_void_p),
        ("writes_seen", ctypes.c_int64),
        ("keys", ctypes.c_void_p),
        ("key_count", ctypes.c_int64),
        ("parts", ctypes.c_void_p),
        ("part_count", ctypes.c_int64),
    ]


class _Recorder(ctypes.Structure):
    """struct recorder."""

    _fields_ = [
        ("data", ctypes.c_void_p),
        ("used", ctypes.c_int64),
        ("rows", ctypes.c_void_p),
        ("count", ctypes.c_int64),
        ("turn", ctypes.c_int64),
        ("first", ctypes.c_int64),
        ("log_time", ctypes.c_int64),
        ("sim_time", ctypes.c_int64),
        ("before", ctypes.c_char_p),
        ("after", ctypes.c_char_p),
        ("before_size", ctypes.c_int64),
        ("after_size", ctypes.c_int64),
        ("limit", ctypes.c_int64),
    ]


class Moments(ctypes.Structure):
    """What is known of the steps of a world that is recorded; `struct moments`, which explains the fields."""

    _fields_ = [
        ("time", ctypes.c_double),
        ("due", ctypes.c_double),
        ("period", ctypes.c_double),
        ("sent", ctypes.c_double),
        ("send_period", ctypes.c_double),
        ("send_size", ctypes.c_int64),
        ("step", ctypes.c_void_p),
        ("sim_time", ctypes.c_void_p),
        ("revision", ctypes.c_void_p),
        ("revision_seen", ctypes.c_int64),
    ]

    time: float
    due: float
    sent: float
    revision_seen: int


_STEP, _STEP_AT = struct.Struct("=qqq"), _Recorder.first.offset  # first row and times


class Piece(NamedTuple):
    """Memory to look at.

    Attributes:
        memory: a buffer.
        channel: number of its channel in the log.
        keys: offset and size of parts that change whenever something else does, or that others than the server write,
            so that the rest need not be compared each time; empty to compare everything.
        link: counts the writes of the server, where that is known.
        seen: whether the log has its present content.
        parts: that are compared after a write; empty to compare everything.
    """

    memory: Any
    channel: int
    keys: tuple[tuple[int, int], ...] = ()
    link: LinkRecord | None = None
    seen: bool = False
    parts: tuple[Part, ...] = ()


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
    library.gz_record.argtypes = [ctypes.c_void_p]
    library.gz_record_step.argtypes = [ctypes.c_void_p, ctypes.c_void_p]
    library.gz_record.restype = library.gz_record_step.restype = ctypes.c_int64
    return library


class Changes:
    """Looks at pieces of memory, and keeps frames of what has changed until they are sent.

    Args:
        pieces: of memory; the first one is that of bodies and joints.
        former: an object that looked before, at some of them, and whose frames were sent. A channel of an interface
            always has pieces of one size.
        native: whether the native part is used, if there is one.
    """

    def __init__(self, pieces: list[Piece], former: Changes | None = None, native: bool = True) -> None:
        self._pieces = pieces
        self._memories = [np.frombuffer(piece.memory, dtype=np.uint8) for piece in pieces]
        # By channel: address of the memory, and what it was at the last look, which is what the writer has.
        self.shadows: dict[int, tuple[int, NDArray[np.uint8]]] = dict(former.shadows) if former is not None else {}
        self._seen: list[bool] = []
        for piece, memory in zip(pieces, self._memories, strict=True):
            address, shadow = self.shadows.get(piece.channel, (0, memory))
            if piece.seen:
                address, shadow = memory.ctypes.data, memory.copy()
            elif not address:
                shadow = np.zeros_like(memory)
            self._seen.append(address == memory.ctypes.data)
            self.shadows[piece.channel] = memory.ctypes.data, shadow
        self._frames = bytearray()
        self._library: Any = _library() if native else None
        if self._library is not None:
            self._prepare()

    def _prepare(self) -> None:
        self._keys = [np.array(piece.keys, dtype=np.int64).reshape(-1, 2) for piece in self._pieces]
        self._parts = [np.array(piece.parts, dtype=np.int64).reshape(-1, 4) for piece in self._pieces]
        rows = []
        for i, (piece, memory) in enumerate(zip(self._pieces, self._memories, strict=True)):
            keys, parts, writes = self._keys[i], self._parts[i], None
            if piece.link is not None:
                writes = ctypes.addressof(piece.link) + LinkRecord.exchanges.offset
            shadow = self.shadows[piece.channel][1].ctypes.data
            row = memory.ctypes.data, shadow, len(memory), piece.channel, self._seen[i], writes, -1
            rows.append(_Row(*row, keys.ctypes.data, len(keys), parts.ctypes.data, len(parts)))
        self._rows = (_Row * len(rows))(*rows)
        self._most = sum(len(memory) + len(memory) // 8 + 64 for memory in self._memories) + 64
        self._recorder = _Recorder(None, 0, ctypes.addressof(self._rows), len(rows), 0)
        self._address = ctypes.addressof(self._recorder)
        self._reserve(self._most + _SPARE)

    def _reserve(self, size: int) -> None:
        """Have space for so many bytes; what waits stays."""
        data = (ctypes.c_char * size)()
        if self._recorder.used:
            ctypes.memmove(data, self._recorder.data, self._recorder.used)
        self._data, self._recorder.data = data, ctypes.addressof(data)
        self._recorder.limit = size - self._most

    def record(self, log_time: int, sim_time: int, first: int = 0, before: bytes = b"", after: bytes = b"") -> int:
        """Append the frames of a step to those that wait; returns the number of bytes that wait.

        Args:
            log_time, sim_time: of the step [ns].
            first: the first piece to look at.
            before, after: other frames of this step, before and after those of the pieces.
        """
        if self._library is None:
            return self._record(log_time, sim_time, first, before, after)
        recorder, extra = self._recorder, len(before) + len(after)
        if recorder.used + extra > recorder.limit:
            self._reserve(2 * recorder.used + extra + self._most)
        _STEP.pack_into(recorder, _STEP_AT, first, log_time, sim_time)
        if extra:
            recorder.before, recorder.before_size = before, len(before)
            recorder.after, recorder.after_size = after, len(after)
        waiting: int = self._library.gz_record(self._address)
        if extra:
            recorder.before, recorder.before_size, recorder.after, recorder.after_size = None, 0, None, 0
        return waiting

    def record_step(self, moments: Moments) -> int:
        """`record` for the next step of a world, without other frames.

        Returns:
            1 if it is time to send what waits, 0 if not, -1 if this step is one for `record`.
        """
        if self._library is None:
            return -1
        found: int = self._library.gz_record_step(self._address, ctypes.byref(moments))
        return found

    def _record(self, log_time: int, sim_time: int, first: int, before: bytes, after: bytes) -> int:
        found = [tick_frame(log_time, sim_time), before]
        for i in range(first, len(self._pieces)):
            channel = self._pieces[i].channel
            now, shadow = self._memories[i].tobytes(), self.shadows[channel][1]
            if self._seen[i] and now == shadow.tobytes():
                continue
            self._seen[i] = True
            shadow[:] = np.frombuffer(now, dtype=np.uint8)
            found.append(frame(Kind.PATCH, channel, _PATCH.pack(0, len(now)) + now))
        self._frames += b"".join([*found, after, END_FRAME])
        return len(self._frames)

    def send(self) -> bytes | memoryview:
        """The frames that wait, to be sent before the next call of `record`; they do not wait any more."""
        if self._library is None:
            frames, self._frames = bytes(self._frames), bytearray()
            return frames
        used, self._recorder.used = self._recorder.used, 0
        return memoryview(self._data).cast("B")[:used]


def apply_patches(target: bytearray, patches: bytes) -> None:
    """Write what has changed into a copy of the memory."""
    at = 0
    while at < len(patches):
        offset, length = _PATCH.unpack_from(patches, at)
        at += _PATCH.size
        target[offset : offset + length] = patches[at : at + length]
        at += length
