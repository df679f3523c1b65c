"""States of legacy worlds at full length: continued, restored after changes, reset, and in other processes."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import state_runs
from state_runs import difference, digest, run
from trials.table import trial

import libgz
from libgz.base.files import installed_worlds

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
STEPS = max(40, round(500 * SHARE))
EXTRA = "<model:SimpleSolid><id>extra</id><xyz>1 1 2</xyz></model:SimpleSolid>"


def worlds():
    """The worlds of libgz, and those in the folders that STATE_WORLDS names, separated by colons."""
    folders = [installed_worlds(), *map(Path, filter(None, os.environ.get("STATE_WORLDS", "").split(":")))]
    return [path for folder in folders for path in sorted(folder.rglob("*.world"))]


def check(expected, seen, what):
    """Two traces are equal; otherwise the message says where they differ first."""
    at = difference(expected, seen)
    assert at is None, f"{what}: {at}"


@pytest.mark.parametrize("path", worlds(), ids=lambda path: path.stem)
def test_states_are_exact(path, tmp_path):
    with trial(f"state of {path.stem}") as row:
        first, second, third = (row.seed + i for i in range(3))
        with libgz.World.from_file(path) as world:
            start = world.get_state()
            fresh = run(world, STEPS, first)
            state = world.get_state()
            seen = run(world, STEPS, second)
            world.set_state(state)
            assert world.get_state() == state, "restored in place"
            check(seen, run(world, STEPS, second), "in place")

            tops = [entity.GetId() for entity in world.models if entity.parent is None]
            world.DeleteModel(tops[len(tops) // 2])
            world.InsertModel(EXTRA)
            run(world, STEPS // 10, third)
            world.set_state(state)
            check(seen, run(world, STEPS, second), "built again")

            world.InsertModel(EXTRA)
            run(world, STEPS // 10, third)
            world.DeleteModel(tops[len(tops) // 2])
            run(world, STEPS // 10, third)
            changed = world.get_state()
            then = run(world, STEPS, third)
            with world.clone() as clone:
                clone.set_state(changed)
                check(then, run(clone, STEPS, third), "cloned after changes")

            world.Reset()
            assert world.get_state() == start, "reset"
            check(fresh, run(world, STEPS, first), "after the reset")
        for kept, seed, expected in ((state, second, seen), (changed, third, then)):
            file = tmp_path / "state"
            file.write_bytes(kept)
            command = [sys.executable, state_runs.__file__, str(path), str(file), str(STEPS), str(seed)]
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.stdout.strip() == digest(expected), f"another process: {done.stderr[-2000:]}"
        row.count = STEPS
        row.result = f"bit-identical, {len(state)} bytes"
