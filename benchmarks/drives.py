"""What drives cost a step: ten models of a kind, by laws and by the same functions in Python, in turns in one run.

    python benchmarks/drives.py [mimic] [planar] [ackermann]

Prints the processor time of a step with and without laws, and without plugins. Needs a quiet machine.
"""

from __future__ import annotations

import contextlib
import logging
import statistics
import sys
import time

import libgz
from libgz.classic.server import attach
from libgz.sdfworld.mimic import Mimic

MODELS, BLOCK, ROUNDS = 10, 1000, 15
INERTIA = "<inertial><mass>1</mass><inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1</izz></inertia></inertial>"
LIMIT = "<limit><lower>-1</lower><upper>1</upper><effort>30</effort><velocity>2</velocity></limit>"
BALL = "<collision name='c'><geometry><sphere><radius>.1</radius></sphere></geometry></collision>"


def link(name: str, place: str, inside: str = "") -> str:
    """A link."""
    return f"<link name='{name}'><pose>{place}</pose>{INERTIA}{inside}</link>"


def joint(name: str, parent: str, child: str, axis: str, inside: str = "") -> str:
    """A hinge."""
    return (
        f"<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{child}</child><axis>"
        f"<xyz>{axis}</xyz>{inside}</axis></joint>"
    )


def mimic(plugin: bool) -> str:
    """A leader and a follower."""
    follow = "<mimic joint='a'><multiplier>-1</multiplier></mimic>" if plugin else ""
    joints = joint("a", "world", "la", "0 0 1", LIMIT) + joint("b", "world", "lb", "0 0 1", LIMIT + follow)
    return link("la", "0 0 1 0 0 0") + link("lb", "0 1 1 0 0 0") + joints


def planar(plugin: bool) -> str:
    """A ball that is moved."""
    driver = "<plugin name='p' filename='libgazebo_ros_planar_move.so'/>" if plugin else ""
    return link("l", "0 0 1 0 0 0", "<gravity>0</gravity>") + driver


def ackermann(plugin: bool) -> str:
    """A car."""
    parts = link("base", "0 0 .2 0 0 0")
    tags = ""
    for end, x in (("front", 0.4), ("rear", -0.4)):
        for side, y in (("left", 0.3), ("right", -0.3)):
            name, holder = f"{end}_{side}", "base"
            if end == "front":
                holder = f"{side}_knuckle"
                parts += link(holder, f"{x} {y} .1 0 0 0") + joint(f"{side}_steering", "base", holder, "0 0 1")
                tags += f"<{side}_steering_joint>{side}_steering</{side}_steering_joint>"
            parts += link(name, f"{x} {y} .1 0 0 0", BALL) + joint(f"{name}_j", holder, name, "0 1 0")
            tags += f"<{name}_joint>{name}_j</{name}_joint>"
    driver = f"<plugin name='p' filename='libgazebo_ros_ackermann_drive.so'>{tags}</plugin>" if plugin else ""
    return parts + driver


KINDS = {one.__name__: one for one in (mimic, planar, ackermann)}


@contextlib.contextmanager
def in_python(world: libgz.World) -> object:
    """Lets the drives of a world be functions of Python while it begins."""
    functions = [Mimic.update]
    for model in attach(world).world.Models():
        functions += [type(one.plugin).OnUpdate for one in world.facade.server.plugins.of_model(model)]
    for function in functions:
        function.is_law = False
    yield
    for function in functions:
        function.is_law = True


def make(kind: str, plugin: bool) -> libgz.World:
    """A world of ten models of a kind."""
    models = "".join(
        f"<model name='m{n}'><pose>{3 * n} 0 0 0 0 0</pose>{KINDS[kind](plugin)}</model>" for n in range(MODELS)
    )
    ground = "<include><uri>model://ground_plane</uri></include>"
    return libgz.World.from_string(f"<sdf version='1.6'><world name='default'>{ground}{models}</world></sdf>")


def cost(world: libgz.World) -> float:
    """The processor time of a step [us]."""
    begin = time.process_time()
    world.step(BLOCK)
    return 1e6 * (time.process_time() - begin) / BLOCK


def main(names: list[str]) -> None:
    """Print a line for each kind."""
    logging.disable(logging.WARNING)
    for name in names or list(KINDS):
        with make(name, True) as by_law, make(name, True) as plain, make(name, False) as bare:
            for world in (by_law, bare):
                world.step(BLOCK)
            with in_python(plain):
                plain.step(BLOCK)
            rounds = [(cost(by_law), cost(plain), cost(bare)) for _ in range(ROUNDS)]
        law, python, none = (statistics.median(values) for values in zip(*rounds, strict=True))
        print(f"{name:10} {law:7.1f} us by laws, {python:7.1f} in Python, {none:7.1f} without plugins", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
