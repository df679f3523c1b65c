"""What SDF 1.4 to 1.9 allow: elements, attributes, types, defaults, and how often each may occur.

The table elements.tsv has one row per element or attribute: its path below a block, its type, and default and count in
1.4, 1.5 and 1.6. A type `@block` refers to that block; count 1 is exactly one, `+` at least one, 0 at most one, `*`
any. The table later.tsv has what 1.7 to 1.9 added or changed.
"""

from __future__ import annotations

import csv
import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from libgz.base.errors import ParameterError

__all__ = ["LATER", "NEWEST", "UNITS", "UNSET", "VERSIONS", "AttributeDescription", "Description", "describe"]

OLDEST = "1.0"
NEWEST = "1.6"  # that is written, and has all that worlds of Gazebo classic need
LATER = ("1.7", "1.8", "1.9")
VERSIONS = ("1.4", "1.5", NEWEST, *LATER)
UNSET = "__default__"  # instead of a default, where none makes sense: a name, a type, a file
ABSENT = "(absent)"
UNITS = ("m", "rad", "s", "Hz", "kg", "rad or m", "rgba 0..1", "rad/s or m/s; negative = no limit")  # among the notes
TABLE = Path(__file__).with_name("elements.tsv")
ADDED = Path(__file__).with_name("later.tsv")
# Of every pose; up to 1.6 the frame that it is relative to has another name.
POSE_ATTRIBUTES = {
    "1.4": {"frame": "string"},
    "1.5": {"frame": "string"},
    "1.6": {"frame": "string"},
    "1.7": {"relative_to": "string"},
    "1.8": {"relative_to": "string"},
    "1.9": {"relative_to": "string", "degrees": "bool", "rotation_format": "string"},
}


class AttributeDescription(NamedTuple):
    """One XML attribute."""

    name: str
    type: str
    default: str
    required: bool
    note: str = ""  # its unit, or how it is meant


@dataclass(eq=False, repr=False)
class Description:
    """One element: the type of its text, and its possible attributes and children."""

    name: str
    type: str = ""
    default: str = ""
    count: str = "*"
    attributes: dict[str, AttributeDescription] = field(default_factory=dict)
    own_children: dict[str, Description] = field(default_factory=dict)
    any_children: bool = False
    note: str = ""  # its unit, or how it is meant
    path: str = ""  # of names, from a block on
    block: str = ""  # a block that gives its attributes and children
    blocks: Mapping[str, Description] = field(default_factory=dict)

    @functools.cached_property
    def children(self) -> Mapping[str, Description]:
        """Name -> description of the possible children."""
        return self.blocks[self.block].children if self.block else self.own_children

    @functools.cached_property
    def all_attributes(self) -> Mapping[str, AttributeDescription]:
        """Name -> description of its XML attributes."""
        return self.blocks[self.block].all_attributes if self.block else self.attributes

    @functools.cached_property
    def open(self) -> bool:
        """Whether any children are allowed, as in a plugin."""
        return self.blocks[self.block].open if self.block else self.any_children

    def later(self, version: str) -> Iterator[tuple[str, Description]]:
        """What versions after `version` have at its place: pairs of a version and a description."""
        head, *steps = (self.block or self.path).split("/")
        for newer in VERSIONS[VERSIONS.index(version) + 1 :]:
            found = describe(newer).get(head)
            for step in steps:
                found = found.children.get(step) if found is not None else None
            if found is not None:
                yield newer, found

    @property
    def unit(self) -> str:
        """The unit of its value; empty for none."""
        return self.note if self.note in UNITS else ""

    @property
    def required(self) -> bool:
        """Whether the element must exist; a missing one is created with its defaults."""
        return self.count in ("1", "+")


@functools.cache
def describe(version: str) -> Mapping[str, Description]:
    """Block name -> description for one version of SDF.

    Raises:
        ParameterError: the version is not one of `VERSIONS`.
    """
    if version not in VERSIONS:
        raise ParameterError(f"SDF version is {version!r}; {', '.join(VERSIONS)} are described")
    return _Blocks(version)


class _Blocks(Mapping[str, Description]):
    """The blocks of a version, each made of its rows when it is first used: most worlds need few of them."""

    def __init__(self, version: str) -> None:
        self._version, self._made = version, dict[str, Description]()
        self._columns = [f"{what}_{min(version, NEWEST)}" for what in ("default", "count")]

    def __getitem__(self, name: str) -> Description:
        if name in self._made:
            return self._made[name]
        rows = list(self._rows(name))
        if not rows:
            raise KeyError(name)
        block = Description(name, path=name)
        for path, kind, default, count, note in rows:
            _add(self, block, path, kind, default, count, note)
        _complete_poses(block, POSE_ATTRIBUTES[self._version])
        return self._made.setdefault(name, block)  # another thread may have made it, too

    def __iter__(self) -> Iterator[str]:
        return (name for name in _families() if any(True for _ in self._rows(name)))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _rows(self, name: str) -> Iterator[tuple[str, str, str, str, str]]:
        """Path, type, default, count and note of what the version has in a block."""
        for row in _families().get(name, ()):
            if "version" not in row:
                default, count = (row[column] for column in self._columns)
                if default != ABSENT and count != "-":
                    yield row["path"], row["type"], default, count, row["note"]
            elif row["version"] <= self._version:
                yield row["path"], row["type"], row["default"], row["count"], ""


@functools.cache
def _families() -> dict[str, list[dict[str, str]]]:
    """Block name -> its rows of both tables."""
    families: dict[str, list[dict[str, str]]] = {}
    for path in (TABLE, ADDED):
        with path.open(encoding="utf-8", newline="") as table:
            head, *rows = csv.reader(table, delimiter="\t")
        for values in rows:
            row = dict(zip_longest(head, values, fillvalue=""))  # what is missing at the end of a row is empty
            families.setdefault(row["path"].partition("/")[0].partition("@")[0], []).append(row)
    return families


def _complete_poses(element: Description, attributes: Mapping[str, str]) -> None:
    for child in element.own_children.values():
        if child.type == "pose":
            child.attributes |= {key: AttributeDescription(key, kind, "", False) for key, kind in attributes.items()}
        _complete_poses(child, attributes)


def _add(blocks: _Blocks, block: Description, path: str, kind: str, default: str, count: str, note: str) -> None:
    """Add one row of a block; rows of parents come before those of their children."""
    where, _, attribute = path.partition("@")
    node, (_, *steps) = block, where.split("/")
    for i, step in enumerate(steps):
        last = i == len(steps) - 1
        if step == "*":
            node.any_children = True
            return
        if last and not attribute:
            node.own_children[step] = Description(step, path=where)
        elif step not in node.own_children:
            return  # its parent is absent in this version
        node = node.own_children[step]
    if attribute:
        node.attributes[attribute] = AttributeDescription(attribute, kind, default, count == "1", note)
    else:
        node.type, node.default, node.count, node.note = kind, default, count, note
        if kind.startswith("@"):
            node.type, node.block, node.blocks = "", kind[1:], blocks
