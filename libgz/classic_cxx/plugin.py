"""CompiledPlugin: a shared object of classic's API, as a plugin class of `libgz.classic`."""

from __future__ import annotations

import ctypes
import functools
import logging
import os
import re
import socket
import sys
from collections.abc import Callable
from ctypes import c_char_p, c_int, c_void_p, py_object
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from libgz.base.errors import PluginError
from libgz.base.files import read_limited
from libgz.base.trust import check_trusted
from libgz.classic.gui import GUI
from libgz.classic.plugin import GUIPlugin, ModelPlugin, SensorPlugin, SystemPlugin, VisualPlugin, WorldPlugin
from libgz.classic.plugin_base import PluginT
from libgz.classic_cxx import rows
from libgz.classic_cxx.desktop import desktop
from libgz.classic_cxx.library import IGNITION, MESSAGES, SONAME, WIDGETS, cache_folder, source_key
from libgz.classic_cxx.own_messages import OwnMessages, mapped
from libgz.cxx.host import frames_address, install, loading, track, watch
from libgz.cxx.shared_object import SharedObject
from libgz.simulation.event import owner
from libgz.simulation.plugins import Plugin, edition

__all__ = ["CompiledPlugin", "is_plugin", "load"]

log = logging.getLogger("libgz.plugin")

KINDS: dict[str, type[PluginT]] = {
    "GUI": GUIPlugin,
    "Model": ModelPlugin,
    "Sensor": SensorPlugin,
    "System": SystemPlugin,
    "Visual": VisualPlugin,
    "World": WorldPlugin,
}
MARK = re.compile(rb"libgz classic plugin: (\w{1,20}); ([0-9a-f]{1,40}-[0-9a-f]{1,40}); ([^;\0]{1,4096});")
ROSCPP = b"libroscpp.so"
TRANSPORT = b"libignition-transport"
NODE = "gazebo_plugins"  # the node of plugins for ROS 1
PATIENCE = 1.0  # [s] for ROS's master
INIT, RESET, DELETE = range(3)  # as in bridge.cc
NOT_KEPT = "states and resets do not keep the variables of its C++ object, which libgz does not know"

_loaded: dict[Path, Plugin] = {}
_messages = OwnMessages()
_library: list[tuple[str, Any]] = []  # key and functions of the one library of the process


def _mark_of(path: Path) -> tuple[str, str, Path] | None:
    """Kind, key of the library and its folder; None if a file is no plugin of classic that was built with libgz."""
    try:
        found = MARK.search(read_limited(path))
    except OSError as error:
        raise PluginError(f"error loading plugin: {path}: {error.strerror}") from None
    if found is None:
        return None
    kind, key, folder = (part.decode(errors="surrogateescape") for part in found.groups())
    return kind, key, Path(folder)


def is_plugin(path: Path) -> bool:
    """Whether a file is a plugin of classic that was built with some libgz."""
    return _mark_of(path) is not None


def _functions(path: Path, key: str, folder: Path) -> Any:
    """The library of a plugin: loaded once, so that all plugins share its classes."""
    if key.partition("-")[0] != source_key():
        raise PluginError(
            f"error loading plugin: {path} was built with another version of libgz or Python; build it again: "
            "libgz config --install-classic, then cmake or make; or libgz cxx build"
        )
    if _library:
        if _library[0][0] != key:
            raise PluginError(
                f"error loading plugin: {path} was built with another compiler or distribution than the plugins before "
                "it; build it again"
            )
        return _library[0][1]
    place = folder if (folder / SONAME).is_file() else cache_folder() / key / "lib"
    if not (place / SONAME).is_file():
        raise PluginError(
            f"error loading plugin: {path} needs {SONAME}, which is not in {folder} any more; "
            "libgz config --install-classic installs it"
        )
    install()
    try:
        ctypes.CDLL(str(place / MESSAGES), mode=os.RTLD_NOW | os.RTLD_GLOBAL)
        functions = ctypes.PyDLL(str(place / SONAME), mode=os.RTLD_NOW | os.RTLD_GLOBAL)
    except OSError as error:
        raise PluginError(f"error loading plugin: {path} needs {SONAME}, which cannot be loaded: {error}") from None
    kinds: dict[str, tuple[Any, list[Any]]] = {
        "start": (None, [c_void_p]),
        "create": (c_void_p, [c_void_p, c_char_p, c_char_p, c_char_p, py_object]),
        "load": (None, [c_void_p, py_object, py_object]),
        "call": (None, [c_void_p, c_int]),
        "start_roscpp": (c_int, [c_void_p, c_char_p]),
    }
    for name, (result, arguments) in kinds.items():
        function = functions[f"libgz_{name}"]
        function.restype, function.argtypes = result, arguments
        setattr(functions, name, function)
    functions.start(frames_address())
    rows.start(functions)
    _library.append((key, functions))
    return functions


class CompiledPlugin:
    """What the plugin classes of shared objects have in common: each call goes to the C++ object.

    Attributes:
        shared: the shared object, in memory as long as a class, an object or a callback of it.
        maker: the address of the function that makes an object.
        functions: those of the library.
        path: the file.
    """

    shared: SharedObject
    maker: int
    functions: Any
    path: Path
    handleName: str
    filename: str
    not_kept = NOT_KEPT
    _object: int | None = None

    def __init__(self) -> None:
        label = f"plugin {self.handleName!r} ({self.path})"
        self._object = self.functions.create(
            self.maker,
            os.fsencode(self.filename),
            self.handleName.encode(errors="surrogateescape"),
            label.encode(errors="surrogateescape"),
            self.shared,
        )

    def Load(self, *values: Any) -> None:
        """Call the plugin's Load."""
        holder, element = (None, *values) if len(values) == 1 else (*values, None)[:2]
        self.functions.load(self._object, holder, element)
        watch()

    def Init(self) -> None:
        """Call the plugin's Init."""
        self.functions.call(self._object, INIT)
        watch()

    def Reset(self) -> None:
        """Call the plugin's Reset."""
        self.functions.call(self._object, RESET)

    def _deletion(self) -> Callable[[], None] | None:
        """What deletes the C++ object, once; it needs this one no more."""
        plugin, self._object = self._object, None
        if plugin is None or sys.is_finalizing():
            return None
        return functools.partial(_delete, self.functions, plugin, f"{self.handleName!r} ({self.path})")

    def __del__(self) -> None:
        deletion = self._deletion()
        if deletion is not None:
            deletion()


def _delete(functions: Any, plugin: int, label: str) -> None:
    try:
        functions.call(plugin, DELETE)
    except PluginError as error:
        log.error("the destructor of plugin %s failed: %s", label, error)


class WithWidgets(CompiledPlugin):
    """A GUI plugin that is a widget of Qt, in the client's window on the screen.

    Attributes:
        widget_of: the address of the function that gives its widget.
    """

    widget_of: int
    gui: GUI

    def __init__(self) -> None:
        self._desktop = desktop(Path(self.functions._name).with_name(WIDGETS))
        super().__init__()

    def Load(self, *values: Any) -> None:
        """Put the widget into the window, call the plugin's Load, and show the widget."""
        self.gui.SetVisible(False)  # the page has no panel of it
        by = owner.get()
        failed = self._desktop.failed if by is None else functools.partial(by.stop, "an event of Qt")
        place = self._object or 0, self.widget_of
        self._desktop.add(*place, failed)
        super().Load(*values)
        self._desktop.show(*place)

    def __del__(self) -> None:
        deletion = self._deletion()
        if deletion is not None:
            self._desktop.delete(deletion)


@functools.cache
def _adapter(kind: str, widgets: bool) -> type[Any]:
    """The class of plugins of a kind, without a file."""
    base = WithWidgets if widgets else CompiledPlugin
    return type(f"Compiled{kind}Plugin", (base, KINDS[kind]), {"__module__": "C++"})


def _address(shared: SharedObject, name: str) -> int | None:
    """The address of a function; None if a file does not have it."""
    try:
        return ctypes.cast(shared.library[name], c_void_p).value
    except AttributeError:
        return None


def _start_ros(functions: Any, shared: SharedObject, path: Path) -> None:
    """Make roscpp's node, which plugins for ROS 1 expect, if ROS's master answers."""
    uri = os.environ.get("ROS_MASTER_URI", "http://localhost:11311")
    try:
        address = urlsplit(uri)
        socket.create_connection((address.hostname or "", address.port or 0), PATIENCE).close()
    except (OSError, ValueError):
        log.warning("plugin %s uses ROS 1, and no master answers at %s: start roscore first", path, uri)
        return
    if not functions.start_roscpp(shared.library._handle, NODE.encode()):
        log.warning(
            "plugin %s gets no node of ROS 1: functions of roscpp are missing in the library that it uses", path
        )


def _start_ignition(functions: Any, path: Path) -> None:
    """Obey joint commands of ignition-transport, as plugins of Gazebo 11 expect that use it."""
    library = Path(functions._name).with_name(IGNITION)
    if not library.is_file():
        log.warning(
            "plugin %s uses ignition-transport, whose commands libgz obeys only after: "
            "apt-get install libignition-transport-dev; libgz config --install-classic",
            path,
        )
        return
    from libgz.classic_cxx.ignition import IgnitionTransport

    IgnitionTransport.start(library)


def load(path: Path) -> Plugin:
    """Load a plugin. A file that was built again since is loaded again.

    Raises:
        PluginError: it was built with another libgz, or cannot be loaded.
        LibraryError: libgz was installed without a C compiler.
        UntrustedError: files are not trusted.
    """
    check_trusted(f"plugin {path}")
    path = path.resolve()
    edited = edition(path)
    known = _loaded.get(path)
    if known is not None and known.edited == edited:
        return known
    mark = _mark_of(path)
    if mark is None or mark[0] not in KINDS:
        raise PluginError(f"error loading plugin: {path} is no plugin that was built with libgz: libgz cxx build")
    kind, key, folder = mark
    functions = _functions(path, key, folder)
    data = read_limited(path)
    _messages.check(path, data)
    before = mapped()
    _loaded.pop(path, None)
    with loading(path):
        shared = SharedObject(path)
        _messages.keep(path, shared, data, before)
        track(shared, path)
        maker, widget_of = _address(shared, "libgz_new_plugin"), _address(shared, "libgz_widget_of")
        if maker is None:
            raise PluginError(f"error loading plugin: {path} hides its RegisterPlugin; build it without -fvisibility")
    if ROSCPP in data:
        _start_ros(functions, shared, path)
    if TRANSPORT in data:
        _start_ignition(functions, path)
    values = {"shared": shared, "maker": maker, "functions": functions, "path": path, "__module__": "C++"}
    if widget_of is not None:
        values["widget_of"] = widget_of
    plugin = Plugin(path, edited=edited)
    plugin.registered = [(kind, type(path.stem, (_adapter(kind, widget_of is not None),), values))]
    _loaded[path] = plugin
    return plugin
