"""Submission: passes display lists of items with their matrices to OpenGL; natively (frame.c), or call by call."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from ctypes import c_int64, c_void_p

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.rendering.native import address
from libgz.rendering.tape import Tape

__all__ = ["Submitter"]

FUNCTIONS = ("glLoadMatrixd", "glCallList", "glEnable", "glDisable", "glColor3ubv")


class SubmissionRecord(ctypes.Structure):
    """`submission` of frame.c."""

    _fields_ = (
        *((name, c_void_p) for name in FUNCTIONS),
        ("matrices", c_void_p),
        ("places", c_void_p),
        ("lists", c_void_p),
        ("count", c_int64),
        ("colors", c_void_p),
        ("dark", c_void_p),
        ("lights", c_void_p),
        ("light_count", c_int64),
    )
    kept: object  # what it points to


class Submitter:
    """Submits items in one context.

    Args:
        gl: the functions of the context.
        native: frame.c; None for the form in Python.

    Raises:
        LibraryError: frame.c was built from another version, or OpenGL lacks a function.
    """

    def __init__(self, gl: Tape, native: ctypes.CDLL | None) -> None:
        self._gl = gl
        self._submit: Callable[..., None] | None = None
        if native is not None:
            native.gz_submission_size.restype = ctypes.c_size_t
            if native.gz_submission_size() != ctypes.sizeof(SubmissionRecord):
                raise LibraryError("_frame.so was built from another version of frame.c; install libgz again")
            self._submit = gl.recorder(ctypes.cast(native.gz_submit, c_void_p).value or 0, "p")
            self._functions = [gl.address(name) for name in FUNCTIONS]

    def submit(
        self,
        matrices: NDArray[np.float64],
        places: NDArray[np.int64],
        lists: NDArray[np.uint32],
        colors: NDArray[np.uint8] | None = None,
        dark: NDArray[np.int64] | None = None,
        lights: Sequence[int] = (),
    ) -> None:
        """Load the matrix of each item, and call its list.

        Args:
            matrices: of all items, by columns, shape (n, 16).
            places: of those to submit, in this order.
            lists: one for each of `places`.
            colors: of all items, shape (n, 3).
            dark: for each of `places` a bit for each of `lights` that is off meanwhile; all are on before and after.
            lights: OpenGL's numbers.
        """
        if not len(places):
            return
        if self._submit is None:
            self._submit_here(matrices, places, lists, colors, dark, lights)
            return
        numbers = (ctypes.c_uint32 * len(lights))(*lights)
        record = SubmissionRecord(*self._functions)
        record.matrices, record.places = address(matrices), address(places)
        record.lists, record.count = address(lists), len(places)
        record.colors = None if colors is None else address(colors)
        record.dark = address(dark) if lights and dark is not None else None
        record.lights, record.light_count = ctypes.addressof(numbers), len(lights)
        record.kept = matrices, places, lists, colors, dark, numbers  # until it is played
        self._submit(record)

    def _submit_here(
        self,
        matrices: NDArray[np.float64],
        places: NDArray[np.int64],
        lists: NDArray[np.uint32],
        colors: NDArray[np.uint8] | None,
        dark: NDArray[np.int64] | None,
        lights: Sequence[int],
    ) -> None:
        gl, now = self._gl, 0
        for k, (i, number) in enumerate(zip(places.tolist(), lists.tolist(), strict=True)):
            if colors is not None:
                gl.glColor3ubv(colors[i])
            if lights and dark is not None:
                now = self._switch(lights, now, int(dark[k]))
            gl.glLoadMatrixd(matrices[i])
            gl.glCallList(number)
        self._switch(lights, now, 0)

    def _switch(self, lights: Sequence[int], now: int, wanted: int) -> int:
        for k, number in enumerate(lights):
            if (now ^ wanted) >> k & 1:
                (self._gl.glDisable if wanted >> k & 1 else self._gl.glEnable)(number)
        return wanted
