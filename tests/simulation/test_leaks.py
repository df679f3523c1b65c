"""Worlds that were closed: nothing of them stays, and what is large goes at once, before Python collects cycles."""

import gc
import tracemalloc
from collections import Counter
from pathlib import Path

import pytest

import libgz
from libgz.base.files import installed_worlds

LARGE = 1e6  # [byte]


def open_files():
    found = []
    for entry in Path("/proc/self/fd").iterdir():
        try:
            found.append(str(entry.readlink()))
        except OSError:  # the directory itself, which was closed since
            continue
    return Counter(found)


def load_and_close(name, **options):
    with libgz.World.from_file(installed_worlds() / f"{name}.world", **options) as world:
        world.step(2)


@pytest.fixture
def no_collection():
    """Python collects no cycles meanwhile."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.parametrize(
    "name", ["pioneer2at", "pioneer2sonars", "factory", "gripper", "ptz", "stereohead", "truth", "wifi", "roomba"]
)
def test_a_closed_world_has_no_files_open(wire, no_collection, name):
    load_and_close(name, server_id=wire)
    before = open_files()
    load_and_close(name, server_id=wire)
    assert not open_files() - before


@pytest.mark.parametrize("name", ["ptz", "stereohead", "heightmap", "terrain", "road", "map"])
def test_a_closed_world_keeps_no_meshes_and_images(no_collection, name):
    load_and_close(name)
    tracemalloc.start()
    try:
        load_and_close(name)
        kept = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert kept < LARGE


def test_loads_and_closes_leave_no_objects():
    names = ("pioneer2at", "ptz", "gripper", "terrain", "factory")
    counts = []
    for _ in range(3):
        for name in names:
            load_and_close(name)
        gc.collect()
        counts.append(len(gc.get_objects()))
    assert counts[-1] <= counts[1] + 20
