"""The raw ODE library: found, checked, and called through declared prototypes only.

The library is the one that LIBGZ_ODE names, else the system's libode.so.8, else the one that libgz's wheel contains.
`ode()` gives the one loaded library; its attributes are the functions of `prototypes`. Handles are plain ints.
Nothing outside `libgz.ode` touches the shared object.
"""

from __future__ import annotations

import ctypes
import functools
import logging
import os
import re
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from libgz.base.errors import LibraryError, nearest
from libgz.ode.prototypes import PROTOTYPES
from libgz.ode.types import ContactGeom

__all__ = ["OdeLibrary", "bundled_path", "declared", "ode"]

log = logging.getLogger("libgz.ode")

LIBRARY = "libode.so.8"
BUNDLED = "bundled"  # the value of LIBGZ_ODE for the library that the wheel contains
ADVICE = (
    "apt-get install libode8 (Debian, Ubuntu), or install libgz from its wheel, which contains ODE (LIBGZ_ODE=bundled)"
)
ALLOCATE_ALL = 0xFFFFFFFF  # dAllocateMaskAll

_C_TYPES: dict[str, Any] = {
    "void": None,
    "int": ctypes.c_int,
    "uint": ctypes.c_uint,
    "ulong": ctypes.c_ulong,
    "real": ctypes.c_double,
    "id": ctypes.c_void_p,
    "data": ctypes.c_void_p,
    "text": ctypes.c_char_p,
    "reals": ctypes.c_void_p,
}
_PROTOTYPE = re.compile(r"(\w+) (\w+)\((.*)\)")
_POINTER_RESULTS = {"reals": ctypes.POINTER(ctypes.c_double * 4), "matrix": ctypes.POINTER(ctypes.c_double * 12)}
_MESSAGE_HANDLER = ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_char_p, ctypes.c_void_p)
_handlers: list[Any] = []  # kept for ever: ODE has their addresses, whatever becomes of an OdeLibrary


def _parse(prototypes: str) -> dict[str, tuple[Any, list[Any]]]:
    """Function name -> (result type, argument types)."""
    declared = {}
    for line in filter(None, map(str.strip, prototypes.splitlines())):
        match = _PROTOTYPE.fullmatch(line)
        if match is None:
            raise LibraryError(f"malformed prototype {line!r}")
        result, name, arguments = match.groups()
        restype = _POINTER_RESULTS.get(result) or _C_TYPES[result]
        declared[name] = (restype, [_C_TYPES[a] for a in arguments.split(", ") if a])
    return declared


@functools.cache
def _declarations() -> dict[str, tuple[Any, list[Any]]]:
    return _parse(PROTOTYPES)


def declared(name: str) -> tuple[Any, list[Any]]:
    """(result type, argument types) of a function of ODE."""
    return _declarations()[name]


def bundled_path() -> Path | None:
    """Where the ODE library of the wheel is; None in a checkout."""
    return next(iter(sorted(Path(__file__).parents[2].glob("libgz.libs/libode*.so*"))), None)


def _candidates() -> Iterator[tuple[str, str]]:
    """Names of libraries in the order in which they are tried, each with the reason."""
    bundled = bundled_path()
    wanted = os.environ.get("LIBGZ_ODE")
    if wanted == BUNDLED:
        if bundled is None:
            raise LibraryError(f"LIBGZ_ODE={BUNDLED}, but this installation contains no ODE library; {ADVICE}")
        yield str(bundled), f"bundled, chosen by LIBGZ_ODE={BUNDLED}"
    elif wanted:
        yield wanted, "named by LIBGZ_ODE"
    else:
        yield LIBRARY, "of the system"
        if bundled is not None:
            yield str(bundled), "bundled"


def _load() -> tuple[ctypes.PyDLL, str]:
    """The first candidate that loads and has double precision, and why it was chosen."""
    reasons = []
    for name, origin in _candidates():
        try:
            # PyDLL keeps the interpreter lock: most calls are shorter than releasing and acquiring it.
            shared = ctypes.PyDLL(name)
        except OSError as error:
            reasons.append(f"cannot load the ODE library {name!r} ({error})")
            continue
        if shared.dCheckConfiguration(b"ODE_double_precision"):
            return shared, origin
        reasons.append(f"{name} is built for single precision; libgz needs doubles")
        log.debug("%s", reasons[-1])
    raise LibraryError(f"{'; '.join(reasons)}; {ADVICE}")


class OdeLibrary:
    """libode with its functions as attributes, each bound on first use.

    Attributes:
        origin: where the library is from: "of the system", "bundled", or what LIBGZ_ODE chose.

    Raises:
        LibraryError: the library is absent, or was built for single precision.
    """

    def __init__(self) -> None:
        self._shared, self.origin = _load()
        self._declared = _declarations()
        self._threads = threading.local()
        for get_handler, set_handler, kind, level in (
            (self.dGetErrorHandler, self.dSetErrorHandler, "error", logging.CRITICAL),
            (self.dGetDebugHandler, self.dSetDebugHandler, "debug", logging.CRITICAL),
            (self.dGetMessageHandler, self.dSetMessageHandler, "message", logging.DEBUG),
        ):
            if not get_handler():  # else they are set, and the native step may have set its own over them
                _handlers.append(_message_handler(kind, level))
                set_handler(ctypes.cast(_handlers[-1], ctypes.c_void_p))
        if not self.dInitODE2(0):
            raise LibraryError("dInitODE2 failed: ODE cannot be initialised")
        self.ensure_thread()

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Bind a declared function at its first use."""
        if name.startswith("_"):
            raise AttributeError(name)
        if name not in self._declared:
            raise AttributeError(f"ODE function {name!r} is not declared in libgz.ode{nearest(name, self._declared)}")
        function: Callable[..., Any]
        try:
            function = self._shared[name]
        except AttributeError:
            function = _absent(name, self._shared._name)
        else:
            function.restype, function.argtypes = self._declared[name]
        setattr(self, name, function)
        return function

    @property
    def path(self) -> str:
        """The name under which the library was loaded."""
        return str(self._shared._name)

    @functools.cached_property
    def collides_cylinders(self) -> bool:
        """Whether this ODE finds contacts of two cylinders, which needs libccd."""
        one, two = self.dCreateCylinder(None, 1.0, 1.0), self.dCreateCylinder(None, 1.0, 1.0)
        try:
            self.dGeomSetPosition(two, 0.0, 0.1, 0.9)
            found = ctypes.create_string_buffer(ctypes.sizeof(ContactGeom))
            return bool(self.dCollide(one, two, 1, ctypes.addressof(found), ctypes.sizeof(ContactGeom)))
        finally:
            self.dGeomDestroy(one)
            self.dGeomDestroy(two)

    @property
    def configuration(self) -> str:
        """ODE's own list of the options it was built with."""
        return str(self.dGetConfiguration().decode())

    def address(self, name: str) -> int:
        """The address of a C function, for the native step."""
        return ctypes.cast(self._shared[name], ctypes.c_void_p).value or 0

    def unchecked(self, name: str, result: Any) -> Callable[..., Any]:
        """A declared function without argument types: ctypes objects pass unchecked, in half the time."""
        _ = self._declared[name]
        function = self._shared[name]  # a new one at each look-up, with types of its own
        function.restype = result
        return function

    def without_lock(self, name: str) -> Callable[..., Any]:
        """A declared function that lets other threads of Python run meanwhile, for calls that take seconds."""
        function = ctypes.CDLL(self.path, handle=self._shared._handle)[name]
        function.restype, function.argtypes = self._declared[name]
        return function

    def ensure_thread(self) -> None:
        """Allocate ODE's data for the calling thread; collision in a thread without them crashes."""
        if not getattr(self._threads, "ready", False):
            if not self.dAllocateODEDataForThread(ALLOCATE_ALL):
                raise LibraryError("ODE cannot allocate its data for this thread")
            self._threads.ready = True


def _message_handler(kind: str, level: int) -> Any:
    """A C callback that formats one of ODE's messages and logs it."""
    vsnprintf = ctypes.CDLL(None).vsnprintf
    vsnprintf.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_void_p]

    def handle(number: int, text: bytes, arguments: int) -> None:
        buffer = ctypes.create_string_buffer(1024)
        vsnprintf(buffer, len(buffer), text, arguments)
        log.log(level, "ODE %s %d: %s", kind, number, buffer.value.decode(errors="replace").strip())

    return _MESSAGE_HANDLER(handle)


def _absent(name: str, library: str) -> Callable[..., Any]:
    """A function that raises an explanation when it is called."""

    def explain(*_arguments: object) -> Any:
        raise LibraryError(f"{library} has no function {name}; {ADVICE}")

    return explain


_loading = threading.Lock()  # the first worlds of two threads may come at once


@functools.cache
def ode() -> OdeLibrary:
    """The ODE library, loaded once per process.

    Raises:
        LibraryError: it is absent or unfit; the message says how to install it.
    """
    with _loading:
        return _the_library()


@functools.cache
def _the_library() -> OdeLibrary:
    return OdeLibrary()
