from pathlib import Path

import pytest
from ros_bridge import EMPTY, FakeGraph, Server
from ros_peers import Master

from libgz import World
from libgz.ros.server import Ros1, Ros2


@pytest.fixture
def master(monkeypatch):
    for name in ("ROS_IP", "ROS_HOSTNAME", "ROS_NAMESPACE"):
        monkeypatch.delenv(name, raising=False)
    found = Master()
    monkeypatch.setenv("ROS_MASTER_URI", found.uri)
    yield found
    found.close()


@pytest.fixture
def start(tmp_path):
    """Makes a world of a file, or of a text, that speaks ROS 1."""
    closing = []

    def start(world=None, *words):
        ros = Ros1(words)
        closing.append(ros)
        core = World(seed=1)
        closing.append(core)
        path = Path(__file__).parent / "turtle.world"
        if world is not None:
            path = tmp_path / "test.world"
            path.write_text(world)
        core.LoadFile(path)
        ros.attach(core)
        core.Initialize()
        return core, ros

    yield start
    for one in reversed(closing):
        one.close()


@pytest.fixture
def graph(tmp_path):
    """The graph of ROS 2, as a test plays it."""
    found = FakeGraph(tmp_path)
    yield found
    found.close()


@pytest.fixture
def start_ros2(graph, tmp_path):
    """Starts a world that speaks ROS 2 with the test's graph."""
    closing = []

    def start(world=EMPTY, *words):
        ros = Ros2(words, graph.python)
        closing.append(ros)
        core = World(seed=1)
        closing.append(core)
        path = tmp_path / "test.world"
        path.write_text(world)
        core.LoadFile(path)
        ros.attach(core)
        core.Initialize()
        return Server(graph, core, ros)

    yield start
    for one in reversed(closing):
        one.close()
