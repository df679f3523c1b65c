"""Launch: what the installed commands call."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["gazebo", "gzclient", "gzserver", "importing", "libgz"]


@contextmanager
def importing() -> Iterator[None]:
    """Without garbage collection, which would search the same modules in vain many times, and later once in a while."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def gazebo() -> int:
    """The command gazebo."""
    with importing():
        from libgz.apps.gazebo import main
    return main()


def gzclient() -> int:
    """The command gzclient."""
    with importing():
        from libgz.apps.gzclient import main
    return main()


def gzserver() -> int:
    """The command gzserver."""
    with importing():
        from libgz.apps.gzserver import main
    return main()


def libgz() -> int:
    """The command libgz."""
    with importing():
        from libgz.apps.libgz import main
    return main()
