"""Robots with lasers that drive on a plane, and the comparison of two kinds of blocks of their steps."""

from __future__ import annotations

import statistics

import libgz

__all__ = ["drive", "fastest", "ratio_text", "world_text"]


def world_text(count: int, in_row: int) -> str:
    """A worldfile with robots in rows of 2 m, each with a laser."""
    robots = "".join(
        f"<model:Pioneer2AT><id>r{i}</id><xyz>{2 * (i % in_row)} {2 * (i // in_row)} 0</xyz>"
        f"<model:SickLMS200><id>l{i}</id><xyz>0.15 0 0.2</xyz></model:SickLMS200></model:Pioneer2AT>"
        for i in range(count)
    )
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robots}</gz:world>"


def drive(world: libgz.World, count: int) -> None:
    """Give each robot a velocity command of its own, and let them settle."""
    for i in range(count):
        world.interface("position", f"r{i}").command(vx=0.2, vyaw=0.02 * (i % 7 - 3))
    world.step(100)


def fastest(times: list[float]) -> float:
    """The fastest tenth of blocks, which other processes of the machine have disturbed least."""
    return statistics.quantiles(times, n=10)[0]


def ratio_text(rounds: list[tuple[float, float]]) -> str:
    """The median ratio of two kinds of blocks, its 95 % interval, and the ratio of the fastest blocks.

    The interval is that of order statistics, whatever the distribution: 0.98 sqrt(n) places around the middle.
    """
    ratios = sorted(after / before for before, after in rounds)
    reach = 0.98 * len(ratios) ** 0.5
    low, high = ratios[max(0, int(len(ratios) / 2 - reach))], ratios[min(len(ratios) - 1, int(len(ratios) / 2 + reach))]
    before, after = (fastest(list(times)) for times in zip(*rounds, strict=True))
    median, low, high, best = (100 * (x - 1) for x in (statistics.median(ratios), low, high, after / before))
    return f"{median:+6.2f} %, 95 % interval {low:+.2f} to {high:+.2f}; of the fastest {best:+6.2f} %"
