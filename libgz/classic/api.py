"""The public API of Gazebo classic as a table, and what of it libgz has.

`api.tsv` has a row for each method, field, function and constant of the headers of Gazebo 11 and its libraries that
plugins can use, and of older names: class, name, state, note. A state is `present`; `differs`, present with values
that are not Gazebo's on purpose, with the reason; `old`, present under a name of Gazebo 7 and before; `absent`, with
the reason or what serves instead; or `added`, libgz's own, with the reason.
"""

from __future__ import annotations

import csv
import functools
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from libgz.base.errors import nearest

__all__ = ["ApiName", "classic_api", "serves_instead", "without"]

TABLE = Path(__file__).with_name("api.tsv")


class ApiName(NamedTuple):
    """A row of the table.

    Attributes:
        holder: ``module.Class``; ``module.(functions)`` and the like for what is in no class.
        name: of the method, field, function or constant.
        state: present, differs, old, absent or added.
        note: the reason, or what serves instead.
    """

    holder: str
    name: str
    state: str
    note: str


@functools.cache
def classic_api() -> tuple[ApiName, ...]:
    """All rows."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE)
        return tuple(ApiName(row["class"], row["name"], row["state"], row["note"]) for row in rows)


def without(module: str) -> Callable[[str], Any]:
    """A `__getattr__` for a module of `libgz.classic`: its AttributeError says what serves instead of Gazebo's name."""

    def missing(name: str) -> Any:
        note = serves_instead(module, name)
        if note:
            raise AttributeError(f"{module} has no {name}, which Gazebo has: {note}", name=name)
        known = getattr(sys.modules[module], "__all__", ())
        raise AttributeError(f"module {module!r} has no attribute {name!r}{nearest(name, known)}", name=name)

    return missing


def serves_instead(module: str, name: str) -> str:
    """What serves instead of a name of Gazebo's, of a module of libgz.classic; empty if that is not known."""
    if name.startswith("_"):
        return ""
    part = module.removeprefix("libgz.classic").lstrip(".")
    for row in classic_api():
        holder, _, kind = row.holder.rpartition(".")
        if row.state == "absent" and holder == part and (kind == name or (kind.startswith("(") and row.name == name)):
            return row.note
    return ""
