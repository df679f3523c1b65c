"""The commands, run as users run them."""

import argparse
import importlib.metadata
import os
import pty
import re
import signal
import subprocess
import sys
import time

import pytest
from commands import command_line, run_command as run, run_libgz, spawn_command

import libgz
from libgz.apps import doctor
from libgz.base.extras import install
from libgz.base.files import installed_worlds

WORLD = installed_worlds() / "pioneer2at.world"


def test_a_client_drives_the_robot_of_a_running_server(gazebo):
    server = gazebo(WORLD, "--rate", "10")
    with libgz.Client(server.id) as client:
        robot, sonar, laser = client.position("robot1"), client.sonar("robot1"), client.laser("laser1")
        robot.command(vx=0.3)
        end = time.monotonic() + 30
        while robot.pose[0] < 0.5 and time.monotonic() < end:
            assert client.wait(timeout=10.0)
        assert robot.pose[0] >= 0.5
        assert robot.vel_pos[0] == pytest.approx(0.3, rel=0.05)
        assert len(sonar.ranges) == 16
        assert len(laser.ranges) == 181
        assert client.sim().sim_time > 1.0
    code, out, err = server.stop()
    assert (code, out) == (0, "")
    assert "ending: SIGTERM" in err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_end_it_cleanly(gazebo, number):
    before = signal.signal(number, signal.SIG_DFL)  # under nohup a server ignores SIGHUP
    try:
        server = gazebo(WORLD)
    finally:
        signal.signal(number, before)
    assert server.stop(number)[0] == 0
    assert not server.directory.exists()


def test_pause_reset_and_save_over_the_wire(gazebo, tmp_path):
    path = tmp_path / "w.world"
    path.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'><model:GroundPlane/>"
        "<model:Pioneer2AT><id>r</id><xyz>1 0 0</xyz></model:Pioneer2AT></gz:world>"
    )
    server = gazebo(path, "--rate", "20")

    def wait_for(condition):
        end = time.monotonic() + 30
        while not condition():
            assert time.monotonic() < end
            client.wait(timeout=5.0)

    with libgz.Client(server.id) as client:
        sim, robot = client.sim(), client.position("r")
        robot.command(vx=0.4)
        wait_for(lambda: robot.pose[0] > 0.5)
        robot.command()
        sim.save()
        wait_for(lambda: not sim.data.save)
        sim.paused = True
        wait_for(lambda: sim.pause_time > 0.1)
        before = sim.sim_time
        client.wait(timeout=1.0)
        assert sim.sim_time == before
        sim.paused = False
        sim.reset()
        wait_for(lambda: not sim.data.reset)
    saved = path.read_text()
    assert float(saved.partition("<xyz>")[2].split()[0]) > 1.4


def test_a_server_announces_0x050_on_request(gazebo):
    server = gazebo(WORLD, "--wire-version", "0.5")
    with libgz.Client(server.id) as client:
        assert client.sim().data.head.version == 0x050
        assert client.position("robot1").data.head.version == 0x050


def test_a_second_server_on_one_id_is_refused(gazebo):
    server = gazebo(WORLD)
    second = run("gazebo", "-s", server.id, WORLD)
    assert second.returncode == 1
    assert f"another server running with id {server.id}" in second.stderr
    assert len(second.stderr.splitlines()) == 1
    assert server.process.poll() is None


def test_servers_run_side_by_side(gazebo):
    one, two = gazebo(WORLD), gazebo(WORLD)
    with libgz.Client(one.id) as a, libgz.Client(two.id) as b:
        assert a.wait(timeout=10.0)
        assert b.wait(timeout=10.0)


def test_a_killed_server_is_succeeded_without_force(gazebo):
    first = gazebo(WORLD)
    first.process.kill()
    first.process.wait()
    assert first.directory.exists()
    again = run("gazebo", "-s", first.id, "--steps", "5", "-n", WORLD)
    assert again.returncode == 0, again.stderr
    assert not first.directory.exists()


def test_steps_time_and_speed(wire):
    began = time.monotonic()
    assert run("gazebo", "-s", wire, "--steps", "500", "-n", WORLD).returncode == 0
    assert time.monotonic() - began < 9.0  # ten simulated seconds
    assert run("gazebo", "-s", wire, "-t", "0.3", WORLD).returncode == 0
    assert run("gazebo", "-s", wire, "-t", "-1", "--steps", "3", WORLD).returncode == 0  # -1 was "never"


def test_a_free_id_is_taken_and_printed(wire):
    done = run("gazebo", "-s", "auto", "--steps", "1", "-n", WORLD)
    assert done.stdout.startswith("server id ")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--fast", "x.world"], "unrecognized arguments: --fast"),
        ([], "the following arguments are required: worldfile"),
        (["-s", "minus", "x.world"], "invalid server id value: 'minus'"),
        (["-s", "-4", "x.world"], "-s"),
        (["-d", "10", "x.world"], "10 is not allowed; allowed are"),
        (["--rate", "nan", "x.world"], "invalid rate value"),
        (["-t", "nan", "x.world"], "invalid number of seconds value"),
        (["--seed", "-1", "x.world"], "--seed"),
        (["--steps", "-1", str(WORLD)], "--steps is -1"),
        (["--wire-version", "0.4", "x.world"], "'0.4' is not a wire version; allowed are 0x050, 0.5, 0x060"),
        (["/no/such.world"], "worldfile '/no/such.world' does not exist"),
        (["/tmp"], "worldfile '/tmp' is a directory"),
        ([""], "argument worldfile: the name is empty; gazebo -h"),
        (["/dev/null"], "worldfile '/dev/null' is not a plain file"),
        (["-l", "/no/such/dir/log", str(WORLD)], "cannot write log file"),
    ],
)
def test_a_wrong_command_line_is_one_sentence_and_code_2(arguments, sentence):
    done = run("gazebo", *arguments)
    assert done.returncode == 2
    assert sentence in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stdout == ""


def test_an_invalid_world_is_reported_with_code_1(wire, tmp_path):
    path = tmp_path / "bad.world"
    path.write_text(
        "<gz:world xmlns:gz='g' xmlns:model='m'>\n<model:SimpleSolid><mass>-1</mass></model:SimpleSolid></gz:world>"
    )
    done = run("gazebo", "-s", wire, path)
    assert done.returncode == 1
    assert f"error   : {path}:2: <mass>: '-1' is not allowed; mass [kg] must be above 0" in done.stderr
    assert "Traceback" not in done.stderr


def test_messages_go_to_the_log_file(wire, tmp_path):
    log = tmp_path / "log"
    done = run("gazebo", "-s", wire, "--steps", "1", "-n", "-l", log, "-d", "-1", WORLD)
    assert done.returncode == 0
    assert "loaded Pioneer2AT 'robot1'" in log.read_text()
    assert done.stderr == ""


def test_the_status_line_is_for_terminals_only(wire):
    parent, child = pty.openpty()
    command = command_line("gazebo", "-s", wire, "--steps", 50, WORLD)
    with subprocess.Popen(command, stdout=child, stderr=subprocess.DEVNULL) as process:
        os.close(child)
        seen = b""
        while True:
            try:
                data = os.read(parent, 4096)
            except OSError:
                break
            if not data:
                break
            seen += data
        assert process.wait(30) == 0
    os.close(parent)
    assert b"\rTime " in seen
    assert b" 1.000 0.000 [" in seen


def test_version_and_help():
    assert run("gazebo", "-v").stdout == f"gazebo (libgz) {libgz.__version__}\n"
    shown = run("gazebo", "-h").stdout
    assert "worldfile" in shown
    assert run_libgz("--version").stdout == f"libgz {libgz.__version__}\n"


def test_doctor():
    done = run_libgz("doctor")
    assert done.returncode == 0, done.stdout
    assert "ODE_double_precision" in done.stdout
    assert "_step.so" in done.stdout
    broken = spawn_command("libgz", "doctor", env={**os.environ, "LIBGZ_ODE": "libnothere.so"})
    assert broken.returncode == 1
    assert "apt-get install libode8" in broken.stdout


def test_doctor_looks_at_every_extra():
    declared = importlib.metadata.metadata("libgz").get_all("Provides-Extra")
    assert sorted([*doctor.EXTRAS, "dev", "docs"]) == sorted(declared)
    needed = {(name, package) for name, extra in doctor.EXTRAS.items() for package in extra.packages}
    requirements = [re.match(r"([\w-]+).*extra == .(\w+).", one) for one in importlib.metadata.requires("libgz")]
    assert needed == {(one[2], one[1]) for one in requirements if one and one[2] not in ("dev", "docs")}


@pytest.mark.parametrize(
    ("name", "package", "words"),
    [
        ("mesh", "trimesh", "no meshes and skins of more formats without trimesh; STL, OBJ and COLLADA "),
        ("video", "av", "no videos by --record without av; cameras, "),
        ("video", "imageio", "no videos by --record without imageio; cameras, "),
        ("plot", "matplotlib", "no plots by libgz plot without matplotlib; libgz echo and libgz export "),
    ],
)
def test_doctor_reports_missing_extras(monkeypatch, capsys, name, package, words):
    real = importlib.metadata.version

    def version(asked):
        if asked == package:
            raise importlib.metadata.PackageNotFoundError(asked)
        return real(asked) if asked in doctor.PACKAGES else "1.0"

    monkeypatch.setattr(importlib.metadata, "version", version)
    assert doctor.run(argparse.Namespace(json=False)) == 0
    lines = {line[8:].split()[0]: line for line in capsys.readouterr().out.splitlines()}
    assert lines[name].startswith(f"absent  {name:14}{words}")
    assert lines[name].endswith(f"; {install(name)}")
    for other in doctor.EXTRAS.keys() - {name}:
        extra = doctor.EXTRAS[other]
        assert lines[other] == f"ok      {other:14}{extra.gives}: " + ", ".join(f"{p} 1.0" for p in extra.packages)


def test_demo(wire):
    done = run_libgz("demo", "--seconds", "4", "--rate", "8")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert "battery [V]" in lines[2]
    assert len(lines) >= 12
    assert float(lines[-1].split()[1]) > 0.8


def test_misspelt_commands_and_options_are_corrected():
    done = run_libgz("chek", "w.world")
    assert (done.returncode, done.stdout) == (2, "")
    assert (
        done.stderr
        == "libgz: 'chek' is not a command; did you mean 'check' or 'schema'?; libgz -h lists what is allowed\n"
    )
    assert "there are check, clean" in run_libgz("xyzzy").stderr
    assert "unrecognized arguments: --strit; did you mean '--strict'" in run_libgz("check", "--strit", "w").stderr
    assert "'cap' is not allowed; allowed are " in run_libgz("picture", "--gl", "cap", "w.world").stderr


def test_help_is_a_command_too():
    everything = run_libgz("help")
    assert everything.returncode == 0
    assert everything.stdout == run_libgz("-h").stdout
    assert run_libgz("help", "check").stdout == run_libgz("check", "-h").stdout
    assert "no command, model, interface or class is called 'chek'" in run_libgz("help", "chek").stderr


def test_the_package_is_the_command():
    done = subprocess.run([sys.executable, "-m", "libgz", "worlds"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert done.stdout == run_libgz("worlds").stdout
