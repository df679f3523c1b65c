"""Efforts that native code holds over the steps of an action are those that Python applies step by step."""

import gymnasium
import numpy as np
import pytest

import libgz.gym  # noqa: F401 - registers the environments


def play(monkeypatch, name, alone):
    """(observations, state) after some actions."""
    with gymnasium.make(f"libgz/{name}-v0") as env:
        env.reset(seed=3)
        own = env.unwrapped
        if alone:
            monkeypatch.setattr(own, "_write_held", lambda values: False)
        else:
            assert len(list(own._act(env.action_space.low))) == 1  # all steps of an action at once
        random = np.random.default_rng(1)
        low, high = env.action_space.low, env.action_space.high
        seen = [env.step(random.uniform(low, high))[0] for _ in range(30)]
        return np.array(seen), own.world.get_state()


@pytest.mark.parametrize("name", ["PendulumSwingUp", "DoublePendulum", "Balance"])
def test_held_efforts_are_single_ones(monkeypatch, name):
    held, single = play(monkeypatch, name, False), play(monkeypatch, name, True)
    assert (held[0] == single[0]).all()
    assert held[1] == single[1]


def test_an_effort_on_a_joint_that_goes_meanwhile_acts_no_more(monkeypatch):
    with gymnasium.make("libgz/PendulumSwingUp-v0") as env:
        env.reset(seed=3)
        world = env.unwrapped.world
        kept = world.events["WorldUpdateEnd"].Connect(
            lambda: [world.DeleteModel(model) for model in list(world.models)]
        )
        env.step([1.0])
        assert not world.models
        kept.Disconnect()
        world.step(5)


def test_a_limit_of_velocity_is_kept_step_by_step():
    with gymnasium.make("libgz/PendulumSwingUp-v0") as env:
        env.reset(seed=3)
        joint, record = env.unwrapped._held[0]
        assert env.unwrapped._write_held([1.0])
        assert record.effort == 1.0
        joint.axes[0].velocity = 0.5
        assert not joint.write_held(record, 1.0)
        assert not env.unwrapped._write_held([1.0])
