"""Limits of joints: `<limit>`, and the soft ones of `<safety_controller>`, by the rules of joint_limits_interface."""

import math

import pytest
from lxml import etree

from libgz.ros.control.hardware import EFFORT, POSITION, VELOCITY, SimJoint, SoftLimits

JOINT = (
    "<joint name='j' type='revolute'><limit lower='-2' upper='2' effort='10' velocity='3'/>"
    "<safety_controller soft_lower_limit='-1.5' soft_upper_limit='1.5' k_position='4' k_velocity='5'/></joint>"
)


class Joint:
    """A joint of a simulation, as far as `SimJoint` uses it."""

    def __init__(self):
        self.at = self.rate = 0.0
        self.done = {}

    def GetName(self):
        return "j"

    def Position(self, _index):
        return self.at

    def GetVelocity(self, _index):
        return self.rate

    def GetForce(self, _index):
        return 0.0

    def SetForce(self, _index, effort):
        self.done["effort"] = effort

    def SetParam(self, name, _index, value):
        self.done[name] = value

    def SetPosition(self, _index, position, _preserve):
        self.done["position"] = self.at = position


def commanded(interface, command, at=0.0, rate=0.0, text=JOINT):
    """What is done with a command at a position and a velocity, in a step of 10 ms."""
    joint = Joint()
    joint.at, joint.rate = at, rate
    found = SimJoint(joint, interface, etree.fromstring(text), None)
    found.read()
    found.command = command
    found.write(0.01)
    return joint.done


def test_far_from_soft_limits_the_hard_ones_hold():
    assert commanded(EFFORT, 50.0)["effort"] == 10.0
    assert commanded(EFFORT, -50.0)["effort"] == -10.0
    assert commanded(VELOCITY, 5.0)["vel"] == 3.0
    assert commanded(POSITION, 1.0)["position"] == pytest.approx(0.03)


@pytest.mark.parametrize(("at", "most"), [(1.0, 2.0), (1.4, 0.4), (1.5, 0.0), (1.6, -0.4)])
def test_the_velocity_falls_towards_a_soft_limit_and_leads_back_beyond_it(at, most):
    assert commanded(VELOCITY, 5.0, at)["vel"] == pytest.approx(most)
    assert commanded(VELOCITY, -5.0, -at)["vel"] == pytest.approx(-most)
    assert commanded(VELOCITY, -5.0, at)["vel"] == -3.0
    assert commanded(POSITION, 2.0, at)["position"] == pytest.approx(at + 0.01 * most)


def test_the_effort_brakes_what_is_too_fast_for_a_soft_limit():
    # At 1.4 rad 0.4 rad/s are allowed; 1 rad/s is 0.6 too fast, which 5 N m s/rad make 3 N m against it.
    assert commanded(EFFORT, 8.0, 1.4, 1.0)["effort"] == pytest.approx(-3.0)
    assert commanded(EFFORT, 8.0, 1.4, 0.0)["effort"] == pytest.approx(2.0)
    assert commanded(EFFORT, -8.0, 1.4, 0.0)["effort"] == pytest.approx(-8.0)


def test_without_soft_limits_nothing_pushes_beyond_a_limit():
    hard = JOINT.partition("<safety")[0] + "</joint>"
    assert commanded(EFFORT, 8.0, 2.1, text=hard)["effort"] == 0.0
    assert commanded(EFFORT, -8.0, 2.1, text=hard)["effort"] == -8.0
    assert commanded(EFFORT, 8.0, 0.0, 3.5, text=hard)["effort"] == 0.0
    assert commanded(EFFORT, -8.0, 0.0, 3.5, text=hard)["effort"] == -8.0
    assert commanded(VELOCITY, 2.5, 1.9, text=hard)["vel"] == 2.5


def test_a_soft_limit_without_a_gain_lets_nothing_move():
    assert SoftLimits(-1.0, 1.0, 0.0, 5.0).velocities(0.3, math.inf) == (0.0, 0.0)
