"""What a thread is doing, in words: the model, callback or plugin whose code runs, and the line in it.

- A function that calls users' code is registered with `names` (`libgz/simulation/running_code.py`), so that reports of
  long steps name what runs. `Watchdog` looks at the world from a thread; steps do nothing for it. Where native code
keeps the interpreter lock, `libgz/transport/ending.c` ends the process after the second signal, in a thread without
  Python.
"""

from __future__ import annotations

import functools
import inspect
import logging
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from libgz.physics.engine import Engine
from libgz.physics.lock import LONG
from libgz.simulation.event import Callback, Event

__all__ = ["describe", "describe_thread", "describe_users", "names", "report_wait"]

log = logging.getLogger("libgz.simulation")

_PACKAGE = (str(Path(__file__).parent.parent), str(Path(__file__).resolve().parent.parent))

_named: dict[CodeType, Callable[[Mapping[str, Any]], str]] = {}
_outermost: set[CodeType] = set()


@functools.cache
def _libraries() -> tuple[str, ...]:
    """How the names of files begin that are of no user."""
    import sysconfig  # loads all variables of Python's build

    paths = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    return (*_PACKAGE, *paths, "<frozen ")


def names(function: Callable[..., Any], name: Callable[[Mapping[str, Any]], str], *, outermost: bool = False) -> None:
    """Let a function that calls code of users be named in descriptions.

    Args:
        function: the function.
        name: what it runs, from its local variables.
        outermost: what called it is of no interest.
    """
    code = inspect.unwrap(function).__code__
    _named[code] = name
    if outermost:
        _outermost.add(code)


def describe(frame: FrameType | None) -> str:
    """What runs in a frame or in one that called it: a name, and the innermost line that is not of a library."""
    found = _users(frame)
    if not found and frame is not None:
        found = f"{frame.f_code.co_filename}:{frame.f_lineno}"
    return found or "code that has ended"


def _users(frame: FrameType | None) -> str:
    """The same, if it is code of users; else an empty string."""
    what = place = ""
    while frame is not None:
        code = frame.f_code
        if not what and code in _named:
            what = _named[code](frame.f_locals)
        if not place and not code.co_filename.startswith(_libraries()):
            place = f"{code.co_filename}:{frame.f_lineno}"
        frame = None if code in _outermost else frame.f_back
    return f"{what} ({place})" if what and place else what or place


def describe_thread(number: int) -> str:
    """What runs in a thread."""
    return describe(sys._current_frames().get(number))


def describe_users(number: int) -> str:
    """What runs in a thread, if that is code of users; else an empty string."""
    return _users(sys._current_frames().get(number))


def report_wait(holder: int) -> None:
    """Log that this thread has waited long for a world that another thread holds."""
    known = {thread.ident: thread.name for thread in threading.enumerate()}
    log.error(
        "thread %r has waited %g s for the world, in %s; thread %r holds it, in %s: if that waits for thread %r, "
        "neither will continue",
        threading.current_thread().name,
        LONG,
        describe(sys._getframe(1)),
        known.get(holder, holder),
        describe_thread(holder),
        threading.current_thread().name,
    )


def _callback(values: Mapping[str, Any]) -> str:
    entry = values.get("entry")
    by = f" of {entry.owner}" if entry is not None and entry.owner is not None else ""
    return f"a callback of event {values['self'].name}{by}"


def _function(values: Mapping[str, Any]) -> str:
    by = values["self"]._owner
    return f"{values['self']._what}{f' of {by}' if by is not None else ''}"


def _physics(values: Mapping[str, Any]) -> str:
    return f"the physics step of {len(values['self'].bodies)} bodies"


names(Event.call, _callback)
names(Callback.__call__, _function)
for _part in (Engine.advance, Engine.collide, Engine.solve):
    names(_part, _physics)
