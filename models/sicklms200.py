"""SickLMS200: SICK's scanning laser range-finder."""

from __future__ import annotations

import ctypes
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzColor
from libgz.interfaces.fiducial import GZ_FIDUCIAL_MAX_FIDS, Fiducial
from libgz.interfaces.laser import GZ_LASER_MAX_RANGES, Laser
from libgz.legacy.model import Model
from libgz.models.parts import BLACK, add_body, fit
from libgz.models.serving import serve
from libgz.ode.records import CastRecord, ScannerRecord
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom
from libgz.physics.rays import RayProximity
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.simulation.updates import Exchange, UpdateRows, replaced
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import angle, integer, length, number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

BLUE = GzColor(0.0, 0.0, 1.0)
EYE_HEIGHT = 0.07  # of the beams above the origin [m]
SMOOTH = 0.10  # [m]; neighbouring rays are interpolated if they differ by less
MOST_READINGS = GZ_LASER_MAX_RANGES - 1
FARTHEST = 1000.0  # [m]

# Parts of an update that subclasses may replace.
_STEPS = ("_take_command", "_publish_laser", "_publish_fiducials", "_intensities")

Hit = tuple[int, int, Geom | None]  # of `RayProximity.hits`


@dataclass(frozen=True)
class SickAttributes:
    """Attributes of `<model:SickLMS200>`."""

    rangeCount: int = integer(181, least=1, most=MOST_READINGS, help="readings in a scan")
    rayCount: int = integer(91, least=1, most=10000, help="rays cast per scan; readings between rays are interpolated")
    rangeMax: float = length(8.192, above=0.0, help="maximum range; the reading of a ray without a hit")
    rangeMin: float = length(0.20, least=0.0, help="minimum range; where the rays begin")
    scanRate: float = number(10.0, unit="Hz", least=0.0, help="scans per second of sim time")
    minAngle: float = angle(-90.0, help="direction of the first reading, left positive")
    maxAngle: float = angle(90.0, help="direction of the last reading")


class SickLMS200(Model):
    """SICK's scanning laser range-finder with a mass of 7 kg; the origin is the centre of its bottom."""

    STATE: ClassVar[tuple[str, ...]] = ("rate", "_wanted_scan", "rays")
    ROW_PARTS = Model.ROW_PARTS | {
        *("rate", "rays", "laser", "fiducial", "rangeMin", "rangeMax", "minAngle", "maxAngle", "rangeCount"),
        *("readings", "fiducials"),
    }

    attributes = SickAttributes
    interfaces = ("laser", "fiducial")
    example = """
        <model:Pioneer2AT>
          <id>robot1</id>
          <model:SickLMS200>
            <id>laser1</id>
            <xyz>0.1 0 0.311</xyz>
          </model:SickLMS200>
        </model:Pioneer2AT>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(SickAttributes, node)
        if values.rangeMin >= values.rangeMax:
            node.error(
                f"rangeMin {values.rangeMin:g} m is not allowed; it must be below rangeMax, {values.rangeMax:g} m"
            )
            values = SickAttributes()
        self.rangeMin, self.rangeMax = values.rangeMin, values.rangeMax
        self.minAngle, self.maxAngle = values.minAngle, values.maxAngle
        self.rayCount, self.rangeCount = values.rayCount, values.rangeCount
        self.rate = UpdateRate(values.scanRate)
        self.laser, self.fiducial = Laser(), Fiducial()
        self._build()
        self._aim()

    def _build(self) -> None:
        body = add_body(self)
        for size, place in (
            ((0.15, 0.15, 0.04), (0.0, 0.0, 0.02)),
            ((0.15, 0.15, 0.08), (0.0, 0.0, 0.16)),
            ((0.075, 0.15, 0.18), (-0.0375, 0.0, 0.10)),
        ):
            fit(BoxGeom(body, self.modelSpaceId, *size), place, 7.0 / 3.0, BLUE)
        window = CylinderGeom(body, self.modelSpaceId, 0.075, 0.18)
        window.SetRelativePosition((0.0, 0.0, 0.10))
        window.SetColor(BLACK)

    def _aim(self) -> None:
        """Set the rays, and the pair of rays that each reading is interpolated from."""
        count = self.rayCount
        self.angles = np.linspace(self.minAngle, self.maxAngle, count) if count > 1 else np.array([self.minAngle])
        self.rays = RayProximity(self.world, self.GetBody(), count)
        for i, direction in enumerate(self.angles):
            x, y = math.cos(direction), math.sin(direction)
            near, far = self.rangeMin, self.rangeMax
            self.rays.SetRay(i, (near * x, near * y, EYE_HEIGHT), (far * x, far * y, EYE_HEIGHT))
        place = np.arange(self.rangeCount) * ((count - 1) / max(self.rangeCount - 1, 1))
        self._first: NDArray[np.int64] = np.floor(place).astype(np.int64)
        self._second = np.minimum(self._first + 1, count - 1)
        self._share = place - self._first

    @property
    def _wanted_scan(self) -> tuple[float, ...]:
        """What clients can change."""
        return self.minAngle, self.maxAngle, self.rangeMax, self.rangeCount

    @_wanted_scan.setter
    def _wanted_scan(self, value: tuple[float, ...]) -> None:
        if value != self._wanted_scan:
            self.minAngle, self.maxAngle, self.rangeMax = value[:3]
            self.rangeCount = int(value[3])
            self._aim()

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        quirks = self.world.engine.quirks
        self._bright_from = 1.0 if "wholeRetro" in quirks else 0.5
        if "updateTimes" in quirks:
            self.rate = OldRate(self.rate.period, last=self.world.GetSimTime())
        self.guard = Guard(f"laser.{self.GetId()}")
        serve(self, self.laser)
        serve(self, self.fiducial)

    def Fini(self) -> None:  # noqa: D102
        self.laser.destroy()
        self.fiducial.destroy()

    def Update(self, step: float) -> None:  # noqa: D102
        now = self.world.GetSimTime()
        if step == 0.0 or not self.rate.due(now):
            return
        self._take_command()
        self.rays.Update()
        hits = self.rays.hits()
        self._publish_laser(now, hits)
        self._publish_fiducials(now, hits)
        self.laser.post()

    # As rows -----------------------------------------------------------------------------------------------------

    def MasterRowsOfUpdate(self, rows: UpdateRows) -> bool:
        """Describe `Update` as rows: without a request of a client, and where no ray hits a marked object, natively."""
        own = ("Update", "readings", "fiducials", *_STEPS)
        if replaced(self, SickLMS200, *own) or not rows.knows(self.rate):
            return False
        requests = Exchange(self.laser)
        for name in ("cmd_new_angle", "cmd_new_length"):
            requests.switch(name, self.guard.switch_record(name))
        with rows.due(self.rate):
            rows.share(lambda _: self._take_command(), requests)
            cast = rows.cast(lambda _: self.rays.Update(), self.rays)
            if cast is None:
                rows.python(self._publish)
            else:
                rows.share(lambda _: self._publish_laser(self.world.GetSimTime(), self.rays.hits()), self._scan(cast))
                nothing = Exchange(self.fiducial)
                nothing.unmarked(cast)
                nothing.now()
                nothing.integer("fid_count", 0)
                rows.share(lambda _: self._publish_fiducials(self.world.GetSimTime(), self.rays.hits()), nothing)
            rows.post(lambda _: self.laser.post())
        return True

    def _publish(self, _step: float) -> None:
        now, hits = self.world.GetSimTime(), self.rays.hits()
        self._publish_laser(now, hits)
        self._publish_fiducials(now, hits)

    def _scan(self, cast: CastRecord) -> Exchange:
        """What `_publish_laser` writes where no ray hit a reflector."""
        exchange, count = Exchange(self.laser), self.rangeCount
        exchange.unmarked(cast)
        exchange.now()
        exchange.doubles("max_range", np.array([self.rangeMax]))
        exchange.integer("range_count", count)
        exchange.doubles("min_angle", np.array([self.minAngle]))
        exchange.doubles("max_angle", np.array([self.maxAngle]))
        exchange.doubles("res_angle", np.array([self._resolution]))
        kept = (cast, self._first, self._second, self._share)
        exchange.readings("ranges", self._interpolation(cast), count, kept)
        exchange.integer("intensity", 0, count)
        return exchange

    def _interpolation(self, cast: CastRecord) -> ScannerRecord:
        """What `readings` computes."""
        far, near, offset = self._limits
        arrays = (array.ctypes.data for array in (self._first, self._second, self._share))
        return ScannerRecord(ctypes.addressof(cast), *arrays, far, near, offset, SMOOTH)

    # Commands ----------------------------------------------------------------------------------------------------

    def _take_command(self) -> None:
        """Change the scan if a client requests it."""
        if not self.laser.lock():
            return
        data = self.laser.data
        wanted = None
        angle, length = data.cmd_new_angle, data.cmd_new_length
        if angle or length:
            data.cmd_new_angle = data.cmd_new_length = 0
            new = [self.guard.switch("cmd_new_angle", angle, False), self.guard.switch("cmd_new_length", length, False)]
            if any(new):
                wanted = (data.cmd_min_angle, data.cmd_max_angle, data.cmd_max_range, data.cmd_range_count)
        self.laser.unlock()
        if wanted is None:
            return
        wanted = self._completed(*wanted)
        number = self.guard.number
        low = number("cmd_min_angle", wanted[0], self.minAngle, math.pi)
        high = number("cmd_max_angle", wanted[1], self.maxAngle, math.pi)
        far = number("cmd_max_range", wanted[2], self.rangeMax, FARTHEST)
        if high < low or far <= self.rangeMin or wanted[3] < 1:
            self.guard.warn(
                "cmd_min_angle, cmd_max_angle, cmd_max_range, cmd_range_count",
                "are {}, not a valid scan",
                "are ignored",
                wanted,
            )
            return
        self.minAngle, self.maxAngle, self.rangeMax = low, high, far
        self.rangeCount = int(number("cmd_range_count", wanted[3], self.rangeCount, MOST_READINGS))
        self._aim()

    def _completed(self, low: float, high: float, far: float, count: int) -> tuple[float, float, float, int]:
        """A command with the present values for those that a client never wrote: many set angles or range only."""
        if count == 0 and low == high == 0.0:
            low, high = self.minAngle, self.maxAngle
        return low, high, far or self.rangeMax, count or self.rangeCount

    @property
    def _limits(self) -> tuple[float, float, float]:
        """The largest range of a ray, what is added to it, and what is added to readings [m]."""
        if "laserNoHitOffset" in self.world.engine.quirks:
            return self.rangeMax, 0.0, self.rangeMin
        return self.rangeMax - self.rangeMin, self.rangeMin, 0.0

    @property
    def _resolution(self) -> float:
        """The angle between readings [rad]."""
        return (self.maxAngle - self.minAngle) / max(self.rangeCount - 1, 1)

    # Readings ----------------------------------------------------------------------------------------------------

    def readings(self) -> NDArray[np.float64]:
        """Distances from the sensor's centre [m]: interpolated between two rays, or the shorter one of them."""
        far, near, offset = self._limits
        distance = np.minimum(self.rays.ranges, far) + near
        a, b = distance[self._first], distance[self._second]
        between: NDArray[np.float64] = (1.0 - self._share) * a + self._share * b
        return np.where(np.abs(a - b) < SMOOTH, between, np.minimum(a, b)) + offset

    def _publish_laser(self, now: float, hits: list[Hit]) -> None:
        if not self.laser.lock():
            return
        data = self.laser.data
        data.time, data.max_range, data.range_count = now, self.rangeMax, self.rangeCount
        data.min_angle, data.max_angle = self.minAngle, self.maxAngle
        data.res_angle = self._resolution
        count = self.rangeCount  # not that of the interface: a client may have overwritten it
        self.laser.all_ranges[:count] = self.readings()
        self.laser.all_intensities[:count] = self._intensities(hits)
        self.laser.unlock()

    def _intensities(self, hits: list[Hit]) -> NDArray[np.int32] | int:
        """1 for each reading with a ray that hit a reflector, else 0; 0 for all where there is none."""
        bright: NDArray[np.int32] | None = None
        for i, j, geom in hits:
            if geom is not None and geom.GetRetro() >= self._bright_from:
                bright = np.zeros(self.rayCount, dtype=np.int32) if bright is None else bright
                bright[i:j] = 1
        return 0 if bright is None else bright[self._first] | bright[self._second]

    def _publish_fiducials(self, now: float, hits: list[Hit]) -> None:
        found = self.fiducials(hits)
        if not self.fiducial.lock():
            return
        data = self.fiducial.data
        data.time, data.fid_count = now, len(found)
        for fid, (number_, x, y, yaw) in zip(data.fids, found, strict=False):
            fid.id, fid.pos[:], fid.rot[:] = number_, (x, y, 0.0), (0.0, 0.0, yaw)
        self.fiducial.unlock()

    def fiducials(self, hits: list[Hit] | None = None) -> list[tuple[int, float, float, float]]:
        """(number, x [m], y [m], yaw [rad]) of marked objects in the sensor's frame, among `hits` of the rays.

        Neighbouring rays with the same number are one object, at the middle of its two ends. With three rays or more
        its yaw is normal to the line between the ends; with fewer, it faces the sensor.
        """
        seen: list[list[int]] = []  # number, first and last ray
        for i, j, geom in self.rays.hits() if hits is None else hits:
            number_ = geom.GetFiducial() if geom is not None else -1
            if number_ < 0:
                continue
            if seen and seen[-1][0] == number_ and seen[-1][2] == i - 1:
                seen[-1][2] = j - 1
            else:
                seen.append([number_, i, j - 1])
        found = []
        for number_, i, j in seen[:GZ_FIDUCIAL_MAX_FIDS]:
            (ax, ay), (bx, by) = self._point(i), self._point(j)
            x, y = (ax + bx) / 2.0, (ay + by) / 2.0
            yaw = math.atan2(by - ay, bx - ax) + math.pi / 2.0 if j - i >= 2 else math.atan2(y, x) + math.pi
            found.append((number_, x, y, yaw))
        return found

    def _point(self, ray: int) -> tuple[float, float]:
        """The point that a ray hit, in the sensor's plane [m]."""
        distance, direction = self.rangeMin + float(self.rays.ranges[ray]), float(self.angles[ray])
        return distance * math.cos(direction), distance * math.sin(direction)
