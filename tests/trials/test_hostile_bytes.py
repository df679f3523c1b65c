"""Random bytes in interface files at full speed: the server keeps its rate, during the attack and afterwards."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import re
import statistics
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest
from trials.table import trial

import libgz
from libgz.interfaces.catalog import new_interface
from libgz.transport.patience import Patience

pytestmark = pytest.mark.trial

ATTACK = Path(__file__).parent / "wire_attack.py"
ROUNDS = 10
SLICE = 0.8  # [s]
CHUNK = 0.01  # [s] of steps in turn
LEAST = 0.9  # of the rate of a server that is never attacked
MOST_LINES = 10  # of the log, for each field of an interface

ROBOT = "<model:Pioneer2AT><id>robot1</id><xyz>0 0 0.3</xyz>{}</model:Pioneer2AT>"
# Kind -> a world that serves it.
WORLDS = {
    "camera": ROBOT.format("<model:MonoCam><id>c</id><xyz>0 0 0.4</xyz></model:MonoCam>"),
    "factory": ROBOT.format("") + "<model:Factory><id>f</id></model:Factory>",
    "fiducial": ROBOT.format("<model:SickLMS200><id>l</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>"),
    "gps": ROBOT.format("<model:GarminGPS><id>g</id><xyz>0 0 0.3</xyz></model:GarminGPS>"),
    "gripper": "<model:Pioneer2DX><id>r</id><xyz>0 0 0.24</xyz>"
    "<model:Pioneer2Gripper><id>g</id><xyz>0.22 0 -0.1</xyz></model:Pioneer2Gripper></model:Pioneer2DX>",
    "guicam": ROBOT.format("") + "<model:ObserverCam><id>o</id><xyz>-3 0 1.5</xyz></model:ObserverCam>",
    "joint": "<model:Bandit><id>b</id><xyz>0 0 1</xyz></model:Bandit>",
    "laser": ROBOT.format("<model:SickLMS200><id>l</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>"),
    "position": ROBOT.format(""),
    "power": ROBOT.format(""),
    "ptz": ROBOT.format("<model:SonyVID30><id>p</id><xyz>0 0 0.3</xyz></model:SonyVID30>"),
    "sim": ROBOT.format(""),
    "sonar": ROBOT.format(""),
    "stereo": ROBOT.format("<model:StereoHead><id>s</id><xyz>0 0 0.3</xyz></model:StereoHead>"),
    "truth": ROBOT.format("<model:TruthWidget><id>t</id></model:TruthWidget>"),
    "wifi": ROBOT.format("<model:WiFi><id>w</id></model:WiFi>"),
    "actarray": ROBOT.format(""),
    "ir": ROBOT.format(""),
}
EXTRA = ("actarray", "ir")  # kinds that no model serves
HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'><model:GroundPlane/>"


def world_of_all(count: int = 3) -> str:
    """A world with all kinds and more than 42 files."""
    text = ""
    for i in range(count):
        text += f"""<model:Pioneer2AT><id>robot{i}</id><xyz>0 {4 * i} 0.3</xyz>
            <model:SickLMS200><id>laser{i}</id><xyz>0.1 0 0.3</xyz></model:SickLMS200>
            <model:SonyVID30><id>ptz{i}</id><xyz>-0.1 0 0.3</xyz></model:SonyVID30>
            <model:TruthWidget><id>truth{i}</id></model:TruthWidget>
            <model:WiFi><id>wifi{i}</id></model:WiFi>
            <model:GarminGPS><id>gps{i}</id><xyz>0 0.2 0.3</xyz></model:GarminGPS></model:Pioneer2AT>"""
    for kind in ("stereo", "gripper", "joint", "guicam", "factory"):
        text += WORLDS[kind].replace("robot1", f"robot_{kind}").replace("<xyz>0 0", "<xyz>9 -9", 1)
    return text


class Attacker:
    """The program wire_attack.py."""

    def __init__(self, kind: str, seed: int) -> None:
        command = [sys.executable, str(ATTACK), kind, str(seed)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self._busy = False

    def order(self, paths: list[Path]) -> int:
        """Attack these files from now on; the number of attacks on the last ones."""
        self.process.stdin.write("\t".join(map(str, paths)) + "\n")
        self.process.stdin.flush()
        done = int(self.process.stdout.readline()) if self._busy else 0
        if paths:
            assert self.process.stdout.readline() == "begin\n"
        self._busy = bool(paths)
        return done

    def end(self) -> int:
        done = self.order([])
        self.process.communicate(timeout=10)
        return done


class Waits(Patience):
    """Patience that adds up all waits, without the processor time in them [s]."""

    def __init__(self) -> None:
        super().__init__()
        self.total = 0.0

    def left(self, now: float) -> float:
        self._used = time.process_time()
        return super().left(now)

    def spend(self, seconds: float) -> None:
        super().spend(seconds)
        self.total += max(0.0, seconds - (time.process_time() - self._used))


class Twins:
    """A server that is attacked and one that never is, which step in turn: both have the same load beside them."""

    def __init__(self, worlds: list[libgz.World]) -> None:
        self.worlds = worlds
        self.chunk = 1
        begin = time.process_time()
        self._times()
        while time.process_time() - begin < 0.5:
            self._times()
        while min(self._times()) < CHUNK:
            self.chunk *= 2

    def _times(self) -> list[float]:
        """What each needs for the next steps: processor time and waits for locks, not what other processes take [s]."""
        found = []
        for world in self.worlds:
            patience = world.gz_server.patience
            waited, used = patience.total, time.process_time()
            for _ in range(self.chunk):
                world.Step()
            found.append(time.process_time() - used + patience.total - waited)
        return found

    def ratio(self, seconds: float) -> float:
        """The rate of the attacked server, as a share of that of the other one."""
        totals, end = [0.0, 0.0], time.monotonic() + seconds
        while time.monotonic() < end:
            for i, used in enumerate(self._times()):
                totals[i] += used
        return totals[1] / totals[0]


def build(server_id: int, path: Path, kind: str, seed: int) -> libgz.World:
    """A world that serves its interfaces."""
    world = libgz.World(server_id, seed=seed)
    world.LoadFile(path)
    world.gz_server.patience = Waits()
    world.Initialize()
    for extra in EXTRA:
        if kind in (extra, "all"):
            interface = new_interface(extra)
            interface.create(world.gz_server, "x")
    return world


@contextlib.contextmanager
def twins_of(kind: str, wire: int, tmp_path: Path, seed: int) -> Iterator[tuple[Twins, list[Path]]]:
    """Two servers of a world for a kind, and the files of the kind that the first one serves."""
    path = tmp_path / "attacked.world"
    path.write_text(HEAD + (world_of_all() if kind == "all" else WORLDS[kind]) + "</gz:world>")
    with contextlib.ExitStack() as stack:
        worlds = [stack.enter_context(build(number, path, kind, seed)) for number in (wire, wire + 1)]
        served = [file for file in Path(worlds[0].gz_server.path).iterdir() if file.name != "gazebo.pid"]
        files = [file for file in served if kind in ("all", file.name.split(".")[0])]
        assert files
        yield Twins(worlds), files


@pytest.mark.parametrize("kind", [*WORLDS, "all"])
def test_kept_locks(wire, tmp_path, monkeypatch, kind):
    monkeypatch.chdir(tmp_path)
    with trial(f"kept locks of {kind}") as row, twins_of(kind, wire, tmp_path, row.seed) as (twins, files):
        with contextlib.ExitStack() as stack:
            for path in files:
                fcntl.flock(stack.enter_context(path.open("rb")), fcntl.LOCK_EX)
            twins.ratio(SLICE)
            under = statistics.median(twins.ratio(SLICE / 2) for _ in range(ROUNDS))
        afterwards = statistics.median(twins.ratio(SLICE / 2) for _ in range(ROUNDS))
        row.count, row.result = len(files), f"{under:.2f}, then {afterwards:.2f}"
        assert min(under, afterwards) >= LEAST, row.result


@pytest.mark.parametrize("mode", ["bytes", "locked", "pieces"])
@pytest.mark.parametrize("kind", [*WORLDS, "all"])
def test_random_bytes(wire, tmp_path, monkeypatch, caplog, kind, mode):
    monkeypatch.chdir(tmp_path)
    with trial(f"random bytes in {kind} ({mode})") as row, twins_of(kind, wire, tmp_path, row.seed) as (twins, files):
        caplog.clear()
        attacker = Attacker(mode, row.seed)
        attacker.order(files)
        under = statistics.median(twins.ratio(SLICE) for _ in range(ROUNDS))
        row.count = attacker.end()
        twins.ratio(SLICE)
        afterwards = statistics.median(twins.ratio(SLICE) for _ in range(ROUNDS))
        messages = [record.getMessage() for record in caplog.records if record.levelno >= logging.WARNING]
        lines = Counter(re.split(" is |;", message)[0] for message in messages)
        saved = len(list(tmp_path.glob("*.pnm")))
        row.result = f"{under:.2f}, then {afterwards:.2f}; {lines.total()} lines"
        assert max(lines.values(), default=0) <= MOST_LINES, lines
        assert saved <= 1000
        assert min(under, afterwards) >= LEAST, row.result
        assert not twins.worlds[0].paused
