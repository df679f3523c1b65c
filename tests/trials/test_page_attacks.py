"""Attacks on the port of a viewer that runs as users have it: it serves a page meanwhile, and holds little."""

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from view_pages import served
from view_sockets import Socket

from libgz.transport.server import free_server_id

pytestmark = pytest.mark.trial

STATES = 100  # that a page receives during each attack: 3 s on an idle machine
LARGEST = 200 << 20  # [byte] that the viewer may grow


ATTACKER = Path(__file__).parents[2] / "benchmarks" / "page_attacks.py"
ATTACKS = runpy.run_path(str(ATTACKER))["ATTACKS"]


def children(process):
    return [int(pid) for pid in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def memory(process):
    """Resident memory [byte]."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.parametrize("kind", ATTACKS)
def test_a_page_is_served_under_attack(kind):
    server_id = free_server_id(300 + os.getpid() % 500)
    with served("-s", server_id, "-d", 0, "worlds/pioneer2at.world") as (process, url), Socket(url) as page:
        page.until("state")
        [viewer] = children(process.pid)
        port, before = int(re.search(r":(\d+)/", url)[1]), memory(viewer)
        attackers = [subprocess.Popen([sys.executable, ATTACKER, str(port), kind]) for _ in range(2)]
        try:
            for _ in range(STATES):
                page.until("state")
        finally:
            for one in attackers:
                one.kill()
                one.wait()
        assert page.ask("pause", "on")[1] in (None, "the server has not answered the requests before; try again later")
        assert children(process.pid) == [viewer]
        assert memory(viewer) < before + LARGEST
