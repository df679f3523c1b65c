"""WiFi: a radio that receives the other radios of its world."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.base.geometry import GzVectorMag, GzVectorSub
from libgz.interfaces.wifi import GAZEBO_WIFI_MAX_LINKS, GAZEBO_WIFI_QUAL_DBM, Wifi
from libgz.legacy.model import Model
from libgz.models.parts import add_body
from libgz.models.serving import serve
from libgz.simulation.plan import Plan
from libgz.simulation.rate import UpdateRate
from libgz.worldfile.attributes import declaration, number, read, text
from libgz.worldfile.file import WorldFile
from libgz.worldfile.node import WorldFileNode

FREQUENCY = 2.437e9  # [Hz], channel 6
LIGHT_SPEED = 299792458.0  # [m/s]
NEAREST = 1.0  # [m]; the smallest distance in the formula
LOSS_AT_NEAREST = 20.0 * math.log10(4.0 * math.pi * NEAREST * FREQUENCY / LIGHT_SPEED)  # [dB], Friis


@declaration
class WiFiAttributes:
    """Attributes of `<model:WiFi>`."""

    ip: str = text("", help="address; by default 192.168.0.1, .2 and so on in the order of the worldfile")
    power: float = number(15.0, unit="dBm", least=-100.0, most=100.0, help="transmitted power")
    pathLoss: float = number(2.0, least=0.0, most=10.0, help="path loss exponent; 2: free space")
    noise: float = number(-95.0, unit="dBm", least=-200.0, most=0.0, help="noise at the receiver")
    sensitivity: float = number(-90.0, unit="dBm", least=-200.0, most=100.0, help="weakest signal that makes a link")
    updateRate: float = number(10.0, unit="Hz", least=0.0, help="updates per second of sim time")


class WiFi(Model):
    """A radio without a shape, usually nested in a robot, with links to the other radios in range.

    The level of a link is the other's power, minus the free-space loss over the first metre (40.2 dB at 2.437 GHz),
    minus 10 pathLoss log10(distance / 1 m): the log-distance model. Obstacles have no effect. The strongest link comes
    first, and there are at most 16.
    """

    STATE: ClassVar[tuple[str, ...]] = ("ip", "rate")

    attributes = WiFiAttributes
    interfaces = ("wifi",)
    example = """
        <model:Pioneer2DX>
          <id>robot1</id>
          <xyz>0 0 0.24</xyz>
          <model:WiFi>
            <id>wifi1</id>
          </model:WiFi>
        </model:Pioneer2DX>
    """

    def Load(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        self.values = read(WiFiAttributes, node)
        add_body(self, dummy=True)
        others = self._others()
        self.ip = self.values.ip or f"192.168.0.{len(others) + 1}"
        taken = next((other.GetId() for other in others if other.ip == self.ip), None)
        if taken is not None:
            node.warn(f"the address {self.ip} is already used by {taken!r}")
        if len(self.ip.encode()) > 31:
            node.error(f"{self.ip!r} is not allowed; ip must be at most 31 bytes")
        self.rate = UpdateRate(self.values.updateRate)
        self.wifi = Wifi()

    def Init(self, file: WorldFile, node: WorldFileNode) -> None:  # noqa: D102
        serve(self, self.wifi)

    def Fini(self) -> None:  # noqa: D102
        self.wifi.destroy()

    def plan_update(self, plan: Plan) -> None:  # noqa: D102
        with plan.due(self.rate):
            plan.call(self._publish)

    def _publish(self) -> None:
        now = self.world.GetSimTime()
        links = self.links()
        if not self.wifi.lock():
            return
        data = self.wifi.data
        data.time, data.link_count = now, len(links)
        for link, (ip, level) in zip(data.links, links, strict=False):
            link.ip, link.qual = ip.encode(), GAZEBO_WIFI_QUAL_DBM
            link.level, link.noise = _pattern(level), _pattern(self.values.noise)
        self.wifi.unlock()

    def links(self) -> list[tuple[str, float]]:
        """(address, level [dBm]) of the radios in range, strongest first, at most 16."""
        here = self.GetPose().pos
        found = []
        for other in self._others():
            distance = GzVectorMag(GzVectorSub(other.GetPose().pos, here))
            loss = LOSS_AT_NEAREST + 10.0 * self.values.pathLoss * math.log10(max(distance, NEAREST) / NEAREST)
            level = other.values.power - loss
            if level >= self.values.sensitivity:
                found.append((other.ip, level))
        return sorted(found, key=lambda link: -link[1])[:GAZEBO_WIFI_MAX_LINKS]

    def _others(self) -> list[WiFi]:
        return [model for model in self.world.models if isinstance(model, WiFi) and model is not self]


def _pattern(dbm: float) -> int:
    """A level as in the interface: whole dBm, as 16 bits of two's complement."""
    return round(dbm) & 0xFFFF
