"""FlashLightPlugin, which switches lights of links on and off in a rhythm, and is a base of others."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.base.geometry import GzColor
from libgz.classic import msgs, transport
from libgz.classic.event import Events
from libgz.classic.math import Color
from libgz.classic.plugin import ModelPlugin
from libgz.physics.geoms import LightGeom

if TYPE_CHECKING:
    from libgz.classic.common import UpdateInfo
    from libgz.classic.physics import Model
    from libgz.sdf.element import Element


__all__ = ["FlashLightPlugin", "Lamp"]


@dataclass
class Block:
    """A part of a light's rhythm.

    Attributes:
        duration: for which the light is on [s].
        interval: for which it is off afterwards [s].
        color: of the light; None: its own.
    """

    duration: float
    interval: float
    color: GzColor | None


@dataclass
class Lamp:
    """A light that flashes: `link/light`, its geom, range when on [m], colour, and rhythm."""

    name: str
    geom: LightGeom | None
    range: float
    color: GzColor | None
    blocks: list[Block]

    def block_at(self, time: float) -> tuple[Block, bool]:
        """The block that is due at a time since the start [s], and whether the light is on."""
        total = sum(block.duration + block.interval for block in self.blocks)
        left = math.fmod(time, total) if total > 0.0 else 0.0
        for block in self.blocks:
            if left < block.duration + block.interval:
                return block, left < block.duration
            left -= block.duration + block.interval
        return self.blocks[-1], True


class FlashLightPlugin(ModelPlugin):
    """Switches lights of the model's links on for a duration, and off for an interval, again and again.

    A plugin of your own can derive from this class, and call TurnOn, TurnOff, TurnOnAll and TurnOffAll.

    Elements:
        enable: whether the lights flash from the start on (true).
        light: one a light.
            id: `link/light`, the names of link and light.
            duration, interval: [s] (1, 1).
            enable: for this light.
            block: a part of a rhythm of several: `duration`, `interval` and `color`; several.
    """

    STATE: ClassVar[tuple[str, ...]] = ("running", "since")

    def Load(self, model: Model, sdf: Element) -> None:
        """Find the lights.

        Raises:
            NotFoundError: there is no such light.
            ParameterError: a time is negative.
        """
        self.model = model
        self.node = transport.Node()
        self.node.Init(model.GetWorld().Name())
        self.publisher = self.node.Advertise(msgs.Light, "~/light/modify")  # for the clients of other processes
        self.lamps: dict[str, Lamp] = {}
        self.start: dict[str, bool] = {}
        together = sdf.Get(bool, "enable", True)[0]
        for element in sdf.named("light"):
            name = element.Get(str, "id").strip()
            if not name:
                raise NotFoundError(f"{element.where}: <id> is missing; it names link and light, such as link/lamp")
            geom = self._find(element, name)
            reach, color = (geom.range, geom.GetDiffuseColor()) if geom is not None else (0.0, None)
            self.lamps[name] = Lamp(name, geom, reach, color, self._blocks(element))
            self.start[name] = element.Get(bool, "enable", together)[0]
        if not self.lamps:
            raise NotFoundError(f"{sdf.where}: <light> is missing; there must be one for each light that flashes")
        self.Reset()
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)

    def _find(self, element: Element, name: str) -> LightGeom | None:
        found: dict[str, LightGeom] = {}
        for link in self.model.family_links():
            geoms = [geom for geom in link.body.geoms if isinstance(geom, LightGeom)]
            described = link.GetSDF()
            elements = list(described.named("light")) if described is not None else []
            for geom, light in zip(geoms, elements, strict=False):
                found[f"{link.GetName()}/{light.Get(str, 'name')}"] = geom
        if name not in found:
            known = ", ".join(found) or "no light"
            raise NotFoundError(
                f"{element.where}: <id> is {name!r}; model {self.model.GetName()!r} has {known}{nearest(name, found)}"
            )
        return found[name]

    @staticmethod
    def _blocks(element: Element) -> list[Block]:
        blocks = [
            Block(
                block.Get(float, "duration", 1.0)[0],
                block.Get(float, "interval", 1.0)[0],
                block.Get(Color, "color") if block.HasElement("color") else None,
            )
            for block in (list(element.named("block")) or [element])
        ]
        for block in blocks:
            if not (block.duration >= 0.0 and block.interval >= 0.0):
                raise ParameterError(f"{element.where}: <duration> and <interval> must not be negative")
        return blocks

    def Reset(self) -> None:
        """Start the rhythm again."""
        self.running = dict(self.start)
        self.since = dict.fromkeys(self.lamps, 0.0)

    def OnUpdate(self, info: UpdateInfo) -> None:
        """Switch the lights."""
        now = info.simTime.Double()
        for name, lamp in self.lamps.items():
            block, lit = lamp.block_at(now - self.since[name])
            self.show(lamp, block.color, lit and self.running[name])

    def show(self, lamp: Lamp, color: GzColor | None, lit: bool) -> None:
        """Switch a light on, in a colour or its own, or off."""
        color = color or lamp.color
        if lamp.geom is None or color is None:
            return
        reach = lamp.range if lit else 0.0
        changed = False
        if lamp.geom.range != reach:
            lamp.geom.range, changed = reach, True
        if lit and tuple(lamp.geom.GetDiffuseColor()) != tuple(color):
            lamp.geom.SetDiffuseColor(color)
            changed = True
        if changed and self.publisher.HasConnections():
            message = msgs.Light(name=f"{self.model.GetScopedName()}::{lamp.name.replace('/', '::')}", range=reach)
            msgs.Set(message.diffuse, lamp.geom.GetDiffuseColor())
            self.publisher.Publish(message, here=False)

    def TurnOn(self, light: str) -> bool:
        """Let a light flash, by `link/light`; whether there is such a light."""
        return self._switch([light], True)

    def TurnOff(self, light: str) -> bool:
        """Switch a light off, by `link/light`; whether there is such a light."""
        return self._switch([light], False)

    def TurnOnAll(self) -> bool:
        """Let all lights flash."""
        return self._switch(list(self.lamps), True)

    def TurnOffAll(self) -> bool:
        """Switch all lights off."""
        return self._switch(list(self.lamps), False)

    def _switch(self, names: list[str], running: bool) -> bool:
        if not all(name in self.lamps for name in names):
            return False
        for name in names:
            self.running[name] = running
            self.since[name] = self.model.GetWorld().SimTime().Double()
        return True
