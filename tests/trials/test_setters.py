"""Every setter of every object of an SDF world: a state has what it changed, and restores what was before."""

from __future__ import annotations

import contextlib
import inspect
import logging
from collections.abc import Iterator
from typing import Any

import pytest
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError
from libgz.classic.math import PID, Pose3d, Quaterniond, Vector3d

pytestmark = pytest.mark.trial

NOISE = "<noise type='gaussian'><mean>0</mean><stddev>0.1</stddev></noise>"
OPTICS = """<horizontal_fov>1</horizontal_fov><image><width>8</width><height>6</height></image>
<clip><near>0.1</near><far>10</far></clip>"""
SENSORS = {
    "ray": f"""<ray><scan><horizontal><samples>5</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal>
</scan><range><min>0.1</min><max>5</max></range>{NOISE}</ray>""",
    "imu": f"<imu><angular_velocity><x>{NOISE}</x></angular_velocity></imu>",
    "contact": "<contact><collision>c</collision></contact>",
    "camera": f"<camera>{OPTICS}{NOISE}</camera>",
    "depth": f"<camera>{OPTICS}</camera>",
    "multicamera": f"<camera name='one'>{OPTICS}</camera><camera name='two'>{OPTICS}{NOISE}</camera>",
    "sonar": "<sonar><min>0.1</min><max>3</max><radius>0.3</radius></sonar>",
    "altimeter": "",
    "magnetometer": "",
    "gps": "",
    "logical_camera": """<logical_camera><near>0.1</near><far>5</far><horizontal_fov>1</horizontal_fov>
<aspect_ratio>1</aspect_ratio></logical_camera>""",
}
RATE = "<always_on>1</always_on><update_rate>20</update_rate>"
BOX = "<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>"
BALL = "<collision name='c'><geometry><sphere><radius>0.2</radius></sphere></geometry></collision>"
WORLD = f"""<sdf version='1.6'><world name='default'>
<model name='ground'><static>1</static><link name='l'><collision name='c'><geometry><plane><normal>0 0 1</normal>
<size>50 50</size></plane></geometry></collision></link></model>
<model name='m'><pose>0 0 0.6 0 0 0</pose><link name='a'>{BOX}<battery name='cell'><voltage>12</voltage></battery>
{"".join(f"<sensor name='{kind}' type='{kind}'>{RATE}{text}</sensor>" for kind, text in SENSORS.items())}</link>
<link name='b'><pose>1.2 0 0 0 0 0</pose>{BALL}</link>
<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz><limit><lower>-1</lower>
<upper>1</upper></limit><dynamics><damping>0.1</damping></dynamics></axis>
<sensor name='force' type='force_torque'>{RATE}</sensor></joint></model>
<model name='n'><pose>3 0 1 0 0 0</pose><link name='a'>{BOX}</link>
<model name='inner'><link name='q'><pose>1 0 0 0 0 0</pose>{BALL}</link></model></model>
<light name='sun' type='directional'><pose>0 0 10 0 0 0</pose></light>
<actor name='walker'><script><trajectory id='0' type='x'><waypoint><time>0</time><pose>0 5 0 0 0 0</pose></waypoint>
<waypoint><time>2</time><pose>2 5 0 0 0 0</pose></waypoint></trajectory></script></actor></world></sdf>"""
PREFIXES = (
    *("Set", "Reset", "Enable", "Add", "Create", "Remove", "Attach", "Detach", "Update", "Place", "Sample", "Apply"),
    *("Toggle", "Change", "Track", "Move", "Scale", "Translate", "Rotate", "Zero", "Disable"),
)
NOT_CALLED = {"ResetTime", "RemoveModel", "RemovePlugin"}  # of the whole world; other tests have them
VALUES: dict[str, Any] = {  # by what an annotation has in it, the first that fits
    "Pose": Pose3d(0.3, 0.2, 1.1, 0.1, 0.2, 0.3),
    "Quatern": Quaterniond(0.1, 0.2, 0.3),
    "Vector": Vector3d(0.2, 0.3, 0.7),
    "bool": True,
    "PID": PID(2.0),
    "Angle": 0.3,
    "float": 0.37,
    "dict": {"m::j": 0.2},
    "Color": (0.1, 0.2, 0.3, 1.0),
}


def value_for(parameter: inspect.Parameter) -> Any:
    """Some value for a parameter of a method."""
    kind, name = str(parameter.annotation), parameter.name.lower()
    found = [value for part, value in VALUES.items() if part in kind]
    if found:
        return found[0]
    if "int" in kind:
        return 0 if "index" in name else 3
    if "str" in kind:
        return "hi_stop" if name == "key" else "j" if "joint" in name else "other"
    raise TypeError(kind)


def objects(world: World) -> Iterator[Any]:
    """What a plugin can reach of a world."""
    view = world.facade
    yield from (view, view.Physics(), view.Physics().GetContactManager(), view.server.presets)
    for model in view.Models():
        yield model
        if hasattr(model, "GetJointController"):
            yield model.GetJointController()
        for link in model.GetLinks():
            yield from (link, link.GetInertial())
            for collision in link.GetCollisions():
                yield from (collision, collision.GetShape())
        yield from model.GetJoints()
    yield from view.Lights()
    for sensor in view.server.sensors.sensors.values():
        yield from (sensor, *sensor.cameras, *sensor.every_noise)
        if hasattr(sensor, "LaserShape"):
            yield sensor.LaserShape()


def calls(thing: Any) -> Iterator[tuple[str, list[Any]]]:
    """The names of its methods that change something, each with arguments."""
    for name, method in inspect.getmembers(type(thing), callable):
        if not name.startswith(PREFIXES) or name in NOT_CALLED:
            continue
        try:
            parameters = list(inspect.signature(method).parameters.values())[1:]
            plain = [p for p in parameters if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
            yield (
                name,
                [value_for(p) for p in plain if p.default is p.empty or isinstance(p.default, int | str | float)],
            )
        except (TypeError, ValueError):
            continue


def test_what_setters_change_is_in_a_state():
    logging.disable(logging.CRITICAL)
    try:
        with trial("states around each setter") as row, World.from_string(WORLD) as world:
            world.step(30)
            for thing in list(objects(world)):
                for name, arguments in calls(thing):
                    before = world.get_state()
                    with contextlib.suppress(GazeboError, TypeError, ValueError, AttributeError):  # wrong arguments
                        getattr(thing, name)(*arguments)
                    changed = world.get_state()
                    world.step(2)
                    then = world.get_state()
                    world.set_state(before)
                    assert world.get_state() == before, f"{thing}.{name}"
                    world.set_state(changed)
                    world.step(2)
                    assert world.get_state() == then, f"{thing}.{name}, set again"
                    world.set_state(before)
                    row.count += 1
            row.result = "all states are complete"
            assert row.count > 500
    finally:
        logging.disable(logging.NOTSET)
