"""The time of a camera frame.

    python benchmarks/camera.py

Each ratio is the median of those of all rounds; the last column is what libgz aims at.

Twenty Pioneer2AT-like robots on textured ground, seen by one camera; the image is copied into the interface's memory.
Where MuJoCo and PyBullet are installed, they render a similar scene in the same run, in turn with libgz, so that a
machine whose speed drifts does not spoil the ratios. Neither is a dependency of libgz: pip install mujoco pybullet.
They run in their own processes, with this Python unless LIBGZ_BENCH_PYTHON names another.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence

SIZES = ((320, 240), (640, 480))
ROBOTS, ROUNDS, FRAMES = 20, 15, 40
EYE, AT = (-6.0, -5.0, 4.0), (3.0, 3.0, 0.0)

AIMS = {
    (320, "MuJoCo, default meshes"): 8,
    (320, "MuJoCo, coarse meshes"): 3,
    (320, "PyBullet TinyRenderer"): 8,
}

Render = Callable[[], object]


def places() -> list[tuple[float, float]]:
    return [(1.6 * (i % 5), 1.6 * (i // 5)) for i in range(ROBOTS)]


def libgz_frame(width: int, height: int, shadows: bool = False) -> Render:
    """One frame of a MonoCam: take a shot, render it, and copy the image into the interface."""
    import libgz
    from libgz.base.files import installed_worlds
    from libgz.base.geometry import GzPosePointAt, GzVector

    robots = "".join(
        f"<model:Pioneer2AT><id>r{i}</id><xyz>{x} {y} 0</xyz></model:Pioneer2AT>" for i, (x, y) in enumerate(places())
    )
    world = libgz.World.from_string(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:LightSource><xyz>-8 6 20</xyz></model:LightSource>"
        f"<model:GroundPlane><color>1 1 1</color><textureFile>{installed_worlds()}/grid.png</textureFile>"
        f"</model:GroundPlane>{robots}<model:MonoCam><id>c</id><imageSize>{width} {height}</imageSize>"
        "<gravity>false</gravity></model:MonoCam></gz:world>"
    )
    world.step(5)
    server = world.model("c").camera
    server.eye.options.shadows = shadows
    pose = GzPosePointAt(GzVector(*EYE), GzVector(*AT), GzVector(0.0, 0.0, 1.0))

    def render() -> object:
        server.take(pose, math.radians(60.0))
        return world

    return render


def mujoco_frame(width: int, height: int, *, coarse: bool) -> Render:
    import mujoco

    detail = '<quality shadowsize="0" offsamples="0" numslices="12" numstacks="8" numquads="1"/>'
    plain = '<quality shadowsize="0" offsamples="0"/>'
    wheels = "".join(
        f'<body pos="{x} {y} .095" quat=".7071 .7071 0 0"><joint type="hinge" axis="0 0 1"/>'
        '<geom type="cylinder" size=".1 .035" rgba=".3 .3 .3 1" mass="1"/></body>'
        for x in (0.133, -0.133)
        for y in (0.19, -0.19)
    )
    robots = "".join(
        f'<body pos="{x} {y} 0"><freejoint/>'
        '<geom type="box" size=".24 .17 .095" pos="0 0 .195" rgba="1 0 0 1" mass="10"/>'
        f'<geom type="box" size=".267 .19 .01" pos="0 0 .3" rgba="0 0 0 1" mass=".1"/>{wheels}</body>'
        for x, y in places()
    )
    forward = [a - e for a, e in zip(AT, EYE, strict=True)]
    right = (forward[1], -forward[0], 0.0)
    up = (-forward[0] * forward[2], -forward[1] * forward[2], forward[0] ** 2 + forward[1] ** 2)
    axes = " ".join(map(str, (*right, *up)))
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><visual><global offwidth="{width}" offheight="{height}"/>{detail if coarse else plain}</visual>'
        '<asset><texture name="t" type="2d" builtin="checker" width="128" height="128" rgb1="1 1 1" rgb2=".5 .5 .5"/>'
        '<material name="m" texture="t" texrepeat="50 50"/></asset><worldbody><light pos="-8 6 20" castshadow="false"/>'
        f'<geom type="plane" size="50 50 1" material="m"/>{robots}'
        f'<camera name="c" pos="{EYE[0]} {EYE[1]} {EYE[2]}" xyaxes="{axes}" fovy="46.8"/></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = mujoco.Renderer(model, height, width)
    renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
    renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0

    def render() -> object:
        renderer.update_scene(data, "c")
        return renderer.render()

    return render


def pybullet_frame(width: int, height: int) -> Render:
    import pybullet as p

    p.connect(p.DIRECT)
    p.createMultiBody(
        0, p.createCollisionShape(p.GEOM_PLANE), p.createVisualShape(p.GEOM_BOX, halfExtents=(50, 50, 0.01))
    )
    hull = p.createVisualShape(p.GEOM_BOX, halfExtents=(0.24, 0.17, 0.095), rgbaColor=(1, 0, 0, 1))
    plate = p.createVisualShape(p.GEOM_BOX, halfExtents=(0.267, 0.19, 0.01), rgbaColor=(0, 0, 0, 1))
    wheel = p.createVisualShape(p.GEOM_CYLINDER, radius=0.1, length=0.07, rgbaColor=(0.3, 0.3, 0.3, 1))
    for x, y in places():
        p.createMultiBody(0, -1, hull, (x, y, 0.195))
        p.createMultiBody(0, -1, plate, (x, y, 0.3))
        for dx in (0.133, -0.133):
            for dy in (0.19, -0.19):
                p.createMultiBody(0, -1, wheel, (x + dx, y + dy, 0.095), (0.7071, 0, 0, 0.7071))
    view = p.computeViewMatrix(EYE, AT, (0, 0, 1))
    projection = p.computeProjectionMatrixFOV(46.8, width / height, 0.5, 50)
    return lambda: p.getCameraImage(width, height, view, projection, shadow=0, renderer=p.ER_TINY_RENDERER)


RENDERERS: dict[str, Callable[[int, int], Render]] = {
    "libgz": libgz_frame,
    "libgz, with shadows": lambda w, h: libgz_frame(w, h, shadows=True),
    "MuJoCo, default meshes": lambda w, h: mujoco_frame(w, h, coarse=False),
    "MuJoCo, coarse meshes": lambda w, h: mujoco_frame(w, h, coarse=True),
    "PyBullet TinyRenderer": pybullet_frame,
}


def serve(name: str, width: int, height: int) -> None:
    """In its own process: render as many frames as each line says; print their median wall and mean CPU time [s]."""
    render = RENDERERS[name](width, height)
    render()
    for line in sys.stdin:
        times, before = [], time.process_time()
        for _ in range(int(line)):
            start = time.perf_counter()
            render()
            times.append(time.perf_counter() - start)
        print(statistics.median(times), (time.process_time() - before) / len(times), flush=True)


def measure(width: int, height: int) -> dict[str, list[tuple[float, ...]]]:
    """Wall and CPU time of a frame of each renderer that works here, in each round [s], measured in turn."""
    other = os.environ.get("LIBGZ_BENCH_PYTHON", sys.executable)
    processes = {}
    for name in RENDERERS:
        python = sys.executable if name.startswith("libgz") else other
        processes[name] = subprocess.Popen(
            [python, __file__, "--serve", name, str(width), str(height)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env={**os.environ, "MUJOCO_GL": "osmesa", "PYOPENGL_PLATFORM": "osmesa"},
        )
    times: dict[str, list[tuple[float, ...]]] = {name: [] for name in RENDERERS}
    for _ in range(ROUNDS):
        for name, process in processes.items():
            try:
                process.stdin.write(f"{FRAMES if name == 'libgz' else FRAMES // 4}\n")  # type: ignore[union-attr]
                process.stdin.flush()  # type: ignore[union-attr]
                answer = process.stdout.readline()  # type: ignore[union-attr]
            except BrokenPipeError:
                answer = ""
            if answer:
                times[name].append(tuple(map(float, answer.split())))
    for process in processes.values():
        process.communicate()
    return {name: values for name, values in times.items() if len(values) == ROUNDS}


def ratio(times: Sequence[float], base: Sequence[float]) -> float:
    """The median ratio of all rounds."""
    return statistics.median(a / b for a, b in zip(times, base, strict=True))


def main() -> None:
    if sys.argv[1:2] == ["--serve"]:
        serve(sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
        return
    for width, height in SIZES:
        times = measure(width, height)
        print(f"\n{width} x {height}, {ROBOTS} robots")
        for name in RENDERERS:
            if name not in times:
                print(f"  {name:24} not installed, or it does not work here")
                continue
            text = f"  {name:24}"
            for kind, values, base in zip(
                ("wall", "CPU"), zip(*times[name], strict=True), zip(*times["libgz"], strict=True), strict=True
            ):
                text += f"{1e3 * statistics.median(values):8.2f} ms {kind}{ratio(values, base):7.1f} x libgz"
            aim = AIMS.get((width, name))
            print(text if aim is None else f"{text}   aim {aim}")


if __name__ == "__main__":
    main()
