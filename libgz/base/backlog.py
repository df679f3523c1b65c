"""Backlog: what waits to be sent to all receivers, and its bound."""

from __future__ import annotations

import threading
from collections.abc import Sized
from typing import Protocol

__all__ = ["BACKLOG_BYTES", "Backlog", "Waiting"]

BACKLOG_BYTES = 64 << 20  # that wait for all receivers together
EASED = 0.75  # of that is left when something has to be discarded, so that it is not each time


class Waiting(Protocol):
    """A connection, as far as a backlog needs it."""

    @property
    def burden(self) -> float:
        """What of all connections the one with the most has to discard something: bytes that wait."""

    def discard(self) -> bool:
        """Discard the oldest message that may be lost, or, if there is none, all: the connection then ends.

        Returns:
            Whether there was anything.
        """


class Backlog:
    """Counts what waits, each frame once, though many connections may have it.

    Attributes:
        lock: Of the queues of all connections; to be held while calling any method.
        size: Bytes of all frames.
    """

    def __init__(self, limit: int = BACKLOG_BYTES) -> None:
        self.lock = threading.Lock()
        self.size = 0
        self._limit = limit
        self._frames: dict[int, int] = {}  # id of a frame -> queues that have it
        self._connections: set[Waiting] = set()

    def add(self, connection: Waiting, frame: Sized) -> None:
        """Count a frame that a connection now has; above the limit, those with the largest burden lose messages."""
        self._connections.add(connection)
        queues = self._frames.get(id(frame), 0)
        self._frames[id(frame)] = queues + 1
        if not queues:
            self.size += len(frame)
            if self.size > self._limit:
                self._shrink()

    def remove(self, frame: Sized) -> None:
        """Count a frame that a connection has no longer."""
        queues = self._frames[id(frame)] - 1
        if queues:
            self._frames[id(frame)] = queues
        else:
            del self._frames[id(frame)]
            self.size -= len(frame)

    def forget(self, connection: Waiting) -> None:
        """A connection has nothing that waits."""
        self._connections.discard(connection)

    def _shrink(self) -> None:
        while self.size > EASED * self._limit and self._connections:
            longest = max(self._connections, key=lambda one: one.burden)
            if not longest.discard():
                self._connections.discard(longest)
