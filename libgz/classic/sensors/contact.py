"""ContactSensor: the contacts of collisions of its link."""

from __future__ import annotations

import logging
from collections import deque
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from libgz.base.errors import StateError
from libgz.classic import msgs
from libgz.classic.names import takes_names
from libgz.classic.physics.contact import RECORD, Contact, ContactPoints, contact_points, read_contacts
from libgz.classic.physics.contact_messages import contacts_message
from libgz.classic.sensors.read import custom_topic, first
from libgz.classic.sensors.sensor import LinkSensor, SensorOwner

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.sdf.element import Element

__all__ = ["ContactSensor"]

log = logging.getLogger("libgz.classic")

MOST_ITERATIONS = 100  # whose contacts are kept between two measurements


@takes_names
class ContactSensor(LinkSensor):
    """Reports the contacts of all iterations since its last measurement."""

    topic_suffix: ClassVar[str | None] = ""
    topic_added = True
    message_type: ClassVar[Any] = msgs.Contacts
    gathers: ClassVar[bool] = True

    def __init__(self, sensors: SensorOwner, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self._prefix = f"{parent.GetScopedName()}::"
        names = [element.Get(str) for element in sdf.child("contact").named("collision")]
        self._collisions = [self._prefix + name.removeprefix(self._prefix) for name in names]
        self._waiting: deque[bytes] = deque(maxlen=MOST_ITERATIONS)  # contact records of iterations
        self._taken = b""  # those of the last measurement
        self._read: tuple[int, list[Contact]] | None = None  # the contacts in those, and the count of geoms then
        self._rows: tuple[int, frozenset[int]] | None = None  # of its collisions, and the count of geoms then
        self._manager = self.world.Physics().GetContactManager()
        self._filter = ""  # name of the topic of each iteration's contacts

    def SaveState(self) -> tuple[object, ...]:
        """The contacts that wait, and those of the last measurement."""
        return [*self._waiting], self._taken

    def LoadState(self, state: Any) -> None:
        """Take what SaveState returned.

        Raises:
            StateError: these are not whole records of contacts.
        """
        waiting, taken = state
        for records in (*waiting, taken):
            if not isinstance(records, bytes) or len(records) % RECORD.itemsize:
                raise StateError(f"the state is damaged: sensor {self.Name()!r} has incomplete records of contacts")
        self._taken = taken
        self._waiting.clear()
        self._waiting.extend(waiting)
        self._read = None

    def Init(self) -> None:
        """Check that the collisions exist."""
        for name in self._collisions:
            if self.link.GetCollision(name.removeprefix(self._prefix)) is None:
                known = ", ".join(collision.GetName() for collision in self.link.GetCollisions()) or "none"
                log.warning(
                    "%s: <contact>: there is no collision %r; %s has %s", self.sdf.where, name, self._prefix[:-2], known
                )

        name = self._prefix.replace("::", "/") + self.Name()
        if self._collisions and not self._manager.HasFilter(name):
            self._filter = name
            self._manager.CreateFilter(name, self._collisions)

    def Fini(self) -> None:
        """End the sensor and its topics."""
        if self._filter and self._manager.HasFilter(self._filter):
            self._manager.RemoveFilter(self._filter)
            self._filter = ""
        super().Fini()

    def custom_topic(self) -> str:
        """The topic that its file names; an empty string for none."""
        contact = first(self.sdf, "contact")
        return (custom_topic(contact) if contact is not None else "") or super().custom_topic()

    def activated(self) -> None:
        """Have contacts recorded."""
        self._manager.hold(self)

    def deactivated(self) -> None:
        """Contacts need not be recorded for this sensor any more."""
        self._manager.release(self)
        self._waiting.clear()

    # Measuring ---------------------------------------------------------------------------------------------------

    def gather(self) -> None:
        """Collect this iteration's contacts."""
        count = self.world.core.engine.tables.geoms.changes
        if self._rows is None or self._rows[0] != count:
            mine = (one.geom.row for one in self.link.GetCollisions() if one.GetScopedName() in self._collisions)
            self._rows = count, frozenset(mine)
        self._waiting.append(self._manager.records_of(self._rows[1]))

    def ready(self, elapsed: float) -> bool:
        """Whether there was an iteration since the last measurement."""
        return bool(self._waiting)

    def measure(self, elapsed: float) -> None:
        """Take over the collected contacts."""
        self._taken = b"".join(self._waiting)
        self._read = None
        self._waiting.clear()

    @property
    def _contacts(self) -> list[Contact]:
        """The contacts of the last measurement, of collisions that still are there."""
        count = self.world.core.engine.tables.geoms.changes
        if self._read is None or self._read[0] != count:
            self._read = count, read_contacts(self.world, np.frombuffer(self._taken, RECORD))
        return self._read[1]

    def points(self) -> list[ContactPoints]:
        """The contacts of the last measurement as arrays."""
        return contact_points(self.world, np.frombuffer(self._taken, RECORD))

    def message(self) -> Any:
        """The contacts of the last measurement as a msgs.Contacts."""
        return contacts_message(self._contacts, self.LastMeasurementTime())

    def reset(self) -> None:
        """Forget all contacts."""
        self._waiting.clear()
        self._taken, self._read = b"", None
        super().reset()

    # Contacts ----------------------------------------------------------------------------------------------------

    def GetCollisionCount(self) -> int:
        """The number of its collisions."""
        return len(self._collisions)

    def GetCollisionName(self, index: int) -> str:
        """``model::link::collision``; an empty string if there is none of this number."""
        return self._collisions[index] if 0 <= index < len(self._collisions) else ""

    def GetCollisionContactCount(self, collisionName: str) -> int:
        """How many contact points a collision had in the last measurement; the name is the scoped one."""
        return sum(contact.count for contact in self._contacts if collisionName in contact.names)

    def Contacts(self, collisionName: str | None = None) -> Any:
        """The contacts of the last measurement: a msgs.Contacts; for one collision, {other collision: Contact}."""
        if collisionName is None:
            return self.message()
        found: dict[str, Contact] = {}
        for contact in self._contacts:
            first, second = contact.names
            if collisionName in (first, second):
                found[second if collisionName == first else first] = contact
        return found

    GetContacts = Contacts
