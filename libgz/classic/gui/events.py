"""Events of the client: `gui.Events.ConnectMainWindowReady(callback)` and its like return a connection to keep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from libgz.errors import nearest
from libgz.simulation.event import Connection, Event

__all__ = ["Events"]

# Name -> what the callback is given.
EVENTS = {
    "MainWindowReady": (),
    "KeyPress": ("key event",),
    "MoveMode": ("mode",),
    "ManipMode": ("mode",),
    "FullScreen": ("on",),
    "Follow": ("visual's name",),
    "WindowMode": ("mode",),
    "ViewMode": ("mode",),
    "SetUserCamera": ("name",),
    "CreateEntity": ("kind", "data"),
}

_events = {name: Event(name) for name in EVENTS}


class _Names(type):
    """`Connect<Name>`, `Disconnect<Name>`, and the event itself as `<name>`."""

    def __getattr__(cls, name: str) -> Any:
        for prefix in ("Connect", "Disconnect"):
            event = name.removeprefix(prefix)
            if name.startswith(prefix) and event in _events:
                return _events[event].Connect if prefix == "Connect" else _disconnect
        capital = name[:1].upper() + name[1:]
        if capital in _events:
            return _events[capital]
        raise AttributeError(f"there is no event {name!r}{nearest(name, [f'Connect{event}' for event in _events])}")

    def __dir__(cls) -> list[str]:
        return [*super().__dir__(), *(f"Connect{event}" for event in _events)]


_disconnect: Callable[[Connection], None] = lambda connection: connection.Disconnect()  # noqa: E731


class Events(metaclass=_Names):
    """The client's events. `Events.mainWindowReady()` and its like make one happen."""
