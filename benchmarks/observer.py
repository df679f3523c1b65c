"""What it costs a server to be observed: a step of 50 robots with and without shared tables, and with an observer.

    python benchmarks/observer.py

Three kinds of blocks of steps alternate within one run of one world: nothing is published, states are published, and an
observer in another process reads them 100 times a second. CPU times are compared as ratios of blocks side by side, and
as those of the fastest tenth of all blocks, which other processes of the machine have disturbed least.
"""

from __future__ import annotations

import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time

from laser_robots import drive, ratio_text, world_text

import libgz

ROBOTS, STEPS, ROUNDS = 50, 5, 400  # five steps are one period of the lasers
SERVER_ID = 910_000 + os.getpid()

OBSERVER = f"""
import time
import libgz

with libgz.Observer({SERVER_ID}, timeout=10.0) as observer:
    print("ready", flush=True)
    while True:
        observer.state(), observer.pose("r7")
        time.sleep(0.01)
"""


def block(world: libgz.World) -> float:
    """CPU time of one step [us]."""
    begin = time.thread_time()
    for _ in range(STEPS):
        world.Step()
    return (time.thread_time() - begin) / STEPS * 1e6


def publication(world: libgz.World, count: int = 2000) -> float:
    """CPU time of one publication alone [us]."""
    begin = time.thread_time()
    for _ in range(count):
        world.publication.publish(False)
    return (time.thread_time() - begin) / count * 1e6


def main() -> None:
    """Print a table."""
    with tempfile.TemporaryDirectory(prefix="gz", dir="/tmp") as folder:
        os.environ["TMP"] = folder
        with libgz.World.from_string(world_text(ROBOTS, in_row=10), server_id=SERVER_ID) as world:
            drive(world, ROBOTS)
            observer = subprocess.Popen([sys.executable, "-c", OBSERVER], stdout=subprocess.PIPE)
            if observer.stdout is not None:
                observer.stdout.readline()  # it is ready
            published, observed = [], []
            publish = world.publication
            try:
                for i in range(ROUNDS):
                    times = {}
                    order = ["none", "published", "observed"]
                    for kind in order if i % 2 else reversed(order):
                        observer.send_signal(signal.SIGCONT if kind == "observed" else signal.SIGSTOP)
                        world.publication = None if kind == "none" else publish
                        times[kind] = block(world)
                    published.append((times["none"], times["published"]))
                    observed.append((times["none"], times["observed"]))
            finally:
                observer.kill()
                observer.wait()
            world.publication = publish
            step = statistics.median(before for before, _ in published)
            print(f"a step of {ROBOTS} robots: {step:.0f} us; a publication alone: {publication(world):.1f} us")
            print(f"{'published':20} {ratio_text(published)}")
            print(f"{'observed at 100 Hz':20} {ratio_text(observed)}")


if __name__ == "__main__":
    main()
