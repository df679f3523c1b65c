"""How commands end after signals, with closed pipes and streams, and on full disks: one sentence at most."""

import argparse
import errno
import logging
import os
import re
import signal
import subprocess
import sys
import types

import pytest

import libgz
from libgz.apps import gazebo as command, libgz as toolbox, model, record
from libgz.apps.console import INTERRUPTED, LogFile, as_command
from libgz.base.errors import GazeboError, ParameterError
from libgz.base.files import installed_worlds
from libgz.transport import server

WORLD = installed_worlds() / "pioneer2at.world"
FULL = "No space left on device"


def words(module, *arguments):
    return [sys.executable, "-m", f"libgz.apps.{module}", *map(str, arguments)]


def by_shell(redirections, module, *arguments):
    """Run a command with redirections that `subprocess` does not know, such as closed streams."""
    line = ["sh", "-c", f'exec "$@" {redirections}', "sh", *words(module, *arguments)]
    return subprocess.run(line, capture_output=True, text=True, timeout=60)


@pytest.mark.parametrize("arguments", [["models"], ["schema", "--rng"], ["models", "SickLMS200"]])
def test_without_a_reader_a_command_ends_in_silence(arguments):
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(words("libgz", *arguments), stdout=writing, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(writing)
    assert (done.returncode, done.stderr) == (128 + signal.SIGPIPE, "")


@pytest.mark.parametrize("arguments", [["models"], ["schema", "--rng"], ["doctor"]])
def test_a_full_disk_is_one_sentence(arguments):
    done = by_shell(">/dev/full", "libgz", *arguments)
    assert done.returncode == 1
    assert done.stderr == f"libgz: its output: {FULL}\n"


def test_help_on_a_full_disk_is_one_sentence():
    done = by_shell(">/dev/full", "gzserver", "--help")
    assert (done.returncode, done.stderr) == (255, f"gzserver: its output: {FULL}\n")


@pytest.mark.parametrize("redirections", [">&-", "2>&-", "<&-", ">&- 2>&- <&-", "2>/dev/full"])
def test_servers_need_no_streams(wire, redirections):
    done = by_shell(redirections, "gazebo", "-n", "-s", wire, "--steps", "3", WORLD)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    if redirections in (">&- 2>&- <&-", "2>/dev/full"):  # the hardest
        assert by_shell(redirections, "gzserver", "--verbose", "--iters", "3").returncode == 0


def test_a_closed_stream_is_not_taken_for_a_file(wire):
    """The next file that is opened gets the lowest free number: what is printed would go into it."""
    look = "import os; from libgz.apps.console import as_command; as_command('x')(lambda _: 0)()"
    look += "; print(os.open('/dev/null', os.O_RDONLY) > 2, file=open('/dev/fd/2', 'w'))"
    done = subprocess.run(
        ["sh", "-c", 'exec "$@" >&- <&-', "sh", sys.executable, "-c", look], capture_output=True, text=True, timeout=60
    )
    assert done.stderr == "True\n"


def test_a_log_file_on_a_full_disk_is_reported_once(wire):
    done = subprocess.run(
        words("gazebo", "-n", "-s", wire, "--steps", "3", "-l", "/dev/full", WORLD),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0
    assert done.stderr == f"error   : log file /dev/full cannot be written any more: {FULL}\n"


def test_a_log_file_has_messages_that_are_no_unicode(tmp_path, capsys):
    file = LogFile(tmp_path / "log")
    file.emit(logging.makeLogRecord({"msg": os.fsdecode(b"caf\xe9.world")}))
    file.close()
    assert (tmp_path / "log").read_text() == "caf\\udce9.world\n"
    assert capsys.readouterr().err == ""


def test_a_log_file_stays_open_after_another_error(tmp_path, capsys):
    root = logging.getLogger("libgz")
    file = LogFile(tmp_path / "log")
    root.addHandler(file)
    try:
        raise TypeError("not a number")
    except TypeError:
        file.handleError(logging.makeLogRecord({"msg": "text"}))
    assert file in root.handlers
    file.close()
    assert "TypeError: not a number" in capsys.readouterr().err


def test_an_interrupt_is_an_exit_code():
    def main(_arguments):
        raise KeyboardInterrupt

    assert as_command("libgz")(main)() == INTERRUPTED == 130


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (OSError(errno.ENOSPC, FULL), f"gz: its output: {FULL}\n"),
        (OSError(errno.EACCES, "Permission denied", "a.txt"), "gz: a.txt: Permission denied\n"),
        (ConnectionRefusedError(errno.ECONNREFUSED, "refused"), f"gz: [Errno {errno.ECONNREFUSED}] refused\n"),
        (TimeoutError("too late"), "gz: too late\n"),
        (MemoryError(), "gz: there is not enough memory\n"),
    ],
)
def test_errors_of_the_system_are_one_sentence(capsys, error, sentence):
    def main(_arguments):
        raise error

    assert as_command("gz", failed=255)(main)() == 255
    assert capsys.readouterr().err == sentence


def test_an_interrupt_while_a_world_loads(wire, tmp_path):
    (tmp_path / "early.py").write_text(
        "import os, signal, libgz\n"
        "class Early(libgz.Model):\n"
        "    def Load(self, file, node):\n"
        "        os.kill(os.getpid(), signal.SIGINT)\n"
        "libgz.GZ_REGISTER_PLUGIN('Early', Early)\n"
    )
    path = tmp_path / "early.world"
    loaded = "<model:Early><plugin>early.py</plugin></model:Early>"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'>{loaded}</gz:world>")
    done = subprocess.run(words("gazebo", "-d", "0", "-s", wire, path), capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (130, "")


def test_a_terminated_demonstration_ends_its_server(wire):
    with subprocess.Popen(words("libgz", "demo", "--seconds", "1000"), stdout=subprocess.PIPE, text=True) as demo:
        line = demo.stdout.readline()
        assert re.match(r"server \d+ runs ", line)
        demo.terminate()
        assert demo.wait(30) == 128 + signal.SIGTERM
    # The fixture looks for what the server left.


def test_an_id_that_was_taken_while_the_world_loaded(gazebo, monkeypatch, capsys):
    taken = gazebo(WORLD)
    ids = iter([taken.id, taken.id + 1, taken.id + 1])
    monkeypatch.setattr(server, "free_server_id", lambda: next(ids))
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    assert command.main(["-s", "auto", "-n", "--steps", "1", str(WORLD)]) == 0
    assert capsys.readouterr().out == f"server id {taken.id + 1}\n"


def test_no_free_directory_ends_the_search(wire, monkeypatch, capsys):
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    monkeypatch.setenv("TMP", "/no/such/directory")
    assert command.main(["-s", "auto", "-n", "--steps", "1", str(WORLD)]) == 1
    err = capsys.readouterr().err
    assert err.startswith("error   : cannot use /no/such/directory/gazebo-tester-")
    assert len(err.splitlines()) == 1


def test_worlds_that_a_program_does_not_close(wire):
    program = f"import libgz; world = libgz.World.from_file({str(WORLD)!r}, server_id={wire}); world.step(2)"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
    # The fixture looks for what the server left.


def test_worlds_in_threads_of_their_own():
    """In a process of its own: worlds that meet in ODE end the process."""
    program = f"""
import concurrent.futures, libgz
def run(_):
    with libgz.World.from_file({str(WORLD)!r}) as world:
        world.interface("position", "robot1").command(vx=0.3, vyaw=0.2)
        world.step(150)
        return tuple(world.model("robot1").GetPose().pos)
alone = run(0)
with concurrent.futures.ThreadPoolExecutor(4) as threads:
    print(all(pose == alone for pose in threads.map(run, range(8))))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert (done.stdout, done.returncode) == ("True\n", 0), done.stderr


def test_a_video_on_a_full_disk(tmp_path):
    def fail(*_):
        raise EOFError("avcodec_send_frame()")

    video = record._Video(tmp_path / "a.mp4", 10.0)
    video.close()
    video._file = types.SimpleNamespace(close=fail)
    with pytest.raises(GazeboError, match=r"a\.mp4 cannot be written: avcodec_send_frame"):
        video.close()
    video.close()


def test_a_model_to_add_that_is_no_text(tmp_path):
    path = tmp_path / "model.sdf"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ParameterError, match=r"cannot be read from .*model\.sdf"):
        model._factory(
            None, argparse.Namespace(spawn_string=None, spawn_file=str(path), model_name="", arguments={}), None
        )


@pytest.mark.parametrize("text", ["<gz:world xmlns:gz='g'/>", "no XML", "<model name='m'/>"])
def test_a_model_to_add_that_is_no_sdf(tmp_path, text):
    path = tmp_path / "box.world"
    path.write_text(text)
    for given in ({"spawn_string": None, "spawn_file": str(path)}, {"spawn_string": text, "spawn_file": None}):
        with pytest.raises(ParameterError, match=r"is no model: its root must be <sdf version="):
            model._factory(None, argparse.Namespace(**given, model_name="", arguments={}), None)


def test_stepping_a_world_that_does_not_run_raises():
    world = libgz.World()
    with pytest.raises(libgz.ClosedError, match="Initialize"):
        world.step()
    world.Initialize()
    world.step()
    for seconds in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ParameterError, match=r"time to run \[s\]"):
            world.run(seconds)
    world.close()
    with pytest.raises(libgz.ClosedError, match="the world is closed"):
        world.step()


@pytest.mark.parametrize(
    "words", [["--size", "99999x99999"], ["--size", "0x1"], ["--pose", "nan 0 1 0 0 0"], ["--pose", "0 0 inf 0 0 0"]]
)
def test_views_that_cannot_be_rendered(capsys, words):
    with pytest.raises(SystemExit) as end:
        toolbox.main(["picture", str(WORLD), *words])
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith(f"libgz picture: argument {words[0]}: invalid ")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["model", "-m", "box", "-x", "nan"], "argument -x/--pose-x: invalid coordinate value: 'nan'; it must be a"),
        (["physics", "-g", "nan,0,0"], "argument -g/--gravity: 'nan,0,0' is not three finite numbers"),
        (["physics", "-g", "0 0 -inf"], "argument -g/--gravity: '0 0 -inf' is not three finite numbers"),
        (
            ["joint", "-m", "box", "-j", "j", "-f", "inf"],
            "argument -f/--force: invalid force value: 'inf'; it must be a",
        ),
        (["joint", "-m", "box", "-j", "j", "--pos-t", "nan"], "argument --pos-t: invalid target value: 'nan'"),
        (["demo", "--seconds=-1"], "argument --seconds: invalid number of seconds value: '-1'; it must be a number"),
        (["demo", "--rate", "nan"], "argument --rate: invalid rate value: 'nan'; it must be a finite number, at"),
    ],
)
def test_numbers_that_cannot_be_used(capsys, words, message):
    with pytest.raises(SystemExit) as end:
        toolbox.main(words)
    assert end.value.code == 2
    assert capsys.readouterr().err.startswith(f"libgz {words[0]}: {message}")


@pytest.mark.parametrize("words", [["models"], ["snapshot", "rewind", "1"], ["log"]])
def test_an_unknown_option_is_reported_by_its_subcommand(capsys, words):
    with pytest.raises(SystemExit) as end:
        toolbox.main([*words, "--nojson"])
    name = f"libgz {' '.join(word for word in words if word.isalpha())}"
    assert end.value.code == 2
    error = capsys.readouterr().err
    assert error.startswith(f"{name}: unrecognized arguments: --nojson")
    assert error.endswith(f"; {name} -h lists what is allowed\n")


def test_a_text_that_is_no_source_of_a_plugin(tmp_path, capsys):
    (tmp_path / "model.sdf").write_text("<sdf version='1.6'/>")
    assert toolbox.main(["cxx", "build", str(tmp_path / "model.sdf")]) == 1
    assert "model.sdf' is no C++ source: it ends with none of .cc, " in capsys.readouterr().err
