"""The ready tasks: Gymnasium's own check, determinism, and policies that show what the rewards mean."""

import math
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import libgz.gym

# Gymnasium recommends actions between -1 and 1; these have units.
ALLOWED = "symmetric and normalized"


def toward_goal(seen):
    bearing = math.atan2(seen[2], seen[1])
    return 0.7 * max(0.0, math.cos(bearing)), 2.0 * bearing


def along_wall(seen):
    ahead = seen[14:23].min()
    if ahead < 1.0:
        return 0.4 if ahead > 0.7 else 0.1, 1.0 - 1.2 * (seen[:18].min() - 0.6)
    converging = seen[4] - seen[0] / math.cos(math.radians(20.0))
    return 0.4, -1.2 * (seen[:18].min() - 0.6) - 1.5 * converging


def upright(seen):
    effort = 90.0 * seen[0] + 25.0 * seen[1] + 6.0 * seen[2] + 14.0 * seen[3]
    return effort / 2.0, effort / 2.0


def at_ball(seen):
    image = seen["camera.cam1/image"].astype(int)
    rows, columns = np.nonzero((image[..., 0] > 150) & (image[..., 0] - image[..., 2] > 90))
    if not len(rows):
        return 0.0, 0.0
    focus = 32.0 / math.tan(math.radians(30.0))
    pan, tilt = seen["ptz.cam1/pan"][0], seen["ptz.cam1/tilt"][0]
    return (
        pan - 1.5 * math.atan((columns.mean() - 31.5) / focus),
        tilt + 1.5 * math.atan((rows.mean() - 23.5) / focus),
    )


def swing(seen):
    angle, rate = math.atan2(seen[1], seen[0]), seen[2]
    if abs(angle) < 0.3 and abs(rate) < 2.0:
        return (-20.0 * angle - 4.0 * rate,)
    energy = rate * rate / 6.0 + 4.9 * (seen[0] - 1.0)
    return (math.copysign(2.0, rate) * (1.0 if energy < 0.0 else -min(1.0, energy)),)


# Of the linearised task: x, both angles, their rates.
GAINS = (7.32, 68.1, 332.88, 12.04, 41.86, 46.48)


def on_cart(seen):
    state = (seen[0], math.atan2(seen[1], seen[2]), math.atan2(seen[3], seen[4]), *seen[5:])
    return (-float(np.dot(GAINS, state)),)


# Task -> policy, least return with it, most return of random actions.
POLICIES = {
    "ReachGoal": (toward_goal, 11.0, 0.0),
    "FollowWall": (along_wall, 12.0, 0.0),
    "Balance": (upright, 190.0, 50.0),
    "TrackBall": (at_ball, 150.0, 80.0),
    "PendulumSwingUp": (swing, -400.0, -700.0),
    "DoublePendulum": (on_cart, 490.0, 50.0),
}


def play(env, policy, seed=1):
    seen, _ = env.reset(seed=seed)
    total, ended = 0.0, False
    while not ended:
        seen, reward, terminated, truncated, _ = env.step(np.asarray(policy(seen), np.float32))
        total, ended = total + reward, terminated or truncated
    return total


def test_every_task_has_a_policy_here():
    assert set(POLICIES) == set(libgz.gym.TASKS)


@pytest.mark.parametrize("name", POLICIES)
def test_gymnasium_accepts_it(name):
    env = gymnasium.make(f"libgz/{name}-v0", render_mode="rgb_array")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=0)
    image = env.render()
    env.close()
    assert [str(one.message) for one in caught if ALLOWED not in str(one.message)] == []
    assert image.shape == (360, 480, 3)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 4  # something is to be seen


@pytest.mark.parametrize("name", POLICIES)
def test_its_reward_is_high_for_who_solves_it(name):
    policy, least, random_most = POLICIES[name]
    env = gymnasium.make(f"libgz/{name}-v0")
    assert play(env, policy) > least
    env.action_space.seed(0)
    assert play(env, lambda _: env.action_space.sample()) < random_most
    env.close()


def episode(env, seed):
    env.action_space.seed(seed)
    seen, info = env.reset(seed=seed)
    found = [seen, info["sim_time"]]
    for _ in range(15):
        seen, reward, *_ = env.step(env.action_space.sample())
        found += [seen, reward]
    return [part.tobytes() if isinstance(part, np.ndarray) else repr(part) for part in found]


@pytest.mark.parametrize("name", POLICIES)
def test_a_seed_repeats_to_the_bit(name):
    env = gymnasium.make(f"libgz/{name}-v0")
    first, other = episode(env, 3), episode(env, 4)
    again = episode(env, 3)
    env.close()
    fresh = gymnasium.make(f"libgz/{name}-v0")
    anew = episode(fresh, 3)
    fresh.close()
    assert first == again == anew
    assert first != other


def test_a_goal_can_be_given():
    env = gymnasium.make("libgz/ReachGoal-v0")
    seen, _ = env.reset(seed=0, options={"goal": (3.0, 4.0)})
    assert abs(seen[0] - 5.0) < 0.05
    with pytest.raises(libgz.ParameterError, match="goal is 'x'; it must be two finite numbers"):
        env.reset(options={"goal": "x"})
    env.close()


@pytest.mark.parametrize("name", libgz.gym.TASKS)
def test_a_state_has_the_episode(name):
    """What follows is equal to the bit, the end and the next episode included."""
    env = gymnasium.make(f"libgz/{name}-v0", time_limit=1.0).unwrapped
    random = np.random.default_rng(2)
    actions = random.uniform(env.action_space.low, env.action_space.high, (15, *env.action_space.shape))

    def play(part):
        found = []
        for action in part:
            seen, *rest = env.step(action.astype(np.float32))
            found.append((repr(gymnasium.spaces.flatten(env.observation_space, seen).tolist()), repr(rest)))
            if rest[1] or rest[2]:
                begun, info = env.reset()
                found.append((repr(gymnasium.spaces.flatten(env.observation_space, begun).tolist()), repr(info)))
        return found

    env.reset(seed=4)
    play(actions[:3])
    state = env.world.get_state()
    expected = play(actions[3:])
    env.reset(seed=9)
    play(actions[:5])
    env.world.set_state(state)
    assert play(actions[3:]) == expected
    env.close()


def test_a_state_has_what_a_class_of_users_declares():
    class Counted(libgz.gym.tasks.PendulumSwingUp):
        STATE = ("count",)

        def begin(self, world, random, options):
            super().begin(world, random, options)
            self.count = 0

        def step(self, action):
            self.count += 1
            return super().step(action)

    with Counted() as env:
        env.reset(seed=1)
        env.step([0.5])
        state = env.world.get_state()
        env.step([0.5])
        env.world.set_state(state)
        assert env.count == 1
