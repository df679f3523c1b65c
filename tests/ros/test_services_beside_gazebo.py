"""The services of /gazebo, with requests to gazebo_ros_pkgs on Gazebo 11.1 and its answers: fields and texts."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from ros_node import Node

from libgz.ros.api import SERVICES
from libgz.ros.types import TIMES, Message, Stamp, message_type, service_type

TESTS = Path(__file__).parents[1]
CALLS = json.loads((TESTS / "data/gazebo_ros_services.json").read_text())


def filled(message, values):
    """A message with the values of a table."""
    for field in message.kind.fields:
        if field.name not in values:
            continue
        value = values[field.name]
        if field.kind in TIMES:
            value = Stamp(*(int(part) for part in (value // 1, value % 1 * 1e9)))
        elif isinstance(value, dict):
            value = filled(message_type(field.kind)(), value)
        setattr(message, field.name, value)
    return message


def differences(wanted, found, path=""):
    """The paths of what differs."""
    if isinstance(wanted, dict):
        for name, value in wanted.items():
            if name != "auto_disable_bodies":
                yield from differences(value, getattr(found, name), f"{path}.{name}")
    elif isinstance(wanted, list):
        found = found.tolist() if isinstance(found, np.ndarray) else found
        if len(wanted) != len(found):
            yield path, wanted, found
        for one, other in zip(wanted, found, strict=False):
            yield from differences(one, other, path)
    elif isinstance(found, Stamp):
        return
    elif isinstance(wanted, float):
        if not (math.isnan(wanted) and math.isnan(found)) and found != pytest.approx(wanted, rel=1e-6, abs=1e-6):
            yield path, wanted, found
    elif wanted != found and not isinstance(found, Message):
        yield path, wanted, found


def test_services_answer_as_those_of_gazebo(master, start):
    node = Node(master, *start((Path(__file__).parent / "services.world").read_text()))
    node.core.facade.SetPaused(True)
    different, changed = [], False
    for number, (name, values, answer) in enumerate(CALLS):
        timed = isinstance(answer, dict) and any(word in str(answer) for word in ("timed out", "Timeout"))
        if timed or isinstance(answer, str):  # Gazebo gave up, or answered without a text
            continue
        request = filled(service_type(SERVICES[name]).request(), values)
        found = node.call(name, **{field.name: getattr(request, field.name) for field in request.kind.fields})
        changed = changed or name == "set_light_properties"
        if changed and name == "get_light_properties":  # without a renderer, Gazebo's light stays as it was
            continue
        if name == "get_world_properties":
            answer.pop("sim_time")
        different += [(number, name, values, *one) for one in differences(answer, found)]
    assert not different
