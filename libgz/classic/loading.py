"""Loads plugins by the rules of Gazebo classic, and calls them so that no error of theirs ends the server."""

from __future__ import annotations

import gc
import itertools
import logging
import sys
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any
from weakref import WeakSet

from libgz.base.errors import USER_ERRORS, GazeboError, ParameterError, PluginError, StateError, pass_interrupt
from libgz.base.trust import UntrustedError, check_trusted
from libgz.base.visible import one_line
from libgz.classic.common import SystemPaths
from libgz.classic.plugin_base import PluginT
from libgz.classic.ros_names import absence, provided, providers, stand_in
from libgz.classic.transport.subscriber import Subscriber
from libgz.simulation.entity import Entity
from libgz.simulation.event import Connection, Ends, WorldEvents, owner
from libgz.simulation.plugins import Plugin as PluginFile, called, load_plugin, own_traceback, reload_plugin, search
from libgz.simulation.problems import NOTED, note, note_threads_of
from libgz.simulation.running_code import names
from libgz.simulation.state import carry_state, check, declares, fields, get_state, set_state

__all__ = [
    "LoadedPlugin",
    "Missing",
    "MissingPluginError",
    "called",
    "find_plugin",
    "is_ready",
    "new_plugin",
    "register_compiled",
    "reload_all",
]

log = logging.getLogger("libgz.classic")

# The folder of the ready plugins.
READY = Path(__file__).parent / "plugins"

_numbers = itertools.count()

_is_compiled: Callable[[Path], bool] | None = None
_load_compiled: Callable[[Path], PluginFile] = load_plugin
SHARED = ".so"


def register_compiled(is_plugin: Callable[[Path], bool], load: Callable[[Path], PluginFile]) -> None:
    """Let worlds name shared objects.

    Args:
        is_plugin: whether a file is one that can be loaded.
        load: loads it, again if it was built again.
    """
    global _is_compiled, _load_compiled
    _is_compiled, _load_compiled = is_plugin, load


class LoadedPlugin:
    """A loaded plugin. An exception that it raises is logged, and stops this plugin only.

    Args:
        plugin_class: the class that its file registered.
        filename, name: as the world gives them.
        path: its file.
        events: those of the world that it belongs to; None: those of all worlds.
        entity: the model that it is a plugin of; its `error` is then what the plugin raises.
        where: ``file:line`` of its element; empty if it has none.

    Attributes:
        plugin: the instance; None once it has failed or was dropped.
        source: the text of its element, if that is not in the world's file.
        prepare: what is done with a new instance before its Load.
        number: of the order in which plugins were loaded, which is that of their callbacks.
    """

    plugin: PluginT | None
    source: str
    number: int

    def __init__(
        self,
        plugin_class: type[PluginT],
        filename: str,
        name: str,
        path: Path,
        events: WorldEvents | None,
        entity: Entity | None = None,
        where: str = "",
    ) -> None:
        self.plugin_class, self.entity, self.where = plugin_class, entity, where
        self.filename, self.name, self.path, self.events = filename, name, path, events
        self.connections: WeakSet[Ends] = WeakSet()
        self.source = ""
        self.number = next(_numbers)
        self.plugin = None
        self.prepare: Callable[[PluginT], object] = lambda _plugin: None
        self._values: tuple[Any, ...] | None = None  # of its Load
        self._construct()

    def _construct(self) -> None:
        token = owner.set(self)
        try:
            self._make()
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.stop("the constructor", error)
        finally:
            owner.reset(token)

    def _make(self) -> PluginT:
        """A new instance. Its constructor may use handle and filename in messages."""
        plugin = self.plugin = self.plugin_class.__new__(self.plugin_class)
        plugin.handleName, plugin.filename = self.name, self.filename
        plugin.__init__()  # type: ignore[misc]
        return plugin

    def __str__(self) -> str:
        return f"plugin with name[{self.name}] and filename[{self.filename}]"

    def start(self, *values: Any) -> bool:
        """Call Load with these values, then Init; returns whether the plugin runs."""
        return self.load(*values) and self.init()

    def load(self, *values: Any) -> bool:
        """Call the plugin's Load with these values; returns whether the plugin runs."""
        self._values = values
        if self.plugin is not None:
            self.prepare(self.plugin)
        # Each kind of plugin has a Load with arguments of its own.
        return self.plugin is not None and self._call("Load", self.plugin.Load, *values)  # type: ignore[attr-defined]

    def init(self) -> bool:
        """Call the plugin's Init; returns whether the plugin still runs."""
        return self.plugin is not None and self._call("Init", self.plugin.Init)

    def reset(self) -> bool:
        """Call the plugin's Reset; returns whether the plugin still runs."""
        return self.plugin is not None and self._call("Reset", self.plugin.Reset)

    # Reload ------------------------------------------------------------------------------------------------------

    def called(self, name: str, holder: str) -> bool:
        """Whether a name means this plugin: its own, alone or after that of its holder, or its file's."""
        return name in (self.name, self.filename, f"{holder}::{self.name}") or called(self.path, name)

    def reload(self, file: PluginFile) -> None:
        """Replace the instance by one of its file's present class, with the same Load and what state both declare.

        The connections, subscriptions and publications of the former instance end.

        Raises:
            PluginError: the new class fails before it runs; the former instance then continues.
        """
        kind = self.plugin_class.kind
        plugin_class = _only_class(file)
        if plugin_class.kind != kind:
            raise PluginError(f"{file.path} registers a {plugin_class.kind}Plugin now; {self} is a {kind}Plugin")
        state = self._state_to_carry()
        old = self.plugin, self.plugin_class, self.connections
        self.plugin_class, self.connections = plugin_class, WeakSet()
        try:
            self._renew(state)
        except PluginError:
            self._disconnect()
            self.plugin, self.plugin_class, self.connections = old
            raise
        for connection in list(old[2]):
            connection.disconnect()
        if self.entity is not None:
            self.entity.plugin_error = None

    def _state_to_carry(self) -> Any:
        try:
            return self.save()
        except PluginError as error:  # which the edit may correct
            log.warning("%s is loaded again without its state: %s", self, error)
            return None

    def _renew(self, state: Any) -> None:
        """Make and load a new instance.

        Raises:
            PluginError: it fails.
        """
        token, doing = owner.set(self), "the constructor"
        try:
            plugin: Any = self._make()
            self.prepare(plugin)
            if self._values is not None:
                doing = "Load"
                plugin.Load(*self._values)
                doing = "Init"
                plugin.Init()
            if state is not None:
                doing = "the return of its state"
                carry_state(plugin, state)
        except USER_ERRORS as error:
            pass_interrupt(error)
            text = own_traceback(error)
            raise PluginError(f"{doing} of the edited {self}, {self.path}, failed with\n{text}") from error
        finally:
            owner.reset(token)

    # State -------------------------------------------------------------------------------------------------------

    @property
    def keeps(self) -> bool:
        """Whether its class declares state that is more than nothing."""
        kind: Any = self.plugin_class
        return declares(kind) and bool(fields(kind))

    def save(self) -> Any:
        """The plugin's declared state; None without one.

        Raises:
            PluginError: an attribute that it declares is missing, or its SaveState failed.
        """
        if self.plugin is None or not self.keeps:
            return None
        return self._guarded("saved", get_state, self.plugin)

    def check_state(self) -> None:
        """Find out which attribute keeps the plugin's state from being encoded.

        Raises:
            ParameterError: there is one, which is named.
        """
        if self.plugin is not None and self.keeps:
            try:
                check(self.plugin)
            except ParameterError as error:
                raise ParameterError(f"{self}: {error}") from error

    def precede(self, others: Collection[LoadedPlugin]) -> None:
        """Have its callbacks of events and topics called before those of others."""
        for connection in list(self.connections):
            if isinstance(connection, Connection | Subscriber):
                connection.precede(others)

    def load_state(self, state: Any) -> None:
        """Give the plugin a state that `save` returned.

        Raises:
            PluginError: its LoadState failed.
        """
        if self.plugin is not None and state:
            self._guarded("restored", set_state, self.plugin, state)

    def _guarded(self, what: str, function: Callable[..., Any], *values: Any) -> Any:
        token = owner.set(self)
        try:
            return function(*values)
        except USER_ERRORS as error:
            pass_interrupt(error)
            reason = f" {error}" if isinstance(error, (ParameterError, StateError)) else f"\n{own_traceback(error)}"
            raise PluginError(f"the state of {self} cannot be {what}:{reason}") from error
        finally:
            owner.reset(token)

    def _call(self, name: str, function: Callable[..., object], *values: Any) -> bool:
        token = owner.set(self)
        try:
            function(*values)
        except USER_ERRORS as error:
            pass_interrupt(error)
            self.stop(f"the {name} function", error, function)
        finally:
            owner.reset(token)
        return self.plugin is not None

    def stop(self, where: str, error: BaseException, called: Callable[..., object] | None = None) -> None:
        """Log the exception that the plugin, or its method `called`, raised, and drop the plugin."""
        text = own_traceback(error, called=called)
        file = getattr(sys.modules.get(self.plugin_class.__module__), "__file__", None)
        if file is not None and isinstance(error, GazeboError) and is_ready(Path(file)):
            text = str(error)  # of the world's file, not of the plugin's code
        elif file is not None and file not in text:
            text = f'  File "{file}"\n{text}'
        elif file is None:
            # Its frames are those of libgz, and hold an object of C++, which holds the world unseen by the collector.
            error.__traceback__ = None
        note(str(self), where, error, self.where)
        if self.entity is not None:
            self.entity.plugin_error = error
        place, words = _place(self.where), "%sException occured in %s of %s. This plugin will not run.\n%s"
        log.error(words, place, where, self, text, extra=NOTED)
        self.drop()

    def drop(self) -> None:
        """End the plugin, its connections, subscriptions and publications."""
        self._disconnect()
        self.plugin = None

    def _disconnect(self) -> None:
        for connection in list(self.connections):
            connection.disconnect()
        self.connections.clear()


names(LoadedPlugin._renew, lambda values: f"{values['doing']} of {values['self']}")
names(LoadedPlugin._call, lambda values: f"{values['name']} of {values['self']}")
names(LoadedPlugin._construct, lambda values: f"the constructor of {values['self']}")


class MissingPluginError(PluginError):
    """There is no file of a plugin.

    Attributes:
        summary: the message without the places.
    """

    def __init__(self, name: str, tried: Sequence[str]) -> None:
        name = one_line(name)
        self.summary = (
            f"Failed to load plugin {name}: {name}: cannot open shared object file: No such file or directory; tried"
        )
        super().__init__("\n".join([self.summary, *map(one_line, tried)]))


class Missing:
    """Logs which plugins have no file: each name once a world, and once where they were searched for."""

    def __init__(self, _world: object = None) -> None:
        self._reported: set[str] = set()
        self._places_known = False

    def report(self, filename: str, error: MissingPluginError, where: str) -> None:
        """Log that a plugin has no file, unless that is known; `where` is ``file:line`` of its element."""
        known = absence(filename)
        text = known or (f"{error.summary} the places above" if self._places_known else str(error))
        key = known or filename
        if key in self._reported:
            return
        self._reported.add(key)
        self._places_known = self._places_known or known is None
        log.log(logging.WARNING if known else logging.ERROR, "%s%s", _place(where), text)


def is_ready(path: Path) -> bool:
    """Whether a plugin's file is one of those that come with libgz."""
    folders = (READY, *(provider.folder for provider in providers))
    ready = [folder / path.name for folder in folders]
    return path.exists() and any(one.exists() and one.samefile(path) for one in ready)  # an editable one has links


def find_plugin(filename: str, beside: str | None = None) -> Path:
    """The file of a plugin, from GAZEBO_PLUGIN_PATH, the current directory, the world's, or the ready plugins.

    `libX.so` is a shared object that was built with libgz, or means `libX.py` or `X.py`.

    Raises:
        MissingPluginError: there is no such file; the message is classic's, with every place that was searched.
    """
    name = filename.strip()
    places = [("GAZEBO_PLUGIN_PATH", Path(folder)) for folder in SystemPaths.Instance().GetPluginPaths()]
    places.append(("the current directory", Path()))
    if beside:
        places.append(("the world's directory", Path(beside).parent.resolve()))
    tried: list[str] = []
    found = search(name, places, tried, _is_compiled) if name else None
    if found is None and name:
        found = provided(name) or search(name, [("the plugins of libgz", READY)], tried)
    if found is None and (ready := stand_in(name)) is not None:
        found = READY / f"{ready}.py"
    if found is None:
        raise MissingPluginError(name, tried)
    return found


def new_plugin(
    kind: str,
    filename: str,
    name: str,
    holder: str,
    events: WorldEvents | None,
    beside: str | None = None,
    entity: Entity | None = None,
    missing: Missing | None = None,
    where: str = "",
) -> LoadedPlugin | None:
    """Find a plugin, run its file, and construct its class; None if that fails, which is logged.

    Args:
        kind: World, Model, Sensor, System, Visual or GUI.
        filename, name: as the world gives them.
        holder: the loading object, for messages, such as ``World[default]``.
        events: those of the world that it belongs to; None: those of all worlds.
        beside: the world's file.
        entity: the model that it is a plugin of.
        missing: logs that there is no such file.
        where: ``file:line`` of its element.
    """
    try:
        check_trusted(f"plugin {filename!r}")
        path = find_plugin(filename, beside)
        plugin_class = _load_class(path)
    except MissingPluginError as error:
        (missing or Missing()).report(filename, error, where)
        return None
    except UntrustedError as error:
        log.warning("%s%s", _place(where), error)
        return None
    except PluginError as error:
        log.error("%s%s", _place(where), error)
        return None
    if plugin_class.kind != kind:
        at_name = f" name[{name}]" if kind not in ("System", "GUI") else ""
        log.error(
            "%s%s is attempting to load a plugin, but detected an incorrect plugin type. Plugin filename[%s]%s; "
            "it is a %sPlugin",
            _place(where),
            holder,
            filename,
            at_name or ".",
            plugin_class.kind,
        )
        return None
    loaded = LoadedPlugin(plugin_class, filename, name, path, events, entity, where)
    return loaded if loaded.plugin is not None else None


def _place(where: str) -> str:
    """What begins a message about the element of a plugin, as diagnostics do."""
    return f"{where}: <plugin>: " if where else ""


def _load_class(path: Path) -> type[PluginT]:
    """The class of a plugin file.

    Raises:
        PluginError: the file fails, or does not register one class.
    """
    try:
        note_threads_of(path)
        file = _load_compiled(path) if path.suffix == SHARED else load_plugin(path)
    except PluginError as error:
        raise PluginError(f"Failed to load plugin {path}: {error}") from error
    return _only_class(file)


def _only_class(file: PluginFile) -> type[PluginT]:
    """The one plugin class of classic among all that a file registered.

    Raises:
        PluginError: there is none, or there are several.
    """
    found = [one for _, one in file.registered if isinstance(one, type) and issubclass(one, PluginT)]
    if len(found) > 1:
        raise PluginError(
            f"Failed to load plugin {file.path}: it registers {len(found)} classes; one file has one plugin"
        )
    if not found:
        raise PluginError(f"Failed to resolve RegisterPlugin: {file.path} registers no plugin of Gazebo classic")
    return found[0]


def reload_all(plugins: Sequence[LoadedPlugin]) -> None:
    """Run the files of plugins again, each once, and replace the plugins' instances.

    Raises:
        PluginError: a file or one of its plugins fails; that one and those after it continue as before.
    """
    files: dict[Path, PluginFile] = {}
    for plugin in plugins:
        if plugin.path not in files:
            note_threads_of(plugin.path)
            reload = _load_compiled if plugin.path.suffix == SHARED else reload_plugin
            files[plugin.path] = reload(plugin.path)
        plugin.reload(files[plugin.path])
    gc.collect()  # what the former instances hold ends with them, such as their loads of batteries
