"""Pages of the API for plugins of Gazebo classic: a table of each class, made from signatures and docstrings."""

from __future__ import annotations

import inspect
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

from libgz.classic import common, log, math, physics, rendering, sdf, sensors, transport
from libgz.reference.classic_api import classic_api
from libgz.reference.pages import write_changed

__all__ = ["classic_pages", "write_classic_pages"]

NOTE = "<!-- Made by scripts/make_classic_pages.py from the classes; do not edit. -->\n"
PAGES: dict[ModuleType, str] = {
    physics: "the world, models, links, joints, collisions",
    sensors: "cameras, lasers and other sensors",
    rendering: "scene, visuals, cameras",
    common: "times, PID controllers, animations, console, search paths",
    math: "vectors, quaternions, poses, angles, random numbers",
    transport: "nodes, publishers, subscribers",
    log: "logs of runs: recording, reading, playing",
    sdf: "elements of SDF documents",
}
OLD = "The old name of "


def classic_pages() -> dict[str, str]:
    """File name -> text of all pages."""
    named = {module.__name__.rpartition(".")[2]: (module, about) for module, about in PAGES.items()}
    rows = ["| module | content |", "|---|---|", *(f"| [{n}]({n}.md) | {about} |" for n, (_, about) in named.items())]
    head = "Classes and functions by module, for example `from libgz.classic import physics`; the guide is"
    states = Counter(row.state for row in classic_api())
    have, whole = states["present"], states["present"] + states["absent"]
    table = (
        f"Of {whole} names of the headers of Gazebo 11 and its libraries that plugins can use, libgz has {have}, and "
        f"{states['old']} older ones. Each class lists those that it has not, with what serves instead; the whole "
        "table is `libgz/reference/classic_api.tsv`.\n"
    )
    text = "\n".join([NOTE, "# The API for plugins\n", f"{head} [plugins.md](../plugins.md).\n", table, *rows, ""])
    return {"README.md": text, **{f"{n}.md": _page(n, *page) for n, page in named.items()}}


def write_classic_pages(directory: Path) -> list[Path]:
    """Write all pages; the files that changed.

    Raises:
        OSError: a file cannot be written.
    """
    return write_changed(directory, classic_pages())


def _page(name: str, module: ModuleType, about: str) -> str:
    found = {word: getattr(module, word) for word in module.__all__}
    classes: dict[type, list[str]] = {}
    functions = []
    for word, thing in found.items():
        if inspect.isclass(thing) and thing.__module__.startswith("libgz."):
            classes.setdefault(thing, []).append(word)
        elif inspect.isfunction(thing):
            functions.append(_row(word, [], thing))
    parts = [NOTE, f"# {name}\n", f"`libgz.classic.{name}`: {about}. Names in the second column are aliases.\n"]
    if functions:
        parts.append(_table("function", functions))
    for kind in sorted(classes, key=lambda kind: kind.__name__):
        parts += [f"## {kind.__name__}\n", _about(kind, classes[kind]), _table("method", list(_methods(kind)))]
        parts.append(_absent(f"{name}.{kind.__name__}"))
    parts.append(_absent_elsewhere(name, {kind.__name__ for kind in classes}))
    return "\n".join(part for part in parts if part)


def _absent(holder: str) -> str:
    """What of a class libgz has not, and what serves instead."""
    missing: dict[str, list[str]] = {}
    for row in classic_api():
        if row.holder == holder and row.state == "absent":
            missing.setdefault(row.note, []).append(row.name)
    rows = [f"| {_names(names)} | {_cell(note)} |" for note, names in missing.items()]
    return "\n".join(["| not in libgz | instead, or why |", "|---|---|", *rows, ""]) if rows else ""


def _absent_elsewhere(module: str, present: set[str]) -> str:
    """The same for functions, constants, and classes that libgz has not at all."""
    prefix = f"{module}."
    holders = dict.fromkeys(row.holder for row in classic_api() if row.holder.startswith(prefix))
    others = [holder for holder in holders if holder.removeprefix(prefix) not in present]
    parts = [f"### {holder.removeprefix(prefix)}\n\n{text}" for holder in others if (text := _absent(holder))]
    return "\n".join(["## What else Gazebo has\n", *parts]) if parts else ""


def _about(kind: type, names: list[str]) -> str:
    others = [name for name in names if name != kind.__name__]
    above = [base.__name__ for base in [next(filter(_documented, kind.__mro__[1:]), None)] if base is not None]
    parts = [_cell(inspect.getdoc(kind) or "").split("\n\n", maxsplit=1)[0].replace("\n", " ")]
    parts += [f"Also called {_names(others)}."] if others else []
    parts += [f"It also has the members of {_names(above)}."] if above else []
    return " ".join(part for part in parts if part) + "\n"


def _documented(kind: type) -> bool:
    """Whether a class has a section of its own: its package exports it."""
    package = sys.modules.get(".".join(kind.__module__.split(".")[:3]))
    return kind.__module__.startswith("libgz.classic") and kind.__name__ in getattr(package, "__all__", ())


def _members(kind: type) -> dict[str, object]:
    """The members of a class, and those of its bases that have no section of their own."""
    inside: dict[str, object] = {}
    for base in kind.__bases__:
        if base.__module__.startswith("libgz.classic") and not _documented(base):
            inside |= _members(base)
    return inside | vars(kind)


def _methods(kind: type) -> Iterator[str]:
    """A row of each method of the class itself. Lower-case names are libgz's own and listed for elements only."""
    names: dict[Callable[..., object], list[str]] = {}
    for name, thing in _members(kind).items():
        function = thing.__func__ if isinstance(thing, classmethod | staticmethod) else thing
        listed = name[0].isupper() or (name[0] != "_" and kind.__module__.startswith("libgz.sdf"))
        if listed and inspect.isfunction(function) and function.__doc__:
            names.setdefault(function, []).append(name)
    old = {_summary(f).removeprefix(OLD).rstrip("."): n for f, n in names.items() if _summary(f).startswith(OLD)}
    for function, own in names.items():
        if not _summary(function).startswith(OLD):
            first = function.__name__ if function.__name__ in own else own[0]
            yield _row(first, [n for n in own if n != first] + old.get(first, []), function)


def _row(name: str, others: list[str], function: Callable[..., object]) -> str:
    signature = inspect.signature(function)
    values = [p for p in signature.parameters.values() if p.name not in ("self", "cls")]
    text = re.sub("(: |-> )'([^']*)'", r"\1\2", str(signature.replace(parameters=values)))
    return f"| `{name}` | {_names(others)} | `{_cell(text)}` | {_summary(function)} |"


def _names(names: list[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _summary(function: Callable[..., object]) -> str:
    return _cell((inspect.getdoc(function) or "").split("\n\n", maxsplit=1)[0].replace("\n", " "))


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _table(head: str, rows: list[str]) -> str:
    if not rows:
        return ""
    return "\n".join([f"| {head} | other names | arguments -> result | description |", "|---|---|---|---|", *rows, ""])
