"""What SDF 1.4, 1.5 and 1.6 allow: elements, attributes, types, defaults, and how often each may occur.

The table elements.tsv has one row per element or attribute: its path below a block, its type, and default and count in
each version. A type `@block` refers to that block; count 1 is exactly one, `+` at least one, 0 at most one, `*` any.
"""

from __future__ import annotations

import csv
import functools
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from libgz.errors import ParameterError

__all__ = ["UNSET", "VERSIONS", "AttributeDescription", "Description", "describe"]

VERSIONS = ("1.4", "1.5", "1.6")
UNSET = "__default__"  # instead of a default, where none makes sense: a name, a type, a file
ABSENT = "(absent)"
TABLE = Path(__file__).with_name("elements.tsv")


@dataclass(frozen=True)
class AttributeDescription:
    """One XML attribute."""

    name: str
    type: str
    default: str
    required: bool


@dataclass
class Description:
    """One element: the type of its text, and its possible attributes and children."""

    name: str
    type: str = ""
    default: str = ""
    count: str = "*"
    attributes: dict[str, AttributeDescription] = field(default_factory=dict)
    own_children: dict[str, Description] = field(default_factory=dict)
    any_children: bool = False
    block: str = ""  # a block that gives its attributes and children
    blocks: Mapping[str, Description] = field(default_factory=dict)

    @property
    def children(self) -> Mapping[str, Description]:
        """Name -> description of the possible children."""
        return self.blocks[self.block].children if self.block else self.own_children

    @property
    def all_attributes(self) -> Mapping[str, AttributeDescription]:
        """Name -> description of its XML attributes."""
        return self.blocks[self.block].all_attributes if self.block else self.attributes

    @property
    def open(self) -> bool:
        """Whether any children are allowed, as in a plugin."""
        return self.blocks[self.block].open if self.block else self.any_children

    @property
    def required(self) -> bool:
        """Whether the element must exist; a missing one is created with its defaults."""
        return self.count in ("1", "+")


@functools.cache
def describe(version: str) -> Mapping[str, Description]:
    """Block name -> description for one version of SDF.

    Raises:
        ParameterError: the version is not one of 1.4, 1.5, 1.6.
    """
    if version not in VERSIONS:
        raise ParameterError(f"SDF version is {version!r}; {', '.join(VERSIONS)} are described")
    blocks: dict[str, Description] = {}
    with TABLE.open(encoding="utf-8", newline="") as table:
        for row in csv.DictReader(table, delimiter="\t"):
            default, count = row[f"default_{version}"] or "", row[f"count_{version}"] or ""
            if default != ABSENT and count != "-":
                _add(blocks, row["path"], row["type"] or "", default, count)
    return blocks


def _add(blocks: dict[str, Description], path: str, kind: str, default: str, count: str) -> None:
    """Add one row; rows of parents come before those of their children."""
    where, _, attribute = path.partition("@")
    head, *steps = where.split("/")
    node = blocks.setdefault(head, Description(head))
    for i, step in enumerate(steps):
        last = i == len(steps) - 1
        if step == "*":
            node.any_children = True
            return
        if last and not attribute:
            node.own_children[step] = Description(step)
        elif step not in node.own_children:
            return  # its parent is absent in this version
        node = node.own_children[step]
    if attribute:
        node.attributes[attribute] = AttributeDescription(attribute, kind, default, count == "1")
    else:
        node.type, node.default, node.count = kind, default, count
        if kind.startswith("@"):
            node.type, node.block, node.blocks = "", kind[1:], blocks
