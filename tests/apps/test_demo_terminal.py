"""`libgz demo` in a terminal: it shows the robot in a browser until Ctrl-C."""

import os
import pty
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip("aiohttp")


def test_in_a_terminal_the_demo_prints_an_address_first_and_serves_until_ctrl_c():
    ours, its = pty.openpty()
    words = [sys.executable, "-m", "libgz", "demo", "--view-port", "18680", "--seconds", "2"]
    with subprocess.Popen(words, stdin=its, stdout=its, stderr=its, start_new_session=True) as demo:
        os.close(its)
        said, end = b"", time.monotonic() + 120.0
        while b"until Ctrl-C" not in said:
            assert time.monotonic() < end
            said += os.read(ours, 4096)
        lines = said.decode().splitlines()
        assert lines[0].startswith("open http://127.0.0.1:18")
        assert sum(line.strip()[:1].isdigit() for line in lines) >= 8  # the table
        assert demo.poll() is None
        os.killpg(demo.pid, signal.SIGINT)
        assert demo.wait(30.0) == 0
    os.close(ours)
