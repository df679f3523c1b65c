"""Desktop: the window on the user's screen with the widgets of compiled GUI plugins.

Its native part is a shared object of its own, which is built with the library where Qt is installed.
"""

from __future__ import annotations

import ctypes
import logging
import os
from collections.abc import Callable
from ctypes import c_char_p, c_double, c_int, c_void_p, py_object
from pathlib import Path
from typing import Any

from libgz.base.errors import PluginError
from libgz.classic import gui

__all__ = ["Desktop", "desktop"]

log = logging.getLogger("libgz.plugin")

FUNCTIONS: dict[str, tuple[Any, list[Any]]] = {
    "open": (None, [c_char_p, c_int, c_int, py_object, py_object]),
    "add": (None, [c_void_p, c_void_p, py_object]),
    "show": (None, [c_void_p, c_void_p, c_int]),
    "full_screen": (None, [c_int]),
    "left_pane": (None, [c_int]),
    "turn": (c_int, [c_double]),
    "leave": (None, []),
    "close": (None, []),
}


def _platform() -> str:
    """The platform of Qt: the user's choice, else X11 if its server answers, else none, which is said."""
    chosen = os.environ.get("QT_QPA_PLATFORM")
    if chosen:
        return chosen
    if os.environ.get("DISPLAY"):
        try:
            xcb = ctypes.CDLL("libxcb.so.1")
        except OSError:
            pass
        else:
            xcb.xcb_connect.restype, xcb.xcb_connect.argtypes = c_void_p, [c_char_p, c_void_p]
            xcb.xcb_connection_has_error.argtypes = xcb.xcb_disconnect.argtypes = [c_void_p]
            connection = xcb.xcb_connect(None, None)
            answers = not xcb.xcb_connection_has_error(connection)
            xcb.xcb_disconnect(connection)
            if answers:
                return "xcb"
    log.warning("GUI plugins have widgets, and no display can be used: they run unseen, by Qt's platform offscreen")
    return "offscreen"


class Desktop:
    """The window, in the thread that makes it. GUI plugins must be made and deleted there.

    Args:
        library: the native part.
        window: the client's main window, whose size it has, and which is closed with it.

    Raises:
        PluginError: the native part cannot be loaded.
    """

    def __init__(self, library: Path, window: gui.MainWindow) -> None:
        self._window = window
        self._ended: list[Callable[[], None]] = []  # deletions, while no event of Qt is handled
        try:
            native = ctypes.PyDLL(str(library), mode=os.RTLD_NOW)
        except OSError as error:
            raise PluginError(f"error loading plugin: the part for widgets cannot be loaded: {error}") from None
        self._functions = {name: native[f"libgz_qt_{name}"] for name in FUNCTIONS}
        for name, (result, arguments) in FUNCTIONS.items():
            self._functions[name].restype, self._functions[name].argtypes = result, arguments
        self._call("open", _platform().encode(), window.width(), window.height(), self.failed, self._nested)

    def _call(self, name: str, *values: Any) -> Any:
        return self._functions[name](*values)

    def failed(self, error: BaseException) -> None:
        """An event of Qt failed that belongs to no plugin's widget."""
        log.error("an event of Qt failed: %s", error)

    def _nested(self) -> None:
        """A plugin waits in an event of Qt, as for a dialog: the client runs on."""
        if self._window.open:
            self._window.frame()
        if not self._window.open:
            self._call("leave")

    def add(self, plugin: int, widget_of: int, failed: Callable[[BaseException], object]) -> None:
        """Put the widget of a plugin into the window.

        Args:
            plugin: the C++ object.
            widget_of: the function that gives its widget.
            failed: is called with what it throws in an event of Qt.
        """
        self._call("add", plugin, widget_of, failed)

    def show(self, plugin: int, widget_of: int, shown: bool = True) -> None:
        """Show or hide the widget of a plugin."""
        self._call("show", plugin, widget_of, shown)

    def show_full_screen(self, on: bool) -> None:
        """Let it fill the screen, or not."""
        self._call("full_screen", on)

    def show_left_pane(self, on: bool) -> None:
        """Show or hide what plugins have added to its left column."""
        self._call("left_pane", on)

    def turn(self, seconds: float) -> None:
        """Let Qt handle events for a time [s]."""
        if not self._call("turn", seconds):
            self._window.close()
        self._delete()

    def delete(self, deletion: Callable[[], None]) -> None:
        """Delete a plugin in the window's thread, after its present event."""
        self._ended.append(deletion)

    def _delete(self) -> None:
        while self._ended:
            self._ended.pop()()

    def close(self) -> None:
        """Close the window."""
        self._delete()
        self._call("close")
        self._window.desktop = None


def desktop(library: Path) -> Desktop:
    """The client's window on the screen; made when it is first asked for.

    Args:
        library: the native part.

    Raises:
        PluginError: there is no client, or no native part.
    """
    window = gui.get_main_window()
    if window is None:
        raise PluginError("its widgets need a client: gzclient")
    found: Any = window.desktop
    if found is None:
        if not library.is_file():
            raise PluginError(
                "it has widgets, which libgz shows only after: apt-get install qtbase5-dev; "
                "libgz config --install-classic"
            )
        found = window.desktop = Desktop(library, window)
    made: Desktop = found
    return made
