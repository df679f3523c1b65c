"""Learn a task by evolution strategies, with numpy alone.

    python examples/learning/learn.py
    python examples/learning/learn.py --task PendulumSwingUp --generations 100 --hidden 16

A policy is a small network: tanh of weights times the scaled observation, to the bounds of the actions. Each generation
tries pairs of opposite changes of the weights (mirrored sampling), ranks them by the return of an episode, and moves
the weights along the changes, by their ranks (Salimans et al., Evolution Strategies as a Scalable Alternative to
Reinforcement Learning, 2017; with Adam's step). The same seed gives the same result to the bit.
"""

from __future__ import annotations

import argparse
import time
from itertools import pairwise
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import libgz.gym  # registers the tasks

Array = NDArray[np.float64]
TESTS = range(10_000, 10_010)  # seeds of the episodes that the result is stated for
# Task -> mean return over these episodes that the default settings reach.
REACHED = {"ReachGoal": 11.0}


class Policy:
    """A network with one hidden layer, or none.

    Args:
        env: the environment, whose spaces are boxes.
        hidden: units of the hidden layer; 0 for none.
    """

    def __init__(self, env: gymnasium.Env[Any, Any], hidden: int = 0) -> None:
        seen, done = env.observation_space, env.action_space
        assert isinstance(seen, gymnasium.spaces.Box)
        assert isinstance(done, gymnasium.spaces.Box)
        self._scale = 1.0 / np.maximum(np.minimum(np.abs(seen.high), 5.0), 1.0)
        self._middle, self._half = (done.high + done.low) / 2.0, (done.high - done.low) / 2.0
        sizes = [int(np.prod(seen.shape)), *([hidden] if hidden else []), int(np.prod(done.shape))]
        self._shapes = [(rows + 1, columns) for rows, columns in pairwise(sizes)]
        self.size = sum(rows * columns for rows, columns in self._shapes)

    def layers(self, weights: Array) -> list[Array]:
        """The weights of each layer, shape (inputs + 1, outputs); the last row is the bias."""
        ends = np.cumsum([rows * columns for rows, columns in self._shapes])[:-1]
        return [part.reshape(shape) for part, shape in zip(np.split(weights, ends), self._shapes, strict=True)]

    def act(self, layers: list[Array], seen: Array) -> Array:
        """The action for an observation."""
        value = seen * self._scale
        for layer in layers:
            value = np.tanh(value @ layer[:-1] + layer[-1])
        action: Array = self._middle + self._half * value
        return action


def play(env: gymnasium.Env[Any, Any], policy: Policy, weights: Array, seed: int) -> float:
    """The return of one episode."""
    layers, (seen, _), total, ended = policy.layers(weights), env.reset(seed=seed), 0.0, False
    while not ended:
        seen, reward, terminated, truncated, _ = env.step(policy.act(layers, seen))
        total, ended = total + float(reward), terminated or truncated
    return total


def learn(
    env: gymnasium.Env[Any, Any], policy: Policy, generations: int, pairs: int, seed: int, verbose: bool = True
) -> Array:
    """The weights that were learned."""
    random = np.random.default_rng(seed)
    weights, mean, square = np.zeros(policy.size), np.zeros(policy.size), np.zeros(policy.size)
    spread, rate, start = 0.3, 0.1, time.perf_counter()
    for generation in range(1, generations + 1):
        changes = random.standard_normal((pairs, policy.size))
        seeds = random.integers(2**31, size=pairs).tolist()
        returns = np.array(
            [
                [play(env, policy, weights + sign * spread * change, one) for sign in (1, -1)]
                for change, one in zip(changes, seeds, strict=True)
            ]
        )
        ranks = np.empty(returns.size)
        ranks[np.argsort(returns.ravel())] = np.linspace(-0.5, 0.5, returns.size)
        ranks = ranks.reshape(returns.shape)
        slope = (ranks[:, 0] - ranks[:, 1]) @ changes / pairs
        mean, square = 0.9 * mean + 0.1 * slope, 0.99 * square + 0.01 * slope**2
        step = (mean / (1.0 - 0.9**generation)) / (np.sqrt(square / (1.0 - 0.99**generation)) + 1e-8)
        weights = weights + rate * step
        if verbose:
            now = time.perf_counter() - start
            shown = f"mean return {returns.mean():8.2f}, best {returns.max():8.2f}"
            print(f"generation {generation:3}: {shown}, {now:5.0f} s", flush=True)
    return weights


def result(env: gymnasium.Env[Any, Any], policy: Policy, weights: Array) -> float:
    """The mean return over the test episodes."""
    return float(np.mean([play(env, policy, weights, seed) for seed in TESTS]))


def main() -> None:
    """Learn, and print the mean return before and after."""
    parser = argparse.ArgumentParser(description="Learn a task by evolution strategies.")
    parser.add_argument(
        "--task", default="ReachGoal", choices=[name for name in libgz.gym.TASKS if name != "TrackBall"]
    )
    parser.add_argument("--generations", type=int, default=30)
    parser.add_argument("--pairs", type=int, default=16, help="of opposite changes in a generation")
    parser.add_argument("--hidden", type=int, default=0, help="units of the hidden layer (default: none)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--save", metavar="FILE.npy", help="where to save the weights")
    options = parser.parse_args()
    env = gymnasium.make(f"libgz/{options.task}-v0")
    policy = Policy(env, options.hidden)
    print(f"{options.task}: {policy.size} weights; mean return before {result(env, policy, np.zeros(policy.size)):.2f}")
    weights = learn(env, policy, options.generations, options.pairs, options.seed)
    print(f"mean return after {result(env, policy, weights):.2f}")
    if options.save:
        np.save(options.save, weights)
    env.close()


if __name__ == "__main__":
    main()
