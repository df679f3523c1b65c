"""OpenGL as PyOpenGL declares it, bound to one context at a time.

PyOpenGL's own functions belong to the one platform that it chose at its first import. Only its constants and prototypes
are used here. Each context binds them to its own library, so OSMesa and EGL can be tried in turn and used together.
Arrays are passed as ctypes arrays or addresses; a call costs a quarter of a microsecond.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import c_char_p, c_double, c_float, c_int, c_ubyte, c_uint, c_void_p
from importlib import import_module
from types import SimpleNamespace
from typing import Any

from OpenGL import platform  # type: ignore[import-untyped]

from libgz.base.errors import LibraryError

__all__ = ["GL", "Constant", "declared", "floats"]

try:
    _library = platform.PLATFORM.GL
except ImportError:
    _library = None
if _library is None:  # with OSMesa or EGL alone, the declarations still need a library
    platform.PLATFORM.GL = SimpleNamespace(glGetError=None)
try:
    _current = platform.PLATFORM.GetCurrentContext
except (AttributeError, ImportError):  # no GLX either
    platform.PLATFORM.GetCurrentContext = None

# 1.1 has all of 1.0. They are imported until a name is found; what 2.0 has, shaders, is for few worlds.
VERSIONS = "1_1", "1_2", "1_3", "1_4", "3_0", "2_0"
PLAIN = {None, c_double, c_float, c_int, c_ubyte, c_uint}  # all other types are arrays
WAITING = {"glFinish", "glReadPixels"}  # these render or wait, and release the interpreter lock meanwhile


def _declared(name: str) -> Any:
    for version in VERSIONS:
        module = import_module(f"OpenGL.raw.GL.VERSION.GL_{version}")
        if hasattr(module, name):
            return getattr(module, name)
    raise AttributeError(f"OpenGL has no {name} up to version 3.0")


def declared(name: str) -> tuple[Any, list[Any]]:
    """What a function returns, and its arguments: types of ctypes, `c_void_p` for arrays."""
    found = _declared(name)
    result = found.restype if found.restype in PLAIN else c_char_p
    return result, [kind if kind in PLAIN else c_void_p for kind in found.argtypes]


class _Constants:
    """Values of the GL headers, without the prefix GL_: ``Constant.LIGHTING``."""

    def __getattr__(self, name: str) -> int:
        value = int(_declared(f"GL_{name}"))
        setattr(self, name, value)
        return value


Constant = _Constants()


class GL:
    """All functions of one context, as attributes: ``gl.glClear(...)``; each is bound when it is first used.

    Args:
        address_of: the context's getProcAddress: a function's address, 0 or None if there is none.

    Raises:
        LibraryError: the context lacks a function that is used.
    """

    def __init__(self, address_of: Callable[[bytes], int | None]) -> None:
        self._address_of = address_of

    def __getattr__(self, name: str) -> Callable[..., Any]:
        result, arguments = declared(name)
        signature = ctypes.CFUNCTYPE if name in WAITING else ctypes.PYFUNCTYPE
        function: Callable[..., Any] = signature(result, *arguments)(self.address(name))
        setattr(self, name, function)
        return function

    def address(self, name: str) -> int:
        """Where a function is.

        Raises:
            LibraryError: the context lacks it.
        """
        address = self._address_of(name.encode())
        if not address:
            raise LibraryError(f"this OpenGL has no function {name}")
        return address

    def check(self) -> None:
        """Raise the error that GL has recorded since the last check.

        Raises:
            LibraryError: there is an error pending.
        """
        code = self.glGetError()
        if code:
            raise LibraryError(f"OpenGL reports error {code:#06x}")


def floats(*values: float) -> ctypes.Array[c_float]:
    """Values as the float array that GL's vector functions take."""
    return (c_float * len(values))(*values)
