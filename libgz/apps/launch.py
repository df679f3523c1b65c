"""Launch: what the installed commands call."""

from __future__ import annotations

import gc
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

__all__ = ["gazebo", "gz", "gzclient", "gzserver", "importing", "libgz"]


@contextmanager
def importing() -> Iterator[None]:
    """For a `with` block that imports a command, which a Ctrl-C ends without a traceback.

    Without garbage collection, which would search the same modules in vain many times, and later once in a while.
    """
    in_main_thread = threading.current_thread() is threading.main_thread()
    # Else it is ignored, as by nohup, or the program that calls this has a handler of its own.
    if in_main_thread and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _end(number: int, _frame: FrameType | None) -> NoReturn:
    """End the process at once: modules and `__del__` could catch an exception, and no file is open yet, or any more."""
    os._exit(128 + number)


def _run(main: Callable[[], int]) -> int:
    """Run a command, in which a Ctrl-C raises KeyboardInterrupt; after it, one ends the process as before it."""
    if signal.getsignal(signal.SIGINT) is not _end:
        return main()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return main()
    finally:
        signal.signal(signal.SIGINT, _end)


def gazebo() -> int:
    """The command gazebo."""
    with importing():
        from libgz.apps.gazebo import main
    return _run(main)


def gz() -> int:
    """The command gz."""
    with importing():
        from libgz.apps.gz import main
    return _run(main)


def gzclient() -> int:
    """The command gzclient."""
    with importing():
        from libgz.apps.gzclient import main
    return _run(main)


def gzserver() -> int:
    """The command gzserver."""
    with importing():
        from libgz.apps.gzserver import main
    return _run(main)


def libgz() -> int:
    """The command libgz."""
    with importing():
        from libgz.apps.libgz import main
    return _run(main)
