"""Grippers: what they hold goes with them."""

import contextlib
from pathlib import Path

import pytest

import libgz
from libgz.classic.server import attach

WORLD = Path(__file__).parents[2] / "examples/sdf/gripper.world"
WEIGHT = 9.8


class Hand:
    def __init__(self, world):
        self.world = world
        self.view = attach(world).world
        self.hand, self.cube = self.view.ModelByName("hand"), self.view.ModelByName("cube")
        self.gripper = self.hand.GetGripper("grasp")

    def act(self, time, lift, effort):
        lifted, end = self.hand.GetJoint("lift"), self.world.GetSimTime() + time
        while self.world.GetSimTime() < end - 1e-9:
            mass = 2.4 + 0.3 * self.gripper.IsAttached()
            lifted.SetForce(0, mass * WEIGHT + 400 * (lift - lifted.Position(0)) - 60 * lifted.GetVelocity(0))
            for finger in ("left_slide", "right_slide"):
                self.hand.GetJoint(finger).SetForce(0, effort)
            self.world.Step()

    @property
    def height(self):
        return self.cube.WorldPose().Pos().Z()


@pytest.fixture
def hand():
    with libgz.World.from_file(WORLD) as world:
        yield Hand(world)


def test_a_gripper_lifts_what_it_holds_and_drops_it(hand):
    assert hand.hand.GetGripperCount() == 1
    assert hand.hand.GetGripper(0) is hand.gripper
    assert hand.hand.GetGripper("other") is None
    assert hand.gripper.GetName() == "grasp"
    hand.act(0.015, 0.0, 5.0)
    assert not hand.gripper.IsAttached()
    hand.act(0.8, 0.0, 5.0)
    assert hand.gripper.IsAttached()
    assert hand.height == pytest.approx(0.35, abs=1e-3)
    hand.act(1.5, 0.3, 5.0)
    assert hand.height == pytest.approx(0.65, abs=2e-3)
    hand.act(0.03, 0.3, -5.0)
    assert hand.gripper.IsAttached()  # until detach_steps are over
    hand.act(0.7, 0.3, -5.0)
    assert not hand.gripper.IsAttached()
    assert hand.height == pytest.approx(0.35, abs=1e-3)


def test_what_is_held_is_in_the_state(hand):
    hand.act(0.5, 0.0, 5.0)
    held = hand.world.get_state()
    hand.act(0.5, 0.3, 5.0)
    first = hand.cube.WorldPose()
    hand.act(0.5, 0.3, -5.0)
    assert not hand.gripper.IsAttached()
    hand.world.set_state(held)
    assert hand.gripper.IsAttached()
    hand.act(0.5, 0.3, 5.0)
    assert hand.cube.WorldPose() == first
    hand.world.Reset()
    assert not hand.gripper.IsAttached()
    assert hand.height == pytest.approx(0.35)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<palm_link>palm", "<palm_link>plam", "<palm_link> is 'plam'"),
        ("<gripper_link>left", "<gripper_link>lefd", "<gripper_link> is 'lefd'"),
        ("<detach_steps>40", "<detach_steps>-1", "<detach_steps>: '-1' is out of range; '40' is used"),
    ],
)
def test_wrong_grippers_are_warnings(tmp_path, old, new, message, caplog):
    (tmp_path / "w.world").write_text(WORLD.read_text().replace(old, new))
    with contextlib.closing(libgz.World.from_file(tmp_path / "w.world")):
        assert message in caplog.text
