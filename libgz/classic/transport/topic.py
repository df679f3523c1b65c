"""A topic: who publishes on it and who listens, in this process; and the names of topics."""

from __future__ import annotations

import itertools
import logging
import os
import socket
import weakref
from collections import deque
from typing import TYPE_CHECKING, NamedTuple

from libgz.errors import ParameterError

if TYPE_CHECKING:
    from libgz.classic.msgs.message import Message
    from libgz.classic.transport.publisher import Publisher
    from libgz.classic.transport.subscriber import Subscriber

__all__ = ["End", "Incoming", "Topic", "decode", "encode", "log", "sequence"]

log = logging.getLogger("libgz.classic.transport")

# Every message and every subscription of the process gets the next number: a subscriber hears what came after it.
sequence = itertools.count(1)
INCOMING = 1000  # messages from other processes that may wait on a topic; then the oldest are dropped


def decode(topic: str, namespace: str) -> str:
    """The full name of a topic: a leading `~` stands for `/gazebo/<namespace>`, doubled slashes are one.

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
    """The short name of a topic, with `~` for `/gazebo/<namespace>`."""
    prefix = f"/gazebo/{namespace}"
    return "~" + topic.removeprefix(prefix) if topic == prefix or topic.startswith(prefix + "/") else topic


class End(NamedTuple):
    """One end of a topic."""

    what: str  # pub or sub
    type_name: str
    process: str  # host:pid


class Incoming(NamedTuple):
    """A message from another process, as it came."""

    number: int  # ours
    sender: str  # the publisher
    sent: int  # the sender's number
    type_name: str
    data: bytes
    subscriber: weakref.ref[Subscriber] | None  # the one that asked for it; None for all


class Topic:
    """What this process knows of a topic.

    Publishers and subscribers are held weakly: whoever asked for one holds it. The tables change by single operations
    of dicts, so that no lock is needed, also when an object goes while another thread publishes.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.publishers: dict[int, weakref.ref[Publisher]] = {}
        self.subscribers: dict[int, weakref.ref[Subscriber]] = {}
        self.remote = False  # whether another process listens
        self.incoming: deque[Incoming] = deque(maxlen=INCOMING)
        self.heard: dict[str, tuple[int, int]] = {}  # other processes' publishers: last message, and our number for it

    def live_publishers(self) -> list[Publisher]:
        """Those that were not dropped, oldest first."""
        return [found for ref in list(self.publishers.values()) if (found := ref()) is not None]

    def live_subscribers(self) -> list[Subscriber]:
        """Those that were not dropped, oldest first."""
        return [found for ref in list(self.subscribers.values()) if (found := ref()) is not None]

    def type_name(self) -> str:
        """The full name of the type that is published here, or an empty string."""
        return next((publisher.GetMsgType() for publisher in self.live_publishers()), "")

    def ends(self) -> list[End]:
        """Who publishes and who listens in this process."""
        me = f"{socket.gethostname()}:{os.getpid()}"
        publishers = [End("pub", publisher.GetMsgType(), me) for publisher in self.live_publishers()]
        return publishers + [End("sub", "", me) for _ in self.live_subscribers()]

    def deliver(self, number: int, message: Message) -> None:
        """Call all subscribers that were there when the message got its number."""
        for subscriber in self.live_subscribers():
            if subscriber.since < number:
                subscriber.take(message)
