import pytest

WORLD = """
<gz:world xmlns:gz="g" xmlns:model="m" xmlns:param="p">
<param:Global><stepTime>0.02</stepTime></param:Global>
<model:GroundPlane><id>ground</id></model:GroundPlane>
<model:Pioneer2AT><id>robot1</id></model:Pioneer2AT>
<model:SimpleSolid><id>crate</id><xyz>1 0.05 0</xyz><mass>5</mass><size>0.4 0.4 0.4</size></model:SimpleSolid>
</gz:world>
"""
STUDY = """
world = "push.world"
duration = 1.0
seeds = 2
controller = "drive.py:Drive"

[parameters]
"crate/mass" = [1.0, 8.0]
"crate/xyz[0]" = { uniform = [0.5, 0.8] }
"controller/speed" = [0.2, 0.4]

[measures]
distance = "robot1/pos[0]"
highest = { of = "robot1/linear_vel", reduce = "max" }
calls = "drive.py:calls"
"""
DRIVE = """
import os, signal, time
from pathlib import Path

class Drive:
    def __init__(self, world, speed=0.3):
        self.robot, self.speed, self.calls = world.interface("position", "robot1"), speed, 0

    def __call__(self, world):
        self.calls += 1
        self.robot.command(vx=self.speed)

def calls(world, controller):
    return controller.calls

def fail(world):
    raise ValueError("out of order")

def fail_first(world):
    mark = Path(__file__).with_name("failed")
    if not mark.exists():
        mark.touch()
        raise ValueError("only once")

def hang(world):
    time.sleep(100)

def crash(world):
    os.kill(os.getpid(), signal.SIGSEGV)

def eat(world):
    world.eaten = bytearray(300_000_000)
    time.sleep(5)

def stop(world):
    return world.GetSimTime() > 0.35

def slow(world):
    time.sleep(0.02)

def word(world):
    return "far"
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a study, its world and its controllers."""
    for name, text in (("push.world", WORLD), ("push.toml", STUDY), ("drive.py", DRIVE)):
        (tmp_path / name).write_text(text)
    return tmp_path
