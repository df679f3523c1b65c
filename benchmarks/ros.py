"""What ROS 1 costs a step: nobody listens, 53 streams are recorded, and these with the images of a camera.

    python benchmarks/ros.py [nobody] [streams] [images]

Ten robots with lasers drive on a plane: odometry, scans, imu, joint states and true poses of each, a second imu, /tf
and /clock are 53 streams with 2.1 messages a step of 1 ms; a camera adds 640 x 480 images at 30 Hz, not compressed, and
its calibration. Steps are made as fast as possible. Processes with the same world take turns, 15 rounds of blocks;
printed are the times of a step, the ratios of real and of processor time, the latter of all threads of a process, with
quartiles, and the aims:

    nobody    with ROS and no subscribers, without drives / without ROS and without plugins    at most  1 %
    streams   recorded / without ROS                                                           at most 10 %
              recorded / with ROS, no subscribers, sensors that measure
    images    the same, with images                                                            at most 20 %

Without ROS, the plugins of the world publish on topics of Gazebo, and sensors measure for these; with ROS, they measure
for subscribers only. What only publishes has nothing to do without subscribers: `nobody` compares with a world that
does not have it, and leaves out the drives, which have.

LIBGZ_ROS1_ROOT names a root with ROS 1 (roscore and rosbag), which is entered by chroot, as root; its rosbag records.
Without it, a process of this script subscribes to all topics and reads what comes. Needs an idle machine with 2 cores.
"""

from __future__ import annotations

import contextlib
import copy
import os
import select
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from lxml import etree

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from ros_peers import Master, ask, encode, wait_for  # noqa: E402

PAIRS, BLOCK, ROBOTS, STREAMS = 15, 1500, 10, 53  # BLOCK: steps
AIMS = {"nobody": 1.0, "streams": 10.0, "images": 20.0}  # [%]
RATES = {"odom": 30, "imu": 50, "joint_states": 50, "truth": 30}  # [Hz]
CAMERA = """
<model name="watcher"><static>true</static><pose>-3 0 2 0 0.4 0</pose><link name="link">
  <sensor name="camera" type="camera"><update_rate>30</update_rate>
    <camera><image><width>640</width><height>480</height></image></camera>
    <plugin name="camera_driver" filename="libgazebo_ros_camera.so"><cameraName>camera</cameraName></plugin>
  </sensor></link></model>
"""


# The world -----------------------------------------------------------------------------------------------------------


def world_text(images: bool, without: str = "") -> str:
    """Ten robots of the tests' world without contact sensors, each in a namespace of its own; one has a second imu.

    Args:
        images: with a camera.
        without: a path of plugins in a robot that are left out.
    """
    tree = etree.parse(ROOT / "tests/ros/turtle.world")
    world = tree.getroot().find("world")
    for name in ("robot", "wall"):
        world.remove(found := world.find(f"model[@name='{name}']"))
        if name == "robot":
            robot = found
    for number in range(ROBOTS):
        one = copy.deepcopy(robot)
        one.set("name", f"r{number}")
        etree.SubElement(one, "pose").text = f"0 {2 * number} 0 0 0 0"
        base = one.find("link[@name='base']")
        base.remove(base.find("sensor[@name='bumper']"))
        if not number:
            second = copy.deepcopy(base.find("sensor[@name='imu']"))
            second.set("name", "second")
            second.find("plugin/topicName").text = "second"
            base.append(second)
        for plugin in one.iter("plugin"):
            for given in (*plugin.iter("robotNamespace"), *plugin.iter("updateRate"), *plugin.iter("publishWheelTF")):
                plugin.remove(given)
            etree.SubElement(plugin, "robotNamespace").text = f"/r{number}"
        rates = {"drive": RATES["odom"], "joints": RATES["joint_states"], "truth": RATES["truth"]}
        for name, rate in rates.items():
            etree.SubElement(one.find(f"plugin[@name='{name}']"), "updateRate").text = str(rate)
        for plugin in one.xpath(without) if without else ():
            plugin.getparent().remove(plugin)
        world.append(one)
    if images:
        world.append(etree.fromstring(CAMERA))
    return etree.tostring(tree, encoding="unicode")


def work(path: str, how: str) -> None:
    """A process that makes as many steps as each line of its input says, and answers with real and processor time."""
    import logging

    from libgz import World
    from libgz.classic.server import attach
    from libgz.ros.server import Ros1

    logging.disable(logging.WARNING)
    with contextlib.ExitStack() as stack:
        session = stack.enter_context(Ros1(["_pub_clock_frequency:=100"])) if how != "plain" else None
        core = stack.enter_context(World(seed=1))
        core.LoadFile(path)
        if session is not None:
            wait_for(lambda: session.node.registered)
            session.attach(core)
        core.Initialize()
        if how == "measures":
            for sensor in attach(core).sensors.sensors.values():
                sensor.SetActive(True)
        core.step(500)
        print("ready", flush=True)
        for line in sys.stdin:
            wall, cpu = time.perf_counter(), time.process_time()
            core.step(int(line))
            print(time.perf_counter() - wall, time.process_time() - cpu, flush=True)


class Worker:
    """Such a process.

    Args:
        path: of the world.
        uri: of the master; None: the world runs without ROS.
        measures: whether sensors measure without subscribers.
    """

    def __init__(self, path: Path, uri: str | None, measures: bool = False) -> None:
        environment = {**os.environ, "ROS_MASTER_URI": uri or ""}
        how = "measures" if measures else "ros" if uri else "plain"
        self.start([sys.executable, __file__, "work", str(path), how], environment)

    def start(self, command: list[str], environment: Mapping[str, str]) -> None:
        """Start the process, and wait until it is ready."""
        self._process = subprocess.Popen(
            command, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._read = iter(self._process.stdout or ())
        if next(self._read, "") != "ready\n":
            raise SystemExit("a world did not start")

    def __call__(self, steps: int) -> tuple[float, float]:
        """Real and processor time [s]."""
        print(steps, file=self._process.stdin, flush=True)
        wall, cpu = map(float, next(self._read).split())
        return wall, cpu

    def close(self) -> None:
        """End it."""
        self._process.terminate()
        self._process.wait(20)


# Subscribers ---------------------------------------------------------------------------------------------------------


def read_all(uri: str) -> None:
    """A process that subscribes to all topics of the tests' master, and reads what comes until it is ended."""
    master, poll, sockets = uri, select.epoll(), {}
    for topic, nodes in ask(master, "listPublishers"):
        _, _, (_, host, port) = ask(nodes, "requestTopic", "/reader", topic, [["TCPROS"]])
        one = socket.create_connection((host, port))
        one.sendall(encode({"callerid": "/reader", "topic": topic, "type": "*", "md5sum": "*"}))
        poll.register(one, select.EPOLLIN)
        sockets[one.fileno()] = one
    print("ready", len(sockets), flush=True)
    while sockets:
        for number, _ in poll.poll():
            if number in sockets and not sockets[number].recv(1 << 20):
                sockets.pop(number).close()


@contextlib.contextmanager
def listed_master() -> Iterator[Master]:
    """The tests' master, which also lists all publishers to `read_all`."""
    master = Master()

    def list_publishers() -> list[tuple[str, str]]:
        return [(topic, uri) for topic, nodes in master.publishers.items() for _, uri in nodes.values()]

    master.server.register_function(list_publishers, "listPublishers")
    yield master
    master.close()


@contextlib.contextmanager
def reading(uri: str, topics: list[str]) -> Iterator[None]:
    """Subscribers of this script."""
    reader = subprocess.Popen([sys.executable, __file__, "read", uri], stdout=subprocess.PIPE, text=True)
    print(f"    {next(iter(reader.stdout or ('ready 0',))).split()[1]} topics are read by a process of this script")
    yield
    reader.terminate()
    reader.wait(20)


@contextlib.contextmanager
def recording(root: Path, port: int, topics: list[str]) -> Iterator[None]:
    """A rosbag of the root, which records topics."""
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "HOME": "/root"}
    environment["PATH"] = "/usr/sbin:/usr/bin:/sbin:/bin"
    bag = root / "tmp/libgz-benchmark.bag"
    command = ["chroot", str(root), "rosbag", "record", "-q", "-b", "0", "-O", f"/tmp/{bag.name}", *topics]
    recorder = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(5.0)  # it connects; blocks before all are connected would only be too cheap
    print(f"    {len(topics)} topics are recorded by rosbag")
    yield
    recorder.send_signal(signal.SIGINT)
    recorder.wait(30)
    wait_for(bag.exists)  # rosbag is a script whose child writes
    print(f"    the bag has {bag.stat().st_size / 1e6:.0f} MB")
    bag.unlink()


@contextlib.contextmanager
def roscore(root: Path, port: int) -> Iterator[None]:
    """A master of the root."""
    environment = {"ROS_IP": "127.0.0.1", "HOME": "/root", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin"}
    command = ["chroot", str(root), "roscore", "-p", str(port)]
    core = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def answers() -> bool:
        try:
            return bool(ask(f"http://127.0.0.1:{port}/", "getPid", "/benchmark"))
        except OSError:
            return False

    wait_for(answers)
    yield
    core.send_signal(signal.SIGINT)
    core.wait(30)


# Comparisons ---------------------------------------------------------------------------------------------------------


def compare(name: str, other: Worker, bases: Mapping[str, Worker]) -> None:
    """Let workers take turns, and print the ratios of one to the others."""
    rounds = []
    for number in range(PAIRS):
        order = [*bases.values(), other]
        rounds.append({worker: worker(BLOCK) for worker in (order if number % 2 else order[::-1])})
    for kind, what in enumerate(("real", "processor")):
        medians = (
            f"{title} {statistics.median(one[worker][kind] for one in rounds) / BLOCK * 1e6:.0f}"
            for title, worker in {"with ROS": other, **bases}.items()
        )
        print(f"{name:8} {what} time of a step [us]: {', '.join(medians)}", flush=True)
    for title, base in bases.items():
        for kind, what in enumerate(("real", "processor")):
            ratios = [one[other][kind] / one[base][kind] for one in rounds]
            low, middle, high = (100.0 * (value - 1.0) for value in statistics.quantiles(ratios, n=4))
            aim = f", at most {AIMS[name]:.0f} %" if title.startswith("without ROS") else ""
            print(f"{name:8} / {title:31} {what:9} {middle:+6.1f} % [{low:+.1f}, {high:+.1f}]{aim}", flush=True)


def run(name: str, folder: Path) -> None:
    """One comparison."""
    path = folder / f"{name}.world"
    bare = folder / "bare.world"
    path.write_text(world_text(images=name == "images", without="plugin[@name='drive']" if name == "nobody" else ""))
    bare.write_text(world_text(images=False, without=".//plugin"))
    root = os.environ.get("LIBGZ_ROS1_ROOT")
    with contextlib.ExitStack() as stack:
        quiet = stack.enter_context(listed_master())
        if name == "nobody":
            bases = {"without ROS and without plugins": Worker(bare, None)}
            other = Worker(path, quiet.uri)
        else:
            bases = {"without ROS": Worker(path, None)}
            bases["sensors that measure"] = Worker(path, quiet.uri, measures=True)
            wait_for(lambda: len(quiet.publishers) >= STREAMS)
            plugins = [topic for topic in quiet.publishers if topic.startswith(("/r", "/clock", "/tf", "/camera"))]
            topics = [topic for topic in plugins if not topic.startswith("/rosout") and "compressed" not in topic]
            if root and shutil.which("chroot"):
                port = 21511
                stack.enter_context(roscore(Path(root), port))
                other = Worker(path, f"http://127.0.0.1:{port}")
                stack.enter_context(recording(Path(root), port, topics))
            else:
                loud = stack.enter_context(listed_master())
                other = Worker(path, loud.uri)
                wait_for(lambda: set(topics) <= set(loud.publishers))
                for topic in set(loud.publishers) - set(topics):
                    del loud.publishers[topic]
                stack.enter_context(reading(loud.uri, topics))
        compare(name, other, bases)
        for worker in (*bases.values(), other):
            worker.close()


def main(names: list[str]) -> None:
    """All comparisons, or those that are named."""
    with tempfile.TemporaryDirectory() as folder:
        for name in names or list(AIMS):
            run(name, Path(folder))


if __name__ == "__main__":
    commands: dict[str, Callable[..., None]] = {"read": read_all, "work": work}
    if sys.argv[1:2] and sys.argv[1] in commands:
        with contextlib.suppress(KeyboardInterrupt):
            commands[sys.argv[1]](*sys.argv[2:])
    else:
        main(sys.argv[1:])
