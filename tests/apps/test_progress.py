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


@pytest.mark.parametrize("command", ["gazebo", "gzserver"])
def test_an_interrupt_ends_a_load(command, tmp_path, wire):
    many = "".join(f"<unknown{i}/>\n" for i in range(400_000))
    legacy = f"<gz:world xmlns:gz='g'>{many}</gz:world>"
    world = tmp_path / "big.world"
    world.write_text(legacy if command == "gazebo" else f"<sdf version='1.6'><world name='w'>{many}</world></sdf>")
    free = {**os.environ, "GAZEBO_MASTER_URI": "localhost:0"}
    arguments = ["-s", str(wire)] if command == "gazebo" else ["--iters", "1"]
    process = subprocess.Popen(
        [sys.executable, "-m", f"libgz.apps.{command}", *arguments, str(world)], env=free, stderr=subprocess.PIPE
    )
    time.sleep(4.0)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    _, errors = process.communicate(timeout=60.0)
    assert time.monotonic() - start < 15.0
    assert b"Traceback" not in errors
