"""Gazebo classic's `gui` names: the client for GUI plugins, which has no window of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from libgz.classic.api import without
from libgz.classic.gui.events import Events
from libgz.classic.gui.window import GUI, MainWindow

if TYPE_CHECKING:
    from libgz.classic.rendering.user_camera import UserCamera

__all__ = [
    "GUI",
    "Events",
    "MainWindow",
    "get_active_camera",
    "get_main_window",
    "get_world",
    "set_active_camera",
    "set_main_window",
]

__getattr__ = without(__name__)

_window: MainWindow | None = None


def get_main_window() -> MainWindow | Any:
    """The client's main window; None where there is no client."""
    return _window


def set_main_window(window: MainWindow | None) -> None:
    """Set the main window; the client does that."""
    global _window
    _window = window


def get_active_camera() -> UserCamera | Any:
    """The user's camera; None where there is no client."""
    return _window.camera if _window is not None else None


def set_active_camera(camera: UserCamera) -> None:
    """Set the user's camera."""
    if _window is not None:
        _window.camera = camera


def get_world() -> str:
    """The name of the shown world; empty where there is no client."""
    return _window.scene.Name() if _window is not None else ""
