"""Worlds for long, many, changing, repeated and in several threads.

TRIAL_SHARE scales the counts: 1 is the whole trial, 0.02 half an hour of the day of simulated time.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from trials import legacy_runs
from trials.table import trial

from libgz.base.files import installed_worlds

pytestmark = pytest.mark.trial

SHARE = float(os.environ.get("TRIAL_SHARE") or 1.0)
DAY = 24.0  # [h]
WORLDS = (
    "pioneer2at", "pioneer2dx", "gripper", "ptz", "segwayrmp", "shrimp", "wheelchair", "carchassis", "clodbuster",
    "bandit", "blimp", "terrain", "heightmap", "map", "road", "pioneer2sonars", "gps", "truth",
)  # fmt: skip


def scaled(count: int, least: int) -> int:
    return max(least, round(count * SHARE))


def run(*words: object, **environment: str) -> dict[str, Any]:
    """The figures of a run in a process of its own."""
    command = [sys.executable, legacy_runs.__file__, *map(str, words)]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment}, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    figures: dict[str, Any] = json.loads(done.stdout)
    figures["errors"] = [line for line in done.stderr.splitlines() if "ERROR" in line or "Traceback" in line]
    return figures


def test_a_day_of_ten_robots_with_lasers_and_a_camera():
    hours = max(0.1, DAY * SHARE)
    with trial(f"{hours:g} h, ten robots, lasers, a camera") as row:
        found = run("long", hours, row.seed)
        row.count = found["steps"]
        row.result = f"memory {found['growth']:+.2%}, {found['steps'] / found['seconds']:.0f} steps/s"
        assert found["iterations"] == found["steps"]
        assert found["sim_time"] == pytest.approx(hours * 3600.0, abs=1e-6)
        expected = {name: found["steps"] // (50 if name == "eye" else 5) for name in found["ticks"]}
        assert found["ticks"] == expected
        assert found["stopped"] == found["errors"] == []
        assert found["growth"] < 0.01


def test_loads_and_closes(wire):
    with trial("loads and closes") as row:
        row.count = scaled(1000, 56)
        found = run("loads", row.count, row.seed, TRIAL_SERVER=str(wire))
        row.result = f"memory {found['growth']:+.2%}"
        assert (found["files"], found["threads"], found["errors"]) == (0, 0, [])
        assert found["growth"] < 0.02


@pytest.mark.parametrize("era", ["legacy", "sdf"])
def test_inserts_and_deletes(wire, era):
    with trial(f"inserts and deletes, {era}") as row:
        row.count = scaled(5000, 200)
        found = run("inserts" if era == "legacy" else "sdf", row.count, row.seed, TRIAL_SERVER=str(wire))
        row.result = f"memory {found['growth']:+.2%}"
        before, after = found["tables"]
        assert after == before
        assert (found["files"], found["errors"]) == (0, [])
        assert found["growth"] < 0.02


@pytest.mark.parametrize("name", WORLDS)
def test_reruns_are_bit_identical_in_processes_and_without_native_code(name):
    with trial(f"reruns of {name}.world") as row:
        steps = scaled(5000, 200)
        path = installed_worlds() / f"{name}.world"
        found = [run("digest", path, steps, row.seed)["digest"] for _ in range(2)]
        row.count = 3 * steps
        row.result = found[0][:12]
        assert len(set(found)) == 1


def test_two_worlds_in_two_threads_are_independent():
    with trial("two worlds in two threads") as row:
        steps = scaled(5000, 200)
        for k, names in enumerate(zip(WORLDS, (*WORLDS[1:], WORLDS[0]), strict=True)):
            paths = [installed_worlds() / f"{name}.world" for name in names]
            alone = [legacy_runs.digest(path, steps, row.seed + k) for path in paths]
            together: dict[Path, str] = {}

            def simulate(path: Path, found: dict[Path, str] = together, seed: int = row.seed + k) -> None:
                found[path] = legacy_runs.digest(path, steps, seed)

            threads = [threading.Thread(target=simulate, args=(path,)) for path in paths]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            assert [together.get(path) for path in paths] == alone, names
            row.count += 2
        row.result = f"{steps} steps each, as alone"
