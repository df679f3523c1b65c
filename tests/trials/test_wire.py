"""Servers whose files are truncated at full speed."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from trials.table import trial
from trials.test_hostile_bytes import HEAD, Attacker, world_of_all

import libgz

pytestmark = pytest.mark.trial

TRUNCATIONS = 10_000
SERVERS = 4


def test_truncations(gazebo, tmp_path):
    path = tmp_path / "attacked.world"
    path.write_text(HEAD + world_of_all(1) + "</gz:world>")
    with trial(f"truncations over {SERVERS} servers") as row:
        survived, slowest = 0, 0.0
        for i in range(SERVERS):
            server = gazebo(path, "-n")
            made = Path(server.directory).iterdir()
            files = [file for file in made if file.name != "gazebo.pid" and file.suffix != ".new"]
            attackers = [Attacker("truncate", row.seed + 2 * i + j) for j in range(2)]
            for attacker in attackers:
                attacker.order(files)
            time.sleep(2.0)
            row.count += sum(attacker.end() for attacker in attackers)
            sim_file, begin = server.directory / "sim.default", time.monotonic()
            while sim_file.stat().st_size < libgz.Sim().size:  # clients refuse short files
                assert time.monotonic() < begin + 20.0, "the length was not restored"
                time.sleep(0.05)
            slowest = max(slowest, time.monotonic() - begin)
            assert server.process.poll() is None, f"server {i + 1} ended with {server.process.poll()}"
            with libgz.Client(server.id, 5, timeout=20.0) as client:
                sim = client.sim()
                before, end = sim.sim_time, time.monotonic() + 20.0
                while sim.sim_time <= before:
                    assert time.monotonic() < end, "the simulation stands still"
                    client.wait(timeout=1.0)
            code, _, err = server.stop()
            assert code == 0, err
            assert "Traceback" not in err
            survived += 1
        row.result = f"{survived} of {SERVERS} servers survived; repaired in {slowest:.1f} s"
        assert row.count >= TRUNCATIONS
