"""The cost of states.

    python benchmarks/state.py

Times are of the processor, medians of many short turns. A step comes before each state that is taken or set, so that
nothing is found as the last call left it. The worlds with an aim: one robot, and fifty.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from scale import text

import libgz
from libgz.base.files import installed_worlds
from libgz.physics.engine import Engine

ROUNDS = 21
STEPS, STATES = 10, 10  # in a round
PLUGINS = Path(__file__).parents[1] / "examples" / "plugins"
LEGACY = ("simplesolids", "pioneer2dx", "factory", "clodbuster", "gripper", "peoplebot")
AIMS = {"pioneer2at": (0.5, 1.0), "50 Pioneer2AT": (10.0, 20.0)}  # [ms] get_state, set_state
BOX = """<model name="b{0}"><pose>{1} {2} {3} 0 0 0</pose><link name="link">
<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
<visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual></link></model>"""
GROUND = """<model name="ground"><static>1</static><link name="link"><collision name="c"><geometry><plane>
<normal>0 0 1</normal><size>100 100</size></plane></geometry></collision></link></model>"""


EMPTY = "<sdf version='1.6'><world name='default'/></sdf>"


def boxes(count: int) -> libgz.World:
    """An SDF world of boxes on the ground, in stacks of two."""
    models = [BOX.format(i, 1.5 * (i // 2 % 5), 1.5 * (i // 10), 0.5 + i % 2) for i in range(count)]
    return libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{GROUND}{''.join(models)}</world></sdf>")


def _time(work: Callable[[], object], count: int) -> float:
    start = time.process_time()
    for _ in range(count):
        work()
    return (time.process_time() - start) / count


def _time_after(step: Callable[[], object], work: Callable[[], object], count: int) -> float:
    """The time of `work` alone, after a step each time."""
    clock, total = time.process_time, 0.0
    for _ in range(count):
        step()
        before = clock()
        start = clock()
        work()
        total += clock() - start - (start - before)  # the latter is what reading the clock takes
    return total / count


def measure(name: str, of: Engine | libgz.World, steps: int = 200) -> None:
    """Print what a step, a state and its restoration take, after so many steps."""
    step_once: Callable[[], object] = of.step
    for _ in range(steps):
        step_once()
    state: Any = of.get_state()
    put_back: Callable[[Any], object] = of.set_state
    samples = []
    for _ in range(ROUNDS):
        step = _time(step_once, STEPS)
        get = _time_after(step_once, of.get_state, STATES)
        put = _time_after(step_once, lambda: put_back(state), STATES)
        samples.append((step, get, put))
    step, get, put = (1e3 * statistics.median(column) for column in zip(*samples, strict=True))
    size = len(state) if isinstance(state, bytes) else sum(len(v) for v in state.values() if isinstance(v, bytes))
    aims = [f" (aim {aim:g})" for aim in AIMS[name]] if name in AIMS else ["", ""]
    print(
        f"{name:22} step {step:7.3f} ms   get_state {get:7.3f} ms{aims[0]}   set_state {put:7.3f} ms{aims[1]}   "
        f"{size / 1024:.0f} KiB",
        flush=True,
    )


def main() -> None:
    """Measure engines of robots on a plane and of boxes in a pile, then worlds of both eras."""
    with libgz.World.from_file(installed_worlds() / "pioneer2at.world") as world:
        measure("pioneer2at", world)
    with libgz.World.from_string(text(50)) as world:
        measure("50 Pioneer2AT", world, 50)
    for count in (1, 10):
        with libgz.World.from_string(text(count)) as world:
            measure(f"engine: {count} Pioneer2AT", world.engine)
    with boxes(50) as world:
        measure("engine: 50 SDF boxes", world.engine)
        measure("  asleep", world.engine, 3000)
        measure("world: 50 boxes asleep", world)
    with libgz.World.from_string(EMPTY) as world:
        measure("world: empty", world)
    for count in (1, 5, 50):
        with boxes(count) as world:
            measure(f"world: {count} SDF boxes", world)
    for path in (*(installed_worlds() / f"{name}.world" for name in LEGACY), *sorted(PLUGINS.glob("*/*.world"))):
        with libgz.World.from_file(path) as world:
            measure(path.stem, world)


if __name__ == "__main__":
    main()
