"""All interfaces by their type, the first part of their file names."""

from __future__ import annotations

from typing import Any

from libgz.base.errors import ParameterError, nearest
from libgz.interfaces.actarray import Actarray
from libgz.interfaces.camera import Camera
from libgz.interfaces.factory import Factory
from libgz.interfaces.fiducial import Fiducial
from libgz.interfaces.gps import Gps
from libgz.interfaces.gripper import Gripper
from libgz.interfaces.guicam import Guicam
from libgz.interfaces.ir import Ir
from libgz.interfaces.joint import Joints
from libgz.interfaces.laser import Laser
from libgz.interfaces.position import Position
from libgz.interfaces.power import Power
from libgz.interfaces.ptz import Ptz
from libgz.interfaces.sim import Sim
from libgz.interfaces.sonar import Sonar
from libgz.interfaces.stereo import Stereo
from libgz.interfaces.truth import Truth
from libgz.interfaces.wifi import Wifi
from libgz.transport.interface import Interface

__all__ = ["INTERFACES", "new_interface"]

INTERFACES: dict[str, type[Interface[Any]]] = {
    kind.type: kind
    for kind in (
        Actarray,
        Camera,
        Factory,
        Fiducial,
        Gps,
        Gripper,
        Guicam,
        Ir,
        Joints,
        Laser,
        Position,
        Power,
        Ptz,
        Sim,
        Sonar,
        Stereo,
        Truth,
        Wifi,
    )
}


def new_interface(kind: str) -> Interface[Any]:
    """An interface object of a type, neither created nor open.

    Raises:
        ParameterError: there is no such type.
    """
    if kind not in INTERFACES:
        known = ", ".join(INTERFACES)
        raise ParameterError(f"there is no interface type {kind!r}; there are {known}{nearest(kind, INTERFACES)}")
    return INTERFACES[kind]()
