"""Energy and drift over a minute of sim time with the exact and the tree solver: python benchmarks/drift.py

All figures are of the motion, so they do not depend on the machine.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from legged import legged_text
from numpy.typing import NDArray

import libgz

SECONDS, SAMPLES = 60.0, 600
GRAVITY = 9.8  # [m/s^2]
Array = NDArray[np.float64]


class Link(NamedTuple):
    """A link of a robot at rest: where it is and its hinge [m], on which other one, the axis, mass and inertia."""

    place: tuple[float, float, float]
    hinge: tuple[float, float, float]
    parent: str
    axis: tuple[int, int, int]
    mass: float
    inertia: tuple[float, float, float]  # [kg m^2]


LINK = """<link name='l{0}'><pose>{1} {2} {3} 0 0 0</pose><inertial><mass>{4}</mass><inertia><ixx>{5}</ixx>
<iyy>{6}</iyy><izz>{7}</izz></inertia></inertial></link>"""
JOINT = """<joint name='j{0}' type='revolute'><pose>{1} {2} {3} 0 0 0</pose><parent>{4}</parent><child>l{0}</child>
<axis><xyz>{5} {6} {7}</xyz></axis></joint>"""
WORLD = """<sdf version='1.6'><world name='w'><gravity>0 0 {gravity}</gravity><physics type='ode'>
<max_step_size>0.001</max_step_size><ode><solver><type>{solver}</type></solver></ode></physics>
<model name='m'><allow_auto_disable>false</allow_auto_disable>{parts}</model></world></sdf>"""


def chain() -> list[Link]:
    """20 links of 1 kg that begin level, the first one on the world."""
    return [
        Link((0.2 * i, 0, 0), (0, 0, 0), f"l{i - 1}" if i else "world", (0, 1, 0), 1.0, (0.01, 0.01, 0.01))
        for i in range(20)
    ]


def spider() -> list[Link]:
    """A free trunk with six legs of three unlike links."""
    links = [Link((0, 0, 0), (0, 0, 0), "", (0, 0, 1), 9.0, (0.04, 0.16, 0.18))]
    for leg in range(6):
        x, side = 0.2 * (leg // 2 - 1), (-1) ** leg
        for part, (reach, axis) in enumerate(((0.15, (1, 0, 0)), (0.35, (0, 1, 0)), (0.55, (1, 0, 0)))):
            parent = f"l{len(links) - 1}" if part else "l0"
            links.append(Link((x, side * reach, 0), (0, -side * 0.1, 0), parent, axis, 0.5, (0.002, 0.0003, 0.002)))
    return links


def world_of(links: list[Link], solver: str, gravity: float) -> libgz.World:
    """A world of such a robot."""
    parts = [LINK.format(i, *one.place, one.mass, *one.inertia) for i, one in enumerate(links)]
    parts += [JOINT.format(i, *one.hinge, one.parent, *one.axis) for i, one in enumerate(links) if one.parent]
    return libgz.World.from_string(WORLD.format(gravity=-gravity, solver=solver, parts="".join(parts)))


def turns(states: Array) -> Array:
    """Rotations of bodies, shape (n, 3, 3)."""
    u, x, y, z = states[:, 3:7].T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - u * z), 2 * (x * z + u * y)],
        [2 * (x * y + u * z), 1 - 2 * (x * x + z * z), 2 * (y * z - u * x)],
        [2 * (x * z - u * y), 2 * (y * z + u * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def gaps(links: list[Link], states: Array) -> Array:
    """How far apart the ends of joints are [m]."""
    rotation, found = turns(states), []
    for i, one in enumerate(links):
        if not one.parent:
            continue
        hinge = np.array(one.hinge)
        child = states[i, :3] + rotation[i] @ hinge
        start = np.array(one.place) + hinge
        if one.parent == "world":
            found.append(np.linalg.norm(child - start))
            continue
        number = int(one.parent[1:])
        parent = states[number, :3] + rotation[number] @ (start - np.array(links[number].place))
        found.append(np.linalg.norm(child - parent))
    return np.array(found)


def momenta(links: list[Link], states: Array, gravity: float) -> tuple[float, Array, Array]:
    """Energy [J], momentum [N s] and angular momentum about the origin [N m s]."""
    mass, rotation = np.array([one.mass for one in links]), turns(states)
    inertia = np.array([one.inertia for one in links])
    place, v, w = states[:, 7:10], states[:, 10:13], states[:, 13:16]
    own = np.einsum("nji,nj->ni", rotation, w)
    spin = np.einsum("nij,nj->ni", rotation, inertia * own)
    energy = 0.5 * (mass * (v**2).sum(1)).sum() + 0.5 * (inertia * own**2).sum() + gravity * (mass * place[:, 2]).sum()
    return energy, (mass[:, None] * v).sum(0), (mass[:, None] * np.cross(place, v) + spin).sum(0)


def swing(solver: str) -> dict[str, float]:
    """The chain falls and swings."""
    links = chain()
    with world_of(links, solver, GRAVITY) as world:
        start = momenta(links, world.engine.states[:20], GRAVITY)[0]
        energies, apart = [], 0.0
        for _ in range(SAMPLES):
            world.run(SECONDS / SAMPLES)
            states = world.engine.states[:20]
            energies.append(momenta(links, states, GRAVITY)[0] - start)
            apart = max(apart, gaps(links, states).max())
    depth = GRAVITY * sum(0.2 * i for i in range(20))  # released when it hangs [J]
    return {
        "largest gain of energy [% of the fall's]": 100.0 * max(0.0, *energies) / depth,
        "lost energy after 60 s [%]": -100.0 * energies[-1] / depth,
        "joints apart [um]": 1e6 * apart,
    }


def tumble(solver: str) -> dict[str, float]:
    """The spider turns in free fall, its legs loose."""
    links = spider()
    with world_of(links, solver, 0.0) as world:
        rate = np.array([0.6, 0.4, 1.0])
        for i, one in enumerate(links):
            body = world.body("m", f"l{i}")
            body.SetLinearVel(np.cross(rate, one.place) + np.array([0.1, 0.0, 0.0]))
            body.SetAngularVel(rate)
        count = len(links)
        first = momenta(links, world.engine.states[:count], 0.0)
        worst, apart, energies = np.zeros(2), 0.0, []
        for _ in range(SAMPLES):
            world.run(SECONDS / SAMPLES)
            states = world.engine.states[:count]
            energy, *others = momenta(links, states, 0.0)
            energies.append(energy / first[0] - 1.0)
            pairs = zip(others, first[1:], strict=True)
            worst = np.maximum(worst, [np.linalg.norm(a - b) / np.linalg.norm(b) for a, b in pairs])
            apart = max(apart, gaps(links, states).max())
    return {
        "largest gain of energy [%]": 100.0 * max(0.0, *energies),
        "lost energy after 60 s [%]": -100.0 * energies[-1],
        "error of momentum [%]": 100.0 * worst[0],
        "error of angular momentum [%]": 100.0 * worst[1],
        "joints apart [um]": 1e6 * apart,
    }


def stand(solver: str) -> dict[str, float]:
    """The quadruped stands by its servos."""
    with libgz.World.from_string(legged_text(1), solver=solver) as world:
        world.run(2.0)  # to its stance
        before, lowest = world.body("q0").GetPose(), np.inf
        for _ in range(SAMPLES):
            world.run((SECONDS - 2.0) / SAMPLES)
            lowest = min(lowest, world.body("q0").GetPose().pos.z)
        after = world.body("q0").GetPose()
    return {
        "moved along the ground [um]": 1e6 * float(np.hypot(after.pos.x - before.pos.x, after.pos.y - before.pos.y)),
        "sunk [um]": 1e6 * max(0.0, before.pos.z - lowest),
        "turned [urad]": 2e6 * float(np.linalg.norm(np.subtract([*after.rot][1:], [*before.rot][1:]))),
    }


SCENES: dict[str, Callable[[str], dict[str, float]]] = {"chain of 20": swing, "free robot": tumble, "standing": stand}


def main() -> None:
    """Print a table."""
    print(f"{'scene':14}{'':44}{'world':>12}{'tree':>12}   {SECONDS:g} s")
    for name, scene in SCENES.items():
        if sys.argv[1:] and name not in sys.argv[1:]:
            continue
        both: list[dict[str, Any]] = [scene(solver) for solver in ("world", "tree")]
        for what in both[0]:
            print(f"{name:14}{what:44}{both[0][what]:12.3g}{both[1][what]:12.3g}", flush=True)


if __name__ == "__main__":
    main()
