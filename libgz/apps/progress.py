"""A line on the terminal while a world takes long to load."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TextIO

__all__ = ["show_loading"]

PATIENCE = 2.0  # [s] without a line
PERIOD = 0.5  # [s] between its updates


@contextlib.contextmanager
def show_loading(path: Path, world: object, stream: TextIO | None = None) -> Iterator[None]:
    """For a `with` block that loads a world: if it takes over 2 s, show on a terminal how long, and what is built.

    Args:
        path: the world's file.
        world: what it is loaded into; its `entities` are counted.
        stream: where to; None for stderr. Nothing is shown if it is not a terminal.
    """
    shown = stream or sys.stderr
    if not shown.isatty():
        yield
        return
    done = threading.Event()
    thread = threading.Thread(target=_report, args=(path, world, shown, done), name="libgz loading", daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def _report(path: Path, world: object, stream: TextIO, done: threading.Event) -> None:
    start, width = time.monotonic(), 0
    if done.wait(PATIENCE):
        return
    while not done.wait(PERIOD):
        count = len(getattr(world, "entities", ()))
        built = f"{count} model{'s' * (count != 1)} built" if count else "reading"
        line = f"loading {path}: {time.monotonic() - start:.0f} s, {built}; Ctrl-C ends it"
        stream.write(f"\r{line.ljust(width)}")
        stream.flush()
        width = len(line)
    stream.write(f"\r{' ' * width}\r")
    stream.flush()
