"""The cost of an SDF world compared with the same legacy world: `python benchmarks/sdf.py`.

A legacy world of solids on the ground is loaded, written as SDF by the converter, and loaded again. Both step without
plugins and clients; ratios are of the best of rounds taken in turn within one run.

A second table compares worlds under the quick solver at 1 ms with `exact_rest` and without it, by CPU time.

`python benchmarks/sdf.py --against FOLDER WORLD...` compares the step of given worlds with that of another version of
libgz, which `pip install --no-deps --target FOLDER CHECKOUT` has installed.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import libgz
from libgz.convert.sdf import convert
from libgz.sdfworld.model import SdfModel

ROUNDS = 40
STEPS = 300  # of a turn, where versions are compared
SHAPES = (("box", "0.4 0.3 0.2"), ("sphere", "0.3"), ("cylinder", "0.3 0.4"))
SOLID = "<model:SimpleSolid><id>s{0}</id><shape>{1}</shape><size>{2}</size><xyz>{3} {4} {5}</xyz></model:SimpleSolid>"


def legacy_text(count: int) -> str:
    """Solids on the ground."""
    solids = []
    for i in range(count):
        shape, size = SHAPES[i % 3]
        height = float(size.split()[-1]) / 2
        solids.append(SOLID.format(i, shape, size, i % 10, i // 10, height))
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{''.join(solids)}</gz:world>"


def load(count: int, folder: Path) -> tuple[libgz.World, libgz.World, libgz.World]:
    """(legacy, SDF awake, SDF with auto-disable)."""
    legacy = libgz.World.from_string(legacy_text(count))
    path = folder / f"solids{count}.world"
    path.write_bytes(convert(legacy).sdf)
    modern = [libgz.World.from_file(path) for _ in range(2)]
    for world in modern:
        world.engine.step_time, world.engine.solver = legacy.engine.step_time, legacy.engine.solver
    for model in modern[0].models:
        if isinstance(model, SdfModel):
            model.set_auto_disable(False)
    return legacy, modern[0], modern[1]


def microseconds(world: libgz.World, steps: int) -> float:
    """Microseconds of a step."""
    begin = time.perf_counter()
    world.step(steps)
    return (time.perf_counter() - begin) / steps * 1e6


CUBE = (
    "<model name='b{0}'><allow_auto_disable>0</allow_auto_disable><pose>{1} {2} {3} 0 0 {4}</pose><link name='link'>"
    "<inertial><inertia><ixx>.04</ixx><iyy>.04</iyy><izz>.04</izz></inertia></inertial><collision name='c'><geometry>"
    "<box><size>.5 .5 .5</size></box></geometry></collision></link></model>"
)
SCENES = {
    "20 cubes apart": [(2 * i, 0, 0.25, 0) for i in range(20)],
    "a stack of 3": [(0, 0, 0.25 + 0.5 * i, 0) for i in range(3)],
    "a stack of 10": [(0, 0, 0.25 + 0.5 * i, 0) for i in range(10)],
    "20 cubes falling on a heap": [(0.3 * (i % 3), 0.3 * (i % 2), 1 + 0.8 * i, i) for i in range(20)],
}


def quick(places: list[tuple[float, ...]], exact: bool) -> libgz.World:
    """Cubes that never sleep, under the quick solver."""
    cubes = "".join(CUBE.format(i, *place) for i, place in enumerate(places))
    settings = f"<physics type='ode'><ode><solver><exact_rest>{exact}</exact_rest></solver></ode></physics>"
    ground = "<include><uri>model://ground_plane</uri></include>"
    return libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{settings}{ground}{cubes}</world></sdf>")


def compare_rest() -> None:
    """Print the second table."""
    print("step under the quick solver, 1 ms, 50 iterations, for 4 s in turns of 0.1 s")
    print(f"{'':<28}{'without [us]':>13}{'exact_rest/without':>20}")
    for name, places in SCENES.items():
        worlds = [quick(places, exact) for exact in (False, True)]
        taken = [0.0, 0.0]
        for _ in range(ROUNDS):
            for i, world in enumerate(worlds):
                begin = time.process_time()
                world.step(100)
                taken[i] += time.process_time() - begin
        print(f"{name:<28}{taken[0] / ROUNDS * 1e4:13.1f}{taken[1] / taken[0]:20.3f}", flush=True)
        for world in worlds:
            world.close()


# Loads a world, and for each line of its input prints the CPU time of some steps.
STEPPER = """
import sys, time, libgz
world, steps = libgz.World.from_file(sys.argv[1]), int(sys.argv[2])
world.step(500)
print("ready", flush=True)
for _ in sys.stdin:
    begin = time.process_time()
    world.step(steps)
    print(time.process_time() - begin, flush=True)
"""


class Stepper:
    """A process that steps a world with some version of libgz.

    Args:
        world: the world's file.
        folder: where the version is installed; empty: this one.
    """

    def __init__(self, world: str, folder: str) -> None:
        environment = {**os.environ, "PYTHONPATH": folder} if folder else dict(os.environ)
        self._process = subprocess.Popen(
            [sys.executable, "-c", STEPPER, str(Path(world).resolve()), str(STEPS)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=environment,
            cwd=tempfile.gettempdir(),
        )
        if not self._read():
            raise SystemExit(f"{world}: cannot be loaded")

    def _read(self) -> str:
        return self._process.stdout.readline() if self._process.stdout is not None else ""

    def step(self) -> float:
        """CPU time of some steps [s]."""
        print(file=self._process.stdin, flush=True)
        return float(self._read())

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


def compare_versions(folder: str, worlds: list[str]) -> None:
    """Print a table of worlds: the step of the version in a folder, and the ratio of this one's, in turns.

    Each pair of processes has its own caches, which moves ratios by some per cent: there are three.
    """
    print(f"{'':<36}{'before [us]':>12}{'now/before':>12}{'of three pairs':>24}")
    for world in worlds:
        ratios, before = [], []
        for _ in range(3):
            pair = Stepper(world, folder), Stepper(world, "")
            taken = [tuple(stepper.step() for stepper in pair) for _ in range(ROUNDS)]
            for stepper in pair:
                stepper.close()
            ratios.append(statistics.median(now / then for then, now in taken))
            before.append(min(then for then, _ in taken) / STEPS * 1e6)
        each = " ".join(f"{ratio:.3f}" for ratio in ratios)
        print(f"{Path(world).stem:<36}{min(before):12.1f}{statistics.median(ratios):12.3f}{each:>24}", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", metavar="FOLDER", help="where another version of libgz is installed")
    parser.add_argument("worlds", nargs="*", metavar="WORLD", help="with --against: SDF worlds")
    options = parser.parse_args()
    if options.against:
        compare_versions(options.against, options.worlds)
        return
    compare_rest()
    print("step of the same solids on the ground, 20 ms, exact solver; the best of", ROUNDS)
    print(f"{'n':>5}{'contacts':>10}{'in SDF':>8}{'legacy [us]':>13}{'SDF/legacy':>12}{'SDF asleep/legacy':>20}")
    with tempfile.TemporaryDirectory() as folder:
        for count, steps in ((1, 500), (10, 150), (50, 30)):
            worlds = load(count, Path(folder))
            for world in worlds:
                world.run(3.0)
            contacts = [world.engine.contact_count for world in worlds]
            taken: list[list[float]] = [[], [], []]
            for _ in range(ROUNDS):
                for world, times in zip(worlds, taken, strict=True):
                    times.append(microseconds(world, steps))
            legacy, awake, asleep = (min(times) for times in taken)
            print(
                f"{count:5}{contacts[0]:10}{contacts[1]:8}{legacy:13.1f}{awake / legacy:12.3f}{asleep / legacy:20.3f}"
            )
            for world in worlds:
                world.close()


if __name__ == "__main__":
    main()
