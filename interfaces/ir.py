"""ir: the ranges of infrared sensors."""

from __future__ import annotations

from libgz.interfaces.ranges import RangeData, RangeInterface
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, double, int32, layout
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
class IrData(RangeData):
    """gz_ir_data_t; only in the repository of November 2006, after the release."""

    time: float = double(SERVER, "s", "sim time of this sample")
    max_range: float = double(SERVER, "m", "reading of a sensor that detects nothing")
    ir_count: int = int32(SERVER, "", "number of sensors, at most 48")
    ir_pos: Array[float] = double(SERVER, "m", "positions in the robot's frame", GZ_IR_MAX_RANGES, 3, used="ir_count")
    ir_rot: Array[float] = double(
        SERVER, "rad", "rotations in the robot's frame: roll, pitch, yaw", GZ_IR_MAX_RANGES, 3, used="ir_count"
    )
    ir_ranges: Array[float] = double(SERVER, "m", "measured distances", GZ_IR_MAX_RANGES, used="ir_count")
    cmd_enable_ir: int = int32(CLIENT, "", "0 or 1")


class Ir(RangeInterface[IrData]):
    """A set of infrared sensors."""

    type = "ir"
    data_class = IrData

    ir_pos = View("ir_pos")
    ir_rot = View("ir_rot")
    ir_ranges = View("ir_ranges")


_functions = LegacyFunctions(Ir)
gz_ir_alloc = _functions.alloc
gz_ir_free = _functions.free
gz_ir_create = _functions.create
gz_ir_destroy = _functions.destroy
gz_ir_open = _functions.open
gz_ir_close = _functions.close
gz_ir_lock = _functions.lock
gz_ir_unlock = _functions.unlock
