"""The installed commands: each launches its module."""

import gc
import os
import signal
import subprocess
import sys
from importlib import import_module, metadata
from pathlib import Path

import pytest

from libgz.apps.launch import importing

COMMANDS = ["gazebo", "gz", "gzclient", "gzserver", "libgz"]
INTERRUPT = "import os, signal; os.kill(os.getpid(), signal.SIGINT)\n"


@pytest.fixture(autouse=True)
def own_handler():
    """Ctrl-C ends the tests as before: after a command it ends the process at once."""
    before = signal.getsignal(signal.SIGINT)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("name", COMMANDS)
def test_an_installed_command_runs_its_module_with_garbage_collection(name, monkeypatch):
    seen = []
    module = import_module(f"libgz.apps.{name}")
    monkeypatch.setattr(module, "main", lambda: seen.append(gc.isenabled()) or 7)
    (entry,) = metadata.entry_points(group="console_scripts", name=name)
    try:
        assert entry.load()() == 7
    finally:
        gc.unfreeze()
    assert seen == [True]


def test_imports_are_not_searched_for_garbage():
    with importing():
        assert not gc.isenabled()
    try:
        assert gc.isenabled()
        assert gc.get_freeze_count() > 1000
    finally:
        gc.unfreeze()


def interrupted(words, folder, module):
    """Run a command with a module that raises SIGINT while it is imported; (exit code, what it printed)."""
    (folder / f"{module}.py").write_text(f"try:\n    {INTERRUPT}except BaseException:\n    pass\n")
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        words, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path}, cwd=folder, timeout=60
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("name", COMMANDS)
def test_an_interrupt_while_a_command_is_imported(name, tmp_path):
    """Even a module that catches all exceptions does not keep the command from ending."""
    command = Path(sys.executable).with_name(name)
    assert interrupted([command], tmp_path, "argparse") == (130, "")


@pytest.mark.parametrize(("ignored", "code"), [("", 130), ('trap "" INT; ', 0)])
def test_an_interrupt_while_a_command_exits(ignored, code, tmp_path):
    """Python calls functions of `atexit` and joins threads after the command's end.

    A shell without job control starts commands in the background with an ignored SIGINT.
    """
    (tmp_path / "sitecustomize.py").write_text(f"import atexit\natexit.register(lambda: exec({INTERRUPT!r}))\n")
    done = subprocess.run(
        ["sh", "-c", f'{ignored}exec "$@"', "sh", Path(sys.executable).with_name("libgz"), "--version"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        timeout=60,
    )
    assert (done.returncode, done.stderr) == (code, "")
    assert done.stdout.startswith("libgz ")
