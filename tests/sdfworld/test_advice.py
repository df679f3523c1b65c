"""What warnings about contacts advise carries what did not rest: each advised value is run."""

import itertools
import re

import numpy as np
import pytest
from sdf_worlds import GROUND, SHAPES, Loader, collision, inertial, link, model, world

AWAKE = "<allow_auto_disable>0</allow_auto_disable>"
STEPS = [
    (0.02, "quick"),
    (0.02, "world"),
    *(pytest.param(step, solver, marks=pytest.mark.trial) for step, solver in ((0.001, "quick"), (0.01, "world"))),
]
SINKING = re.compile(r"model '(\w+)' sinks into what it rests on: .*; (.*) would carry it")


@pytest.fixture
def load(tmp_path):
    loader = Loader(tmp_path)
    yield loader
    loader.close()


def solid(name, place, shape, mass, kp, max_vel=0.01, kd=1.0, size=1.0):
    contact = f"<contact><ode><kp>{kp}</kp><kd>{kd}</kd><max_vel>{max_vel}</max_vel></ode></contact>"
    part = collision(shape, contact)
    return model(name, AWAKE, link("link", inertial(mass, (mass * size**2 / 6,) * 3), part), pose=f"{place} 0 0 0")


def physics(step, solver, more=""):
    return f"<max_step_size>{step}</max_step_size><ode><solver><type>{solver}</type>{more}</solver></ode>"


def advised(made):
    """Name -> the choices of a warning, each with the elements that it sets."""
    found = (SINKING.search(warning.message) for warning in made.warnings)
    return {
        match[1]: [dict(re.findall(r"<(\w+)> ([\d.e+-]+)", choice)) for choice in match[2].split(" or ")]
        for match in found
        if match
    }


@pytest.mark.parametrize(("step", "solver"), STEPS)
def test_the_advised_springs_and_speeds_carry_every_shape_and_mass(load, step, solver):
    cases = {
        f"s{i}": dict(zip(("shape", "mass", "kp", "max_vel"), case, strict=True))
        for i, case in enumerate(
            [
                *itertools.product(SHAPES, (1.0, 1000.0, 1e4), (10.0, 1e3, 1e5), (0.01,)),
                *itertools.product(("box",), (1.0, 1000.0), (10.0,), (0.0, 100.0)),
            ]
        )
    }

    def run(settings):
        placed = [solid(name, f"{20 * i} 0 0.5", **one) for i, (name, one) in enumerate(settings.items())]
        made = load(world(GROUND, *placed, physics=physics(step, solver)))
        warned = advised(made)
        made.run(20.0 if step > 0.01 else 5.0)
        heights = []
        for _ in range(25):  # springs with little damping oscillate
            made.run(0.02)
            heights.append([made.body(name).GetPosition().z for name in settings])
        return warned, {name for name, height in zip(settings, np.mean(heights, axis=0), strict=True) if height < 0.4}

    warned, sinks = run(cases)
    assert sinks  # what sinks is warned about, and what is warned about sinks
    assert set(warned) == sinks
    assert len(warned) > 15
    for choice in (0, -1):
        repaired = {name: cases[name] | choices[choice] for name, choices in warned.items()}
        assert run(repaired) == ({}, set())


ITERATED = "<exact_rest>false</exact_rest>"


@pytest.mark.trial
@pytest.mark.parametrize("ratio", [10.0, 1000.0, 1e4])
def test_heavy_on_light_rests_or_the_advised_solver_carries_it(load, caplog, ratio):
    def pile(count, solver, more=""):
        boxes = [solid(f"b{i}", f"0 0 {i + 0.5}", "box", 1.0, 1e12) for i in range(count - 1)]
        top = solid("top", f"0 0 {count - 0.5}", "box", ratio, 1e12)
        caplog.clear()
        made = load(world(GROUND, *boxes, top, physics=physics(0.001, solver, more)))
        before = made.engine.states[:, 9].copy()
        made.run(1.0)
        return float(np.abs(made.engine.states[:, 9] - before).max())

    assert pile(2, "quick") < 1e-4
    assert pile(14, "quick") < 1e-3
    assert "sinks" not in caplog.text
    sunk = pile(14, "quick", ITERATED)
    assert ("<solver><type>world</type> or <exact_rest>true" in caplog.text) == (ratio > 50.0) == (sunk > 0.01)
    assert pile(14, "world") < 1e-3
    assert "stands on one of" not in caplog.text


@pytest.mark.trial
@pytest.mark.parametrize("count", [13, 30, 60])
def test_tall_stacks_rest_or_the_advice_holds_them_still(load, caplog, count):
    def speed(more=""):
        caplog.clear()
        boxes = [solid(f"b{i}", f"0 0 {i + 0.5}", "box", 1.0, 1e12) for i in range(count)]
        made = load(world(GROUND, *boxes, physics=physics(0.001, "quick", more)))
        made.run(1.0)
        return float(np.abs(made.engine.states[:, 10:13]).max())

    assert speed() < 1e-3
    assert "hold still" not in caplog.text
    assert speed(ITERATED) > 1e-3
    assert "<exact_rest>true</exact_rest> would" in caplog.text
