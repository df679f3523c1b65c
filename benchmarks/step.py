"""The cost of a step.

    python benchmarks/step.py            both tables
    python benchmarks/step.py engine     the engine's step, as a ratio to the same ODE calls in C
    python benchmarks/step.py gazebo     a whole headless `gazebo` with driving Pioneer2ATs

Ratios are of medians taken in turn within one run, so that a change of the machine's speed affects both sides.
"""

from __future__ import annotations

import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import libgz
from libgz.physics.engine import Engine
from libgz.physics.space import Space

HERE = Path(__file__).parent
ROUNDS = 7
ON_ITS_SIDE = (0.70710678118654757, 0.70710678118654757, 0.0, 0.0)


def build(robots: int) -> Engine:
    """The world of step_reference.c: four-wheeled robots and boxes on a plane, each in a space of its own."""
    engine = Engine(step_time=0.01)
    ground = libgz.Body(engine, dummy=True)
    plane = libgz.PlaneGeom(ground, Space(engine), 0.0, (0, 0, 1))
    plane.SetHardness(math.inf, 0)
    plane.SetFriction(1)

    def part(geom: libgz.Geom, mass: float, place: tuple[float, float, float], kp: float) -> libgz.Body:
        geom.SetMass(mass)
        geom.SetFriction(1)
        geom.SetHardness(kp, 0)
        geom.body.SetPosition(place)
        return geom.body

    for i in range(robots):
        x, y, space = 2.0 * (i % 10), 2.0 * (i // 10), Space(engine)
        chassis = part(libgz.BoxGeom(libgz.Body(engine), space, 0.5, 0.35, 0.2), 10, (x, y, 0.2), 1e4)
        for w in range(4):
            place = (x + (0.13 if w < 2 else -0.13), y + (-0.19 if w % 2 else 0.19), 0.1)
            wheel = part(libgz.CylinderGeom(libgz.Body(engine), space, 0.1, 0.05), 1, place, 1e4)
            wheel.SetRotation(ON_ITS_SIDE)
            hinge = libgz.HingeJoint(engine)
            hinge.Attach(wheel, chassis)
            hinge.SetAnchor(place)
            hinge.SetAxis((0, 1, 0))
            hinge.SetParam(libgz.dParamVel, 1)
            hinge.SetParam(libgz.dParamFMax, 10)
        part(libgz.BoxGeom(libgz.Body(engine), Space(engine), 0.3, 0.3, 0.3), 1, (x + 1, y + 1, 0.15), 1e6)
    return engine


def time_engine(form: str, robots: int, steps: int) -> tuple[float, float]:
    """(microseconds a step, final position of the first robot [m])."""
    os.environ["LIBGZ_STEP"] = form
    engine = build(robots)
    for _ in range(200):
        engine.step()
    begin = time.perf_counter()
    for _ in range(steps):
        engine.step()
    taken = (time.perf_counter() - begin) / steps * 1e6
    end = float(engine.states[0, 7])
    engine.close()
    return taken, end


def build_reference(compiler: str, folder: str) -> Path:
    """Compile step_reference.c."""
    program = Path(folder) / "step_reference"
    source = HERE / "step_reference.c"
    subprocess.run([compiler, "-O2", source, "-o", program, "-l:libode.so.8", "-lm"], check=True)
    return program


def time_c(program: Path, robots: int, steps: int) -> tuple[float, float]:
    """(microseconds a step, final position of the first robot [m]) of the C program."""
    done = subprocess.run([program, str(robots), str(steps)], check=True, capture_output=True, text=True)
    microseconds, end = done.stdout.split()[:2]
    return float(microseconds), float(end)


def engine_table() -> None:
    """Ratios to bare C for the native and the Python step."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        print("no C compiler here: the reference cannot be built")
        return
    print("engine step: world of n robots and n boxes, 10 ms, states copied out; medians of", ROUNDS)
    print(f"{'n':>5}{'C [us]':>10}{'native/C':>10}{'python/C':>10}   end of the first robot equal to C's")
    with tempfile.TemporaryDirectory() as folder:
        program = build_reference(compiler, folder)
        for robots, steps in ((1, 20000), (10, 2000), (100, 200)):
            taken: dict[str, list[float]] = {"c": [], "native": [], "python": []}
            ends = {}
            for _ in range(ROUNDS):
                microseconds, ends["c"] = time_c(program, robots, steps)
                taken["c"].append(microseconds)
                for form in ("native", "python"):
                    microseconds, ends[form] = time_engine(form, robots, steps)
                    taken[form].append(microseconds)
            medians = {form: statistics.median(values) for form, values in taken.items()}
            same = all(abs(end - ends["c"]) < 1e-11 for end in ends.values())
            ratios = (medians[form] / medians["c"] for form in ("native", "python"))
            print(f"{robots:5}{medians['c']:10.1f}" + "".join(f"{r:10.3f}" for r in ratios) + f"   {same}")


ROBOT = "<model:Pioneer2AT><id>r{0}</id><xyz>{1} {2} 0</xyz></model:Pioneer2AT>"
NUMBERS = (1, 10, 50)
SERVER_ROUNDS = 3


def gazebo_table() -> None:
    """Microseconds a step of the whole command, as its clients see it, beside bare ODE calls in C."""
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        print("no C compiler here: the reference cannot be built")
        return
    print(
        "\ngazebo -n: n driving Pioneer2ATs with sonars, 20 ms steps, no camera; C: ODE alone with n robots and boxes"
    )
    print(f"{'n':>5}{'C [us]':>10}{'step [us]':>12}{'step/C':>10}   medians of {SERVER_ROUNDS}")
    with tempfile.TemporaryDirectory() as folder:
        program = build_reference(compiler, folder)
        env = {**os.environ, "TMP": folder, "USER": "bench", "LIBGZ_STEP": "auto"}
        os.environ.update(env)
        for number in NUMBERS:
            robots = "".join(ROBOT.format(i, 3 * (i % 10), 3 * (i // 10)) for i in range(number))
            world = Path(folder) / "bench.world"
            world.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>{robots}</gz:world>")
            pairs = [
                (time_c(program, number, 20000 // number)[0], time_gazebo(world, number, env))
                for _ in range(SERVER_ROUNDS)
            ]
            bare, measured = (statistics.median(column) for column in zip(*pairs, strict=True))
            ratio = statistics.median(step / c for c, step in pairs)
            print(f"{number:5}{bare:10.1f}{measured:12.1f}{ratio:10.2f}")


def time_gazebo(world: Path, robots: int, env: dict[str, str]) -> float:
    """Run the command, drive all robots, and read both times twice."""
    command = [sys.executable, "-m", "libgz.apps.gazebo", "-s", "auto", "-n", "-d", "0", str(world)]
    with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True) as server:
        number = int((server.stdout.readline() if server.stdout else "").split()[-1])
        with libgz.Client(number, timeout=20.0) as client:
            for i in range(robots):
                client.position(f"r{i}").command(vx=0.3, vyaw=0.3)
            sim = client.sim()
            time.sleep(1.0)
            with sim.locked() as data:
                first = (data.sim_time, data.real_time)
            time.sleep(3.0)
            with sim.locked() as data:
                last = (data.sim_time, data.real_time)
        server.terminate()
    steps = (last[0] - first[0]) / 0.02
    return (last[1] - first[1]) / steps * 1e6


if __name__ == "__main__":
    what = sys.argv[1:] or ["engine", "gazebo"]
    if "engine" in what:
        engine_table()
    if "gazebo" in what:
        gazebo_table()
