"""Observation, reward and end as one law: natively and in Python the same to the bit."""

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces

import libgz.gym
from libgz.base.errors import ParameterError
from libgz.base.law import law, where
from libgz.gym import WorldVectorEnv
from libgz.gym.tasks import WORLDS

MEASURED = [name for name, kind in libgz.gym.TASKS.items() if kind.measure is not libgz.gym.WorldEnv.measure]


def play(env, *, native):
    """What some steps return, and how many of them native code measured."""
    env.reset(seed=3)
    env.world.rows.enabled = native
    random, found, done = np.random.default_rng(1), [], 0
    for _ in range(20):
        found.append(env.step(random.uniform(env.action_space.low, env.action_space.high))[:4])
        done += bool(env._law.address)
    return found, done


@pytest.mark.parametrize("name", MEASURED)
def test_native_code_measures_what_python_does(name):
    env = gymnasium.make(f"libgz/{name}-v0").unwrapped
    (ours, done), (expected, none) = play(env, native=True), play(env, native=False)
    env.close()
    assert (done, none) == (20, 0)
    for one, other in zip(ours, expected, strict=True):
        assert one[0].tobytes() == other[0].tobytes()
        assert one[1:] == other[1:]


class Tip(libgz.gym.WorldEnv):
    """A pendulum whose tip is observed."""

    def __init__(self, **options):
        box = spaces.Box(-1.0, 1.0, (1, 2), np.float32)
        effort = {"pendulum::pivot": ["effort"]}
        super().__init__(WORLDS / "pendulum.world", effort, box, start=self.begin, period=0.05, settle=0.0, **options)

    def begin(self, world, _random, _options):
        self.joint = world.model("pendulum").sdf_joints["pivot"]
        self.joint.set_position(0.5)

    @law
    def measure(self):
        now, rate = self.outcome, self.joint.velocity()
        now.seen[:] = (self.joint.position() / 10.0, rate / 20.0)
        now.reward = now.action[0]
        now.ended = where(abs(rate) > 0.5, 1.0, 0.0)


@pytest.mark.parametrize("flat", [False, True])
def test_a_class_of_users_measures(flat):
    env, many = Tip(flat=flat), WorldVectorEnv(Tip, 3, flat=flat)
    seen, _ = env.reset(seed=1)
    assert seen.shape == env.observation_space.shape == ((2,) if flat else (1, 2))
    assert seen in env.observation_space
    assert seen.ravel()[0] == pytest.approx(0.05)
    many.reset(seed=[1, 1, 1])
    ended = False
    while not ended:
        seen, reward, ended, _, _ = env.step([0.25])
        rows, rewards, ends, _, _ = many.step(np.full((3, 1), 0.25))
        assert reward == 0.25
        assert [*rewards] == [reward] * 3
        assert [*ends] == [ended] * 3
        assert all((row == seen).all() for row in rows)
    env.close()
    many.close()


def test_a_method_that_is_no_law_is_computed_in_python(monkeypatch):
    with Tip() as env:
        env.reset(seed=1)
        expected = env.step([0.0])[0]
        monkeypatch.setattr(Tip, "measure", lambda self: self.outcome.seen.__setitem__(slice(None), 0.5))
        env._law = None
        env.reset(seed=1)
        assert (env.step([0.0])[0] == 0.5).all()
        assert not (expected == 0.5).any()


def test_a_box_without_a_method_is_refused():
    with pytest.raises(ParameterError, match="observations is a Box; WorldEnv must have a method `measure` then"):
        libgz.gym.WorldEnv(WORLDS / "pendulum.world", {"pendulum::pivot": ["effort"]}, spaces.Box(-1.0, 1.0, (2,)))


def test_what_is_set_in_an_episode_counts():
    """An object that a law takes as constant may be another one after a reset."""
    with Tip() as env:
        first = env.reset(seed=1)[0]
        env.joint.set_position(-0.5)
        env.step([0.0])
        assert (env.reset(seed=1)[0] == first).all()


class Aim(Tip):
    """A tip whose reward depends on a number that each start sets."""

    def begin(self, world, random, _options):
        super().begin(world, random, _options)
        self.aim = float(random.uniform())

    @law
    def measure(self):
        super().measure()
        self.outcome.reward = self.outcome.reward + self.aim


def test_a_law_sees_what_a_start_has_set():
    env = Aim()
    for seed in range(3):
        env.reset(seed=seed)
        assert env.step([0.0])[1] == env.aim
    env.close()


def test_a_law_sees_what_an_episode_has_set():
    with Aim() as env:
        env.reset(seed=0)
        for aim in (1.5, -2.0):
            env.aim = aim
            assert env.step([0.0])[1] == aim


def test_a_law_sees_that_a_joint_was_released_and_joined_again():
    """Which joint the engine has is looked at only where rows of its tables were taken or freed."""
    env = gymnasium.make("libgz/DoublePendulum-v0").unwrapped
    env.reset(seed=1)
    elbow = env._joints[2]
    before = env.step([0.0])[0]
    parent, child = elbow.parent, elbow.child
    elbow.detach()
    assert env.step([0.0])[0].tolist()[3:5] == [0.0, 1.0]
    elbow.attach(parent, child)
    after = env.step([0.0])[0]
    assert env._law.address
    env.close()
    assert after[3] != 0.0 != before[3]
    assert after[6] != 0.0


def test_it_is_measured_once_for_all_steps_of_an_action():
    """Also where each step has to be made alone: the reward is what changed since the action before."""
    found = []
    for rewinds in (False, True):
        with gymnasium.make("libgz/ReachGoal-v0") as env:
            env.reset(seed=3)
            if rewinds:
                env.unwrapped.world.keep_rewind(1.0)
            found.append([env.step(np.array([0.5, 0.2], np.float32))[1] for _ in range(5)])
    assert found[0] == found[1]


def test_no_steps_are_measured_too():
    with gymnasium.make("libgz/PendulumSwingUp-v0") as env:
        env.reset(seed=3)
        own = env.unwrapped
        env.step(np.array([0.5], np.float32))
        own.outcome.reward = 7.0
        own.world.step(0, own._law)
        assert own.outcome.reward != 7.0
