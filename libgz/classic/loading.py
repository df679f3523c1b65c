"""Loading plugins by the rules of Gazebo classic, and calling them so that none of them can end the server."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Any
from weakref import WeakSet

from libgz.classic.common import SystemPaths
from libgz.classic.plugin import KINDS, PluginT
from libgz.errors import PluginError
from libgz.simulation.event import Ends, WorldEvents, owner
from libgz.simulation.plugins import Plugin as PluginFile, load_plugin, own_traceback, search

__all__ = ["LoadedPlugin", "find_plugin", "new_plugin"]

log = logging.getLogger("libgz.classic")

READY = Path(__file__).parent / "plugins"


class LoadedPlugin:
    """A plugin with its place. What it raises is reported, and stops it and nothing else.

    Args:
        plugin_class: what its file registered.
        filename, name: as the world has them.
        events: of the world that it belongs to; None for all worlds.
    """

    def __init__(self, plugin_class: type[PluginT], filename: str, name: str, events: WorldEvents | None) -> None:
        self.plugin_class = plugin_class
        self.filename, self.name, self.events = filename, name, events
        self.connections: WeakSet[Ends] = WeakSet()
        self.plugin: PluginT | None = None
        self._construct()

    def _construct(self) -> None:
        token = owner.set(self)
        try:
            # Handle and filename are there in the constructor already, for the plugin's own messages.
            plugin = self.plugin_class.__new__(self.plugin_class)
            plugin._handle, plugin._filename = self.name, self.filename
            self.plugin = plugin
            plugin.__init__()  # type: ignore[misc]
        except Exception as error:  # noqa: BLE001 - a plugin's
            self.stop("the constructor", error)
        finally:
            owner.reset(token)

    def __str__(self) -> str:
        return f"plugin with name[{self.name}] and filename[{self.filename}]"

    def start(self, *values: Any) -> bool:
        """Load with these values, then Init; whether the plugin runs."""
        return self.call("Load", *values) and self.call("Init")

    def call(self, function: str, *values: Any) -> bool:
        """Call one of the plugin's functions; whether it runs still."""
        if self.plugin is None:
            return False
        token = owner.set(self)
        try:
            getattr(self.plugin, function)(*values)
        except Exception as error:  # noqa: BLE001 - a plugin's
            self.stop(f"the {function} function", error)
        finally:
            owner.reset(token)
        return self.plugin is not None

    def stop(self, where: str, error: BaseException) -> None:
        """Report what the plugin raised, and let it go."""
        text, file = own_traceback(error), getattr(sys.modules.get(self.plugin_class.__module__), "__file__", None)
        if file is not None and file not in text:
            text = f'  File "{file}"\n{text}'
        log.error("Exception occured in %s of %s. This plugin will not run.\n%s", where, self, text)
        self.drop()

    def drop(self) -> None:
        """Let the plugin go, with all it is connected to."""
        for connection in list(self.connections):
            connection.disconnect()
        self.connections.clear()
        self.plugin = None


def find_plugin(filename: str, beside: str | None = None) -> Path:
    """The Python file of a plugin: in GAZEBO_PLUGIN_PATH, as it stands, beside the world, among the ready plugins.

    `libX.so` means `libX.py` or `X.py`.

    Raises:
        PluginError: it is nowhere, in classic's words, with every place that was tried.
    """
    name = filename.strip()
    places = [("GAZEBO_PLUGIN_PATH", Path(folder)) for folder in SystemPaths.Instance().GetPluginPaths()]
    places.append(("the current directory", Path()))
    if beside:
        places.append(("the world's directory", Path(beside).parent.resolve()))
    places.append(("the plugins of libgz", READY))
    tried: list[str] = []
    found = search(name, places, tried) if name else None
    if found is None:
        raise PluginError(
            f"Failed to load plugin {name}: {name}: cannot open shared object file: No such file or directory; tried\n"
            + "\n".join(tried)
        )
    return found


def new_plugin(
    kind: str, filename: str, name: str, holder: str, events: WorldEvents | None, beside: str | None = None
) -> LoadedPlugin | None:
    """Find a plugin, run its file, and construct its class; None if it will not run, after telling why.

    Args:
        kind: World, Model, Sensor, System, Visual or GUI.
        filename, name: as the world has them.
        holder: who loads it, for messages: ``World[default]``.
        events: of the world that it belongs to; None for all worlds.
        beside: the world's file.
    """
    try:
        path = find_plugin(filename, beside)
    except PluginError as error:
        log.error("%s", error)
        return None
    try:
        file = load_plugin(path)
    except PluginError as error:
        log.error("Failed to load plugin %s: %s", path, error)
        return None
    registered = _registered(file)
    if len(registered) > 1:
        log.error("Failed to load plugin %s: it registers %d classes; one file has one plugin", path, len(registered))
        return None
    if not registered:
        log.error("Failed to resolve RegisterPlugin: %s registers no plugin of Gazebo classic", path)
        return None
    found, plugin_class = registered[0]
    if found != kind:
        at_name = f" name[{name}]" if kind not in ("System", "GUI") else ""
        log.error(
            "%s is attempting to load a plugin, but detected an incorrect plugin type. Plugin filename[%s]%s; "
            "it is a %sPlugin",
            holder,
            filename,
            at_name or ".",
            found,
        )
        return None
    loaded = LoadedPlugin(plugin_class, filename, name, events)
    return loaded if loaded.plugin is not None else None


def _registered(file: PluginFile) -> list[tuple[str, type[PluginT]]]:
    return [(kind, found) for kind, found in file.registered if kind in KINDS]
