"""Events of Gazebo classic: `Events.ConnectWorldUpdateBegin(callback)` and its like return a connection to keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from libgz.classic.common import Time, UpdateInfo
from libgz.errors import nearest
from libgz.simulation.event import Connection, Event, WorldEvents, everywhere, owner

__all__ = ["Connection", "ConnectionPtr", "Event", "EventT", "Events"]

ConnectionPtr = Connection


def _update_info(world: str, sim_time: float, real_time: float) -> UpdateInfo:
    return UpdateInfo(world, Time(sim_time), Time(real_time))


WorldEvents.update_info = staticmethod(_update_info)
EventT = Event


def _here() -> WorldEvents:
    """The events of the world whose plugin is running; outside plugins those of all worlds."""
    by = owner.get()
    return by.events if by is not None and by.events is not None else everywhere


class _Names(type):
    """`Connect<Name>`, `Disconnect<Name>`, and the event itself as `<name>`."""

    def __getattr__(cls, name: str) -> Any:
        for prefix in ("Connect", "Disconnect"):
            event = name.removeprefix(prefix)
            if name.startswith(prefix) and event in everywhere:
                return (lambda connection: connection.Disconnect()) if prefix == "Disconnect" else _connector(event)
        capital = name[:1].upper() + name[1:]
        if capital in everywhere:
            return _here()[capital]
        known = [f"Connect{event}" for event in everywhere]
        raise AttributeError(f"there is no event {name!r}{nearest(name, known)}")

    def __dir__(cls) -> list[str]:
        return [*super().__dir__(), *(f"Connect{event}" for event in everywhere)]


def _connector(event: str) -> Callable[[Callable[..., object]], Connection]:
    return lambda callback: _here()[event].Connect(callback)


class Events(metaclass=_Names):
    """All events. A plugin hears those of its own world, other code those of every world.

    `Events.ConnectWorldUpdateBegin(callback)` calls `callback(info)`, or `callback()` if it takes no argument, first
    thing in every iteration; the facts of each event are in docs/plugins.md.
    """
