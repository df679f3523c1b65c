"""`libgz snapshot` on running servers: save, restore, rewind, and what they say when they cannot."""

import os
import signal
import socket
import stat
import subprocess
import time
from pathlib import Path

import pytest
from commands import command_line, run_libgz
from gzserver_process import SERVER, new_environment

import libgz
from libgz.base.encoding import FORMAT
from libgz.base.files import installed_worlds
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld
from libgz.transport.paths import CONTROL_SOCKET, server_directory

WORLD = installed_worlds() / "segwayrmp.world"
OTHER = installed_worlds() / "pioneer2at.world"
HEAD = "<gz:world xmlns:gz='g' xmlns:model='m'>"
BOX = """<sdf version='1.6'><world name='default'><model name='box'><pose>0 0 9 0 0 0</pose><link name='link'>
<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link></model></world></sdf>"""


@pytest.fixture
def serve(wire):
    """Starts `gazebo` or `gzserver`, and waits until requests are taken."""
    running = []

    def start(command, **options):
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **options)
        running.append(process)
        end = time.monotonic() + 30
        while not answers(wire):
            assert process.poll() is None, process.communicate(timeout=5)
            assert time.monotonic() < end
            time.sleep(0.02)
        return process

    yield start
    for process in running:
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=20)


def answers(wire):
    """Whether a server takes requests."""
    with socket.socket(socket.AF_UNIX) as probe:
        return probe.connect_ex(f"{server_directory(wire)}/{CONTROL_SOCKET}") == 0


def gazebo(wire, *words):
    return command_line("gazebo", "-s", wire, *words)


def wait(client, sim_time):
    """Wait for a sim time [s]."""
    end = time.monotonic() + 30
    while client.sim().data.sim_time < sim_time:
        assert time.monotonic() < end
        time.sleep(0.01)


def pause(client):
    """Pause a server, and wait until its clock stands."""
    sim = client.sim()
    sim.data.pause, waited = 1, sim.data.pause_time
    end = time.monotonic() + 30
    while sim.data.pause_time <= waited:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_running_server_is_saved_restored_and_rewound(wire, serve, tmp_path):
    serve(gazebo(wire, "--rewind", 60, WORLD))
    control = Path(server_directory(wire)) / CONTROL_SOCKET
    assert stat.S_IMODE(control.stat().st_mode) == 0o600
    kept = tmp_path / "kept.state"
    with libgz.Client(wire, 0) as client:
        sim, robot = client.sim(), client.position("robot1")
        wait(client, 0.5)
        done = run_libgz("snapshot", "save", kept, "-s", wire)
        assert (done.returncode, done.stdout) == (0, f"saved {kept.stat().st_size} bytes to {kept}\n"), done.stderr
        saved_at = sim.data.sim_time
        robot.command(vx=0.5)
        wait(client, saved_at + 1.5)
        moved = robot.data.pos[0]
        done = run_libgz("snapshot", "restore", kept, "-s", wire)
        assert done.returncode == 0, done.stderr
        restored = float(done.stdout.split()[-2])
        assert 0.5 <= restored <= saved_at + 0.5
        assert robot.data.pos[0] < moved
        assert robot.data.cmd_vel_pos[0] == 0.0
        wait(client, restored + 1.0)
        pause(client)
        before = sim.data.sim_time
        done = run_libgz("snapshot", "rewind", "0.6", "-s", wire)
        assert done.returncode == 0, done.stderr
        assert restored - 0.6 < float(done.stdout.split()[-2]) <= before - 0.6
        done = run_libgz("snapshot", "rewind", "1000", "-s", wire)
        assert (done.returncode, done.stdout) == (1, "")
        assert "before the oldest state that was kept" in done.stderr
        pause(client)
        done = run_libgz("snapshot", "restore", kept, "-s", wire)
        assert done.returncode == 0, done.stderr  # also while it is paused
        assert "control" not in run_libgz("interfaces", "-s", wire).stdout


def test_what_cannot_be_done_is_one_sentence(wire, serve, tmp_path):
    done = run_libgz("snapshot", "save", tmp_path / "x", "-s", wire)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1)
    assert f"no server with id {wire} takes requests" in done.stderr
    server = serve(gazebo(wire, OTHER))
    with libgz.World.from_file(WORLD) as world:
        (tmp_path / "other").write_bytes(world.get_state())
    (tmp_path / "text").write_text("text")
    (tmp_path / "old").write_bytes(b"libgz state 1\nand more")
    (tmp_path / "truncated").write_bytes((tmp_path / "other").read_bytes()[:-9])
    with (tmp_path / "huge").open("wb") as huge:
        huge.write(FORMAT)
        huge.truncate(3 << 30)  # with holes, which take no space
    for words, message in (
        (("restore", tmp_path / "other"), "its file has another text"),
        (("restore", tmp_path / "text"), "is no state: it was not written by `libgz snapshot save`"),
        (("restore", tmp_path / "old"), "this state has format 1; this version of libgz has format 9"),
        (("restore", tmp_path / "truncated"), "the state is damaged"),
        (("restore", tmp_path / "huge"), "is larger than 256 MiB"),
        (("restore", "/dev/zero"), "it is a device, not a file"),
        (("restore", tmp_path / "absent"), "cannot read"),
        (("save", tmp_path), "cannot write"),
        (("rewind", "1"), "--rewind SEC"),
    ):
        done = run_libgz("snapshot", *words, "-s", wire)
        assert (done.returncode, done.stdout) == (1, ""), words
        assert message in done.stderr
        assert done.stderr.count("\n") == 1
    assert run_libgz("snapshot", "rewind", "-1", "-s", wire).returncode == 2
    directory = Path(server_directory(wire))
    for request in (b"\n", b"save\n", b"save - -5\n", b"save - 99999999999\n", b"dance - 0\n", b"\xff\xff", b"x" * 999):
        with socket.socket(socket.AF_UNIX) as hostile:
            hostile.connect(str(directory / CONTROL_SOCKET))
            hostile.sendall(request)
    assert run_libgz("snapshot", "save", tmp_path / "x", "-s", wire).returncode == 0
    assert server.poll() is None
    server.kill()
    server.wait()
    assert run_libgz("snapshot", "save", tmp_path / "x", "-s", wire).returncode == 1
    serve(gazebo(wire, OTHER))  # takes the stale directory
    assert run_libgz("snapshot", "save", tmp_path / "x", "-s", wire).returncode == 0


def test_gzserver_with_a_server_id(wire, serve, tmp_path):
    path = tmp_path / "box.world"
    path.write_text(BOX)
    environment = {**new_environment(tmp_path), "TMP": os.environ["TMP"]}
    serve([*SERVER, "--server-id", str(wire), "--rewind", "10", str(path)], env=environment)
    kept = tmp_path / "kept.state"
    assert run_libgz("snapshot", "save", kept, "-s", wire).returncode == 0
    with libgz.Client(wire, 0) as client:
        wait(client, client.sim().data.sim_time + 0.1)
    done = run_libgz("snapshot", "restore", kept, "-s", wire)
    assert done.returncode == 0, done.stderr
    with libgz.World.from_file(path) as world:
        world.set_state(kept.read_bytes())
        assert world.GetSimTime() <= float(done.stdout.split()[-2]) + 1e-6


ODD = """from libgz import GZ_REGISTER_PLUGIN, Body, Model
class Odd(Model):
    def Load(self, file, node):
        self.AddBody(Body(self.world, dummy=True), True)
    def SaveState(self):
        if self.world.paused:
            raise ValueError("odd")
        return 1
    def LoadState(self, state):
        pass
GZ_REGISTER_PLUGIN("Odd", Odd)
"""


@pytest.mark.parametrize("strict", [False, True])
def test_a_model_whose_state_cannot_be_saved_ends_a_strict_server_only(wire, serve, tmp_path, strict):
    (tmp_path / "Odd.py").write_text(ODD)
    path, kept = tmp_path / "odd.world", tmp_path / "kept.state"
    path.write_text(f"{HEAD}<model:Odd><plugin>Odd.py</plugin></model:Odd></gz:world>")
    server = serve(gazebo(wire, *["--strict"] * strict, path))
    assert run_libgz("snapshot", "save", kept, "-s", wire).returncode == 0
    with libgz.Client(wire, 0) as client:
        pause(client)
    done = run_libgz("snapshot", "save", tmp_path / "x", "-s", wire)
    assert (done.returncode, done.stderr.count("ValueError: odd"), (tmp_path / "x").exists()) == (1, 1, False)
    if not strict:
        assert run_libgz("snapshot", "restore", kept, "-s", wire).returncode == 0
        server.send_signal(signal.SIGTERM)
    server.wait(timeout=20)
    messages = server.stderr.read()
    assert server.returncode == (3 if strict else 0)
    assert messages.count("(Odd): its state cannot be saved:") == (2 if strict else 1)


def test_a_state_of_strangers_loads_no_plugin_into_a_server(wire, serve, tmp_path):
    plugin, world, state = tmp_path / "libran.py", tmp_path / "box.world", tmp_path / "a.state"
    head = "from libgz.classic import GZ_REGISTER_MODEL_PLUGIN, ModelPlugin\nclass Ran(ModelPlugin):\n    STATE = ()\n"
    rest = "    def Load(self, model, sdf): {}\nGZ_REGISTER_MODEL_PLUGIN(Ran)\n"
    plugin.write_text(head + rest.format("pass"))
    world.write_text(BOX)
    guest = f"<model name='guest'><link name='l'/><plugin name='p' filename='{plugin}'/></model>"
    with libgz.World.from_file(world) as here:
        here.attach_era()
        here.extension(SdfWorld).insert(SdfFile.from_string(f"<sdf version='1.6'>{guest}</sdf>"))
        here.Step()
        assert len(list(here.companions[0].plugins.running())) == 1
        state.write_bytes(here.get_state())
    plugin.write_text(head + rest.format(f"open({str(tmp_path / 'ran')!r}, 'w')"))
    serve(gazebo(wire, world))
    for words, env in ((("--untrusted",), {}), ((), {"LIBGZ_UNTRUSTED": "1"})):
        done = run_libgz("snapshot", "restore", *words, state, "-s", wire, env={**os.environ, **env})
        assert done.returncode == 1
        assert "Model plugin 'p' of guest of the state cannot be loaded again" in done.stderr
        assert not (tmp_path / "ran").exists()
    plain = tmp_path / "plain.state"
    assert run_libgz("snapshot", "save", plain, "-s", wire).returncode == 0
    assert run_libgz("snapshot", "restore", "--untrusted", plain, "-s", wire).returncode == 0
    done = run_libgz("snapshot", "restore", state, "-s", wire)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "ran").exists()
