"""What the viewer shows and commands, as protocols: a running server satisfies them, and so can a recorded run."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.transport.observer import ObservedState

__all__ = ["Controls", "Overlay", "Source"]


class Source(Protocol):
    """Where scene and states come from; `libgz.Observer` is one. docs/observer.md describes the scene."""

    @property
    def alive(self) -> bool:
        """Whether new states are to be expected; after that the viewer calls `reconnect`."""

    @property
    def scene(self) -> dict[str, Any]:
        """The scene of the present state; its ``revision`` is that of the states which belong to it."""

    def state(self) -> ObservedState:
        """The present state.

        Raises:
            ServerGoneError: there are no more.
        """

    def data(self, reference: dict[str, Any]) -> dict[str, NDArray[Any]]:
        """The arrays that the scene refers to.

        Raises:
            NotFoundError: they were removed.
        """

    def reconnect(self, timeout: float = 0.0) -> None:
        """Begin again with the next run.

        Raises:
            ServerGoneError: there is none within the timeout [s].
        """


class Controls(Protocol):
    """What users of the viewer can do.

    Attributes:
        abilities: names of what works: pause, step, reset, speed, rewind, seek, move, delete, insert, write, publish,
            describe, contacts, interfaces, readings, problems and those of docs/view.md.
    """

    @property
    def abilities(self) -> frozenset[str]:
        """The names of the requests that are answered."""

    def ask(self, verb: str, argument: str = "-", **content: Any) -> Any:
        """Do one of `abilities`; the answer is plain data.

        Raises:
            GazeboError: it was refused.
        """

    def interface(self, kind: str, id: str) -> Any:
        """An open interface.

        Raises:
            GazeboError: there is none.
        """

    def reconnect(self) -> None:
        """Forget all that belongs to the run before."""


class Overlay(Protocol):
    """What a GUI plugin shows: `libgz.classic.gui.GUI` is one."""

    text: str
    visible: bool
    images: dict[str, NDArray[np.uint8]]
    plots: dict[str, tuple[NDArray[np.float64], dict[str, NDArray[np.float64]]]]

    def Buttons(self) -> list[str]:
        """The labels of its buttons."""

    def Press(self, label: str) -> None:
        """Press a button."""
