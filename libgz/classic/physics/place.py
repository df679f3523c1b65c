"""Places: where views stand in their world, as plain data for states."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.base.errors import StateError
from libgz.classic.physics.base import Entity
from libgz.classic.physics.collision import Collision
from libgz.classic.physics.link import Link

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["Place", "found_at", "place_if_there", "place_of"]

Place = tuple[str, int, int]  # id of the model or light, number of its link, number of the link's geom; -1 for none


def place_of(entity: Entity) -> Place:
    """Where a model, light, link or collision stands."""
    view: Any = entity
    if isinstance(entity, Collision):
        body = entity.geom.body
        return body.model.GetId(), body.model.bodies.index(body), body.geoms.index(entity.geom)
    if isinstance(entity, Link):
        return entity.model.core.GetId(), entity.model.core.bodies.index(entity.body), -1
    return view.core.GetId(), -1, -1


def place_if_there(entity: Entity) -> Place | None:
    """Where it stands; None if it is a link or collision that was removed from its model."""
    try:
        return place_of(entity)
    except ValueError:
        return None


def found_at(world: World, place: Place) -> Any:
    """The view at a place.

    Raises:
        StateError: there is nothing.
    """
    owner, link, geom = place
    for core in world.core.entities:
        if core.GetId() != owner:
            continue
        if link < 0:
            return world.view_of(core)
        if link < len(core.bodies) and geom < len(core.bodies[link].geoms):
            body = core.bodies[link]
            return world.link_of(body) if geom < 0 else world.collision_of(body.geoms[geom])
    raise StateError(f"this state has something of {owner!r} that is not in this world")
