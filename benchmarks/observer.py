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

import libgz

ROBOTS, STEPS, ROUNDS = 50, 5, 150  # five steps are one period of the lasers
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


def world_text() -> str:
    """Fifty robots with lasers on a plane, each with a velocity command of its own."""
    robots = "".join(
        f"<model:Pioneer2AT><id>r{i}</id><xyz>{2 * (i % 10)} {2 * (i // 10)} 0</xyz>"
        f"<model:SickLMS200><id>l{i}</id><xyz>0.15 0 0.2</xyz></model:SickLMS200></model:Pioneer2AT>"
        for i in range(ROBOTS)
    )
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robots}</gz:world>"


def block(world: libgz.World) -> float:
    """CPU time of one step [us]."""
    begin = time.thread_time()
    for _ in range(STEPS):
        world.Step()
    return (time.thread_time() - begin) / STEPS * 1e6


def report(name: str, rounds: list[tuple[float, float]]) -> None:
    """Print the median ratio of two kinds of blocks, its standard error, and the ratio of the fastest blocks."""
    ratios = sorted(after / before for before, after in rounds)
    error = 0.93 * (ratios[3 * len(ratios) // 4] - ratios[len(ratios) // 4]) / len(ratios) ** 0.5
    fastest = [statistics.quantiles(times, n=10)[0] for times in zip(*rounds, strict=True)]
    print(f"{name:20} {100 * (statistics.median(ratios) - 1):+6.2f} % +- {100 * error:.2f}", end="")
    print(f"; of the fastest {100 * (fastest[1] / fastest[0] - 1):+6.2f} %")


def publication(world: libgz.World, count: int = 2000) -> float:
    """CPU time of one publication alone [us]."""
    begin = time.thread_time()
    for _ in range(count):
        world._publication.publish(False)
    return (time.thread_time() - begin) / count * 1e6


def main() -> None:
    """Print a table."""
    with tempfile.TemporaryDirectory(prefix="gz", dir="/tmp") as folder:
        os.environ["TMP"] = folder
        with libgz.World.from_string(world_text(), server_id=SERVER_ID) as world:
            for i in range(ROBOTS):
                world.interface("position", f"r{i}").command(vx=0.2, vyaw=0.02 * (i % 7 - 3))
            world.step(100)
            observer = subprocess.Popen([sys.executable, "-c", OBSERVER], stdout=subprocess.PIPE)
            if observer.stdout is not None:
                observer.stdout.readline()  # it is ready
            published, observed = [], []
            publish = world._publication
            try:
                for i in range(ROUNDS):
                    times = {}
                    order = ["none", "published", "observed"]
                    for kind in order if i % 2 else reversed(order):
                        observer.send_signal(signal.SIGCONT if kind == "observed" else signal.SIGSTOP)
                        world._publication = None if kind == "none" else publish
                        times[kind] = block(world)
                    published.append((times["none"], times["published"]))
                    observed.append((times["none"], times["observed"]))
            finally:
                observer.kill()
                observer.wait()
            world._publication = publish
            step = statistics.median(before for before, _ in published)
            print(f"a step of {ROBOTS} robots: {step:.0f} us; a publication alone: {publication(world):.1f} us")
            report("published", published)
            report("observed at 100 Hz", observed)


if __name__ == "__main__":
    main()
