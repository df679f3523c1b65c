"""Tape: records calls of OpenGL's functions, which native code (tape.c) then plays in the context's thread.

Python records, with the interpreter lock, and reads the world; what plays needs neither of them, so that images are
rendered beside all that Python does meanwhile.
"""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Callable
from concurrent.futures import Future
from ctypes import c_char_p, c_double, c_float, c_int, c_int64, c_size_t, c_ubyte, c_uint, c_void_p
from functools import partial
from typing import Any

import numpy as np

from libgz.base.errors import LibraryError
from libgz.rendering.context import Context
from libgz.rendering.gl import declared
from libgz.rendering.native import address

__all__ = ["Tape"]

_LETTERS = {c_int: "i", c_uint: "i", c_ubyte: "i", c_float: "f", c_double: "d"}  # of all other types: "p"
_FORMATS = {"i": "q", "f": "d", "d": "d", "p": "Q"}
_AT_ONCE = "glGen", "glGet", "glShaderSource"  # pointers to what is written, or to pointers
_HEAD, _WORD, _MOST_ARGUMENTS = "=QQ", 8, 10
_LAYOUT = struct.calcsize(_HEAD) + _WORD * _MOST_ARGUMENTS  # `call` of tape.c


class Tape:
    """All functions of one context, as attributes: ``gl.glClear(...)`` records a call.

    Arrays are passed as they are, by numpy or ctypes, contiguous; the tape keeps them until they were played, so nobody
    may write to them before. A function that returns something, or writes to where a pointer says, is called at once,
    after all that was recorded before.

    Args:
        context: whose functions.
        native: the library of tape.c; None for the form in Python.

    Attributes:
        address: where a function is, by its name.

    Raises:
        LibraryError: the library was built from another version, or the context lacks a function that is used.
    """

    def __init__(self, context: Context, native: ctypes.CDLL | None) -> None:
        self._context, self._native = context, native
        self.address = context.gl.address
        self._calls: list[Any] = []
        self._kept: list[object] = []
        if native is not None:
            native.gz_call_size.restype = c_size_t
            if native.gz_call_size() != _LAYOUT:
                raise LibraryError("_frame.so was built from another version of tape.c; install libgz again")
            native.gz_player.argtypes, native.gz_player.restype = [c_char_p], c_void_p
            native.gz_play.argtypes, native.gz_play.restype = [c_char_p, c_int64, c_void_p], c_uint
            self._get_error = self.address("glGetError")

    def __getattr__(self, name: str) -> Callable[..., Any]:
        result, arguments = declared(name)
        found = None
        if result is None and not name.startswith(_AT_ONCE):
            form = "".join(_LETTERS.get(kind, "p") for kind in arguments)
            found = self._twin(name, form) if self._native is None else self.recorder(self.address(name), form)
        if found is None:
            return partial(self._call_now, name)
        setattr(self, name, found)
        return found

    def _call_now(self, name: str, *arguments: Any) -> Any:
        self.play().result()
        return self._context.run(getattr(self._context.gl, name), *arguments)

    def recorder(self, function: int, form: str) -> Callable[..., None] | None:
        """What records calls of a function, by its address and its form, see tape.c; None where that has none."""
        player = None if self._native is None else self._native.gz_player(form.encode())
        if not player:
            return None
        codes = "".join(_FORMATS[letter] for letter in form)
        head = struct.Struct(f"{_HEAD}{codes}{_WORD * (_MOST_ARGUMENTS - len(form))}x")
        pack, add, kept = head.pack, self._calls.append, self._kept
        pointers = [place for place, letter in enumerate(form) if letter == "p"]
        if not pointers:
            return lambda *values: add(pack(function, player, *values))

        def record(*values: Any) -> None:
            given = list(values)
            for place in pointers:
                given[place] = _keep(values[place], kept)
            add(pack(function, player, *given))

        return record

    def _twin(self, name: str, form: str) -> Callable[..., None]:
        function, add, kept = getattr(self._context.gl, name), self._calls.append, self._kept

        def record(*values: Any) -> None:
            given = [_keep(one, kept) if letter == "p" else one for one, letter in zip(values, form, strict=True)]
            add(partial(function, *given))

        return record

    def play(self) -> Future[None]:
        """Have all that was recorded played, in the context's thread; what it raises is in the result.

        Raises (in the result):
            LibraryError: OpenGL reports an error.
        """
        calls, kept = self._calls[:], self._kept[:]
        self._calls.clear()
        self._kept.clear()
        return self._context.submit(self._play, calls, kept)

    def _play(self, calls: list[Any], _kept: list[object]) -> None:
        if self._native is None:
            for call in calls:
                call()
            self._context.gl.check()
            return
        code = self._native.gz_play(b"".join(calls), len(calls), self._get_error)
        if code:
            raise LibraryError(f"OpenGL reports error {code:#06x}")


def _keep(array: Any, kept: list[object]) -> int:
    """Where the numbers of an array are, which is added to those that are not freed before they were used."""
    if array is None:
        return 0
    kept.append(array)
    if not isinstance(array, np.ndarray):
        return ctypes.addressof(array)
    if array.flags.writeable and array.size:
        return address(array)
    if not array.flags.c_contiguous:
        raise ValueError("an array for OpenGL is not contiguous")
    return int(array.ctypes.data)
