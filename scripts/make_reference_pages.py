"""Writes docs/commands.md, docs/sdf_elements.md, docs/api and the tables of docs/worldfile.md.

They follow from the parsers, the description of SDF, the docstrings and the declarations of settings.

.venv/bin/python scripts/make_reference_pages.py
"""

from __future__ import annotations

import argparse
import csv
import inspect
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import libgz
from libgz.apps.command_line import command_parsers
from libgz.interfaces.sample import SampleInterface
from libgz.legacy.settings import QUIRKS, GlobalAttributes
from libgz.reference.catalogue import rows_of
from libgz.sdf.description import ABSENT, TABLE, UNSET
from libgz.transport.interface import Interface

DOCS = Path(__file__).parent.parent / "docs"
NOTE = "<!-- Made by scripts/make_reference_pages.py; do not edit. -->\n"


def pages() -> dict[str, str]:
    """Path below docs -> text of all pages."""
    made = {"commands.md": commands_page(), "sdf_elements.md": sdf_page(), "worldfile.md": worldfile_page()}
    return made | api_pages()


def cell(text: str) -> str:
    """A text in a cell of a table; tags outside code are no markup."""
    parts = " ".join(text.split()).replace("|", "\\|").split("`")
    return "`".join(part if i % 2 else part.replace("<", "&lt;") for i, part in enumerate(parts))


# Commands ------------------------------------------------------------------------------------------------------------


def commands_page() -> str:
    """The commands and all their options, from the parsers."""
    parts = [
        NOTE,
        "# Commands\n",
        "All commands and options, as `-h` prints them. [Tools](tools.md) explains them with examples, and has a table "
        "of [exit codes](tools.md#exit-codes).\n",
    ]
    for name, parser in command_parsers().items():
        parts += list(command(name, parser, 2))
    return "\n".join(parts)


def command(name: str, parser: argparse.ArgumentParser, level: int) -> Iterator[str]:
    """The section of a command, and those of its subcommands."""
    yield f"{'#' * level} {name}\n"
    if parser.description:
        yield " ".join(parser.description.split()).replace("<", "\\<") + "\n"
    rows, below = [], []
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            below = [(word, sub) for word, sub in action.choices.items() if word != "help"]
        elif action.help is not argparse.SUPPRESS and not isinstance(action, argparse._HelpAction):
            rows.append(f"| {option(action)} | {cell(meaning(parser, action))} |")
    if rows:
        yield "\n".join(["| option or argument | meaning |", "|---|---|", *rows, ""])
    for word, sub in below:
        yield from command(f"{name} {word}", sub, min(level + 1, 4))


def option(action: argparse.Action) -> str:
    """An option with its argument, or an argument."""
    names = action.metavar or ("" if action.nargs == 0 else action.dest.upper())
    if action.choices is not None and action.metavar is None:
        names = "{" + ",".join(map(str, action.choices)) + "}"
    word = " ".join(names) if isinstance(names, tuple) else names
    if not action.option_strings:
        return f"`{word}`".replace("|", "\\|")
    ending = f" {word}" if action.nargs != 0 else ""
    if action.nargs == "?":
        ending = f" [{word}]"
    return ", ".join(f"`{name}{ending}`" for name in action.option_strings).replace("|", "\\|")


def meaning(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    """The help text with its values filled in."""
    values = {**vars(action), "prog": parser.prog}
    return (action.help or "") % {key: value for key, value in values.items() if value is not argparse.SUPPRESS}


# SDF -----------------------------------------------------------------------------------------------------------------

# Path -> why libgz does not act on the element, and what is below it. The text "" stands for that of the path above.
NO_EFFECT: dict[str, str] = {
    "physics/real_time_factor": "kept; Gazebo did not use it, either",
    "physics/bullet": "ODE only",
    "physics/simbody": "ODE only",
    "physics/dart": "ODE only",
    "physics/ode/solver/min_step_size": "kept",
    "physics/ode/solver/island_threads": "kept",
    "physics/ode/solver/precon_iters": "kept",
    "physics/ode/solver/thread_position_correction": "kept",
    "physics/ode/solver/use_dynamic_moi_rescaling": "kept",
    "scene/sky/sunrise": "the sky follows the time only",
    "scene/sky/sunset": "the sky follows the time only",
    "scene/sky/clouds": "the sky is rendered without clouds",
    "scene/origin_visual": "the origin is not shown",
    "spherical_coordinates/surface_model": "the Earth's WGS 84",
    "spherical_coordinates/world_frame_orientation": "east, north, up",
    "gui@fullscreen": "the client's window is a page",
    "gui/camera/projection_type": "perspective",
    "gui/camera/track_visual/min_dist": "kept",
    "gui/camera/track_visual/max_dist": "kept",
    "gui/camera/track_visual/use_model_frame": "kept",
    "gui/camera/track_visual/inherit_yaw": "kept",
    "link/must_be_base_link": "kept",
    "heightmap/texture/normal": "light follows the heights alone",
    "heightmap/use_terrain_paging": "kept",
    "heightmap/sampling": "each sample of the image is one of the height map",
    "image": "warning: the shape is not supported",
    "geometry/image": "warning: the shape is not supported",
    "surface/friction/bullet": "ODE only",
    "surface/contact/bullet": "ODE only",
    "surface/contact/category_bitmask": "collide_bitmask of both decides",
    "surface/contact/ode/soft_cfm": "kp and kd decide",
    "surface/contact/ode/soft_erp": "kp and kd decide",
    "surface/friction/torsional/ode/slip": "kept",
    "visual/meta": "kept",
    "material/shader": "rendered without it",
    "joint/axis/initial_position": "warning: as in Gazebo, poses of links decide",
    "joint/axis2/initial_position": "warning: as in Gazebo, poses of links decide",
    "joint/axis/limit/stiffness": "stops are hard",
    "joint/axis/limit/dissipation": "stops are hard",
    "joint/axis2/limit/stiffness": "stops are hard",
    "joint/axis2/limit/dissipation": "stops are hard",
    "camera/depth_camera/output": "a depth camera has all of them",
    "camera/distortion": "warning: images are rendered without it",
    "camera/lens": "warning: images are rendered without it",
}
VERSIONS = ("1.4", "1.5", "1.6")  # of the table
UNITS = ("m", "rad", "s", "Hz", "kg", "rad or m", "rgba 0..1", "rad/s or m/s; negative = no limit")


def rows_of_sdf() -> dict[str, dict[str, str]]:
    """Path -> row of the table that describes SDF 1.4 to 1.6."""
    with TABLE.open(encoding="utf-8", newline="") as table:
        return {row["path"]: row for row in csv.DictReader(table, delimiter="\t")}


def without_effect(path: str) -> str | None:
    """Why an element has no effect; None if it has one."""
    at = path
    while at:
        if at in NO_EFFECT:
            return NO_EFFECT[at]
        at = at[: max(at.rfind("/"), at.rfind("@"), 0)]
    return None


def sdf_page() -> str:
    """Every element of SDF 1.4 to 1.6: type, default, versions, and whether libgz acts on it."""
    rows = rows_of_sdf()
    parts = [
        NOTE,
        "# Elements of SDF\n",
        "Every element and attribute (`@`) of SDF 1.4, 1.5 and 1.6, block by block, with its default in 1.6 and "
        "whether libgz acts on it. [SDF](sdf.md) says how older and newer versions are read. What is not part of a "
        "file's version is a warning with its line, and has no effect; `libgz sdf --check FILE` prints all of them.\n",
        "In brief: worlds, models, nested models, links, inertias, collisions, visuals, lights, joints of all kinds "
        "with dynamics, limits and springs, surfaces, sensors, plugins, scene, fog, includes, states, actors, "
        "populations, wind, atmosphere and grippers act. Other engines than ODE, shaders, lens models and distortion "
        "do not.\n",
    ]
    blocks: dict[str, list[str]] = {}
    for path in rows:
        blocks.setdefault(re.split("[/@]", path)[0], []).append(path)
    for block in sorted(blocks):
        parts.append(f"## {block}\n")
        parts.append("| element | type | default | from | acts |\n|---|---|---|---|---|")
        for path in blocks[block]:
            inside = path.removeprefix(block).removeprefix("/")
            if inside:
                parts.append(sdf_row(inside, path, rows[path]))
        parts.append("")
    return "\n".join(parts)


def sdf_row(inside: str, path: str, row: dict[str, str]) -> str:
    """A row of an element."""
    kind, default = row["type"] or "", row["default_1.6"] or ""
    if kind.startswith("@"):
        kind = f"[{kind[1:]}](#{kind[1:]})"
    there = [version for version in VERSIONS if row[f"default_{version}"] != ABSENT and row[f"count_{version}"] != "-"]
    span = there[0] if there and there[-1] == VERSIONS[-1] else f"{there[0]} to {there[-1]}" if there else ""
    note, reason = row["note"] or "", without_effect(path)
    unit = f" [{note}]" if note in UNITS else ""
    acts = f"no: {reason}" if reason else "yes" if unit or not note else f"yes: {note}"
    shown = f"`{cell(default)}`" if default not in ("", ABSENT, UNSET) else ""
    return f"| `{inside}` | {kind}{unit} | {shown} | {span} | {cell(acts)} |"


# Worldfiles ----------------------------------------------------------------------------------------------------------


def worldfile_page() -> str:
    """The page about worldfiles, with its tables of settings and quirks."""
    text = (DOCS / "worldfile.md").read_text()
    settings = ["| element | type | default | unit | meaning |", "|---|---|---|---|---|"]
    for row in rows_of(GlobalAttributes):
        settings.append(f"| `{row.name}` | {row.type} | {row.default} | {row.unit} | {cell(row.meaning)} |")
    quirks = ["| quirk | effect |", "|---|---|", *(f"| `{name}` | {cell(effect)} |" for name, effect in QUIRKS.items())]
    for name, table in (("settings", settings), ("quirks", quirks)):
        begin = f"<!-- {name}: made by scripts/make_reference_pages.py -->\n"
        head, _, rest = text.partition(begin)
        text = head + begin + "\n" + "\n".join(table) + "\n\n<!-- end -->" + rest.partition("<!-- end -->")[2]
    return text


# API -----------------------------------------------------------------------------------------------------------------

# Page -> (title, what it has, where its names come from).
API: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "world": ("Worlds and models", "worlds, models, plugins, rates", ("front", "legacy", "simulation")),
    "physics": ("Bodies, geoms, joints", "what models are built from", ("physics",)),
    "geometry": ("Geometry", "vectors, quaternions, poses, colours, with the functions of the old API", ("geometry",)),
    "interfaces": ("Clients and interfaces", "the client, and a class for each interface", ("interfaces",)),
    "worldfile": ("Worldfiles", "elements of worldfiles and their typed getters", ("worldfile",)),
    "observer": ("Observer", "states and shapes of a running world, for other processes", ("transport.observer",)),
    "errors": ("Errors", "the tree of exceptions", ("errors",)),
}
BASES = {"interfaces": (Interface, SampleInterface)}  # classes whose members others have
DATA = ("Data",)  # endings of the names of structs, which docs/interfaces.md has


def api_pages() -> dict[str, str]:
    """The public names of libgz by topic."""
    things = {name: getattr(libgz, name) for name in dir(libgz)}
    own = {name: thing for name, thing in things.items() if getattr(thing, "__module__", "").startswith("libgz.")}
    listed, found = [], {}
    for page, (title, about, places) in API.items():
        names = {n: t for n, t in own.items() if t.__module__.removeprefix("libgz.").startswith(places)}
        names |= {kind.__name__: kind for kind in BASES.get(page, ())}
        found[f"api/{page}.md"] = api_page(title, about, names)
        listed.append(f"| [{title}]({page}.md) | {about} |")
    text = (
        "All public names: `from libgz import World, Client, ...`. The functions and constants of the old API, such "
        "as `gz_position_open` and `dParamVel`, are names of `libgz`, too; [interfaces](../interfaces.md) has the "
        "structs. "
        "Classes for plugins of Gazebo classic are in [libgz.classic](../classic/README.md).\n"
    )
    table = "\n".join(["| page | content |", "|---|---|", *listed, ""])
    return {"api/README.md": f"{NOTE}\n# Python API\n\n{text}\n{table}", **found}


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
    if kind.__init__ is not object.__init__ and not issubclass(kind, BaseException):
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


def write() -> list[Path]:
    """Write the pages that changed."""
    changed = []
    for name, text in pages().items():
        path = DOCS / name
        if not path.exists() or path.read_text() != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            changed.append(path)
    return changed


if __name__ == "__main__":
    write()
