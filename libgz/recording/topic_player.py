"""TopicPlayer: publishes the recorded messages of a classic world's topics."""

from __future__ import annotations

import contextlib
import logging
from typing import Any

from libgz.base.errors import GazeboError
from libgz.classic import msgs
from libgz.classic.transport import Node, Publisher, TopicManager
from libgz.recording.reader import LogChannel
from libgz.recording.topics import type_of_topic

__all__ = ["TopicPlayer"]

log = logging.getLogger("libgz.recording")


class TopicPlayer:
    """Publishes messages on the topics of a world.

    Args:
        world: its name.
    """

    def __init__(self, world: str) -> None:
        self._world = world
        self._manager = TopicManager.Instance()
        self._manager.AddTopicNamespace(world)
        self._node = Node()
        self._node.Init(world)
        self._publishers: dict[str, Publisher | None] = {}
        self._damaged: set[str] = set()  # topics of which messages were left out
        self._received: list[Any] = []
        self._subscriber = self._node.Subscribe("~/playback_control", self._received.append)

    def publish(self, channel: LogChannel, content: bytes) -> None:
        """Publish a message. A topic whose type is not understood is left out, with a warning."""
        if channel.topic not in self._publishers:
            self._publishers[channel.topic] = self._advertise(channel)
        publisher = self._publishers[channel.topic]
        if publisher is not None:
            kind = type_of_topic(channel.about.get("type", ""), channel.about.get("declaration", ""))
            try:
                publisher.Publish(kind.FromString(content))
            except GazeboError as error:
                if channel.topic not in self._damaged:  # a log may have millions
                    self._damaged.add(channel.topic)
                    log.warning("topic %s: messages are left out: %s", channel.topic, error)

    def _advertise(self, channel: LogChannel) -> Publisher | None:
        try:
            kind = type_of_topic(channel.about.get("type", ""), channel.about.get("declaration", ""))
            return self._node.Advertise(kind, channel.topic)
        except GazeboError as error:
            log.warning("topic %s is left out: %s", channel.topic, error)
            return None

    def update(self) -> None:
        """Deliver what was published."""
        self._manager.ProcessNodes()

    def requests(self) -> list[tuple[str, str]]:
        """What came by ``~/playback_control``."""
        received, self._received[:] = list(self._received), []
        found: list[tuple[str, str]] = []
        for message in received:
            if message.rewind:
                found.append(("seek", "0"))
            if message.forward:
                found.append(("seek", "1e300"))
            if message.HasField("seek"):
                found.append(("seek", str(msgs.ConvertIgn(message.seek).Double())))
            if message.HasField("pause"):
                found.append(("pause" if message.pause else "resume", ""))
            if message.HasField("rt_factor"):
                found.append(("speed", str(message.rt_factor)))
            if message.multi_step > 0:
                found.append(("step", str(message.multi_step)))
        return found

    def close(self) -> None:
        """End the publications."""
        with contextlib.suppress(GazeboError):
            self._subscriber.Unsubscribe()
        self._node.Fini()
        self._publishers.clear()
        self._manager.RemoveTopicNamespace(self._world)
