"""Upgraded worlds move as before: those of libgz, and those in the folders that TRIAL_OLD_WORLDS names."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest

from libgz import World
from libgz.sdf.conversion import upgrade_document
from libgz.sdf.recognition import is_sdf
from libgz.worldfile.file import WorldFile
from libgz.worldfile.upgrade import upgrade

pytestmark = pytest.mark.trial

ROOT = Path(__file__).parents[2]
NAMED = [Path(name) for name in os.environ.get("TRIAL_OLD_WORLDS", "").split(":") if name]
FILES = sorted(path for folder in (ROOT / "worlds", ROOT / "examples", *NAMED) for path in folder.rglob("*.world"))


def motion(path: Path) -> bytes:
    """Places of all bodies in 1000 steps, to the bit; -0 is 0."""
    frames = []
    with World.from_file(path) as world:
        for _ in range(20):
            world.step(50)
            frames += [[*body.GetPose().pos, *body.GetPose().rot] for body in world.engine.bodies.values()]
    return (np.array(frames) + 0.0).tobytes()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_an_upgraded_world_moves_as_before(path: Path, tmp_path: Path) -> None:
    if is_sdf(path):
        text, changes = upgrade_document(path.read_bytes(), str(path), path)
    else:
        text, changes = upgrade(WorldFile.from_file(path))
    if not changes:
        return
    folder = shutil.copytree(path.parent, tmp_path / "world")
    before = motion(folder / path.name)
    (folder / path.name).write_bytes(text)
    assert motion(folder / path.name) == before
