"""Processes that libgz starts do not import what lies in the current directory."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from libgz.base.files import installed_worlds
from libgz.base.python import environment, run_module, start_module

BIN = Path(sys.executable).parent
HOSTILE = "from pathlib import Path\nPath(__file__).with_suffix('.ran').touch()\nraise SystemExit('hostile')\n"
NAMES = ("json", "struct", "logging", "numpy", "pickle", "socket", "threading", "aiohttp", "mcap", "lxml", "libgz")
STUDY = """world = "pioneer2at"
duration = 0.1
seeds = 2
measures = {x = "crate/pos[0]"}
"""


def test_the_current_directory_is_not_searched(tmp_path):
    (tmp_path / "json.py").write_text(HOSTILE)
    done = subprocess.run(run_module("json.tool", "--help"), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "json.ran").exists()


@pytest.mark.parametrize("paths", [":{other}", "{other}:", ".::{other}", "./:beside:{other}", "", ":"])
def test_the_current_directory_is_not_searched_for_a_variable_either(paths, tmp_path, monkeypatch):
    """A part of PYTHONPATH that is empty means it, which is common where files of ROS have been sourced."""
    here, other, beside = (tmp_path / name for name in ("here", "other", "here/beside"))
    for folder in (here, other, beside):
        folder.mkdir()
    (here / "json.py").write_text(HOSTILE)
    monkeypatch.chdir(here)
    monkeypatch.setenv("PYTHONPATH", paths.format(other=other))
    monkeypatch.setenv("LIBGZ_TEST", "old")
    with start_module("json.tool", "--help", changes={"LIBGZ_TEST": "new"}, stdout=subprocess.DEVNULL) as process:
        pass
    assert process.returncode == 0
    assert not (here / "json.ran").exists()
    named = [str(folder) for folder in (beside, other) if folder.name in paths]
    assert environment().get("PYTHONPATH", "") == ":".join(named)


def test_a_container_searches_no_folder_of_a_volume_either():
    text = (Path(__file__).parents[2] / "Dockerfile").read_text()
    programs = re.findall(r'"python3", ("-\w+")', text)
    assert programs
    assert set(programs) == {'"-P"'}


@pytest.mark.parametrize(
    "words",
    [
        "gazebo -n --steps 20 --mcap log.mcap --view {world}",
        "libgz sweep study.toml -j 2",
        *(
            pytest.param(words, marks=pytest.mark.trial)  # tests/test_architecture.py sees that all start Python alike
            for words in (
                "gzserver --iters 20 --mcap log.mcap --view",
                "libgz demo --seconds 0.3",
                "libgz check {world}",
                "libgz view --timeout 0.1",
                "libgz doctor",
            )
        ),
    ],
)
def test_commands_run_in_a_hostile_folder(words, tmp_path, wire):
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(HOSTILE)
    (tmp_path / "study.toml").write_text(STUDY)
    program, *rest = words.format(world=installed_worlds() / "pioneer2at.world").split()
    environment = {**os.environ, "GAZEBO_MASTER_URI": "localhost:0", "HOME": str(tmp_path)}
    done = subprocess.run(
        [BIN / program, *rest], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120
    )
    assert "hostile" not in done.stdout + done.stderr, done
    assert [path.name for path in tmp_path.glob("*.ran")] == []
