"""ContactSensor: what touches some collisions of its link."""

from __future__ import annotations

import logging
from collections import deque
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from libgz.classic.common import Time
from libgz.classic.physics.contact import Contact, read_contacts
from libgz.classic.physics.contact_messages import contacts_message
from libgz.classic.sensors.read import custom_topic
from libgz.classic.sensors.sensor import Sensor

if TYPE_CHECKING:
    from libgz.classic.physics import Link
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.sdf.element import Element

__all__ = ["ContactSensor"]

log = logging.getLogger("libgz.classic")

MOST_ITERATIONS = 100  # whose contacts are kept between two measurements


class ContactSensor(Sensor):
    """Tells of contacts, those of all iterations since its last measurement."""

    topic_suffix: ClassVar[str | None] = ""
    message_type: ClassVar[str] = "Contacts"
    gathers: ClassVar[bool] = True

    def __init__(self, sensors: WorldSensors, parent: Link, sdf: Element) -> None:
        super().__init__(sensors, parent, sdf)
        self.link = parent
        self._prefix = f"{parent.GetScopedName()}::"
        names = [element.Get(str) for element in sdf.child("contact").named("collision")]
        self._collisions = [self._prefix + name.removeprefix(self._prefix) for name in names]
        self._waiting: deque[list[Contact]] = deque(maxlen=MOST_ITERATIONS)
        self._contacts: list[Contact] = []
        self._manager = self.world.Physics().GetContactManager()

    def Init(self) -> None:
        """Look whether the collisions are there."""
        for name in self._collisions:
            if self.link.GetCollision(name.removeprefix(self._prefix)) is None:
                known = ", ".join(collision.GetName() for collision in self.link.GetCollisions()) or "none"
                log.warning(
                    "%s: <contact>: there is no collision %r; %s has %s", self.sdf.where, name, self._prefix[:-2], known
                )

    def Topic(self) -> str:
        """``~/model/link/sensor``, or what its file says."""
        contact = next(self.sdf.named("contact"), None)
        return (custom_topic(contact) if contact is not None else "") or super().Topic()

    GetTopic = Topic

    def went_active(self) -> None:
        """Let contacts be recorded."""
        self._manager.hold(self)

    def went_idle(self) -> None:
        """Contacts need not be recorded for this sensor."""
        self._manager.release(self)
        self._waiting.clear()

    # Measuring ---------------------------------------------------------------------------------------------------

    def gather(self) -> None:
        """Note this iteration's contacts."""
        points = self.world.core.engine.contacts
        rows = [c.geom.row for c in self.link.GetCollisions() if c.GetScopedName() in self._collisions]
        mine = points[np.isin(points["geom1"], rows) | np.isin(points["geom2"], rows)] if len(points) else points
        self._waiting.append(read_contacts(self.world, mine))

    def measure(self, now: float) -> bool:
        """Take over what was noted; nothing if there was no iteration since."""
        if not self._waiting:
            return False
        self._measured = now
        self._contacts = [contact for found in self._waiting for contact in found]
        self._waiting.clear()
        if self.listened():
            self.publish(self.Contacts())
        return True

    def reset(self) -> None:
        """Forget all contacts."""
        self._waiting.clear()
        self._contacts = []
        super().reset()

    # Telling -----------------------------------------------------------------------------------------------------

    def GetCollisionCount(self) -> int:
        """How many collisions it watches."""
        return len(self._collisions)

    def GetCollisionName(self, index: int) -> str:
        """``model::link::collision``; an empty string if there is none of this number."""
        return self._collisions[index] if 0 <= index < len(self._collisions) else ""

    def GetCollisionContactCount(self, collisionName: str) -> int:
        """How many contact points a collision had in the last measurement; the name is the scoped one."""
        return sum(contact.count for contact in self._contacts if collisionName in contact.names)

    def Contacts(self, collisionName: str | None = None) -> Any:
        """The contacts of the last measurement: a msgs.Contacts; for one collision, {what it touches: Contact}."""
        if collisionName is None:
            return contacts_message(self._contacts, Time(self._measured))
        found: dict[str, Contact] = {}
        for contact in self._contacts:
            first, second = contact.names
            if collisionName in (first, second):
                found[second if collisionName == first else first] = contact
        return found

    GetContacts = Contacts
