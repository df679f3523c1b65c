"""MainWindow: stands for a client's window, with the overlays of its GUI plugins."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from libgz.errors import NotFoundError, nearest
from libgz.simulation.event import Event

if TYPE_CHECKING:
    from libgz.classic.rendering.scene import Scene
    from libgz.classic.rendering.user_camera import UserCamera

__all__ = ["GUI", "MainWindow"]


class GUI:
    """A plugin's overlay in the client: a rectangle with a text and buttons, for programs that show them.

    Attributes:
        name: the plugin's.
        position: of its upper left corner [px].
        size: width and height [px].
        text: shown in it.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.position, self.size = (0, 0), (100, 30)
        self.text = ""
        self.visible = True
        self._buttons: dict[str, Event] = {}
        self._kept: list[object] = []

    def Move(self, x: int, y: int) -> None:
        """Move its upper left corner [px]."""
        self.position = (int(x), int(y))

    def Resize(self, width: int, height: int) -> None:
        """Set its size [px]."""
        self.size = (int(width), int(height))

    move, resize = Move, Resize

    def SetText(self, text: str) -> None:
        """Set the text."""
        self.text = str(text)

    def SetVisible(self, visible: bool) -> None:
        """Show or hide it."""
        self.visible = bool(visible)

    def AddButton(self, label: str, callback: Callable[[], object]) -> None:
        """Add a button."""
        self._kept.append(self._buttons.setdefault(label, Event(f"button {label}")).Connect(callback))

    def Buttons(self) -> list[str]:
        """The labels of its buttons."""
        return list(self._buttons)

    def Press(self, label: str) -> None:
        """Press a button.

        Raises:
            NotFoundError: there is no such button.
        """
        if label not in self._buttons:
            raise NotFoundError(f"{self.name!r} has no button {label!r}{nearest(label, self._buttons)}")
        self._buttons[label]()


class MainWindow:
    """The client's window, as plugins use it.

    Attributes:
        title: of the window.
        scene: the shown scene.
        camera: the user's camera.
        places: the overlays of the plugins, by name.
        open: until it is closed.
    """

    def __init__(self, scene: Scene, camera: UserCamera) -> None:
        self.title = "Gazebo"
        self.scene, self.camera = scene, camera
        self.places: dict[str, GUI] = {}
        self.open = True

    def setWindowTitle(self, title: str) -> None:
        """Set the title."""
        self.title = title

    def width(self) -> int:
        """[px]."""
        return self.camera.ImageWidth()

    def height(self) -> int:
        """[px]."""
        return self.camera.ImageHeight()

    def resize(self, width: int, height: int) -> None:
        """Set the size of the image [px]."""
        self.camera.Resize(width, height)

    def AddPlace(self, name: str) -> GUI:
        """A new overlay for a plugin."""
        self.places[name] = GUI(name)
        return self.places[name]

    def close(self) -> None:
        """End the client, after this frame."""
        self.open = False
