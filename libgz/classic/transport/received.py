"""Received: the messages of other processes that wait for delivery, and what they may take of space."""

from __future__ import annotations

import threading

from libgz.classic.transport.topic import Incoming, Topic, log
from libgz.transport.tally import Tally

__all__ = ["Received"]

COUNT = 1000  # messages that may wait on a topic; then the oldest are dropped
BYTES = 64 << 20  # of all that wait; then the oldest of the topic with the most are dropped


class Received:
    """Counts the messages in the queues of topics.

    Attributes:
        size: Bytes of all that wait.
    """

    def __init__(self, limit: int = BYTES) -> None:
        self.size = 0
        self._limit = limit
        self._sizes: dict[Topic, int] = {}
        self._asked: dict[Topic, int] = {}  # calls of `take` that are to come
        self._lock = threading.Lock()
        self._warned = False
        self._tally = Tally(100)

    def add(self, topic: Topic, message: Incoming) -> bool:
        """Let a message wait; any thread may call this.

        Returns:
            Whether it has to be asked for by one more `take`; not if it has the place of a dropped one.
        """
        with self._lock:
            if len(topic.incoming) >= COUNT:
                self._drop(topic)
            topic.incoming.append(message)
            self._count(topic, len(message.data))
            while self.size > self._limit:
                most = max(self._sizes, key=self._sizes.__getitem__)
                if most is topic and len(topic.incoming) == 1:
                    break  # a message that is larger than the limit alone
                self._drop(most)
            more = self._asked.get(topic, 0) < len(topic.incoming)
            self._asked[topic] = self._asked.get(topic, 0) + more
            return more

    def take(self, topic: Topic) -> Incoming | None:
        """Return the oldest message of a topic; None if there is none any more."""
        with self._lock:
            asked = self._asked.pop(topic, 1) - 1
            if asked > 0:
                self._asked[topic] = asked
            if not topic.incoming:
                return None
            message = topic.incoming.popleft()
            self._count(topic, -len(message.data))
            return message

    def clear(self, topic: Topic) -> None:
        """Drop the messages of a topic, which are not asked for any more."""
        with self._lock:
            self._asked.pop(topic, None)
            topic.incoming.clear()
            self.size -= self._sizes.pop(topic, 0)

    def refuse(self, topic: str, text: str) -> None:
        """Log why a message is not delivered: seldom, for clients can repeat it without end."""
        if self._tally.due((topic, text[:200])):
            log.error("topic %s: %s%s", topic, text[:2000], self._tally.times((topic, text[:200])))

    def _drop(self, topic: Topic) -> None:
        self._count(topic, -len(topic.incoming.popleft().data))
        if not self._warned:
            self._warned = True
            log.warning(
                "topic %s: more messages come from other processes than are delivered; the oldest are dropped "
                "(reported once)",
                topic.name,
            )

    def _count(self, topic: Topic, size: int) -> None:
        self.size += size
        self._sizes[topic] = self._sizes.get(topic, 0) + size
        if not topic.incoming:
            self.size -= self._sizes.pop(topic)
