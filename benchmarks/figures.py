"""One table of what libgz costs, each figure with its aim.

    python benchmarks/figures.py             all figures
    python benchmarks/figures.py gazebo legs some of them

All sides of a figure take turns within the run; figures are medians of the rounds' ratios. docs/performance.md explains
them. MuJoCo and PyBullet take part where they are installed (pip install mujoco pybullet), with this Python unless
LIBGZ_BENCH_PYTHON names another.
"""

from __future__ import annotations

import math
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import robots
from laser_robots import world_text as laser_text
from legged import legged_text
from peers import Peer
from reference import Reference, Spent, scene_of
from rounds import ROUNDS, Run, ServerRun, Times, of_calls, spend, take_turns
from scale import text as pioneers_text

import libgz

WIDTH = 64


class Figure(NamedTuple):
    """A line of the table.

    Attributes:
        name: what is compared.
        value: by processor time, unless `unit` says otherwise.
        wall: by real time; None: not measured.
        aim: 0: none, the figure is only shown.
        least: whether the value should be at least the aim; else at most.
        note: of the absolute times behind it.
    """

    name: str
    value: float
    wall: float | None = None
    aim: float = 0.0
    least: bool = False
    note: str = ""


def _ratio(name: str, times: Times, one: str, base: str, aim: float = 0.0, steps: float = 1.0) -> Figure:
    note = f"{times.median(one) * steps * 1e6:.4g} us; {times.median(base) * steps * 1e6:.4g} us"
    return Figure(name, times.ratio(one, base), times.ratio(one, base, "wall"), aim, note=note)


def _drive(count: int, client: Any) -> None:
    """Give each robot a command, through a client or in the process."""
    for i in range(count):
        position = client.position(f"r{i}") if hasattr(client, "position") else client.interface("position", f"r{i}")
        position.command(vx=0.2, vyaw=0.1)


def _driven(text: str, count: int, solver: str = "world") -> libgz.World:
    world = libgz.World.from_string(text, solver=solver)
    _drive(count, world)
    world.step(60)
    return world


def _own(world: libgz.World) -> Run:
    return lambda steps: spend(steps, lambda: world.step(steps))


def _peers(stack: ExitStack, scene: str, count: int = 1) -> dict[str, Run]:
    """The engines that are installed, as runs."""
    found = {name: stack.enter_context(Peer(name, scene, count)) for name in ("MuJoCo", "PyBullet")}
    return {name: (lambda steps, peer=peer: Spent(*peer(steps))) for name, peer in found.items() if peer.works}


# The figures -----------------------------------------------------------------------------------------------------


def gazebo() -> Iterator[Figure]:
    """A whole server with driving robots, over the C loop without their sonars; its memory."""
    for count, aim in ((1, 1.6), (10, 1.2), (50, 1.15)):
        text = pioneers_text(count)
        with ExitStack() as stack, _driven(text, count) as world:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
            server = stack.enter_context(ServerRun(folder, text, partial(_drive, count)))
            loop = stack.enter_context(Reference(scene_of(world, sensors=False)))
            times = take_turns({"gazebo": server, "C": loop.run}, seconds=0.3)
            if count == 1:
                yield Figure("memory of a server with one robot [MB]", server.resident, aim=40.0)
        yield _ratio(f"gazebo -n, {count} Pioneer2AT with sonars / C loop", times, "gazebo", "C", aim)


def lasers() -> Iterator[Figure]:
    """A whole server with lasers over the C loop that casts the same rays and writes the same structs; one scan."""
    count = 10
    text = laser_text(count, 5)
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        server = stack.enter_context(ServerRun(folder, text, partial(_drive, count)))
        with libgz.World.from_string(text, server_id=900_000 + os.getpid()) as world:  # with files and locks
            _drive(count, world)
            world.step(60)
            loop = stack.enter_context(Reference(scene_of(world)))
        times = take_turns({"gazebo": server, "C": loop.run}, seconds=0.3)
    yield _ratio(f"gazebo -n, {count} SickLMS200 / C loop with rays and structs", times, "gazebo", "C", 1.2)

    boxes = "".join(
        f"<model:SimpleSolid><id>b{i}</id><xyz>{3 * math.cos(i)} {3 * math.sin(i)} {0.01 * i}</xyz>"
        "<size>0.2 0.2 1</size></model:SimpleSolid>"
        for i in range(100)
    )
    sick = "<model:SickLMS200><id>l</id><rayCount>361</rayCount><rangeCount>361</rangeCount></model:SickLMS200>"
    head = "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
    with libgz.World.from_string(f"{head}{sick}{boxes}</gz:world>") as world:
        world.step()
        model, rows = world.model("l"), world.rows
        rate, scan = model.rate, model.rays._scan

        def update() -> None:
            rate.last = -math.inf
            rows.run(rows.begin, rows.end)

        times = take_turns({"update": of_calls(update), "rays": of_calls(scan)})
    yield _ratio("SickLMS200, 361 rays: whole update / rays alone", times, "update", "rays", 1.2)


def robot_models() -> Iterator[Figure]:
    """The whole step of each driven robot over its engine step."""
    for name in robots.HEIGHTS:
        whole, engine = robots.measure(name)
        pairs = list(zip(whole, engine, strict=True))
        value, wall = (
            statistics.median(getattr(a, kind) / getattr(b, kind) for a, b in pairs) for kind in ("cpu", "wall")
        )
        one, two = (statistics.median(spent.cpu for spent in side) * 1e6 for side in (whole, engine))
        yield Figure(
            f"{name}: whole step / engine step",
            value,
            wall,
            robots.AIMS.get(name, 1.3),
            note=f"{one:.4g} us; {two:.4g} us",
        )


def legs() -> Iterator[Figure]:
    """A robot with twelve joints beside one with wheels: over the C loop, and other engines over libgz."""
    for scene, text, count in (("legged", legged_text(1), 0), ("pioneers", pioneers_text(10), 10)):
        what = "12 joints on four legs" if scene == "legged" else "10 Pioneer2AT"
        with ExitStack() as stack, _driven(text, count) as world, _driven(text, count, "tree") as other:
            loop = stack.enter_context(Reference(scene_of(world, sensors=False)))
            runs = {"libgz": _own(world), "C": loop.run, "tree": _own(other), **_peers(stack, scene, max(count, 1))}
            times = take_turns(runs)
        yield _ratio(f"{what}: in process / C loop", times, "libgz", "C")
        yield _ratio(f"{what}: solver tree / default", times, "tree", "libgz")
        for name in list(runs)[3:]:
            yield _ratio(f"{what}: {name} / libgz", times, name, "libgz")
            yield _ratio(f"{what}: solver tree / {name}", times, "tree", name)


def start() -> Iterator[Figure]:
    """Processor time of commands over that of Python with numpy."""
    as_installed = "import sys; from libgz.apps.launch import {0}; sys.exit({0}())"
    gazebo = ["-c", as_installed.format("gazebo"), "--steps", "1"]
    commands = {
        "numpy": ["-c", "import numpy"],
        "gazebo --steps 1": [*gazebo, "pioneer2at"],
        "gazebo --steps 1, camera": [*gazebo, "ptz"],
        "gzserver --iters 1": ["-c", as_installed.format("gzserver"), "--iters", "1"],
    }

    with tempfile.TemporaryDirectory() as folder:
        settings = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "TMP": folder, "USER": "bench", "HOME": folder}
        settings["GAZEBO_MASTER_URI"] = "http://localhost:0"
        settings.pop("PYTHONDONTWRITEBYTECODE", None)

        def run(arguments: list[str], _steps: int) -> Spent:
            before, wall = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            subprocess.run([sys.executable, *arguments], env=settings, check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            return Spent(time.perf_counter() - wall, cpu)

        runs: dict[str, Run] = {name: partial(run, arguments) for name, arguments in commands.items()}
        for one in runs.values():
            one(1)  # writes bytecode
        times = take_turns(runs, seconds=0.001)
    for name, aim in (("gazebo --steps 1", 1.8), ("gazebo --steps 1, camera", 3.5), ("gzserver --iters 1", 1.8)):
        yield _ratio(f"start: {name} / python with numpy", times, name, "numpy", aim)


def scale() -> Iterator[Figure]:
    """Cost per robot, sleeping boxes, and loading."""
    counts = (10, 400, 1000)
    with ExitStack() as stack:
        runs: dict[str, Run] = {}
        for count in counts:
            world = stack.enter_context(_driven(pioneers_text(count), count))
            runs[f"{count}"] = _own(world)
            runs[f"C {count}"] = stack.enter_context(Reference(scene_of(world, sensors=False))).run
        times = take_turns(runs)
    for count in counts[1:]:
        for kind, aim in (("", 1.1), ("C ", 0.0)):
            pair = f"{kind}{count}", f"{kind}10"
            per = [times.ratio(*pair, clock) * 10 / count for clock in ("cpu", "wall")]
            one, ten = (times.median(f"{kind}{n}") / n * 1e6 for n in (count, 10))
            what = "the same in the C loop" if kind else f"cost per robot at {count} / at 10"
            yield Figure(what, *per, aim, note=f"{one:.4g} us; {ten:.4g} us")

    head, ground = "<sdf version='1.6'><world name='w'>", "<include><uri>model://ground_plane</uri></include>"
    with ExitStack() as stack:
        sleeping = stack.enter_context(libgz.World.from_string(f"{head}{ground}{boxes_text(10_000)}</world></sdf>"))
        sleeping.step(3)
        for body in sleeping.engine.bodies.values():
            body.Enable(False)  # which they would do themselves after 1 s
        sleeping.step(3)
        empty = stack.enter_context(libgz.World.from_string(f"{head}{ground}</world></sdf>"))
        times = take_turns({"boxes": _own(sleeping), "empty": _own(empty)})
    yield _ratio("10,000 boxes at rest, auto-disable / empty world", times, "boxes", "empty", 3.0)

    for what, text in (("SDF", f"{head}{ground}{boxes_text(5000)}</world></sdf>"), ("legacy", solids_text(5000))):
        spent = []
        for _ in range(3):
            before = time.process_time(), time.perf_counter()
            with libgz.World.from_string(text):
                spent.append(Spent(time.perf_counter() - before[1], time.process_time() - before[0]))
        value, wall = (statistics.median(getattr(one, kind) for one in spent) for kind in ("cpu", "wall"))
        yield Figure(f"5,000 models of an {what} world loaded [s]", value, wall, 5.0)


def boxes_text(count: int) -> str:
    """Boxes of SDF on a square, 1 m apart."""
    side = math.ceil(math.sqrt(count))
    shape = "<geometry><box><size>.5 .5 .5</size></box></geometry>"
    return "".join(
        f"<model name='b{i}'><pose>{i % side} {i // side} 0.25 0 0 0</pose><link name='link'>"
        f"<inertial><mass>1</mass><inertia><ixx>.04</ixx><iyy>.04</iyy><izz>.04</izz></inertia></inertial>"
        f"<collision name='c'>{shape}</collision><visual name='v'>{shape}</visual></link></model>"
        for i in range(count)
    )


def solids_text(count: int) -> str:
    """Boxes of a legacy world on a square, 1 m apart."""
    side = math.ceil(math.sqrt(count))
    boxes = "".join(
        f"<model:SimpleSolid><id>b{i}</id><xyz>{i % side} {i // side} 0</xyz></model:SimpleSolid>" for i in range(count)
    )
    return f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{boxes}</gz:world>"


def camera() -> Iterator[Figure]:
    """A frame of other renderers over that of libgz."""
    import camera as frames

    found = frames.measure(320, 240)
    times = Times([{name: Spent(*spent[number]) for name, spent in found.items()} for number in range(frames.ROUNDS)])
    frame = (times.median("libgz", kind) * 1e3 for kind in ("cpu", "wall"))
    yield Figure("camera 320x240, 20 robots: a frame [ms]", *frame)
    for (width, name), aim in frames.AIMS.items():
        if width == 320 and name in found:
            ratios = (times.ratio(name, "libgz", kind) for kind in ("cpu", "wall"))
            note = f"{times.median(name) * 1e3:.3g} ms"
            yield Figure(f"camera 320x240: {name} / libgz", *ratios, aim, True, note)


def learning() -> Iterator[Figure]:
    """Env steps of five steps and 181 rays: their rate over that of the C loop, and of others."""
    laser = "<model:SickLMS200><id>l0</id><xyz>0.15 0 0.2</xyz><rayCount>181</rayCount></model:SickLMS200>"
    robot = f"<model:Pioneer2AT><id>r0</id>{laser}</model:Pioneer2AT>"
    text = f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robot}</gz:world>"
    with ExitStack() as stack, _driven(text, 1) as world:
        loop = stack.enter_context(Reference(scene_of(world)))
        batch = world.batch(
            [("position.r0", "cmd_vel_pos[0]", "cmd_vel_rot[2]")],
            [("laser.l0", "ranges"), ("position.r0", "pos", "rot[2]")],
        )
        command = batch.commands.copy()
        runs = {
            "libgz": of_calls(lambda: batch.step(command, steps=5)),
            "C": lambda steps: Spent(*(5 * kind for kind in loop.run(5 * steps))),
            **_peers(stack, "learning"),
        }
        times = take_turns(runs)
    for name in ("C", "MuJoCo", "PyBullet"):
        if name in runs:
            rates = 1.0 / times.median("libgz"), 1.0 / times.median(name)
            values = times.ratio(name, "libgz"), times.ratio(name, "libgz", "wall")
            note = f"{rates[0]:.0f}/s; {rates[1]:.0f}/s"
            aim = 0.8 if name == "C" else 0.0
            yield Figure(f"learning loop, env steps per second: libgz / {name}", *values, aim, True, note)


FIGURES: dict[str, Callable[[], Iterator[Figure]]] = {
    "gazebo": gazebo,
    "lasers": lasers,
    "robots": robot_models,
    "legs": legs,
    "start": start,
    "scale": scale,
    "camera": camera,
    "learning": learning,
}


def show(figure: Figure) -> None:
    """Print a line of the table."""
    wall = "" if figure.wall is None else f"{figure.wall:.3g}"
    aim, met = "", ""
    if figure.aim:
        aim = f"{'>=' if figure.least else '<='} {figure.aim:g}"
        met = "met" if (figure.value >= figure.aim) == figure.least or figure.value == figure.aim else "missed"
    print(f"{figure.name:{WIDTH}}{figure.value:8.3g}{wall:>8}{aim:>9}  {met:7} {figure.note}", flush=True)


def main(names: list[str]) -> None:
    """Print the table."""
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        raise SystemExit(f"there is no figure {unknown[0]!r}; there are {', '.join(FIGURES)}")
    print(f"{'medians of ' + str(ROUNDS) + ' rounds':{WIDTH}}{'CPU':>8}{'real':>8}{'aim':>9}")
    for name in names or FIGURES:
        for figure in FIGURES[name]():
            show(figure)


if __name__ == "__main__":
    main(sys.argv[1:])
