"""A server's directory: its creation and removal, stale files, and files of other programs."""

import contextlib
import errno
import itertools
import os
import resource
import socket
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from descriptors import none_left
from ros_peers import wait_for
from served import serve

import libgz
from libgz.base.files import installed_worlds
from libgz.interfaces.catalog import new_interface
from libgz.interfaces.position import Position
from libgz.transport import control as control_module, timed_socket
from libgz.transport.control import Control, ask
from libgz.transport.paths import CONTROL_SOCKET, LOCK_FILE, server_directory
from libgz.transport.semaphores import CLIENTS, GZ_SEM_KEY, SemaphoreSet
from libgz.transport.server import Server, free_server_id


def test_directory_is_named_by_tmp_user_and_id(monkeypatch):
    monkeypatch.setenv("TMP", "/somewhere")
    monkeypatch.setenv("USER", "ahoward")
    assert server_directory(0) == "/somewhere/gazebo-ahoward-0"
    monkeypatch.delenv("USER")
    monkeypatch.delenv("TMP")
    assert server_directory(3) == "/tmp/gazebo-nobody-3"
    monkeypatch.setenv("USER", "")
    assert server_directory(3) == "/tmp/gazebo--3"
    monkeypatch.setenv("TMP", "/" + "x" * 130)
    with pytest.raises(libgz.ParameterError, match="longer than 127"):
        server_directory(0)


def test_modes_and_semaphores(server):
    serve(server)
    assert Path(server.path).stat().st_mode & 0o777 == 0o700
    assert (Path(server.path) / "position.robot1").stat().st_mode & 0o777 == 0o600
    lines = Path("/proc/sysvipc/sem").read_text().splitlines()
    fields = [line.split() for line in lines[1:] if int(line.split()[0]) == GZ_SEM_KEY + server.server_id]
    assert [(f[2], f[3]) for f in fields] == [("700", str(CLIENTS))]


def test_a_live_server_is_never_disturbed(server):
    interface = serve(server)
    for force in (False, True):
        with pytest.raises(
            libgz.ServerError, match=f"another server running with id {server.server_id} .pid {os.getpid()}"
        ):
            Server(server.server_id, force).start()
    interface.data.pos[0] = 1.0
    server.post()
    assert (Path(server.path) / "position.robot1").exists()


def test_stale_files_and_semaphores_are_removed_at_the_start(wire):
    script = (
        f"import os; from libgz.transport.server import Server; from libgz.interfaces.position import Position\n"
        f"s = Server({wire}); s.start(); p = Position(); p.create(s, 'old'); s.post(); os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", script], timeout=30).returncode == 9
    folder = Path(server_directory(wire))
    assert (folder / "position.old").exists()
    assert SemaphoreSet.attach(wire)
    server = Server(wire)
    server.start()
    assert sorted(p.name for p in folder.iterdir()) == [LOCK_FILE]
    server.stop()
    server.stop()
    assert not folder.exists()


def test_waits_for_a_dead_server_end_when_a_new_server_starts(wire):
    script = (
        f"import os; from libgz.transport.server import Server; from libgz.interfaces.sim import Sim\n"
        f"s = Server({wire}); s.start(); Sim().create(s, 'default'); s.post()\n"
        f"print('up', flush=True); input(); os._exit(9)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as first:
        assert first.stdout.readline() == "up\n"
        client = libgz.Client(wire)
        client.wait(timeout=5.0)
        first.communicate("\n", timeout=30)
    server = Server(wire)
    server.start()
    server.post()
    with pytest.raises(libgz.ServerGoneError):  # its files are stale
        client.wait(timeout=5.0)
    client.disconnect()
    server.stop()


def test_semaphores_of_a_live_server_of_another_kind_are_kept(wire):
    # It does not hold libgz's lock, but it posts to its semaphores.
    script = (
        f"import sys; from libgz.transport.semaphores import SemaphoreSet\n"
        f"s = SemaphoreSet.create({wire}); s.post(); print('up', flush=True); sys.stdin.read(); s.remove()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout.readline() == "up\n"
        with pytest.raises(libgz.ServerError, match="-f if you definitely want"):
            Server(wire).start()
        assert not Path(server_directory(wire)).exists()
        forced = Server(wire, force=True)
        forced.start()
        forced.stop()
        other.communicate("", timeout=30)


def test_links_in_a_shared_tmp_are_not_followed(wire, tmp_path):
    target = tmp_path / "target"
    target.mkdir()
    folder = Path(server_directory(wire))
    folder.symlink_to(target)
    with pytest.raises(libgz.ServerError, match="cannot use"):
        Server(wire).start()
    folder.unlink()
    victim = tmp_path / "victim"
    victim.write_text("precious")
    folder.mkdir(mode=0o755)
    (folder / "position.robot1").symlink_to(victim)
    server = Server(wire)
    server.start()
    assert folder.stat().st_mode & 0o777 == 0o700
    serve(server)
    server.stop()
    assert victim.read_text() == "precious"


def test_invalid_ids(server):
    for name, message in ((None, "is NULL"), ("a.b", "must not contain '.'"), ("a/b", "must not contain '/'")):
        with pytest.raises(libgz.InterfaceError, match=message):
            Position().create(server, name)
    empty = serve(server, name="")
    assert (Path(server.path) / "position.").exists()
    empty.destroy()


def test_the_first_of_two_with_one_id_is_served(server, caplog):
    first, second = serve(server), serve(server)
    assert "second position interface with id 'robot1'" in caplog.text
    second.data.pos[0] = 5.0
    assert first.data.pos[0] == 0.0
    second.destroy()
    assert (Path(server.path) / "position.robot1").exists()


def test_the_directory_is_removed_under_a_running_server(server, caplog):
    first = serve(server)
    for path in Path(server.path).iterdir():
        path.unlink()
    Path(server.path).rmdir()
    with first.locked() as data:
        data.pos[0] = 1.0
    serve(server, name="robot2")
    assert "was removed under the running server" in caplog.text
    assert (Path(server.path) / "position.robot2").exists()


def test_a_server_ends_where_a_folder_took_the_place_of_its_socket(tmp_path):
    control = Control(str(tmp_path))
    (tmp_path / CONTROL_SOCKET).unlink()
    (tmp_path / CONTROL_SOCKET).mkdir()
    control.close()


def test_control_takes_requests_again_when_there_are_descriptors_again(server, monkeypatch):
    tried = threading.Event()
    monkeypatch.setattr(control_module, "PAUSE", 0.01)
    monkeypatch.setattr(control_module.time, "sleep", lambda _: tried.set())
    control = Control(server.path)
    try:
        with socket.socket(socket.AF_UNIX) as waiting:
            waiting.connect(f"{server.path}/{CONTROL_SOCKET}")  # the thread waits for another one by now, or will
            with socket.socket(socket.AF_UNIX) as second, none_left():
                second.connect(f"{server.path}/{CONTROL_SOCKET}")
                assert tried.wait(20.0)
        answered = threading.Thread(target=ask, args=(server.server_id, "verb"))
        answered.start()
        wait_for(lambda: control.waiting)
        control.waiting.popleft().answer()
        answered.join()
    finally:
        control.close()


def test_control_serves_a_bounded_number_of_requests_at_a_time(server, monkeypatch):
    monkeypatch.setattr(control_module, "MOST_REQUESTS", 3)
    control = Control(server.path)
    before = threading.active_count()
    try:
        with contextlib.ExitStack() as stack:
            for _ in range(20):
                one = stack.enter_context(socket.socket(socket.AF_UNIX))
                one.connect(f"{server.path}/{CONTROL_SOCKET}")
                one.sendall(b"verb - 0\n")
            wait_for(lambda: len(control.waiting) == 3)
            assert threading.active_count() <= before + 3
            for _ in range(20):
                wait_for(lambda: control.waiting)
                control.waiting.popleft().answer()
    finally:
        control.close()


def served(control):
    """Whether a request is answered."""
    answered = threading.Thread(target=ask, args=(int(control._path.split("/")[-2].rsplit("-", 1)[1]), "verb"))
    answered.start()
    wait_for(lambda: control.waiting)
    control.waiting.popleft().answer()
    answered.join()
    return True


def test_a_request_that_comes_byte_by_byte_is_late_as_a_whole(server, monkeypatch):
    """However often a byte comes: here always before one has been waited for."""
    clock = itertools.count()
    monkeypatch.setattr(timed_socket.time, "monotonic", lambda: float(next(clock)))
    control = Control(server.path)
    try:
        with socket.socket(socket.AF_UNIX) as slow:
            slow.connect(f"{server.path}/{CONTROL_SOCKET}")
            slow.settimeout(20.0)
            slow.sendall(b"verb - 10000\n")
            with contextlib.suppress(OSError):  # once the connection is closed
                for _ in range(10_000):
                    slow.sendall(b"x")
                pytest.fail("all of it was taken")
        assert not control.waiting
    finally:
        control.close()


@pytest.mark.parametrize("length", [(1 << 28) + 1, 1 << 31, -1])
def test_a_request_of_more_than_the_bound_is_not_read(server, monkeypatch, length):
    monkeypatch.setattr(control_module, "PATIENCE", 1000.0)
    control = Control(server.path)
    try:
        with socket.socket(socket.AF_UNIX) as large:
            large.connect(f"{server.path}/{CONTROL_SOCKET}")
            large.settimeout(20.0)
            large.sendall(f"verb - {length}\n".encode())
            assert large.recv(1) == b""
        assert served(control)
    finally:
        control.close()


def test_control_serves_on_when_a_request_found_no_memory_or_no_thread(server, monkeypatch, caplog):
    monkeypatch.setattr(control_module, "MOST_REQUESTS", 1)
    monkeypatch.setattr(control_module, "PAUSE", 0.0)
    failures = [MemoryError, RuntimeError]
    real, thread = control_module._receive, threading.Thread

    def receive(connection, most):
        if MemoryError in failures and most == control_module.MOST:
            failures.remove(MemoryError)
            raise MemoryError
        return real(connection, most)

    class Threads(thread):
        def start(self):
            if RuntimeError in failures and self._target.__name__ == "_serve":
                failures.remove(RuntimeError)
                raise RuntimeError("can't start new thread")
            super().start()

    control = Control(server.path)
    monkeypatch.setattr(control_module, "_receive", receive)
    monkeypatch.setattr(threading, "Thread", Threads)
    try:
        for _ in range(2):
            with socket.socket(socket.AF_UNIX) as one:
                one.connect(f"{server.path}/{CONTROL_SOCKET}")
                one.settimeout(20.0)
                assert one.recv(1) == b""
        assert not failures
        assert served(control)
    finally:
        control.close()
    assert "no memory is left for a request" in caplog.text


def test_a_free_server_id(wire):
    number = free_server_id()
    with pytest.raises(FileNotFoundError):
        SemaphoreSet.attach(number)


def test_a_full_disk_is_reported_when_an_interface_is_created(server, monkeypatch):
    """Access to a page of a sparse mapped file raises SIGBUS if the disk is full."""

    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(libgz.InterfaceError, match=r"No space left on device \(position\.robot1\)"):
        serve(server)
    assert [path.name for path in Path(server.path).iterdir()] == [LOCK_FILE]


def test_the_limit_of_open_files_is_raised_for_many_interfaces(server, monkeypatch):
    def create(i):
        new_interface("power").create(server, f"robot{i}")

    new_interface("sim").create(server, "default")
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (100, hard))
    try:
        with libgz.Client(server.server_id, client_id=-1) as client:
            for i in range(30):
                create(i)
                client.power(f"robot{i}")
        assert 200 < resource.getrlimit(resource.RLIMIT_NOFILE)[0] < 700
        monkeypatch.setattr(resource, "setrlimit", lambda *_: None)
        with pytest.raises(libgz.InterfaceError, match=rf"Too many open files \(.*\); .* of {hard} that this process"):
            any(create(i) for i in range(30, 400))
        monkeypatch.undo()
        server.stop()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def test_blocks_of_interface_files_are_allocated(server):
    interface = serve(server)
    assert (Path(server.path) / "position.robot1").stat().st_blocks * 512 >= interface.size


def test_a_directory_that_cannot_be_written_is_reported(wire, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "pwrite", full)
    with pytest.raises(libgz.ServerError, match=r"cannot use .* as the server's directory: No space left on device"):
        Server(wire).start()
    assert not Path(server_directory(wire)).exists()


def test_a_forked_child_does_not_end_its_parents_server(wire):
    """In a separate process, because the process of the tests has threads."""
    program = f"""
import os, sys, libgz
world = libgz.World.from_file({str(installed_worlds() / "pioneer2at.world")!r}, server_id={wire})
with world:
    child = os.fork()
    if child == 0:
        sys.exit(0)
    print(os.waitpid(child, 0)[1], sorted(n for n in os.listdir(world.gz_server.path) if n[0] != "."))
    with libgz.Client({wire}) as client:
        world.step()
        print(client.wait(timeout=1.0))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("0 ['fiducial.laser1', 'gazebo.pid', 'laser.laser1', "), done.stderr
    assert done.stdout.endswith("True\n")


def test_a_server_is_stopped_when_its_program_ends(wire):
    program = f"from libgz.transport.server import Server\nServer({wire}).start()"
    assert subprocess.run([sys.executable, "-c", program], timeout=30).returncode == 0
    assert not Path(server_directory(wire)).exists()


def test_semaphores_that_were_removed_are_made_again(wire, caplog):
    """As `ipcrm` removes them, also while native code posts."""
    text = "<gz:world xmlns:gz='g' xmlns:model='m'><model:Pioneer2AT><id>r</id></model:Pioneer2AT></gz:world>"
    with libgz.World.from_string(text, server_id=wire) as world, libgz.Client(wire) as client:
        world.step(2)
        assert client.wait(timeout=1.0)
        for _ in range(3):
            SemaphoreSet.attach(wire).remove()
            with pytest.raises(libgz.ServerGoneError):
                client.wait(timeout=1.0)
            world.step(2)
            with libgz.Client(wire) as again:
                assert again.wait(timeout=1.0)
                assert not again.wait(timeout=0.0)
                world.step()
                assert again.wait(timeout=1.0)
        assert caplog.text.count("clients can connect again") == 1
    with pytest.raises(FileNotFoundError):
        SemaphoreSet.attach(wire)


def test_semaphores_of_another_server_are_left_alone(wire, caplog):
    server = Server(wire)
    server.start()
    SemaphoreSet.attach(wire).remove()
    other = SemaphoreSet.create(wire)
    server.post()
    server.post()
    assert caplog.text.count("new ones cannot be made") == 1
    server.stop()
    other.remove()  # it is still there
