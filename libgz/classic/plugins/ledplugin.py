"""LedPlugin: lights and visuals that blink together."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from libgz.base.errors import NotFoundError, nearest
from libgz.base.geometry import GzColor
from libgz.classic.plugin import GZ_REGISTER_MODEL_PLUGIN
from libgz.classic.plugins._flash_light import FlashLightPlugin

if TYPE_CHECKING:
    from libgz.classic.physics import Model
    from libgz.classic.plugins._flash_light import Lamp
    from libgz.physics.geom import Geom
    from libgz.physics.geoms import LightGeom
    from libgz.sdf.element import Element

DARK = GzColor(0.0, 0.0, 0.0)


class LedPlugin(FlashLightPlugin):
    """Lets lights blink, and with each the visual of the same name: it glows while the light is on.

    The visual glows in the colour of the block; without one, in its own emissive colour, or else its diffuse one. There
    may be a visual without a light. Elements are those of FlashLightPlugin.
    """

    STATE: ClassVar[tuple[str, ...]] = ()

    def Load(self, model: Model, sdf: Element) -> None:
        """Find lights and visuals.

        Raises:
            NotFoundError: there is neither a light nor a visual of a name.
            ParameterError: a time is negative.
        """
        self.bulbs: dict[str, list[tuple[Geom, GzColor]]] = {}  # each with the colour that it glows in
        super().Load(model, sdf)

    def _find(self, element: Element, name: str) -> LightGeom | None:
        self.bulbs[name] = [(geom, self._glow(geom)) for geom in self._visuals(name)]
        try:
            return super()._find(element, name)
        except NotFoundError:
            if self.bulbs[name]:
                return None
            links = self.model.family_links()
            known = [f"{link.GetName()}/{link.model.geom_name(geom)}" for link in links for geom in link.visuals()]
            raise NotFoundError(
                f"{element.where}: <id> is {name!r}; model {self.model.GetName()!r} has neither a light nor a "
                f"visual of this name{nearest(name, known)}"
            ) from None

    def _visuals(self, name: str) -> list[Geom]:
        link_name, _, visual = name.rpartition("/")
        links = (link for link in self.model.family_links() if link.GetName() == link_name)
        return [geom for link in links for geom in link.visuals() if link.model.geom_name(geom) == visual]

    @staticmethod
    def _glow(geom: Geom) -> GzColor:
        own = geom.appearance.emission
        return GzColor(*(own if any((own.r, own.g, own.b)) else geom.appearance.diffuse))

    def show(self, lamp: Lamp, color: GzColor | None, lit: bool) -> None:
        """Switch a light and its visuals on or off."""
        super().show(lamp, color, lit)
        for geom, own in self.bulbs[lamp.name]:
            glow = (color or own) if lit else DARK
            if tuple(geom.appearance.emission) != tuple(glow):
                geom.appearance.change(emission=glow)


GZ_REGISTER_MODEL_PLUGIN(LedPlugin)
