"""Launch: what the installed commands call."""

from __future__ import annotations

import gc
import importlib
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

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


def _end(number: int, _frame: FrameType | None) -> NoReturn:
    """End the process at once: modules and `__del__` could catch an exception, and no file is open yet, or any more."""
    os._exit(128 + number)


def _launch(name: str) -> int:
    """Import and run a command; a Ctrl-C before or after its run ends the process without a traceback."""
    before = signal.getsignal(signal.SIGINT)
    # Else it is ignored, as by nohup, or the program that calls this has a handler of its own.
    ours = before is signal.default_int_handler and threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, _end)
    with importing():
        command = importlib.import_module(f"libgz.apps.{name}")
    if not ours:
        return int(command.main())
    signal.signal(signal.SIGINT, before)
    try:
        return int(command.main())
    finally:
        signal.signal(signal.SIGINT, _end)


def gazebo() -> int:
    """The command gazebo."""
    return _launch("gazebo")


def gzclient() -> int:
    """The command gzclient."""
    return _launch("gzclient")


def gzserver() -> int:
    """The command gzserver."""
    return _launch("gzserver")


def libgz() -> int:
    """The command libgz."""
    return _launch("libgz")
