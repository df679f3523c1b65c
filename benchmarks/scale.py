"""What one core and two do: robots in a world, and runs of a sweep against bare runs.

python benchmarks/scale.py           both parts
python benchmarks/scale.py robots    one of robots, runs

Times are processor time, so that other programs matter little; the speed of two processes is real time.
"""

from __future__ import annotations

import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import libgz

COUNTS = (1, 3, 10, 30, 100, 200, 400)
RUNS, SECONDS = 6, 1.0  # of a sweep; processor time of each [s]
ROUNDS = 3  # of which the median counts


def text(robots: int) -> str:
    """A world of robots on a square, 2 m apart."""
    side = math.ceil(math.sqrt(robots))
    place = "<model:Pioneer2AT><id>r{0}</id><xyz>{1} {2} 0</xyz></model:Pioneer2AT>"
    models = "".join(place.format(i, 2 * (i % side), 2 * (i // side)) for i in range(robots))
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{models}</gz:world>"


def resident() -> int:
    """Memory of this process [byte]."""
    pages = Path("/proc/self/statm").read_text().split()[1]
    return int(pages) * os.sysconf("SC_PAGE_SIZE")


def robots() -> None:
    """Step time, real-time factor and memory over the number of robots, all driving."""
    print(
        f"{'robots':>8}{'step [us]':>11}{'us/robot':>10}{'RTF':>8}{'robots x RTF':>14}{'kB/robot':>10}{'state kB':>10}"
    )
    for count in COUNTS:
        before = resident()
        with libgz.World.from_string(text(count)) as world:
            for number in range(count):
                world.interface("position", f"r{number}").command(vx=0.2, vyaw=0.1)
            world.step(50)
            memory = (resident() - before) / count / 1e3
            times = []
            steps = max(10, 3000 // count)
            for _ in range(ROUNDS):
                start = time.process_time()
                world.step(steps)
                times.append((time.process_time() - start) / steps)
            step = statistics.median(times)
            factor, state = world.engine.step_time / step, len(world.get_state()) / count / 1e3
        values = f"{step * 1e6:11.0f}{step / count * 1e6:10.1f}{factor:8.1f}{factor * count:14.0f}"
        print(f"{count:8}{values}{memory:10.0f}{state:10.1f}")


def children() -> float:
    """Processor time of the processes that this one has started and awaited [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def bare(folder: Path, duration: float) -> float:
    """Processor time of one process that does all runs in a loop, its start not counted [s]."""
    program = (
        "import time, libgz\n"
        f"def run():\n    with libgz.World.from_file({str(folder / 'w.world')!r}) as world:\n"
        f"        world.run({duration})\n        return world.model('r0').GetPose()\n"
        f"run()\nstart = time.process_time()\nfor _ in range({RUNS}):\n    run()\nprint(time.process_time() - start)\n"
    )
    return float(subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout)


def swept(folder: Path, count: int, jobs: int) -> tuple[float, float]:
    """(processor time, real time) of a sweep of so many runs [s]."""
    study = folder / "w.toml"
    study.write_text(study.read_text().split("seeds")[0] + f"seeds = {count}\n\n[measures]\nx = 'r0/pos[0]'\n")
    target = folder / f"results-{count}-{jobs}-{time.monotonic()}"
    before, start = children(), time.monotonic()
    command = [sys.executable, "-m", "libgz", "sweep", str(study), "-j", str(jobs), "--results", str(target)]
    subprocess.run(command, check=True, capture_output=True)
    return children() - before, time.monotonic() - start


def runs() -> None:
    """Overhead of a sweep, and two processes against one."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "w.world").write_text(text(10))
        with libgz.World.from_file(folder / "w.world") as world:
            start = time.process_time()
            world.step(300)
            duration = round(SECONDS / ((time.process_time() - start) / 300)) * world.engine.step_time
        (folder / "w.toml").write_text(f"world = 'w.world'\nduration = {duration}\nseeds = 1\n")
        shares, ratios = [], []
        for _ in range(ROUNDS):
            plain = bare(folder, duration) / RUNS
            (small, _), (large, one) = swept(folder, 1, 1), swept(folder, RUNS + 1, 1)
            _, two = swept(folder, RUNS + 1, 2)
            shares.append((large - small) / RUNS / plain)
            ratios.append(one / two)
        print(f"a run of {plain:.2f} s: {statistics.median(shares):.3f} of that in a sweep (median of {ROUNDS})")
        print(f"two processes: {statistics.median(ratios):.2f} times one (median), {max(ratios):.2f} at best")


if __name__ == "__main__":
    parts = {"robots": robots, "runs": runs}
    for part in sys.argv[1:] or parts:
        parts[part]()
