"""The cost of plugins' callbacks: a step with 1000 connected update callbacks, and one with none, in one run."""

from __future__ import annotations

import statistics
import time

import libgz
from libgz.classic.event import Events

CALLBACKS, STEPS, ROUNDS = 1000, 200, 15
WORLD = """
<sdf version='1.6'><world name='default'>
  <model name='box'><link name='link'>
    <collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>
  </link></model>
</world></sdf>
"""


class Listener:
    """A minimal plugin."""

    def __init__(self) -> None:
        self.count = 0

    def on_update(self, info: object) -> None:
        """Count."""
        self.count += 1


def cost(world: libgz.World) -> float:
    """The time of one step [ms]."""
    begin = time.perf_counter()
    world.step(STEPS)
    return 1e3 * (time.perf_counter() - begin) / STEPS


def main() -> None:
    """Print the table."""
    with libgz.World.from_string(WORLD) as world:
        world.step(STEPS)
        plain, loaded = [], []
        for _ in range(ROUNDS):
            plain.append(cost(world))
            listeners = [Listener() for _ in range(CALLBACKS)]
            kept = [Events.ConnectWorldUpdateBegin(listener.on_update) for listener in listeners]
            loaded.append(cost(world))
            kept.clear()
    base, full = statistics.median(plain), statistics.median(loaded)
    print(f"step without callbacks {base:.4f} ms, with {CALLBACKS} callbacks {full:.4f} ms")
    print(f"{CALLBACKS} callbacks cost {full - base:.4f} ms a step (target: at most 0.3)")


if __name__ == "__main__":
    main()
