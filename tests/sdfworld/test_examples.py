"""The examples of SDF worlds, run as they stand."""

import math
from pathlib import Path

import numpy as np
import pytest

import libgz

FOLDER = Path(__file__).parents[2] / "examples" / "sdf"


@pytest.fixture(params=sorted(FOLDER.glob("*.world")), ids=lambda path: path.stem)
def world(request):
    with libgz.World.from_file(request.param) as made:
        yield made


def test_an_example_runs_without_warnings_and_comes_to_rest(world, caplog):
    assert not caplog.text
    world.step(2000)
    states = world.engine.states
    assert np.isfinite(states).all()
    assert np.abs(states[:, 10:]).max(initial=0.0) < (0.5 if world.name == "wind" else 0.05)


def test_wind_turns_the_pendulum():
    with libgz.World.from_file(FOLDER / "wind.world") as made:
        made.step(6000)
        x, _, z = made.model("pendulum").GetPose().pos
        assert math.atan2(x, 2.0 - z) == pytest.approx(math.atan(4.0 / 9.8), abs=2e-3)
        assert tuple(made.model("stone").GetPose().pos) == pytest.approx((1.0, 0.0, 0.1), abs=1e-4)


def test_the_rover_drives_and_opens_both_fingers():
    with libgz.World.from_file(FOLDER / "rover.world") as made:
        joints = made.model("rover").sdf_joints
        made.interface("position", "rover").command(vx=0.3)
        for _ in range(1500):
            joints["left_finger_joint"].add_force(3.0)
            made.step(1)
        x, y, _ = made.model("rover").GetPose().pos
        assert (x, y) == pytest.approx((0.45, 0.0), abs=0.05)
        assert joints["left_finger_joint"].position() > 0.09
        assert joints["right_finger_joint"].position() == pytest.approx(0.1, abs=0.005)
