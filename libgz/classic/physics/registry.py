"""The worlds of this process, by name."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING
from weakref import WeakSet

from libgz.errors import NotFoundError
from libgz.ode.types import ContactRule
from libgz.simulation.event import owner
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = ["enter", "get_world", "has_world", "leave", "live_worlds", "own_world", "worlds"]

_worlds: WeakSet[World] = WeakSet()


def enter(world: World) -> None:
    """Note a world's view."""
    _worlds.add(world)


def leave(world: World) -> None:
    """A world ends."""
    _worlds.discard(world)


def live_worlds() -> list[World]:
    """The views that there are already."""
    return sorted(_worlds, key=lambda world: world.GetId())


def worlds() -> list[World]:
    """All SDF worlds that run in this process, oldest first."""
    for core in CoreWorld.all_running():
        if core.engine.contact_rule is ContactRule.CLASSIC:
            importlib.import_module("libgz.classic.server").attach(core)  # by name: it stands on the views
    return live_worlds()


def has_world(name: str = "") -> bool:
    """Whether there is a world of this name, or any."""
    return any(not name or world.Name() == name for world in worlds())


def get_world(name: str = "") -> World:
    """A world by name; without one, that of the plugin that is running, or the first.

    Raises:
        NotFoundError: there is none.
    """
    own = own_world()
    found = [world for world in worlds() if not name or world.Name() == name]
    if not found:
        raise NotFoundError(f"Unable to find world by name in physics::get_world({name})")
    return own if own is not None and own in found else found[0]


def own_world() -> World | None:
    """The world of the plugin that is running; None outside plugins, and in those of all worlds."""
    by = owner.get()
    return next((world for world in worlds() if by is not None and by.events is world.core.events), None)
