"""Where the plugins that worldfiles name are searched for."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from libgz.base.errors import PluginError
from libgz.clib.prefixes import installed_prefixes
from libgz.legacy.factory import builtin_folder
from libgz.simulation.plugins import Plugin, load_plugin, reload_plugin, search

__all__ = ["find_plugin", "load", "load_edited", "plugin_directories", "register_compiled"]

SHARED = ".so"

_is_compiled: Callable[[Path], bool] | None = None
_load_compiled: Callable[[Path], Plugin] = load_plugin


def register_compiled(is_plugin: Callable[[Path], bool], load: Callable[[Path], Plugin]) -> None:
    """Let worldfiles name shared objects.

    Args:
        is_plugin: whether a file is one that can be loaded.
        load: loads it.
    """
    global _is_compiled, _load_compiled
    _is_compiled, _load_compiled = is_plugin, load


def load(path: Path) -> Plugin:
    """The plugin of a file that `find_plugin` found.

    Raises:
        PluginError: it fails, or registers nothing.
    """
    return _load_compiled(path) if path.suffix == SHARED else load_plugin(path)


def load_edited(path: Path) -> Plugin:
    """The plugin of a file that was edited.

    Raises:
        PluginError: it fails, or registers nothing.
    """
    return _load_compiled(path) if path.suffix == SHARED else reload_plugin(path)


def plugin_directories(worldfile: str | None) -> list[tuple[str, Path]]:
    """(why, directory) of all places where plugins are searched for, in order."""
    named = [("GAZEBOPATH", Path(d)) for d in os.environ.get("GAZEBOPATH", "").split(os.pathsep) if d]
    home = (Path(worldfile).parent if worldfile else Path()).resolve()
    return [
        *named,
        ("the worldfile's directory", home),
        *(("the installed plugins", prefix / "lib" / "gazebo" / "plugins") for prefix in installed_prefixes()),
        ("the installed models", builtin_folder()),
    ]


def find_plugin(name: str, worldfile: str | None) -> Path:
    """The file of a plugin that a legacy worldfile names: a shared object of libgz's C++ adapter, or a Python file.

    An absolute name (or one that begins with `~`) means that file only; others are searched for in each directory of
    GAZEBOPATH, the worldfile's directory, the installed plugins (those of `libgz config --install` first, /usr/local
    last), and the installed models.

    Raises:
        PluginError: it was not found; the message lists every path tried, and why it was rejected.
    """
    name = name.strip()
    if not name:
        raise PluginError("<plugin> is empty; it must name a file, such as ExampleModel.py")
    tried: list[str] = []
    found = search(name, plugin_directories(worldfile), tried, _is_compiled)
    if found is None:
        raise PluginError(f"plugin {name!r} was not found; tried\n" + "\n".join(tried))
    return found
