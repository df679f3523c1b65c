"""libgz new: each folder it writes runs at once: its own tests, its client, mypy --strict, ruff."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from commands import run_libgz
from master_uri import free_master_uri

from libgz.apps.new import KINDS

ROOT = Path(__file__).parents[2]
# Name -> words of the command.
STARTERS = {"MyRobot": ["model", "MyRobot"]} | {f"my_{k}": ["plugin", "--kind", k, f"my_{k}"] for k in KINDS}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with one starter of each kind."""
    parent = tmp_path_factory.mktemp("starters") / "deep"
    for name, words in STARTERS.items():
        done = run_libgz("new", *words, "--in", parent)
        assert (done.returncode, done.stderr) == (0, "")
        assert f"cd {parent / name} && pytest" in done.stdout
    return parent


def run(command, folder, **environment):
    environment = {**os.environ, "GAZEBO_MASTER_URI": free_master_uri(), **environment}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_each_has_all_files_and_no_placeholder_is_left(folder):
    for name in STARTERS:
        files = {path.name for path in (folder / name).iterdir()}
        code, tests = ("MyRobot.py", "my_robot") if name == "MyRobot" else (f"{name}.py", name)
        assert files == {code, "README.md", "client.py", f"{tests}.world", f"test_{tests}.py"}
        for path in (folder / name).iterdir():
            assert "MyName" not in path.read_text()
            assert "my_name" not in path.read_text()
            assert path.name == "README.md" or path.name in (folder / name / "README.md").read_text()


def test_the_tests_of_all_pass(folder):
    out = run(
        [sys.executable, "-m", "pytest", "-q", "-ra", "--import-mode=importlib", "-p", "no:cacheprovider"], folder
    )
    assert "10 passed" in out, out


@pytest.mark.trial
def test_type_checkers_and_ruff_accept_all(folder):
    mypy = [sys.executable, "-m", "mypy", "--strict", "--explicit-package-bases"]
    run([*mypy, "--cache-dir", str(ROOT / "build" / "mypy_programs"), "."], folder)
    ruff = [sys.executable, "-m", "ruff"]
    config = ["--config", str(ROOT / "pyproject.toml"), "--ignore", "D,S101,T20"]
    run([*ruff, "check", "--no-cache", *config, "."], folder)
    run([*ruff, "format", "--check", "--no-cache", *config[:2], "."], folder)


@pytest.mark.parametrize("name", ["MyRobot", "my_world", "my_model", "my_sensor"])
def test_the_worlds_have_no_errors_or_warnings(folder, name):
    world = next((folder / name).glob("*.world"))
    command = ["check", "--strict"] if name == "MyRobot" else ["sdf", "--check"]
    done = run_libgz(*command, world)
    assert (done.returncode, done.stderr) == (0, "")


# What the client of each prints, and what the server does: (words for the client, its output, the server's output).
CLIENTS = {
    "my_world": (["0.25"], "a ball every 0.25 s\n", "a ball every 0.25 s\n"),
    "my_model": (["-0.5"], "the box moves at -0.5 m/s\n", "box moves at -0.5 m/s\n"),
    "my_sensor": (["4"], "near: 1.", "near: 1."),
    "my_system": (["2"], " s\n", "default: 1.0 s\n"),
    "my_visual": (["0", "1", "0"], "the lamp blinks in 0.0 1.0 0.0\n", ""),
}


@pytest.mark.parametrize(
    "name", ["my_model", *(pytest.param(n, marks=pytest.mark.trial) for n in CLIENTS if n != "my_model")]
)
def test_the_client_and_the_server_meet(folder, name, tmp_path):
    words, printed, logged = CLIENTS[name]
    plugin = ["-s", f"lib{name}.so"] if name == "my_system" else []
    environment = {**os.environ, "GAZEBO_MASTER_URI": free_master_uri(), "GAZEBO_PLUGIN_PATH": str(folder / name)}
    command = [sys.executable, "-m", "libgz.apps.gzserver", "--verbose", *plugin, str(folder / name / f"{name}.world")]
    log = tmp_path / "log"
    with log.open("w") as out, subprocess.Popen(command, stdout=out, stderr=out, env=environment) as server:
        client = [sys.executable, str(folder / name / "client.py"), *words]
        done = subprocess.run(client, capture_output=True, text=True, timeout=60, env=environment)
        end = time.monotonic() + 30.0
        while logged not in log.read_text() and time.monotonic() < end:
            time.sleep(0.05)
        server.terminate()
    assert done.returncode == 0, done.stderr
    assert printed in done.stdout
    assert logged in log.read_text()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["model", "2x"], "'2x' is not a name: a name has letters"),
        (["model", "my-robot"], "did you mean 'my_robot'?"),
        (["model", "Pioneer2AT"], "is a model of libgz: see `libgz models Pioneer2AT`"),
        (["plugin", "--kind", "world", "socket"], "'socket' has a meaning of its own"),
        (["plugin", "--kind", "world", "Class"], "'Class' has a meaning of its own"),
        (["model", "../up"], "did you mean 'up'?"),
    ],
)
def test_names_that_cannot_be(words, message, tmp_path):
    done = run_libgz("new", *words, "--in", tmp_path)
    assert done.returncode == 1
    assert message in done.stderr
    assert not list(tmp_path.iterdir())


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "MyRobot").mkdir()
    done = run_libgz("new", "model", "MyRobot", "--in", tmp_path)
    assert done.returncode == 1
    assert "MyRobot exists; choose another name" in done.stderr
    assert not list((tmp_path / "MyRobot").iterdir())
    (tmp_path / "file").touch()
    done = run_libgz("new", "model", "Other", "--in", tmp_path / "file")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("libgz: cannot write ")


def test_kinds_are_suggested():
    done = run_libgz("new", "plugin", "--kind", "wrld", "x")
    assert done.returncode == 2
    assert "did you mean 'world'?" in done.stderr
