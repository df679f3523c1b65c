"""Events of the client: `gui.Events.ConnectMainWindowReady(callback)` and its like return a connection to keep."""

from __future__ import annotations

import logging
from collections.abc import Callable

from libgz.classic.event import EventNames
from libgz.simulation.event import Connection, Event, owner

__all__ = ["Events"]

log = logging.getLogger("libgz.classic")

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
    "ModelUpdate": ("msgs.Model",),
    "LightUpdate": ("msgs.Light",),
    "AlignMode": ("axis", "configuration", "target", "preview", "inverted"),
    "InputStepSize": ("steps",),
    "ScaleEntity": ("name", "scale"),
    "MoveEntity": ("name", "pose", "on the plane"),
}
SIGNALLED = ("MainWindowReady", "KeyPress", "ModelUpdate", "LightUpdate")  # by the client


class _OfWindow(Event):
    """An event that Gazebo's toolbars, menus and editors signal, and here only plugins."""

    _said = False

    def Connect(self, callback: Callable[..., object]) -> Connection:
        """Call `callback` at each signal, as long as the connection is kept."""
        if not self._said and owner.get() is not None:
            self._said = True
            log.warning(
                "gui::Events::Connect%s: only plugins signal this event here; in Gazebo the window does, which libgz "
                "does not have (reported once)",
                self.name,
            )
        return super().Connect(callback)


_events = {name: Event(name) if name in SIGNALLED else _OfWindow(name) for name in EVENTS}


class Events(metaclass=EventNames):
    """The client's events; calling one, such as `Events.mainWindowReady()`, signals it."""

    @classmethod
    def _events(cls) -> dict[str, Event]:
        return _events
