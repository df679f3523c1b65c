"""fiducial: the poses of marked objects that a sensor recognises."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled
from libgz.transport.interface import View
from libgz.transport.layout import SERVER, Array, Element, double, elements, int32, layout
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
class FiducialData(SampleData):
    """gz_fiducial_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    fid_count: int = int32(SERVER, "", "number of objects in view, at most 401")
    fids: Array[FiducialFid] = elements(FiducialFid, SERVER, "the objects", GZ_FIDUCIAL_MAX_FIDS, used="fid_count")


class Fiducial(SampleInterface[FiducialData]):
    """Marked objects in view."""

    type = "fiducial"
    data_class = FiducialData

    all_fids = View("fids")

    @property
    def fids(self) -> NDArray[np.void]:
        """The objects: records of `id`, `pos` [m] and `rot` [rad], shape (fid_count,); a view of the shared memory."""
        return filled(self.all_fids, self.data.fid_count)


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
