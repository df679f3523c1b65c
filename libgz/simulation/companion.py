"""Companion: what goes along with a world and is built on it, such as the sensors and plugins of Gazebo classic."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from libgz.legacy.model import Model

__all__ = ["Companion"]


class Companion(Protocol):
    """Told by a world of all that matters to it."""

    def start(self) -> None:
        """All models are loaded and have made their interfaces."""

    def model_added(self, model: Model) -> None:
        """A model was built; while a world loads, others may still come."""

    def model_removed(self, model: Model) -> None:
        """A model was taken off; its bodies are still there."""

    def update(self) -> None:
        """Sim time has grown, models have been updated, physics comes next."""

    def step(self, paused: bool) -> None:
        """A step is over."""

    def reset(self) -> None:
        """Clock and models were put back."""

    def close(self) -> None:
        """The world ends; its models are still there."""
