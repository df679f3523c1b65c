"""SickLMS200: SICK's scanning laser range-finder."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzColor, GzPose, GzQuatern, GzVector
from libgz.base.law import law, usually
from libgz.interfaces.fiducial import GZ_FIDUCIAL_MAX_FIDS, Fiducial, FiducialData
from libgz.interfaces.laser import GZ_LASER_MAX_RANGES, Laser, LaserData
from libgz.legacy.model import Model
from libgz.models.parts import BLACK, add_body, fit
from libgz.models.serving import serve
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom
from libgz.physics.rays import RayProximity
from libgz.simulation.exchange import Exchange
from libgz.simulation.plan import Plan, handler
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.transport.guard import Guard
from libgz.worldfile.attributes import angle, declaration, integer, length, number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

BLUE = GzColor(0.0, 0.0, 1.0)
EYE_HEIGHT = 0.07  # of the beams above the origin [m]
SMOOTH = 0.10  # [m]; neighbouring rays are interpolated if they differ by less
MOST_READINGS = GZ_LASER_MAX_RANGES - 1
FARTHEST = 1000.0  # [m]

# Parts of an update that subclasses may replace.

Hit = tuple[int, int, Geom | None]  # of `RayProximity.hits`


@declaration
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

    @property
    def beam_origin(self) -> GzPose:
        """Where the beams begin, in the body frame."""
        return GzPose(GzVector(0.0, 0.0, EYE_HEIGHT), GzQuatern(1.0, 0.0, 0.0, 0.0))

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

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            plan.exchange(self.laser, None, unless=self._expect, otherwise=self._take_command)
            plan.cast(lambda: self.rays)
            plan.exchange(self.laser, self._publish_laser)
            plan.exchange(self.fiducial, self._publish_fiducials)
            plan.post(self.laser)

    # Commands ----------------------------------------------------------------------------------------------------

    def _expect(self, exchange: Exchange) -> None:
        """The condition that there is no request."""
        for name in ("cmd_new_angle", "cmd_new_length"):
            exchange.switch(name, self.guard.switch_record(name))

    @handler
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
    @law
    def _limits(self) -> tuple[float, float, float]:
        """The largest range of a ray, what is added to it, and what is added to readings [m]."""
        if "laserNoHitOffset" in self.world.engine.quirks:
            return self.rangeMax, 0.0, self.rangeMin
        return self.rangeMax - self.rangeMin, self.rangeMin, 0.0

    @property
    @law
    def _resolution(self) -> float:
        """The angle between readings [rad]."""
        return (self.maxAngle - self.minAngle) / max(self.rangeCount - 1, 1)

    # Readings ----------------------------------------------------------------------------------------------------

    @law
    def readings(self) -> NDArray[np.float64]:
        """Distances from the sensor's centre [m]: interpolated between two rays, or the shorter one of them."""
        far, near, offset = self._limits
        distance = np.minimum(self.rays.ranges, far) + near
        a, b = distance[self._first], distance[self._second]
        between: NDArray[np.float64] = (1.0 - self._share) * a + self._share * b
        return np.where(np.abs(a - b) < SMOOTH, between, np.minimum(a, b)) + offset

    @law
    def _publish_laser(self, data: LaserData) -> None:
        data.time, data.max_range, data.range_count = self.world.GetSimTime(), self.rangeMax, self.rangeCount
        data.min_angle, data.max_angle = self.minAngle, self.maxAngle
        data.res_angle = self._resolution
        count = self.rangeCount  # not that of the interface: a client may have overwritten it
        self.laser.all_ranges[:count] = self.readings()
        self.laser.all_intensities[:count] = 0 if usually(self.rays.unmarked()) else self._intensities()

    def _intensities(self) -> NDArray[np.int32] | int:
        """1 for each reading with a ray that hit a reflector, else 0; 0 for all where there is none."""
        bright: NDArray[np.int32] | None = None
        for i, j, geom in self.rays.hits():
            if geom is not None and geom.GetRetro() >= self._bright_from:
                bright = np.zeros(self.rayCount, dtype=np.int32) if bright is None else bright
                bright[i:j] = 1
        return 0 if bright is None else bright[self._first] | bright[self._second]

    @law
    def _publish_fiducials(self, data: FiducialData) -> None:
        found = [] if usually(self.rays.unmarked()) else self.fiducials()
        data.time, data.fid_count = self.world.GetSimTime(), len(found)
        for fid, (number_, x, y, yaw) in zip(data.fids, found, strict=False):
            fid.id, fid.pos[:], fid.rot[:] = number_, (x, y, 0.0), (0.0, 0.0, yaw)

    def fiducials(self) -> list[tuple[int, float, float, float]]:
        """(number, x [m], y [m], yaw [rad]) of marked objects in the sensor's frame.

        Neighbouring rays with the same number are one object, at the middle of its two ends. With three rays or more
        its yaw is normal to the line between the ends; with fewer, it faces the sensor.
        """
        seen: list[list[int]] = []  # number, first and last ray
        for i, j, geom in self.rays.hits():
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
