"""Servers: the heads of their interfaces, wire versions, and servers without clients."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from served import serve

import libgz
from libgz.interfaces.position import Position
from libgz.transport import ending
from libgz.transport.semaphores import SemaphoreSet
from libgz.transport.server import LocalServer, Server, alive


def test_the_head_of_an_interface(server):
    interface = serve(server)
    head = interface.data.head
    assert (head.version, head.size, head.model_type, head.model_id, head.parent_model_id) == (
        0x060,
        312,
        b"Tester",
        7,
        3,
    )
    raw = (Path(server.path) / "position.robot1").read_bytes()
    assert len(raw) == 312
    assert raw[:4] == (0x060).to_bytes(4, "little")


def test_model_ids_larger_than_an_int_are_masked(server):
    interface = Position()
    interface.create(server, "a", "T", 0x7F00_9000_0001, 0)
    assert interface.data.head.model_id == -0x70000000 + 1


def test_unknown_versions_are_refused():
    with pytest.raises(libgz.ParameterError, match="wire version is 0x070; allowed are 0x050, 0x060"):
        Server(version=0x070)
    with pytest.raises(libgz.ParameterError, match="wire version"):
        libgz.World(wire_version=5)


def test_removed_semaphores_are_reported_once(wire, caplog):
    server = Server(wire)
    server.start()
    SemaphoreSet.attach(wire).remove()
    server.post()
    server.post()
    assert caplog.text.count("semaphores of server") == 1
    server.stop()


def test_a_local_server():
    server = LocalServer()
    robot = serve(server)
    robot.command(vx=0.5)
    assert robot.data.cmd_vel_pos[0] == 0.5
    assert robot.lock()
    robot.unlock()
    robot.post()
    assert server.interfaces == {("position", "robot1"): robot}
    server.stop()
    assert server.interfaces == {}


def test_a_running_server_is_not_started_again(server):
    serve(server)
    with pytest.raises(libgz.ServerError, match=f"another server running with id {server.server_id}"):
        server.start()
    assert libgz.gz_server_init(server, server.server_id, 1) == -1
    assert (Path(server.path) / "position.robot1").exists()
    assert libgz.Client.query(server.server_id)


def test_the_old_functions_of_servers(wire):
    server = libgz.gz_server_alloc()
    assert libgz.gz_server_init(server, wire, 0) == 0
    position = libgz.gz_position_alloc()
    assert libgz.gz_position_create(position, server, "robot1", "Tester", 7, 3) == 0
    assert libgz.gz_position_post(position) == 0
    assert SemaphoreSet.attach(wire).wait(0, 1.0)
    assert libgz.gz_position_destroy(position) == 0
    assert libgz.gz_server_fini(server) == 0
    assert not Path(server.path).exists()
    assert libgz.gz_server_init(server, wire, 0) == 0  # a stopped server can be started again
    assert libgz.gz_server_fini(server) == 0


def test_native_code_can_remove_what_is_left_until_nothing_is(wire, monkeypatch):
    """A second signal may end the process at any moment, as on a busy machine."""
    server, left = Server(wire), []
    server.start()

    def forget(path):
        with pytest.raises(FileNotFoundError):
            SemaphoreSet.attach(wire)
        left.append(Path(path).exists())

    monkeypatch.setattr(ending, "forget", forget)
    server.stop()
    assert left == [False]


def test_a_server_that_was_killed_holds_no_id_though_nobody_waits_for_it(wire):
    code = f"from libgz.transport.semaphores import SemaphoreSet; SemaphoreSet.create({wire}).post()"
    with subprocess.Popen([sys.executable, "-c", code]) as ended:
        os.waitid(os.P_PID, ended.pid, os.WEXITED | os.WNOWAIT)  # nobody waits for it yet
        assert SemaphoreSet.attach(wire).last_poster() == ended.pid
        assert not alive(ended.pid)
        server = Server(wire)
        server.start()
        server.stop()
