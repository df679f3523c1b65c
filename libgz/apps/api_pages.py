"""The pages of the public names of libgz: signatures and docstrings, by topic."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator

import libgz
from libgz.interfaces.sample import SampleInterface
from libgz.reference.markdown import NOTE, cell
from libgz.transport.interface import Interface

__all__ = ["api_names", "api_pages", "describe"]

# Page -> (title, what it has, where its names come from).
API: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "world": ("Worlds and models", "worlds, models, plugins, rates", ("front", "legacy", "simulation")),
    "physics": ("Bodies, geoms, joints", "what models are built from", ("physics",)),
    "geometry": (
        "Geometry",
        "vectors, quaternions, poses, colours, with the functions of the old API",
        ("base.geometry",),
    ),
    "interfaces": ("Clients and interfaces", "the client, and a class for each interface", ("interfaces",)),
    "worldfile": ("Worldfiles", "elements of worldfiles and their typed getters", ("worldfile",)),
    "observer": ("Observer", "states and shapes of a running world, for other processes", ("transport.observer",)),
    "errors": ("Errors", "the tree of exceptions", ("base.errors",)),
}
BASES = {"interfaces": (Interface, SampleInterface)}  # classes whose members others have
DATA = ("Data",)  # endings of the names of structs, which the page of structs has


def api_names() -> dict[str, dict[str, object]]:
    """Page -> its classes and functions by name."""
    things = {name: getattr(libgz, name) for name in dir(libgz)}
    own = {name: thing for name, thing in things.items() if getattr(thing, "__module__", "").startswith("libgz.")}
    found = {}
    for page, (_, _, places) in API.items():
        names = {n: t for n, t in own.items() if t.__module__.removeprefix("libgz.").startswith(places)}
        found[page] = names | {kind.__name__: kind for kind in BASES.get(page, ())}
    return found


def api_pages() -> dict[str, str]:
    """Path below docs/api -> text of all pages."""
    listed, found = [], {}
    for page, names in api_names().items():
        title, about, _ = API[page]
        found[f"{page}.md"] = api_page(title, about, names)
        listed.append(f"| [{title}]({page}.md) | {about} |")
    text = (
        "All public names: `from libgz import World, Client, ...`. The functions and constants of the old API, such "
        "as `gz_position_open` and `dParamVel`, are names of `libgz`, too; [structs](../structs.md) has the "
        "structs. "
        "Classes for plugins of Gazebo classic are in [libgz.classic](../classic/README.md).\n"
    )
    table = "\n".join(["| page | content |", "|---|---|", *listed, ""])
    return {"README.md": f"{NOTE}\n# The Python API in full\n\n{text}\n{table}", **found}


def describe(name: str) -> str:
    """The section of one public class or function; an empty text if there is none of that name."""
    for names in api_names().values():
        if (thing := names.get(name)) is None:
            continue
        if inspect.isclass(thing):
            listed = {kind for kind in names.values() if inspect.isclass(kind)}
            return "\n".join([f"# {name}\n", *about_class(name, thing, listed)])
        if inspect.isfunction(thing):
            return f"# {name}\n\n`{name}{signature(thing)}`\n\n{docstring(thing)}"
    return ""


def api_page(title: str, about: str, names: dict[str, object]) -> str:
    """A page of classes and functions."""
    parts = [NOTE, f"# {title}\n", f"{about[0].upper()}{about[1:]}.\n"]
    functions = {name: thing for name, thing in names.items() if inspect.isfunction(thing)}
    classes = {name: thing for name, thing in names.items() if inspect.isclass(thing) and not name.endswith(DATA)}
    for name, kind in classes.items():
        parts += [f"## {name}\n", *about_class(name, kind, set(classes.values()))]
    if functions:
        parts += ["## Functions\n", "| function | description |", "|---|---|"]
        parts += [f"| `{name}{signature(thing)}` | {summary(thing)} |" for name, thing in functions.items()]
        parts.append("")
    return "\n".join(parts)


def about_class(name: str, kind: type, listed: set[type]) -> Iterator[str]:
    """The constructor, the docstring and the members of a class."""
    base = next((base for base in kind.__mro__[1:] if base in listed), None)
    if inspect.getattr_static(kind, "__init__") is not object.__init__ and not issubclass(kind, BaseException):
        yield f"`{name}{signature(kind)}`\n"
    yield docstring(kind)
    if base is not None:
        yield f"It also has the members of [{base.__name__}](#{base.__name__.lower()}).\n"
    inherited = set(dir(base)) if base is not None else set(dir(object))
    rows = []
    for member in sorted(set(dir(kind)) - inherited | set(vars(kind)), key=lambda name: (name.lower(), name)):
        thing = inspect.getattr_static(kind, member)
        function = thing.__func__ if isinstance(thing, classmethod | staticmethod) else thing
        if member.startswith(("_", "Master")) or not inspect.getdoc(function):
            continue
        if isinstance(function, property):
            rows.append(f"| `{member}` | {summary(function)} |")
        elif inspect.isfunction(function):
            rows.append(f"| `{member}{signature(function)}` | {summary(function)} |")
    if rows:
        yield "\n".join(["| member | description |", "|---|---|", *rows, ""])


def docstring(thing: object) -> str:
    """A docstring as Markdown: sections become lists."""
    lines, found, inside = (inspect.getdoc(thing) or "").splitlines(), [], False
    for line in lines:
        if re.fullmatch(r"(Args|Raises|Returns|Attributes|Yields):", line):
            found += [f"{line}", ""]
            inside = True
        elif inside and re.match(r" {4}\S", line):
            word, _, rest = line.strip().partition(": ")
            found.append(f"- `{word}`: {rest}" if rest else f"- {line.strip()}")
        elif inside and line.startswith("     "):
            found.append(f"  {line.strip()}")
        else:
            inside = False
            found.append(line)
    return "\n".join(found).replace("``", "`").replace("<", "\\<") + "\n"


def signature(thing: Callable[..., object]) -> str:
    """Parameters and result, without `self`."""
    try:
        found = inspect.signature(thing)
    except ValueError:
        return ""
    values = [p for p in found.parameters.values() if p.name not in ("self", "cls")]
    text = str(found.replace(parameters=values))
    if inspect.isclass(thing):
        text = text.partition(" -> ")[0]
    text = re.sub(r"(: |-> )'([^']*)'", r"\1\2", text)
    return re.sub(r"<(\w+)[^>]*>", r"\1", text).replace("|", "\\|")


def summary(thing: object) -> str:
    """The first paragraph of a docstring."""
    return cell((inspect.getdoc(thing) or "").split("\n\n", maxsplit=1)[0]).replace("``", "`")
