"""The worlds of Gazebo classic that run in this process, by name."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

from libgz.base.errors import NotFoundError
from libgz.classic.names import takes_names
from libgz.ode.types import ContactRule
from libgz.simulation.event import owner
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.world import World

__all__ = [
    "getUniqueId",
    "get_world",
    "has_world",
    "own_world",
    "pause_world",
    "pause_worlds",
    "stop_world",
    "stop_worlds",
    "worlds",
    "worlds_running",
]

_numbers = itertools.count(1)


def _cores(name: str = "") -> list[CoreWorld]:
    """The SDF worlds of this name that run in this process, oldest first; without a name, all."""
    found = (core for core in CoreWorld.all_running() if not name or core.name == name)
    return [core for core in found if core.engine.contact_rule is ContactRule.CLASSIC]


def _view(core: CoreWorld) -> World:
    """The view on a world. One that is there already needs no lock: its world may be waiting for the caller's."""
    if core.facade is None:
        core.attach_era()
    found: World = core.facade
    return found


def worlds() -> list[World]:
    """All SDF worlds that run in this process, oldest first."""
    return [*map(_view, _cores())]


@takes_names
def has_world(name: str = "") -> bool:
    """Whether there is a world of this name; without a name, whether there is any."""
    return bool(_cores(name))


@takes_names
def get_world(name: str = "") -> World:
    """A world by name; without one, the world of the plugin that is running, or the first world.

    Raises:
        NotFoundError: there is none.
    """
    found = _cores(name)
    if not found:
        raise NotFoundError(f"Unable to find world by name in physics::get_world({name})")
    own = _own_core()
    return _view(own if own is not None and own in found else found[0])


def own_world() -> World | None:
    """The world of the plugin that is running; None outside plugins, and in System plugins."""
    own = _own_core()
    return _view(own) if own is not None else None


def _own_core() -> CoreWorld | None:
    by = owner.get()
    return next((core for core in _cores() if by is not None and by.events is core.events), None)


def pause_world(world: World, pause: bool) -> None:
    """Pause a world, or resume it."""
    world.SetPaused(pause)


def pause_worlds(pause: bool) -> None:
    """Pause all worlds, or resume them."""
    for world in worlds():
        world.SetPaused(pause)


def stop_world(world: World) -> None:
    """End a world's Run, or the loop of gzserver."""
    world.Stop()


def stop_worlds() -> None:
    """End the Run of all worlds."""
    for world in worlds():
        world.Stop()


def worlds_running() -> bool:
    """Whether a world was not stopped."""
    return any(world.Running() for world in worlds())


def getUniqueId() -> int:
    """A number that no other call in this process returns."""
    return next(_numbers)
