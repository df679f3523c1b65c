"""Tests of a world and of a control program: pytest --libgz-record examples/ci."""

import subprocess
import sys
import time
from pathlib import Path

from libgz.testing import Worlds

PROGRAM = Path(__file__).with_name("stop_at_wall.py")


def test_the_robot_turns_left(libgz_world: Worlds) -> None:
    world = libgz_world("course.world")  # strict, with a free server id, and ended after the test
    robot = world.interface("position", "robot1")
    robot.command(vx=0.2, vyaw=0.3)  # [m/s], [rad/s]
    world.run(3.0)  # [s] of sim time, as fast as possible
    x, y, yaw = robot.pose
    assert x > 0.3
    assert y > 0.1
    assert 0.6 < yaw < 1.0


def test_the_program_stops_before_the_wall(libgz_world: Worlds) -> None:
    world = libgz_world("course.world")
    program = subprocess.Popen([sys.executable, PROGRAM, str(world.server_id)])
    while program.poll() is None and world.GetSimTime() < 600.0:
        world.step()
        time.sleep(0.001)  # 20 ms of sim time take at least 1 ms: the program is a process that needs time, too
    assert program.wait(timeout=10.0) == 0
    world.run(1.0)
    assert 0.2 < world.model("robot1").GetPose().pos.x < 1.6
