"""Pages of the API for plugins of Gazebo classic: one of each module and class, made from the table and the classes."""

from __future__ import annotations

import inspect
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType

from libgz.classic import common, event, gui, log, math, msgs, physics, plugin, rendering, sdf, sensors, transport
from libgz.classic.msgs.declare import declarations
from libgz.reference.classic_api import ApiName, classic_api
from libgz.reference.markdown import NOTE

__all__ = ["classic_pages", "describe"]

PAGES: dict[ModuleType, str] = {
    plugin: "the six kinds of plugins, and how a file registers its class",
    physics: "the world, models, links, joints, collisions",
    sensors: "cameras, lasers and other sensors",
    rendering: "scene, visuals, cameras",
    gui: "the client: its window, the user's camera",
    event: "events, and connections to them",
    common: "times, PID controllers, animations, console, search paths",
    math: "vectors, quaternions, poses, angles, random numbers",
    transport: "nodes, publishers, subscribers",
    msgs: "messages",
    log: "logs of runs: recording, reading, playing",
    sdf: "elements of SDF documents",
}
OLD = "The old name of "
NAMES = "names.md"


@dataclass
class _Class:
    """A class that has a page.

    Attributes:
        module: the short name of its module.
        kind: the class.
        aliases: other names that the module exports it by.
    """

    module: str
    kind: type
    aliases: list[str]

    @property
    def holder(self) -> str:
        """What the table calls it."""
        return f"{self.module}.{self.kind.__name__}"

    @property
    def path(self) -> str:
        """Of its page."""
        return f"{self.module}/{self.kind.__name__}.md"

    def rows(self, *states: str) -> list[ApiName]:
        """What the table has of it."""
        return [row for row in _rows_of(self.holder) if row.state in states]


def classic_pages() -> dict[str, str]:
    """Path -> text of all pages."""
    modules = {module.__name__.rpartition(".")[2]: module for module in PAGES}
    classes = {name: _classes(name, module) for name, module in modules.items()}
    every = {one.kind: one for found in classes.values() for one in found}
    pages = {"README.md": _front(classes), NAMES: _index(every)}
    for name, module in modules.items():
        pages[f"{name}/README.md"] = _module_page(name, module, classes[name])
        pages |= {one.path: _class_page(one, every) for one in classes[name]}
    return pages


def describe(name: str) -> str:
    """The pages of a module, a class, or all that have a method of this name; an empty text if there are none.

    Args:
        name: `physics`, `Link`, `physics.Link` or `SetLinearVel`.
    """
    pages = classic_pages()
    path = name.replace(".", "/")
    wanted = (f"{path}/README.md", f"{path}.md")
    found = [text for page, text in pages.items() if page in wanted or page.endswith(f"/{name}.md")]
    if not found:
        found = [line for line in pages[NAMES].splitlines() if line.startswith(f"| `{name}` |")]
    return "\n".join(found)


# Pages ----------------------------------------------------------------------------------------------------------------


def _front(classes: dict[str, list[_Class]]) -> str:
    about = {module.__name__.rpartition(".")[2]: text for module, text in PAGES.items()}
    states = Counter(row.state for row in classic_api())
    have = states["present"] + states["differs"]
    whole = have + states["absent"]
    rows = [
        f"| [{name}]({name}/README.md) | {about[name]} | {', '.join(_link(one) for one in found)} |"
        for name, found in classes.items()
    ]
    return "\n".join(
        [
            NOTE,
            "# The API for plugins in full\n",
            "Classes and functions by module, for example `from libgz.classic import physics`; the guide is "
            "[plugins.md](../plugins.md).\n",
            f"Of {whole} names of the headers of Gazebo 11 and its libraries that plugins can use, libgz has {have}, "
            f"and {states['old']} older ones. Each page lists those that libgz has not, with what serves instead; the "
            "whole table is `libgz/classic/api.tsv`.\n",
            "| module | content | classes |",
            "|---|---|---|",
            *rows,
            "",
            f"- [All names]({NAMES}), and the classes that have them",
            "",
        ]
    )


def _index(every: dict[type, _Class]) -> str:
    """The page of all names of methods."""
    places: dict[str, list[_Class]] = {}
    for one in every.values():
        for name in {*(row.name for row in one.rows("present", "differs", "old", "added")), *_own_methods(one.kind)}:
            places.setdefault(name, []).append(one)
    rows = [
        f"| `{name}` | {', '.join(_link(one) for one in sorted(found, key=lambda one: one.holder))} |"
        for name, found in sorted(places.items(), key=lambda item: (item[0].lower(), item[0]))
    ]
    return "\n".join(
        [
            NOTE,
            "# All names\n",
            "Methods, attributes and constants, old names included, and the classes that have them; derived classes "
            "have those of their bases, too.\n",
            "| name | classes |",
            "|---|---|",
            *rows,
            "",
        ]
    )


def _module_page(name: str, module: ModuleType, classes: list[_Class]) -> str:
    exported = getattr(module, "__all__", ())
    functions = [
        _row(word, [], getattr(module, word)) for word in exported if inspect.isfunction(getattr(module, word))
    ]
    parts = [NOTE, f"# {name}\n", f"`libgz.classic.{name}`: {PAGES[module]}.\n"]
    if classes:
        rows = [f"| [{one.kind.__name__}]({one.kind.__name__}.md) | {_about(one.kind)} |" for one in classes]
        parts += ["## Classes\n", "| class | |", "|---|---|", *rows, ""]
    if functions:
        parts += ["## Functions\n", _table("function", functions)]
    if module is msgs:
        parts += _message_tables()
    parts.append(_absent_elsewhere(name, {one.kind.__name__ for one in classes}))
    return "\n".join(part for part in parts if part or part == "")


def _message_tables() -> list[str]:
    rows, numbers = [], []
    for name, text in declarations().items():
        if text.startswith("enum "):
            numbers.append(f"| `{name}` | {_cell(text.removeprefix('enum '))} |")
        else:
            fields = [_field(part) for part in text.split(", ")]
            rows.append(f"| `{name}` | {_cell(', '.join(fields))} |")
    return [
        "## Messages\n",
        "Types of Gazebo classic, as `msgs.Vector3d`; `*` marks required fields, `[]` repeated ones.\n",
        "| type | fields |",
        "|---|---|",
        *rows,
        "",
        "## Enumerations\n",
        "| type | values |",
        "|---|---|",
        *numbers,
        "",
    ]


def _field(text: str) -> str:
    """A field of a message, ``kind name number``: its name, marked, before its kind, and its default."""
    words, _, default = text.partition(" = ")
    kind, name, _number = words.split()
    shown = f"`{name.replace('!', '*')}` {kind}"
    return f"{shown} = {default}" if default else shown


def _class_page(one: _Class, every: dict[type, _Class]) -> str:
    kind = one.kind
    parts = [NOTE, f"# {one.module}.{kind.__name__}\n", f"{_about(kind, whole=True)}\n"]
    names = f"`from libgz.classic import {one.module}`, then `{one.module}.{kind.__name__}`"
    parts.append(f"{names}; also called {_names(one.aliases)}.\n" if one.aliases else f"{names}.\n")
    methods = list(_methods(kind))
    parts.append(_table("method", methods))
    shown = set(_own_methods(kind))
    others = [row.name for row in one.rows("present", "differs", "old") if row.name not in shown]
    above = [every[base] for base in kind.__mro__[1:] if base in every]
    inherited = {name for base in above for name in _own_methods(base.kind)}
    others = [name for name in others if name not in inherited]
    if others:
        parts.append(f"Attributes, constants and operators: {_names(others)}.\n")
    for base in above:
        own = sorted(set(_own_methods(base.kind)) - shown)
        shown |= set(own)
        if own:
            parts.append(f"From {_link(base, '../')}: {_names(own)}.\n")
    other: dict[str, list[str]] = {}
    for row in one.rows("differs"):
        other.setdefault(row.note, []).append(row.name)
    if other:
        rows = [f"| {_names(names)} | {_cell(note)} |" for note, names in other.items()]
        parts.append("\n".join(["| not as in Gazebo 11.1 | how |", "|---|---|", *rows, ""]))
    added: dict[str, list[str]] = {}
    for row in one.rows("added"):
        added.setdefault(row.note, []).append(row.name)
    if added:
        rows = [f"| {_names(names)} | {_cell(note)} |" for note, names in added.items()]
        parts.append("\n".join(["| not in Gazebo | why |", "|---|---|", *rows, ""]))
    parts.append(_absent(one.holder))
    return "\n".join(part for part in parts if part)


# Tables ---------------------------------------------------------------------------------------------------------------


def _rows_of(holder: str) -> list[ApiName]:
    return [row for row in classic_api() if row.holder == holder]


def _classes(name: str, module: ModuleType) -> list[_Class]:
    """The classes that a module exports, by name, each once."""
    found: dict[type, list[str]] = {}
    for word in getattr(module, "__all__", ()):
        thing = getattr(module, word)
        if inspect.isclass(thing) and thing.__module__.startswith("libgz."):
            found.setdefault(thing, []).append(word)
    made = [_Class(name, kind, [word for word in words if word != kind.__name__]) for kind, words in found.items()]
    return sorted((one for one in made if _home(one) == name), key=lambda one: one.kind.__name__)


def _home(one: _Class) -> str:
    """The module that a class belongs to, where several export it."""
    parts = one.kind.__module__.split(".")
    own = parts[2] if one.kind.__module__.startswith("libgz.classic.") else one.module
    names = {module.__name__.rpartition(".")[2]: module for module in PAGES}
    exported = own in names and one.kind in (getattr(names[own], word, None) for word in names[own].__all__)
    return own if exported else one.module


def _link(one: _Class, up: str = "") -> str:
    return f"[{one.kind.__name__}]({up}{one.path})"


def _own_methods(kind: type) -> Iterator[str]:
    """The names that the table of a class shows, aliases and old names included."""
    for name, thing in _members(kind).items():
        function = thing.__func__ if isinstance(thing, classmethod | staticmethod) else thing
        listed = name[0].isupper() or (name[0] != "_" and kind.__module__.startswith("libgz.sdf"))
        if listed and inspect.isfunction(function) and function.__doc__:
            yield name


def _absent(holder: str) -> str:
    """What of a class libgz has not, and what serves instead."""
    missing: dict[str, list[str]] = {}
    for row in _rows_of(holder):
        if row.state == "absent":
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


def _about(kind: type, whole: bool = False) -> str:
    """The first paragraph of a class's docstring; or, whole, all of it up to its sections."""
    text = inspect.getdoc(kind) or ""
    paragraphs = text.split("\n\n")
    if not whole:
        return _cell(paragraphs[0].replace("\n", " "))
    shown = []
    for paragraph in paragraphs:
        if re.match(r"(Args|Attributes|Raises|Returns|Elements):", paragraph):
            break
        code = paragraph.startswith("    ")
        shown.append(paragraph if code or "\n    " in paragraph else _cell(paragraph.replace("\n", " ")))
    return "\n\n".join(shown)


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
