"""Environments: their steps per second against a bare loop that steps, commands and reads; processes; other engines.

python benchmarks/gym.py            all parts
python benchmarks/gym.py overhead   one of overhead, vector, others
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np

import libgz.gym
from libgz.gym import WorldEnv

ROUNDS, SHARE = 21, 0.1  # interleaved rounds, and how long each one runs [s]


def bare(env: WorldEnv) -> Callable[[Any], None]:
    """What a program without the environment does: write commands, step, read, and compute the task's own numbers."""
    world, count, writers = env.world, env._count, [write for write, _ in env._writers]
    names = [one.fetch for one in env._readings]
    update, made = env._update, env._made.get("")
    reward, ended = env._reward, env._terminated

    def run(action: Any) -> None:
        values = action.tolist()
        if update is not None:
            update(world)
        if env._lasting:
            for write, value in zip(writers, values, strict=True):
                write(value)
            world.step(count)
        else:
            for _ in range(count):
                for write, value in zip(writers, values, strict=True):
                    write(value)
                world.Step()
        seen = made[0](world) if made is not None else [np.array(fetch()) for fetch in names]
        if reward is not None:
            reward(world, seen, action)
        if ended is not None:
            ended(world, seen)

    return run


def rate(run: Callable[[], object], reset: Callable[[], object]) -> float:
    """Calls per second of a loop that is reset before, and every 100 calls, without the time of the resets."""
    spent, calls = 0.0, 0
    while spent < SHARE:
        reset()
        start = time.process_time()
        for _ in range(100):
            run()
        spent += time.process_time() - start
        calls += 100
    return calls / spent


def overhead() -> None:
    """Steps per second of each task, and their share of the bare loop's."""
    print(f"{'task':18}{'steps/s':>10}{'bare':>10}{'share':>8}  (median of {ROUNDS} interleaved rounds)")
    for name in libgz.gym.TASKS:
        env: Any = gymnasium.make(f"libgz/{name}-v0").unwrapped
        action = np.zeros(env.action_space.shape, np.float32)
        seed = iter(range(10**9))

        def begin(env: WorldEnv = env) -> None:
            env.reset(seed=next(seed) % 5)  # noqa: B023

        begin()
        loop = bare(env)
        rounds = []
        for number in range(ROUNDS):
            pair: dict[bool, float] = {}
            for own in (number % 2 == 0, number % 2 == 1):
                if own:
                    pair[own] = rate(lambda: env.step(action), begin)  # noqa: B023
                else:
                    begin()
                    loop = bare(env)
                    pair[own] = rate(lambda: loop(action), lambda: begin())  # noqa: B023
            rounds.append((pair[True], pair[False]))
        env.close()
        own_rate, bare_rate = (statistics.median(column) for column in zip(*rounds, strict=True))
        share = statistics.median(a / b for a, b in rounds)
        print(f"{name:18}{own_rate:10.0f}{bare_rate:10.0f}{share:8.3f}")


if __name__ == "__main__":
    chosen = sys.argv[1:] or ["overhead", "vector", "others"]
    for part in chosen:
        {"overhead": overhead}[part]()
