"""Loads that take long: a line on the terminal, and signals that end them."""

import io
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from libgz.apps import progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_long_load_is_shown_on_a_terminal_only(monkeypatch):
    monkeypatch.setattr(progress, "PATIENCE", 0.02)
    monkeypatch.setattr(progress, "PERIOD", 0.01)
    terminal, pipe = Terminal(), io.StringIO()
    for stream in (terminal, pipe):
        with progress.show_loading(Path("big.world"), object(), stream):
            time.sleep(0.3)
    assert "loading big.world: 0 s, reading; Ctrl-C ends it" in terminal.getvalue()
    assert terminal.getvalue().endswith(" \r")  # the line is erased
    assert pipe.getvalue() == ""


def test_a_short_load_shows_nothing():
    terminal = Terminal()
    with progress.show_loading(Path("small.world"), object(), terminal):
        pass
    assert terminal.getvalue() == ""


SLOW = """
import time
from libgz import GZ_REGISTER_PLUGIN, Body, Model

class Slow(Model):
    def Load(self, file, node):
        print("ready", flush=True)
        self.AddBody(Body(self.world), True)
        for _ in range(3000):
            time.sleep(0.01)

GZ_REGISTER_PLUGIN("Slow", Slow)
"""
READY = """
from libgz.classic import *

class Ready(SystemPlugin):
    def Load(self, argc=0, argv=None):
        print("ready", flush=True)

GZ_REGISTER_SYSTEM_PLUGIN(Ready)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("command", ["gazebo", "gzserver"])
def test_a_signal_ends_a_load_and_leaves_no_files(command, number, tmp_path, wire):
    world = tmp_path / "long.world"
    if command == "gazebo":
        (tmp_path / "Slow.py").write_text(SLOW)
        world.write_text(
            "<gz:world xmlns:gz='g' xmlns:model='m'><model:Slow><plugin>Slow.py</plugin></model:Slow></gz:world>"
        )
        arguments = ["-s", str(wire)]
    else:
        (tmp_path / "Ready.py").write_text(READY)
        many = "".join(f"<unknown{i}/>\n" for i in range(400_000))
        world.write_text(f"<sdf version='1.6'><world name='w'>{many}</world></sdf>")
        arguments = ["-s", "Ready.py", "--server-id", str(wire)]
    process = subprocess.Popen(
        [sys.executable, "-m", f"libgz.apps.{command}", *arguments, str(world)],
        env={**os.environ, "GAZEBO_MASTER_URI": "localhost:0"},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        cwd=tmp_path,
    )
    while b"ready" not in process.stdout.readline():  # `wire` checks that all files are removed
        assert process.poll() is None
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(number)
    start = time.monotonic()
    output, _ = process.communicate(timeout=60.0)
    assert time.monotonic() - start < 15.0
    assert b"Traceback" not in output
    assert process.returncode == 128 + number


def test_a_second_signal_ends_a_load_that_does_not_obey(tmp_path, wire):
    """A plugin's `Load` in a native function, during which Python runs no signal handler."""
    (tmp_path / "Busy.py").write_text(
        "import ctypes\nfrom libgz import GZ_REGISTER_PLUGIN, Model\nclass Busy(Model):\n"
        "    def Load(self, file, node):\n        print('busy', flush=True)\n"
        "        while True:\n            try:\n                ctypes.CDLL(None).sleep(60)\n"
        "            except BaseException:\n                pass\n"
        "GZ_REGISTER_PLUGIN('Busy', Busy)\n"
    )
    world = tmp_path / "busy.world"
    world.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:Busy><plugin>Busy.py</plugin></model:Busy></gz:world>"
    )
    command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", str(wire), str(world)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout.readline() == b"busy\n"
    process.send_signal(signal.SIGTERM)
    time.sleep(0.5)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=10.0)
    assert process.returncode == 143
