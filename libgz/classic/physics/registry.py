"""The worlds of Gazebo classic that run in this process, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from libgz.errors import NotFoundError
from libgz.ode.types import ContactRule
from libgz.simulation.event import owner
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["get_world", "has_world", "own_world", "worlds"]


def worlds() -> list[World]:
    """All SDF worlds that run in this process, oldest first."""
    found = []
    for core in CoreWorld.all_running():
        if core.engine.contact_rule is ContactRule.CLASSIC:
            core.attach_era()
            found.append(core.facade)
    return found


def has_world(name: str = "") -> bool:
    """Whether there is a world of this name; without a name, whether there is any."""
    return any(not name or world.Name() == name for world in worlds())


def get_world(name: str = "") -> World:
    """A world by name; without one, the world of the plugin that is running, or the first world.

    Raises:
        NotFoundError: there is none.
    """
    own = own_world()
    found = [world for world in worlds() if not name or world.Name() == name]
    if not found:
        raise NotFoundError(f"Unable to find world by name in physics::get_world({name})")
    return own if own is not None and own in found else found[0]


def own_world() -> World | None:
    """The world of the plugin that is running; None outside plugins, and in System plugins."""
    by = owner.get()
    return next((world for world in worlds() if by is not None and by.events is world.core.events), None)
