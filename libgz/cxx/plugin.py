"""CxxPlugin: a shared object of C++ models, loaded into this process."""

from __future__ import annotations

import ctypes
import gc
import logging
import re
from ctypes import c_char_p, c_double, c_int, c_long, c_size_t, c_void_p
from pathlib import Path
from typing import Any

from libgz.base.errors import PluginError
from libgz.base.files import read_limited
from libgz.base.trust import check_trusted
from libgz.cxx.headers import mark
from libgz.cxx.host import install, loading, track
from libgz.cxx.model import CxxModel
from libgz.cxx.objects import running
from libgz.cxx.shared_object import SharedObject
from libgz.cxx.table import table
from libgz.ode.lib import ode
from libgz.simulation.plugins import Plugin, edition

__all__ = ["CxxPlugin", "is_plugin", "load"]

log = logging.getLogger("libgz.plugin")

MARK = re.compile(rb"libgz C\+\+ plugin: ([^;\0]{1,80});")
DONE, RETURNED, FAILED, THREW = range(4)  # as in ModelFactory.hh
LONGEST = 1024  # of the description of an exception

NOT_KEPT = (
    "states and resets keep its bodies, joints, sensors and interfaces, but not the variables of its C++ object, "
    "which libgz does not know (C++ plugin {})"
)

_loaded: dict[Path, Plugin] = {}


def _mark_of(path: Path) -> str | None:
    """For which libgz a file was compiled; None if it is no plugin of libgz."""
    try:
        found = MARK.search(read_limited(path))
    except OSError as error:
        raise PluginError(f"error loading plugin: {path}: {error.strerror}") from None
    return found[0].decode(errors="replace") if found else None


def is_plugin(path: Path) -> bool:
    """Whether a file is a C++ plugin of some libgz."""
    return _mark_of(path) is not None


class CxxPlugin:
    """A loaded file, in memory as long as this object.

    Args:
        path: where it was found.
        shared: the shared object.
    """

    def __init__(self, path: Path, shared: SharedObject) -> None:
        self.path, self.shared = path, shared
        library = shared.library
        text = [c_char_p, c_size_t]
        kinds: dict[str, list[Any]] = {
            "create": [c_void_p, c_void_p, c_char_p, c_void_p, *text],
            "call": [c_void_p, c_int, c_void_p, c_void_p, c_char_p, c_void_p, *text],
            "update": [c_void_p, c_double, c_char_p, *text],
            "delete": [c_void_p, c_char_p, *text],
            "wrap": [c_char_p, c_long, c_void_p],
            "fields": [c_void_p],
            "on_heap": [c_void_p],
        }
        functions = {name: library[f"libgz_plugin_{name}"] for name in kinds}
        for name, types in kinds.items():
            functions[name].argtypes = types
        for name in ("wrap", "fields"):
            functions[name].restype = c_void_p
        self._create, self._call, self.update = functions["create"], functions["call"], functions["update"]
        self._delete, self._wrap = functions["delete"], functions["wrap"]
        self.fields, self.on_heap = functions["fields"], functions["on_heap"]
        self.wire = c_int.in_dll(library, "libgz_plugin_wire").value
        self.text = ctypes.create_string_buffer(LONGEST)

    def model_class(self, name: str, function: int) -> type[CxxModel]:
        """The class of the models that a function of the plugin creates."""
        values = {"plugin": self, "create": function, "not_kept": NOT_KEPT.format(self.path), "__module__": "C++"}
        return type(name, (CxxModel,), values)

    def create(self, function: int, world: int, label: bytes) -> int:
        """Create a model by a function that the plugin registered; `world` is the C++ object."""
        model = c_void_p()
        text = ctypes.create_string_buffer(LONGEST)
        status = self._create(function, world, label, ctypes.byref(model), text, LONGEST)
        self.check(status, "the constructor", 0, text, label.decode(errors="replace").partition(", plugin ")[0])
        return model.value or 0

    def call(self, model: int, method: int, file: int, node: int, label: bytes) -> tuple[int, int, Any]:
        """Call Load, Init or Fini: how it ended, its result, and the text of an exception."""
        result = c_int()
        text = ctypes.create_string_buffer(LONGEST)
        status = self._call(model, method, file, node, label, ctypes.byref(result), text, LONGEST)
        return status, result.value, text

    def delete(self, pointer: int, label: bytes) -> None:
        """Delete a C++ object; an exception of its destructor is logged."""
        text = ctypes.create_string_buffer(LONGEST)
        status = self._delete(pointer, label, text, LONGEST)
        if status != DONE:
            log.error(
                "the destructor of %s failed: %s", label.decode(errors="replace"), text.value.decode(errors="replace")
            )

    def wrap(self, kind: str, handle: int, world: int) -> int:
        """A C++ object of a class for an object of libgz."""
        return int(self._wrap(kind.encode(), handle, world) or 0)

    def check(self, status: int, method: str, result: int, text: Any, who: str = "") -> None:
        """Raise what a method failed with.

        Raises:
            PluginError: it returned a number that is not 0, or threw.
        """
        failure, running.failure = running.failure, None
        if status == DONE:
            return
        what = f"plugin {self.path}: {method}{f' of {who}' if who else ''}"
        if status == RETURNED:
            raise PluginError(f"{what} returned {result}, which is not 0")
        if status == THREW:
            raise PluginError(f"{what} threw {text.value.decode(errors='replace')}")
        if failure is None:
            raise PluginError(f"{what} failed")
        if not isinstance(failure, Exception):
            raise failure
        raise PluginError(f"{what}: {failure}") from failure


def load(path: Path) -> Plugin:
    """Load a C++ plugin, and collect what it registers. A file that was built again since is loaded again.

    Raises:
        PluginError: it was built for another libgz, cannot be loaded, or registers nothing.
        LibraryError: libgz was installed without a C compiler.
        UntrustedError: files are not trusted.
    """
    check_trusted(f"plugin {path}")
    path = path.resolve()
    edited = edition(path)
    known = _loaded.get(path)
    if known is not None and known.edited == edited:
        return known
    found, own = _mark_of(path), mark()
    if found is None:
        raise PluginError(
            f"error loading plugin: {path}: this file is no C++ plugin of libgz; build its source: libgz cxx build"
        )
    if found != own:
        raise PluginError(
            f"error loading plugin: {path} was built for another libgz: it needs {_named(found)}, and this is "
            f"{_named(own)}; build it again: libgz cxx build"
        )
    install()
    ctypes.CDLL(ode().path, mode=ctypes.RTLD_GLOBAL)  # the same library again: plugins may call ODE themselves
    if _loaded.pop(path, None) is not None:
        gc.collect()  # which unloads the old version, unless a world uses it
    table()
    with loading(path):
        shared = SharedObject(path)
        track(shared, path)
        registered = _registered(path, shared.library)
    if shared.renders_with is not None:
        log.info("plugin %s renders with %s: its Render is never called", path, shared.renders_with)
    cxx = CxxPlugin(path, shared)
    plugin = Plugin(path, edited=edited)
    plugin.registered = [(name, cxx.model_class(name, function)) for name, function in registered]
    _loaded[path] = plugin
    return plugin


def _named(text: str) -> str:
    return text.removeprefix("libgz C++ plugin: ").rstrip(";")


def _registered(path: Path, library: ctypes.CDLL) -> list[tuple[str, int]]:
    """What the file registers, as (name, function)."""
    try:
        function = library["gazebo_plugin_init"]
    except AttributeError:
        function = None
    if function is None:
        raise PluginError(
            f'plugin {path} registers nothing; one of its files must have GZ_REGISTER_PLUGIN("MyModel", MyModel)'
        )
    found: list[tuple[str, int]] = []
    running.registered = found
    try:
        result = function()
    finally:
        running.registered = None
    if result:
        raise PluginError(f"plugin init failed: gazebo_plugin_init() of {path} returned {result}")
    if not found:
        raise PluginError(
            f"plugin {path} registers nothing; its gazebo_plugin_init must call ModelFactory::RegisterModel"
        )
    return found
