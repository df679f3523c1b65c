"""Random rewinds between inserts, deletes, resets, pauses, seeds and jumps of time: as a plain list of states says."""

from __future__ import annotations

import contextlib
import logging
import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from topics import send
from trials.table import trial

import libgz
from libgz.base.errors import GazeboError, StateError
from libgz.base.files import installed_worlds
from libgz.classic import msgs

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
EXAMPLES = Path(__file__).parents[2] / "examples"
WORLDS = (
    installed_worlds() / "pioneer2at.world",
    installed_worlds() / "gripper.world",
    EXAMPLES / "sdf" / "rover.world",
    EXAMPLES / "plugins" / "joint_pid" / "joint_pid.world",
)
SLACK = 1e-9  # [s]
OPERATIONS = 60
SPHERE = """<sdf version='1.6'><model name='{0}'><pose>{1:.2f} 0 2 0 0 0</pose><link name='l'><collision name='c'>
<geometry><sphere><radius>.2</radius></sphere></geometry></collision></link></model></sdf>"""
SOLID = "<model:SimpleSolid><id>{0}</id><xyz>{1:.2f} 3 1</xyz></model:SimpleSolid>"


class Rewinding:
    """A world that keeps states, and a list of what these should be."""

    def __init__(self, path: Path, rng: random.Random) -> None:
        self.rng, self.world = rng, libgz.World.from_file(path)
        self.classic = self.world.sdf is not None
        if self.classic:
            self.world.attach_era()
        self.interval, self.seconds = rng.choice((0.0, 0.02, 0.1)), rng.choice((0.05, 0.3, 2.0))
        self.world.keep_rewind(self.seconds, self.interval)
        self.kept = [(self.world.GetSimTime(), self.world.get_state())]

    def step(self) -> None:
        """Some steps, each of which may be kept."""
        for _ in range(self.rng.randrange(1, 15)):
            self.world.Step()
            now, kept = self.world.GetSimTime(), self.kept
            while kept and kept[-1][0] > now + SLACK:
                kept.pop()
            if not kept or (now - kept[-1][0] > SLACK and now - kept[-1][0] >= self.interval - SLACK):
                kept.append((now, self.world.get_state()))
                while len(kept) > 1 and kept[1][0] <= now - self.seconds + SLACK:
                    kept.pop(0)

    def rewind(self) -> None:
        """Rewind, if there is such a state; the world is then in it, and otherwise as before."""
        back = self.rng.choice((0.0, 0.0, 0.02, 0.1, 0.5, 1.0, 1e6))
        wanted = self.world.GetSimTime() - back
        state = next((state for at, state in reversed(self.kept) if at <= wanted + SLACK), None)
        before = self.world.get_state()
        if state is None:
            with pytest.raises(StateError, match="before the oldest state that was kept"):
                self.world.rewind(back)
            assert self.world.get_state() == before
            return
        now = self.world.rewind(back)
        assert self.world.get_state() == state
        while self.kept and self.kept[-1][0] > now + SLACK:
            self.kept.pop()

    def insert(self) -> None:
        """Insert a model, unless there is one of its name."""
        name, x = f"n{self.rng.randrange(4)}", self.rng.uniform(-3.0, 3.0)
        if name in [entity.GetId() for entity in self.world.entities]:
            return
        if self.classic:
            self.world.facade.InsertModelString(SPHERE.format(name, x))
        else:
            self.world.InsertModel(SOLID.format(name, x), "<inserted>")

    def control(self) -> None:
        """A message of ~/world_control."""
        message = self.rng.choice(
            (
                {"multi_step": self.rng.randrange(1, 30)},
                {"step": True},
                {"pause": False},
                {"reset": {"all": True}},
                {"reset": {"time_only": True}},
                {"seed": 9},
            )
        )
        if self.classic:
            made = msgs.WorldControl()
            made.FromDict(message)
            send("~/world_control", made)

    def clone(self) -> None:
        """A clone has the state."""
        with self.world.clone() as clone:
            assert clone.get_state() == self.world.get_state()

    def operations(self) -> list[Callable[[], object]]:
        """What may happen, the frequent more than once."""
        world, rng = self.world, self.rng
        return [
            *[self.step] * 6,
            *[self.rewind] * 3,
            *[self.control] * 2,
            self.insert,
            lambda: world.DeleteModel(rng.choice(world.models)),
            world.Reset,
            world.ResetModelPoses,
            self.clone,
            lambda: setattr(world, "paused", not world.paused),
            lambda: setattr(world, "seed", rng.randrange(9)),
            lambda: world.set_state(rng.choice(self.kept)[1]),
            lambda: world.set_sim_time(world.GetSimTime() + rng.choice((-0.5, 0.2, 3.0))),
        ]


def check(path: Path, rng: random.Random) -> str:
    """What is wrong in one run; an empty string if nothing is."""
    subject = Rewinding(path, rng)
    done: list[Any] = []
    with subject.world:
        for _ in range(OPERATIONS):
            done.append(rng.choice(subject.operations()))
            try:
                with contextlib.suppress(IndexError):  # nothing to choose from
                    done[-1]()
            except (GazeboError, AssertionError) as error:
                return f"{path.stem}: {[getattr(one, '__name__', '') for one in done]}: {error!r}"[-1500:]
    return ""


def test_random_rewinds():
    logging.disable(logging.CRITICAL)
    try:
        with trial("rewinds between random changes") as row:
            row.count = max(8, round(400 * SHARE))
            rounds = (check(WORLDS[n % len(WORLDS)], random.Random(f"{row.seed} {n}")) for n in range(row.count))
            failures = [found for found in rounds if found]
            row.result = f"{len(failures)} differ"
            assert not failures, "\n".join(failures)
    finally:
        logging.disable(logging.NOTSET)
