"""Comparisons within one run: what is compared takes turns, and ratios are medians over the rounds."""

from __future__ import annotations

import math
import os
import signal
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol, Self

from reference import Spent

import libgz

__all__ = ["ROUNDS", "Run", "ServerRun", "Times", "interval", "of_calls", "spend", "take_turns", "text_of"]

ROUNDS = 15  # of which medians are taken

Run = Callable[[int], Spent]  # runs so many steps, and returns the time of each


def spend(steps: int, action: Callable[[], object]) -> Spent:
    """The time of an action that makes steps, for each of them."""
    wall, cpu = time.perf_counter(), time.process_time()
    action()
    return Spent((time.perf_counter() - wall) / steps, (time.process_time() - cpu) / steps)


def of_calls(action: Callable[[], object]) -> Run:
    """A run that calls an action once a step."""

    def run(steps: int) -> Spent:
        def repeat() -> None:
            for _ in range(steps):
                action()

        return spend(steps, repeat)

    return run


class Times:
    """What was measured of several runs in turn."""

    def __init__(self, rounds: list[dict[str, Spent]]) -> None:
        self.rounds = rounds

    def ratio(self, name: str, base: str, kind: str = "cpu") -> float:
        """The median of a run's time over that of another one of the same round."""
        return statistics.median(self.ratios(name, base, kind))

    def ratios(self, name: str, base: str, kind: str = "cpu") -> list[float]:
        """A run's time over that of another one of the same round, of all rounds."""
        return [getattr(one[name], kind) / getattr(one[base], kind) for one in self.rounds]

    def median(self, name: str, kind: str = "cpu") -> float:
        """The median time of a step [s]."""
        return statistics.median(getattr(one[name], kind) for one in self.rounds)


def interval(ratios: list[float]) -> tuple[float, float]:
    """The 95 % interval of a median, by order statistics."""
    ordered, count = sorted(ratios), len(ratios)
    below, rank = 0.0, 0
    while (below := below + math.comb(count, rank) / 2**count) <= 0.025:
        rank += 1
    rank = max(rank - 1, 0)
    return ordered[rank], ordered[count - 1 - rank]


def text_of(ratios: list[float]) -> str:
    """A median, and its interval."""
    low, high = (100 * (end - 1.0) for end in interval(ratios))
    return f"{100 * (statistics.median(ratios) - 1.0):+5.1f} % ({low:+.1f} to {high:+.1f})"


class _Paced(Protocol):
    def __call__(self, steps: int, /) -> Spent: ...


def take_turns(runs: Mapping[str, Run], seconds: float = 0.15, rounds: int = ROUNDS) -> Times:
    """Let runs take turns, each for some seconds a round; every other round in the opposite order."""
    counts = {}
    for name, run in runs.items():
        count, spent = 1, run(1)
        while spent.cpu * count < seconds / 10.0:
            count *= 4
            spent = run(count)
        counts[name] = max(1, round(seconds / max(spent.cpu, 1e-9)))
    found = []
    for number in range(rounds):
        order = list(runs) if number % 2 else list(runs)[::-1]
        found.append({name: runs[name](counts[name]) for name in order})
    return Times(found)


class ServerRun:
    """A `gazebo -n` of its own, stopped by signals while others have their turn. It is called with a number of steps.

    Args:
        folder: of the world's file, and of the server's own files.
        text: the world.
        drive: what a client does at the beginning.
    """

    STEP = 0.02  # [s]

    def __init__(self, folder: Path, text: str, drive: Callable[[libgz.Client], object]) -> None:
        folder.mkdir(exist_ok=True)
        world = folder / "bench.world"
        world.write_text(text)
        env = {**os.environ, "TMP": str(folder), "USER": "bench"}
        os.environ.update(TMP=env["TMP"], USER=env["USER"])
        command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", "auto", "-n", "-d", "0", "--gl", "none", str(world)]
        self._process = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True)
        line = self._process.stdout.readline() if self._process.stdout else ""
        self._client = libgz.Client(int(line.split()[-1]), timeout=30.0).__enter__()
        self._sim = self._client.sim()
        drive(self._client)
        self._clock = (~self._process.pid << 3) | 2  # of the process's processor time, as Linux numbers clocks
        while self._sim.data.sim_time < 1.0:
            time.sleep(0.01)
        self._stop()

    def _stop(self) -> None:
        self._process.send_signal(signal.SIGSTOP)
        state = Path(f"/proc/{self._process.pid}/stat")
        while state.read_text().rpartition(")")[2].split()[0] not in "Tt":
            time.sleep(0.0005)

    def __call__(self, steps: int) -> Spent:
        """Let it run for about so many steps."""
        sim, data = self._sim, self._sim.data
        first, wall, cpu = data.sim_time, time.perf_counter(), time.clock_gettime(self._clock)
        self._process.send_signal(signal.SIGCONT)
        while data.sim_time < first + steps * self.STEP:
            time.sleep(0.002)
        self._stop()
        made = max(1, round((sim.data.sim_time - first) / self.STEP))
        return Spent((time.perf_counter() - wall) / made, (time.clock_gettime(self._clock) - cpu) / made)

    @property
    def resident(self) -> float:
        """Its memory [MB]."""
        pages = Path(f"/proc/{self._process.pid}/statm").read_text().split()[1]
        return int(pages) * os.sysconf("SC_PAGE_SIZE") / 1e6

    def close(self) -> None:
        """End the server."""
        self._process.send_signal(signal.SIGCONT)
        self._process.terminate()
        self._client.__exit__(None, None, None)
        self._process.communicate()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
