"""GpuRaySensor: a laser that sees what images show."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError
from libgz.classic.math import Angle
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.ray import RaySensor
from libgz.classic.sensors.sensor import SensorOwner
from libgz.rendering.depth_scan import DepthScan
from libgz.simulation.event import Connection, Event

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["GpuRaySensor"]

log = logging.getLogger("libgz.classic")

SAME_PLACE = 0.01  # of a range: a collision that near is that of the visual that was seen


class GpuRaySensor(RaySensor):
    """A laser that sees visuals, actors and grounds, not collisions: its ranges are read from rendered depths.

    What is nearer than the minimum range along the axis of an image is not seen, as in Gazebo. Retro values, and the
    ranges where there is no OpenGL, are those of collisions, as a `ray` sensor has them.
    """

    noise_type: ClassVar[SensorNoiseType] = SensorNoiseType.GPU_RAY_NOISE

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._frames = Event(f"NewLaserFrame of sensor {self.ScopedName()}")
        self._depths: DepthScan | None = None

    def Init(self) -> None:
        """Open the views that its ranges are read from."""
        super().Init()
        if self._depths is not None:
            return
        grid = self._shape.grid
        try:
            depths = DepthScan(self.world.core, grid.directions(), grid.spacing, *grid.reach)
        except LibraryError as error:
            log.warning("sensor %s sees collisions instead of visuals: %s", self.ScopedName(), error)
            return
        if depths.blind:
            depths.close()
            log.warning("sensor %s sees collisions instead of visuals: OpenGL is switched off", self.ScopedName())
            return
        self._depths = depths

    def Fini(self) -> None:
        """Close its views."""
        if self._depths is not None:
            self._depths.close()
            self._depths = None
        super().Fini()

    def _scan(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        cast, retros = super()._scan()
        if self._depths is None:
            return cast, retros
        near, far = self._shape.grid.reach
        seen = self._depths.ranges(self.world_pose())
        seen[seen >= far] = math.inf
        self._shape.show(seen)
        ranges = np.minimum(seen, far)
        return ranges, np.where(np.abs(ranges - cast) <= SAME_PLACE * ranges + near, retros, 0.0)

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
