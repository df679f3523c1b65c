"""Gazebo itself beside the recorded values: builds the plugin of `classic_values` where Gazebo 11 is, and compares.

    RECORD=1 .venv/bin/pytest tests/trials/test_classic_values.py

writes what it returns to tests/data/classic_values.
"""

import gzip
import json
import os
import shutil
import subprocess

import classic_values
import pytest

pytestmark = pytest.mark.skipif(shutil.which("gzserver") is None, reason="needs Gazebo 11 with its headers")
SECONDS = 600


@pytest.fixture(scope="module")
def plugin(tmp_path_factory):
    """The folder of the compiled plugin."""
    folder = tmp_path_factory.mktemp("plugin")
    (folder / "probe.cc").write_text(classic_values.cxx_source())
    flags = subprocess.run(["pkg-config", "--cflags", "gazebo"], capture_output=True, text=True, check=True).stdout
    command = ["c++", "-w", "-std=c++17", "-shared", "-fPIC", "probe.cc", "-o", "libprobe.so", *flags.split()]
    subprocess.run(command, cwd=folder, check=True, timeout=SECONDS)
    return folder


def rounded(value, digits):
    if isinstance(value, list):
        return [rounded(one, digits) for one in value]
    return round(float(f"{value:.{digits}g}"), digits) if isinstance(value, float) else value


@pytest.mark.parametrize("name", classic_values.SCENES)
def test_gazebo_returns_what_was_recorded(name, plugin, tmp_path):
    scene = classic_values.SCENES[name]
    world, out = tmp_path / "w.world", tmp_path / "out.json"
    world.write_text(scene.text)
    where = {"GAZEBO_PLUGIN_PATH": str(plugin), "PROBE_OUT": str(out), "PROBE_SCENE": name, "HOME": str(tmp_path)}
    where |= {"GAZEBO_MASTER_URI": "http://127.0.0.1:11399", "GAZEBO_MODEL_DATABASE_URI": ""}
    subprocess.run(["gzserver", "-u", "--seed", "1", str(world)], env=os.environ | where, check=True, timeout=SECONDS)
    found = json.loads(out.read_text())
    kept = classic_values.RECORDED / f"{name}.json.gz"
    if os.environ.get("RECORD"):
        digits, last = (11 if scene.tolerance < 1e-8 else 5), {}
        steps = []
        for step in found:
            steps.append({})
            for when in ("now", "then"):
                new = {key: rounded(value, digits) for key, value in step[when].items()}
                steps[-1][when] = {key: value for key, value in new.items() if key not in last or last[key] != value}
                last |= new
        text = json.dumps(steps, separators=(",", ":"))
        kept.write_bytes(gzip.compress(text.encode(), 9, mtime=0))
    if kept.is_file():
        recorded = classic_values.read_recorded(name)
        assert not list(classic_values.differences(scene, recorded, found))
