"""States of the worlds of ready plugins: set after a few other steps, the same follows, state included."""

from pathlib import Path

import pytest
from classic_runs import Run

from libgz import World
from libgz.classic.math import Rand

WORLDS = sorted((Path(__file__).parents[3] / "examples" / "plugins").glob("*/*.world"))
SHORT = {"link_plot_3d", "diff_drive"}


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, id=path.stem, marks=[] if path.stem in SHORT else pytest.mark.trial) for path in WORLDS],
)
def test_the_state_after_a_state_is_the_same(path):
    Rand.Seed(5)
    with World.from_file(path) as world:
        run = Run(world)
        run.activate()
        run.steps(30)
        state = world.get_state()
        seen, then = run.steps(40), world.get_state()
        for others in (0, 1, 5, 17):
            world.set_state(state)
            run.steps(others)
            world.set_state(state)
            assert run.steps(40) == seen
            assert world.get_state() == then
