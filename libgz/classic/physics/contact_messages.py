"""Contacts as messages."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from libgz.classic import msgs
from libgz.classic.common import Time
from libgz.classic.physics.contact import Contact

__all__ = ["contacts_message"]


def contacts_message(contacts: Iterable[Contact], time: Time) -> Any:
    """Contacts as a msgs.Contacts, of a sim time."""
    message = msgs.Contacts()
    msgs.Set(message.time, time)
    for contact in contacts:
        contact.FillMsg(message.contact.add())
    return message
