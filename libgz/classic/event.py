"""Events of Gazebo classic: `Events.ConnectWorldUpdateBegin(callback)` returns a connection, which must be kept."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from libgz.base.errors import nearest
from libgz.classic.api import without
from libgz.classic.common import Time, UpdateInfo
from libgz.simulation.event import Connection, Event, WorldEvents, everywhere, owner

__all__ = ["Connection", "ConnectionPtr", "Event", "EventNames", "EventT", "Events"]

__getattr__ = without(__name__)

ConnectionPtr = Connection
EventT = Event


def _update_info(world: str, sim_time: float, real_time: float) -> UpdateInfo:
    return UpdateInfo(world, Time(sim_time), Time(real_time))


WorldEvents.update_info = staticmethod(_update_info)


def _disconnect(connection: Connection) -> None:
    connection.Disconnect()


class EventNames(type):
    """Metaclass of `Events`: `Connect<Name>(callback)`, `Disconnect<Name>(connection)`, and the event as `<name>`.

    The class gives its present events, by capital name, in a class method `_events`.
    """

    _events: Callable[[], Mapping[str, Event]]

    def __getattr__(cls, name: str) -> Any:
        events = cls._events()
        if name.startswith("Connect") and name.removeprefix("Connect") in events:
            return cls._connector(name.removeprefix("Connect"))
        if name.startswith("Disconnect") and name.removeprefix("Disconnect") in events:
            return _disconnect
        capital = name[:1].upper() + name[1:]
        if capital in events:
            return events[capital]
        raise AttributeError(f"there is no event {name!r}{nearest(name, [f'Connect{event}' for event in events])}")

    def _connector(cls, name: str) -> Callable[[Callable[..., object]], Connection]:
        """The function that connects to an event: the present one at the time of its call."""
        return lambda callback: cls._events()[name].Connect(callback)

    def __dir__(cls) -> list[str]:
        return [*super().__dir__(), *(f"Connect{event}" for event in cls._events())]


class Events(metaclass=EventNames):
    """All events of Gazebo. A plugin connects to those of its own world, other code to those of all worlds.

    `Events.ConnectWorldUpdateBegin(callback)` calls `callback(info)`, or `callback()` if it takes no argument, at the
    beginning of every iteration; docs/plugins.md lists all events and their arguments.
    """

    @classmethod
    def _events(cls) -> WorldEvents:
        """The events of the world whose plugin is running; outside plugins those of all worlds."""
        by = owner.get()
        return by.events if by is not None and by.events is not None else everywhere
