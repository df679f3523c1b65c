"""Publisher: the sending end of a topic."""

from __future__ import annotations

import functools
import threading
import time as clock
import weakref
from collections import deque
from contextlib import suppress
from typing import Any

from libgz.base.errors import ClosedError, ParameterError
from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import PATIENCE, TopicManager
from libgz.classic.transport.topic import Topic, log, sequence
from libgz.simulation.event import owner

__all__ = ["Publisher", "drop_waiting", "queue_message", "waiting_messages"]

POLL = 0.002  # [s] between checks for a subscriber


class _Outbox(deque[tuple[int, Message]]):
    """The messages of a publisher that wait, each with a place in the manager's queue, and their numbers."""

    def __init__(self) -> None:
        super().__init__()
        # Held while either changes: threads publish while another one delivers. A handler of signals may publish, too.
        self.lock = threading.RLock()

    def entries(self) -> list[tuple[int, Message]]:
        """Return what waits now."""
        with self.lock:
            return list(self)

    def empty(self) -> None:
        """Drop all messages."""
        with self.lock:
            self.clear()


class Publisher:
    """A publication, as returned by Node.Advertise; it ends when it is dropped, or with the plugin that made it.

    Raises:
        ParameterError: `queueLimit` is below 1, or `hzRate` is negative.
    """

    def __init__(self, topic: Topic, kind: type[Message], queueLimit: int = 1000, hzRate: float = 0.0) -> None:
        if queueLimit < 1:
            raise ParameterError(f"queueLimit is {queueLimit}; it must be at least 1")
        if hzRate < 0.0:
            raise ParameterError(f"hzRate is {hzRate}; it must be positive, or 0 for no limit")
        self.id = next(sequence)
        self._topic = topic
        self._type = kind
        self._limit = queueLimit
        self._period = 1.0 / hzRate if hzRate else 0.0
        self._due = 0.0
        self._outbox = _Outbox()
        # Not a method of this object: waiting messages are delivered even if the publisher is dropped before.
        self._send_one = functools.partial(_send_one, topic, self._outbox)
        self._open = True
        self._warned = False
        self.latest: tuple[int, Message] | None = None
        topic.publishers[id(self)] = weakref.ref(self)
        if (by := owner.get()) is not None:
            by.connections.add(self)
        self._manager = TopicManager.Instance()
        self._manager.refresh(topic)

    def Publish(self, message: Message, block: bool = False, *, here: bool = True) -> None:
        """Send a copy of a message; without `here`, to other processes only.

        Subscribers in this process are called at the end of the server's iteration, or, with `block`, before this
        returns. Other processes are sent the message at once. Above `hzRate` messages per second of wall time, the
        message is dropped. Without a subscriber, the message is only kept for late ones.

        Raises:
            ParameterError: the message is not of the type that was advertised.
            ClosedError: after Fini, or after the world was closed.
        """
        if not self._open:
            raise ClosedError(f"publisher of {self._topic.name}: Publish after Fini, or after its world was closed")
        if type(message) is not self._type:
            what = message.GetTypeName() if isinstance(message, Message) else type(message).__name__
            raise ParameterError(f"{self._topic.name} was advertised with {self.GetMsgType()}; it cannot send a {what}")
        if self._period:
            now = clock.monotonic()
            if now < self._due:
                return
            self._due = now + self._period
        self.latest = entry = (next(sequence), message.copy())
        topic = self._topic
        if here and topic.subscribers:
            self._put(entry)
            if block:
                self.SendMessage()
        if topic.remote and (remote := self._manager.remote) is not None:
            remote.send(topic, self.id, *entry)

    def SendMessage(self) -> None:
        """Deliver the waiting messages to the subscribers of this process now; soon, while another thread delivers."""
        if not self._manager.delivering.acquire(timeout=PATIENCE):
            return
        try:
            while self._outbox:
                self._send_one()
        finally:
            self._manager.delivering.release()

    def _put(self, entry: tuple[int, Message]) -> None:
        """Let a message wait; one too many takes the place of the oldest."""
        with self._outbox.lock:
            full = len(self._outbox) >= self._limit
            if full:
                self._outbox.popleft()
            else:
                self._manager.queue.append(self._send_one)
            self._outbox.append(entry)
        if full and not self._warned:
            self._warned = True
            log.warning(
                "topic %s: more than %d messages wait; the oldest are dropped (reported once)",
                self._topic.name,
                self._limit,
            )

    def HasConnections(self) -> bool:
        """Whether there is a subscriber, in this or another process."""
        return bool(self._topic.subscribers) or self._topic.remote

    def WaitForConnection(self, timeout: Any = None) -> bool:
        """Wait until there is a subscriber.

        Args:
            timeout: Wall time to wait, as a Time or in [s]; without limit when not given or negative.

        Returns:
            Whether there is a subscriber.
        """
        seconds = -1.0 if timeout is None else float(timeout.Double() if hasattr(timeout, "Double") else timeout)
        end = clock.monotonic() + seconds
        while not self.HasConnections():
            if seconds >= 0.0 and clock.monotonic() >= end:
                return False
            clock.sleep(POLL)
        return True

    def GetTopic(self) -> str:
        """Return the full name of the topic."""
        return self._topic.name

    def GetMsgType(self) -> str:
        """Return the full name of the messages' type."""
        return self._type.GetTypeName()

    def GetOutgoingCount(self) -> int:
        """Return the number of messages that wait for delivery in this process."""
        return len(self._outbox)

    def ClearBuffer(self) -> None:
        """Drop the waiting messages."""
        self._outbox.empty()

    def Fini(self) -> None:
        """End the publication. Waiting messages are still delivered."""
        self._open = False
        if self._topic.publishers.pop(id(self), None) is not None:
            self._manager.refresh(self._topic)

    disconnect = Fini

    def __del__(self) -> None:
        topic = getattr(self, "_topic", None)
        if topic is not None and topic.publishers.pop(id(self), None) is not None:
            TopicManager.Instance().refresh_later(topic)


def _send_one(topic: Topic, outbox: _Outbox) -> None:
    """Deliver the oldest waiting message, if SendMessage has not done it yet."""
    with outbox.lock:
        entry = outbox.popleft() if outbox else None
    if entry is not None:
        topic.deliver(*entry)


# States of worlds -----------------------------------------------------------------------------------------------------


def waiting_messages(prefix: str) -> list[tuple[str, Message]]:
    """Return (topic, message) of all that waits in this process on topics with a prefix, in the order of delivery."""
    queue = TopicManager.Instance().queue
    if not queue:
        return []
    found: dict[int, tuple[str, Message]] = {}
    outboxes: dict[int, tuple[Topic, _Outbox]] = {}  # each once: threads may publish meanwhile
    for deliver in list(queue):
        if isinstance(deliver, functools.partial) and deliver.func is _send_one:
            outboxes[id(deliver.args[1])] = deliver.args
        elif isinstance(deliver, _Waiting):
            found[deliver.number] = deliver.topic, deliver.message
    for topic, outbox in outboxes.values():
        found.update({number: (topic.name, message) for number, message in outbox.entries()})
    return [entry for _, entry in sorted(found.items()) if entry[0].startswith(prefix)]


def drop_waiting(prefix: str) -> None:
    """Drop the messages that `waiting_messages` returns."""
    queue = TopicManager.Instance().queue
    for deliver in list(queue):
        if isinstance(deliver, functools.partial) and deliver.func is _send_one:
            topic, outbox = deliver.args
            if topic.name.startswith(prefix):
                outbox.empty()
        elif isinstance(deliver, _Waiting) and deliver.topic.startswith(prefix):
            with suppress(ValueError):  # another thread delivers it
                queue.remove(deliver)


def queue_message(topic: str, message: Message) -> None:
    """Let a message wait on a topic, for those that have subscribed by now."""
    TopicManager.Instance().queue.append(_Waiting(topic, message))


class _Waiting:
    """A message whose publisher is not known any more."""

    def __init__(self, topic: str, message: Message) -> None:
        self.topic, self.message, self.number = topic, message, next(sequence)

    def __call__(self) -> None:
        TopicManager.Instance().topic(self.topic).deliver(self.number, self.message)
