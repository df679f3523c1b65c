"""sonar: the ranges of a ring of ultrasonic sensors."""

from __future__ import annotations

from libgz.interfaces.ranges import RangeData, RangeInterface
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GZ_SONAR_MAX_RANGES",
    "Sonar",
    "SonarData",
    "gz_sonar_alloc",
    "gz_sonar_close",
    "gz_sonar_create",
    "gz_sonar_destroy",
    "gz_sonar_free",
    "gz_sonar_lock",
    "gz_sonar_open",
    "gz_sonar_unlock",
]


GZ_SONAR_MAX_RANGES = 48


@layout
class SonarData(RangeData):
    """gz_sonar_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    max_range: float = double(SERVER, "m", "reading of a sonar that detects nothing")
    sonar_count: int = int32(SERVER, "", "number of sonars, at most 48")
    sonar_pos: Array[float] = double(
        SERVER, "m", "positions in the robot's frame", GZ_SONAR_MAX_RANGES, 3, used="sonar_count"
    )
    sonar_rot: Array[float] = double(
        SERVER, "rad", "rotations in the robot's frame: roll, pitch, yaw", GZ_SONAR_MAX_RANGES, 3, used="sonar_count"
    )
    sonar_ranges: Array[float] = double(SERVER, "m", "measured distances", GZ_SONAR_MAX_RANGES, used="sonar_count")
    cmd_enable_sonar: int = int32(CLIENT, "", "0 or 1; without effect on the Pioneers")


class Sonar(RangeInterface[SonarData]):
    """A ring of sonars."""

    type = "sonar"
    data_class = SonarData

    sonar_pos = View("sonar_pos")
    sonar_rot = View("sonar_rot")
    sonar_ranges = View("sonar_ranges")


_functions = LegacyFunctions(Sonar)
gz_sonar_alloc = _functions.alloc
gz_sonar_free = _functions.free
gz_sonar_create = _functions.create
gz_sonar_destroy = _functions.destroy
gz_sonar_open = _functions.open
gz_sonar_close = _functions.close
gz_sonar_lock = _functions.lock
gz_sonar_unlock = _functions.unlock
