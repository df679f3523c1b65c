"""Bones of a skeleton: their poses between two keys of an animation, and in the world."""

from __future__ import annotations

import ctypes
import functools
from ctypes import c_double, c_int64, c_void_p

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.ode.step import address_of, library_path

__all__ = ["blend_bones", "join_bones"]

Array = NDArray[np.float64]


@functools.cache
def _library() -> ctypes.PyDLL:
    """The functions of bones.c, which take so little time that they keep the interpreter lock."""
    library = ctypes.PyDLL(str(library_path()))
    library.gz_blend_bones.argtypes = [c_int64, c_void_p, c_double, c_void_p, c_void_p]
    library.gz_join_bones.argtypes = [c_int64, *[c_void_p] * 5]
    library.gz_blend_bones.restype = library.gz_join_bones.restype = None
    return library


def blend_bones(before: tuple[Array, Array], after: tuple[Array, Array], share: float) -> tuple[Array, Array]:
    """(positions, turns) between those of two keys: along lines, and the shorter ways of turning (Shoemake, 1985).

    Args:
        before, after: positions [m], shape (k, 3), and quaternions (u, x, y, z) of length 1, shape (k, 4).
        share: of the second key.
    """
    arrays = [np.ascontiguousarray(pair[i], dtype=np.float64) for i in (0, 1) for pair in (before, after)]
    positions, turns = np.empty_like(arrays[0]), np.empty_like(arrays[2])
    keys = (c_void_p * 4)(*map(address_of, arrays))
    _library().gz_blend_bones(len(positions), keys, share, address_of(positions), address_of(turns))
    return positions, turns


def join_bones(
    parents: NDArray[np.int64], positions: Array, turns: Array, place: Array, rotation: Array
) -> tuple[Array, Array]:
    """Global (positions, turns) of bones, from those in the frames of their parents.

    Args:
        parents: the place of each bone's parent, which comes first; that of the root, the first one, is not used.
        positions, turns: [m], shape (k, 3); shape (k, 4). Those of the root are not used.
        place, rotation: of the root, global [m].

    Raises:
        ParameterError: they are of another number of bones.
    """
    positions, turns = (np.ascontiguousarray(array, dtype=np.float64) for array in (positions, turns))
    if positions.shape != (len(parents), 3) or turns.shape != (len(parents), 4):
        raise ParameterError(f"a skeleton of {len(parents)} bones cannot have the pose of one of {len(positions)}")
    places, rotations = np.empty_like(positions), np.empty_like(turns)
    places[0], rotations[0] = place, rotation
    arrays = (parents, positions, turns, places, rotations)
    _library().gz_join_bones(len(parents), *map(address_of, arrays))
    return places, rotations
