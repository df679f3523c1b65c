"""Damaged states: one that is refused leaves the world unchanged, and one that is not leaves it usable."""

from __future__ import annotations

import contextlib
import logging
import os
import random
from pathlib import Path

import pytest
from damaged_states import damage
from forked import BATCH, note, run_trials
from state_runs import command
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
SDF = ("gripper", "rover", "actors", "population")
PLUGINS = ("contact", "joint_pid", "diff_drive", "camera")
LEGACY = ("pioneer2at", "gripper", "simplesolids", "bandit", "truth")


class Subject:
    """A world, a state of it, and a later one."""

    def __init__(self, path: Path) -> None:
        self.name, self.world = path.stem, World.from_file(path)
        if not self.world.running:
            self.world.Initialize()
        if self.world.sdf is not None:
            self.world.attach_era()
        rng = random.Random(1)
        for _ in range(20):
            self.run(rng)
        self.early = self.world.get_state()
        for _ in range(20):
            self.run(rng)
        self.late = self.world.get_state()

    def run(self, rng: random.Random) -> None:
        """A step, with commands."""
        if self.world.sdf is None:
            command(self.world, rng)
        self.world.Step()

    def attack(self, rng: random.Random) -> str:
        """Set a damaged state; what is wrong then."""
        data, what = damage(rng, self.early)
        note(f"{self.name}: {what}")
        try:
            self.world.set_state(data)
        except GazeboError as error:
            if self.world.get_state() != self.late:
                return f"{self.name}: {what}: refused, but the world has changed: {error}"
            return ""
        with contextlib.suppress(Exception):  # an attribute may hold anything, also what its class cannot use
            self.world.Step()
            self.world.get_state()
            self.world.Step()
        self.world.set_state(self.late)
        if self.world.get_state() != self.late:
            return f"{self.name}: {what}: taken, and a sound state that follows is not the same"
        return ""


def test_damaged_states_are_refused_as_a_whole():
    paths = [ROOT / "worlds" / f"{name}.world" for name in LEGACY]
    paths += [EXAMPLES / "sdf" / f"{name}.world" for name in SDF]
    paths += [path for path in sorted((EXAMPLES / "plugins").glob("*/*.world")) if path.parent.name in PLUGINS]
    logging.disable(logging.CRITICAL)
    try:
        with trial("damaged states") as row:
            subjects: dict[Path, Subject] = {}  # of one process: a world has threads, which no other one inherits

            def one(number: int) -> str:
                path = paths[number // BATCH % len(paths)]
                if path not in subjects:
                    subjects[path] = Subject(path)
                return subjects[path].attack(random.Random(f"{row.seed} {number}"))

            row.count = len(paths) * max(20, round(400 * SHARE)) // BATCH * BATCH or BATCH
            failures = list(run_trials(one, range(row.count), 2))
            row.result = f"{len(failures)} differ"
            assert not failures, "\n".join(map(str, failures))
    finally:
        logging.disable(logging.NOTSET)
