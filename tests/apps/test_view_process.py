"""The viewer of a server: it is started again, at the same address, if it dies."""

import os
import re
import signal
import time
from pathlib import Path

from view_pages import address_of, served

from libgz.apps.viewer_process import WELL


def viewer_of(process):
    """The process of a server's viewer."""
    tasks = Path(f"/proc/{process.pid}/task").iterdir()
    return max(int(child) for task in tasks for child in (task / "children").read_text().split())


def test_a_viewer_that_dies_is_started_again_with_its_address(wire):
    with served("-s", wire, "-d", 0, "pioneer2at") as (process, url):
        time.sleep(WELL + 0.5)
        os.kill(viewer_of(process), signal.SIGKILL)
        again = address_of(process)
    assert re.sub(r":\d+/", "/", again) == re.sub(r":\d+/", "/", url)  # the port may be taken for a moment
