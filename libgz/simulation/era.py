"""Era: what differs between the worlds of the two generations of Gazebo."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from libgz.base.errors import StateError

if TYPE_CHECKING:
    from libgz.base.geometry import GzPose
    from libgz.simulation.world import World

__all__ = ["Era"]


class Era:
    """How a world counts time, starts, is reset and saved. A world has one, chosen by what loads its file.

    Attributes:
        name: of the era, for observers.
        counts_at_start: whether sim time grows when a step begins; otherwise it grows when the entities are updated.
    """

    name: ClassVar[str] = "none"
    counts_at_start = False
    digest = b""  # of the text of the world's file: states are of worlds with one file

    def start_view(self, world: World) -> GzPose | None:
        """Where the file wants a user's view to begin [m]: it looks along x, with z up; None if it says nothing."""
        return None

    def start(self, world: World) -> None:
        """Prepare the first step; all entities are initialized."""

    def reset(self, world: World) -> None:
        """Return the world to its beginning, between two steps."""
        world.return_to_start()

    def press_reset(self, world: World) -> None:
        """Do what the button `reset` of interface `sim` means, between two steps: return the models to their poses."""
        world.ResetModelPoses()

    def load_into(self, world: World) -> None:
        """Load the file of this era's world into another, new world.

        Raises:
            StateError: there is no file.
        """
        raise StateError("this world was not loaded from a file, so there is nothing to make a second one from")

    @property
    def file_name(self) -> str:
        """The name of the world's file, without its folder; empty without a file."""
        return ""

    @property
    def text(self) -> bytes:
        """The text of the world's file, with what was edited since it was read; empty without a file."""
        return b""

    def set_text(self, text: bytes) -> None:
        """Take another text as that of the world's file; what is in the world stays until a state is restored.

        Raises:
            WorldFileError: it has errors.
        """
        raise StateError("this world was not loaded from a file, so there is no text to edit")

    def saved_text(self, world: World) -> tuple[str | None, bytes, bytes]:
        """What `save` of the whole world would write: the file's name or None, its text now, and its text then.

        Raises:
            GazeboError: there is no file, or its text cannot be changed.
        """
        raise StateError("this world was not loaded from a file, so there is nothing to write")

    def save(self, world: World, whole: bool = False) -> int:
        """Write the present poses to the world's file; 0, or -1 if there is none or it cannot be written."""
        return -1
