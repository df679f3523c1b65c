"""The locks of interfaces, and clients that truncate or remove files."""

import fcntl
import os
import time
from pathlib import Path

from served import serve

import libgz
from libgz.interfaces.position import Position


def test_a_held_lock_does_not_stop_the_server(server, caplog):
    robot = serve(server)
    descriptor = os.open(Path(server.path) / "position.robot1", os.O_RDWR)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    begin = time.monotonic()
    assert not robot.lock()
    first = time.monotonic() - begin
    assert not robot.lock()
    assert time.monotonic() - begin - first < first + 0.01  # only the first attempt waits
    assert caplog.text.count("holds the lock of position.robot1") == 1
    fcntl.flock(descriptor, fcntl.LOCK_UN)
    assert robot.lock()
    robot.unlock()
    os.close(descriptor)


def test_a_lock_is_shared_with_other_descriptors(server):
    robot = serve(server)
    with robot.locked():
        client = libgz.gz_client_alloc()
        libgz.gz_client_connect(client, server.server_id)
        other = Position()
        other.open(client, "robot1")
        assert not other.lock(timeout=0.05)
    assert other.lock(timeout=0.05)
    other.unlock()
    client.disconnect()


def test_the_length_of_a_truncated_file_is_restored(server, caplog):
    robot = serve(server)
    os.truncate(Path(server.path) / "position.robot1", 0)
    with robot.locked() as data:
        data.pos[0] = 1.0
        assert (data.head.version, data.head.size, data.head.model_type) == (0x060, 312, b"Tester")
    assert "a client truncated position.robot1" in caplog.text
    assert (Path(server.path) / "position.robot1").stat().st_size == 312


def test_a_removed_file_stays_mapped(server):
    robot = serve(server)
    (Path(server.path) / "position.robot1").unlink()
    with robot.locked() as data:
        data.pos[0] = 1.0
    robot.destroy()
