"""Faults of a file: gathered while it is read and told all at once."""

from __future__ import annotations

from dataclasses import dataclass, field

from libgz.errors import WorldFileError

__all__ = ["Fault", "Faults"]


@dataclass(frozen=True)
class Fault:
    """One thing wrong in a worldfile or an SDF file. `str()` gives ``file:line: <element>: message``."""

    file: str
    line: int
    element: str
    message: str
    severity: str  # "error" or "warning"

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: <{self.element}>: {self.message}"


@dataclass
class Faults:
    """All faults of one file, in the order in which they were found; each is kept once."""

    found: dict[Fault, None] = field(default_factory=dict)

    def add(self, fault: Fault) -> None:
        """Take a fault, if it is new."""
        self.found.setdefault(fault)

    @property
    def errors(self) -> list[Fault]:
        """Those that keep a world from loading."""
        return [fault for fault in self.found if fault.severity == "error"]

    @property
    def warnings(self) -> list[Fault]:
        """Those with which it loads all the same."""
        return [fault for fault in self.found if fault.severity == "warning"]

    def raise_errors(self) -> None:
        """Tell all errors at once.

        Raises:
            WorldFileError: there is at least one.
        """
        if self.errors:
            raise WorldFileError("\n".join(map(str, self.errors)))
