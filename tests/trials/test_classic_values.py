"""Gazebo itself beside the recorded values: the plugin of `classic_values` runs in the real Gazebo 11.1.

LIBGZ_BENCH_GAZEBO names a root directory in which Gazebo 11.1, its headers and g++ are installed; as root, for chroot.
With LIBGZ_RECORD=1 what Gazebo returns is written to tests/data/classic_values.
"""

import gzip
import json
import os
import subprocess
from pathlib import Path

import classic_values
import pytest

ROOT = os.environ.get("LIBGZ_BENCH_GAZEBO", "")
pytestmark = [
    pytest.mark.trial,
    pytest.mark.skipif(not ROOT, reason="LIBGZ_BENCH_GAZEBO names no root with Gazebo 11.1"),
]
FOLDER = "/values"  # in the root
SECONDS = 600


def run(command, **variables):
    """A command in the root's folder."""
    variables = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp", **variables}
    inside = ["chroot", ROOT, "sh", "-c", f"cd {FOLDER} && {command}"]
    subprocess.run(inside, env=variables, check=True, timeout=SECONDS)


@pytest.fixture(scope="module")
def folder():
    """The folder with the compiled plugin."""
    found = Path(ROOT + FOLDER)
    found.mkdir(exist_ok=True)
    (found / "probe.cc").write_text(classic_values.cxx_source())
    run("g++ -w -std=c++17 -shared -fPIC probe.cc -o libprobe.so $(pkg-config --cflags gazebo)")
    return found


def rounded(value, digits):
    """A value as it is recorded; what is hardly less than infinite is infinite."""
    if isinstance(value, list):
        return [rounded(one, digits) for one in value]
    return round(float(f"{value:.{digits}g}"), digits) if isinstance(value, float) else value


@pytest.mark.parametrize("name", classic_values.SCENES)
def test_gazebo_returns_what_was_recorded(name, folder):
    scene, out = classic_values.SCENES[name], folder / "out.json"
    (folder / "w.world").write_text(scene.text)
    out.unlink(missing_ok=True)
    where = {"GAZEBO_PLUGIN_PATH": FOLDER, "PROBE_OUT": f"{FOLDER}/out.json", "PROBE_SCENE": name}
    where |= {"GAZEBO_MASTER_URI": "http://127.0.0.1:11399", "GAZEBO_MODEL_DATABASE_URI": ""}
    run("gzserver -u --seed 1 w.world", **where)
    digits = 11 if scene.tolerance < 1e-8 else 5
    found = [
        {when: {key: rounded(value, digits) for key, value in step[when].items()} for when in ("now", "then")}
        for step in json.loads(out.read_text())
    ]
    kept = classic_values.RECORDED / f"{name}.json.gz"
    if os.environ.get("LIBGZ_RECORD"):
        last, steps = {}, []
        for step in found:
            steps.append({})
            for when in ("now", "then"):
                steps[-1][when] = {k: value for k, value in step[when].items() if k not in last or last[k] != value}
                last |= step[when]
        kept.write_bytes(gzip.compress(json.dumps(steps, separators=(",", ":")).encode(), 9, mtime=0))
    if kept.is_file():  # what differs by nature is not: screws, gyroscopic torques
        assert not list(classic_values.differences(scene, classic_values.read_recorded(name), found))
