"""What a world's lock costs in a program with one thread: steps with it and without, which take turns in one process.

    python benchmarks/lock.py [PAIRS]

Without it, the wrappers of `exclusive` are taken off all methods, and the lock's own functions do nothing. The figures
are the median ratio of the processor times of a pair, and the 95 % interval of that median; the exit code is 1 if an
interval is wholly above 1 % for a world in which anything moves. A step at rest takes one or two microseconds.
"""

from __future__ import annotations

import functools
import gc
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from types import FunctionType
from typing import Any

from reference import Spent
from rounds import Run, interval, of_calls, spend, take_turns, text_of
from scale import text

import libgz
from libgz.physics import lock

PAIRS, LIMIT = 15, 0.01
BOX = """<model name='b{i}'><pose>{i} 0 0.25 0 0 0</pose><link name='l'><collision name='c'><geometry><box>
<size>0.5 0.5 0.5</size></box></geometry></collision></link></model>"""
AWAKE = BOX.replace("<pose>", "<allow_auto_disable>0</allow_auto_disable><pose>")
GROUND = "<include><uri>model://ground_plane</uri></include>"


def boxes(count: int, box: str) -> str:
    """Boxes in a row, on the ground."""
    inside = "".join(box.format(i=i) for i in range(count))
    return f"<sdf version='1.6'><world name='default'>{GROUND}{inside}</world></sdf>"


WORLDS = {
    "a robot that drives": text(1),
    "ten robots that drive": text(10),
    "ten boxes awake": boxes(10, AWAKE),
    "ten boxes asleep": boxes(10, BOX),
}


def is_exclusive(function: object) -> bool:
    """Whether it is a wrapper that `exclusive` made."""
    own = isinstance(function, FunctionType) and function.__code__.co_filename == lock.__file__
    return own and hasattr(function, "__wrapped__")


def wrapped() -> list[tuple[type, str, Any]]:
    """(class, name, function) of all methods that are `exclusive`."""
    kinds = [kind for kind in gc.get_objects() if isinstance(kind, type) and str(kind.__module__).startswith("libgz")]
    return [(kind, name, f) for kind in kinds for name, f in vars(kind).items() if is_exclusive(f)]


@contextmanager
def unlocked(world: libgz.World, methods: list[tuple[type, str, Any]]) -> Iterator[None]:
    """Take the lock off a world, and off all methods."""
    own = dict(vars(world.lock))
    yes = functools.partial(bool, 1)
    vars(world.lock).update(try_acquire=yes, owned=yes, release=dict)
    for kind, name, function in methods:
        setattr(kind, name, function.__wrapped__)
    try:
        yield
    finally:
        vars(world.lock).update(own)
        for kind, name, function in methods:
            setattr(kind, name, function)


def without(world: libgz.World, methods: list[tuple[type, str, Any]], action: Callable[[], object]) -> Run:
    """A run of an action without the lock."""

    def run(steps: int) -> Spent:
        def repeat() -> None:
            for _ in range(steps):
                action()

        with unlocked(world, methods):
            return spend(steps, repeat)

    return run


def main() -> int:
    """Print a table; the exit code."""
    pairs = int(sys.argv[1]) if len(sys.argv) > 1 else PAIRS
    missed = 0
    for what, content in WORLDS.items():
        with ExitStack() as stack:
            world = stack.enter_context(libgz.World.from_string(content))
            for model in world.models:
                if model.GetName() == "Pioneer2AT":
                    world.interface("position", model.GetId()).command(vx=0.2, vyaw=0.1)
            world.step(2000 if "asleep" in what else 100)
            methods = wrapped()
            for calls, action in (
                ("World.step(100)", functools.partial(world.step, 100)),
                ("100 World.Step()", lambda world=world: [world.Step() for _ in range(100)]),
            ):
                times = take_turns({"with": of_calls(action), "without": without(world, methods, action)}, rounds=pairs)
                ratios = times.ratios("with", "without")
                missed += interval(ratios)[0] > 1.0 + LIMIT and "asleep" not in what
                print(f"{text_of(ratios)}  {times.median('without') * 1e4:8.2f} us  {what}, {calls}", flush=True)
    return int(missed > 0)


if __name__ == "__main__":
    sys.exit(main())
