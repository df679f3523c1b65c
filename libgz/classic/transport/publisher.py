"""The end of a topic that speaks."""

from __future__ import annotations

import functools
import time as clock
import weakref
from collections import deque
from typing import Any

from libgz.classic.msgs.message import Message
from libgz.classic.transport.manager import TopicManager
from libgz.classic.transport.topic import Topic, log, sequence
from libgz.errors import ClosedError, ParameterError

__all__ = ["Publisher"]

POLL = 0.002  # [s] between looks for a subscriber


class Publisher:
    """A publication, as Node.Advertise returns it; it ends when it is dropped, and its last message with it."""

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
        self._outbox: deque[tuple[int, Message]] = deque()
        # Not a method of this object: what waits is delivered, though the publisher may be dropped before.
        self._send_one = functools.partial(_send_one, topic, self._outbox)
        self._open = True
        self._warned = False
        self.latest: tuple[int, Message] | None = None
        topic.publishers[id(self)] = weakref.ref(self)
        self._manager = TopicManager.Instance()
        self._manager.refresh(topic)

    def Publish(self, message: Message, block: bool = False) -> None:
        """Send a message; it is copied, so that it may be filled anew at once.

        Subscribers in this process are called when the server has ended its iteration, or, with `block`, before this
        returns. Other processes are sent the message at once. Above `hzRate` messages a second of wall time, the
        message is dropped. A message that nobody listens to is only kept for late subscribers.

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
        if topic.subscribers:
            if len(self._outbox) < self._limit or not self._drop():
                self._manager.queue.append(self._send_one)
            self._outbox.append(entry)
            if block:
                self.SendMessage()
        if topic.remote and (remote := self._manager.remote) is not None:
            remote.send(topic, self.id, *entry)

    def SendMessage(self) -> None:
        """Deliver to the subscribers of this process what waits, now."""
        with self._manager.pump:
            while self._outbox:
                self._send_one()

    def _drop(self) -> bool:
        """Drop the oldest message that waits, so that another can take its place in the queue."""
        try:
            self._outbox.popleft()
        except IndexError:
            return False
        if not self._warned:
            self._warned = True
            log.warning(
                "topic %s: more than %d messages wait; the oldest are dropped (told once)",
                self._topic.name,
                self._limit,
            )
        return True

    def HasConnections(self) -> bool:
        """Whether somebody listens, here or in another process."""
        return bool(self._topic.subscribers) or self._topic.remote

    def WaitForConnection(self, timeout: Any = None) -> bool:
        """Wait until somebody listens.

        Args:
            timeout: How long of wall time, as a Time or in [s]; as long as it takes when not given or negative.

        Returns:
            Whether somebody does.
        """
        seconds = -1.0 if timeout is None else float(timeout.Double() if hasattr(timeout, "Double") else timeout)
        end = clock.monotonic() + seconds
        while not self.HasConnections():
            if seconds >= 0.0 and clock.monotonic() >= end:
                return False
            clock.sleep(POLL)
        return True

    def GetTopic(self) -> str:
        """The full name of the topic."""
        return self._topic.name

    def GetMsgType(self) -> str:
        """The full name of the messages' type."""
        return self._type.GetTypeName()

    def GetOutgoingCount(self) -> int:
        """How many messages wait for delivery in this process."""
        return len(self._outbox)

    def ClearBuffer(self) -> None:
        """Forget what waits."""
        self._outbox.clear()

    def Fini(self) -> None:
        """End the publication. What waits is still delivered."""
        self._open = False
        if self._topic.publishers.pop(id(self), None) is not None:
            self._manager.refresh(self._topic)

    def __del__(self) -> None:
        topic = getattr(self, "_topic", None)
        if topic is not None and topic.publishers.pop(id(self), None) is not None:
            TopicManager.Instance().refresh_later(topic)


def _send_one(topic: Topic, outbox: deque[tuple[int, Message]]) -> None:
    """Deliver the oldest message that waits; SendMessage may have been faster."""
    try:
        entry = outbox.popleft()
    except IndexError:
        return
    topic.deliver(*entry)
