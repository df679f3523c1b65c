"""The command gz, and `gazebo` with worlds of SDF: as those of Gazebo classic."""

import os
import sys

import pytest
from commands import run_command, spawn_command
from gzserver_process import new_environment

from libgz.apps.gazebo import _is_classic

SDF = "<sdf version='1.6'><world name='default'><model name='m'><link name='l'/></model></world></sdf>"
LEGACY = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/></gz:world>"


def gz(*words, **variables):
    return spawn_command("gz", *words, env={**os.environ, **variables})


def test_gz_has_the_subcommands_of_gazebo(tmp_path):
    (tmp_path / "w.world").write_text(SDF)
    done = gz("sdf", "--check", str(tmp_path / "w.world"), PATH="")
    assert (done.returncode, done.stdout.strip()) == (0, "Check complete"), done
    assert gz("help", PATH="").stdout.startswith("usage: gz [-h]")
    done = gz("camera", PATH="")
    assert (done.returncode, done.stderr.partition(":")[0]) == (2, "gz")
    assert "gz: 'sweep' is not a command" in gz("sweep", PATH="").stderr


def test_another_gz_on_the_path_goes_first(tmp_path):
    other = tmp_path / "gz"
    other.write_text('#!/bin/sh\necho other "$@"\n')
    other.chmod(0o755)
    assert gz("sdf", "--check", "x", PATH=str(tmp_path)).stdout == "other sdf --check x\n"
    other.write_text(f"#!/bin/sh\nexec {sys.executable} -m libgz.apps.gz help\n")  # one that leads back
    assert gz("sdf", PATH=str(tmp_path)).stdout.startswith("usage: gz")


@pytest.mark.parametrize(
    ("words", "classic"),
    [
        ("w.sdf", True),
        ("w.sdf --verbose --iters 10", True),
        ("-u w.sdf", True),
        ("-s libsystem.so w.sdf", True),
        ("-s 3 w.sdf", False),
        ("-s3 w.sdf", False),
        ("-s auto w.sdf", False),
        ("-n w.sdf", False),
        ("--rate=2 w.sdf", False),
        ("w.world", False),
        ("--verbose w.world", False),
        ("none.world", False),
        ("worlds/empty.world", True),
        ("pioneer2at", False),
        ("--verbose", True),
        ("-h", False),
        ("-v", False),
        ("", False),
    ],
)
def test_the_file_decides_which_era_gazebo_is_of(words, classic, tmp_path, monkeypatch):
    (tmp_path / "w.sdf").write_text(SDF)
    (tmp_path / "w.world").write_text(LEGACY)
    monkeypatch.chdir(tmp_path)
    assert _is_classic(words.split()) is classic


def test_gazebo_runs_an_sdf_world_as_classic_does(tmp_path):
    (tmp_path / "my.world").write_text(SDF)
    words = (tmp_path / "my.world", "--verbose", "--iters", 10)
    done = run_command("gazebo", *words, env=new_environment(tmp_path))
    assert done.returncode == 0, done
    assert done.stderr.startswith("Gazebo multi-robot simulator, version")
    assert "[Msg] Connected to gazebo master" in done.stdout
