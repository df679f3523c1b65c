"""`libgz plot` and `libgz export`, of logs and of running servers; `gazebo --record view=FILE`."""

import csv
import os
import subprocess

import numpy as np
import pytest
from commands import command_line, run_command, run_libgz
from log_kills import WORLD
from PIL import Image

import libgz
from libgz.apps.series import read_logs
from libgz.base.errors import NotFoundError
from libgz.base.geometry import GzQuaternToEuler
from libgz.recording.capture import Capture
from libgz.recording.reader import LogReader
from libgz.rendering.framing import overview

SERVER_ID = 960_000 + os.getpid()
LIGHT = WORLD.replace(
    "<model:Pion", "<model:LightSource><id>l</id><xyz>-3 -3 9</xyz></model:LightSource><model:Pion", 1
)
SDF = """<sdf version="1.6"><world name="default"><include><uri>model://sun</uri></include>
<model name="ball"><pose>0 0 5 0 0 0</pose><link name="link">
<collision name="c"><geometry><sphere><radius>0.5</radius></sphere></geometry></collision>
<visual name="v"><geometry><sphere><radius>0.5</radius></sphere></geometry></visual></link></model></world></sdf>"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A log, and what it must hold."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    poses, ranges = [], []
    with libgz.World.from_string(WORLD) as world, Capture(world, path) as log:
        world.interface("position", "robot1").command(vx=0.5, vyaw=0.3)
        for _ in range(60):
            world.Step()
            log.take()
            poses.append(world.body("robot1").GetPose())
            ranges.append(float(world.interface("laser", "laser1").ranges[:1].sum()))
    return path, poses, ranges


def table(path):
    with path.open(newline="") as file:
        head, *rows = csv.reader(file)
    return head, rows


def test_export(run, tmp_path):
    path, poses, _ = run
    done = run_libgz("export", path, "--csv", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    names = {one.name for one in (tmp_path / "out").iterdir()}
    assert {"position.robot1.csv", "laser.laser1.csv", "sim.default.csv", "state.robot1.canonical.csv"} <= names
    head, rows = table(tmp_path / "out" / "state.robot1.canonical.csv")
    assert head[:4] == ["sim time [s]", "pos[0] [m]", "pos[1] [m]", "pos[2] [m]"]
    numbers = np.array(rows, dtype=float)
    np.testing.assert_allclose(numbers[1:, 0], 0.02 * np.arange(1, 61), atol=1e-9)
    np.testing.assert_array_equal(numbers[1:, 1:4], [tuple(pose.pos) for pose in poses])
    np.testing.assert_allclose(numbers[1:, 4:7], [tuple(GzQuaternToEuler(pose.rot)) for pose in poses])
    head, rows = table(tmp_path / "out" / "laser.laser1.csv")
    assert "ranges[180] [m]" in head or "ranges[180]" in head
    one = run_libgz("export", path, "power.robot1", "-o", tmp_path / "one")
    assert [file.name for file in (tmp_path / "one").iterdir()] == ["power.robot1.csv"]
    assert one.returncode == 0
    missing = run_libgz("export", path, "power.robot2")
    assert missing.returncode == 1
    assert "did you mean '/power/robot1'" in missing.stderr


TARGETS = [(name, []) for name in ("state.robot1", "sim.default", "position.robot1", "state.robot1::canonical")]


def count_readings(monkeypatch):
    read, messages = [], LogReader.messages

    def count(*arguments, **more):
        read.append(more)
        return messages(*arguments, **more)

    monkeypatch.setattr(LogReader, "messages", count)
    return read


def test_a_log_is_read_once_for_all_targets(run, monkeypatch):
    read = count_readings(monkeypatch)
    with LogReader(run[0]) as log:
        together = list(read_logs(log, TARGETS))
        assert len(read) == 1
        alone = [series for one in TARGETS for series in read_logs(log, [one])]
    assert [(one.times, one.lines, one.units) for one in together] == [(o.times, o.lines, o.units) for o in alone]
    assert all(one.times for one in together)


@pytest.mark.parametrize(
    ("wrong", "words"), [("power.nobody", "has no /power/nobody"), ("state.nobody", "no body 'nobody'")]
)
def test_targets_before_a_wrong_one_are_read(run, wrong, words):
    with LogReader(run[0]) as log:
        reading = read_logs(log, [*TARGETS, (wrong, []), TARGETS[0]])
        assert all(next(reading).times for _ in TARGETS)
        with pytest.raises(NotFoundError, match=words):
            next(reading)


def test_targets_that_do_not_fit_together_are_read_in_turn(run, monkeypatch):
    read = count_readings(monkeypatch)
    monkeypatch.setattr("libgz.base.budget.DECOMPRESSED", 1 << 20)
    with LogReader(run[0]) as log:
        found = list(read_logs(log, TARGETS * 60))
    assert len(read) > 2
    assert [one.times for one in found] == [one.times for one in found[: len(TARGETS)]] * 60


def test_plot_of_a_log(run, tmp_path):
    words = ("position.robot1", "pos", "rot[2]", "laser.laser1", "ranges[0]", "state.robot1", "vel")
    done = run_libgz("plot", run[0], *words, "-o", tmp_path / "p.png")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"61 samples plotted to {tmp_path / 'p.png'}\n"
    with Image.open(tmp_path / "p.png") as image:
        assert image.size == (800, 1050)
    assert run_libgz("plot", run[0], "state.robot1", "pos", "--to", "0.5", "-o", tmp_path / "q.svg").returncode == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["position.robot1"], "has no field to plot"),
        ([], "no target is given"),
        (["position.robot1", "poss"], "did you mean 'pos'"),
        (["state.robt1", "pos"], "did you mean 'robot1'"),
        (["state.robot1", "place"], "it has pos, rot, vel, omega"),
        (["~/nothing", "data"], "has no /gazebo/default/nothing"),
        (["laser.laser1", "ranges[0]", "--from", "100"], "there is nothing to plot"),
    ],
)
def test_errors_of_plots(run, words, message):
    done = run_libgz("plot", run[0], *words)
    assert done.returncode == 1
    assert message in done.stderr


def test_plot_of_a_running_server(tmp_path):
    world = tmp_path / "a.world"
    world.write_text(WORLD)
    with subprocess.Popen(command_line("gazebo", "-s", SERVER_ID, "-d", -1, world)) as server:
        try:
            with libgz.Observer(SERVER_ID, timeout=30.0):
                words = ("position.robot1", "pos", "state.robot1", "pos")
                done = run_libgz("plot", "-s", SERVER_ID, *words, "--seconds", "0.5", "-o", tmp_path / "p.png")
        finally:
            server.terminate()
    assert done.returncode == 0, done.stderr
    assert "samples plotted" in done.stdout


def test_topics_in_plots_and_tables(tmp_path):
    with libgz.World.from_string(SDF) as world:
        world.attach_era()
        with Capture(world, tmp_path / "a.mcap") as log:
            for _ in range(100):
                world.Step()
                log.take()
    done = run_libgz(
        "plot", tmp_path / "a.mcap", "state.ball", "pos[2]", "~/world_stats", "iterations", "-o", tmp_path / "p.png"
    )
    assert done.returncode == 0, done.stderr
    wrong = run_libgz("plot", tmp_path / "a.mcap", "~/world_stats", "iteration")
    assert "has no field 'iteration'" in wrong.stderr
    assert run_libgz("export", tmp_path / "a.mcap").returncode == 0
    head, rows = table(tmp_path / "a" / "world_stats.csv")
    assert "iterations" in head
    assert rows


def test_a_video_of_the_whole_world(tmp_path):
    import av

    world, video = tmp_path / "a.world", tmp_path / "view.mp4"
    world.write_text(LIGHT)
    words = ("-n", "--steps", 10, "-d", -1, "-s", SERVER_ID, "--record", f"view={video}", world)
    assert run_command("gazebo", *words).returncode == 0
    with av.open(str(video)) as file:
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    assert len(frames) == 5
    assert frames[0].shape == (480, 640, 3)
    image = frames[-1].astype(int)
    assert ((image[..., 0] > 100) & (image[..., 1] < 60)).sum() > 200  # the robot is red


@pytest.mark.parametrize("text", [LIGHT, SDF])
def test_an_overview_shows_what_moves(text):
    with libgz.World.from_string(text) as world:
        pose = overview(world)
        image = world.image(160, 120, pose)
    assert np.isfinite([*pose.pos, *pose.rot]).all()
    ground = image[0, 0].astype(int)
    assert (abs(image[30:90, 40:120].astype(int) - ground).sum(axis=2) > 60).sum() > 50
