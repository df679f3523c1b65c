"""Where the plugins that worldfiles name are searched for."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from libgz.errors import PluginError
from libgz.legacy.factory import builtin_folder
from libgz.simulation.plugins import search

__all__ = ["find_plugin", "plugin_directories"]


def plugin_directories(worldfile: str | None) -> list[tuple[str, Path]]:
    """(why, directory) of all places where plugins are searched for, in order."""
    named = [("GAZEBOPATH", Path(d)) for d in os.environ.get("GAZEBOPATH", "").split(os.pathsep) if d]
    home = (Path(worldfile).parent if worldfile else Path()).resolve()
    return [
        *named,
        ("the worldfile's directory", home),
        ("the installed plugins", Path(sys.prefix) / "lib" / "gazebo" / "plugins"),
        ("the installed models", builtin_folder()),
    ]


def find_plugin(name: str, worldfile: str | None) -> Path:
    """The Python file of a plugin that a legacy worldfile names.

    An absolute name (or one that begins with `~`) means that file only; others are searched for in each directory of
    GAZEBOPATH, the worldfile's directory, the installed plugins, and the installed models.

    Raises:
        PluginError: it was not found; the message lists every path tried, and why it was rejected.
    """
    name = name.strip()
    if not name:
        raise PluginError("<plugin> is empty; it must name a Python file, such as ExampleModel.py")
    tried: list[str] = []
    found = search(name, plugin_directories(worldfile), tried)
    if found is None:
        raise PluginError(f"plugin {name!r} was not found; tried\n" + "\n".join(tried))
    return found
