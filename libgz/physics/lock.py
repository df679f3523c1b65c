"""WorldLock: lets one thread at a time change a world or step it.

One lock per world, held by a step and by all that changes the engine: a method that calls a changing function of ODE,
or edits a table, is `@exclusive`, a constructor `@built`; so is what reads a stale row, or from ODE itself. The native
step releases the interpreter lock; ODE aborts if anything changes meanwhile. Take no other lock, and wait for no
thread, while holding it. `exclusive` compiles a wrapper with the method's own parameters, and in a step finds the lock
held: 0.1 us. `World.step` keeps the lock from one step to the next unless a thread waits: to take and release it costs
1,300 instructions, 0.5 % of a step of one robot and 1.6 % of one of ten sleeping boxes.
"""

from __future__ import annotations

import functools
import inspect
import math
import os
import re
import sys
import threading
import time
from collections.abc import Callable
from ctypes import c_int64
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

from libgz.base.errors import ClosedError
from libgz.base.waiting import PERIOD

__all__ = ["WorldLock", "built", "exclusive"]

LONG = 5.0  # [s] of waiting, after which it is reported
_YIELD = 0.1  # [s] at most that a step waits for threads that were waiting first
_OWNER = re.compile(r"owner=(\d+)")

P = ParamSpec("P")
R = TypeVar("R")


class WorldLock:
    """A re-entrant lock. A step holds it, and so does every call that changes the world, for as long as it takes.

    Several calls become one change, between two steps, with::

        with world.lock:
            robot.SetPose(pose)
            robot.GetBody().SetLinearVel((1, 0, 0))

    Attributes:
        waiting: threads that wait for it, by their numbers, and since when [s]; a step lets them pass first.
        wanted: not 0 if one has begun to wait, or interrupted, since it was last set to 0; for native code.
        interrupt: sets that to 1, so that native code ends its steps after the present one, or its wait for the next:
            something else has to be done between them.
        report: called once by a thread that has waited for 5 s, with the number of the thread that holds the lock.
        owned: whether the calling thread holds it.
        release: end what `try_acquire` or `acquire` began.
    """

    def __init__(self) -> None:
        lock = threading.RLock()
        self._lock, self._process = lock, os.getpid()
        self.try_acquire = functools.partial(lock.acquire, False)
        self.release: Callable[[], None] = lock.release
        self.owned: Callable[[], bool] = lock._is_owned  # type: ignore[attr-defined]
        self.waiting: dict[int, float] = {}
        self.wanted = c_int64(0)
        self.interrupt: Callable[[], object] = functools.partial(setattr, self.wanted, "value", 1)
        self.report: Callable[[int], object] | None = None

    def acquire(self) -> None:
        """Wait until no other thread holds the lock, and hold it."""
        if not self.try_acquire():
            self.wait()

    def wait(self, patience: float = math.inf) -> bool:
        """Hold the lock, which another thread holds, as soon as it is released; False if it is not in that time [s].

        Raises:
            ClosedError: this process was forked while another thread held it, and has no such thread.
        """
        me = threading.get_ident()
        self.waiting[me] = begin = time.monotonic()
        self.interrupt()
        due = begin + LONG
        try:
            while not self._lock.acquire(timeout=PERIOD):
                if time.monotonic() >= begin + patience:
                    return False
                if self._lost():
                    raise ClosedError(
                        "this process was forked while another thread stepped or changed the world, which cannot be "
                        "used here; fork between steps"
                    )
                if time.monotonic() >= due:
                    due = math.inf
                    if self.report is not None:
                        self.report(self.holder)
            return True
        finally:
            self.waiting.pop(me, None)

    def _lost(self) -> bool:
        """Whether the thread that holds the lock is one of the process from which this one was forked."""
        return os.getpid() != self._process and self.holder not in (0, *sys._current_frames())

    def give_way(self) -> None:
        """Let those that wait now hold the lock first: a thread that steps without a pause would keep it for ever."""
        if self.owned():
            return
        first, end = dict(self.waiting), time.monotonic() + _YIELD
        while time.monotonic() < end and any(self.waiting.get(thread) == since for thread, since in first.items()):
            time.sleep(2e-5)

    def pass_on(self) -> None:
        """Let those that wait now hold the lock, which this thread holds, and take it again."""
        self.release()
        try:
            self.give_way()
        finally:
            self.acquire()

    @property
    def holder(self) -> int:
        """The number of the thread that holds the lock; 0 if none does."""
        found = _OWNER.search(repr(self._lock))  # Python offers it nowhere else, and to note it would cost each call
        return int(found[1]) if found is not None else 0

    def __enter__(self) -> None:
        self.acquire()

    def __exit__(self, *_error: object) -> None:
        self.release()


class _HasLock(Protocol):
    lock: WorldLock


class _HasEngine(Protocol):
    @property
    def engine(self) -> Any:
        """The ODE world."""


T = TypeVar("T", bound=_HasEngine)


_LINE = sys._getframe().f_lineno  # tracebacks show the lines of this text
_EXCLUSIVE = """
def made(method):
    def call({passed}):
        lock = self.engine.lock
        if lock.owned():
            return method({passed})
        if not lock.try_acquire():
            lock.wait()
        try:
            return method({passed})
        finally:
            lock.release()
    return call
"""


@functools.cache
def _wrapper(count: int) -> Callable[[Any], Any]:
    """What makes a method with so many parameters one that holds the lock.

    To pack and unpack any arguments would cost three times as much in each call.
    """
    values: dict[str, Any] = {"__name__": __name__}
    passed = ", ".join(["self", *(f"argument{number}" for number in range(1, count))])
    exec(compile("\n" * _LINE + _EXCLUSIVE.format(passed=passed), __file__, "exec"), values)
    made: Callable[[Any], Any] = values["made"]
    return made


def exclusive(method: Callable[Concatenate[T, P], R]) -> Callable[Concatenate[T, P], R]:
    """Decorate a method of a part of a world that changes it: it holds the world's lock.

    In a step, whose thread holds it already, that costs 0.1 us a call.
    """
    code = method.__code__
    count, names = code.co_argcount, code.co_varnames
    if code.co_kwonlyargcount or code.co_flags & (inspect.CO_VARARGS | inspect.CO_VARKEYWORDS):
        return _exclusive_with_keywords(method)
    call: Any = _wrapper(count)(method)
    # Arguments can be given by their names. To compile a wrapper for each method would take 0.2 ms.
    call.__code__ = call.__code__.replace(co_varnames=(*names[:count], *call.__code__.co_varnames[count:]))
    call.__defaults__ = method.__defaults__
    wrapped: Callable[Concatenate[T, P], R] = functools.wraps(method)(call)
    return wrapped


def _exclusive_with_keywords(method: Callable[Concatenate[T, P], R]) -> Callable[Concatenate[T, P], R]:
    """The same for any parameters."""

    @functools.wraps(method)
    def call(self: T, *args: P.args, **kwargs: P.kwargs) -> R:
        with self.engine.lock:
            return method(self, *args, **kwargs)

    wrapped: Any = call
    return wrapped  # type: ignore[no-any-return]


def built(constructor: Callable[P, None]) -> Callable[P, None]:
    """Decorate a constructor whose first argument is, or is a part of, the world in which it builds something."""

    @functools.wraps(constructor)
    def build(*args: P.args, **kwargs: P.kwargs) -> None:
        values = (*args[1:2], *kwargs.values())
        engine = next((value.engine for value in values if hasattr(value, "engine")), None)
        if engine is None:
            constructor(*args, **kwargs)  # raises what is wrong with the arguments
            return
        with engine.lock:
            constructor(*args, **kwargs)

    return build
