"""GarminGPS: a satellite navigation receiver."""

from __future__ import annotations

from typing import ClassVar

from libgz.base.geometry import GzColor
from libgz.interfaces.gps import Gps
from libgz.legacy.model import Model
from libgz.models.parts import add_body, fit
from libgz.models.serving import serve
from libgz.models.utm import utm_to_geodetic
from libgz.physics.geoms import CylinderGeom
from libgz.simulation.plan import Plan
from libgz.simulation.rate import OldRate, UpdateRate
from libgz.worldfile.attributes import color, declaration, lengths, number, read
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

FARTHEST = 2e7  # [m], half the circumference of the earth; beyond it there is no fix


@declaration
class GarminGPSAttributes:
    """Attributes of `<model:GarminGPS>`."""

    size: tuple[float, ...] = lengths(0.08, 0.05, help="diameter and height")
    mass: float = number(1.0, unit="kg", above=0.0, help="mass")
    color: GzColor = color(1.0, 1.0, 1.0, help="colour")
    updateFreq: float = number(1.0, unit="Hz", least=0.0, help="fixes per second of sim time")


class GarminGPS(Model):
    """A satellite receiver without noise and with an unobstructed view of the sky.

    The origin is the centre of its bottom. Its UTM coordinates are its position plus the world's utmOffset; latitude
    and longitude follow from them and utmZone, on WGS84. Without utmZone they stay 0.
    """

    STATE: ClassVar[tuple[str, ...]] = ("rate", "zone")

    attributes = GarminGPSAttributes
    interfaces = ("gps",)
    example = """
        <param:Global>
          <utmZone>31</utmZone>
          <utmOffset>448251.795 5411932.678 35</utmOffset>
        </param:Global>

        <model:Pioneer2AT>
          <id>robot1</id>
          <model:GarminGPS>
            <id>gps1</id>
            <xyz>-0.15 0 0.311</xyz>
          </model:GarminGPS>
        </model:Pioneer2AT>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        values = read(GarminGPSAttributes, node)
        body = add_body(self)
        diameter, height = values.size
        housing = CylinderGeom(body, self.modelSpaceId, diameter / 2.0, height)
        fit(housing, (0.0, 0.0, height / 2.0), values.mass, values.color)
        self.rate = UpdateRate(values.updateFreq)
        if "updateTimes" in self.world.engine.quirks and values.updateFreq > 0.0:
            self.rate = OldRate(1.0 / values.updateFreq, last=0.0, beyond=True)
        self.gps = Gps()
        self.zone = int(self.world.utmZone.x)
        if self.zone == 0:
            node.warn("the world sets no <utmZone> in <param:Global>: latitude and longitude stay 0")

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        serve(self, self.gps)

    def Fini(self) -> None:  # noqa: D102
        self.gps.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            plan.call(self._publish)

    def _publish(self) -> None:
        """Publish where it is."""
        now = self.world.GetSimTime()
        here, offset = self.GetPose().pos, self.world.utmOffset
        east, north = here.x + offset.x, here.y + offset.y
        in_range = max(abs(east), abs(north)) <= FARTHEST
        latitude, longitude = utm_to_geodetic(east, north, self.zone) if self.zone and in_range else (0.0, 0.0)
        if not self.gps.lock():
            return
        data = self.gps.data
        data.time, data.utc_time = now, self.world.utcOffset + now
        data.latitude, data.longitude, data.altitude = latitude, longitude, here.z + offset.z
        data.utm_e, data.utm_n = east, north
        data.satellites, data.quality, data.hdop, data.vdop = 10, 2, 1.0, 1.0
        data.err_horz = data.err_vert = 0.0
        self.gps.unlock()
        self.gps.post()
