"""The engine's step over the same calls of ODE in a C loop.

python benchmarks/step.py

The whole server is in figures.py.
"""

from __future__ import annotations

from contextlib import ExitStack

from reference import Reference, scene_of
from rounds import Run, of_calls, take_turns
from scale import text

import libgz

NUMBERS = (1, 10, 100)


def main() -> None:
    """Print a table."""
    print(f"{'Pioneer2ATs':>12}{'C [us]':>10}{'step/C':>10}   processor time; same motion as in C")
    for number in NUMBERS:
        with ExitStack() as stack:
            runs: dict[str, Run] = {}
            worlds = []
            world = stack.enter_context(libgz.World.from_string(text(number)))
            for i in range(number):
                world.interface("position", f"r{i}").command(vx=0.2, vyaw=0.1)
            world.step(60)
            worlds.append(world)
            runs["step"] = of_calls(world.engine.step)
            loop = stack.enter_context(Reference(scene_of(worlds[0], sensors=False)))
            loop.run(50)
            for world in worlds:
                world.engine.sort_geoms()
                for _ in range(50):
                    world.engine.step()
            places = [world.engine.bodies[0].GetCoMPose().pos for world in worlds]
            same = all(abs(a - b) < 1e-3 for place in places for a, b in zip(place, loop.position, strict=True))
            times = take_turns({"C": loop.run, **runs})
        ratios = "".join(f"{times.ratio(form, 'C'):10.3f}" for form in runs)
        print(f"{number:12}{times.median('C') * 1e6:10.1f}{ratios}   {same}")


if __name__ == "__main__":
    main()
