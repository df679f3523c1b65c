from pathlib import Path

import pytest
from ros_peers import Master

from libgz import World
from libgz.ros.server import Ros1


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
