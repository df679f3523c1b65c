"""RangeInterface: the base of the interfaces of several range sensors on one robot, sonar and ir."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.interfaces.sample import SampleData, SampleInterface
from libgz.interfaces.views import filled

__all__ = ["RangeData", "RangeInterface"]

R = TypeVar("R", bound="RangeData")


class RangeData(SampleData):
    """Base of the structs of range sensors; each declares `max_range` itself."""

    __slots__ = ()

    max_range: float


class RangeInterface(SampleInterface[R]):
    """The poses and readings of several range sensors.

    The names of the struct's fields begin with the type of the interface: `sonar_count`, `sonar_pos`, `sonar_rot` and
    `sonar_ranges`.
    """

    has_post = False

    @property
    def count(self) -> int:
        """The number of sensors, as the server writes it."""
        count: int = getattr(self.data, f"{self.type}_count")
        return count

    @property
    def max_range(self) -> float:
        """The reading of a sensor that detects nothing [m]."""
        return self.data.max_range

    @property
    def ranges(self) -> NDArray[np.float64]:
        """Distances [m], shape (count,); a view of the shared memory."""
        return filled(self.array(f"{self.type}_ranges"), self.count)

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions of the sensors in the robot's frame [m], shape (count, 3); a view of the shared memory."""
        return filled(self.array(f"{self.type}_pos"), self.count)

    @property
    def directions(self) -> NDArray[np.float64]:
        """Directions of the sensors in the robot's frame: yaw [rad], shape (count,); a view of the shared memory."""
        return filled(self.array(f"{self.type}_rot"), self.count)[:, 2]
