"""The commands for running SDF worlds, against a real gzserver: libgz model, joint, stats, world, physics."""

import contextlib
import json
import os
import re
import subprocess
import time
from pathlib import Path

import pytest
from commands import command_line, run_libgz
from master_uri import free_master_uri

from libgz.apps.libgz import main

ROBOTS = Path(__file__).parents[1] / "data" / "urdf"
WORLD = """
<sdf version='1.6'><world name='w'>
  <physics type='ode'><max_step_size>0.01</max_step_size><real_time_update_rate>100</real_time_update_rate></physics>
  <model name='box'><pose>1 2 3 0 0 0</pose><static>1</static>
    <link name='link'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link>
  </model>
  <model name='arm'>
    <link name='base'><pose>0 0 1 0 0 0</pose></link>
    <link name='rod'><pose>0 0 1 0 0 0</pose><gravity>0</gravity></link>
    <joint name='fix' type='fixed'><parent>world</parent><child>base</child></joint>
    <joint name='hinge' type='revolute'><parent>base</parent><child>rod</child>
      <axis><xyz>0 0 1</xyz><dynamics><damping>1</damping></dynamics></axis></joint>
  </model>
</world></sdf>
"""


@contextlib.contextmanager
def serve(folder):
    """(environment for clients, process) of a server that runs."""
    (folder / "w.world").write_text(WORLD)
    kept = {k: v for k, v in os.environ.items() if not k.startswith("GAZEBO")}
    env = {**kept, "HOME": str(folder), "GAZEBO_MASTER_URI": free_master_uri()}
    command = command_line("gzserver", "--verbose", folder / "w.world")
    with subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True) as server:
        while "Publicized" not in server.stdout.readline():
            assert server.poll() is None
        yield env, server
        server.terminate()
        assert server.wait(20) in (0, -9)


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """The environment of a server that runs, and of its clients."""
    with serve(tmp_path_factory.mktemp("server")) as (env, server):
        yield env
        assert server.poll() is None


@pytest.fixture
def libgz(place):
    def run(*words, code=0):
        done = run_libgz(*words, env=place)
        assert done.returncode == code, done.stderr
        return done.stderr if code else done.stdout

    return run


def eventually(condition):
    end = time.monotonic() + 20.0
    while not condition():
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.1)


def pose(libgz, name):
    return [float(word) for word in libgz("model", "-m", name, "-p").split()]


def test_a_model_is_shown_and_moved(libgz):
    assert pose(libgz, "box") == pytest.approx([1, 2, 3, 0, 0, 0])
    assert 'name: "box"' in libgz("model", "-m", "box", "-i")
    assert json.loads(libgz("model", "-m", "box", "-i", "--json"))["name"] == "box"
    shown = json.loads(libgz("model", "-m", "box", "-p", "--json"))
    assert shown == pytest.approx({"x": 1, "y": 2, "z": 3, "roll": 0, "pitch": 0, "yaw": 0})
    libgz("model", "-m", "box", "-x", "4", "-Y", "0.5")
    eventually(lambda: pose(libgz, "box") == pytest.approx([4, 2, 3, 0, 0, 0.5]))


def test_models_come_and_go(libgz, tmp_path):
    file = tmp_path / "new.sdf"
    file.write_text("<sdf version='1.6'><model name='x'><static>1</static><link name='l'/></model></sdf>")
    libgz("model", "-f", str(file), "-m", "guest", "-z", "2")
    eventually(lambda: "guest" in libgz("topic", "-r", "entity_list"))
    assert pose(libgz, "guest")[2] == pytest.approx(2.0)
    robot = ROBOTS / "robot_pack" / "urdf" / "mesh_bot.urdf"  # whose mesh lies in the package around it
    libgz("model", "-f", str(robot), "-m", "robot", "-x", "5")
    eventually(lambda: "robot" in libgz("topic", "-r", "entity_list"))
    assert pose(libgz, "robot")[0] == pytest.approx(5.0, abs=1e-3)
    libgz("model", "-m", "robot", "-d")
    libgz("model", "-m", "guest", "-d")
    assert "there is no 'guest'; there are box, arm" in libgz("model", "-m", "guest", "-p", code=1)


def test_a_joint_is_steered(libgz):
    assert libgz("joint", "-m", "arm", "-i").split() == ["fix", "hinge", "0.000000"]
    libgz("joint", "-m", "arm", "-j", "hinge", "--pos-t", "0.7", "--pos-p", "20", "--pos-d", "10")

    def arrived():
        return abs(float(libgz("joint", "-m", "arm", "-j", "hinge", "-i").split()[1]) - 0.7) < 0.05

    eventually(arrived)
    assert "has no joint 'hing'; it has fix, hinge; did you mean 'hinge'?" in libgz(
        "joint", "-m", "arm", "-j", "hing", "-f", "1", code=1
    )


def test_statistics_are_printed(libgz):
    lines = libgz("stats", "-d", "2").splitlines()
    assert len(lines) >= 2
    for line in lines:
        assert re.fullmatch(r"Factor\[\d+\.\d\d\] SimTime\[[\d.]+\] RealTime\[[\d.]+\] Paused\[F\]", line)
    [first, *_] = map(json.loads, libgz("stats", "-d", "1", "--json").splitlines())
    assert set(first) == {"factor", "sim_time", "real_time", "paused"}
    assert first["paused"] is False


def test_missing_arguments_are_reported(libgz):
    assert "no model is given" in libgz("model", "-i", code=1)
    assert "no action is given" in libgz("model", "-m", "box", code=1)
    assert "no action is given" in libgz("joint", "-m", "arm", "-j", "hinge", code=1)


def test_statistics_end_with_the_server(tmp_path, monkeypatch):
    monkeypatch.setenv("TMP", str(tmp_path))  # a server that is killed leaves its directory
    with (
        serve(tmp_path) as (env, server),
        subprocess.Popen(
            command_line("libgz", "stats"), env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as stats,
    ):
        assert stats.stdout.readline().startswith("Factor")
        server.kill()
        assert "the server has ended" in stats.communicate(timeout=30)[1]
        assert stats.returncode == 1


def test_a_world_is_paused_stepped_and_reset(libgz):
    def paused_at():
        found = json.loads(libgz("topic", "-e", "~/world_stats", "-n", "1", "--json"))
        return int(found["iterations"]) if found["paused"] else None

    assert libgz("world", "-p", "1") == ""
    eventually(lambda: paused_at() is not None)
    at = paused_at()
    libgz("world", "-m", "20")
    eventually(lambda: paused_at() == at + 20)
    libgz("world", "-r")
    eventually(lambda: paused_at() == 0)
    libgz("physics", "-g", "0,0,-3", "-s", "0.002", "-i", "70", "-u", "500", "-o", "default_physics")
    found = libgz("topic", "-r", "physics_info")
    assert "max_step_size: 0.002" in found
    assert "z: -3\n" in found
    assert dict(re.findall(r"^(iters|real_time_update_rate): (\d+)", found, re.MULTILINE)) == {
        "iters": "70",
        "real_time_update_rate": "500",
    }
    libgz("physics", "--gravity=0,0,-9.8", "-s", "0.01", "-i", "50", "-u", "100")
    libgz("world", "-p", "0")


def test_commands_for_worlds_without_an_action_or_with_wrong_numbers_are_errors(capsys):
    for words, code, message in (
        (["world"], 1, "no action is given; use -p 0, -p 1, -s, -m N, -r, -t or -o"),
        (["world", "-m", "0"], 1, "--multi-step is 0; it must be at least 1"),
        (["physics"], 1, "no parameter is given"),
        (["physics", "--step-size=-1"], 2, "argument -s/--step-size: invalid step size value: '-1'"),
        (["physics", "-u", "nan"], 2, "argument -u/--update-rate: invalid update rate value: 'nan'"),
        (["physics", "-i", "0"], 1, "--iters is 0; it must be at least 1"),
        (["physics", "-g", "1,2"], 2, "'1,2' is not three finite numbers, such as 0,0,-9.8"),
    ):
        try:
            found = main(words)
        except SystemExit as error:
            found = error.code
        assert found == code
        assert message in capsys.readouterr().err


def test_a_model_of_strangers_comes_without_its_plugins(place, libgz, tmp_path):
    plugin = tmp_path / "ran.py"
    plugin.write_text(f"open({str(tmp_path / 'ran')!r}, 'w')")
    code = f"<plugin name='p' filename='{plugin}'/>"
    text = "<sdf version='1.6'><model name='{}'><static>1</static><link name='l'>{}</link>{}</model></sdf>"
    inner, outer = tmp_path / "inner", tmp_path / "outer.sdf"
    inner.mkdir()
    (inner / "model.sdf").write_text(text.format("inner", "", code))
    (inner / "model.config").write_text("<model><name>inner</name><sdf version='1.6'>model.sdf</sdf></model>")
    sensor = f"<sensor name='s' type='imu'>{code}</sensor>"
    outer.write_text(text.format("outer", sensor, "<include><uri>model://inner</uri></include>"))
    env = {**place, "GAZEBO_MODEL_PATH": str(tmp_path)}
    for name, *given in (
        ("outer", "-f", outer),
        ("inner", "-f", "model://inner"),
        ("x", "-s", text.format("x", "", code)),
    ):
        done = run_libgz("model", "--untrusted", *given, env=env)
        assert done.returncode == 0, done.stderr
        assert done.stderr.count("is left out: files are untrusted") == (2 if name == "outer" else 1)
        eventually(lambda name=name: f'"{name}"' in libgz("topic", "-r", "entity_list"))
        assert not (tmp_path / "ran").exists()
        libgz("model", "-m", name, "-d")
    libgz("model", "-f", str(inner / "model.sdf"))
    eventually((tmp_path / "ran").exists)
    eventually(lambda: '"inner"' in libgz("topic", "-r", "entity_list"))
    libgz("model", "-m", "inner", "-d")
