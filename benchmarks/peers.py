"""Scenes like those of the benchmarks in MuJoCo and PyBullet, each in a process of its own.

Neither is a dependency of libgz: pip install mujoco pybullet. The processes use this Python unless LIBGZ_BENCH_PYTHON
names another. Each line that a process reads is a number of steps.
"""

from __future__ import annotations

import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any, NamedTuple, Self

__all__ = ["STEP", "Peer"]

STEP = 0.02  # [s], of all scenes
RAYS, FAR = 181, 8.0  # of the laser; [m]


class Link(NamedTuple):
    """A part of a robot: where its hinge is on the part before it, its axis, mass, shape and place of the shape."""

    place: tuple[float, float, float]
    axis: tuple[float, float, float]
    mass: float
    shape: tuple[str, tuple[float, ...]]
    centre: tuple[float, float, float]
    links: tuple[Link, ...] = ()
    foot: float = 0.0  # radius of a sphere at its end


class Robot(NamedTuple):
    """A trunk with links; its motors' gain [1/s] (0: they hold a velocity) and effort [N m]."""

    mass: float
    size: tuple[float, float, float]
    height: float
    links: tuple[Link, ...]
    gain: float
    effort: float
    targets: tuple[float, ...]  # [rad], or [rad/s]


def pioneer() -> Robot:
    """Four wheels on a box."""
    wheel = ("cylinder", (0.1, 0.07))
    wheels = [Link((x, y, -0.1), (0, 1, 0), 1.0, wheel, (0, 0, 0)) for x in (0.133, -0.133) for y in (0.19, -0.19)]
    return Robot(10.0, (0.48, 0.34, 0.19), 0.2, tuple(wheels), 0.0, 10.0, (3.0, 3.2) * 2)


def quadruped() -> Robot:
    """The robot of legged.py."""
    limb = ("box", (0.03, 0.03, 0.2))
    legs = []
    for x in (0.19, -0.19):
        for y in (0.13, -0.13):
            shank = Link((0, 0, -0.2), (0, 1, 0), 0.25, limb, (0, 0, -0.1), (), 0.025)
            thigh = Link((0, 0, 0), (0, 1, 0), 1.0, limb, (0, 0, -0.1), (shank,))
            legs.append(Link((x, y, 0), (1, 0, 0), 0.7, ("sphere", (0.04,)), (0, 0, 0), (thigh,)))
    return Robot(9.0, (0.45, 0.2, 0.1), 0.43, tuple(legs), 10.0, 30.0, (0.0, 0.5, -1.0) * 4)


def _text(values: Any) -> str:
    return " ".join(map(str, values))


# MuJoCo ----------------------------------------------------------------------------------------------------------


def _mujoco_link(link: Link, name: str, names: list[str]) -> str:
    names.append(name)
    kind, numbers = link.shape
    size = {"box": [n / 2 for n in numbers], "sphere": numbers, "cylinder": [numbers[0], numbers[-1] / 2]}[kind]
    turned = ' quat=".7071 .7071 0 0"' if kind == "cylinder" else ""
    foot = f'<geom type="sphere" size="{link.foot}" pos="0 0 -.2" mass="0"/>' if link.foot else ""
    inner = "".join(_mujoco_link(one, f"{name}_{i}", names) for i, one in enumerate(link.links))
    return (
        f'<body pos="{_text(link.place)}"><joint name="{name}" axis="{_text(link.axis)}"/>'
        f'<geom type="{kind}" size="{_text(size)}" pos="{_text(link.centre)}" mass="{link.mass}"{turned}/>'
        f"{foot}{inner}</body>"
    )


def _mujoco_text(robot: Robot, count: int) -> tuple[str, list[str]]:
    names: list[str] = []
    bodies = ""
    for i in range(count):
        links = "".join(_mujoco_link(link, f"r{i}_{k}", names) for k, link in enumerate(robot.links))
        half = _text(n / 2 for n in robot.size)
        bodies += (
            f'<body name="r{i}" pos="{2 * (i % 10)} {2 * (i // 10)} {robot.height}"><freejoint/>'
            f'<geom type="box" size="{half}" mass="{robot.mass}"/>{links}</body>'
        )
    motor = (
        '<position joint="{0}" kp="150" kv="5" forcerange="-{1} {1}"/>'
        if robot.gain
        else '<velocity joint="{0}" kv="20" forcerange="-{1} {1}"/>'
    )
    motors = "".join(motor.format(name, robot.effort) for name in names)
    return (
        f'<mujoco><option timestep="{STEP}" gravity="0 0 -9.8" integrator="implicitfast"/>'
        '<default><joint armature="0.02" damping="0.5"/><geom contype="1" conaffinity="2"/></default><worldbody>'
        f'<geom type="plane" size="100 100 1" contype="2" conaffinity="1"/>{bodies}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>",
        names,
    )


def mujoco(scene: str, count: int) -> Callable[[int], object]:
    """A function that runs steps."""
    import mujoco as engine
    import numpy as np

    robot = quadruped() if scene == "legged" else pioneer()
    text, _ = _mujoco_text(robot, count)
    model = engine.MjModel.from_xml_string(text)
    data = engine.MjData(model)
    data.ctrl[:] = robot.targets * count
    if scene != "learning":
        return lambda steps: engine.mj_step(model, data, nstep=steps)

    angles = np.linspace(-math.pi / 2, math.pi / 2, RAYS)
    local = np.stack([np.cos(angles), np.sin(angles), np.zeros(RAYS)], axis=1)
    ids, ranges = np.zeros(RAYS, np.int32), np.zeros(RAYS)
    body = model.body("r0").id

    def env_steps(steps: int) -> object:
        for _ in range(steps):
            engine.mj_step(model, data, nstep=5)
            ways = (local @ data.xmat[body].reshape(3, 3).T).ravel()
            engine.mj_multiRay(model, data, data.xpos[body], ways, None, 1, body, ids, ranges, None, RAYS, FAR)
        return ranges

    return env_steps


# PyBullet --------------------------------------------------------------------------------------------------------


def _urdf_shape(kind: str, numbers: tuple[float, ...]) -> str:
    if kind == "box":
        return f'<box size="{_text(numbers)}"/>'
    return (
        f'<sphere radius="{numbers[0]}"/>'
        if kind == "sphere"
        else f'<cylinder radius="{numbers[0]}" length="{numbers[1]}"/>'
    )


def _urdf_link(name: str, mass: float, shape: tuple[str, tuple[float, ...]], centre: Any, foot: float = 0.0) -> str:
    turned = ' rpy="1.5708 0 0"' if shape[0] == "cylinder" else ""
    inertia = max(mass, 0.1) * 0.01
    end = (
        f'<collision><origin xyz="0 0 -.2"/><geometry><sphere radius="{foot}"/></geometry></collision>' if foot else ""
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{_text(centre)}"/><mass value="{mass}"/>'
        f'<inertia ixx="{inertia}" iyy="{inertia}" izz="{inertia}" ixy="0" ixz="0" iyz="0"/></inertial>'
        f'<collision><origin xyz="{_text(centre)}"{turned}/><geometry>{_urdf_shape(*shape)}</geometry></collision>'
        f"{end}</link>"
    )


def _urdf_links(parent: str, links: tuple[Link, ...], prefix: str) -> str:
    text = ""
    for i, link in enumerate(links):
        name = f"{prefix}_{i}"
        text += _urdf_link(name, link.mass, link.shape, link.centre, link.foot)
        text += (
            f'<joint name="j{name}" type="continuous"><parent link="{parent}"/><child link="{name}"/>'
            f'<origin xyz="{_text(link.place)}"/><axis xyz="{_text(link.axis)}"/></joint>'
        )
        text += _urdf_links(name, link.links, name)
    return text


def pybullet(scene: str, count: int) -> Callable[[int], object]:
    """A function that runs steps."""
    import pybullet as engine

    robot = quadruped() if scene == "legged" else pioneer()
    engine.connect(engine.DIRECT)
    engine.setTimeStep(STEP)
    engine.setGravity(0, 0, -9.8)
    engine.setPhysicsEngineParameter(numSolverIterations=20)
    engine.createMultiBody(0, engine.createCollisionShape(engine.GEOM_PLANE))
    trunk = _urdf_link("trunk", robot.mass, ("box", robot.size), (0, 0, 0))
    with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
        file.write(f'<robot name="r">{trunk}{_urdf_links("trunk", robot.links, "l")}</robot>')
        file.flush()
        for i in range(count):
            one = engine.loadURDF(file.name, (2 * (i % 10), 2 * (i // 10), robot.height))
            for joint in range(engine.getNumJoints(one)):
                mode = (
                    {"targetPosition": robot.targets[joint]} if robot.gain else {"targetVelocity": robot.targets[joint]}
                )
                kind = engine.POSITION_CONTROL if robot.gain else engine.VELOCITY_CONTROL
                engine.setJointMotorControl2(one, joint, kind, force=robot.effort, **mode)
    if scene != "learning":

        def run(steps: int) -> None:
            for _ in range(steps):
                engine.stepSimulation()

        return run

    def env_steps(steps: int) -> object:
        found: object = None
        for _ in range(steps):
            for _ in range(5):
                engine.stepSimulation()
            (x, y, z), rotation = engine.getBasePositionAndOrientation(1)
            yaw = engine.getEulerFromQuaternion(rotation)[2] - math.pi / 2
            ways = [
                (math.cos(yaw + k * math.pi / (RAYS - 1)), math.sin(yaw + k * math.pi / (RAYS - 1)))
                for k in range(RAYS)
            ]
            ends = [(x + FAR * a, y + FAR * b, z) for a, b in ways]
            found = engine.rayTestBatch([(x, y, z)] * RAYS, ends)
        return found

    return env_steps


ENGINES = {"MuJoCo": mujoco, "PyBullet": pybullet}


class Peer:
    """A process that steps a scene in another engine; it is called with a number of steps.

    Attributes:
        works: whether the engine is installed.

    Args:
        name: of the engine.
        scene: ``pioneers``, ``legged`` or ``learning``.
        count: of robots.
    """

    def __init__(self, name: str, scene: str, count: int = 1) -> None:
        python = os.environ.get("LIBGZ_BENCH_PYTHON", sys.executable)
        self._process = subprocess.Popen(
            [python, __file__, name, scene, str(count)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=None if os.environ.get("LIBGZ_BENCH_VERBOSE") else subprocess.DEVNULL,
            text=True,
        )
        self.works = bool(self._process.stdout) and self._process.stdout.readline().strip() == "ready"

    def __call__(self, steps: int) -> tuple[float, float]:
        """Run steps; real time and processor time of each [s]."""
        if self._process.stdin is None or self._process.stdout is None:
            raise SystemExit("the process has no input or output")
        self._process.stdin.write(f"{steps}\n")
        self._process.stdin.flush()
        wall, cpu = map(float, self._process.stdout.readline().split())
        return wall / steps, cpu / steps

    def close(self) -> None:
        """End the process."""
        self._process.communicate()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def main(name: str, scene: str, count: str) -> None:
    """The process."""
    run = ENGINES[name](scene, int(count))
    run(100)
    print("ready", flush=True)
    for line in sys.stdin:
        wall, cpu = time.perf_counter(), time.process_time()
        run(int(line))
        print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
