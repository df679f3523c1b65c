"""The tree of errors. Every message says what is wrong, where, and what is allowed."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass, field

__all__ = [
    "ClosedError",
    "Diagnostic",
    "Diagnostics",
    "GazeboError",
    "InterfaceError",
    "LibraryError",
    "NotFoundError",
    "ParameterError",
    "PluginError",
    "ServerError",
    "ServerGoneError",
    "WorldFileError",
    "nearest",
]


class GazeboError(Exception):
    """Root of all errors raised by libgz."""


class ParameterError(GazeboError, ValueError):
    """An argument has a value that the function cannot take."""


class ClosedError(GazeboError):
    """An object was used after it was closed."""


class NotFoundError(GazeboError, LookupError):
    """A model, body, joint, file or name does not exist."""


class LibraryError(GazeboError, OSError):
    """A shared library is missing or unfit."""


class WorldFileError(GazeboError):
    """A worldfile cannot be loaded; the message lists all errors, one line each."""


class PluginError(GazeboError):
    """A plugin file was not found, could not be loaded, or failed."""


class ServerError(GazeboError):
    """A server cannot start: its id is in use, or its directory is unfit."""


class InterfaceError(GazeboError):
    """An interface cannot be created, opened or locked."""


class ServerGoneError(InterfaceError):
    """The server ended while a client was connected to it."""


def nearest(name: str, known: Iterable[str]) -> str:
    """A phrase for messages, ``"; did you mean 'x'?"``, or an empty string when nothing known resembles `name`."""
    lower = {candidate.lower(): candidate for candidate in known}
    found = difflib.get_close_matches(name.lower(), lower, n=3, cutoff=0.6)
    if not found:
        return ""
    return "; did you mean " + " or ".join(repr(lower[match]) for match in found) + "?"


@dataclass(frozen=True)
class Diagnostic:
    """One thing wrong in a worldfile or an SDF file. `str()` gives ``file:line: <element>: message``."""

    file: str
    line: int
    element: str
    message: str
    severity: str  # "error" or "warning"

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: <{self.element}>: {self.message}"


@dataclass
class Diagnostics:
    """All errors of one file, in the order in which they were found; each is kept once."""

    found: dict[Diagnostic, None] = field(default_factory=dict)

    def add(self, error: Diagnostic) -> None:
        """Take an error, if it is new."""
        self.found.setdefault(error)

    @property
    def errors(self) -> list[Diagnostic]:
        """Those that keep a world from loading."""
        return [error for error in self.found if error.severity == "error"]

    @property
    def warnings(self) -> list[Diagnostic]:
        """Those with which it loads all the same."""
        return [error for error in self.found if error.severity == "warning"]

    def raise_errors(self) -> None:
        """Tell all errors at once.

        Raises:
            WorldFileError: there is at least one.
        """
        if self.errors:
            raise WorldFileError("\n".join(map(str, self.errors)))
