"""SdfLight: a `<light>` of a world."""

from __future__ import annotations

from typing import Any

from libgz.base.errors import Diagnostics
from libgz.base.geometry import GzPose
from libgz.physics.body import Body
from libgz.physics.geoms import LightGeom
from libgz.sdf.element import Element
from libgz.sdfworld.visual import set_light
from libgz.simulation.description import Store
from libgz.simulation.entity import Entity
from libgz.simulation.world import World

__all__ = ["SdfLight"]


class SdfLight(Entity):
    """A light that stands in a world: a dummy body with a light geom.

    Args:
        world: where.
        element: the `<light>`.
        diagnostics: takes the warnings.
    """

    STATE = ()  # all that it has is in the engine's state

    is_model = False

    def __init__(self, world: World, element: Element, diagnostics: Diagnostics) -> None:
        super().__init__(world)
        self.sdf = element
        self.SetName("light")
        self.SetId(element.Get(str, "name"))
        body = Body(world, dummy=True)
        self.AddBody(body, True)
        body.SetPose(element.Get(GzPose, "pose"))
        self.light = LightGeom(body, None)
        set_light(self.light, element, diagnostics.warn)

    @property
    def cast_shadows(self) -> bool:
        """Whether bodies cast shadows in its light."""
        return self.light.cast_shadows

    def _entity_describe(self, store: Store) -> dict[str, Any]:
        """As of all entities, and whether it casts shadows."""
        return {**super()._entity_describe(store), "cast_shadows": self.cast_shadows}

    def _entity_place(self) -> str:
        """``file:line: <tag>: `` of its element, for messages."""
        return f"{self.sdf.where}: <{self.sdf.name}>: "
