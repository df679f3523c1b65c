"""The wire: layouts, clients, semaphores, locks, and clients that misbehave."""

import ctypes
import fcntl
import importlib
import json
import math
import os
import pkgutil
import signal
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from served import serve

import libgz
import libgz.interfaces
import libgz.interfaces.reference
from libgz.interfaces.gripper import GripperDataCvs
from libgz.interfaces.laser import Laser
from libgz.interfaces.position import Position
from libgz.interfaces.sim import Sim
from libgz.transport.interface import Interface
from libgz.transport.layout import Data, fields_of
from libgz.transport.semaphores import SemaphoreSet
from libgz.transport.server import LocalServer, Server

LAYOUT = json.loads((Path(__file__).parent / "data" / "libgazebo-layout.json").read_text())


def interface_kinds():
    kinds = []
    for module in pkgutil.iter_modules(libgz.interfaces.__path__):
        for value in vars(importlib.import_module(f"libgz.interfaces.{module.name}")).values():
            if isinstance(value, type) and issubclass(value, Interface) and value.__module__.endswith(module.name):
                kinds.append(value)
    return kinds


KINDS = interface_kinds()


# Layouts ---------------------------------------------------------------------------------------------------------


def check_struct(struct, expected):
    assert ctypes.sizeof(struct) == expected["size"]
    for name, (offset, size, _) in expected["fields"].items():
        field = getattr(struct, name)
        assert (field.offset, field.size) == (offset, size), name
    declared = {name for name, *_ in struct._fields_} | ({"head"} if issubclass(struct, Data) else set())
    assert declared == set(expected["fields"])


ELEMENTS = {
    "FiducialFid": "gz_fiducial_fid",
    "WifiLink": "gz_wifi_link",
    "JointData": "gz_joint_data",
    "ActarrayActuator": "gazebo_actarray_actuator",
}


def test_all_interfaces_of_the_old_library_are_declared():
    assert {kind.type for kind in KINDS} == set(LAYOUT["_files"])
    check_struct(GripperDataCvs, LAYOUT["gz_gripper_data_cvs"])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_structs_lie_as_they_did(kind):
    described = LAYOUT["_files"][kind.type]
    check_struct(kind.data_class, LAYOUT[described["struct"]])
    assert kind.has_post == described["post_function"]
    for field in fields_of(kind.data_class).values():
        if issubclass(field.ctype, ctypes.Structure):
            check_struct(field.ctype, LAYOUT[ELEMENTS[field.ctype.__name__]])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_structs_of_0x050_lie_as_they_did(kind):
    struct = LAYOUT["_files"][kind.type]["struct"]
    differs = LAYOUT["_versions"]["0x050"]["differs"]
    assert set(kind.older) == ({0x050} if struct in differs else set())
    if kind.older:
        check_struct(kind.older[0x050], differs[struct])


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.type)
def test_old_functions_exist_for_every_interface(kind):
    module = importlib.import_module(kind.__module__)
    for verb in ("alloc", "free", "create", "destroy", "open", "close", "lock", "unlock"):
        assert callable(getattr(module, f"gz_{kind.type}_{verb}"))
        assert getattr(libgz, f"gz_{kind.type}_{verb}") is not None
    assert hasattr(module, f"gz_{kind.type}_post") == kind.has_post


def test_the_head_is_filled_in(server):
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


def test_ids_larger_than_an_int_are_masked(server):
    interface = Position()
    interface.create(server, "a", "T", 0x7F00_9000_0001, 0)
    assert interface.data.head.model_id == -0x70000000 + 1


@pytest.mark.parametrize("version", [0x050, 0x060])
def test_both_versions_can_be_announced(wire, version):
    server = Server(wire, version=version)
    server.start()
    truth, camera = serve(server, libgz.Truth, "t"), serve(server, libgz.Camera, "c")
    serve(server, Sim, "default")
    sizes = {0x050: (264, 230576), 0x060: (280, 921776)}[version]
    for interface, size in ((truth, sizes[0]), (camera, sizes[1])):
        raw = (Path(server.path) / f"{interface.type}.{interface.id}").read_bytes()
        assert (len(raw), raw[:4], raw[8:16]) == (size, version.to_bytes(4, "little"), size.to_bytes(8, "little"))
    here = libgz.GzPose(libgz.GzVector(1, 2, 3), libgz.GzQuaternFromEuler(0.1, 0.2, 0.3))
    there = libgz.GzPose(libgz.GzVector(4, 5, 6), libgz.GzQuaternFromEuler(-0.1, 0.4, 2.3))
    with truth.locked():
        truth.publish(1.5, here)
        assert truth.take_move() is None
    if version == 0x050:
        assert truth.rot.tolist() == pytest.approx([0.1, 0.2, 0.3])
    with libgz.Client(wire) as client:
        seen = client.truth("t")
        assert tuple(seen.pose.pos) == (1, 2, 3)
        assert tuple(seen.pose.rot) == pytest.approx(tuple(here.rot), abs=1e-15)
        seen.move(there)
        assert client.camera("c").all_pixels.size == camera.all_pixels.size
    with truth.locked():
        asked = truth.take_move()
        assert tuple(asked.rot) == pytest.approx(tuple(there.rot), abs=1e-15)
        assert truth.take_move() is None
    server.stop()


def test_other_versions_are_refused():
    with pytest.raises(libgz.ParameterError, match="wire version is 0x070; allowed are 0x050, 0x060"):
        Server(version=0x070)
    with pytest.raises(libgz.ParameterError, match="wire version"):
        libgz.World(wire_version=5)


# Client ----------------------------------------------------------------------------------------------------------


def test_the_old_functions(server, caplog):
    robot = serve(server)
    client = libgz.gz_client_alloc()
    assert libgz.gz_client_query(client, server.server_id) == 0
    assert libgz.gz_client_connect(client, server.server_id) == 0
    position = libgz.gz_position_alloc()
    assert libgz.gz_position_open(position, client, "robot1") == 0
    assert libgz.gz_position_lock(position, 1) == 0
    position.data.cmd_vel_pos[0] = 0.2
    libgz.gz_position_unlock(position)
    assert robot.data.cmd_vel_pos[0] == 0.2
    assert libgz.gz_position_close(position) == 0
    assert libgz.gz_position_open(libgz.gz_position_alloc(), client, "nobody") == -1
    assert "nobody" in libgz.gz_error_str()
    assert "nobody" in caplog.text
    assert libgz.gz_client_connect_wait(client, server.server_id, 16) == -1
    assert libgz.gz_client_connect_wait(client, server.server_id + 1, 0) == -1
    assert "does not appear to be running" in libgz.gz_error_str()
    assert libgz.gz_client_query(client, server.server_id + 1) == 1
    assert libgz.gz_client_connect_wait(client, server.server_id, 3) == 0
    server.post()
    assert libgz.gz_client_wait(client) == 0
    assert libgz.gz_client_disconnect(client) == 0


def test_the_pythonic_client(server):
    robot = serve(server)
    serve(server, Sim, "default")
    robot.data.pos[0] = 1.5
    with libgz.Client(server.server_id) as client:
        view = client.position("robot1")
        assert client.position("robot1") is view
        assert isinstance(view.pos, np.ndarray)
        robot.data.pos[1] = 2.5
        assert view.pos.tolist() == [1.5, 2.5, 0.0]  # a view, not a copy
        view.command(vx=0.2, vyaw=0.1)
        assert robot.data.cmd_vel_rot[2] == 0.1
        view.cmd_vel_pos[0] = 9.0
        assert robot.data.cmd_vel_pos[0] == 9.0
        kept = view.pos
        assert client.interfaces() == [("position", "robot1"), ("sim", "default")]
    with pytest.raises(libgz.ClosedError):
        _ = view.data
    assert kept[0] == 1.5  # memory lives as long as a view of it does


def test_an_interface_that_was_made_anew_is_opened_anew(server):
    first = serve(server)
    serve(server, Sim, "default")
    with libgz.Client(server.server_id) as client:
        old = client.position("robot1")
        first.destroy()
        assert client.position("robot1") is old  # nothing better is there
        second = serve(server)
        new = client.position("robot1")
        new.command(vx=1.0)
        assert second.data.cmd_vel_pos[0] == 1.0
        assert old.cmd_vel_pos[0] == 0.0
        assert client.position("robot1") is new


def test_an_id_too_long_for_c_programs_is_told(server, caplog):
    room = 127 - len(f"{server.path}/position.")
    serve(server, name="a" * room)
    assert not caplog.records
    serve(server, name="b" * (room + 1))
    assert "C programs cannot open" in caplog.text


def test_a_client_without_a_server(wire):
    with pytest.raises(libgz.ServerError, match=f"server {wire} does not appear to be running"):
        libgz.Client(wire, timeout=0.05)


def test_an_interface_that_is_not_there_is_answered_with_its_neighbours(server):
    serve(server)
    serve(server, Sim, "default")
    with libgz.Client(server.server_id) as client:
        with pytest.raises(libgz.InterfaceError, match="its position interfaces are 'robot1'; did you mean 'robot1'"):
            client.position("robt1")
        with pytest.raises(libgz.InterfaceError, match="serves no laser interface"):
            client.laser("laser1")


def test_a_file_too_short_is_refused(server):
    serve(server, Sim, "default")
    (Path(server.path) / "laser.short").write_bytes(bytes(100))
    with libgz.Client(server.server_id) as client, pytest.raises(libgz.InterfaceError, match="expected file size"):
        client.laser("short")
    (Path(server.path) / "laser.old").write_bytes(bytes(Laser().size))
    with libgz.Client(server.server_id) as client, pytest.raises(libgz.InterfaceError, match="expected file size"):
        client.laser("old")


# Waiting ---------------------------------------------------------------------------------------------------------


def test_post_is_a_flag_for_each_client(server):
    one, two = (SemaphoreSet.attach(server.server_id) for _ in range(2))
    for _ in range(10):
        server.post()
    assert one.wait(0, 1.0)
    assert not one.wait(0, 0.0)  # ten posts wake once
    assert two.wait(1, 1.0)  # each client has its own flag
    assert not two.wait(1, 0.05)


def test_wait_sleeps_until_the_post(server):
    waiting = SemaphoreSet.attach(server.server_id)
    threading.Timer(0.1, server.post).start()
    begin = time.monotonic()
    assert waiting.wait(5, 10.0)
    assert 0.05 < time.monotonic() - begin < 5.0


def test_a_client_learns_that_the_server_ended(wire):
    server = Server(wire)
    server.start()
    serve(server, Sim, "default")
    client = libgz.Client(wire)
    threading.Timer(0.1, server.stop).start()
    with pytest.raises(libgz.ServerGoneError, match=f"server {wire} ended"):
        client.wait(timeout=10.0)
    client.disconnect()


def test_signals_do_not_end_a_wait(server):
    waiting = SemaphoreSet.attach(server.server_id)
    seen = []
    before = signal.signal(signal.SIGUSR1, lambda *_: seen.append(1))
    try:
        threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGUSR1)).start()
        threading.Timer(0.2, server.post).start()
        assert waiting.wait(2, 10.0)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert seen


@pytest.mark.parametrize("timeout", [-1, math.nan])
def test_timeouts_are_checked(server, timeout):
    with pytest.raises(libgz.ParameterError, match="timeout"):
        SemaphoreSet.attach(server.server_id).wait(0, timeout)


# Clients that misbehave ------------------------------------------------------------------------------------------


def test_a_held_lock_does_not_stop_the_server(server, caplog):
    robot = serve(server)
    descriptor = os.open(Path(server.path) / "position.robot1", os.O_RDWR)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    begin = time.monotonic()
    assert not robot.lock()
    first = time.monotonic() - begin
    assert not robot.lock()
    assert time.monotonic() - begin - first < first + 0.01  # it has learned: no waiting any more
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


def test_a_file_cut_short_is_mended(server, caplog):
    robot = serve(server)
    os.truncate(Path(server.path) / "position.robot1", 0)
    with robot.locked() as data:
        data.pos[0] = 1.0
        assert (data.head.version, data.head.size, data.head.model_type) == (0x060, 312, b"Tester")
    assert "cut position.robot1 short" in caplog.text
    assert (Path(server.path) / "position.robot1").stat().st_size == 312


def test_a_removed_file_goes_on_in_memory(server):
    robot = serve(server)
    (Path(server.path) / "position.robot1").unlink()
    with robot.locked() as data:
        data.pos[0] = 1.0
    robot.destroy()


def test_removed_semaphores_are_told_once(wire, caplog):
    server = Server(wire)
    server.start()
    SemaphoreSet.attach(wire).remove()
    server.post()
    server.post()
    assert caplog.text.count("semaphores of server") == 1
    server.stop()


# In process ------------------------------------------------------------------------------------------------------


def test_interfaces_without_a_wire():
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


def test_every_field_is_described():
    for kind in KINDS:
        for name, field in fields_of(kind.data_class).items():
            assert field.help, (kind.type, name)
            assert field.writer in ("S", "C", "S/C")


def test_view_docstrings_carry_units():
    assert Position.vel_pos.__doc__.startswith("velocity in the robot's frame, forward first [m/s], shape (3,)")


def test_the_reference_page_is_what_the_declarations_say():
    page = Path(__file__).parent.parent / "docs" / "interfaces.md"
    again = "run `python -m libgz.interfaces.reference > docs/interfaces.md`"
    assert page.read_text() == libgz.interfaces.reference.reference(), again
