"""States of SDF worlds: all examples and packaged models, and worlds of a folder, restored and reset to the bit."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import pytest
from classic_runs import Run, first_difference, opened
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError
from libgz.classic.math import Rand

pytestmark = pytest.mark.trial

ROOT = Path(__file__).parents[2]
STEPS = 500
MODEL = """<sdf version='1.6'><world name='default'><include><uri>model://ground_plane</uri></include>
<include><uri>model://{0}</uri><name>it</name></include>
<include><uri>model://{0}</uri><name>other</name><pose>3 0 0.5 0 0.1 0</pose></include></world></sdf>"""
BALL = """<sdf version='1.6'><model name='{0}'><pose>0.3 0.2 4 0 0 0</pose><link name='l'><collision name='c'><geometry>
<sphere><radius>0.2</radius></sphere></geometry></collision></link></model></sdf>"""


def worlds() -> list[tuple[str, str | Path]]:
    """Names and texts or paths of worlds; those of the folder CLASSIC_WORLDS, too."""
    found: list[tuple[str, str | Path]] = [
        (path.stem, path) for path in sorted((ROOT / "examples" / "plugins").glob("*/*.world"))
    ]
    models = sorted(path.parent.name for path in (ROOT / "libgz").glob("**/model.config"))
    found += [(name, MODEL.format(name)) for name in models if name not in ("sun", "ground_plane")]
    folder = os.environ.get("CLASSIC_WORLDS")
    return found + [(path.stem, path) for path in sorted(Path(folder).glob("*.world"))] if folder else found


def begun(world: str | Path) -> Run | None:
    """A run of a world; None if libgz does not load it."""
    Rand.Seed(5)
    try:
        run = opened(world) if isinstance(world, Path) else Run(World.from_string(world))
    except GazeboError:
        return None
    run.watch()
    return run


def check(world: str | Path) -> str | None:
    """What differs after a restore or a reset; None if nothing does, and an empty text if the world does not load."""
    run = begun(world)
    if run is None:
        return ""
    with run.world:
        fresh = run.steps(STEPS)
        run.view.InsertModelString(BALL.format("before"))
        run.steps(STEPS // 10)
        run.world.get_state()
        run.steps(3)
        state = run.world.get_state()
        first = run.steps(STEPS)
        moving = [model.GetName() for model in run.view.Models() if not model.IsStatic()]
        run.view.RemoveModel(moving[0])
        run.view.InsertModelString(BALL.format("after"))
        run.steps(STEPS // 10)
        run.world.set_state(state)
        if run.world.get_state() != state:
            return "the state that was set is not the state"
        at = first_difference(first, run.steps(STEPS))
        if at is not None:
            return f"differs in step {at} after a restore"
        Rand.Seed(5)
        run.world.reset()
        run.activate()
        at = first_difference(fresh, run.steps(STEPS))
        return f"differs in step {at} after a reset" if at is not None else None


def test_restored_and_reset_worlds_are_equal_to_the_bit():
    logging.disable(logging.ERROR)
    try:
        with trial("SDF worlds restored and reset, 500 steps") as row:
            found = {name: check(world) for name, world in worlds()}
            row.count = sum(result != "" for result in found.values())
            failures = {name: result for name, result in found.items() if result}
            row.result = f"{len(failures)} differ"
            assert not failures
            assert row.count >= 15
    finally:
        logging.disable(logging.NOTSET)
