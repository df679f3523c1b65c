"""WorldVectorEnv: the same to the bit as single environments, with any number of threads; modes; errors; threads."""

import threading

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import libgz.gym
from libgz.base.errors import ClosedError, GazeboError, ParameterError

COUNT = 4


def same(one, other):
    """Whether observations, rewards, ends and infos are equal to the bit."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray) and one.dtype == object:
        return all(map(same, one, other))
    return np.array_equal(one, other)


@pytest.fixture
def make():
    made = []

    def start(name, *, sync=False, **options):
        mode = "sync" if sync else None
        made.append(gymnasium.make_vec(f"libgz/{name}-v0", num_envs=COUNT, vectorization_mode=mode, **options))
        return made[-1]

    yield start
    for envs in made:
        envs.close()


def play(envs, count, scale=1.0):
    """All that some steps return."""
    random = np.random.default_rng(5)
    low, high = envs.action_space.low * scale, envs.action_space.high * scale
    found = [envs.reset(seed=3)]
    for _ in range(count):
        found.append(envs.step(random.uniform(low, high).astype(np.float32)))
    return found


@pytest.mark.parametrize("name", libgz.gym.TASKS)
def test_environments_move_as_alone_with_any_number_of_threads(make, name):
    expected = play(make(name, sync=True), 25)
    for threads in (1, 3):
        envs = make(name, threads=threads)
        assert isinstance(envs, libgz.gym.WorldVectorEnv)
        assert envs.threads == threads
        assert all(map(same, play(envs, 25), expected))
        assert expected[-1][0] in envs.observation_space


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP])
def test_environments_that_end_are_reset_as_gymnasium_does(make, mode):
    options = {"time_limit": 0.4, "period": 0.1}
    expected = play(make("Balance", sync=True, vector_kwargs={"autoreset_mode": mode}, **options), 12, 2.0)
    found = play(make("Balance", autoreset_mode=mode.value, **options), 12, 2.0)
    assert sum(int(one[3].any()) for one in expected[1:]) >= 2
    assert all(map(same, found, expected))


def test_a_mask_resets_some(make):
    sync = make("PendulumSwingUp", sync=True, vector_kwargs={"autoreset_mode": AutoresetMode.DISABLED}, time_limit=0.2)
    ours = make("PendulumSwingUp", autoreset_mode="Disabled", time_limit=0.2)
    assert all(map(same, play(ours, 4), play(sync, 4)))
    with pytest.raises(ParameterError, match="environment 0 has ended; reset it"):
        ours.step(np.zeros((COUNT, 1), np.float32))
    mask = np.array([True, False, True, True])
    seeds = [7, None, 8, 9]
    assert same(
        ours.reset(seed=seeds, options={"reset_mask": mask}), sync.reset(seed=seeds, options={"reset_mask": mask})
    )
    with pytest.raises(ParameterError, match="environment 1 has ended"):
        ours.step(np.zeros((COUNT, 1), np.float32))


def test_observations_are_one_array(make):
    envs = make("DoublePendulum", copy=False)
    first, _ = envs.reset(seed=1)
    seen, *_ = envs.step(np.zeros((COUNT, 1), np.float32))
    assert seen is first
    assert seen.shape == (COUNT, 8)
    copied = make("DoublePendulum")
    assert copied.reset(seed=1)[0] is not copied.reset(seed=1)[0]


def test_worlds_of_each_seed_are_randomised_alone(make):
    options = {"randomise": {"pendulum/rod/inertial/mass": ("uniform", 0.5, 2.0)}}
    assert all(
        map(same, play(make("PendulumSwingUp", **options), 5), play(make("PendulumSwingUp", sync=True, **options), 5))
    )


def test_an_environment_that_fails_is_named(make):
    envs = make("PendulumSwingUp")
    envs.reset(seed=0)
    before = [env.world.iterations for env in envs.envs[:2]]
    envs.envs[2].world.close()
    with pytest.raises(GazeboError, match=r"^environment 2 of 4: the world is closed") as raised:
        envs.step(np.zeros((COUNT, 1), np.float32))
    assert isinstance(raised.value.__cause__, ClosedError)
    assert [env.world.iterations for env in envs.envs[:2]] == [count + 10 for count in before]


@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP])
def test_an_environment_whose_reset_fails_is_named(make, mode):
    envs = make("PendulumSwingUp", autoreset_mode=mode, time_limit=0.01)
    envs.reset(seed=0)

    def fail(*_values):
        raise ValueError("no place is free")

    envs.envs[2]._start = fail
    actions = np.zeros((COUNT, 1), np.float32)
    if mode == AutoresetMode.NEXT_STEP:
        envs.step(actions)
    with pytest.raises(GazeboError, match=r"^environment 2 of 4: no place is free"):
        envs.step(actions)


def test_what_is_wrong_is_refused(make):
    for options, message in (
        ({"autoreset_mode": "Never"}, "autoreset_mode is 'Never'; allowed are NextStep, SameStep, Disabled"),
        ({"threads": 0}, "threads is 0"),
    ):
        with pytest.raises(ParameterError, match=message):
            make("Balance", **options)
    envs = make("PendulumSwingUp")
    with pytest.raises(GazeboError, match=r"environment 0 of 4: call reset\(\) before"):
        envs.step(np.zeros((COUNT, 1), np.float32))
    envs.reset(seed=0)
    for actions, message in (
        (np.zeros((3, 1), np.float32), "3 actions were given for 4 environments"),
        (np.full((COUNT, 1), np.nan), "environment 0 of 4: action is .* finite"),
    ):
        with pytest.raises(GazeboError, match=message):
            envs.step(actions)
    with pytest.raises(ParameterError, match="2 seeds were given for 4 environments"):
        envs.reset(seed=[1, 2])
    with pytest.raises(ParameterError, match=r"reset_mask is .* 4 booleans"):
        envs.reset(options={"reset_mask": [True] * 4})
    envs.close()
    for call in (envs.reset, envs.render, lambda: envs.step(np.zeros((COUNT, 1)))):
        with pytest.raises(ClosedError, match="the environments are closed"):
            call()


def test_attributes_calls_and_the_end(make):
    envs = make("PendulumSwingUp", threads=3, render_mode="rgb_array", width=32, height=24)
    envs.reset(seed=0)
    envs.step(np.zeros((COUNT, 1), np.float32))
    assert sum(thread.name.startswith("libgz crew") for thread in threading.enumerate()) == 2
    envs.set_attr("mark", [1, 2, 3, 4])
    assert envs.get_attr("mark") == envs.call("mark") == (1, 2, 3, 4)
    assert envs.call("_whole", 0.05, "time") == (10, 10, 10, 10)
    assert envs.spec.to_json()
    worlds = [env.world for env in envs.envs]
    envs.close()
    envs.close()
    assert not any(thread.name.startswith("libgz crew") for thread in threading.enumerate())
    assert not any(world.clock.running for world in worlds)


def test_gymnasium_takes_it(make):
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(make("Balance", time_limit=0.2))
    envs.reset(seed=0)
    found = [envs.step(envs.action_space.sample())[4] for _ in range(5)]
    assert any("episode" in one for one in found)
    assert not isinstance(envs.unwrapped, SyncVectorEnv)
