"""Events of the client: `gui.Events.ConnectMainWindowReady(callback)` and its like return a connection to keep."""

from __future__ import annotations

from libgz.classic.event import EventNames
from libgz.simulation.event import Event

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
    "EditModel": ("model's name",),
    "LeftPaneVisibility": ("on",),
    "ShowToolbars": ("on",),
    "FPS": (),
    "Orbit": (),
}

_events = {name: Event(name) for name in EVENTS}


class Events(metaclass=EventNames):
    """The client's events; calling one, such as `Events.mainWindowReady()`, signals it."""

    @classmethod
    def _events(cls) -> dict[str, Event]:
        return _events
