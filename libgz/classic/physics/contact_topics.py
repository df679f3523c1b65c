"""Contacts as messages, and topics that tell of the contacts of some collisions only."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.transport import Node, Publisher
from libgz.errors import NotFoundError, ParameterError, nearest

if TYPE_CHECKING:
    from libgz.classic.physics.contact import Contact, ContactManager, JointWrench
    from libgz.classic.physics.world import World

__all__ = ["ContactFilters", "contacts_message"]


class ContactFilters:
    """The filters of a world: ``~/name/contacts`` tells in each iteration what some collisions touch."""

    def __init__(self, manager: ContactManager, world: World) -> None:
        self._manager, self._world = manager, world
        self._node = Node()
        self._node.Init(world.Name())
        self._filters: dict[str, tuple[Publisher, frozenset[str]]] = {}
        self._told = world.core.engine.steps

    def create(self, name: str, collisions: str | Iterable[str]) -> str:
        """Begin a topic; its name.

        Raises:
            ParameterError: there is a filter of this name, or no collision.
        """
        name = name.replace("::", "/")
        wanted = [collisions] if isinstance(collisions, str) else list(collisions)
        if name in self._filters:
            raise ParameterError(f"there is a contact filter {name!r} already")
        if not wanted:
            raise ParameterError(f"contact filter {name!r} has no collisions to tell of")
        prefix = f"{self._world.Name()}::"
        topic = f"~/{name}/contacts"
        publisher = self._node.Advertise(msgs.Contacts, topic)
        self._filters[name] = publisher, frozenset(one.removeprefix(prefix) for one in wanted)
        return topic

    def remove(self, name: str) -> None:
        """End a topic.

        Raises:
            NotFoundError: there is no filter of this name.
        """
        name = name.replace("::", "/")
        if name not in self._filters:
            raise NotFoundError(f"there is no contact filter {name!r}{nearest(name, self._filters)}")
        publisher, _ = self._filters.pop(name)
        publisher.Fini()
        self._manager.release(publisher)

    def names(self) -> list[str]:
        """The names of all filters."""
        return list(self._filters)

    def publish(self) -> None:
        """Tell of the last step, once, where somebody listens."""
        step = self._world.core.engine.steps
        if step == self._told:
            return
        self._told = step
        for publisher, names in self._filters.values():
            if not publisher.HasConnections():
                self._manager.release(publisher)
                continue
            self._manager.hold(publisher)
            found = [one for one in self._manager.read() if not names.isdisjoint(one.names)]
            publisher.Publish(contacts_message(found, self._world.SimTime()))


def contacts_message(contacts: Iterable[Contact], time: Time) -> Any:
    """Contacts as a msgs.Contacts."""
    message = msgs.Contacts()
    msgs.Set(message.time, time)
    for contact in contacts:
        part = message.contact.add(world=contact.world.Name())
        part.collision1, part.collision2 = contact.names
        msgs.Set(part.time, contact.time)
        part.position = [msgs.Convert(position) for position in contact.positions]
        part.normal = [msgs.Convert(normal) for normal in contact.normals]
        part.depth = contact.depths
        part.wrench = [_wrench_message(contact, wrench) for wrench in contact.wrench]
    return message


def _wrench_message(contact: Contact, wrench: JointWrench) -> Any:
    message = msgs.JointWrench()
    message.body_1_name, message.body_2_name = contact.names
    message.body_1_id, message.body_2_id = contact.collision1.GetId(), contact.collision2.GetId()
    msgs.Set(message.body_1_wrench.force, wrench.body1Force)
    msgs.Set(message.body_1_wrench.torque, wrench.body1Torque)
    msgs.Set(message.body_2_wrench.force, wrench.body2Force)
    msgs.Set(message.body_2_wrench.torque, wrench.body2Torque)
    return message
