"""The cost of robots: a step of the world with a robot, compared with the step of the engine alone.

python benchmarks/robots.py
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import libgz

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
HEIGHTS = {
    "Pioneer2AT": 0.0,
    "Pioneer2DX": 0.24,
    "PeopleBot": 0.0,
    "B21R": 0.0,
    "Atrv": 0.0,
    "Roomba": 0.0,
    "SegwayRMP": 0.0,
    "ClodBuster": 0.0,
    "Shrimp": 0.2,
    "WheelChair": 1.2,
    "CarChassis": 0.0,
    "Blimp": 10.0,
    "AvatarHeli": 0.49,
    "Bandit": 0.8,
}
STEPS, ROUNDS = 300, 7
WITHOUT_POSITION = ("AvatarHeli", "Bandit")


def cost(step: Callable[[], object]) -> float:
    """Mean time of one call [s]."""
    start = time.perf_counter()
    for _ in range(STEPS):
        step()
    return (time.perf_counter() - start) / STEPS


def main() -> None:
    """Print a table."""
    print(f"{'robot':12} {'step [us]':>10} {'engine [us]':>12} {'ratio':>6} {'times real time':>16}")
    for name, height in HEIGHTS.items():
        robot = f"<model:{name}><id>r</id><xyz>0 0 {height}</xyz></model:{name}>"
        with libgz.World.from_string(f"{HEAD}{robot}</gz:world>") as world:
            if name not in WITHOUT_POSITION:
                world.interface("position", "r").command(vx=0.3, vyaw=0.1)
            world.step(STEPS)
            rounds = [(cost(world.Step), cost(world.engine.step)) for _ in range(ROUNDS)]
            whole, engine = (statistics.median(column) for column in zip(*rounds, strict=True))
            ratio = statistics.median(a / b for a, b in rounds)
            faster = world.engine.step_time / whole
            print(f"{name:12} {whole * 1e6:10.1f} {engine * 1e6:12.1f} {ratio:6.2f} {faster:16.0f}")


if __name__ == "__main__":
    main()
