"""fiducial: marked objects that a sensor recognises, and where they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.transport.interface import Interface, View
from libgz.transport.layout import SERVER, Array, Data, Element, double, elements, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GZ_FIDUCIAL_MAX_FIDS",
    "Fiducial",
    "FiducialData",
    "FiducialFid",
    "gz_fiducial_alloc",
    "gz_fiducial_close",
    "gz_fiducial_create",
    "gz_fiducial_destroy",
    "gz_fiducial_free",
    "gz_fiducial_lock",
    "gz_fiducial_open",
    "gz_fiducial_post",
    "gz_fiducial_unlock",
]


GZ_FIDUCIAL_MAX_FIDS = 401


@layout
class FiducialFid(Element):
    """gz_fiducial_fid_t: one object."""

    id: int = int32(SERVER, "", "number of the object")
    pos: Array[float] = double(SERVER, "m", "x, y, z in the sensor's frame", 3)
    rot: Array[float] = double(SERVER, "rad", "roll, pitch, yaw in the sensor's frame", 3)


@layout
class FiducialData(Data):
    """gz_fiducial_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    fid_count: int = int32(SERVER, "", "how many objects are seen, at most 401")
    fids: Array[FiducialFid] = elements(FiducialFid, SERVER, "the objects", GZ_FIDUCIAL_MAX_FIDS)


class Fiducial(Interface[FiducialData]):
    """Marked objects in view."""

    type = "fiducial"
    data_class = FiducialData

    all_fids = View("fids")

    @property
    def time(self) -> float:
        """Sim time of the sample [s]."""
        return self.data.time

    @property
    def fids(self) -> NDArray[np.void]:
        """The objects in view: records of `id`, `pos` [m] and `rot` [rad]; a view of the shared memory."""
        return self.all_fids[: min(max(self.data.fid_count, 0), GZ_FIDUCIAL_MAX_FIDS)]


_functions = LegacyFunctions(Fiducial)
gz_fiducial_alloc = _functions.alloc
gz_fiducial_free = _functions.free
gz_fiducial_create = _functions.create
gz_fiducial_destroy = _functions.destroy
gz_fiducial_open = _functions.open
gz_fiducial_close = _functions.close
gz_fiducial_lock = _functions.lock
gz_fiducial_unlock = _functions.unlock
gz_fiducial_post = _functions.post
