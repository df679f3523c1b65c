"""What it costs a server to record a log: a step of 10 robots with lasers, without and with `--mcap`.

    python benchmarks/record.py

Blocks of steps with and without recording alternate within one run of one world. CPU times of the server's thread are
compared, as ratios of blocks side by side and as those of the fastest tenth of all blocks. Then the CPU time of the
process that writes: it has a core of its own where there is one, and if it is slower than the server, the server waits.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from pathlib import Path

from laser_robots import drive, fastest, ratio_text, world_text

import libgz
from libgz.recording.capture import Capture

ROBOTS, STEPS, ROUNDS = 10, 20, 150  # twenty steps are several periods of all sensors
PAUSE = 0.02  # [s] after a block, in which the writer keeps up


def block(world: libgz.World, log: Capture | None) -> float:
    """CPU time of one step [us]."""
    begin = time.thread_time()
    for _ in range(STEPS):
        world.Step()
        if log is not None:
            log.take()
    return (time.thread_time() - begin) / STEPS * 1e6


def writer_time(log: Capture) -> float:
    """CPU time of the writing process so far [s]."""
    words = Path(f"/proc/{log._writer.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Print a table."""
    with tempfile.TemporaryDirectory() as folder, libgz.World.from_string(world_text(ROBOTS, in_row=5)) as world:
        drive(world, ROBOTS)
        path = Path(folder, "run.mcap")
        with Capture(world, path) as log:
            time.sleep(2.0)  # the writer has started
            block(world, log)
            rounds, before, steps = [], writer_time(log), 0
            for i in range(ROUNDS):
                times = {}
                for recorded in (False, True) if i % 2 else (True, False):
                    times[recorded] = block(world, log if recorded else None)
                    time.sleep(PAUSE)
                rounds.append((times[False], times[True]))
                steps += STEPS
            time.sleep(1.0)
            written = (writer_time(log) - before) / steps * 1e6
        size = path.stat().st_size / steps
    plain = [before for before, _ in rounds]
    print(
        f"a step of {ROBOTS} robots with lasers: {statistics.median(plain):.0f} us, the fastest {fastest(plain):.0f} us"
    )
    print(f"recorded: {ratio_text(rounds)}")
    print(f"the writing process: {written:.0f} us a step; the log: {size / 1000:.1f} kB a step")


if __name__ == "__main__":
    main()
