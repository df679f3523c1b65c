"""MainWindow: stands for a client's window, with the overlays of its GUI plugins."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import NotFoundError, ParameterError, nearest
from libgz.classic import msgs
from libgz.classic.names import takes_names
from libgz.simulation.event import Event

if TYPE_CHECKING:
    from libgz.classic.rendering.scene import Scene
    from libgz.classic.rendering.user_camera import UserCamera
    from libgz.classic.transport import Publisher

__all__ = ["GUI", "Desktop", "MainWindow"]

PATIENCE = 1.0  # [s] for the server to listen


@takes_names
class GUI:
    """A plugin's overlay in the client: a rectangle with a text and buttons, shown as a panel of the client's page.

    Images and plots are an addition to Gazebo classic's API, in which plugins paint them with Qt.

    Attributes:
        name: the plugin's.
        position: of its upper left corner [px].
        size: width and height [px].
        text: shown in it.
        images: by label, each of shape (height, width, 3), red, green, blue from 0 to 255.
        plots: by title, values for the horizontal axis, and lines by their labels.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.position, self.size = (0, 0), (100, 30)
        self.text = ""
        self.visible = True
        self.images: dict[str, NDArray[np.uint8]] = {}
        self.plots: dict[str, tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]] = {}
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

    def SetImage(self, label: str, image: ArrayLike | None) -> None:
        """Show an image, or another one in its place; None removes it. An addition to Gazebo classic's API.

        Args:
            label: above it.
            image: shape (height, width) or (height, width, 3), from 0 to 255.

        Raises:
            ParameterError: it has another shape, or no pixels.
        """
        if image is None:
            self.images.pop(label, None)
            return
        pixels = np.clip(np.asarray(image), 0, 255).astype(np.uint8)
        if pixels.ndim == 2:
            pixels = np.repeat(pixels[:, :, None], 3, axis=2)
        if pixels.ndim != 3 or pixels.shape[2] != 3 or not pixels.size:
            shape = np.shape(image)
            raise ParameterError(f"image {label!r} has shape {shape}; it must be (height, width) or (height, width, 3)")
        self.images[label] = pixels

    def SetPlot(self, title: str, x: ArrayLike | None, lines: Mapping[str, ArrayLike] | None = None) -> None:
        """Show a plot, or another one in its place; None for `x` removes it. An addition to Gazebo classic's API.

        Args:
            title: above it.
            x: values of the horizontal axis, shape (n,), growing.
            lines: by label, values of the vertical axis, shape (n,).

        Raises:
            ParameterError: the shapes do not match, or there is no line.
        """
        if x is None:
            self.plots.pop(title, None)
            return
        values = np.array(x, dtype=np.float64)
        found = {label: np.array(line, dtype=np.float64) for label, line in (lines or {}).items()}
        if not found or values.ndim != 1 or any(line.shape != values.shape for line in found.values()):
            shapes = ", ".join(f"{label!r} {line.shape}" for label, line in found.items())
            raise ParameterError(
                f"plot {title!r} needs lines of shape {values.shape}, as x has; it got {shapes or 'none'}"
            )
        self.plots[title] = values, found

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


class Desktop(Protocol):
    """A window on the user's screen."""

    def show_full_screen(self, on: bool) -> None:
        """Let it fill the screen, or not."""

    def show_left_pane(self, on: bool) -> None:
        """Show or hide what plugins have added to its left column."""

    def turn(self, seconds: float) -> None:
        """Let it handle events for a time [s]."""

    def close(self) -> None:
        """Close it."""


@takes_names
class MainWindow:
    """The client's window, as plugins use it.

    Attributes:
        title: of the window.
        scene: the shown scene.
        camera: the user's camera.
        places: the overlays of the plugins, by name.
        open: until it is closed.
        frame: updates what it shows.
        desktop: its part on the user's screen, once a plugin has widgets of its own.
    """

    def __init__(self, scene: Scene, camera: UserCamera, controls: Publisher) -> None:
        self.title = "Gazebo"
        self._controls = controls
        self.scene, self.camera = scene, camera
        self.places: dict[str, GUI] = {}
        self.open = True
        self.frame: Callable[[], object] = lambda: None
        self.desktop: Desktop | None = None

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

    def Play(self) -> None:
        """Let the server's world run."""
        self._control(msgs.WorldControl(pause=False))

    def Pause(self) -> None:
        """Pause the server's world."""
        self._control(msgs.WorldControl(pause=True))

    def _control(self, message: msgs.WorldControl) -> None:
        self._controls.WaitForConnection(PATIENCE)  # Gazebo's publishers keep a first message until somebody listens
        self._controls.Publish(message)

    def AddPlace(self, name: str) -> GUI:
        """A new overlay for a plugin."""
        self.places[name] = GUI(name)
        return self.places[name]

    def close(self) -> None:
        """End the client, after this frame."""
        self.open = False
