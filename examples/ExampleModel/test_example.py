"""Test of the example: it drives and turns as commanded, in one process and through a server."""

import math
import subprocess
import sys
from pathlib import Path

import pytest

import libgz

HERE = Path(__file__).parent


def test_drives_as_told():
    with libgz.World.from_file(HERE / "example.world") as world:
        robot = world.interface("position", "robot1")
        robot.command(vx=0.2)
        world.run(5.0)
        assert robot.pose[0] == pytest.approx(1.0, rel=0.03)
        # The world turned the robot by 90 degrees: forward is along +y.
        assert world.model("robot1").GetPose().pos.y == pytest.approx(1.0, rel=0.03)
        robot.command(vyaw=0.5)
        world.run(2.0)
        heading = libgz.GzQuaternToEuler(world.model("robot1").GetPose().rot).z
        assert heading == pytest.approx(math.pi / 2 + 1.0, abs=0.1)


@pytest.mark.parametrize("name", ["ExampleModel.so", "libExampleModel.so", "ExampleModel.py", "examplemodel.so"])
def test_names_of_the_plugin(name, monkeypatch):
    monkeypatch.setenv("GAZEBOPATH", str(HERE))
    text = (HERE / "example.world").read_text().replace("ExampleModel.so", name)
    with libgz.World.from_string(text) as world:
        assert world.model("robot1").GetName() == "ExampleModel"


def test_client_program(gazebo):
    server = gazebo(HERE / "example.world", "--rate", "5")
    done = subprocess.run(
        [sys.executable, HERE / "client.py", str(server.id)], env=server.env, capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("odometry: x 0.5")
