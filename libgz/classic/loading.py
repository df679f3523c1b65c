"""Loads plugins by the rules of Gazebo classic, and calls them so that no error of theirs ends the server."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from weakref import WeakSet

from libgz.classic.common import SystemPaths
from libgz.classic.plugin_base import PluginT
from libgz.classic.ros_names import stand_in
from libgz.errors import USER_ERRORS, PluginError, pass_interrupt
from libgz.simulation.entity import Entity
from libgz.simulation.event import Ends, WorldEvents, owner
from libgz.simulation.plugins import Plugin as PluginFile, load_plugin, own_traceback, search
from libgz.simulation.problems import NOTED, note, note_threads_of
from libgz.simulation.running_code import names
from libgz.simulation.state import declares, get_state, set_state

__all__ = ["LoadedPlugin", "find_plugin", "new_plugin"]

log = logging.getLogger("libgz.classic")

# The folder of the ready plugins.
READY = Path(__file__).parent / "plugins"


class LoadedPlugin:
    """A loaded plugin. An exception that it raises is logged, and stops this plugin only.

    Args:
        plugin_class: the class that its file registered.
        filename, name: as the world gives them.
        events: those of the world that it belongs to; None: those of all worlds.
        entity: the model that it is a plugin of; its `error` is then what the plugin raises.

    Attributes:
        plugin: the instance; None once it has failed or was dropped.
        source: the text of its element, if that is not in the world's file.
    """

    def __init__(
        self,
        plugin_class: type[PluginT],
        filename: str,
        name: str,
        events: WorldEvents | None,
        entity: Entity | None = None,
    ) -> None:
        self.plugin_class, self.entity = plugin_class, entity
        self.filename, self.name, self.events = filename, name, events
        self.connections: WeakSet[Ends] = WeakSet()
        self.source = ""
        self.plugin: PluginT | None = None
        self._construct()

    def _construct(self) -> None:
        token = owner.set(self)
        try:
            # The plugin's own constructor may use handle and filename in messages.
            plugin = self.plugin_class.__new__(self.plugin_class)
            plugin._handle, plugin._filename = self.name, self.filename
            self.plugin = plugin
            plugin.__init__()  # type: ignore[misc]
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.stop("the constructor", error)
        finally:
            owner.reset(token)

    def __str__(self) -> str:
        return f"plugin with name[{self.name}] and filename[{self.filename}]"

    def start(self, *values: Any) -> bool:
        """Call Load with these values, then Init; returns whether the plugin runs."""
        return self.load(*values) and self.init()

    def load(self, *values: Any) -> bool:
        """Call the plugin's Load with these values; returns whether the plugin runs."""
        # Each kind of plugin has a Load with arguments of its own.
        return self.plugin is not None and self._call("Load", self.plugin.Load, *values)  # type: ignore[attr-defined]

    def init(self) -> bool:
        """Call the plugin's Init; returns whether the plugin still runs."""
        return self.plugin is not None and self._call("Init", self.plugin.Init)

    def reset(self) -> bool:
        """Call the plugin's Reset; returns whether the plugin still runs."""
        return self.plugin is not None and self._call("Reset", self.plugin.Reset)

    # State -------------------------------------------------------------------------------------------------------

    def save(self) -> Any:
        """The plugin's declared state; None without one.

        Raises:
            PluginError: an attribute that it declares is missing, or its SaveState failed.
        """
        kind: Any = self.plugin_class
        if self.plugin is None or not declares(kind):
            return None
        return self._guarded("saved", get_state, self.plugin)

    def load_state(self, state: Any) -> None:
        """Give the plugin a state that `save` returned.

        Raises:
            PluginError: its LoadState failed.
        """
        if self.plugin is not None and state is not None:
            self._guarded("restored", set_state, self.plugin, state)

    def _guarded(self, what: str, function: Callable[..., Any], *values: Any) -> Any:
        token = owner.set(self)
        try:
            return function(*values)
        except USER_ERRORS as error:
            pass_interrupt(error)
            raise PluginError(f"the state of {self} cannot be {what}:\n{own_traceback(error)}") from error
        finally:
            owner.reset(token)

    def _call(self, name: str, function: Callable[..., object], *values: Any) -> bool:
        token = owner.set(self)
        try:
            function(*values)
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.stop(f"the {name} function", error)
        finally:
            owner.reset(token)
        return self.plugin is not None

    def stop(self, where: str, error: BaseException) -> None:
        """Log the exception that the plugin raised, and drop the plugin."""
        text, file = own_traceback(error), getattr(sys.modules.get(self.plugin_class.__module__), "__file__", None)
        if file is not None and file not in text:
            text = f'  File "{file}"\n{text}'
        note(str(self), where, error)
        if self.entity is not None:
            self.entity.plugin_error = error
        log.error("Exception occured in %s of %s. This plugin will not run.\n%s", where, self, text, extra=NOTED)
        self.drop()

    def drop(self) -> None:
        """End the plugin, its connections and its subscriptions."""
        for connection in list(self.connections):
            connection.disconnect()
        self.connections.clear()
        self.plugin = None


names(LoadedPlugin._call, lambda values: f"{values['name']} of {values['self']}")
names(LoadedPlugin._construct, lambda values: f"the constructor of {values['self']}")


def find_plugin(filename: str, beside: str | None = None) -> Path:
    """The Python file of a plugin, from GAZEBO_PLUGIN_PATH, the current directory, the world's, or the ready plugins.

    `libX.so` means `libX.py` or `X.py`.

    Raises:
        PluginError: there is no such file; the message is classic's, with every place that was searched.
    """
    name = filename.strip()
    places = [("GAZEBO_PLUGIN_PATH", Path(folder)) for folder in SystemPaths.Instance().GetPluginPaths()]
    places.append(("the current directory", Path()))
    if beside:
        places.append(("the world's directory", Path(beside).parent.resolve()))
    places.append(("the plugins of libgz", READY))
    tried: list[str] = []
    found = search(name, places, tried) if name else None
    if found is None and (ready := stand_in(name)) is not None:
        found = READY / f"{ready}.py"
    if found is None:
        raise PluginError(
            f"Failed to load plugin {name}: {name}: cannot open shared object file: No such file or directory; tried\n"
            + "\n".join(tried)
        )
    return found


def new_plugin(
    kind: str,
    filename: str,
    name: str,
    holder: str,
    events: WorldEvents | None,
    beside: str | None = None,
    entity: Entity | None = None,
) -> LoadedPlugin | None:
    """Find a plugin, run its file, and construct its class; None if that fails, which is logged.

    Args:
        kind: World, Model, Sensor, System, Visual or GUI.
        filename, name: as the world gives them.
        holder: the loading object, for messages, such as ``World[default]``.
        events: those of the world that it belongs to; None: those of all worlds.
        beside: the world's file.
        entity: the model that it is a plugin of.
    """
    try:
        path = find_plugin(filename, beside)
    except PluginError as error:
        log.error("%s", error)
        return None
    try:
        note_threads_of(path)
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
    (plugin_class,) = registered
    if plugin_class.kind != kind:
        at_name = f" name[{name}]" if kind not in ("System", "GUI") else ""
        log.error(
            "%s is attempting to load a plugin, but detected an incorrect plugin type. Plugin filename[%s]%s; "
            "it is a %sPlugin",
            holder,
            filename,
            at_name or ".",
            plugin_class.kind,
        )
        return None
    loaded = LoadedPlugin(plugin_class, filename, name, events, entity)
    return loaded if loaded.plugin is not None else None


def _registered(file: PluginFile) -> list[type[PluginT]]:
    """The classic plugin classes among all that a file registered."""
    return [found for _, found in file.registered if isinstance(found, type) and issubclass(found, PluginT)]
