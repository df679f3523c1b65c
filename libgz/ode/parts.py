"""Parts: the objects of ODE whose memory is a state, in the order in which it is written."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from ctypes import c_int64, c_void_p
from itertools import chain
from typing import Any

from libgz.ode.memory import Layout

__all__ = ["Parts"]


class Parts(ctypes.Structure):
    """What a state is of; mirrors `parts` in states.c.

    Args:
        where: the layout of ODE's objects.
        bodies, joints: handles in order of construction.
        geoms: handles by row; 0 for one that touches nothing, and for a free row.
        spaces: handles in order of construction, the top space first.
        blocks: other memory that is copied, rows of the tables: (address, size [byte]) of each.
    """

    _fields_ = [
        ("where", Layout),
        ("bodies", c_void_p),
        ("body_count", c_int64),
        ("joints", c_void_p),
        ("joint_count", c_int64),
        ("geoms", c_void_p),
        ("geom_count", c_int64),
        ("spaces", c_void_p),
        ("space_count", c_int64),
        ("blocks", c_void_p),
        ("block_count", c_int64),
    ]

    def __init__(
        self,
        where: Layout,
        bodies: Sequence[int],
        joints: Sequence[int],
        geoms: Sequence[int],
        spaces: Sequence[int],
        blocks: Sequence[tuple[int, int]] = (),
    ) -> None:
        self.handles = (bodies, joints, geoms, spaces)
        self.places = tuple(blocks)
        arrays: list[Any] = [(c_void_p * len(handles))(*handles) for handles in self.handles]
        arrays.append((c_int64 * (2 * len(self.places)))(*chain.from_iterable(self.places)))
        self._arrays = arrays  # kept alive
        values = [value for array in arrays[:-1] for value in (ctypes.addressof(array), len(array))]
        super().__init__(where, *values, ctypes.addressof(arrays[-1]), len(self.places))
