"""Contacts of the last step."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.classic.common import Time
from libgz.classic.math import Vector3d
from libgz.errors import NotFoundError

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.contact_topics import ContactFilters
    from libgz.classic.physics.world import World

__all__ = ["Contact", "ContactManager", "JointWrench", "read_contacts"]


@dataclass
class JointWrench:
    """Forces [N] and torques [N m] on two bodies."""

    body1Force: Vector3d = field(default_factory=Vector3d)
    body1Torque: Vector3d = field(default_factory=Vector3d)
    body2Force: Vector3d = field(default_factory=Vector3d)
    body2Torque: Vector3d = field(default_factory=Vector3d)


@dataclass
class Contact:
    """All points at which two collisions touch: global positions [m] and normals, depths [m], wrenches on the links."""

    world: World
    collision1: Collision
    collision2: Collision
    time: Time
    positions: list[Vector3d] = field(default_factory=list)
    normals: list[Vector3d] = field(default_factory=list)
    depths: list[float] = field(default_factory=list)
    wrench: list[JointWrench] = field(default_factory=list)

    @property
    def count(self) -> int:
        """How many points there are."""
        return len(self.positions)

    @property
    def names(self) -> tuple[str, str]:
        """Scoped names of both collisions."""
        return self.collision1.GetScopedName(), self.collision2.GetScopedName()


class ContactManager:
    """The contacts of the last step; the first question begins their recording."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._read_at = (-1, -1)
        self._contacts: list[Contact] = []
        self._filters: ContactFilters | None = None
        self._never_drop = False
        self._wanted = False
        self._holders: set[object] = set()

    def want(self) -> None:
        """Begin to record contacts, so that the next step's are there."""
        self._wanted = True
        self._world.core.engine.record_contacts = True

    def hold(self, who: object) -> None:
        """Record contacts until `who` releases them."""
        self._holders.add(who)
        self._world.core.engine.record_contacts = True

    def release(self, who: object) -> None:
        """`who` needs no contacts any more; they are recorded as long as somebody else does."""
        self._holders.discard(who)
        if not (self._wanted or self._holders):
            self._world.core.engine.record_contacts = False

    def SetNeverDropContacts(self, neverDrop: bool) -> None:
        """Record contacts even if nobody has asked yet."""
        self._never_drop = bool(neverDrop)
        if neverDrop:
            self.want()

    def NeverDropContacts(self) -> bool:
        """Whether contacts are recorded even if nobody has asked."""
        return self._never_drop

    def GetContactCount(self) -> int:
        """How many pairs of collisions touch."""
        return len(self.GetContacts())

    def GetContact(self, index: int) -> Contact | None:
        """A contact by number; None if there is none."""
        found = self.GetContacts()
        return found[index] if 0 <= index < len(found) else None

    def GetContacts(self) -> list[Contact]:
        """The contacts of the last step, a pair of collisions each."""
        self.want()
        return self.read()

    def read(self) -> list[Contact]:
        """The same, where somebody else has them recorded."""
        engine = self._world.core.engine
        now = engine.steps, engine.collisions
        if self._read_at != now:
            self._read_at = now
            self._contacts = read_contacts(self._world, engine.contacts)
        return self._contacts

    # Filters -----------------------------------------------------------------------------------------------------

    def CreateFilter(self, name: str, collisions: str | Iterable[str]) -> str:
        """Let a topic tell in each iteration what some collisions touch, by their scoped names; the topic's name.

        Raises:
            ParameterError: there is a filter of this name, or no collision.
        """
        if self._filters is None:
            from libgz.classic.physics.contact_topics import ContactFilters

            self._filters = ContactFilters(self, self._world)
        return self._filters.create(name, collisions)

    def RemoveFilter(self, name: str) -> None:
        """End such a topic.

        Raises:
            NotFoundError: there is no filter of this name.
        """
        if self._filters is None:
            raise NotFoundError(f"there is no contact filter {name!r}")
        self._filters.remove(name)

    def HasFilter(self, name: str) -> bool:
        """Whether there is a filter of this name."""
        return self._filters is not None and name.replace("::", "/") in self._filters.names()

    def GetFilterCount(self) -> int:
        """How many filters there are."""
        return len(self._filters.names()) if self._filters is not None else 0

    def PublishContacts(self) -> None:
        """Let the filters' topics tell of the last step; the world calls this in each iteration."""
        if self._filters is not None:
            self._filters.publish()


def read_contacts(world: World, points: NDArray[np.void]) -> list[Contact]:
    """Records of contact points (see `Engine.contacts`) as contacts, a pair of collisions each."""
    engine, now = world.core.engine, world.SimTime()
    pairs: dict[tuple[int, int], Contact] = {}
    for point in points:
        rows = int(point["geom1"]), int(point["geom2"])
        if rows not in pairs:
            touching = [world.collision_of(engine.geoms[row]) for row in rows if row in engine.geoms]
            if len(touching) < 2 or None in touching:
                continue
            pairs[rows] = Contact(world, touching[0], touching[1], now)
        contact = pairs[rows]
        contact.positions.append(Vector3d(*point["position"].tolist()))
        contact.normals.append(Vector3d(*point["normal"].tolist()))
        contact.depths.append(float(point["depth"]))
        contact.wrench.append(_wrench(contact, point))
    return list(pairs.values())


def _wrench(contact: Contact, point: np.void) -> JointWrench:
    """Forces and torques in the axes of the two links, as in Gazebo."""
    values = []
    for number, collision in ((1, contact.collision1), (2, contact.collision2)):
        turn = collision.link.WorldPose().rot
        for word in ("force", "torque"):
            values.append(turn.RotateVectorReverse(Vector3d(*point[f"{word}{number}"].tolist())))
    return JointWrench(*values)
