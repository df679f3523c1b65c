"""Damaged states: one that is refused leaves the world unchanged, and one that is not leaves it usable."""

from __future__ import annotations

import contextlib
import json
import logging
import os
import random
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from forked import BATCH, note, run_trials
from state_runs import command
from trials.table import trial

from libgz import World
from libgz.base.errors import GazeboError
from libgz.simulation import state

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
SDF = ("gripper", "rover", "actors", "population")
PLUGINS = ("contact", "joint_pid", "diff_drive", "camera")
LEGACY = ("pioneer2at", "gripper", "simplesolids", "bandit", "truth")
ODD = (
    None,
    True,
    -1,
    0,
    2**40,
    -(2**70),
    1e308,
    float("nan"),
    float("inf"),
    "",
    "x",
    b"",
    b"\xff" * 9,
    (),
    [],
    {},
    (1,),
)


class Opened:
    """A value of a state that has others in it, opened up so that one of them can be replaced.

    Attributes:
        kind: a builtin type; `state` for what is encoded within, `json` for what the engine compresses.
        items: what is in it; of a dict (key, value) one after the other.
    """

    def __init__(self, kind: Any, items: list[Any]) -> None:
        self.kind, self.items = kind, items

    def closed(self) -> Any:
        """The value again, with what was replaced."""
        items = [item.closed() if isinstance(item, Opened) else item for item in self.items]
        if self.kind == "state":
            return state.encode(items[0])
        if self.kind == "json":
            return zlib.compress(json.dumps(items[0], default=str).encode(), 1)
        if self.kind is dict:
            return dict(zip(items[::2], items[1::2], strict=False))
        return self.kind(items)

    def places(self) -> Iterator[tuple[Opened, int]]:
        """All places of values in it."""
        for i, item in enumerate(self.items):
            yield self, i
            if isinstance(item, Opened):
                yield from item.places()


def opened(value: Any) -> Any:
    """A value with all containers in it opened."""
    if isinstance(value, memoryview):
        value = bytes(value)
    if isinstance(value, bytes):
        if value.startswith(state.FORMAT):
            return Opened("state", [opened(state.decode(value))])
        try:
            return Opened("json", [opened(json.loads(zlib.decompress(value)))])
        except (zlib.error, ValueError):
            return value
    if isinstance(value, dict):
        return Opened(dict, [opened(part) for pair in value.items() for part in pair])
    return Opened(type(value), list(map(opened, value))) if type(value) in (tuple, list) else value


def damage(rng: random.Random, data: bytes) -> tuple[bytes, str]:
    """A state with something wrong in it, and what that is."""
    tree = opened(data)
    holder, i = rng.choice(list(tree.places()))
    value = holder.items[i]
    if isinstance(value, Opened) and value.items and rng.random() < 0.7:
        items, at = value.items, rng.randrange(len(value.items))
        how = rng.choice(("drop", "double", "exchange"))
        if how == "drop":
            del items[at]
        elif how == "double":
            items.insert(at, items[at])
        else:
            items[at], items[-1] = items[-1], items[at]
    elif isinstance(value, bytes) and value and rng.random() < 0.8:
        at = rng.randrange(len(value))
        how = rng.choice(("flipped", "shorter", "longer"))
        flipped = value[:at] + bytes([value[at] ^ (1 << rng.randrange(8))]) + value[at + 1 :]
        holder.items[i] = {"flipped": flipped, "shorter": value[:at], "longer": value + value[at:]}[how]
    else:
        how = "replaced"
        holder.items[i] = rng.choice(ODD)
    try:
        return tree.closed(), f"{how} in {holder.kind}: {str(value)[:60]!r}"
    except (TypeError, ValueError, IndexError, GazeboError):  # no such dict, or not plain any more
        return data, "nothing"


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
