"""Problems: the errors and warnings of a world, which are logged and can be read, and end a strict world's run."""

from __future__ import annotations

import logging
import threading
import traceback
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from weakref import WeakSet

from libgz.base.errors import Severity, StrictError
from libgz.simulation.plugins import own_traceback

__all__ = ["NOTED", "Problem", "Problems", "note", "note_threads_of"]

log = logging.getLogger("libgz.simulation")

LARGEST = 1000  # entries of a list
NOTED = {"noted": True}  # extra of log messages whose problem was noted by `note`
NOT_THE_WORLDS = ("libgz.transport", "libgz.classic.transport", "libgz.gazebo")  # loggers


class Problem(NamedTuple):
    """An error or warning of a running world.

    Attributes:
        source: the model, plugin or callback; for other messages the logger, such as ``libgz.physics``.
        message: what is wrong, in one line.
        traceback: of the user's own code; empty if there is none.
        severity: ``"error"`` or ``"warning"``.
        where: ``file:line`` of the plugin's element in an SDF file; empty for others.
    """

    source: str
    message: str
    traceback: str
    severity: Severity
    where: str = ""

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        return f"{place}{self.source}: {self.message}" + (f"\n{self.traceback}" if self.traceback else "")


class Problems:
    """What went wrong in a world.

    Args:
        owned: whether the calling thread works for the world: what it logs belongs to the world.
        strict: whether the first error or warning ends the run.
        warnings: whether warnings end it, too.
        time: the sim time [s]; None where there is none.

    Attributes:
        errors, warnings: the problems in order, 1000 each at most.
        count: how many there have been.
        recent: the last 1000 of both: number from 1 on, sim time [s] and problem.
        failure: the first one, if the world is strict.
    """

    def __init__(
        self,
        owned: Callable[[], bool],
        strict: bool,
        warnings: bool = True,
        time: Callable[[], float] | None = None,
    ) -> None:
        self.owned, self.strict, self._time = owned, strict, time
        self.errors: list[Problem] = []
        self.warnings: list[Problem] = []
        self.count = 0
        self.recent: deque[tuple[int, float, Problem]] = deque(maxlen=LARGEST)
        self.failure: Problem | None = None
        self._with_warnings = warnings
        self._raised = False
        _all.add(self)
        root = logging.getLogger("libgz")
        if _collector not in root.handlers:
            root.addHandler(_collector)

    def add(self, problem: Problem) -> None:
        """Add a problem."""
        kept = self.errors if problem.severity == "error" else self.warnings
        if len(kept) < LARGEST:
            kept.append(problem)
        self.count += 1
        self.recent.append((self.count, self._time() if self._time is not None else 0.0, problem))
        if self.strict and self.failure is None and (self._with_warnings or problem.severity == "error"):
            self.failure = problem

    def errors_since(self, count: int) -> list[Problem]:
        """The errors after so many errors and warnings, as far as they are among the last 1000 of both."""
        return [problem for number, _, problem in self.recent if number > count and problem.severity == "error"]

    def check(self, *, again: bool = True) -> None:
        """Raise the first problem of a strict world.

        Args:
            again: also if it was raised before.

        Raises:
            StrictError: there is one.
        """
        if self.failure is not None and (again or not self._raised):
            self._raised = True
            raise StrictError(f"the run ended at its first problem (strict): {self.failure}")


_all: WeakSet[Problems] = WeakSet()


def _add(problem: Problem) -> None:
    for problems in list(_all):
        if problems.owned():
            problems.add(problem)


def note(source: str, what: str, error: BaseException, where: str = "") -> None:
    """Note an error of a user's code in the world that this thread works for; the caller logs it, with `NOTED`."""
    _add(Problem(source, f"{what} failed with {type(error).__name__}: {error}", own_traceback(error), "error", where))


def note_threads_of(path: Path) -> None:
    """Note what threads raise in the code of a plugin file, in the world that this thread works for and loads it.

    A thread does not say who started it: what counts is whether its traceback leads through the file, or for a plugin
    that is a package, through one of its folder.
    """
    path = path.resolve()
    name = str(path.parent) + "/" if path.stem == "__init__" else str(path)
    users = _plugins.setdefault(name, WeakSet())
    users.update(problems for problems in list(_all) if problems.owned())
    if not isinstance(threading.excepthook, _ThreadHook):
        threading.excepthook = _ThreadHook(threading.excepthook)


_plugins: dict[str, WeakSet[Problems]] = {}  # the worlds that use a file, or a folder with a / at its end
_failed_threads: WeakSet[threading.Thread] = WeakSet()


class _ThreadHook:
    """Notes what threads of plugins raise, then calls the hook that it replaced, which prints it."""

    def __init__(self, replaced: Callable[[threading.ExceptHookArgs], object]) -> None:
        self._replaced = replaced

    def __call__(self, args: threading.ExceptHookArgs, /) -> None:
        # Another hook may have replaced this one, and call it.
        if args.thread is not None and args.exc_value is not None and args.thread not in _failed_threads:
            _failed_threads.add(args.thread)
            _note_thread(args.thread.name, args.exc_value)
        self._replaced(args)


def _note_thread(name: str, error: BaseException) -> None:
    if isinstance(error, SystemExit) and error.code in (None, 0):  # `sys.exit()`: the thread has done its work
        return
    files = [frame.filename for frame in traceback.extract_tb(error.__traceback__)]
    for plugin, users in list(_plugins.items()):
        if any(file.startswith(plugin) if plugin.endswith("/") else file == plugin for file in files):
            what = f"it failed with {type(error).__name__}: {error}"
            problem = Problem(f"thread {name!r} of plugin {plugin}", what, own_traceback(error), "error")
            if isinstance(error, SystemExit):  # which Python does not print
                log.error("%s", problem, extra=NOTED)
            for problems in list(users):
                problems.add(problem)


class _Collector(logging.Handler):
    """Notes what the package logs, in the world that the thread works for."""

    def emit(self, record: logging.LogRecord) -> None:
        """Note an error or warning."""
        # A logger with a handler gets none of Python's last resort, which prints messages where nothing is set up.
        if logging.lastResort is not None and not _has_other_handlers(record.name):
            logging.lastResort.handle(record)
        note_record(record)


def note_record(record: logging.LogRecord) -> None:
    """Note an error or warning that the package logs, in the world that this thread works for."""
    noted = getattr(record, "noted", False) or record.name.startswith(NOT_THE_WORLDS)
    if record.levelno < logging.WARNING or noted:
        return
    message, _, rest = record.getMessage().partition("\n")
    _add(Problem(record.name, message, rest, "error" if record.levelno >= logging.ERROR else "warning"))


def _has_other_handlers(name: str) -> bool:
    logger: logging.Logger | None = logging.getLogger(name)
    while logger is not None:
        if any(handler is not _collector for handler in logger.handlers):
            return True
        logger = logger.parent if logger.propagate else None
    return False


_collector = _Collector(logging.WARNING)
