"""Environments: their steps per second against a bare loop that steps, commands and reads; processes; other engines.

python benchmarks/gym.py            all parts
python benchmarks/gym.py batch      one of overhead, processes, batch, engines
python benchmarks/gym.py batch Balance ReachGoal    of these tasks only

Times of one process are processor time, so that other programs matter little; those of processes are real time.
"""

from __future__ import annotations

import multiprocessing
import os
import statistics
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import gymnasium
import numpy as np

import libgz.gym
from libgz.gym import WorldEnv

ROUNDS, SHARE = 101, 0.02  # interleaved rounds, and how long each one runs [s]


def bare(env: WorldEnv) -> Callable[[list[float]], object]:
    """What a program without the environment does: write commands, step, read."""
    world, count, writers = env.world, env._count, env._writers
    fetchers, update, law = [(one.fetch, one.dtype) for one in env._readings], env._update, env._law

    def run(values: list[float]) -> object:
        if update is not None:
            update(world)
        if env._lasting:
            for write, value in zip(writers, values, strict=True):
                write(value)
            world.step(count, law)
        elif env._write_held(values):
            world.engine.hold(env._efforts)
            world.step(count, law)
            world.engine.hold(None)
        else:
            for _ in range(count):
                for write, value in zip(writers, values, strict=True):
                    write(value)
                world.Step()
            if law is not None:
                law()
        return env._observation() if law is not None else [np.array(fetch(), dtype) for fetch, dtype in fetchers]

    return run


def rate(run: Callable[[], object], reset: Callable[[], object]) -> float:
    """Calls per second of processor time; resets, before the first call and every 100 calls, are not counted."""
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
    print(f"{'task':18}{'steps/s':>10}{'bare':>10}{'share':>8}   median of {ROUNDS} interleaved rounds")
    for name in libgz.gym.TASKS:
        env: Any = gymnasium.make(f"libgz/{name}-v0").unwrapped
        action = np.zeros(env.action_space.shape, np.float32)
        seeds = iter(range(10**9))

        def begin(env: Any = env, seeds: Any = seeds) -> None:
            env.reset(seed=next(seeds) % 5)

        begin()
        loop, values = bare(env), action.tolist()
        turns: list[tuple[str, Callable[[], object]]] = [
            ("env", lambda env=env, action=action: env.step(action)),
            ("bare", lambda loop=loop, values=values: loop(values)),
        ]
        rounds = []
        for number in range(ROUNDS):
            order = turns if number % 2 else turns[::-1]
            rounds.append({which: rate(run, begin) for which, run in order})
        env.close()
        own, plain = (statistics.median(one[which] for one in rounds) for which in ("env", "bare"))
        share = statistics.median(one["env"] / one["bare"] for one in rounds)
        print(f"{name:18}{own:10.0f}{plain:10.0f}{share:8.3f}")


def processes() -> None:
    """Steps per second of environments in one process and in two."""
    print(f"{'task':18}{'one':>10}{'two':>10}{'ratio':>8}{'best':>8}   steps/s; median of {ROUNDS} interleaved rounds")
    for name in libgz.gym.TASKS:
        many = [gymnasium.make_vec(f"libgz/{name}-v0", num_envs=n, vectorization_mode="async") for n in (1, 2)]
        actions = [np.zeros(one.action_space.shape, np.float32) for one in many]
        for one in many:
            one.reset(seed=0)
        rounds = []
        for number in range(ROUNDS):
            pair = [0.0, 0.0]
            for which in (0, 1) if number % 2 else (1, 0):
                start = time.perf_counter()
                for _ in range(50):
                    many[which].step(actions[which])
                pair[which] = 50 * (which + 1) / (time.perf_counter() - start)
            rounds.append(pair)
        for one in many:
            one.close()
        one, two = (statistics.median(column) for column in zip(*rounds, strict=True))
        best = max(pair[1] for pair in rounds) / max(pair[0] for pair in rounds)
        print(f"{name:18}{one:10.0f}{two:10.0f}{statistics.median(b / a for a, b in rounds):8.2f}{best:8.2f}")


BATCH, BATCH_ROUNDS = 64, 15  # environments, and rounds of about 0.3 s on either side


def turns(name: str, count: int, first: int) -> Callable[[int], object]:
    """Environments that step one after the other; a function that does so many steps of each."""
    envs: list[Any] = [gymnasium.make(f"libgz/{name}-v0").unwrapped for _ in range(count)]
    for number, env in enumerate(envs):
        env.reset(seed=first + number)
    action = np.zeros(envs[0].action_space.shape, np.float32)

    def run(steps: int) -> None:
        for _ in range(steps):
            for env in envs:
                *_, ended, cut, _ = env.step(action)
                if ended or cut:
                    env.reset()

    return run


def serve(name: str, count: int, first: int, pipe: Any) -> None:
    """A process with such environments."""
    run = turns(name, count, first)
    while steps := pipe.recv():
        run(steps)
        pipe.send(None)


def batch() -> None:
    """Steps per second of many environments of one process by threads, over those of as many processes as cores."""
    cores = len(os.sched_getaffinity(0))
    print(f"{'task':18}{'threads':>10}{'processes':>10}{'ratio':>8}   {BATCH} environments, {cores} cores")
    for name in [task for task in libgz.gym.TASKS if task in sys.argv] or libgz.gym.TASKS:
        share, pipes, workers = BATCH // cores, [], []
        for number in range(cores):
            ours, theirs = multiprocessing.Pipe()
            arguments = (name, share, number * share, theirs)
            workers.append(multiprocessing.Process(target=serve, args=arguments, daemon=True))
            workers[-1].start()
            pipes.append(ours)
        envs = gymnasium.make_vec(f"libgz/{name}-v0", num_envs=share * cores)
        envs.reset(seed=0)
        actions = np.zeros(envs.action_space.shape, np.float32)

        def by_threads(steps: int, envs: Any = envs, actions: Any = actions) -> None:
            for _ in range(steps):
                envs.step(actions)

        def by_processes(steps: int, pipes: Any = pipes) -> None:
            for pipe in pipes:
                pipe.send(steps)
            for pipe in pipes:
                pipe.recv()

        sides = [by_threads, by_processes]
        start = time.perf_counter()
        by_threads(5)
        steps = max(1, round(1.5 / (time.perf_counter() - start)))
        rounds = []
        for number in range(BATCH_ROUNDS):
            taken = {}
            for side in sides if number % 2 else sides[::-1]:
                start = time.perf_counter()
                side(steps)
                taken[side] = time.perf_counter() - start
            rounds.append([share * cores * steps / taken[side] for side in sides])
        envs.close()
        for pipe, worker in zip(pipes, workers, strict=True):
            pipe.send(0)
            worker.join()
        ours, theirs = (statistics.median(column) for column in zip(*rounds, strict=True))
        ratio = statistics.median(one / other for one, other in rounds)
        print(f"{name:18}{ours:10.0f}{theirs:10.0f}{ratio:8.2f}", flush=True)


# One scene in all engines: a cart on a rail with two rods, 2 ms a step, ten steps for an action, a force on the cart.

MUJOCO = """
<mujoco><option timestep="0.002" gravity="0 0 -9.8" integrator="Euler"/><worldbody><body name="cart" pos="0 0 0.5">
<joint name="rail" type="slide" axis="1 0 0" limited="true" range="-2.4 2.4"/>
<inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>
<body name="lower"><joint name="shoulder" axis="0 1 0"/>
<inertial pos="0 0 0.3" mass="0.3" diaginertia="0.009 0.009 0.0002"/>
<body name="upper" pos="0 0 0.6"><joint name="elbow" axis="0 1 0"/>
<inertial pos="0 0 0.3" mass="0.3" diaginertia="0.009 0.009 0.0002"/></body></body></body></worldbody>
<actuator><motor joint="rail" gear="1"/></actuator></mujoco>
"""
URDF = """
<robot name="cart"><link name="base"/>
<link name="cart"><inertial><mass value="2"/>
<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
{links}
<joint name="rail" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-2.4" upper="2.4" effort="40" velocity="100"/></joint>
<joint name="shoulder" type="continuous"><parent link="cart"/><child link="lower"/><axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous">
<parent link="lower"/><child link="upper"/><origin xyz="0 0 0.6"/><axis xyz="0 1 0"/></joint>
</robot>
"""
LINK = """<link name="{}"><inertial><origin xyz="0 0 0.3"/><mass value="0.3"/>
<inertia ixx="0.009" iyy="0.009" izz="0.0002" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
STEPS = 10
ANGLES = (0.03, -0.02)  # of shoulder and elbow at the start [rad]: upright, the rods of some engines would not move


def libgz_steps(solver: str = "world") -> Callable[[], object]:
    """The task DoublePendulum."""
    env: Any = gymnasium.make("libgz/DoublePendulum-v0", solver=solver).unwrapped
    env.reset(seed=0)
    for joint, angle in zip(env._joints[1:], ANGLES, strict=True):
        joint.set_position(angle)
    loop = bare(env)
    return lambda: loop([0.0])


def mujoco_steps() -> Callable[[], object]:
    """The same scene in MuJoCo."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(MUJOCO)
    data = mujoco.MjData(model)
    data.qpos[1:] = ANGLES

    def run() -> object:
        data.ctrl[0] = 0.0
        mujoco.mj_step(model, data, nstep=STEPS)
        return np.concatenate([data.qpos, data.qvel])

    return run


def pybullet_steps() -> Callable[[], object]:
    """The same scene in PyBullet."""
    import tempfile

    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(0.002, client)
    pybullet.setGravity(0, 0, -9.8, client)
    with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
        file.write(URDF.format(links=LINK.format("lower") + LINK.format("upper")))
        file.flush()
        robot = pybullet.loadURDF(file.name, useFixedBase=True, physicsClientId=client)
    for joint, angle in zip((1, 2), ANGLES, strict=True):
        pybullet.resetJointState(robot, joint, angle, physicsClientId=client)
        pybullet.setJointMotorControl2(robot, joint, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=client)
    pybullet.setJointMotorControl2(robot, 0, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=client)

    def run() -> object:
        for _ in range(STEPS):
            pybullet.setJointMotorControl2(robot, 0, pybullet.TORQUE_CONTROL, force=0.0, physicsClientId=client)
            pybullet.stepSimulation(client)
        return np.array([one[:2] for one in pybullet.getJointStates(robot, [0, 1, 2], physicsClientId=client)])

    return run


def engines() -> None:
    """Actions per second on one scene; engines that are not installed are left out."""
    found: dict[str, Callable[[], object]] = {}
    for name, make in (
        ("libgz", libgz_steps),
        ("libgz, tree", partial(libgz_steps, "tree")),
        ("MuJoCo", mujoco_steps),
        ("PyBullet", pybullet_steps),
    ):
        try:
            found[name] = make()
        except ImportError as error:
            print(f"{name}: not installed ({error})")
    rounds = [{name: rate(run, lambda: None) for name, run in found.items()} for _ in range(ROUNDS)]
    print(f"{'engine':18}{'actions/s':>12}{'of libgz':>10}   cart with two rods, {STEPS} steps of 2 ms an action")
    for name in found:
        ratio = statistics.median(one[name] / one["libgz"] for one in rounds)
        print(f"{name:18}{statistics.median(one[name] for one in rounds):12.0f}{ratio:10.2f}")


if __name__ == "__main__":
    parts = {"overhead": overhead, "processes": processes, "batch": batch, "engines": engines}
    for part in [one for one in sys.argv[1:] if one not in libgz.gym.TASKS] or parts:
        parts[part]()
