"""The locks of interfaces, and clients that truncate or remove files."""

import ctypes
import fcntl
import os
import random
import time
from pathlib import Path

from served import serve

import libgz
from libgz.interfaces.factory import Factory, FactoryData
from libgz.interfaces.joint import GAZEBO_JOINT_MAX_JOINTS, JointData, JointsData
from libgz.interfaces.position import Position, PositionData
from libgz.transport.layout import commands_of


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


def overwrite(robot, generator):
    os.pwrite(robot.descriptor, generator.randbytes(robot.size), 0)


def test_commands_beside_an_overwritten_head_are_restored(server):
    robot, generator = serve(server), random.Random(1)
    with robot.locked() as data:
        data.cmd_enable_motors, data.cmd_vel_pos[0], data.cmd_vel_rot[2] = 1, 0.3, -0.2
    for _ in range(100):
        overwrite(robot, generator)
        with robot.locked() as data:
            assert robot.intact()
            assert (data.cmd_enable_motors, *data.cmd_vel_pos, *data.cmd_vel_rot) == (1, 0.3, 0, 0, 0, 0, -0.2)


def test_commands_of_a_restored_state_are_kept(server):
    robot, generator = serve(server), random.Random(1)
    with robot.locked() as data:
        data.cmd_vel_pos[0] = 0.3
    state = robot.get_bytes()
    with robot.locked() as data:
        data.cmd_vel_pos[0] = 0.4
    robot.set_bytes(state)
    overwrite(robot, generator)
    with robot.locked() as data:
        assert data.cmd_vel_pos[0] == 0.3


def test_commands_stay_after_a_truncation(server):
    robot = serve(server)
    with robot.locked() as data:
        data.cmd_vel_pos[0] = 0.3
    os.truncate(Path(server.path) / "position.robot1", 0)
    with robot.locked() as data:
        assert data.cmd_vel_pos[0] == 0.3


def test_what_was_overwritten_without_the_lock_is_not_kept(server):
    robot, generator = serve(server), random.Random(1)
    with robot.locked() as data:
        data.cmd_vel_pos[0] = 0.3
    time.sleep(0.06)  # commands are kept again
    with robot.locked() as data:
        overwrite(robot, generator)
        assert not robot.intact()
    with robot.locked() as data:
        assert robot.intact()
        assert data.cmd_vel_pos[0] == 0.3


def test_requests_in_text_do_not_come_again(server):
    factory = serve(server, Factory, "f")
    with factory.locked() as data:
        data.string[:2] = b"<x"
    os.pwrite(factory.descriptor, b"x" * 200, 0)
    with factory.locked() as data:
        assert not any(data.string)


def test_where_clients_write():
    assert [(place.start, text) for place, text in commands_of(FactoryData)] == [(160, True)]
    assert [place for place, _ in commands_of(PositionData)] == [
        slice(PositionData.cmd_enable_motors.offset, PositionData.cmd_vel_rot.offset + 24)
    ]
    joint, first = ctypes.sizeof(JointData), JointsData.joints.offset + JointData.cmd_angle.offset
    assert [place for place, _ in commands_of(JointsData)] == [
        slice(first + i * joint, first + i * joint + 16) for i in range(GAZEBO_JOINT_MAX_JOINTS)
    ]


def test_a_removed_file_stays_mapped(server):
    robot = serve(server)
    (Path(server.path) / "position.robot1").unlink()
    with robot.locked() as data:
        data.pos[0] = 1.0
    robot.destroy()
