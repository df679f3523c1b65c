"""What ROS 2 costs a step: nobody listens, all topics of ten robots are read, and these with the images of a camera.

    LIBGZ_ROS2_PYTHON=/path/bin/python3 python benchmarks/ros2.py [nobody] [streams] [images]

The worlds, the rounds and the aims are those of ros.py. LIBGZ_ROS2_PYTHON names a Python that has rclpy, such as
that of an environment which `libgz ros venv` made: it runs the bridges, and a node that subscribes to all topics but
that of compressed images: to make a JPEG takes 0.6 ms, whoever asks for it. The processor time is that of the server:
bridge and node have processes of their own. Needs an idle machine with 2 cores, better with 4.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "benchmarks")]

from ros import AIMS, Worker, compare, world_text  # noqa: E402

PYTHON = os.environ.get("LIBGZ_ROS2_PYTHON", "")
PATIENCE = 60.0  # [s]
DOMAINS = {"quiet": "71", "measures": "71", "loud": "72"}  # ROS_DOMAIN_ID of servers without subscribers, and with some
NODE = """
import importlib, json, sys
import rclpy
from rclpy.qos import QoSProfile, ReliabilityPolicy
rclpy.init()
node = rclpy.create_node("reader")
kept = []
for topic, kind in json.loads(sys.argv[1]).items():
    package, sort, name = kind.split("/")
    kind = getattr(importlib.import_module(f"{package}.{sort}"), name)
    quality = QoSProfile(depth=50, reliability=ReliabilityPolicy.BEST_EFFORT)
    kept.append(node.create_subscription(kind, topic, lambda message: None, quality, raw=True))
while not all(node.count_publishers(one.topic_name) for one in kept):
    rclpy.spin_once(node, timeout_sec=0.1)
print("ready", flush=True)
rclpy.spin(node)
"""


def work(path: str, how: str) -> None:
    """A process that makes as many steps as each line of its input says, and answers with real and processor time."""
    from libgz import World
    from libgz.classic.server import attach
    from libgz.ros.server import Ros2

    logging.disable(logging.WARNING)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())  # so that the node ends, too
    with contextlib.ExitStack() as stack:
        ros = stack.enter_context(Ros2(["--ros-args", "-p", "publish_rate:=100.0"])) if how != "plain" else None
        core = stack.enter_context(World(seed=1))
        core.LoadFile(path)
        if ros is not None:
            ros.attach(core)
        core.Initialize()
        if how == "measures":
            for sensor in attach(core).sensors.sensors.values():
                sensor.SetActive(True)
        core.step(500)
        if how == "loud" and ros is not None:
            channels = [one for one in ros.node._channels.values() if one.verb == "publish"]
            topics = [one for one in channels if one.topic.startswith(("/r", "/clock", "/tf", "/camera"))]
            wanted = [one for one in topics if not one.topic.endswith("/compressed")]
            stack.enter_context(reading({one.topic: one.about["type"] for one in wanted}))
            end = time.monotonic() + PATIENCE
            while not all(one.subscribed for one in wanted) and time.monotonic() < end:
                core.step(10)
                time.sleep(0.01)
            if not all(one.subscribed for one in wanted):
                raise SystemExit("the node does not subscribe to all topics")
            sys.stderr.write(f"    {len(wanted)} topics are read\n")
        print("ready", flush=True)
        for line in sys.stdin:
            wall, cpu = time.perf_counter(), time.process_time()
            core.step(int(line))
            print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)


@contextlib.contextmanager
def reading(topics: dict[str, str]) -> Iterator[None]:
    """A node that subscribes to topics."""
    node = subprocess.Popen([PYTHON, "-c", NODE, json.dumps(topics)], stdout=subprocess.PIPE, text=True, cwd="/")
    try:
        if next(iter(node.stdout or ()), "") != "ready\n":
            raise SystemExit("the node did not start")
        yield
    finally:
        node.kill()
        node.wait(20)


class Server(Worker):
    """A process of `work`.

    Args:
        path: of the world.
        how: plain, without ROS; quiet, without subscribers; measures, the same, but with sensors that measure; loud,
            with some.
    """

    def __init__(self, path: Path, how: str) -> None:
        more = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": DOMAINS.get(how, "")}
        environment = {**os.environ, "ROS_MASTER_URI": "", **more}
        self.start([sys.executable, __file__, "work", str(path), how], environment)


def main(names: list[str]) -> None:
    """All comparisons, or those that are named."""
    if not PYTHON:
        raise SystemExit("LIBGZ_ROS2_PYTHON names no Python that has rclpy; `libgz ros venv` makes one")
    with tempfile.TemporaryDirectory() as folder:
        for name in names or list(AIMS):
            path = Path(folder) / f"{name}.world"
            path.write_text(world_text(images=name == "images"))
            bases = {"without ROS": Server(path, "plain")}
            if name != "nobody":
                bases["sensors that measure"] = Server(path, "measures")
            other = Server(path, "quiet" if name == "nobody" else "loud")
            compare(name, other, bases)
            for worker in (*bases.values(), other):
                worker.close()


if __name__ == "__main__":
    if sys.argv[1:2] == ["work"]:
        with contextlib.suppress(KeyboardInterrupt):
            work(*sys.argv[2:])
    else:
        main(sys.argv[1:])
