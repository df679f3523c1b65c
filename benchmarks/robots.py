"""The cost of robots: a step of the world with a robot, compared with the step of the engine alone.

python benchmarks/robots.py

Both begin from the same states of one run, so that the robot does the same in both.
"""

from __future__ import annotations

import statistics

from reference import Spent
from rounds import ROUNDS, spend

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
AIMS = {"Blimp": 3.0}  # of the ratio; 1.3 of the others
STEPS, MOMENTS = 20, 8  # in a block, whose states hardly differ; blocks in a round
WITHOUT_POSITION = ("AvatarHeli", "Bandit")


def measure(name: str) -> tuple[list[Spent], list[Spent]]:
    """The time of whole steps, and of those of the engine alone, in each round."""
    robot = f"<model:{name}><id>r</id><xyz>0 0 {HEIGHTS[name]}</xyz></model:{name}>"
    whole, engine = [], []
    with libgz.World.from_string(f"{HEAD}{robot}</gz:world>") as world:
        if name not in WITHOUT_POSITION:
            world.interface("position", "r").command(vx=0.3, vyaw=0.1)
        world.step(100)
        for _ in range(ROUNDS):
            found: tuple[list[Spent], list[Spent]] = [], []
            for _ in range(MOMENTS):
                state = world.get_state()
                for side, step in zip(found, (world.step, lambda count: _steps(world.engine, count)), strict=True):
                    world.set_state(state)
                    step(5)  # the first one builds rows
                    side.append(spend(STEPS, lambda step=step: step(STEPS)))
                world.set_state(state)
                world.step(STEPS)
            for side, blocks in zip((whole, engine), found, strict=True):
                side.append(Spent(*(statistics.median(column) for column in zip(*blocks, strict=True))))
    return whole, engine


def _steps(engine: object, count: int) -> None:
    for _ in range(count):
        engine.step()  # type: ignore[attr-defined]


def main() -> None:
    """Print a table."""
    print(f"{'robot':12} {'step [us]':>10} {'engine [us]':>12} {'ratio':>6} {'times real time':>16}   processor time")
    for name in HEIGHTS:
        whole, engine = measure(name)
        one, two = (statistics.median(spent.cpu for spent in side) for side in (whole, engine))
        ratio = statistics.median(a.cpu / b.cpu for a, b in zip(whole, engine, strict=True))
        print(f"{name:12} {one * 1e6:10.1f} {two * 1e6:12.1f} {ratio:6.2f} {0.02 / one:16.0f}")


if __name__ == "__main__":
    main()
