"""Frames: what a server sends to the process that writes its log, through a pipe."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from enum import IntEnum
from typing import Any, NamedTuple

__all__ = ["END_FRAME", "Frame", "Frames", "Kind", "channel_frame", "frame", "tick_frame", "tick_times"]

_HEAD = struct.Struct("<BHI")  # kind, channel, length of what follows
_TICK = struct.Struct("<qq")


class Kind(IntEnum):
    """What a frame is."""

    TICK = 0  # the times of the messages that follow: of the log and simulated [ns]
    CHANNEL = 1  # a new channel, JSON
    MESSAGE = 2
    END = 3  # of a step
    METADATA = 4  # about the whole log, JSON
    PATCH = 5  # what has changed of an interface; see changes.c


class Frame(NamedTuple):
    """One frame."""

    kind: int
    channel: int
    content: bytes


def frame(kind: int, channel: int, content: bytes) -> bytes:
    """A frame as bytes."""
    return _HEAD.pack(kind, channel, len(content)) + content


END_FRAME = frame(Kind.END, 0, b"")


def tick_frame(log_time: int, sim_time: int) -> bytes:
    """The times [ns] of the messages that follow."""
    return frame(Kind.TICK, 0, _TICK.pack(log_time, sim_time))


def tick_times(content: bytes) -> tuple[int, int]:
    """The times [ns] of a tick."""
    log_time, sim_time = _TICK.unpack(content)
    return log_time, sim_time


def channel_frame(channel: int, **about: Any) -> bytes:
    """A new channel."""
    return frame(Kind.CHANNEL, channel, json.dumps(about).encode())


class Frames:
    """Takes bytes apart into frames."""

    def __init__(self) -> None:
        self._rest = bytearray()

    def feed(self, data: bytes) -> Iterator[Frame]:
        """The frames that are complete now."""
        rest = self._rest
        rest += data
        at = 0
        while at + _HEAD.size <= len(rest):
            kind, channel, length = _HEAD.unpack_from(rest, at)
            end = at + _HEAD.size + length
            if end > len(rest):
                break
            yield Frame(kind, channel, bytes(memoryview(rest)[at + _HEAD.size : end]))
            at = end
        del rest[:at]
