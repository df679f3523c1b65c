"""Space: a group of geoms that never touch each other.

Each model has a space of its own inside a hash space: geoms of one model never touch, and spaces of fixed models ignore
each other.
"""

from __future__ import annotations

from typing import Protocol

from libgz.base.errors import ClosedError
from libgz.ode.lib import ode
from libgz.physics.lock import WorldLock, built, exclusive

__all__ = ["Space"]

FIXED_COLLIDE = 1  # GZ_FIXED_COLLIDE: ground, terrain, roads: they never collide with each other
LASER_COLLIDE = 2  # GZ_LASER_COLLIDE: rays
ALL_COLLIDE = 0xFFFFFFFF


class SpaceOwner(Protocol):
    """The part of an `Engine` that its spaces use."""

    lock: WorldLock

    @property
    def top(self) -> Space:
        """The space of all geoms."""

    @property
    def spaces(self) -> dict[Space, None]:
        """All open spaces below the top."""


class Space:
    """A simple ODE space inside the engine's top space. Geoms of one space never touch each other.

    Args:
        engine: where.
        handle: an existing ODE space, which its owner destroys; without one, a new space is made.
        parent: a space that this one is a part of and closes with: its parts are skipped together in collision
            detection.
    """

    @built
    def __init__(self, engine: SpaceOwner, handle: int | None = None, parent: Space | None = None) -> None:
        self.engine = engine
        self._id = handle
        self.parent = parent or (engine.top if handle is None else None)
        self._parts: list[Space] = []
        if handle is None:
            self._id = ode().dSimpleSpaceCreate((parent or engine.top).id)
            engine.spaces[self] = None
        if parent is not None:
            parent._parts.append(self)

    @property
    def closed(self) -> bool:
        """Whether it was closed."""
        return self._id is None

    @property
    def id(self) -> int:
        """The ODE handle.

        Raises:
            ClosedError: the space was closed.
        """
        if self._id is None:
            raise ClosedError("this space was closed")
        return self._id

    def set_fixed(self) -> None:
        """Mark as ground: no contacts with other fixed spaces."""
        self.set_bits(FIXED_COLLIDE, ALL_COLLIDE & ~FIXED_COLLIDE)

    @exclusive
    def set_bits(self, category: int, collide: int) -> None:
        """Set the category of this space, and the categories that it collides with."""
        ode().dGeomSetCategoryBits(self.id, category)
        ode().dGeomSetCollideBits(self.id, collide)

    @exclusive
    def close(self) -> None:
        """Destroy the space and its parts; its geoms are closed by their bodies."""
        for part in self._parts:
            part.close()
        if self._id is not None:
            ode().dSpaceSetCleanup(self._id, 0)
            ode().dSpaceDestroy(self._id)
            self._id = None
            self.engine.spaces.pop(self, None)
