"""Small worlds of all versions of SDF, in tests/data/sdf: each loads, runs and stays finite.

Comments in the files say what is expected: `At rest`; `warns: TEXT` of a warning with file and line; at the end,
`place: LINK X Y Z`, `axis: MODEL JOINT X Y Z`, `range: SENSOR INDEX METRES`; `step: SECONDS`.
"""

import math
import re
from pathlib import Path

import pytest

import libgz
from libgz.classic import sensors

WORLDS = sorted((Path(__file__).parent.parent / "data" / "sdf").glob("*.world"))


def expectations(text, key):
    return re.findall(rf"<!-- {key}: (.*?) -->", text)


def numbers(words):
    return tuple(map(float, words))


def run(path, steps, caplog):
    text = path.read_text()
    with libgz.World.from_file(path) as world:
        warned = [record.getMessage() for record in caplog.records]
        for expected in expectations(text, "warns"):
            assert any(
                re.match(rf"{re.escape(str(path.parent))}\S+:\d+: ", line) and expected in line for line in warned
            )
        if not expectations(text, "warns"):
            assert warned == []
        for expected in expectations(text, "axis"):
            model, joint, *axis = expected.split()
            found = tuple(world.model(model).sdf_joints[joint].axis(0))
            assert found == pytest.approx(numbers(axis), abs=1e-6)
        world.step(steps)
        bodies = [body for entity in world.entities for body in entity.bodies if not body.dummy]
        for body in bodies:
            assert all(map(math.isfinite, (*body.GetPosition(), *body.GetLinearVel(), *body.GetAngularRate())))
        if "At rest" in text:
            assert max((max(map(abs, body.GetLinearVel())) for body in bodies), default=0.0) < 0.01
        for expected in expectations(text, "place"):
            scoped, *place = expected.rsplit(" ", 3)
            model, _, link = scoped.partition("::")
            assert tuple(world.model(model).GetBody(link).GetPosition()) == pytest.approx(numbers(place), abs=0.01)
        for expected in expectations(text, "range"):
            sensor, index, distance = expected.split()
            sensors.get_sensor(sensor).Update(True)
            assert sensors.get_sensor(sensor).Range(int(index)) == pytest.approx(float(distance), abs=1e-6)
        for expected in expectations(text, "step"):
            assert world.engine.step_time == float(expected)


@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_a_world_runs(path, caplog):
    run(path, 200, caplog)


@pytest.mark.trial
@pytest.mark.parametrize("path", WORLDS, ids=lambda path: path.stem)
def test_a_world_runs_2000_iterations(path, caplog):
    run(path, 2000, caplog)
