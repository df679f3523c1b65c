"""Probes: numbers of topics and plugins by name, which a viewer plots."""

from __future__ import annotations

import itertools
import json
import math
import time
from collections.abc import Callable, Iterator
from typing import Any

from libgz.base.errors import GazeboError
from libgz.base.numbers import whole_number
from libgz.front import World

__all__ = ["Probes"]

MOST_LISTED, MOST_READ, MOST_OF_TOPIC = 2000, 200, 40  # numbers of an answer; that are listed of a topic
MOST_TOPICS = 32  # that are listened to
DEEPEST = 5  # messages in messages
MOST_REPEATED = 3  # of a repeated field, that are listed
UNUSED = 5.0  # [s] of real time after which a topic that nobody asks for is not listened to


class _Heard:
    """The last message of a topic."""

    def __init__(self) -> None:
        self.message: Any = None
        self.subscriber: Any = None
        self.asked = 0.0  # [s] of time.monotonic

    def hear(self, message: Any) -> None:
        self.message = message


class Probes:
    """Reads numbers of a world; their keys are JSON.

    A key is ``["topic", name, field]`` or ``["plugin", model, name, attribute]``; without a model it is the world's.

    Args:
        world: it is initialized.
        node: of the topics' world, as it is needed.
    """

    def __init__(self, world: World, node: Callable[[], Any]) -> None:
        self._world, self._node = world, node
        self._heard: dict[str, _Heard] = {}

    def listed(self, name: str) -> list[dict[str, str]]:
        """What can be read of an entity, or of the world if the name is empty: key, label, group."""
        found = [*self._of_plugins(name), *self._of_topics(name)]
        return found[:MOST_LISTED]

    def values(self, keys: list[Any]) -> dict[str, float]:
        """The present numbers; those that there are not are left out. Topics are listened to from the first call on."""
        now, found = time.monotonic(), {}
        for key in [key for key in keys if isinstance(key, str)][:MOST_READ]:
            value = self._value(key, now)
            if value is not None and math.isfinite(value):
                found[key] = value
        for topic, heard in list(self._heard.items()):
            if now > heard.asked + UNUSED:
                heard.subscriber.Unsubscribe()
                del self._heard[topic]
        return found

    def _value(self, key: str, now: float) -> float | None:
        try:
            parts = json.loads(key)
        except (ValueError, RecursionError):
            return None
        match parts:
            case ["topic", str(topic), str(field)]:
                return self._of_topic(topic, field, now)
            case ["plugin", str(model), str(name), str(attribute)]:
                return self._of_plugin(model, name, attribute)
        return None

    # Plugins ---------------------------------------------------------------------------------------------------------

    def _plugins(self, name: str) -> Iterator[tuple[str, Any]]:
        """The plugins of an entity, or of the world: name and instance."""
        if self._world.sdf is None:
            if name:
                model = self._world.model(name)
                yield type(model).__name__, model
            return
        from libgz.classic.server import attach

        server = attach(self._world)
        models = [model for model in server.world.Models() if model.GetName() == name]
        loaded = [plugin for model in models for plugin in server.plugins.of_model(model)]
        for one in loaded if name else server.plugins.of_world.values():
            if one.plugin is not None:
                yield one.name, one.plugin

    def _of_plugins(self, name: str) -> Iterator[dict[str, str]]:
        for label, plugin in self._plugins(name):
            group = f"plugin {label}" if self._world.sdf is not None else "attributes of the class"
            for attribute, value in sorted(getattr(plugin, "__dict__", {}).items()):
                plain = not attribute.startswith("_") and not isinstance(value, bool)
                if plain and _number(value) is not None:
                    yield {"key": json.dumps(["plugin", name, label, attribute]), "label": attribute, "group": group}

    def _of_plugin(self, model: str, name: str, attribute: str) -> float | None:
        if model and model not in {entity.GetId() for entity in self._world.entities}:
            return None
        found = next((plugin for label, plugin in self._plugins(model) if label == name), None)
        return _number(getattr(found, "__dict__", {}).get(attribute)) if not attribute.startswith("_") else None

    # Topics ----------------------------------------------------------------------------------------------------------

    def _topics(self) -> dict[str, str]:
        """The types of the topics that are published, by name."""
        if self._world.sdf is None:
            return {}
        from libgz.classic.transport import TopicManager

        self._node()
        found: dict[str, str] = TopicManager.Instance().AdvertisedTopics()
        return found

    def _of_topics(self, name: str) -> Iterator[dict[str, str]]:
        """The numbers of the messages of topics; those of an entity have its name in theirs."""
        if self._world.sdf is None:
            return
        from libgz.classic import msgs

        models = {entity.GetId() for entity in self._world.entities}
        for topic, kind in self._topics().items():
            owners = models.intersection(topic.split("/"))
            if (name not in owners) if name else owners:
                continue
            try:
                descriptor = msgs.message_type(kind).DESCRIPTOR
            except GazeboError:  # of another program
                continue
            for field in itertools.islice(_numbers_of(descriptor), MOST_OF_TOPIC):
                yield {"key": json.dumps(["topic", topic, field]), "label": field, "group": f"topic {topic}"}

    def _of_topic(self, topic: str, path: str, now: float) -> float | None:
        heard = self._heard.get(topic)
        if heard is None:
            if len(self._heard) >= MOST_TOPICS or topic not in self._topics():
                return None
            heard = self._heard[topic] = _Heard()
            heard.subscriber = self._node().Subscribe(topic, heard.hear, True)
        heard.asked = now
        value = heard.message
        for part in path.split("."):
            word, _, place = part.partition("[")
            field = _fields_of(value).get(word)
            if field is None:
                return None
            value = getattr(value, word)
            if place:
                number = place[:-1]
                index = whole_number(number, len(value) - 1) if field.is_repeated else None
                value = None if index is None else value[index]
        return _number(value)


def _fields_of(message: Any) -> Any:
    return getattr(getattr(message, "DESCRIPTOR", None), "fields_by_name", {})


def _numbers_of(descriptor: Any, depth: int = DEEPEST) -> Iterator[str]:
    """The paths of the numbers of a message: ``pose.position.x``, ``ranges[0]``."""
    for field in descriptor.fields:
        names = [f"{field.name}[{i}]" for i in range(MOST_REPEATED)] if field.is_repeated else [field.name]
        for name in names:
            if field.message_type is not None:
                if depth:
                    yield from (f"{name}.{rest}" for rest in _numbers_of(field.message_type, depth - 1))
            elif field.cpp_type not in (field.CPPTYPE_STRING, field.CPPTYPE_ENUM):
                yield name


def _number(value: Any) -> float | None:
    """A number; None for all else."""
    return float(value) if isinstance(value, int | float) and abs(value) < 1e300 else None
