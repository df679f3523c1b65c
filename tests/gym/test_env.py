"""WorldEnv: spaces, actions, observations, resets, randomisation, views, processes."""

import gc
import weakref
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import libgz
import libgz.gym
from libgz.gym import WorldEnv

ROOT = Path(__file__).parents[2]
DRIVE = {"position.robot1": ["cmd_vel_pos[0]", "cmd_vel_rot[2]"]}
ODOMETRY = {"position.robot1": ["pos", "rot"]}
ARM = """
<sdf version="1.6"><world name="default"><physics type="ode"><max_step_size>0.002</max_step_size></physics>
<model name="arm">
<link name="base"><inertial><mass>5</mass></inertial></link>
<link name="rod"><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass></inertial>
<sensor name="imu" type="imu"><update_rate>50</update_rate><imu><angular_velocity><y><noise type="gaussian">
<mean>0</mean><stddev>0.1</stddev></noise></y></angular_velocity></imu></sensor>
<sensor name="laser" type="ray"><update_rate>20</update_rate><ray><scan><horizontal><samples>7</samples>
<min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan><range><min>0.1</min><max>4</max></range></ray></sensor>
</link>
<joint name="fixed" type="fixed"><parent>world</parent><child>base</child></joint>
<joint name="elbow" type="revolute"><parent>base</parent><child>rod</child><axis><xyz>0 1 0</xyz>
<limit><lower>-1</lower><upper>1</upper><effort>3</effort></limit></axis></joint>
</model></world></sdf>
"""


@pytest.fixture
def make():
    made = []

    def start(*arguments, **options):
        named = dict(zip(("world", "actions", "observations"), arguments, strict=False))
        env = gymnasium.make("libgz/World-v0", disable_env_checker=True, **named, **options)
        made.append(env)
        return env

    yield start
    for env in made:
        env.close()


def test_a_legacy_world_by_interfaces(make):
    env = make(
        world="pioneer2at",
        actions=DRIVE,
        observations={"laser.laser1": ["ranges"], "position.robot1": ["pos", "rot", "stall"]},
        reward=lambda world, seen, action: seen["position.robot1/pos"][0],
        terminated=lambda world, seen: seen["position.robot1/pos"][0] > 0.2,
        time_limit=3.0,
    )
    laser = env.observation_space["laser.laser1/ranges"]
    assert laser.shape == (181,)
    assert laser.dtype == np.float64
    assert (laser.low.min(), laser.high.max()) == (0.0, 8.192)
    assert env.observation_space["position.robot1/stall"] == gymnasium.spaces.Box(0, 1, (1,), np.int32)
    assert (env.action_space.low.tolist(), env.action_space.high.tolist()) == ([-100, -100], [100, 100])
    seen, _ = env.reset(seed=0)
    assert seen in env.observation_space
    for count in range(1, 31):  # noqa: B007
        seen, reward, terminated, truncated, info = env.step([0.3, 0.0])
        assert seen in env.observation_space
        assert reward == seen["position.robot1/pos"][0]
        if terminated:
            break
    assert terminated
    assert not truncated
    assert 6 <= count <= 9  # 0.2 m at 0.3 m/s, ten times a second, after one update
    assert info["sim_time"] == pytest.approx(0.1 + 0.1 * count)
    env.reset(seed=0)
    ends = [env.step([0.0, 0.0])[2:4] for _ in range(30)]
    assert ends == [(False, False)] * 29 + [(False, True)]


def test_an_sdf_world_by_joints_links_and_sensors(make):
    env = make(
        world=ARM,
        actions={"arm::elbow": ["effort"]},
        observations={
            "arm::elbow": ["position", "velocity"],
            "arm::rod": ["pos", "quat", "angular_vel"],
            "arm::rod::imu": ["angular_velocity"],
            "laser": ["ranges"],
            "own": (lambda world: np.array([world.GetSimTime()]), gymnasium.spaces.Box(0.0, 100.0, (1,), np.float64)),
        },
        period=0.02,
    )
    assert env.action_space == gymnasium.spaces.Box(-3.0, 3.0, (1,), np.float32)
    spaces = env.observation_space
    assert spaces["laser/ranges"] == gymnasium.spaces.Box(0.1, 4.0, (7,), np.float64)
    assert -1.2 < spaces["arm::elbow/position"].low[0] < -1.0
    assert (spaces["arm::rod/quat"].low == -1.0).all()
    seen, _ = env.reset(seed=5)
    assert seen in spaces
    for _ in range(10):
        seen, *_ = env.step([3.0])
    assert seen["arm::elbow/velocity"][0] > 0.05
    assert seen["arm::elbow/velocity"][0] == pytest.approx(seen["arm::rod/angular_vel"][1])
    assert seen["own"][0] == pytest.approx(env.unwrapped.world.GetSimTime())
    noise = [env.reset(seed=seed)[0]["arm::rod::imu/angular_velocity"][1] for seed in (5, 6, 5)]
    assert noise[0] == noise[2] != noise[1]


def test_bounds_of_actions_are_those_given_or_those_of_the_world(make):
    env = make("segwayrmp", DRIVE, ODOMETRY)
    assert env.action_space.high.tolist() == pytest.approx([1.5, 1.4])
    env = make("segwayrmp", {"position.robot1": {"cmd_vel_pos[0]": (-0.2, 0.5), "cmd_vel_rot[2]": None}}, ODOMETRY)
    assert env.action_space.low.tolist() == pytest.approx([-0.2, -1.4])
    env.reset()
    env.step([9.0, 9.0])  # what is beyond is clipped
    data = env.unwrapped.world.interface("position", "robot1").data
    assert (data.cmd_vel_pos[0], data.cmd_vel_rot[2]) == pytest.approx((0.5, 1.4))


def test_bounds_of_observations_are_those_given_and_clip(make):
    bounded = {"robot1": {"pos": (-0.1, 0.1), "quat": None}, "sonar.robot1": {"ranges": (0.5, 9)}}
    env = make("pioneer2at", DRIVE, bounded)
    spaces = env.observation_space
    assert spaces["robot1/pos"].high.tolist() == [0.1] * 3
    assert spaces["sonar.robot1/ranges"].high.max() == 5.0  # no sonar reaches 9 m
    assert spaces["robot1/quat"].high.tolist() == [1.0] * 4  # its own bounds
    env.reset(seed=1)
    for _ in range(10):
        seen, *_ = env.step([0.5, 0.0])
    assert seen in spaces
    assert seen["robot1/pos"][0] == 0.1 < env.unwrapped.world.body("robot1").GetPosition()[0]


def test_a_flat_observation_is_one_box(make):
    observed = {"sonar.robot1": ["ranges"], "position.robot1": ["pos[0:2]", "stall"]}
    env, apart = make("pioneer2at", DRIVE, observed, flat=True), make("pioneer2at", DRIVE, observed)
    (seen, _), (parts, _) = env.reset(seed=3), apart.reset(seed=3)
    assert env.observation_space.shape == seen.shape == (19,)
    assert seen in env.observation_space
    flat = gymnasium.spaces.flatten(apart.observation_space, parts)
    assert (seen.dtype, seen.tolist()) == (flat.dtype, flat.tolist())


ERRORS = [
    ({"position.robot2": ["cmd_vel_pos[0]"]}, ODOMETRY, {}, "no model serves position.robot2"),
    ({"position.robot1": ["cmd_vel_po[0]"]}, ODOMETRY, {}, "did you mean 'cmd_vel_pos'"),
    ({"position.robot1": ["pos[0]"]}, ODOMETRY, {}, "clients cannot write 'pos'"),
    (
        {"position.robot1": ["cmd_vel_pos[1]"]},
        ODOMETRY,
        {},
        r"does not obey cmd_vel_pos\[1\]; it obeys cmd_vel_pos\[0\]",
    ),
    ({"position.robot1": {"cmd_vel_pos[0]": (-999, 999)}}, ODOMETRY, {}, "beyond -100 to 100"),
    ({"position.robot1": {"cmd_vel_pos[0]": 3}}, ODOMETRY, {}, "must be a pair of bounds"),
    ({"robot1::left_front": ["effort"]}, ODOMETRY, {}, "has no bounds of its own; give them"),
    ({}, ODOMETRY, {}, "actions is empty"),
    (DRIVE, {}, {}, "observations is empty"),
    (DRIVE, {"position.robot1": "pos"}, {}, "must be a list of fields"),
    (DRIVE, {"position.robot1": ["poss"]}, {}, "did you mean 'pos'"),
    (DRIVE, {"position.robot1": ["pos[7]"]}, {}, "cannot be read: index 7 is out of bounds"),
    (DRIVE, {"fiducial.laser1": ["fids"]}, {}, "is not of numbers; name one of id, pos, rot"),
    (DRIVE, {"robot3": ["pos"]}, {}, "no interface, model, joint, body or sensor 'robot3'; .* did you mean 'robot1'"),
    (DRIVE, {"position.robot1": {"pos[0]": (2, 1)}}, {}, "the lower bound, 2, must be below the upper one, 1"),
    (DRIVE, ODOMETRY, {"period": 0.03}, "must be a multiple of the world's step, 0.02 s"),
    (DRIVE, ODOMETRY, {"render_mode": "rgb_aray"}, "did you mean 'rgb_array'"),
    (["cmd"], ODOMETRY, {}, r"actions is \['cmd'\]; it must be a table"),
    (DRIVE, ODOMETRY, {"reward": 5}, "reward is 5; it must be a function, or None"),
    (DRIVE, ODOMETRY, {"randomise": 5}, "randomise is 5; it must be a table, such as {'crate/mass'"),
    (DRIVE, ODOMETRY, {"randomise": {"crate/mas": ("uniform", 1, 2)}}, "nothing in the world reads <mas>"),
    (DRIVE, ODOMETRY, {"randomise": {"crate/mass": ("unifrm", 1, 2)}}, "did you mean 'uniform'"),
]


@pytest.mark.parametrize(("actions", "observations", "options", "message"), ERRORS)
def test_errors_name_what_is_wrong(actions, observations, options, message):
    with pytest.raises(libgz.GazeboError, match=message):
        WorldEnv("pioneer2at", actions, observations, **options)  # before any reset


def test_wrong_calls(make):
    env = make("pioneer2at", DRIVE, ODOMETRY).unwrapped
    with pytest.raises(gymnasium.error.ResetNeeded):
        env.step([0.0, 0.0])
    env.reset()
    for action, message in (
        ([0.0], "it must have 2 numbers"),
        ([np.nan, 0.0], "must be finite"),
        ("x", "must be 2 numbers"),
    ):
        with pytest.raises(libgz.ParameterError, match=message):
            env.step(action)
    env.close()
    with pytest.raises(libgz.ClosedError, match="the environment is closed"):
        env.reset()


def test_randomisation_samples_anew_at_each_reset(make):
    env = make(
        "pioneer2at",
        DRIVE,
        {**ODOMETRY, "crate": ["pos"]},
        randomise={
            "crate/mass": {"uniform": [5.0, 50.0]},
            "crate/xyz[0]": ("normal", 3.0, 0.5),
            "barrel/retro": [0, 1],
        },
    )
    found = []
    for seed in (1, 2, 1):
        seen, info = env.reset(seed=seed)
        assert env.unwrapped.world.body("crate").mass == info["sampled"]["crate/mass"]
        assert seen["crate/pos"][0] == pytest.approx(info["sampled"]["crate/xyz[0]"], abs=1e-3)
        assert 5.0 <= info["sampled"]["crate/mass"] <= 50.0
        found.append((info["sampled"], env.step([0.3, 0.5])[0]["position.robot1/pos"].tobytes()))
    assert found[0] == found[2]
    assert found[0][0] != found[1][0]
    more = [env.reset()[1]["sampled"]["crate/mass"] for _ in range(3)]
    assert len(set(more)) == 3


def test_closing_frees_everything():
    env = WorldEnv("pioneer2at", DRIVE, ODOMETRY, render_mode="rgb_array")
    env.reset()
    assert env.render().shape == (360, 480, 3)
    world = weakref.ref(env.world)
    before = len(list(Path("/proc/self/fd").iterdir()))
    env.close()
    env.close()
    del env
    gc.collect()
    assert world() is None
    assert len(list(Path("/proc/self/fd").iterdir())) <= before


def test_human_mode_serves_a_page(make, caplog):
    env = make("pioneer2at", DRIVE, ODOMETRY, render_mode="human")
    env.reset(seed=0)
    for _ in range(3):
        env.step([0.3, 0.0])
    assert "open http://127.0.0.1:" in caplog.text


def test_images_are_observed_and_rendered_by_a_named_camera(make):
    env = make("ptz", {"ptz.cam1": ["cmd_pan"]}, {"camera.cam1": ["image"]}, render_mode="rgb_array", camera="cam1")
    assert env.action_space.high[0] == pytest.approx(0.3 * np.pi)
    seen, _ = env.reset(seed=0)
    assert seen["camera.cam1/image"].shape == (240, 320, 3)
    assert env.observation_space["camera.cam1/image"].dtype == np.uint8
    assert (env.render() == seen["camera.cam1/image"]).all()


@pytest.mark.parametrize("name", ["TrackBall", "PendulumSwingUp"])
def test_processes_are_equal_to_one(name):
    def returns(mode):
        envs = gymnasium.make_vec(f"libgz/{name}-v0", num_envs=2, vectorization_mode=mode)
        seen, _ = envs.reset(seed=7)
        found = [seen]
        for _ in range(5):
            seen, rewards, *_ = envs.step(np.full(envs.action_space.shape, 0.2, np.float32))
            found += [seen, rewards]
        envs.close()
        return [
            tuple(part[key].tobytes() for key in sorted(part)) if isinstance(part, dict) else part.tobytes()
            for part in found
        ]

    assert returns("async") == returns("sync")


def test_actions_act_on_what_a_reset_built_again(make):
    """Interfaces and joints are found anew where the world has other objects."""
    drive, push = (
        make("pioneer2at", DRIVE, ODOMETRY),
        make(ARM, {"arm::elbow": ["effort"]}, {"arm::elbow": ["velocity"]}),
    )
    moved = []
    for env, name in ((drive, "robot1"), (push, "arm")):
        env.reset(seed=0)
        expected = [repr(env.step([2.0] * env.action_space.shape[0])[0]) for _ in range(5)]
        env.unwrapped.world.DeleteModel(name)
        env.reset(seed=0)
        moved.append([repr(env.step([2.0] * env.action_space.shape[0])[0]) for _ in range(5)] == expected)
    assert moved == [True, True]
