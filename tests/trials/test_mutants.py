"""Trials of mutated files: each gives a loaded world or one GazeboError that names the file."""

import os
import random
import re
import shlex
from collections.abc import Callable

import pytest
from forked import Failure, note, run_trials
from mutants import OWN_NAME, mutant
from readers import ASSETS, SAVED, TEXT, problem, seeds, warm
from sample_files import SETTINGS, sample
from trials.table import trial

from libgz import World
from libgz.rendering.choice import prefer

pytestmark = pytest.mark.trial

SEED = int(os.environ.get("TRIAL_SEED") or random.SystemRandom().randrange(1 << 32))
WORLDS = int(os.environ.get("TRIAL_WORLDS") or 100_000)  # of both eras together, and of robots in macros
ASSET_COUNT = int(os.environ.get("TRIAL_ASSETS") or 10_000)  # of each kind
FURTHER = f"TRIAL_SEEDS={shlex.quote(os.environ['TRIAL_SEEDS'])} " if os.environ.get("TRIAL_SEEDS") else ""
FIRST = int(os.environ.get("TRIAL_FIRST") or 0)  # number of the first mutant
PROCESSES = int(os.environ.get("TRIAL_PROCESSES") or os.cpu_count() or 1)
SHOWN = 12  # failures in a message


@pytest.fixture(scope="module", autouse=True)
def warmed():
    """Import all that worlds need, so that the forked processes need not."""
    prefer("none")
    warm()
    yield
    prefer("auto")


def check(action: Callable[[int], str], count: int, name: str, repeat: str) -> None:
    with trial(f"mutated {name}") as row:
        row.seed, row.count = SEED, count
        found = list(run_trials(action, range(FIRST, FIRST + count), PROCESSES))
        # A loaded world may hold dozens of shapes in one place: ODE's step takes as long as their contacts need.
        slow = [failure for failure in found if failure.during == "stepping" and "longer than" in failure.what]
        failures = [failure for failure in found if failure not in slow]
        late = [failure for failure in failures if failure.first is not None]
        row.result = f"{len(failures)} failures, {len(late)} after others only; {len(slow)} slow steps"
        kinds = {re.sub(r"\d+", "0", failure.what): failure for failure in failures}  # one of each
        shown = "\n".join(f"--- number {f.number}{batch(f)}: {f.what}" for f in list(kinds.values())[:SHOWN])
        assert not failures, f"{row.result} of {count}; {repeat} repeats one\n{shown}"


def batch(failure: Failure) -> str:
    """What repeats a failure that passes alone."""
    return "" if failure.first is None else f", in one process from number {failure.first} on"


def after_load(world: World) -> None:
    """Make one step."""
    note("stepping")
    world.step(1)


@pytest.mark.parametrize("era", ["legacy", "sdf", "xacro"])
def test_mutated_worldfiles_load_or_name_file_and_line(era, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sources = seeds(era)
    donors = [*sources, *seeds("sdf")]

    def action(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}" / OWN_NAME
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(mutant(SEED, number, sources[number % len(sources)], text=True, donors=donors))
        return problem(era, path, after_load)

    repeat = f"{FURTHER}TRIAL_SEED={SEED} TRIAL_WORLDS=2 TRIAL_FIRST=NUMBER make trials"
    check(action, (WORLDS + 1) // 2, f"{era} worldfiles", repeat)


@pytest.mark.parametrize("kind", SAVED)
def test_mutated_logs_and_states_are_read_or_refused(kind, tmp_path):
    sources = seeds(kind)

    def action(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}.{kind}"
        path.write_bytes(mutant(SEED, number, sources[number % len(sources)], text=False))
        return problem(kind, path)

    check(action, ASSET_COUNT, kind, f"TRIAL_SEED={SEED} TRIAL_ASSETS=1 TRIAL_FIRST=NUMBER make trials")


@pytest.mark.parametrize("kind", SETTINGS)
def test_mutated_settings_are_read_or_refused(kind, tmp_path):
    sources = seeds(kind)

    def action(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}.{kind}"
        path.write_bytes(mutant(SEED, number, sources[number % len(sources)], text=True))
        return problem(kind, path)

    check(action, ASSET_COUNT, kind, f"TRIAL_SEED={SEED} TRIAL_ASSETS=1 TRIAL_FIRST=NUMBER make trials")


@pytest.mark.parametrize("kind", ASSETS)
def test_mutated_assets_load_or_name_the_file(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def action(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}.{kind}"
        path.write_bytes(mutant(SEED, number, sample(kind, number), text=kind in TEXT))
        return problem(kind, path, after_load)

    check(action, ASSET_COUNT, kind, f"TRIAL_SEED={SEED} TRIAL_ASSETS=1 TRIAL_FIRST=NUMBER make trials")
