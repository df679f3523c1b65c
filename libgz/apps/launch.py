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

OWN_FRAME = 1 << 16  # of a command [words]; as much again is left in that piece of memory for those that it calls

Command = Callable[[], int]


def _with_large_stack(command: Command) -> Command:
    """A command whose calls find place for their frames in one piece of memory, which is mapped once.

    CPython maps 16 KB for frames, and unmaps them when the call that needed them returns. Calls that come and go at
    such a border, as those of importlib do while modules import each other, map memory thousands of times.
    """
    command.__code__ = command.__code__.replace(co_stacksize=OWN_FRAME)
    return command


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


def _run(main: Command) -> int:
    """Run a command, in which a Ctrl-C raises KeyboardInterrupt; after it, one ends the process as before it."""
    set_before = signal.getsignal(signal.SIGINT) is _end
    if set_before:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return main()
    finally:
        if set_before:
            signal.signal(signal.SIGINT, _end)
        gc.freeze()  # Python would look through all that is left, and free it piece by piece, before the process ends


@_with_large_stack
def gazebo() -> int:
    """The command gazebo."""
    with importing():
        from libgz.apps.gazebo import main
    return _run(main)


@_with_large_stack
def gz() -> int:
    """The command gz."""
    with importing():
        from libgz.apps.gz import main
    return _run(main)


@_with_large_stack
def gzclient() -> int:
    """The command gzclient."""
    with importing():
        from libgz.apps.gzclient import main
    return _run(main)


@_with_large_stack
def gzserver() -> int:
    """The command gzserver."""
    with importing():
        from libgz.apps.gzserver import main
    return _run(main)


@_with_large_stack
def libgz() -> int:
    """The command libgz."""
    with importing():
        from libgz.apps.libgz import main
    return _run(main)
