"""A step that does not return: it is reported, and a second signal ends the process and leaves nothing behind."""

import os
import re
import select
import signal
import subprocess
import textwrap
import threading
import time
from pathlib import Path

import pytest
from gzserver_process import SERVER, new_environment

from libgz.base.errors import Interrupted
from libgz.simulation import watchdog
from libgz.simulation.watchdog import Watchdog

HEAD = "<gz:world xmlns:gz='g' xmlns:model='m' xmlns:param='p'>"
LOOP = """
import time
from libgz import GZ_REGISTER_PLUGIN, Body, Model

class Loop(Model):
    def Load(self, file, node):
        self.AddBody(Body(self.world), True)
    def Init(self, file, node):
        {init}
    def Update(self, step):
        print("looping", flush=True)
        {update}

GZ_REGISTER_PLUGIN("Loop", Loop)
"""
CLASSIC = """
from libgz.classic import *
from libgz.classic.event import Events

class Loop(WorldPlugin):
    def Load(self, world, sdf):
        {load}
        self.connection = Events.ConnectWorldUpdateBegin(self.OnUpdate)
    def OnUpdate(self, info):
        print("looping", flush=True)
        while True:
            pass

GZ_REGISTER_WORLD_PLUGIN(Loop)
"""
SOLIDS = "".join(
    f"<model:SimpleSolid><id>s{i}</id><xyz>0 0 {0.5 + 0.001 * i}</xyz></model:SimpleSolid>" for i in range(48)
)
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143}


def loop_world(folder, update="while True: pass", init="pass"):
    (folder / "Loop.py").write_text(LOOP.format(update=update, init=init))
    path = folder / "loop.world"
    path.write_text(f"{HEAD}<model:Loop><id>looping1</id><plugin>Loop.py</plugin></model:Loop></gz:world>")
    return path


def read_until(stream, text, limit=30.0):
    """What a process prints, up to some text."""
    end, found = time.monotonic() + limit, b""
    while text.encode() not in found:
        assert time.monotonic() < end, f"no {text!r} in {found!r}"
        if select.select([stream], [], [], 0.1)[0]:
            got = os.read(stream.fileno(), 4096)
            assert got, f"no {text!r} in {found!r}"
            found += got
    return found.decode()


def pending(pid):
    """Whether signals wait for a process."""
    status = Path(f"/proc/{pid}/status").read_text()
    return any(int(mask, 16) for mask in re.findall(r"^(?:SigPnd|ShdPnd):\s*(\w+)", status, re.MULTILINE))


def end_by_two(process, first, second):
    """Send two signals; the first must not end the process, the second one soon. Returns the exit code."""
    process.send_signal(first)
    while pending(process.pid) and process.poll() is None:  # a second one of its kind would be none
        time.sleep(0.01)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.5)
    begin = time.monotonic()
    process.send_signal(second)
    process.wait(20)
    assert time.monotonic() - begin < 5.0  # 1 s is promised where the machine is not busy
    return process.returncode


@pytest.mark.parametrize(
    ("first", "second"),
    [(signal.SIGINT, signal.SIGINT), (signal.SIGTERM, signal.SIGTERM), (signal.SIGINT, signal.SIGTERM)],
)
def test_a_second_signal_ends_an_endless_update(gazebo, tmp_path, first, second):
    server = gazebo(loop_world(tmp_path), "-n")  # the fixture `wire` finds what is not removed
    read_until(server.process.stdout, "looping")
    assert end_by_two(server.process, first, second) == CODES[second]
    text = server.stop()[1:][1]
    assert "ended at once: second signal, " + second.name in text
    assert "not the server's" not in text
    assert "stale" not in text
    assert not server.directory.exists()


def test_a_second_signal_ends_an_endless_start(gazebo, tmp_path):
    path = loop_world(tmp_path, init="print('starting', flush=True)\n        while True: pass")
    server = gazebo(path, "-n", ready=False)
    read_until(server.process.stdout, "starting")
    assert end_by_two(server.process, signal.SIGTERM, signal.SIGTERM) == 143
    assert not server.directory.exists()


def test_a_second_signal_ends_a_long_physics_step(gazebo, tmp_path):
    path = tmp_path / "solids.world"
    loop = loop_world(tmp_path, update="pass").read_text().removeprefix(HEAD).removesuffix("</gz:world>")
    path.write_text(f"{HEAD}<model:GroundPlane/>{SOLIDS}{loop}</gz:world>")
    server = gazebo(path, "-n")
    read_until(server.process.stdout, "looping")  # its update is over, the step's physics take several seconds
    assert end_by_two(server.process, signal.SIGINT, signal.SIGINT) == 130
    assert not server.directory.exists()


@pytest.mark.parametrize(
    "load", ["pass", "print('looping', flush=True)\n        while True: pass"], ids=["callback", "Load"]
)
def test_a_second_signal_ends_an_endless_callback(tmp_path, load):
    (tmp_path / "Loop.py").write_text(CLASSIC.format(load=load))
    world = tmp_path / "w.world"
    world.write_text("<sdf version='1.6'><world name='default'><plugin name='l' filename='libLoop.so'/></world></sdf>")
    process = subprocess.Popen(
        [*SERVER, world], env=new_environment(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    read_until(process.stdout, "looping")
    assert end_by_two(process, signal.SIGINT, signal.SIGINT) == 130
    process.communicate()


@pytest.mark.parametrize("report", [False, pytest.param(True, marks=pytest.mark.trial)])
def test_a_second_signal_ends_native_code_that_keeps_the_interpreter_lock(gazebo, tmp_path, report):
    server = gazebo(loop_world(tmp_path, update="sum(range(10**12))"), "-n")
    read_until(server.process.stdout, "looping")
    if report:
        text = read_until(server.process.stderr, "in Update")
        assert "native code has kept Python's interpreter lock for 5 s" in text
        assert f'File "{tmp_path / "Loop.py"}", line 12' in text
    assert end_by_two(server.process, signal.SIGINT, signal.SIGTERM) == 143
    assert not server.directory.exists()


def test_nohup_keeps_a_server_running(gazebo, tmp_path):
    ignored = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        server = gazebo(loop_world(tmp_path, update="time.sleep(0.01)"), "-n")
    finally:
        signal.signal(signal.SIGHUP, ignored)
    server.process.send_signal(signal.SIGHUP)
    with pytest.raises(subprocess.TimeoutExpired):
        server.process.wait(0.5)
    assert server.stop()[0] == 0


def test_a_first_signal_ends_a_step_that_returns(gazebo, tmp_path):
    server = gazebo(loop_world(tmp_path, update="time.sleep(0.5)"), "-n")
    code, _, text = server.stop(signal.SIGINT)
    assert code == 0
    assert "ending: SIGINT" in text


def test_a_run_that_ends_after_the_second_signal_ends_as_usual(gazebo, tmp_path):
    server = gazebo(loop_world(tmp_path, update="time.sleep(0.01)"), "-n")
    server.process.send_signal(signal.SIGTERM)
    assert server.stop(signal.SIGINT)[0] == 0


def test_a_long_step_is_reported_once_by_name(gazebo, tmp_path):
    update = "time.sleep(self.naps.pop() if self.naps else 0.01)"
    server = gazebo(loop_world(tmp_path, update, init="self.naps = [6.5]"), "-n")
    text = read_until(server.process.stderr, "running is", 30)
    read_until(server.process.stdout, "looping\nlooping")  # the long step is over
    code, _, rest = server.stop(signal.SIGTERM)
    assert code == 0
    line = next(line for line in (text + rest).splitlines() if "running is" in line)
    place = f"{tmp_path / 'Loop.py'}:12"
    assert line.endswith(f"takes more than 5 s; running is Update of model 'looping1' ({place})")
    assert (text + rest).count("running is") == 1


def test_a_long_callback_is_reported_by_plugin(tmp_path):
    (tmp_path / "Loop.py").write_text(CLASSIC.format(load="pass"))
    world = tmp_path / "w.world"
    world.write_text(
        "<sdf version='1.6'><world name='default'><plugin name='looper' filename='libLoop.so'/></world></sdf>"
    )
    process = subprocess.Popen(
        [*SERVER, world], env=new_environment(tmp_path), stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    name = "running is a callback of event WorldUpdateBegin of plugin with name[looper] and filename[libLoop.so]"
    read_until(process.stderr, f"{name} ({tmp_path / 'Loop.py'}:1")
    assert end_by_two(process, signal.SIGINT, signal.SIGTERM) == 143
    process.communicate()


def test_a_load_that_ends_in_the_middle_is_closed_as_far_as_possible():
    class Incomplete:
        present_step = None

        def close(self):
            raise KeyError(-1)

    with Watchdog(lambda number: None, Incomplete()) as watchdog:
        with pytest.raises(KeyError):
            watchdog.close()
        with pytest.raises(Interrupted), watchdog.loading():
            signal.raise_signal(signal.SIGTERM)
        watchdog.close()


def test_signals_of_a_forked_child_are_its_own(gazebo, tmp_path):
    fork = textwrap.indent(
        textwrap.dedent("""
        import os, signal
        if not hasattr(self, "child"):
            self.child = os.fork()
            if self.child == 0:
                while True: time.sleep(0.01)
            time.sleep(0.2)
            for _ in range(3):
                os.kill(self.child, signal.SIGTERM)
                time.sleep(0.1)
            os.kill(self.child, signal.SIGKILL)
            os.waitpid(self.child, 0)
            print("forked", flush=True)
        """),
        8 * " ",
    ).strip()
    server = gazebo(loop_world(tmp_path, update=fork), "-n")
    read_until(server.process.stdout, "forked")
    with pytest.raises(subprocess.TimeoutExpired):
        server.process.wait(1.0)
    assert server.stop()[0] == 0


def test_a_thread_that_outlives_the_run_is_reported(monkeypatch, caplog):
    monkeypatch.setattr(watchdog, "LONG", 0.05)
    main_thread, stop = threading.main_thread, threading.Event()
    with Watchdog(lambda number: None):
        listener = threading.Thread(target=stop.wait, name="listener")
        listener.start()
        monkeypatch.setattr(threading, "main_thread", threading.Thread)  # one that does not run
    report = next(thread for thread in threading.enumerate() if thread.name == "end")
    report.join(10.0)
    monkeypatch.setattr(threading, "main_thread", main_thread)
    stop.set()
    listener.join()
    assert re.search(r"still waiting for thread 'listener' to end: \S+; a signal ends the process", caplog.text)


def test_what_a_start_waits_for_is_named(gazebo, tmp_path):
    path = loop_world(tmp_path, init="print('starting', flush=True)\n        while True: pass")
    server = gazebo(path, "-n", ready=False)
    read_until(server.process.stdout, "starting")
    server.process.send_signal(signal.SIGINT)
    read_until(server.process.stderr, f"for Init of model 'looping1' ({path.with_name('Loop.py')}:10) to end; a second")
    server.process.send_signal(signal.SIGTERM)
    assert server.process.wait(20.0) == 143
