"""Contacts as messages."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.physics.contact import Contact, JointWrench

__all__ = ["contacts_message"]


def contacts_message(contacts: Iterable[Contact], time: Time) -> Any:
    """Contacts as a msgs.Contacts, of a sim time."""
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
