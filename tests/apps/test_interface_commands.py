"""The commands libgz interfaces, echo, set and clean."""

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

import libgz
from libgz.apps import clean, libgz as toolbox
from libgz.base.files import installed_worlds
from libgz.interfaces.catalog import new_interface
from libgz.transport import stale_files
from libgz.transport.paths import LOCK_FILE, server_directory
from libgz.transport.semaphores import SemaphoreSet

WORLD = installed_worlds() / "pioneer2at.world"


def command(capsys, *words):
    """(exit code, stdout, stderr) of `libgz ...` in this process."""
    try:
        code = toolbox.main([str(word) for word in words])
    except SystemExit as end:
        code = end.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.fixture
def server(server):
    """A server with one interface of each kind that the tests need."""
    for kind, name in (
        ("position", "robot1"),
        ("laser", "laser1"),
        ("joint", "arm"),
        ("factory", "f"),
        ("sim", "default"),
    ):
        new_interface(kind).create(server, name, "Tester", 7)
    return server


def served(server, kind, name):
    return server.interfaces[kind, name].data


# interfaces ------------------------------------------------------------------------------------------------------


def test_interfaces_are_listed(capsys, server):
    (Path(server.path) / "strange.thing").write_bytes(b"")
    code, out, _ = command(capsys, "interfaces", "-s", server.server_id)
    assert code == 0
    lines = [line.split() for line in out.splitlines()]
    assert [line[0] for line in lines] == [
        "factory.f",
        "joint.arm",
        "laser.laser1",
        "position.robot1",
        "sim.default",
        "strange.thing",
    ]
    assert lines[3][1] == "Tester"
    assert "there is no interface type 'strange'" in out
    rows = json.loads(command(capsys, "interfaces", "--json", "-s", server.server_id)[1])
    assert (rows[3]["type"], rows[3]["id"], rows[3]["version"]) == ("position", "robot1", 0x060)
    (Path(server.path) / "strange.thing").unlink()


def test_texts_of_other_processes_command_no_terminal(capsys, server):
    served(server, "position", "robot1").head.model_type = b"\x1b[2J\nposition.none"
    new_interface("wifi").create(server, "w", "Tester", 7)
    wifi = served(server, "wifi", "w")
    wifi.link_count, wifi.links[0].ip = 1, b"\x1b[2J\n"
    assert r"\x1b[2J\nposition.none" in command(capsys, "interfaces", "-s", server.server_id)[1]
    assert r"\x1b[2J\n" in command(capsys, "echo", "-s", server.server_id, "wifi.w", "--once")[1]


def test_a_missing_server_is_reported(capsys, wire):
    for words in (["interfaces"], ["echo", "sim", "--once"], ["set", "sim", "pause=1"]):
        code, out, err = command(capsys, *words, "-s", wire)
        assert (code, out) == (1, "")
        assert f"server {wire} does not appear to be running" in err


# echo ------------------------------------------------------------------------------------------------------------


def test_echo_prints_a_sample(capsys, server):
    data = served(server, "position", "robot1")
    data.pos[:] = (1.5, -2.25, 0)
    code, out, _ = command(capsys, "echo", "position.robot1", "--once", "-s", server.server_id)
    assert code == 0
    assert "pos (1.5 -2.25 0)" in out
    assert len(out.splitlines()) == 1
    out = command(capsys, "echo", "position.robot1", "pos[1]", "--once", "-s", server.server_id)[1]
    assert out == "pos[1] -2.25\n"


def test_echo_in_json(capsys, server):
    laser, arm = served(server, "laser", "laser1"), served(server, "joint", "arm")
    laser.range_count, laser.ranges[1], laser.max_range = 3, 4.5, math.inf
    arm.joint_count, arm.joints[1].angle = 2, 0.5
    out = command(capsys, "echo", "laser.laser1", "--json", "--once", "-s", server.server_id)[1]
    values = json.loads(out)
    assert values["ranges"] == [0.0, 4.5, 0.0]
    assert values["max_range"] is None
    values = json.loads(command(capsys, "echo", "joint.arm", "--json", "--once", "-s", server.server_id)[1])
    assert [joint["angle"] for joint in values["joints"]] == [0.0, 0.5]
    out = command(capsys, "echo", "joint.arm", "joints[1].angle", "--json", "--once", "-s", server.server_id)[1]
    assert json.loads(out) == {"joints[1].angle": 0.5}


def test_counts_are_clamped(capsys, server):
    laser = served(server, "laser", "laser1")
    for count in (-5, 1 << 30):
        laser.range_count = count
        assert command(capsys, "echo", "laser.laser1", "--json", "--once", "-s", server.server_id)[0] == 0


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["positron.robot1"], "there is no interface type 'positron'"),
        (["position.robot2"], "its position interfaces are 'robot1'; did you mean 'robot1'"),
        (["position.robot1", "poss"], "position.robot1 has no field 'poss'; it has time, pos,"),
        (["position.robot1", "pos[3]"], "there is no 'pos[3]'; the field is pos[3]"),
        (["joint.arm", "joints[0].ankle"], "joints has no member 'ankle'"),
        (["position.robot1", "--rate", "0"], "--rate is 0"),
        (["position.robot1", "--count", "0"], "--count is 0"),
        (["position"], "'position' has no id; write TYPE.ID; its position interfaces are 'robot1'"),
        (["position.robot1", "pos", "--plot", "x.png"], "--plot needs a duration"),
        (["position.robot1", "--plot", "x.png"], "--plot needs a field"),
    ],
)
def test_errors_of_echo(capsys, server, words, sentence):
    more = [] if "--plot" in words and "pos" in words else ["--seconds", "0.1"]
    code, out, err = command(capsys, "echo", "-s", server.server_id, *words, *more)
    assert (code, out) == (1, "")
    assert sentence in err


@pytest.mark.parametrize("seconds", ["nan", "inf", "-1"])
def test_invalid_durations_of_echo(capsys, server, seconds):
    code, out, err = command(capsys, "echo", "-s", server.server_id, "position.robot1", "--seconds", seconds)
    assert (code, out) == (1, "")
    assert f"--seconds is {seconds}; it must be finite and not negative" in err


def test_only_required_arguments_are_reported_as_missing(capsys):
    code, _, err = command(capsys, "echo")
    assert code == 2
    assert "the following arguments are required: TYPE.ID;" in err


def test_echo_follows_a_running_robot(capsys, gazebo, tmp_path):
    server = gazebo(WORLD, "--rate", "10")
    assert command(capsys, "set", "position.robot1", "cmd_vel_pos=0.3", "-s", server.id)[0] == 0
    words = ["echo", "position.robot1", "--json", "--count", "5", "--rate", "100", "-s", server.id]
    lines = [json.loads(line) for line in command(capsys, *words)[1].splitlines()]
    times = [line["time"] for line in lines]
    assert len(times) == 5
    assert times == sorted(set(times))
    assert lines[-1]["cmd_vel_pos"] == [0.3, 0.0, 0.0]
    code, out, _ = command(capsys, "echo", "sim", "--seconds", "0.2", "-s", server.id)
    assert code == 0
    assert out.splitlines()


def test_echo_plots(capsys, gazebo, tmp_path):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    server = gazebo(WORLD, "--rate", "10")
    command(capsys, "set", "position.robot1", "cmd_vel_pos=0.3", "cmd_vel_rot[2]=0.4", "-s", server.id)
    path = tmp_path / "path.png"
    words = [
        "echo",
        "position.robot1",
        "pos",
        "rot[2]",
        "--count",
        "8",
        "--rate",
        "50",
        "--plot",
        path,
        "-s",
        server.id,
    ]
    code, out, err = command(capsys, *words)
    assert (code, out) == (0, f"8 samples plotted to {path}; `libgz plot` has more\n"), err
    assert path.read_bytes().startswith(b"\x89PNG")
    words[-4:-2] = ["--plot", "/no/such/place.png"]
    assert "cannot be written to '/no/such/place.png'" in command(capsys, *words)[2]


def test_a_missing_matplotlib_is_reported(server):
    code = "import sys; sys.modules['matplotlib'] = None; from libgz.apps.libgz import main; sys.exit(main())"
    words = ["echo", "position.robot1", "pos", "--once", "--plot", "x.png", "-s", str(server.server_id)]
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, timeout=30, check=False)
    assert done.returncode == 1
    assert "pip install 'matplotlib" in done.stderr


# set -------------------------------------------------------------------------------------------------------------


def test_set_writes_fields(capsys, server):
    words = ["cmd_vel_pos=0.3,0.1", "cmd_vel_rot[2]=-0.5", "cmd_enable_motors=1"]
    assert command(capsys, "set", "position.robot1", *words, "-s", server.server_id) == (0, "", "")
    data = served(server, "position", "robot1")
    assert (list(data.cmd_vel_pos), data.cmd_vel_rot[2], data.cmd_enable_motors) == ([0.3, 0.1, 0.0], -0.5, 1)
    assert command(capsys, "set", "joint.arm", "joints[3].cmd_angle=1.5", "-s", server.server_id)[0] == 0
    assert served(server, "joint", "arm").joints[3].cmd_angle == 1.5
    assert command(capsys, "set", "sim", "pause=1", "-s", server.server_id)[0] == 0
    assert served(server, "sim", "default").pause == 1
    assert command(capsys, "set", "factory.f", "string=<delete>r</delete>", "-s", server.server_id)[0] == 0
    assert bytes(served(server, "factory", "f").string[:18]) == b"<delete>r</delete>"


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["position.robot1", "cmd_vel_pos"], "is not an assignment"),
        (["position.robot1", "pos=1"], "pos is written by the server; clients write cmd_enable_motors, cmd_vel_pos"),
        (["position.robot1", "cmd_vel_pos=1,2,3,4"], "takes 3 numbers; 4 are given"),
        (["position.robot1", "cmd_vel_pos[0]=1,2"], "takes 1 number; 2 are given"),
        (["position.robot1", "cmd_vel_pos=fast"], "'fast' is not a number"),
        (["position.robot1", "cmd_enable_motors=0.5"], "'0.5' is not a whole number"),
        (["position.robot1", "cmd_enable_motors=99999999999"], "does not fit in cmd_enable_motors, which has 32 bits"),
        (["joint.arm", "joints[0]=1"], "joints holds records; name one of their numbers: joints[0].type"),
        (["joint.arm", "joints=1"], "joints"),
        (["factory.f", "string=" + "x" * 4096], "has 4096 bytes; 4095 are allowed"),
    ],
)
def test_set_with_an_error_writes_nothing(capsys, server, words, sentence):
    more = ["cmd_vel_rot=9"] if words[0].startswith("position") else []
    code, out, err = command(capsys, "set", words[0], *more, *words[1:], "-s", server.server_id)
    assert (code, out) == (1, "")
    assert sentence in err
    assert list(served(server, "position", "robot1").cmd_vel_rot) == [0.0, 0.0, 0.0]


def test_set_can_be_forced(capsys, server):
    assert command(capsys, "set", "position.robot1", "pos=1", "--force", "-s", server.server_id)[0] == 0
    assert served(server, "position", "robot1").pos[0] == 1.0


# clean -----------------------------------------------------------------------------------------------------------

DYING = """
import os
from libgz.transport.server import Server
from libgz.interfaces.position import Position
server = Server({0})
server.start()
Position().create(server, "old")
server.post()
os._exit(9)
"""


def test_clean_removes_stale_files_of_a_dead_server(capsys, wire):
    assert subprocess.run([sys.executable, "-c", DYING.format(wire)], timeout=30, check=False).returncode == 9
    folder = Path(server_directory(wire))
    code, out, _ = command(capsys, "clean", "-s", wire)
    assert code == 0
    assert [line.rpartition("/")[2] for line in out.splitlines()][1:] == ["position.old", LOCK_FILE, folder.name]
    assert not folder.exists()
    with pytest.raises(FileNotFoundError):
        SemaphoreSet.attach(wire)
    assert command(capsys, "clean", "-s", wire) == (0, "no stale files of dead servers\n", "")


def test_clean_finds_all_dead_servers(capsys, wire, monkeypatch):
    # Semaphores have one name space for the whole machine: do not touch those of other tests.
    monkeypatch.setattr(stale_files, "_SEMAPHORES", Path("/nonexistent"))
    for number in (wire, wire + 1):
        subprocess.run([sys.executable, "-c", DYING.format(number)], timeout=30, check=False)
    out = command(capsys, "clean")[1]
    assert out.count("removed semaphores") == 2
    assert not list(Path(os.environ["TMP"]).iterdir())


def test_orphaned_semaphores_are_found(wire):
    subprocess.run([sys.executable, "-c", DYING.format(wire)], timeout=30, check=False)
    assert wire in set(stale_files._semaphore_ids())
    for path in Path(server_directory(wire)).iterdir():
        path.unlink()
    Path(server_directory(wire)).rmdir()
    clean.run(type("Options", (), {"server_id": wire, "json": False}))


def test_clean_never_touches_a_live_server(capsys, server):
    before = sorted(Path(server.path).iterdir())
    assert "no stale files" in command(capsys, "clean", "-s", server.server_id)[1]
    assert sorted(Path(server.path).iterdir()) == before
    # Nor a server whose directory was removed: its semaphores show that it is alive.
    assert libgz.Client.query(server.server_id)


def test_clean_neither_follows_links_nor_removes_other_files(capsys, wire, tmp_path):
    victim = tmp_path / "position.precious"
    victim.write_text("precious")
    folder = Path(server_directory(wire))
    folder.symlink_to(tmp_path)
    assert "no stale files" in command(capsys, "clean", "-s", wire)[1]
    folder.unlink()
    folder.mkdir(mode=0o700)
    (folder / "position.link").symlink_to(victim)
    (folder / "notes").write_text("mine")
    command(capsys, "clean", "-s", wire)
    assert victim.read_text() == "precious"
    assert (folder / "notes").read_text() == "mine"
    for path in folder.iterdir():
        path.unlink()
    folder.rmdir()


def test_clean_refuses_a_negative_id(capsys):
    assert command(capsys, "clean", "-s", "-3")[0] != 0
