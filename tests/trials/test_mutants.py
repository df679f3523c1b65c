"""Trials of mutated files: each gives a loaded world or one GazeboError that names the file."""

import os
import random
import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from forked import note, run_trials
from mutants import mutant
from sample_files import sample, worlds

from libgz import GazeboError, GzVector, World
from libgz.errors import UNFORESEEN
from libgz.files import installed_worlds
from libgz.models.greyimage import read_grey
from libgz.models.gzb import read_gzb
from libgz.models.roadfile import read_road
from libgz.ode.native_step import NativeStep
from libgz.physics.mesh_files import read_mesh
from libgz.rendering.context import prefer
from libgz.rendering.image import read_image
from libgz.rendering.skin import read_skin

pytestmark = pytest.mark.trial

ROOT = Path(__file__).parent.parent.parent
SEED = int(os.environ.get("TRIAL_SEED") or random.SystemRandom().randrange(1 << 32))
WORLDS = int(os.environ.get("TRIAL_WORLDS") or 100_000)  # legacy and SDF together
ASSETS = int(os.environ.get("TRIAL_ASSETS") or 10_000)  # of each kind
FIRST = int(os.environ.get("TRIAL_FIRST") or 0)  # number of the first mutant
PROCESSES = int(os.environ.get("TRIAL_PROCESSES") or os.cpu_count() or 1)
SHOWN = 12  # failures in a message

# Where each kind of asset stands in a world, and what reads it.
GEOMETRY = (
    "<sdf version='1.6'><model name='m'><static>1</static><link name='l'>"
    "<collision name='c'><geometry>{}</geometry></collision></link></model></sdf>"
)
LEGACY = "<gz:world xmlns:gz='g' xmlns:model='m'>{}</gz:world>"
HEIGHTS = "<heightmap><uri>{0}</uri><size>10 10 1</size></heightmap>"
MESH = "<mesh><uri>{0}</uri></mesh>"
ASSET_WORLDS = {
    "3ds": LEGACY.format("<model:SimpleSolid><skinFile>{0}</skinFile></model:SimpleSolid>"),
    "gzb": LEGACY.format("<model:Terrain><terrainFile>{0}</terrainFile></model:Terrain>"),
    "road": LEGACY.format("<model:Road><roadFile>{0}</roadFile></model:Road>"),
    **dict.fromkeys(("stl", "obj", "dae"), GEOMETRY.format(MESH)),
    **dict.fromkeys(("ppm", "png"), GEOMETRY.format(HEIGHTS)),
    "jpeg": LEGACY.format("<model:Terrain><dataFile>{0}</dataFile></model:Terrain>"),
}
READERS: dict[str, list[Callable[[Path], object]]] = {
    "3ds": [read_skin],
    "gzb": [read_gzb],
    "road": [lambda path: read_road(path, GzVector())],
    **{kind: [read_mesh] for kind in ("stl", "obj", "dae")},
    **{kind: [read_image, read_grey] for kind in ("ppm", "png", "jpeg")},
}


@pytest.fixture(scope="module", autouse=True)
def warmed():
    """Import all that worlds need, so that the forked processes need not."""
    prefer("none")
    with World() as world:  # ODE's assertions end the process where the step is in Python
        assert isinstance(world.engine.step_form, NativeStep), "the trials need the native step"
    for path in (*worlds(installed_worlds(), b"gz:world"), ROOT / "tests" / "data" / "worlds" / "everything.sdf"):
        load(path)
    yield
    prefer("auto")


def load(path: Path) -> None:
    """Load a world and make one step."""
    with World.from_file(path) as world:
        note("stepping")
        world.step(1)


def complaint(path: Path, action: Callable[[Path], object], line: bool = False) -> str:
    """What is wrong with how a file is read; an empty string if it is read, or refused as it should be."""
    try:
        action(path)
    except GazeboError as error:
        text = str(error)
        if UNFORESEEN in text or "Load failed with" in text or "Init failed with" in text:
            return text[:2000]
        if not (re.match(r".+:\d+: ", text) if line else path.name in text):
            return f"the message names no {'line' if line else 'file'}: {text[:2000]}"
    return ""


def check(trial: Callable[[int], str], count: int, name: str, repeat: str) -> None:
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout
    label = f"{name}: seed {SEED}, commit {commit.strip() or 'unknown'}"
    found = list(run_trials(trial, range(FIRST, FIRST + count), PROCESSES))
    # A world that is loaded may hold dozens of shapes in one place: ODE's step takes as long as their contacts need.
    slow = [failure for failure in found if failure.during == "stepping" and "longer than" in failure.what]
    failures = [failure for failure in found if failure not in slow]
    print(f"\n{label}: {count} mutants, {len(failures)} failures, {len(slow)} slow steps", flush=True)
    kinds = {re.sub(r"\d+", "0", failure.what): failure for failure in failures}  # one of each
    shown = "\n".join(f"--- number {f.number}: {f.what}" for f in list(kinds.values())[:SHOWN])
    assert not failures, f"{label}: {len(failures)} of {count} fail; {repeat} repeats the first\n{shown}"


@pytest.mark.parametrize("era", ["legacy", "sdf"])
def test_mutated_worldfiles_load_or_name_file_and_line(era, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if era == "legacy":
        files = worlds(installed_worlds(), b"gz:world")
    else:
        files = [ROOT / "tests" / "data" / "worlds" / "everything.sdf"] * 8
        files += worlds(ROOT / "examples", b"<sdf")
    sources = [path.read_bytes() for path in files]

    def trial(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}.world"
        path.write_bytes(mutant(SEED, number, sources[number % len(sources)], text=True))
        return complaint(path, load, line=True)

    repeat = f"TRIAL_SEED={SEED} TRIAL_WORLDS=2 TRIAL_FIRST=NUMBER make trials"
    check(trial, (WORLDS + 1) // 2, f"{era} worldfiles", repeat)


@pytest.mark.parametrize("kind", ["3ds", "gzb", "road", "ppm", "png", "jpeg", "stl", "obj", "dae"])
def test_mutated_assets_load_or_name_the_file(kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def trial(number: int) -> str:
        path = tmp_path / f"m{os.getpid()}.{kind}"
        path.write_bytes(mutant(SEED, number, sample(kind, number), text=kind in ("road", "obj", "dae")))
        for reader in READERS[kind]:
            found = complaint(path, reader)
            if found and kind != "road":
                return found
        world = tmp_path / f"w{os.getpid()}.world"
        world.write_text(ASSET_WORLDS[kind].format(path.name))
        return complaint(world, load, line=True)

    check(trial, ASSETS, kind, f"TRIAL_SEED={SEED} TRIAL_ASSETS=1 TRIAL_FIRST=NUMBER make trials")
