"""The table of signatures: the public C++ API of Gazebo 11 that libgz has.

`api.tsv` has a row for each class, method, function, type and enumeration: kind, scope, name, type, parameters, flags,
header. A class has its bases as type. Flags of a method are ctor, const, static, virt and pure; `hand` marks what
`native/libgz` declares by hand. Headers, forwards and the page of the API are made of it.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

__all__ = ["Class", "Row", "classes", "rows", "split"]

TABLE = Path(__file__).with_name("api.tsv")


@dataclass(frozen=True)
class Row:
    """A row of the table."""

    kind: str
    scope: str
    name: str
    type: str
    parameters: str
    flags: frozenset[str]
    header: str

    @property
    def full_name(self) -> str:
        """The name with its scope: ``gazebo::physics::Link``."""
        return f"{self.scope}::{self.name}" if self.scope else self.name


@dataclass
class Class:
    """A class of the table, with what is in it."""

    row: Row
    bases: tuple[str, ...]
    methods: list[Row] = field(default_factory=list)
    enums: list[Row] = field(default_factory=list)

    @property
    def space(self) -> str:
        """The last part of its namespace: physics."""
        return self.row.scope.rpartition("::")[2]


@functools.cache
def rows() -> tuple[Row, ...]:
    """All rows."""
    lines = TABLE.read_text(encoding="utf-8").splitlines()[1:]
    found = []
    for line in lines:
        kind, scope, name, kind_of, parameters, flags, header = line.split("\t")
        found.append(Row(kind, scope, name, kind_of, parameters, frozenset(flags.split()), header))
    return tuple(found)


def split(text: str, separator: str = ",") -> list[str]:
    """The parts of a list; what is in brackets is one part."""
    return [part.strip() for part in _split(text, separator) if part.strip()]


def _split(text: str, separator: str) -> Iterator[str]:
    depth = start = 0
    for place, letter in enumerate(text):
        depth += (letter in "<(") - (letter in ">)")
        if letter == separator and not depth:
            yield text[start:place]
            start = place + 1
    yield text[start:]


@functools.cache
def classes() -> dict[str, Class]:
    """The classes that are generated, by full name, each after its bases."""
    found = {
        row.full_name: Class(row, tuple(split(row.type)))
        for row in rows()
        if row.kind == "class" and "hand" not in row.flags
    }
    for row in rows():
        owner = found.get(row.scope)
        if owner is not None and row.kind == "method":
            owner.methods.append(row)
        elif owner is not None and row.kind == "enum":
            owner.enums.append(row)
    ordered: dict[str, Class] = {}

    def add(name: str) -> None:
        for base in found[name].bases:
            if base in found and base not in ordered:
                add(base)
        ordered[name] = found[name]

    for name in found:
        if name not in ordered:
            add(name)
    return ordered
