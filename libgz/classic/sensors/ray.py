"""RaySensor: a laser that scans in rows."""

from __future__ import annotations

import logging
import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzPose
from libgz.classic import msgs
from libgz.classic.math import Angle
from libgz.classic.physics.ray_shape import MultiRayShape, ScanGrid
from libgz.classic.sensors.noise import SensorNoiseType
from libgz.classic.sensors.read import clip, count, number, wrong
from libgz.classic.sensors.sensor import LinkSensor, SensorCategory, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["RaySensor"]

log = logging.getLogger("libgz.classic")

MOST_RAYS = 10_000_000


class RaySensor(LinkSensor):
    """A laser. Distances beyond its range are +inf, those below its minimum -inf.

    Rays are cast against collisions, those of the laser's own link included, from the minimum range on. What stands
    nearer stops them, unlike in Gazebo, which sees through it; the laser's own model does not. Where
    `resolution` is not 1, there are samples * resolution readings, interpolated between the rays.
    """

    STATE = (
        "_ranges",
        "_retros",
        "_shape",
    )

    category: ClassVar[SensorCategory] = SensorCategory.RAY
    topic_suffix: ClassVar[str | None] = "scan"
    topic_added = True
    message_type: ClassVar[Any] = msgs.LaserScanStamped
    noise_type: ClassVar[SensorNoiseType] = SensorNoiseType.RAY_NOISE

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        ray = sdf.child("ray")
        scan, reach = ray.child("scan"), ray.child("range")
        horizontal = _row(scan.child("horizontal"))
        vertical = _row(scan.child("vertical")) if scan.HasElement("vertical") else (1, 1, (0.0, 0.0))
        if horizontal[0] * vertical[0] > MOST_RAYS or horizontal[1] * vertical[1] > MOST_RAYS:
            raise wrong(scan, "samples", f"there are more than {MOST_RAYS} rays or readings")
        near, far = clip(reach, "min", "max")
        self._resolution = number(reach, "resolution", 0.0, unit="m")
        self._readings = horizontal[1], vertical[1]
        grid = ScanGrid((horizontal[0], vertical[0]), (horizontal[2], vertical[2]), (near, far))
        self._shape = MultiRayShape(parent.body.engine, parent.body, self._pose, grid)
        self._mixing = _mixing(grid.samples, self._readings) if grid.samples != self._readings else None
        self._ranges: NDArray[np.float64] = np.zeros(0)
        self._retros: NDArray[np.float64] = np.zeros(0)
        self.add_noise(self.noise_type, ray)

    def Init(self) -> None:
        """Show the rays in viewers, if its file asks for that."""
        if self.Visualize():
            self.world.core.engine.ray_bundles.add(self._shape)

    def SetPose(self, pose: GzPose) -> None:
        """Set the pose in its link [m]."""
        super().SetPose(pose)
        self._shape.place(self._pose)

    def SaveState(self) -> None:
        """Its pose is all that the rays have."""

    def LoadState(self, _state: object) -> None:
        """Place the rays where its pose is now."""
        self._shape.place(self._pose)

    def LaserShape(self) -> MultiRayShape:
        """The rays."""
        return self._shape

    GetLaserShape = LaserShape

    # Measuring ---------------------------------------------------------------------------------------------------

    def measure(self, elapsed: float) -> None:
        """Cast all rays."""
        ranges, self._retros = self._scan()
        if self._mixing is not None:
            ranges = _mix(ranges, self._mixing)
            self._retros = _mix(self._retros, self._mixing, average=True)
        near, far = self._shape.grid.reach
        noise = self.noises.get(self.noise_type)
        measured = ranges if noise is None else np.clip(noise.apply_all(ranges), near, far)
        self._ranges = np.where(ranges >= far, math.inf, np.where(ranges <= near, -math.inf, measured))

    def _scan(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Ranges [m] and retro values of all rays."""
        self._shape.Update()
        return self._shape.ranges(), self._shape.retros()

    def message(self) -> Any:
        """The last scan as a msgs.LaserScanStamped."""
        msg = self.stamped()
        scan = msg.scan
        scan.frame = self.ParentName()
        msgs.Set(scan.world_pose, self.world_pose())
        scan.angle_min, scan.angle_max = self.AngleMin().Radian(), self.AngleMax().Radian()
        scan.angle_step, scan.count = self.AngleResolution(), self.RangeCount()
        scan.vertical_angle_min, scan.vertical_angle_max = (
            self.VerticalAngleMin().Radian(),
            self.VerticalAngleMax().Radian(),
        )
        scan.vertical_angle_step, scan.vertical_count = self.VerticalAngleResolution(), self.VerticalRangeCount()
        scan.range_min, scan.range_max = self._shape.grid.reach
        scan.ranges, scan.intensities = self._ranges.tolist(), self._retros.tolist()
        return msg

    def FillMsg(self, msg: Any) -> None:
        """Describe the sensor and its rays in a msgs.Sensor."""
        super().FillMsg(msg)
        about = msg.ray
        about.display_scan = self.Visualize()
        about.horizontal_samples, about.vertical_samples = self.RayCount(), self.VerticalRayCount()
        about.horizontal_min_angle, about.horizontal_max_angle = float(self.AngleMin()), float(self.AngleMax())
        about.vertical_min_angle = float(self.VerticalAngleMin())
        about.vertical_max_angle = float(self.VerticalAngleMax())
        about.range_min, about.range_max = self.RangeMin(), self.RangeMax()
        about.range_resolution = self.RangeResolution()

    def Ranges(self) -> list[float]:
        """All readings of the last scan [m], row after row."""
        return self._ranges.tolist()  # type: ignore[no-any-return]

    def ranges(self) -> NDArray[np.float64]:
        """All readings of the last scan [m], row after row, as an array that is not to be changed."""
        return self._ranges

    def intensities(self) -> NDArray[np.float64]:
        """How much of the laser came back, for each reading, as an array that is not to be changed."""
        return self._retros

    def Range(self, index: int) -> float:
        """One reading of the last scan [m]; 0 before there was one."""
        return self._reading(self._ranges, index, "range")

    def Retro(self, index: int) -> float:
        """How much of the laser came back, for one reading."""
        return self._reading(self._retros, index, "intensity")

    def _reading(self, values: NDArray[np.float64], index: int, what: str) -> float:
        if not 0 <= index < len(values):
            log.error("sensor %s: Invalid %s index[%s]; it has %d", self.ScopedName(), what, index, len(values))
            return 0.0
        return float(values[index])

    def Fiducial(self, index: int) -> int:
        """The fiducial number of what the ray of a reading hit; -1 for none."""
        row, column = divmod(index, self._readings[0])
        rays, rows = self._shape.grid.samples
        return self._shape.Fiducial(row * rows // self._readings[1] * rays + column * rays // self._readings[0])

    GetRanges, GetRange, GetRetro, GetFiducial = Ranges, Range, Retro, Fiducial

    # Description -------------------------------------------------------------------------------------------------

    def RangeMin(self) -> float:
        """Nearest that is measured [m]."""
        return self._shape.MinRange()

    def RangeMax(self) -> float:
        """Farthest that is measured [m]."""
        return self._shape.MaxRange()

    def RangeResolution(self) -> float:
        """The file's resolution of ranges [m], which nothing depends on."""
        return self._resolution

    def AngleMin(self) -> Angle:
        """Direction of a row's first reading [rad]."""
        return self._shape.MinAngle()

    def AngleMax(self) -> Angle:
        """Direction of a row's last reading [rad]."""
        return self._shape.MaxAngle()

    def VerticalAngleMin(self) -> Angle:
        """Elevation of the lowest row [rad]."""
        return self._shape.VerticalMinAngle()

    def VerticalAngleMax(self) -> Angle:
        """Elevation of the highest row [rad]."""
        return self._shape.VerticalMaxAngle()

    def AngleResolution(self) -> float:
        """Between the readings of a row [rad]."""
        return _step(self.AngleMin(), self.AngleMax(), self.RangeCount())

    def VerticalAngleResolution(self) -> float:
        """Between rows [rad]."""
        return _step(self.VerticalAngleMin(), self.VerticalAngleMax(), self.VerticalRangeCount())

    def RayCount(self) -> int:
        """Rays in a row."""
        return self._shape.SampleCount()

    def VerticalRayCount(self) -> int:
        """Rows of rays."""
        return self._shape.VerticalSampleCount()

    def RangeCount(self) -> int:
        """Readings in a row."""
        return self._readings[0]

    def VerticalRangeCount(self) -> int:
        """Rows of readings."""
        return self._readings[1]

    GetRangeMin, GetRangeMax, GetRangeResolution = RangeMin, RangeMax, RangeResolution
    GetAngleMin, GetAngleMax, GetAngleResolution = AngleMin, AngleMax, AngleResolution
    GetVerticalAngleMin, GetVerticalAngleMax = VerticalAngleMin, VerticalAngleMax
    GetVerticalAngleResolution = VerticalAngleResolution
    GetRayCount, GetVerticalRayCount = RayCount, VerticalRayCount
    GetRangeCount, GetVerticalRangeCount = RangeCount, VerticalRangeCount


def _row(element: Element) -> tuple[int, int, tuple[float, float]]:
    """(rays, readings, (first, last) angle [rad]) of `<horizontal>` or `<vertical>`."""
    samples = count(element, "samples", most=MOST_RAYS)
    resolution = number(element, "resolution", 0.0)
    if samples * resolution > MOST_RAYS:
        message = f"is {resolution:g}; samples times resolution must be at most {MOST_RAYS}"
        raise wrong(element, "resolution", message)
    readings = int(samples * resolution)
    if readings < 1:
        message = f"is {resolution:g}; samples times resolution is less than 1, and 1 is used instead"
        log.warning("%s", wrong(element, "resolution", message))
        readings = 1
    low, high = (number(element, key, unit="rad") for key in ("min_angle", "max_angle"))
    return samples, readings, (low, high)  # in either order: the first ray is the one at <min_angle>


def _step(low: Angle, high: Angle, readings: int) -> float:
    return (high.Radian() - low.Radian()) / (readings - 1) if readings > 1 else 0.0


_Mixing = tuple[NDArray[np.int64], NDArray[np.float64]]


def _mixing(samples: tuple[int, int], readings: tuple[int, int]) -> _Mixing:
    """(indices, weights), shape (readings, 4): how readings between rays are interpolated bilinearly."""
    lower, upper, share = [], [], []
    for rays, wanted in zip(samples, readings, strict=True):
        place = np.linspace(0.0, rays - 1.0, wanted) if wanted > 1 else np.zeros(1)
        below = np.minimum(np.floor(place), rays - 1).astype(np.int64)
        lower.append(below)
        upper.append(np.minimum(below + 1, rays - 1))
        share.append(place - below)
    rows = [lower[1], lower[1], upper[1], upper[1]]
    columns = [lower[0], upper[0], lower[0], upper[0]]
    h, v = share[0][None, :], share[1][:, None]
    weights = [(1 - v) * (1 - h), (1 - v) * h, v * (1 - h), v * h]
    indices = [(row[:, None] * samples[0] + column[None, :]).ravel() for row, column in zip(rows, columns, strict=True)]
    return np.stack(indices, axis=1), np.stack([weight.ravel() for weight in weights], axis=1)


def _mix(values: NDArray[np.float64], mixing: _Mixing, average: bool = False) -> NDArray[np.float64]:
    indices, weights = mixing
    corners = values[indices]
    mixed: NDArray[np.float64] = corners.mean(axis=1) if average else (corners * weights).sum(axis=1)
    return mixed
