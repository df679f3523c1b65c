"""The worlds of tests/beside in the real Gazebo 11.1, asked again, and by a C++ plugin in both servers.

LIBGZ_BENCH_GAZEBO names a root directory in which Gazebo 11.1, its headers, g++ and Xvfb are installed; as root, for
chroot. LIBGZ_BENCH_PLUGINS names a folder with plugins that were compiled for libgz, by the names in the worlds: then
they run there, and not the ready ones. LIBGZ_BENCH_GAZEBO_PLUGINS names a folder in the root with those of them that do
not come with Gazebo. With LIBGZ_RECORD=1 what Gazebo says is written to tests/data/beside.tsv.
"""

import math
import os
import subprocess
import sys

import pytest
from beside.kinds import KINDS
from beside.machines import MACHINES
from beside.runs import PLUGIN, RECORDED, RealGazebo, followed, run_server, write_files
from beside.scenes import ROBOTS, SCENES
from beside.worlds import WORLDS

ROOT = os.environ.get("LIBGZ_BENCH_GAZEBO", "")
COMPILED = os.environ.get("LIBGZ_BENCH_PLUGINS", "")
pytestmark = [
    pytest.mark.trial,
    pytest.mark.skipif(not ROOT, reason="LIBGZ_BENCH_GAZEBO names no root with Gazebo 11.1"),
]
TRIES = 3  # Gazebo's JointControl has its commands from another thread, at once or some iterations later


def apart(one, other):
    return max(math.dist(one[link][:3], other[link][:3]) for link in one)


def test_worlds_beside_the_real_gazebo(tmp_path, monkeypatch):
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    subprocess.run(
        [sys.executable, "-m", "libgz", "cxx", "build", str(PLUGIN), "-o", str(tmp_path / "libfollow.so")], check=True
    )
    gazebo, lines, far = RealGazebo(ROOT, os.environ.get("LIBGZ_BENCH_GAZEBO_PLUGINS", "")), [], {}
    for name, world in {**WORLDS, **SCENES, **ROBOTS, **KINDS, **MACHINES}.items():
        write_files(world, tmp_path)
        served = run_server(world, tmp_path, f"{tmp_path}:{COMPILED}")
        ours = served if world.compiled else followed(world)
        there = gazebo.poses(world)
        for _ in range(TRIES):
            if apart(there, ours) < world.tolerance:
                break
            there = gazebo.poses(world)
        lines += ["\t".join([name, link, *(f"{number:.12g}" for number in numbers)]) for link, numbers in there.items()]
        print(f"{name:28} {apart(there, ours):.1e} m, by C++ {apart(there, served):.1e} m, of {world.tolerance:g} m")
        if not max(apart(there, ours), apart(there, served)) < world.tolerance:
            far[name] = apart(there, ours), apart(there, served)
    if os.environ.get("LIBGZ_RECORD"):
        RECORDED.write_text("\n".join(lines) + "\n")
    assert not far
