"""Readings: what cameras and lasers of a classic world measured last, from the recorded messages of their topics."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from libgz.base.budget import budget_limit
from libgz.base.errors import GazeboError
from libgz.classic.msgs.declare import message_type
from libgz.classic.transport.topic import decode
from libgz.recording.reader import LogChannel
from libgz.rendering.image import jpeg_text

__all__ = ["Readings"]

SUFFIXES = {"camera": "image", "ray": "scan", "gpu_ray": "scan"}  # of the topics of sensors, by kind
IMAGE, SCAN = "gazebo.msgs.ImageStamped", "gazebo.msgs.LaserScanStamped"


class Readings:
    """Keeps the last message of each sensor's topic, the newest that fit in a budget; they are read on request.

    Args:
        world: its name.
    """

    def __init__(self, world: str) -> None:
        self._world = world
        self._topics: dict[str, str] = {}  # of sensors, by model::link::sensor
        self._messages: dict[str, tuple[str, bytes]] = {}  # type and bytes, by topic; the newest comes last
        self._size = 0  # of them [byte]

    def show(self, scene: dict[str, Any]) -> None:
        """Learn the sensors of a scene."""
        self._topics = {}
        for entity in scene["entities"]:
            bodies = {body["id"]: body["name"] for body in entity["bodies"]}
            for sensor in entity["sensors"]:
                if "name" in sensor and sensor["kind"] in SUFFIXES:
                    name = f"{entity['id']}::{bodies.get(sensor['body'], '')}::{sensor['name']}"
                    own = f"~/{name.replace('::', '/')}/{SUFFIXES[sensor['kind']]}"
                    self._topics[name] = decode(sensor.get("topic") or own, self._world)

    def take(self, channel: LogChannel, content: bytes) -> None:
        """Keep a message of a topic."""
        kind = channel.about.get("type", "")
        if kind not in (IMAGE, SCAN):
            return
        self._forget(channel.topic)
        self._messages[channel.topic] = kind, content
        self._size += len(content)
        while self._size > budget_limit():
            self._forget(next(iter(self._messages)))

    def _forget(self, topic: str) -> None:
        _, content = self._messages.pop(topic, ("", b""))
        self._size -= len(content)

    def clear(self) -> None:
        """Forget all messages."""
        self._messages.clear()
        self._size = 0

    def answer(self, names: Iterable[str]) -> dict[str, Any]:
        """Of sensors named ``model::link::sensor``: last images, as JPEG in base64, and ranges [m], -1 for none."""
        images: dict[str, str] = {}
        ranges: dict[str, list[float]] = {}
        for name in names:
            kind, content = self._messages.get(self._topics.get(name, ""), ("", b""))
            try:
                message: Any = message_type(kind).FromString(content) if kind else None
            except GazeboError:
                continue  # the file is damaged there; the topic's player reports it
            if kind == IMAGE:
                text = jpeg_text(message.image.data, message.image.height, message.image.width)
                images |= {name: text} if text else {}
            elif kind == SCAN:
                ranges[name] = [float(r) if math.isfinite(r) else -1.0 for r in message.scan.ranges]
        return {"images": images, "ranges": ranges}
