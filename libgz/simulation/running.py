"""The running worlds of this process. Loads no engine, so that a program without worlds can ask for them, too."""

from __future__ import annotations

from typing import Protocol

from libgz.simulation.event import WorldEvents

__all__ = ["RunningWorld", "add_running", "remove_running", "running_worlds"]


class RunningWorld(Protocol):
    """The part of a world's interface that programs and plugins need to find it."""

    name: str
    events: WorldEvents

    @property
    def topic_space(self) -> str:
        """What `~` means in the names of its topics."""

    def attach_era(self) -> None:
        """Attach what the world's era offers on request, such as topics. Can be called twice."""


_running: list[RunningWorld] = []


def running_worlds() -> list[RunningWorld]:
    """Return the worlds between Initialize and Finalize, oldest first."""
    return list(_running)


def add_running(world: RunningWorld) -> None:
    """Add a world that was initialized."""
    _running.append(world)


def remove_running(world: RunningWorld) -> None:
    """Remove a world that was finalized."""
    _running.remove(world)
