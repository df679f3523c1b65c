"""What servers of an empty world cost while they run in real time: `python benchmarks/idle.py [SECONDS]`.

The processor time of the whole process, in percent of one core, beside that of a C library's sleep of 1 ms in a loop,
which is the floor of a world whose steps take 1 ms.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SECONDS, STARTING = 20.0, 4.0  # measured, and left to the start [s]
SDF = """<sdf version="1.6"><world name="default">
<include><uri>model://ground_plane</uri></include><include><uri>model://sun</uri></include></world></sdf>"""
LEGACY = '<gz:world xmlns:gz="g" xmlns:model="m"><model:GroundPlane/></gz:world>'
SLEEPER = "import ctypes\nsleep = ctypes.CDLL(None).usleep\nwhile True: sleep(900)"


def spent(process: int) -> float:
    """Processor time of a process so far [s]."""
    tasks = Path(f"/proc/{process}/task")
    return sum(int((task / "schedstat").read_text().split()[0]) for task in tasks.iterdir()) / 1e9


def share(command: list[str], seconds: float, **environment: str) -> float:
    """Of one core, while a command runs."""
    with subprocess.Popen(command, env={**os.environ, **environment}, stdout=subprocess.DEVNULL) as process:
        try:
            time.sleep(STARTING)
            before, begin = spent(process.pid), time.monotonic()
            time.sleep(seconds)
            if process.poll() is not None:
                raise SystemExit(f"{' '.join(command)} has ended with {process.returncode}")
            return (spent(process.pid) - before) / (time.monotonic() - begin)
        finally:
            process.terminate()


def main() -> None:
    """Print a table."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS
    folder = Path(sys.executable).parent
    with tempfile.TemporaryDirectory() as name:
        worlds = {"sdf": Path(name, "empty.world"), "legacy": Path(name, "legacy.world")}
        worlds["sdf"].write_text(SDF)
        worlds["legacy"].write_text(LEGACY)
        rows = {
            "gzserver, 1 ms": [str(folder / "gzserver"), str(worlds["sdf"])],
            "gazebo, SDF, 1 ms": [str(folder / "gazebo"), "--gl", "none", str(worlds["sdf"])],
            "gazebo, legacy, 20 ms": [str(folder / "gazebo"), "--gl", "none", str(worlds["legacy"])],
            "sleep of 1 ms": [sys.executable, "-c", SLEEPER],
        }
        for label, command in rows.items():
            print(f"{label:24}{100.0 * share(command, seconds, TMP=name):6.2f} % of a core", flush=True)


if __name__ == "__main__":
    main()
