"""The tree of errors. Every message says what is wrong, where, and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol, TypeAlias

__all__ = [
    "ClosedError",
    "Diagnostic",
    "Diagnostics",
    "GazeboError",
    "InterfaceError",
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
    "StrictError",
    "WorldFileError",
    "nearest",
]


class GazeboError(Exception):
    """Root of all errors raised by libgz."""


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


class StrictError(GazeboError):
    """A strict world had its first error in a model or plugin, or its first warning; the message has the traceback."""


class ServerError(GazeboError):
    """A server cannot start: its id is in use, or its directory cannot be used."""


class InterfaceError(GazeboError):
    """An interface cannot be created, opened or locked."""


class ServerGoneError(InterfaceError):
    """The server ended while a client was connected to it."""


def nearest(name: str, known: Iterable[str]) -> str:
    """The end of a message, ``"; did you mean 'x'?"``; an empty string if no known name resembles `name`."""
    lower = {candidate.lower(): candidate for candidate in known}
    found = difflib.get_close_matches(name.lower(), lower, n=3, cutoff=0.6)
    if not found:
        return ""
    return "; did you mean " + " or ".join(repr(lower[match]) for match in found) + "?"


Severity: TypeAlias = Literal["error", "warning"]


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


@dataclass(frozen=True)
class Remark:
    """A message about a place in a file. `str()` gives ``file:line: <element>: message``."""

    file: str
    line: int
    element: str
    message: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: <{self.element}>: {self.message}"


@dataclass(frozen=True)
class Diagnostic(Remark):
    """One error or warning about a worldfile or an SDF file."""

    severity: Severity

    @classmethod
    def at(cls, where: Located, message: str, severity: Severity) -> Diagnostic:
        """The diagnostic of an element; a text without a file name is called ``<string>``."""
        return cls(where.file or "<string>", where.line, where.name, message, severity)


@dataclass
class Diagnostics:
    """The errors and warnings of one file, in the order in which they were found; each is kept once.

    Errors are collected, not raised, so that all are reported together::

        diagnostics.error(element, "must be given")
        diagnostics.warn(element, "has no effect")
        diagnostics.raise_errors()

    `element` is anything with `file`, `line` and `name`, such as `libgz.sdf.element.Element` or `Place`.
    A `WorldFileNode` has its own `error(message)` and `warn(message)`.
    """

    found: dict[Diagnostic, None] = field(default_factory=dict)

    def error(self, where: Located, message: str) -> None:
        """Add an error: the world does not load."""
        self.add(Diagnostic.at(where, message, "error"))

    def warn(self, where: Located, message: str) -> None:
        """Add a warning: the world loads all the same."""
        self.add(Diagnostic.at(where, message, "warning"))

    def add(self, *diagnostics: Diagnostic) -> None:
        """Add diagnostics, such as those of an included file; the known ones are skipped."""
        self.found.update(dict.fromkeys(diagnostics))

    @property
    def errors(self) -> list[Diagnostic]:
        """Those that keep the world from loading."""
        return [diagnostic for diagnostic in self.found if diagnostic.severity == "error"]

    @property
    def warnings(self) -> list[Diagnostic]:
        """Those with which the world still loads."""
        return [diagnostic for diagnostic in self.found if diagnostic.severity == "warning"]

    def raise_errors(self) -> None:
        """Raise all errors together, one line each; warnings alone raise nothing.

        Raises:
            WorldFileError: there is at least one error.
        """
        if self.errors:
            raise WorldFileError("\n".join(map(str, self.errors)))
