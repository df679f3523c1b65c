"""The cost of the shared-memory interfaces.

    python benchmarks/wire.py

Measures publishing a position, publishing an image, and the time until a waiting client wakes. The actions alternate
within one run and ratios are those of medians, so that changes of the machine's speed do not affect them.
"""

from __future__ import annotations

import ctypes
import fcntl
import mmap
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

from libgz.interfaces.camera import Camera
from libgz.interfaces.position import Position
from libgz.interfaces.sim import Sim
from libgz.transport.server import Server

ROUNDS = 15
WAKES = 500
SERVER_ID = 900_000 + os.getpid()

CLIENT = f"""
import statistics, sys, time
import libgz

with libgz.Client({SERVER_ID}, 0) as client:
    robot = client.position("robot1")
    client.wait(timeout=10.0)
    print("ready", flush=True)
    late = []
    while len(late) < {WAKES} and client.wait(timeout=10.0):
        late.append(time.monotonic_ns() - int(robot.data.stall) - int(robot.data.time) * 10**9)
    late = sorted(late)
    print(late[len(late) // 2] / 1e3, late[len(late) * 99 // 100] / 1e3)
"""


def time_each(action: Callable[[], object], count: int) -> float:
    """Time of one call [us]."""
    begin = time.perf_counter()
    for _ in range(count):
        action()
    return (time.perf_counter() - begin) / count * 1e6


def publish_position(robot: Position) -> None:
    """Publish as a robot does in each update."""
    if robot.lock():
        data = robot.data
        data.time = 1.5
        pos, rot = data.pos, data.rot
        pos[0], pos[1], rot[2] = 1.0, 2.0, 0.5
        data.vel_pos[0], data.vel_rot[2] = 0.3, 0.1
        data.stall = 0
        robot.unlock()


def lock_alone(robot: Position) -> None:
    """The system calls of `publish_position` alone."""
    descriptor = robot.descriptor or 0
    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.fstat(descriptor)
    fcntl.flock(descriptor, fcntl.LOCK_UN)


def publish_image(camera: Camera, image: np.ndarray) -> None:
    """Publish as a camera does with a new image."""
    if camera.lock():
        data = camera.data
        data.time, data.width, data.height, data.image_size = 1.5, 640, 480, image.size
        camera.all_pixels[: image.size] = image
        camera.unlock()


def table(server: Server) -> None:
    """Print the times of publishing beside those of the least work that it needs."""
    robot, camera = Position(), Camera()
    robot.create(server, "bench")
    camera.create(server, "bench")
    image = np.random.default_rng(0).integers(0, 255, 640 * 480 * 3, dtype=np.uint8)
    target, size = mmap.mmap(-1, image.size), image.size
    address = ctypes.addressof(ctypes.c_char.from_buffer(target))
    jobs: dict[str, tuple[Callable[[], object], int]] = {
        "position": (lambda: publish_position(robot), 20000),
        "its system calls alone": (lambda: lock_alone(robot), 20000),
        "image 640x480": (lambda: publish_image(camera, image), 1000),
        "its memory copy alone": (lambda: ctypes.memmove(address, image.ctypes.data, size), 1000),
        "post to all clients": (server.post, 20000),
    }
    taken: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(ROUNDS):
        for name, (action, count) in jobs.items():
            taken[name].append(time_each(action, count))
    median = {name: statistics.median(values) for name, values in taken.items()}
    print(f"{'':28}{'[us]':>8}{'ratio to the least':>20}")
    for name, least in (("position", "its system calls alone"), ("image 640x480", "its memory copy alone")):
        print(f"{name:28}{median[name]:8.2f}{median[name] / median[least]:20.2f}")
        print(f"  {least:26}{median[least]:8.2f}")
    print(f"{'post to all clients':28}{median['post to all clients']:8.2f}")


def wake_up(server: Server) -> None:
    """Print the time from a post until a waiting client in another process runs."""
    robot, sim = Position(), Sim()
    robot.create(server, "robot1")
    sim.create(server, "default")
    server.post()
    with subprocess.Popen([sys.executable, "-c", CLIENT], stdout=subprocess.PIPE, text=True) as client:
        if client.stdout is None or client.stdout.readline() != "ready\n":
            raise SystemExit("the client did not start")
        for _ in range(WAKES + 5):
            time.sleep(0.005)
            now = time.monotonic_ns()
            robot.data.time, robot.data.stall = now // 10**9, now % 10**9
            server.post()
            if client.poll() is not None:
                break
        median, worst = map(float, client.stdout.read().split())
    print(f"{'wake-up after a post':28}{median:8.1f}   median of {WAKES}; 99 % within {worst:.0f} us")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="gz") as folder:
        os.environ.update(TMP=folder, USER="bench")
        running = Server(SERVER_ID)
        running.start()
        try:
            table(running)
            wake_up(running)
        finally:
            running.stop()
