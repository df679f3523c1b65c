"""Messages with any numbers and names on all topics of a classic world: it steps on, and can be brought back.

A world that is brought back is what makes a refused state leave no trace; so no message may lead to a world whose own
state is refused.
"""

from __future__ import annotations

import faulthandler
import logging
import os
import random
from pathlib import Path
from typing import Any

import pytest
from google.protobuf.descriptor import FieldDescriptor
from trials.table import trial

from libgz import World
from libgz.classic import msgs, transport

pytestmark = pytest.mark.trial

ROOT = Path(__file__).parents[2]
COUNT = int(os.environ.get("TRIAL_MESSAGES") or 3000)  # of each world
BETWEEN = 50  # messages between two times that a world is brought back
LARGEST = 2**31 - 1
NUMBERS = (0.0, 1.0, -1.0, 1e9, -1e9, 1e30, 1e308, -1e308, 1e-320, 0.5, float("nan"), float("inf"), -float("inf"))
MODEL = "<model name='new{}'><link name='l'><pose>{} 0 5 0 0 0</pose>{}</link></model>"
BALL = "<collision name='c'><geometry><sphere><radius>{}</radius></sphere></geometry></collision>"
TOPICS: dict[str, Any] = {
    "~/atmosphere": msgs.Atmosphere,
    "~/factory": msgs.Factory,
    "~/factory/light": msgs.Light,
    "~/light/modify": msgs.Light,
    "~/model/modify": msgs.Model,
    "~/physics": msgs.Physics,
    "~/request": msgs.Request,
    "~/scene": msgs.Scene,
    "~/undo_redo": msgs.UndoRedo,
    "~/user_cmd": msgs.UserCmd,
    "~/visual": msgs.Visual,
    "~/wind": msgs.Wind,
    "~/world_control": msgs.WorldControl,
}


class Writer:
    """Fills messages with what should do no harm."""

    def __init__(self, seed: int, names: list[str]) -> None:
        self._rng = random.Random(seed)
        self._names = [*names, "", "a::b", "../..", "x" * 3000, "\0"]

    def fill(self, message: Any, depth: int = 0) -> Any:
        """Fill some of the fields of a message, and all that it must have."""
        for field in message.DESCRIPTOR.fields:
            if not field.is_required and self._rng.random() > 0.6 * 0.8**depth:
                continue
            if field.cpp_type == FieldDescriptor.CPPTYPE_MESSAGE:
                if depth < 5:
                    inner = getattr(message, field.name)
                    self.fill(inner.add() if field.is_repeated else inner, depth + 1)
            elif field.is_repeated:
                getattr(message, field.name).append(self._value(field))
            else:
                setattr(message, field.name, self._value(field))
        return message

    def _value(self, field: Any) -> Any:
        rng, kind = self._rng, field.cpp_type
        if field.type == FieldDescriptor.TYPE_BYTES:
            return rng.randbytes(20)
        if field.name == "sdf":
            ball = BALL.format(rng.choice((0.1, 0, -1, "nan", 1e308)))
            return f"<sdf version='1.6'>{MODEL.format(rng.randrange(9), rng.choice((0, 1e308, 'nan')), ball)}</sdf>"
        if field.name == "request":
            return rng.choice(("entity_info", "entity_list", "entity_delete", "scene_info", "world_sdf", "x"))
        if field.name == "multi_step":
            return rng.randrange(3)
        if kind == FieldDescriptor.CPPTYPE_STRING:
            return rng.choice(self._names)
        if kind in (FieldDescriptor.CPPTYPE_DOUBLE, FieldDescriptor.CPPTYPE_FLOAT):
            return rng.choice(NUMBERS)
        if kind == FieldDescriptor.CPPTYPE_BOOL:
            return rng.random() < 0.5
        if kind == FieldDescriptor.CPPTYPE_ENUM:
            return rng.choice([value.number for value in field.enum_type.values])
        return rng.choice((0, 1, 7, 1000, LARGEST))


@pytest.mark.parametrize("name", ["gripper", "rover", "wind"])
def test_messages_with_anything_in_them(name: str) -> None:
    faulthandler.enable()
    logging.disable(logging.CRITICAL)
    try:
        with (
            trial(f"hostile messages, {name}") as row,
            World.from_file(ROOT / "examples" / "sdf" / f"{name}.world") as world,
        ):
            world.attach_era()
            row.count = COUNT
            node = transport.Node()
            node.Init(world.topic_space)
            models = [model.GetId() for model in world.models]
            topics = TOPICS | {f"~/{model}/joint_cmd": msgs.JointCmd for model in models}
            topics |= {f"~/{model}/link/wrench": msgs.Wrench for model in models}
            publishers = {topic: node.Advertise(kind, topic) for topic, kind in topics.items()}
            rng, writer = random.Random(row.seed), Writer(row.seed, [*models, *(f"{model}::link" for model in models)])
            for number in range(COUNT):
                topic = rng.choice(list(topics))
                publishers[topic].Publish(writer.fill(topics[topic]()))
                world.step(1)
                if number % BETWEEN == 0:
                    world.snapshots.restore(world.get_state(), anew=True)
            row.result = "no failure"
            node.Fini()
    finally:
        logging.disable(logging.NOTSET)
