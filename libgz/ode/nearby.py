"""Geoms near a place, found by the bounding boxes that ODE keeps."""

from __future__ import annotations

import ctypes
from ctypes import c_void_p

from libgz.ode.lib import OdeLibrary

__all__ = ["NEAR_CALLBACK", "geoms_near"]

NEAR_CALLBACK = ctypes.PYFUNCTYPE(None, c_void_p, c_void_p, c_void_p)


def geoms_near(lib: OdeLibrary, probe: int, space: int) -> list[int]:
    """Handles of the geoms in a space, and in spaces of it, whose bounding boxes meet that of the geom `probe`.

    Geoms that the probe's bits exclude are left out.
    """
    found: list[int] = []
    spaces = [space]

    def near(_data: int, geom1: int, geom2: int) -> None:
        geom = geom2 if geom1 == probe else geom1
        (spaces if lib.dGeomIsSpace(geom) else found).append(geom)

    callback = NEAR_CALLBACK(near)
    address = ctypes.cast(callback, c_void_p)
    for one in spaces:  # grows by the spaces that are met
        lib.dSpaceCollide2(probe, one, None, address)
    return found
