"""LocalSource: the scene and the states of a world in this process, for a viewer."""

from __future__ import annotations

import dataclasses
import json
import time
from typing import Any

from numpy.typing import NDArray

from libgz.base.errors import ServerGoneError
from libgz.simulation.world import World
from libgz.transport.observer import ObservedState, arrays_of, state_of

__all__ = ["LocalSource"]

IDLE = 0.5  # [s] after its last step a world counts as paused


class LocalSource:
    """A source that shows a world between its steps.

    Args:
        world: it is initialized.

    Raises:
        ClosedError: it is not, or not any more.
    """

    def __init__(self, world: World) -> None:
        self.world = world
        self._tables = world.publish()
        self._scene: tuple[bytes, dict[str, Any]] = (b"", {})
        self._last: ObservedState | None = None
        self._stepped = 0.0  # when the last step was seen [s]

    @property
    def alive(self) -> bool:
        """Whether the world is open."""
        return self.world.running

    @property
    def scene(self) -> dict[str, Any]:
        """The scene of the present state."""
        text = self._tables.scene
        if text is not self._scene[0]:
            self._scene = text, json.loads(text)
        return self._scene[1]

    def state(self) -> ObservedState:
        """The present state. A world that nobody steps is shown as a paused one.

        Raises:
            ServerGoneError: the world is closed.
        """
        with self.world.lock:
            if not self.world.running:
                raise ServerGoneError("the world is closed")
            state = state_of(bytes(self.world.publish().memory))  # what was set since the last step is in it
        now, last = time.monotonic(), self._last
        if last is not None and (state.steps, state.pause_time) != (last.steps, last.pause_time):
            self._stepped = now
        self._last = state
        return dataclasses.replace(state, paused=state.paused or now > self._stepped + IDLE)

    def data(self, reference: dict[str, Any]) -> dict[str, NDArray[Any]]:
        """The arrays that the scene refers to.

        Raises:
            NotFoundError: they were removed.
        """
        return arrays_of(self._tables.content(reference["file"]), reference)

    def reconnect(self, timeout: float = 0.0) -> None:
        """There is no next run.

        Raises:
            ServerGoneError: always.
        """
        raise ServerGoneError("the world is closed")
