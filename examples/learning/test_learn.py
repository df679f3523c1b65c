"""The example learns: some generations in each test run, the whole of it as a trial."""

import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parent))
import learn

sys.path.pop(0)


@pytest.fixture
def task():
    env = gymnasium.make("libgz/ReachGoal-v0")
    yield env, learn.Policy(env)
    env.close()


def test_a_few_generations_are_better_than_none(task):
    env, policy = task
    weights = learn.learn(env, policy, generations=4, pairs=6, seed=0, verbose=False)
    seeds = range(3)
    before, after = (
        np.mean([learn.play(env, policy, one, seed) for seed in seeds]) for one in (0.0 * weights, weights)
    )
    assert after > before + 2.0


@pytest.mark.trial
def test_the_stated_return_is_reached(task):
    env, policy = task
    weights = learn.learn(env, policy, generations=30, pairs=16, seed=0, verbose=False)
    assert learn.result(env, policy, weights) >= learn.REACHED["ReachGoal"]
