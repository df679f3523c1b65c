"""Records: structs that Python and native code share, by which native code does what models do in each step.

Parts of models, such as an odometry or a rate, are subclasses of them, so that both work on the same numbers. Addresses
are plain integers: who makes a struct keeps alive what it points to.
"""

from __future__ import annotations

import ctypes
from ctypes import c_char, c_double, c_int32, c_int64, c_void_p
from enum import IntEnum
from functools import cache
from typing import Any

from libgz.base.errors import LibraryError

__all__ = [
    "BeginRecord",
    "CastRecord",
    "ClockRecord",
    "JobRecord",
    "Kind",
    "LawRecord",
    "LinkRecord",
    "OperationRecord",
    "PaceRecord",
    "PostRecord",
    "PublishRecord",
    "RateRecord",
    "Row",
    "SpanRecord",
    "SwitchRecord",
    "TableRecord",
    "TextRecord",
    "UpdatesRecord",
    "check_sizes",
    "numbers",
]

HEAD_SIZE = 152  # of an interface [byte]; on i386 it is shorter


class Kind(IntEnum):
    """Kinds of rows."""

    PYTHON = 0
    BEGIN = 1
    DUE = 2
    LAW = 3
    CAST = 4
    ADVANCE = 5
    PUBLISH = 6
    POST = 7


@cache
def numbers(count: int) -> Any:
    """The type of an array of so many doubles, which is equal to lists and tuples of the same numbers."""

    def equal(self: Any, other: object) -> Any:
        try:
            values = list(other)  # type: ignore[call-overload]
        except TypeError:
            return NotImplemented
        return list(self) == values

    own = {"__eq__": equal, "__hash__": None, "__repr__": lambda self: repr(list(self))}
    return type("Numbers", (c_double * count,), own)


class TableRecord(ctypes.Structure):
    """`tables` in updates.h: where states are."""

    _fields_ = [
        ("context", c_void_p),
        ("step", c_double),
        ("bodies", c_void_p),
        ("body_state", c_void_p),
        ("body_fresh", c_void_p),
        ("body_size", c_int64),
        ("joints", c_void_p),
        ("joint_state", c_void_p),
        ("joint_fresh", c_void_p),
        ("joint_size", c_int64),
        ("marks", c_void_p),
        ("touched", c_int64),
        ("changes", c_int64),
        ("done", c_int64),
    ]


class ClockRecord(ctypes.Structure):
    """Sim and pause time [s], steps, and when real time began on the monotonic clock [s]."""

    _fields_ = [("sim_time", c_double), ("pause_time", c_double), ("iterations", c_int64), ("_start", c_double)]

    sim_time: float
    pause_time: float
    iterations: int
    _start: float


class SpanRecord(ctypes.Structure):
    """Where clients write in an interface."""

    _fields_ = [("offset", c_int64), ("size", c_int64), ("text", c_int64)]


class LinkRecord(ctypes.Structure):
    """`link_record` in updates.h: the memory of an interface, and what its lock needs."""

    _fields_ = [
        ("memory", c_void_p),
        ("size", c_int64),
        ("descriptor", c_int64),
        ("blocked", c_int64),
        ("attempts", c_int64),
        ("keeps", c_int64),
        ("next_check", c_double),
        ("counts", c_void_p),
        ("seen", c_int64 * 2),
        ("commands", c_void_p),
        ("command_count", c_int64),
        ("kept", c_void_p),
        ("found", c_void_p),
        ("kept_any", c_int64),
        ("exchanges", c_int64),
        ("restored", c_int64),
        ("most_restored", c_int64),
        ("head_size", c_int64),
        ("head", c_char * HEAD_SIZE),
    ]


class Row(ctypes.Structure):
    """One row: its kind, where to continue if a rate is not due or a condition does not hold, and its struct."""

    _fields_ = [("kind", c_int64), ("jump", c_int64), ("part", c_void_p)]


class RateRecord(ctypes.Structure):
    """When something is due: period, last time and tolerance [s]; whether a period has to be exceeded."""

    _fields_ = [("period", c_double), ("last", c_double), ("slack", c_double), ("beyond", c_int64)]

    period: float
    last: float
    slack: float
    beyond: int


class OperationRecord(ctypes.Structure):
    """`operation` in updates.h: what it is, its operands, and its result."""

    _fields_ = [
        ("code", c_int32),
        ("count", c_int32),
        ("strides", c_int32 * 3),
        ("type", c_int32),
        ("one", c_void_p),
        ("two", c_void_p),
        ("three", c_void_p),
        ("result", c_void_p),
    ]


class LawRecord(ctypes.Structure):
    """The operations of a law, the interface under whose lock they are done, and where the number is that says whether
    the rows up to `jump` follow."""

    _fields_ = [("link", c_void_p), ("operations", c_void_p), ("count", c_int64), ("condition", c_void_p)]


class CastRecord(ctypes.Structure):
    """Rays from a body; see `RayScan`."""

    _fields_ = [
        ("body", c_int64),
        ("handle", c_void_p),
        ("frame", c_void_p),
        ("rays", c_void_p),
        ("count", c_int64),
        ("owner", c_int64),
        ("ranges", c_void_p),
        ("rows", c_void_p),
    ]


class SwitchRecord(ctypes.Structure):
    """How often native code ignored other numbers than 0 and 1 since Python counted them, and how often it may."""

    _fields_ = [("ignored", c_int64), ("most_ignored", c_int64)]

    ignored: int
    most_ignored: int


class TextRecord(ctypes.Structure):
    """A text of clients, as it was seen before and as it is found now; where to write the sim time of that."""

    _fields_ = [("seen", c_void_p), ("found", c_void_p), ("size", c_int64), ("time", c_int64)]


class BeginRecord(ctypes.Structure):
    """How a step begins: after how many steps Python looks for bodies that fell; whether sim time grows now."""

    _fields_ = [("period", c_int64), ("at_start", c_int64)]


class PublishRecord(ctypes.Structure):
    """`publishing` in updates.h: states for other processes."""

    _fields_ = [
        ("publication", c_void_p),
        ("numbers", c_void_p),
        ("revision", c_int64),
        ("ready", c_int64),
        ("changes", c_int64),
        ("next_look", c_double),
        ("process", c_int64),
    ]


class PostRecord(ctypes.Structure):
    """A set of semaphores (-1: none), and the values that wake its clients."""

    _fields_ = [("set", c_int64), ("values", c_void_p)]


class UpdatesRecord(ctypes.Structure):
    """All rows, what they share, and whether another thread waits for the world."""

    _fields_ = [("tables", c_void_p), ("clock", c_void_p), ("rows", c_void_p), ("wanted", c_void_p)]


class JobRecord(ctypes.Structure):
    """`job` in crew.h: rows of a world that are done step after step, and a law after them."""

    _fields_ = [
        ("updates", c_void_p),
        ("count", c_int64),
        ("steps", c_int64),
        ("seconds", c_double),
        ("pace", c_void_p),
        ("law", c_void_p),
        ("row", c_int64),
        ("obeyed", c_int64),
        ("next", c_void_p),
    ]

    steps: int
    pace: int | None
    law: int | None
    row: int
    obeyed: int


class PaceRecord(ctypes.Structure):
    """Sim time at a speed: simulated seconds per second of real time since a start on the monotonic clock [s].

    What is further behind than its debt [s] begins anew. Python looks after `longest` [s] of real time at the latest.
    """

    _fields_ = [(name, c_double) for name in ("speed", "start", "simulated", "debt", "longest")]
    speed: float
    start: float
    simulated: float


_MIRRORS: tuple[Any, ...] = (
    *(TableRecord, ClockRecord, SpanRecord, LinkRecord, Row, RateRecord, CastRecord, OperationRecord, LawRecord),
    *(BeginRecord, PublishRecord, PostRecord, UpdatesRecord, SwitchRecord, TextRecord, PaceRecord, JobRecord),
)


def check_sizes(library: ctypes.CDLL) -> None:
    """Check that the structs are those of the native code.

    Raises:
        LibraryError: it was built from another version of updates.h.
    """
    library.gz_updates_sizes.restype = ctypes.POINTER(c_int64)
    sizes = [ctypes.sizeof(mirror) for mirror in _MIRRORS]
    if library.gz_updates_sizes()[: len(sizes) + 1] != [*sizes, 0]:
        raise LibraryError("the native step was built from another version of updates.h; install libgz again")
