"""Topic: the publishers and subscribers of a topic in this process; and the names of topics."""

from __future__ import annotations

import itertools
import logging
import weakref
from collections import deque
from collections.abc import Collection
from typing import NamedTuple, Protocol

from libgz.base.errors import ParameterError
from libgz.classic.msgs.message import Message
from libgz.classic.transport.elements import MOST
from libgz.simulation.event import Owner

__all__ = ["Incoming", "LocalPublisher", "LocalSubscriber", "Topic", "decode", "encode", "log", "sequence"]

log = logging.getLogger("libgz.classic.transport")

# Every message and every subscription of the process gets the next number: a subscriber receives what came after it.
sequence = itertools.count(1)


def decode(topic: str, namespace: str) -> str:
    """Return the full name of a topic: a leading `~` is replaced by `/gazebo/<namespace>`, doubled slashes by one.

    Raises:
        ParameterError: the name is empty.
    """
    name = topic.strip()
    if not name.strip("~/"):
        raise ParameterError(
            f"a topic cannot be called {topic!r}; a name is like ~/pose/info or /gazebo/default/pose/info"
        )
    if name.startswith("~"):
        name = f"/gazebo/{namespace}/{name[1:]}"
    while "//" in name:
        name = name.replace("//", "/")
    return name


def encode(topic: str, namespace: str) -> str:
    """Return the short name of a topic, with `~` for `/gazebo/<namespace>`."""
    prefix = f"/gazebo/{namespace}"
    return "~" + topic.removeprefix(prefix) if topic == prefix or topic.startswith(prefix + "/") else topic


class LocalPublisher(Protocol):
    """The part of a publisher's interface that topics and their manager use."""

    id: int
    latest: tuple[int, Message] | None  # the last message and its number

    def GetMsgType(self) -> str:
        """Return the full name of the messages' type."""

    def ClearBuffer(self) -> None:
        """Drop all waiting messages."""

    def Fini(self) -> None:
        """End the publication."""


class LocalSubscriber(Protocol):
    """The part of a subscriber's interface that topics and their manager use."""

    since: int  # the number of the subscription: it receives messages with larger ones
    latching: bool
    owner: Owner | None  # the plugin that subscribes
    type_name: str  # the full name of the messages' type, if it was named

    def take(self, message: Message) -> None:
        """Call the callback."""

    def Unsubscribe(self) -> None:
        """End the subscription."""


class Incoming(NamedTuple):
    """A message received from another process, still encoded."""

    number: int  # of this process
    type_name: str
    data: bytes
    subscriber: weakref.ref[LocalSubscriber] | None  # the latching one that it is for; None for all others


class Topic:
    """A topic in this process.

    Publishers and subscribers are held weakly: the code that created one holds it. The tables change by single
    operations of dicts, so that no lock is needed, even if an object is collected while another thread publishes.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.publishers: dict[int, weakref.ref[LocalPublisher]] = {}
        self.subscribers: dict[int, weakref.ref[LocalSubscriber]] = {}
        self.remote = False  # whether another process has a subscriber
        self.incoming: deque[Incoming] = deque()
        self.elements = MOST  # of a message of another process that is delivered

    @property
    def used(self) -> bool:
        """Whether it has publishers or subscribers, or messages of other processes wait."""
        return bool(self.publishers or self.subscribers or self.incoming)

    def live_publishers(self) -> list[LocalPublisher]:
        """Return the publishers that were not dropped, oldest first."""
        return [found for ref in list(self.publishers.values()) if (found := ref()) is not None]

    def live_subscribers(self) -> list[LocalSubscriber]:
        """Return the subscribers that were not dropped, oldest first."""
        return [found for ref in list(self.subscribers.values()) if (found := ref()) is not None]

    def move(self, by: Owner | None, others: Collection[Owner]) -> None:
        """Call the subscribers of one plugin before those of others."""
        every = self.live_subscribers()
        rest = [one for one in every if one.owner is not by]
        at = next((i for i, one in enumerate(rest) if one.owner is not None and one.owner in others), len(rest))
        for one in (*(one for one in every if one.owner is by), *rest[at:]):  # to the end, one after the other
            reference = self.subscribers.pop(id(one), None)
            if reference is not None:
                self.subscribers[id(one)] = reference

    def type_name(self) -> str:
        """Return the full name of the type that this process publishes, or an empty string."""
        return next((publisher.GetMsgType() for publisher in self.live_publishers()), "")

    def expected_type(self) -> str:
        """Return the full name of the type that a subscriber of this process names, or an empty string."""
        return next((one.type_name for one in self.live_subscribers() if one.type_name), "")

    def deliver(self, number: int, message: Message, latching: bool = True) -> None:
        """Call all subscribers that subscribed before the message got its number; without `latching`, not those."""
        for subscriber in self.live_subscribers():
            if subscriber.since < number and (latching or not subscriber.latching):
                subscriber.take(message)
