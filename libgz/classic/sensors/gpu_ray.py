"""GpuRaySensor: the laser that Gazebo rendered; here it casts rays like any laser."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from libgz.classic.math import Angle
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.ray import RaySensor
from libgz.classic.sensors.sensor import SensorOwner
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["GpuRaySensor"]


class GpuRaySensor(RaySensor):
    """A laser with the names of Gazebo's GPU laser."""

    noise_type: ClassVar[SensorNoiseType] = SensorNoiseType.GPU_RAY_NOISE

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._frames = Event(f"NewLaserFrame of sensor {self.ScopedName()}")

    def connected(self) -> bool:
        """Whether there are callbacks for its measurements."""
        return super().connected() or bool(self._frames)

    def ConnectNewLaserFrame(self, callback: Callable[..., object]) -> Connection:
        """Call ``callback(data, width, height, depth, format)`` after each scan.

        `data` is a float32 array of `width` x `height` readings, each a range [m], how much came back, and 0.
        """
        return self.listen(self._frames, callback)

    def deliver(self) -> None:
        """Pass the scan to the topic's subscribers and to callbacks."""
        super().deliver()
        if self._frames:
            data = np.zeros((len(self._ranges), 3), dtype=np.float32)
            data[:, 0], data[:, 1] = self._ranges, self._retros
            self._frames(data.ravel(), self.RangeCount(), self.VerticalRangeCount(), 3, "FLOAT32_RGB")

    def HorzFOV(self) -> float:
        """From a row's first reading to its last [rad]."""
        return self.AngleMax().Radian() - self.AngleMin().Radian()

    def VertFOV(self) -> float:
        """From the lowest row to the highest [rad]."""
        return self.VerticalAngleMax().Radian() - self.VerticalAngleMin().Radian()

    def HorzHalfAngle(self) -> Angle:
        """The middle of a row [rad]."""
        return Angle((self.AngleMax().Radian() + self.AngleMin().Radian()) / 2.0)

    def VertHalfAngle(self) -> Angle:
        """The middle of all rows [rad]."""
        return Angle((self.VerticalAngleMax().Radian() + self.VerticalAngleMin().Radian()) / 2.0)

    def RangeCountRatio(self) -> float:
        """Readings of a row by rows."""
        return self.RangeCount() / self.VerticalRangeCount()

    def RayCountRatio(self) -> float:
        """Rays of a row by rows."""
        return self.RayCount() / self.VerticalRayCount()
