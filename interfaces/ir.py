"""ir: the ranges of infrared sensors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.transport.interface import Interface, View
from libgz.transport.layout import CLIENT, SERVER, Array, Data, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GZ_IR_MAX_RANGES",
    "Ir",
    "IrData",
    "gz_ir_alloc",
    "gz_ir_close",
    "gz_ir_create",
    "gz_ir_destroy",
    "gz_ir_free",
    "gz_ir_lock",
    "gz_ir_open",
    "gz_ir_unlock",
]


GZ_IR_MAX_RANGES = 48


@layout
class IrData(Data):
    """gz_ir_data_t; in the repository of November 2006 only."""

    time: float = double(SERVER, "s", "sim time of this sample")
    max_range: float = double(SERVER, "m", "what a sensor reads that sees nothing")
    ir_count: int = int32(SERVER, "", "how many sensors there are, at most 48")
    ir_pos: Array[float] = double(SERVER, "m", "where they sit in the robot's frame", GZ_IR_MAX_RANGES, 3)
    ir_rot: Array[float] = double(SERVER, "rad", "where they look: roll, pitch, yaw", GZ_IR_MAX_RANGES, 3)
    ir_ranges: Array[float] = double(SERVER, "m", "distance to what each one sees", GZ_IR_MAX_RANGES)
    cmd_enable_ir: int = int32(CLIENT, "", "0 or 1")


class Ir(Interface[IrData]):
    """A set of infrared sensors."""

    type = "ir"
    data_class = IrData
    has_post = False

    ir_pos = View("ir_pos")
    ir_rot = View("ir_rot")
    ir_ranges = View("ir_ranges")

    @property
    def time(self) -> float:
        """Sim time of the sample [s]."""
        return self.data.time

    @property
    def ranges(self) -> NDArray[np.float64]:
        """Distances [m], shape (ir_count,); a view of the shared memory."""
        return self.ir_ranges[: min(max(self.data.ir_count, 0), GZ_IR_MAX_RANGES)]


_functions = LegacyFunctions(Ir)
gz_ir_alloc = _functions.alloc
gz_ir_free = _functions.free
gz_ir_create = _functions.create
gz_ir_destroy = _functions.destroy
gz_ir_open = _functions.open
gz_ir_close = _functions.close
gz_ir_lock = _functions.lock
gz_ir_unlock = _functions.unlock
