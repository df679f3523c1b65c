"""gazebo starts a client where plugins for it are named; each of the two ends with the other."""

import os
import signal
import subprocess
import textwrap

import pytest
from commands import command_line
from gzserver_process import new_environment

from libgz.apps.gazebo import _is_classic

PATIENCE = 180.0  # [s]: a machine under load
MOST = 60000  # iterations of a server whose client does not come
EMPTY = "<sdf version='1.6'><world name='default'>{}</world></sdf>"
GUI = "<gui><plugin name='teller' filename='libteller.so'/></gui>"
PLUGINS = {
    "system": """
    class P(SystemPlugin):
        def Load(self, argc, argv):
            print("system Load", *argv)
            self.kept = Events.ConnectSigInt(lambda: print("system SigInt"))
    GZ_REGISTER_SYSTEM_PLUGIN(P)
    """,
    "teller": """
    class P(GUIPlugin):
        def Load(self, sdf):
            self.text = f"teller runs {gui.get_world()} {os.getpid()}"
            self.kept = Events.ConnectPreRender(self.OnPreRender)
        def OnPreRender(self):
            print(self.text)
            self.kept = None
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
    "closer": """
    class P(GUIPlugin):
        def Load(self, sdf):
            self.kept = Events.ConnectPreRender(lambda: gui.get_main_window().close())
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
    "crasher": """
    class P(GUIPlugin):
        def Load(self, sdf):
            os.kill(os.getpid(), signal.SIGKILL)
    GZ_REGISTER_GUI_PLUGIN(P)
    """,
    "sayer": """
    class P(WorldPlugin):
        def Load(self, world, sdf):
            self.kept = Events.ConnectSigInt(lambda: print("server SigInt"))
    GZ_REGISTER_WORLD_PLUGIN(P)
    """,
}
HEAD = """
import os, signal
from libgz.classic import *
from libgz.classic import gui
from libgz.classic.event import Events
"""


@pytest.fixture
def start(tmp_path):
    """Starts gazebo with a world that has this inside it."""
    for name, text in PLUGINS.items():
        (tmp_path / f"{name}.py").write_text(HEAD + textwrap.dedent(text))
    environment = {**new_environment(tmp_path), "PYTHONUNBUFFERED": "1"}
    started = []

    def begin(inside, *words, **variables):
        world = tmp_path / "w.world"
        world.write_text(EMPTY.format(inside + "<plugin name='sayer' filename='libsayer.so'/>"))
        process = subprocess.Popen(
            command_line("gazebo", world, "--view-port", "18080", "--iters", MOST, *words),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**environment, **variables},
        )
        started.append(process)
        return process

    yield begin
    for process in started:
        process.terminate()
        process.communicate(timeout=PATIENCE)


def alive(number):
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    return True


def test_plugins_of_options_and_world_run_in_a_client_that_ends_with_the_server(start, tmp_path):
    process = start(GUI, "-g", "libsystem.so", "--verbose", "--my-own", "5")
    said = []
    while not any(line.startswith("teller runs") for line in said):
        line = process.stdout.readline()
        assert line, process.communicate()
        said.append(line.strip())
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=PATIENCE)
    (loaded,) = (line for line in said if line.startswith("system Load"))
    words = loaded.split()
    assert words[2] == "gzclient"
    assert {"--gui-plugin=libsystem.so", "--view-port=18080", "--verbose", "--my-own", "5"} <= set(words)
    (shown,) = (line for line in said if line.startswith("teller runs"))
    assert shown.split()[2] == "default"
    assert process.returncode == 0, errors
    assert {"system SigInt", "server SigInt"} <= set(rest.splitlines())
    assert not alive(int(shown.split()[3]))
    assert "unrecognized" not in errors
    assert "has no effect" not in errors


@pytest.mark.parametrize("place", ["option", "gui.ini"])
def test_the_server_ends_with_its_client(start, tmp_path, place):
    if place == "option":
        process = start("", "--gui-client-plugin", "libcloser.so", "--verbose")
    else:
        (tmp_path / "my.ini").write_text("[overlay_plugins]\nfilenames=libcloser.so\n")
        process = start("", "--verbose", GAZEBO_GUI_INI_FILE=str(tmp_path / "my.ini"))
    out, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    assert "The client has ended; the server ends with it." in out
    assert "server SigInt" in out


def test_a_client_that_crashes_is_named(start):
    process = start("", "--gui-client-plugin", "libcrasher.so")
    errors = process.communicate(timeout=PATIENCE)[1]
    assert process.returncode == 0, errors
    assert "The client has ended with signal 9; the server ends with it." in errors


@pytest.mark.parametrize("words", [["--untrusted"], []])
def test_files_of_strangers_start_no_client(start, words):
    process = start(GUI, "-g", "libsystem.so", "--iters", "5", *words, **({} if words else {"LIBGZ_UNTRUSTED": "1"}))
    out, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    for name in ("libsystem.so", "libteller.so"):
        assert f"plugin '{name}' of the client is left out: files are untrusted" in errors
    assert "teller runs" not in out


def test_a_client_s_option_without_a_world_means_the_empty_one():
    for words in (["-g", "liba.so"], ["--gui-client-plugin=liba.so"], ["--gui-plugin", "liba.so"]):
        assert _is_classic(words)
    assert not _is_classic(["-u"])
