"""The tree of errors. Every message says what is wrong, where, and what is allowed."""

from __future__ import annotations

import dis
import itertools
import logging
import re
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, NamedTuple, Protocol, TypeAlias, TypeVar

from libgz.base.credit import Credit

__all__ = [
    "USER_ERRORS",
    "ClosedError",
    "Diagnostic",
    "Diagnostics",
    "GazeboError",
    "InterfaceError",
    "Interrupted",
    "LibraryError",
    "Located",
    "NotFoundError",
    "ParameterError",
    "Place",
    "PluginError",
    "Remark",
    "ServerError",
    "ServerGoneError",
    "Severity",
    "StateError",
    "StrictError",
    "WorldFileError",
    "advise",
    "explain",
    "listed",
    "nearest",
    "pass_interrupt",
]


class GazeboError(Exception):
    """Root of all errors raised by libgz."""

    def GetErrorStr(self) -> str:
        """The message, by the name of the original API."""
        return str(self)

    def GetErrorFile(self) -> str:
        """The file in which it was raised; an empty string before that."""
        trace = self.__traceback__
        while trace is not None and trace.tb_next is not None:
            trace = trace.tb_next
        return trace.tb_frame.f_code.co_filename if trace is not None else ""


class ParameterError(GazeboError, ValueError):
    """An argument has a value that is not allowed."""


class ClosedError(GazeboError):
    """An object was used after it was closed."""


class NotFoundError(GazeboError, LookupError):
    """A model, body, joint, file or name does not exist."""


class LibraryError(GazeboError, OSError):
    """A shared library is missing or cannot be used."""


class WorldFileError(GazeboError):
    """A worldfile cannot be loaded; the message lists all errors, one line each."""


class PluginError(GazeboError):
    """A plugin file was not found, could not be loaded, or failed."""


class StateError(GazeboError):
    """A state does not fit the world that it is to be set in."""


class StrictError(GazeboError):
    """A strict world had its first error in a model or plugin, or its first warning; the message has the traceback."""


class ServerError(GazeboError):
    """A server cannot start: its id is in use, or its directory cannot be used."""


class InterfaceError(GazeboError):
    """An interface cannot be created, opened or locked."""


class ServerGoneError(InterfaceError):
    """The server ended while a client was connected to it."""


class Interrupted(KeyboardInterrupt):
    """A signal ended the loading of a world; it is no error of libgz. `number` is the signal's."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


# What code of users may raise, also SystemExit or asyncio's CancelledError; `pass_interrupt` lets interrupts through.
USER_ERRORS = (BaseException,)


def pass_interrupt(error: BaseException) -> None:
    """Raise an error again that interrupts the process, and was not raised by a user's code.

    These are a `KeyboardInterrupt` by Ctrl-C, what a signal handler of libgz raises, and what ends a test of pytest,
    such as its time limit. A plugin that calls `sys.exit`, or raises `KeyboardInterrupt` itself, fails like one that
    raises any other exception.
    """
    if isinstance(error, Exception):
        return
    if type(error).__module__.startswith("_pytest."):
        raise error
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        raise error
    code = trace.tb_frame.f_code
    own = Path(code.co_filename).is_relative_to(Path(__file__).parents[1])
    raised = code.co_code[trace.tb_lasti] == dis.opmap["RAISE_VARARGS"]
    if own or (isinstance(error, KeyboardInterrupt) and not raised):
        raise error


class _Allowance:
    """The processor time that suggestions may take: a second, and a tenth of what has passed since it was used up.

    A comparison costs 20 us, so that 10,000 wrong names among 10,000 others would take half an hour.
    """

    def __init__(self) -> None:
        self._credit, self._at = Credit(0.1, 1.0), 0.0

    def begin(self) -> bool:
        """Whether there is any left."""
        self._credit.earn(self._passed())
        return self._credit.left > 0.0

    def end(self) -> None:
        """Take what has passed since `begin`."""
        self._credit.spend(self._passed())

    def _passed(self) -> float:
        before, self._at = self._at, time.process_time()
        return self._at - before


_allowance = _Allowance()
LONGEST_NAME = 200  # characters of names that are compared


def nearest(name: str, known: Iterable[str]) -> str:
    """The end of a message, ``"; did you mean 'x'?"``; an empty string if no known name resembles `name`.

    It is empty, too, where names are long, or thousands of them have been compared just before.
    """
    if len(name) > LONGEST_NAME or not _allowance.begin():
        return ""
    lower = {candidate.lower(): candidate for candidate in known if len(candidate) <= LONGEST_NAME}
    import difflib  # for errors alone

    found = difflib.get_close_matches(name.lower(), lower, n=3, cutoff=0.6)
    _allowance.end()
    if not found:
        return ""
    return "; did you mean " + " or ".join(repr(lower[match]) for match in found) + "?"


MOST_NAMES = 200  # of a list in a message


def listed(names: Iterable[str]) -> str:
    """Names as a list in a message, the first 200 of them: each message of a file would have all; none if empty."""
    found = list(itertools.islice(names, MOST_NAMES + 1))
    return ", ".join([*found[:MOST_NAMES], "..."] if len(found) > MOST_NAMES else found) or "none"


MOST_ALIKE = 5  # warnings of a file that differ only in names, paths and numbers, in a log
# Each alternative looks at a character once only, whatever the message is.
_VARIABLE = re.compile(r"'[^']*'|\[[^\[\]]*\]|[/~][^\s,;]*,?|(?<![^\s'\]])[^\s\d'\]]*\d\S*|; did you mean .*")
MOST_LISTED = 100  # elements without effect that are listed, of each file
MOST_KEPT = {"error": 1000, "warning": 10_000}  # of each file
LONGEST_MESSAGE = 8000  # characters of a message, and
_KEPT_END = 1000  # those of them that are the end of a longer one
UNFORESEEN = "libgz cannot handle it"


def explain(error: BaseException) -> str:
    """What an exception says of an element or file that could not be loaded, in one sentence."""
    if isinstance(error, GazeboError):
        return str(error)
    if isinstance(error, MemoryError):
        return "there is not enough memory for it"
    if isinstance(error, RecursionError):
        return "it is nested too deeply"
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return f"{UNFORESEEN} ({type(error).__name__}: {error}); please report this with the file"


T = TypeVar("T")


def advise(check: Callable[..., T], default: T, *arguments: object) -> T:
    """What a check that only warns returns; where it fails, that is logged, and `default` is returned.

    All checks of loaded worlds run here, so that none can end a load.
    """
    try:
        return check(*arguments)
    except Exception as error:
        name = getattr(check, "__name__", str(check))
        log.warning("the check %s could not look at this world (%s: %s)", name, type(error).__name__, error)
        log.debug("%s", name, exc_info=error)
        return default


Severity: TypeAlias = Literal["error", "warning"]


log = logging.getLogger("libgz")

_PLACED = re.compile(r"(.+?):(\d+): <([^<>]+)>: (.*)")  # str() of a Remark


class Located(Protocol):
    """Something with a place in a file: an element of an SDF file, or a `Place`."""

    @property
    def file(self) -> str:
        """The file's name; may be empty."""

    @property
    def line(self) -> int:
        """The line where it starts, from 1; 0 if it has none."""

    @property
    def name(self) -> str:
        """Its tag."""


class Place(NamedTuple):
    """A place in a file, for what has no element object."""

    file: str
    line: int
    name: str


def _placed(file: str, line: int, element: str, message: str) -> str:
    """``file:line: <element>: message``, without what is unknown."""
    return f"{file}{f':{line}' if line else ''}:{f' <{element}>:' if element else ''} {message}"


class Remark(NamedTuple):
    """A message about a place in a file. `str()` gives ``file:line: <element>: message``, without what is unknown."""

    file: str
    line: int
    element: str
    message: str

    def __str__(self) -> str:
        return _placed(*self)


class Diagnostic(NamedTuple):
    """One error or warning about a worldfile or an SDF file. `str()` gives what that of a `Remark` gives.

    Attributes:
        included: if it is about a file that the checked one includes, the line of that include, from 1; else 0.
    """

    file: str
    line: int
    element: str
    message: str
    severity: Severity
    included: int = 0

    def __str__(self) -> str:
        return _placed(self.file, self.line, self.element, self.message)

    def shortened(self) -> Diagnostic:
        """The same, its message without what is beyond the longest in its middle."""
        text = self.message
        if len(text) <= LONGEST_MESSAGE:
            return self
        return self._replace(message=f"{text[: LONGEST_MESSAGE - _KEPT_END]} ... {text[-_KEPT_END:]}")

    @classmethod
    def at(cls, where: Located, message: str, severity: Severity) -> Diagnostic:
        """The diagnostic of an element; a text without a file name is called ``<string>``.

        It is one line: no part of a name in it looks like a diagnostic of its own.
        """
        return cls(where.file or "<string>", where.line, where.name, message.replace("\n", "\\n"), severity)


@dataclass(eq=False, repr=False)
class Diagnostics:
    """The errors and warnings of one file, in the order in which they were found; each is kept once.

    At most 1000 errors and 10,000 warnings are kept, of 8000 characters each; one more says how many others there are.
    Errors are collected, not raised, so that all are reported together::

        diagnostics.error(element, "must be given")
        diagnostics.warn(element, "has no effect")
        diagnostics.raise_errors()

    `element` is anything with `file`, `line` and `name`, such as `libgz.sdf.element.Element` or `Place`.
    A `WorldFileNode` has its own `error(message)` and `warn(message)`.
    """

    found: dict[Diagnostic, None] = field(default_factory=dict)
    includes: dict[str, int] = field(default_factory=dict)  # included files, and the lines of their first includes
    listed: int = 0  # elements without effect among them
    unlisted: int = 0  # further ones, which are only counted
    most_alike: int = MOST_ALIKE  # warnings of a kind in the summary
    _first_unlisted: Located | None = None
    _kept: Counter[Severity] = field(default_factory=Counter)
    _beyond: Counter[Severity] = field(default_factory=Counter)  # those that are not kept
    _first_beyond: dict[Severity, Diagnostic] = field(default_factory=dict)

    def error(self, where: Located, message: str) -> None:
        """Add an error: the world does not load."""
        self.add(Diagnostic.at(where, message, "error"))

    def warn(self, where: Located, message: str) -> None:
        """Add a warning: the world loads all the same."""
        self.add(Diagnostic.at(where, message, "warning"))

    def no_effect(self, where: Located, describe: Callable[[], str]) -> None:
        """Add a warning about an element that has no effect; beyond the first hundred, they are only counted.

        Args:
            where: the element.
            describe: gives the message; it is not called for what is only counted.
        """
        if self.listed < MOST_LISTED:
            self.listed += 1
            self.warn(where, describe())
        else:
            self._first_unlisted = self._first_unlisted or where
            self.unlisted += 1

    def include(self, other: Diagnostics, file: str, line: int) -> None:
        """Add those of a file that is included in a line."""
        for name in (file, *other.includes):
            self.includes.setdefault(name, line)
        self.add(*other.found)
        self._beyond += other._beyond
        self._first_beyond = other._first_beyond | self._first_beyond
        self.listed += other.listed
        self.unlisted += other.unlisted
        self._first_unlisted = self._first_unlisted or other._first_unlisted

    def failure(self, where: Located, error: BaseException) -> None:
        """Add what the loading of an element raised as an error; a message that names a place itself keeps it."""
        text = explain(error)
        if not isinstance(error, GazeboError):
            log.debug("%s:%d: <%s>", where.file, where.line, where.name, exc_info=error)
        placed = [_PLACED.match(line) for line in text.splitlines()]
        if placed and all(placed):
            known = {(error.file, error.line, error.element) for error in self.errors}
            found = [Diagnostic(m[1], int(m[2]), m[3], m[4], "error") for m in placed if m]
            self.add(*(one for one in found if (one.file, one.line, one.element) not in known))  # else it follows
        else:
            self.add(Diagnostic.at(where, "", "error")._replace(message=text))

    def remark(self, file: str, text: str) -> None:
        """Add a message that was logged, as a warning at the place that it names, or else about the whole file."""
        placed = _PLACED.match(text)
        if placed is not None:
            self.add(Diagnostic(placed[1], int(placed[2]), placed[3], placed[4], "warning"))
        else:
            self.add(Diagnostic(file, 0, "", text, "warning"))

    def add(self, *diagnostics: Diagnostic) -> None:
        """Add diagnostics, such as those of an included file; the known ones are skipped."""
        for one in map(Diagnostic.shortened, diagnostics):
            if one in self.found:
                continue
            if self._kept[one.severity] < MOST_KEPT[one.severity]:
                self._kept[one.severity] += 1
                self.found[one] = None
            else:
                self._beyond[one.severity] += 1
                self._first_beyond.setdefault(one.severity, one)

    def _of(self, severity: Severity) -> list[Diagnostic]:
        found = [diagnostic for diagnostic in self.found if diagnostic.severity == severity]
        if severity in self._first_beyond:
            rest = f"this and {self._beyond[severity] - 1} more {severity}s are not listed"
            found.append(self._first_beyond[severity]._replace(message=rest))
        return found

    @property
    def errors(self) -> list[Diagnostic]:
        """Those that keep the world from loading."""
        return self._of("error")

    @property
    def warnings(self) -> list[Diagnostic]:
        """Those with which the world still loads."""
        found = self._of("warning")
        if self._first_unlisted is not None:
            rest = f"this and {self.unlisted - 1} more elements have no effect, either" if self.unlisted > 1 else ""
            found.append(Diagnostic.at(self._first_unlisted, rest or "has no effect, either", "warning"))
        return found

    def summary(self) -> list[str]:
        """The warnings for a log: of those alike but for names, paths and numbers a few, and how many follow."""
        lines: list[str] = []
        groups: dict[tuple[str, str], list[Diagnostic]] = {}
        for warning in self.warnings:
            group = groups.setdefault((warning.element, _VARIABLE.sub("", warning.message)), [])
            group.append(warning)
            if len(group) <= self.most_alike:
                lines.append(str(warning))
        for group in groups.values():
            if (more := len(group) - self.most_alike) > 0:
                first = group[0]
                lines.append(
                    f"{first.file}: <{first.element}>: {more} more like the warning of line {first.line}; "
                    f"`libgz sdf --check {first.file}` lists all"
                )
        return lines

    def raise_errors(self) -> None:
        """Raise all errors together, one line each; warnings alone raise nothing.

        Raises:
            WorldFileError: there is at least one error.
        """
        if self.errors:
            raise WorldFileError("\n".join(map(str, self.errors)))
