"""sonar: the ranges of a ring of ultrasonic sensors."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from libgz.transport.interface import Interface, View
from libgz.transport.layout import CLIENT, SERVER, Array, Data, double, int32, layout
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
class SonarData(Data):
    """gz_sonar_data_t."""

    time: float = double(SERVER, "s", "sim time of this sample")
    max_range: float = double(SERVER, "m", "what a sonar reads that hears nothing")
    sonar_count: int = int32(SERVER, "", "how many sonars there are, at most 48")
    sonar_pos: Array[float] = double(SERVER, "m", "where they sit in the robot's frame", GZ_SONAR_MAX_RANGES, 3)
    sonar_rot: Array[float] = double(SERVER, "rad", "where they look: roll, pitch, yaw", GZ_SONAR_MAX_RANGES, 3)
    sonar_ranges: Array[float] = double(SERVER, "m", "distance to what each one hears", GZ_SONAR_MAX_RANGES)
    cmd_enable_sonar: int = int32(CLIENT, "", "0 or 1; without effect on the Pioneers")


class Sonar(Interface[SonarData]):
    """A ring of sonars."""

    type = "sonar"
    data_class = SonarData
    has_post = False

    sonar_pos = View("sonar_pos")
    sonar_rot = View("sonar_rot")
    sonar_ranges = View("sonar_ranges")

    @property
    def time(self) -> float:
        """Sim time of the sample [s]."""
        return self.data.time

    @property
    def max_range(self) -> float:
        """What a sonar reads that hears nothing [m]."""
        return self.data.max_range

    @property
    def ranges(self) -> NDArray[np.float64]:
        """Distances [m], shape (sonar_count,); a view of the shared memory."""
        return self.sonar_ranges[: self._count]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Places of the sonars [m], shape (sonar_count, 3); a view of the shared memory."""
        return self.sonar_pos[: self._count]

    @property
    def directions(self) -> NDArray[np.float64]:
        """Where the sonars look: yaw [rad], shape (sonar_count,); a view of the shared memory."""
        return self.sonar_rot[: self._count, 2]

    @property
    def _count(self) -> int:
        return min(max(self.data.sonar_count, 0), GZ_SONAR_MAX_RANGES)


_functions = LegacyFunctions(Sonar)
gz_sonar_alloc = _functions.alloc
gz_sonar_free = _functions.free
gz_sonar_create = _functions.create
gz_sonar_destroy = _functions.destroy
gz_sonar_open = _functions.open
gz_sonar_close = _functions.close
gz_sonar_lock = _functions.lock
gz_sonar_unlock = _functions.unlock
