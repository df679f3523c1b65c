"""Era: what differs between the worlds of the two generations of Gazebo."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from libgz.simulation.world import World

__all__ = ["Era"]


class Era:
    """How a world counts time, starts, is reset and saved. A world has one, chosen by what loads its file.

    Attributes:
        counts_at_start: whether sim time grows when a step begins; otherwise it grows when the entities are updated.
    """

    counts_at_start = False

    def start(self, world: World) -> None:
        """Prepare the first step; all entities are initialized."""

    def reset(self, world: World) -> None:
        """Return the world to its beginning, between two steps."""
        world.ResetModelPoses()

    def save(self, world: World) -> int:
        """Write the present poses to the world's file; 0, or -1 if there is none or it cannot be written."""
        return -1
