"""OpenGL, bound to one context at a time.

Each context binds the functions of `gl_prototypes` to its own library, so OSMesa and EGL can be tried in turn and used
together. Arrays are passed as ctypes arrays or addresses; a call costs a quarter of a microsecond.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from ctypes import c_char_p, c_double, c_float, c_int, c_ubyte, c_uint, c_void_p
from functools import cache
from typing import Any

from libgz.errors import LibraryError
from libgz.rendering.gl_constants import Constant
from libgz.rendering.gl_prototypes import PROTOTYPES

__all__ = ["GL", "Constant", "floats"]

TYPES: dict[str, Any] = {
    "void": None,
    "data": c_void_p,
    "double": c_double,
    "float": c_float,
    "int": c_int,
    "text": c_char_p,
    "ubyte": c_ubyte,
    "uint": c_uint,
}
WAITING = {"glFinish", "glReadPixels"}  # these render or wait, and release the interpreter lock meanwhile


@cache
def _declared() -> dict[str, tuple[str, list[str]]]:
    """Function name -> names of the types of its result and of its arguments."""
    found = {}
    for line in PROTOTYPES.split("\n")[1:-1]:
        result, name, arguments = line.replace("(", " ", 1).rstrip(")").split(" ", 2)
        found[name] = (result, arguments.split(", ") if arguments else [])
    return found


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
        if name not in _declared():
            raise AttributeError(f"OpenGL function {name!r} is not declared in gl_prototypes.py")
        result, arguments = _declared()[name]
        signature = ctypes.CFUNCTYPE if name in WAITING else ctypes.PYFUNCTYPE
        function: Callable[..., Any] = signature(TYPES[result], *map(TYPES.__getitem__, arguments))(self.address(name))
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
