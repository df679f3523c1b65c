"""laser: the ranges of a scanning laser range-finder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled
from libgz.transport.interface import View
from libgz.transport.layout import CLIENT, SERVER, Array, double, int32, layout
from libgz.transport.legacy import LegacyFunctions

__all__ = [
    "GZ_LASER_MAX_RANGES",
    "Laser",
    "LaserData",
    "gz_laser_alloc",
    "gz_laser_close",
    "gz_laser_create",
    "gz_laser_destroy",
    "gz_laser_free",
    "gz_laser_lock",
    "gz_laser_open",
    "gz_laser_post",
    "gz_laser_unlock",
]


GZ_LASER_MAX_RANGES = 401


@layout
class LaserData(SampleData):
    """gz_laser_data_t."""

    time: float = double(SERVER, "s", "sim time of this scan")
    min_angle: float = double(SERVER, "rad", "direction of the first reading, left positive")
    max_angle: float = double(SERVER, "rad", "direction of the last reading")
    res_angle: float = double(SERVER, "rad", "angle between readings")
    max_range: float = double(SERVER, "m", "reading where nothing is hit")
    range_count: int = int32(SERVER, "", "number of readings, at most 400")
    ranges: Array[float] = double(
        SERVER, "m", "distance from the sensor's centre, counter-clockwise", GZ_LASER_MAX_RANGES, used="range_count"
    )
    intensity: Array[int] = int32(
        SERVER, "", "1 where a retro-reflector is hit", GZ_LASER_MAX_RANGES, used="range_count"
    )
    cmd_new_angle: int = int32(CLIENT, "", "1: apply the cmd_ fields below; the server clears it")
    cmd_new_length: int = int32(CLIENT, "", "1: apply the cmd_ fields below; the server clears it")
    cmd_max_range: float = double(CLIENT, "m", "wanted maximum range; 0: as it is")
    cmd_min_angle: float = double(CLIENT, "rad", "wanted direction of the first reading")
    cmd_max_angle: float = double(CLIENT, "rad", "wanted direction of the last reading")
    cmd_range_count: int = int32(CLIENT, "", "wanted number of readings; 0: as it is")


class Laser(SampleInterface[LaserData]):
    """A laser range-finder."""

    type = "laser"
    data_class = LaserData

    all_ranges = View("ranges")
    all_intensities = View("intensity")

    @property
    def max_range(self) -> float:
        """The reading where nothing is hit [m]."""
        return self.data.max_range

    @property
    def ranges(self) -> NDArray[np.float64]:
        """Distances from the sensor's centre [m], shape (range_count,); a view of the shared memory."""
        return filled(self.all_ranges, self.data.range_count)

    @property
    def intensities(self) -> NDArray[np.int32]:
        """1 where a retro-reflector is hit, shape (range_count,); a view of the shared memory."""
        return filled(self.all_intensities, self.data.range_count)

    @property
    def angles(self) -> NDArray[np.float64]:
        """Directions of the readings [rad], left positive, shape (range_count,)."""
        return np.linspace(self.data.min_angle, self.data.max_angle, len(self.ranges))

    def configure(self, min_angle: float, max_angle: float, max_range: float, range_count: int) -> None:
        """Request another scan.

        Args:
            min_angle: direction of the first reading [rad], left positive.
            max_angle: direction of the last reading [rad].
            max_range: maximum range [m].
            range_count: number of readings, at most 400.
        """
        with self.locked() as data:
            data.cmd_min_angle, data.cmd_max_angle = min_angle, max_angle
            data.cmd_max_range, data.cmd_range_count = max_range, range_count
            data.cmd_new_angle = data.cmd_new_length = 1


_functions = LegacyFunctions(Laser)
gz_laser_alloc = _functions.alloc
gz_laser_free = _functions.free
gz_laser_create = _functions.create
gz_laser_destroy = _functions.destroy
gz_laser_open = _functions.open
gz_laser_close = _functions.close
gz_laser_lock = _functions.lock
gz_laser_unlock = _functions.unlock
gz_laser_post = _functions.post
