"""Segment: the memory of one interface."""

from __future__ import annotations

import mmap
from dataclasses import dataclass

__all__ = ["Segment"]


@dataclass(frozen=True)
class Segment:
    """Memory that holds an interface's struct, and the file it is mapped from."""

    memory: mmap.mmap | bytearray
    descriptor: int | None = None  # of the file; None for memory of this process
