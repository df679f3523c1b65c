"""The native part of the adapter (host.c), and the interfaces that plugins create with the C functions."""

from __future__ import annotations

import atexit
import ctypes
import logging
import os
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes import CFUNCTYPE, POINTER, c_char_p, c_int, c_size_t, c_void_p
from functools import cache
from pathlib import Path
from typing import Any

from libgz.base.errors import USER_ERRORS, GazeboError, InterfaceError, LibraryError
from libgz.cxx import FOLDER
from libgz.cxx.objects import running
from libgz.cxx.shadow import Shadow
from libgz.cxx.shared_object import SharedObject
from libgz.interfaces.catalog import INTERFACES
from libgz.simulation.world import World
from libgz.transport.interface import Interface
from libgz.transport.semaphores import GZ_SEM_KEY
from libgz.transport.server import Server

__all__ = ["HostedServer", "ended_address", "fail", "frames_address", "install", "loading", "offer", "track", "watch"]

log = logging.getLogger("libgz.plugin")

HOSTED = -0x6877  # GZ_HOSTED of host.h
LIBRARY = FOLDER / "_host.so"
_LOW = 0xFFFFFFFF


class _Server(ctypes.Structure):
    """gz_server_t."""

    _fields_ = [("server_id", c_int), ("filename", c_char_p), ("sem_key", c_int), ("sem_cid", c_int)]


class _Iface(ctypes.Structure):
    """gz_iface_t."""

    _fields_ = [
        ("server", c_void_p),
        ("client", c_void_p),
        ("mmap_fd", c_int),
        ("mmap", c_void_p),
        ("filename", c_void_p),
    ]


class _Frame(ctypes.Structure):
    """libgz_frame."""

    _fields_ = [("below", c_void_p), ("method", c_char_p), ("label", c_char_p), ("failed", c_int)]


class HostedServer:
    """What plugins know as `world->gz_server`: the server of a world, whose interfaces they create.

    Args:
        world: the world.
        numbers: the number of the model of a C++ object, by the low 32 bits of its address: old plugins pass these as
            numbers of models.
    """

    def __init__(self, world: World, numbers: Callable[[int], int | None]) -> None:
        self.world = world
        self.numbers = numbers
        server = world.gz_server
        path = server.path.encode() if isinstance(server, Server) else b""
        number = world.server_id or 0
        self.struct = _Server(number, path, GZ_SEM_KEY + number, HOSTED)
        self.interfaces: dict[int, tuple[Interface[Any], Any]] = {}  # and their memory, by address of the gz_iface_t
        self.shadows: dict[int, Shadow] = {}  # likewise, where clients have another ABI
        _servers[self.address] = self

    @property
    def address(self) -> int:
        """Of the gz_server_t."""
        return ctypes.addressof(self.struct)

    def create(self, iface: _Iface, address: int, type: str, id: str | None) -> None:
        """Create an interface on the world's server."""
        if type not in INTERFACES:
            raise InterfaceError(f"there are no interfaces of type {type!r}; there are {', '.join(sorted(INTERFACES))}")
        interface, version = INTERFACES[type](), self.world.gz_server.version
        wire = running.model.plugin.wire if running.model is not None else version
        native: Any = interface.layout_for(version, None)
        if interface.layout_for(wire, None) is not native:
            raise InterfaceError(
                f"the plugin was compiled for {type} of version {wire:#05x}, and the server's interfaces are of "
                f"{version:#05x}; compile it with -DLIBGAZEBO_VERSION={version:#05x}"
            )
        interface.create(self.world.gz_server, id)
        data: Any = interface.data
        if interface.layout is not native:
            shadow = self.shadows[address] = Shadow(interface, native)
            data = shadow.struct
        self.interfaces[address] = interface, data
        iface.mmap = ctypes.addressof(data)
        iface.mmap_fd = -1 if interface.descriptor is None else interface.descriptor

    def pull(self) -> None:
        """Take what clients have written, before code of a plugin runs."""
        for shadow in self.shadows.values():
            shadow.pull()

    def push(self) -> None:
        """Write what a plugin has changed without a lock."""
        for shadow in self.shadows.values():
            shadow.push()

    def number(self, passed: int) -> int:
        """The number of a model, which a plugin may have passed as the address of its C++ object."""
        found = self.numbers(passed & _LOW)
        return passed if found is None else found

    def close(self) -> None:
        """Plugins do not use it any more."""
        _servers.pop(self.address, None)
        self.interfaces.clear()
        self.shadows.clear()


_servers: dict[int, HostedServer] = {}


def _hosted(address: int) -> tuple[HostedServer, _Iface]:
    iface = _Iface.from_address(address)
    return _servers[iface.server], iface


def _attempt(action: Callable[[], int | None]) -> int:
    """0, or -1 after an error message of the C library."""
    try:
        return action() or 0
    except GazeboError as error:
        _library().gz_host_report(str(error).encode(errors="surrogateescape"))
        return -1
    except USER_ERRORS as error:
        running.failure = error
        fail()
        return -1


def _create(address: int, type: bytes, id: bytes | None, _size: int) -> int:
    server, iface = _hosted(address)
    name = None if id is None else id.decode(errors="surrogateescape")
    return _attempt(lambda: server.create(iface, address, type.decode(), name))


def _set_owner(address: int, model_type: bytes | None, model_id: int, parent_model_id: int) -> None:
    server, _ = _hosted(address)
    interface, _ = server.interfaces[address]
    kind = (model_type or b"").decode(errors="surrogateescape")
    interface.set_owner(kind, server.number(model_id), server.number(parent_model_id))


def _destroy(address: int) -> int:
    server, iface = _hosted(address)
    interface, _ = server.interfaces.pop(address, (None, None))
    server.shadows.pop(address, None)
    iface.mmap, iface.mmap_fd = None, -1
    return _attempt(interface.destroy) if interface is not None else -1


def _lock(address: int) -> int:
    server, _ = _hosted(address)
    if _attempt(lambda: 0 if server.interfaces[address][0].lock() else -1) != 0:
        return -1
    if address in server.shadows:
        server.shadows[address].pull()
    return 0


def _unlock(address: int) -> None:
    server, _ = _hosted(address)
    if address in server.shadows:
        server.shadows[address].push()
    _attempt(server.interfaces[address][0].unlock)


def _post(address: int) -> int:
    _servers[address].push()
    return _attempt(_servers[address].world.gz_server.post)


class _Host(ctypes.Structure):
    """struct gz_host."""

    _fields_ = [
        ("create", CFUNCTYPE(c_int, c_void_p, c_char_p, c_char_p, c_size_t)),
        ("set_owner", CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_int)),
        ("destroy", CFUNCTYPE(c_int, c_void_p)),
        ("lock", CFUNCTYPE(c_int, c_void_p)),
        ("unlock", CFUNCTYPE(None, c_void_p)),
        ("post", CFUNCTYPE(c_int, c_void_p)),
    ]


@cache
def _library() -> ctypes.CDLL:
    if not LIBRARY.exists():
        raise LibraryError(
            "libgz was installed without a C compiler, so it cannot run C++ plugins: apt-get install gcc libc6-dev, "
            "and install libgz again"
        )
    # Plugins are linked without libraries: they find the C functions here.
    library = ctypes.CDLL(str(LIBRARY), mode=ctypes.RTLD_GLOBAL)
    library.gz_host_install.argtypes = [POINTER(_Host)]
    library.gz_host_install.restype = None
    library.gz_host_report.argtypes = [c_char_p]
    library.gz_host_report.restype = None
    library.gz_host_fail.argtypes = []
    library.gz_host_fail.restype = None
    library.gz_host_offer.argtypes = [c_void_p, c_size_t]
    library.gz_host_offer.restype = None
    library.gz_host_loading.argtypes = [POINTER(_Frame)]
    library.gz_host_loading.restype = None
    library.gz_host_loaded.argtypes = []
    library.gz_host_loaded.restype = None
    library.gz_host_watch.argtypes = []
    library.gz_host_watch.restype = None
    library.gz_host_opened.argtypes = [c_char_p, c_char_p]
    library.gz_host_closed.argtypes = [c_int]
    library.gz_host_closed.restype = None
    return library


@cache
def install() -> _Host:
    """Offer the C functions to plugins that are loaded later, and report crashes.

    Raises:
        LibraryError: libgz was installed without a C compiler.
    """
    kinds: list[Any] = [field[1] for field in _Host._fields_]
    functions = (_create, _set_owner, _destroy, _lock, _unlock, _post)
    host = _Host(*(kind(function) for kind, function in zip(kinds, functions, strict=True)))
    _library().gz_host_install(host)
    atexit.register(setattr, c_int.in_dll(_library(), "gz_host_ended"), "value", 1)
    return host


def offer(table: Any) -> None:
    """Let plugins find the functions that their methods call."""
    _library().gz_host_offer(ctypes.addressof(table), ctypes.sizeof(table))


@contextmanager
def loading(path: Path) -> Iterator[None]:
    """A plugin's file is loaded: its constructors at file scope and its `gazebo_plugin_init` run."""
    frame = _Frame(None, b"its constructors or gazebo_plugin_init", f"plugin {path}".encode(errors="replace"))
    _library().gz_host_loading(frame)
    try:
        yield
    finally:
        _library().gz_host_loaded()
        watch()


def track(shared: SharedObject, path: Path) -> None:
    """Let messages after a crash name a plugin whose own threads crash, also when it was unloaded.

    Args:
        shared: what was loaded.
        path: its file.
    """
    label = f"plugin {path}".encode(errors="surrogateescape")
    number = _library().gz_host_opened(os.fsencode(shared.library._name), label)
    weakref.finalize(shared, _library().gz_host_closed, number).atexit = False


def watch() -> None:
    """Report crashes before handlers do that code of plugins has installed meanwhile; those follow."""
    _library().gz_host_watch()


def frames_address() -> int:
    """Where the C function is by which plugins mark what runs."""
    return ctypes.cast(_library().gz_host_frames, c_void_p).value or 0


def ended_address() -> int:
    """Where it is noted that Python has ended."""
    return ctypes.addressof(c_int.in_dll(_library(), "gz_host_ended"))


def fail() -> None:
    """Let the method of a plugin that runs in this thread end after the present call."""
    _library().gz_host_fail()
