"""libgz new: write a folder with a new model or plugin that runs at once: code, world, client, tests, README."""

from __future__ import annotations

import argparse
import keyword
import re
import sys
from pathlib import Path

from libgz.apps.console import say, writing
from libgz.base.errors import ParameterError
from libgz.models import MODELS

__all__ = ["KINDS", "configure", "run", "write_starter"]

KINDS = ("world", "model", "sensor", "system", "visual", "gui")
STARTERS = Path(__file__).parent / "starters"  # files whose names end with .in
LEGACY = "legacy_model"
# Names of other files in the folder, and of modules that those import: a file beside them would take their place.
OTHERS = {"client", "conftest", "libgz", "numpy", "pytest", *sys.stdlib_module_names}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    what = parser.add_subparsers(dest="what", required=True, metavar="model|plugin")
    text = "a model for worldfiles of Gazebo 0.4 to 0.7: a small robot"
    model = what.add_parser("model", help=text, description=f"Write a folder with {text}.")
    model.add_argument("name", metavar="NAME", help="name of the class and of the folder, such as MyRobot")
    text = "a plugin for SDF worlds"
    plugin = what.add_parser("plugin", help=text, description=f"Write a folder with {text}.")
    plugin.add_argument("--kind", required=True, choices=KINDS, help=f"what it belongs to: {', '.join(KINDS)}")
    plugin.add_argument("name", metavar="NAME", help="name of the file and of the folder, such as my_plugin")
    for command in (model, plugin):
        command.add_argument("--in", dest="parent", default=".", metavar="DIR", help="where to write the folder")


def run(options: argparse.Namespace) -> int:
    """Write the folder, and print what is in it and how to run it.

    Raises:
        GazeboError: the name is not allowed, or the folder exists or cannot be written.
    """
    kind = LEGACY if options.what == "model" else options.kind
    folder = Path(options.parent) / options.name
    with writing():
        written = write_starter(kind, options.name, folder)
    for path in written:
        say(path)
    world = next(path.name for path in written if path.suffix == ".world")
    plugin = f"-s lib{_snake(options.name)}.so " if kind == "system" else ""
    command = f"gazebo {world}" if kind == LEGACY else f"gzserver --verbose {plugin}{world}"
    steps = f"run it:   cd {folder} && {command}\ntest it:  cd {folder} && pytest\nread on:  {folder / 'README.md'}"
    say(f"\n{steps}")
    return 0


def write_starter(kind: str, name: str, folder: Path) -> list[Path]:
    """Write the files of a new model or plugin; returns their paths.

    Args:
        kind: a kind of plugin, one of `KINDS`, or "legacy_model".
        name: of the model's class, or of the plugin's file.
        folder: where to write; it must not exist.

    Raises:
        ParameterError: the name is not allowed, or the folder exists.
        OSError: a file cannot be written.
    """
    _check_name(kind, name)
    if folder.exists():
        raise ParameterError(f"{folder} exists; choose another name, another --in, or remove it")
    names = {"MyName": name if kind == LEGACY else _camel(name), "my_name": _snake(name)}
    folder.mkdir(parents=True)
    written = []
    for source in sorted((STARTERS / kind).glob("*.in")):
        path = folder / _renamed(source.name.removesuffix(".in"), names)
        path.write_text(_renamed(source.read_text(encoding="utf-8"), names), encoding="utf-8")
        written.append(path)
    return written


def _check_name(kind: str, name: str) -> None:
    """Raise ParameterError for what cannot be the name of a class and a file."""
    usable = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    what = "a name has letters, digits and _, and does not begin with a digit or _"
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        hint = f"; did you mean {usable!r}?" if re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", usable) else ""
        raise ParameterError(f"{name!r} is not a name: {what}{hint}")
    if {name, _snake(name)} & {*OTHERS, *keyword.kwlist}:
        raise ParameterError(f"{name!r} has a meaning of its own in Python or in the new folder; choose another name")
    if kind == LEGACY and name in MODELS:
        raise ParameterError(f"{name!r} is a model of libgz: see `libgz models {name}`; choose another name")


def _snake(name: str) -> str:
    """MyRobot2 -> my_robot2, HTTPServer -> http_server."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name).lower()


def _camel(name: str) -> str:
    """my_plugin -> MyPlugin."""
    return "".join(word[0].upper() + word[1:] for word in name.split("_") if word)


def _renamed(text: str, names: dict[str, str]) -> str:
    for placeholder, name in names.items():
        text = text.replace(placeholder, name)
    return text
