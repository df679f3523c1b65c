"""Segment: the memory of one interface."""

from __future__ import annotations

import errno
import mmap
import resource
from typing import NamedTuple

__all__ = ["Segment", "file_limit_hint", "raise_file_limit"]

_SPARE = 128  # open files, for what else a process opens


class Segment(NamedTuple):
    """Memory that holds an interface's struct, and the file it is mapped from."""

    memory: mmap.mmap | bytearray
    descriptor: int | None = None  # of the file; None for memory of this process


def raise_file_limit(descriptor: int) -> None:
    """Raise this process's limit of open files if it is near: each interface takes two of the usual 1024.

    Args:
        descriptor: of a file that was just opened.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft not in (hard, resource.RLIM_INFINITY) and descriptor + _SPARE > soft:
        most = 2 * (descriptor + _SPARE)
        resource.setrlimit(resource.RLIMIT_NOFILE, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))


def file_limit_hint(error: OSError) -> str:
    """What is short if a file could not be opened because there are too many."""
    if error.errno != errno.EMFILE:
        return ""
    return f"; each interface takes two, of {resource.getrlimit(resource.RLIMIT_NOFILE)[1]} that this process may have"
