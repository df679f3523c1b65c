"""Clients that are broken, slow or hostile cost the others and the server nothing."""

import contextlib
import itertools
import random
import socket
import struct
import time

import pytest
from descriptors import none_left
from player_clients import ACK, NACK, Client1, Client2, free_port

from libgz.interfaces.catalog import new_interface
from libgz.player import connection, server as server_module
from libgz.player.configuration import read_configuration
from libgz.player.conversation import Conversation2
from libgz.player.drivers import RefusedError
from libgz.player.simulator import Simulator
from libgz.transport.server import Server

STAMPS = itertools.count(100)


def well(server, interfaces):
    """Whether a client is served, from the first byte to data and a command."""
    data = interfaces["position"].data
    data.time = speed = float(next(STAMPS))
    with Client2(server) as client:
        client.mode(1)
        assert client.subscribe("position2d")[0] == 1
        assert len(client.data("position2d")) == 52
        client.command("position2d", 1, struct.pack(">3dI", speed, 0.0, 0.0, 1))
        assert client.request("position2d", 1)[0] == ACK
        return data.cmd_vel_pos[0] == speed


def raw(server):
    return socket.create_connection(("127.0.0.1", server.ports[0]), timeout=5.0)


def turns(server, count=20):
    for _ in range(count):
        server.turn(0.002)


HEADER1 = struct.Struct(">2s3H6I")
HEADER2 = struct.Struct(">6IdII")
ATTACKS = {
    "nothing": b"",
    "half of the mark": b"X",
    "half of a header": b"Xx\0\3\0\1",
    "half of a packet": HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 100) + b"\0\5",
    "another protocol": b"GET / HTTP/1.1\r\nHost: here\r\n\r\n" * 3,
    "no size": HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 0) * 50,
    "the largest size": HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 0xFFFFFFFF) + b"z" * 5000,
    "another type": HEADER1.pack(b"Xx", 99, 1, 0, 0, 0, 0, 0, 0, 4) + b"zzzz",
    "a type that only servers send": HEADER1.pack(b"Xx", 4, 1, 0, 0, 0, 0, 0, 0, 4) + b"zzzz",
    "the largest size of 2": HEADER2.pack(0, 0, 1, 0, 3, 5, 0.0, 0, 0xFFFFFFFF),
    "a size to be skipped": HEADER2.pack(0, 0, 1, 0, 3, 5, 0.0, 0, 1 << 24) + b"z" * 9999,
    "no type of 2": HEADER2.pack(0, 0, 1, 0, 0, 5, 0.0, 0, 0),
    "no interface of 2": HEADER2.pack(0, 0, 1, 0, 3, 5, 0.0, 0, 0) + HEADER2.pack(0, 0, 1 << 20, 0, 3, 5, 0.0, 0, 0),
    "a count that is too large": HEADER2.pack(0, 0, 1, 0, 3, 3, 0.0, 0, 28)
    + struct.pack(">7I", 0, 0, 4, 0, 1, 1 << 31, 1 << 31),
    "two counts": HEADER2.pack(0, 0, 31, 0, 3, 1, 0.0, 0, 12) + struct.pack(">2I4s", 4, 5, b"box\0"),
}


def test_attacks_of_one_packet(serve, interfaces):
    server = serve()
    for name, attack in ATTACKS.items():
        with raw(server) as attacker:
            attacker.sendall(attack)
            turns(server, 3)
            assert well(server, interfaces), name
    turns(server)
    assert (server.connections, server.unsent) == (0, 0)


def test_random_bytes(serve, interfaces):
    server, rng = serve(), random.Random(7)
    for number in range(60):
        with raw(server) as attacker:
            start = (
                b"Xx\0\3\0\1\0\0",
                HEADER2.pack(0, 0, rng.choice((1, 4, 6, 31, 53)), 0, 3, rng.randrange(11), 0.0, 0, 64),
            )
            attacker.sendall(start[number % 2] + rng.randbytes(rng.randrange(2000)))
            turns(server, 2)
    assert well(server, interfaces)


def test_numbers_that_are_not_finite_move_nothing(serve, interfaces):
    server, data = serve(), interfaces["position"].data
    with Client2(server) as client:
        client.mode(1)
        client.subscribe("position2d")
        client.command("position2d", 1, struct.pack(">3dI", 0.25, 0.0, 0.0, 1))
        client.command("position2d", 1, struct.pack(">3dI", float("nan"), 0.0, 0.0, 1))
        assert client.request("position2d", 5, struct.pack(">3d", float("inf"), 0.0, 0.0))[0] == NACK
        assert data.cmd_vel_pos[0] == 0.25
        for number in (float("nan"), float("inf")):
            with pytest.raises(RefusedError, match=r"px is .*; it must be finite"):
                server._simulator.answer("set_pose3d", {"name": "tester", "px": number})


def test_a_client_that_never_reads(serve, interfaces, monkeypatch):
    """It is sent no more data when its memory is full, no answers either, and gets the newest data when it reads."""
    monkeypatch.setattr(connection, "MOST_UNSENT", 200_000)
    camera = interfaces["camera"]
    camera.data.width, camera.data.height, camera.data.image_size = 320, 240, 230_400
    server = serve()
    with Client2(server) as client:
        client.mode(1)
        client.subscribe("camera")
        for number in range(1, 200):
            camera.data.time = float(number)
            server._next_poll = 0.0
            server.turn()
        assert server.unsent < 500_000
        for _ in range(20_000):
            try:
                client.socket.send(HEADER2.pack(0, 0, 1, 0, 3, 1, 0.0, 0, 0) * 100)
            except BlockingIOError:
                break
            server.turn()
        assert server.unsent < 600_000
        assert well(server, interfaces)
        times = []
        while 199.0 not in times:
            client.data("camera")
            times.append(client.time)
        assert times == sorted(times)
    turns(server)
    assert server.unsent == 0


def test_answers_that_nobody_reads_are_bounded(serve, interfaces, monkeypatch):
    monkeypatch.setattr(connection, "MOST_UNSENT", 100_000)
    server = serve()
    request = HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 2) + b"\0\1"  # 1540 bytes for 34
    with socket.socket() as attacker:
        attacker.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        attacker.connect(("127.0.0.1", server.ports[0]))
        attacker.setblocking(False)
        most = 0
        for _ in range(100):
            with contextlib.suppress(BlockingIOError):
                attacker.send(request * 100)
            server.turn()
            most = max(most, server.unsent)
        assert 100_000 < most < 100_000 + 2 * 1600
        assert well(server, interfaces)


def test_more_connections_than_there_is_room_for(serve, interfaces, monkeypatch):
    monkeypatch.setattr(server_module, "MOST_CONNECTIONS", 20)
    server = serve()
    with Client1(server) as first:
        first.subscribe("position2d")
        silent = []
        for _ in range(100):
            silent.append(raw(server))
            server.turn(0.002)
        assert server.connections <= 20
        assert well(server, interfaces)
        assert first.request("position2d", b"\x01")[0] == ACK  # who has spoken stays
        for one in silent:
            one.close()
    turns(server)
    assert server.connections == 0


def test_without_descriptors_the_server_does_not_spin(serve, interfaces):
    server = serve()
    with socket.socket() as sock, none_left():
        sock.connect(("127.0.0.1", server.ports[0]))
        server.turn(0.1)
        assert not [key for key in server._selector.get_map().values() if key.fileobj in server._listeners]
        assert server.connections == 0
    end = time.monotonic() + 20.0
    while not server._selector.get_map().get(next(iter(server._listeners)).fileno()) and time.monotonic() < end:
        server.turn(0.01)
    assert well(server, interfaces)


def test_a_client_that_floods_leaves_turns_to_others(serve, interfaces):
    server = serve()
    with raw(server) as flood, Client2(server) as client:
        flood.setblocking(False)
        subscribe = HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 7) + struct.pack(">HHHB", 3, 4, 0, ord("a"))
        flood.send(subscribe + (HEADER1.pack(b"Xx", 2, 4, 0, 0, 0, 0, 0, 0, 26) + bytes(26)) * 1000)
        client.mode(1)  # within the turns that a client of the tests waits
        assert client.subscribe("position2d")[0] == 1
        assert server.connections == 2


def test_a_held_lock_delays_its_device_only(serve, interfaces, server):
    player, data = serve(), interfaces["position"].data
    data.time = interfaces["power"].data.time = 1.0
    with Client2(player) as client:
        client.mode(1)
        client.subscribe("position2d")
        client.subscribe("power")
        client.data("position2d")
        client.data("power")
        interfaces["position"].lock()
        client.command("position2d", 1, struct.pack(">3dI", 0.5, 0.0, 0.0, 1))
        interfaces["power"].data.time = data.time = 2.0
        client.data("power")
        assert data.cmd_vel_pos[0] == 0.0
        interfaces["position"].unlock()
        client.data("position2d")
        assert data.cmd_vel_pos[0] == 0.5


def test_the_simulation_comes_and_goes(wire, tmp_path, monkeypatch):
    monkeypatch.setattr("libgz.player.simulator.CHECK_PERIOD", 0.0)
    path = tmp_path / "robot.cfg"
    path.write_text('driver ( name "gz_position" provides ["position:0"] gz_id "robot1" )')

    def run(speed):
        gazebo = Server(wire)
        gazebo.start()
        robot, sim = new_interface("position"), new_interface("sim")
        robot.create(gazebo, "robot1")
        sim.create(gazebo, "default")
        robot.data.vel_pos[0], robot.data.time = speed, 1.0
        return gazebo

    configuration = read_configuration(path, free_port())
    with server_module.PlayerServer(configuration, Simulator(wire)) as server, Client1(server) as client:
        assert client.subscribe("position2d")[0] == "e"
        for speed in (250, 500):
            gazebo = run(speed / 1000)
            turns(server, 3)
            if speed == 250:
                assert client.subscribe("position2d")[0] == "a"
            assert struct.unpack(">6iB", client.data("position2d"))[3] == speed
            gazebo.stop()
            turns(server, 3)
        assert client.request("position2d", struct.pack(">2B", 2, 1))[0] == NACK


def test_a_model_that_is_deleted_and_inserted_again_is_driven(serve, server, interfaces, monkeypatch):
    monkeypatch.setattr("libgz.player.simulator.CHECK_PERIOD", 0.0)
    player = serve()
    with Client2(player) as client:
        client.mode(1)
        client.subscribe("position2d")
        interfaces["position"].destroy()
        client.command("position2d", 1, struct.pack(">3dI", 0.25, 0.0, 0.0, 1))  # of a model that is gone
        robot = new_interface("position")
        robot.create(server, "one", "Tester", 7)
        turns(player, 3)
        client.command("position2d", 1, struct.pack(">3dI", 0.5, 0.0, 0.0, 1))
        assert client.request("position2d", 1)[0] == ACK
        assert robot.data.cmd_vel_pos[0] == 0.5


def test_twenty_clients_get_every_sample(serve, interfaces):
    data, server = interfaces["position"].data, serve()
    clients = [(Client2 if number % 2 else Client1)(server) for number in range(20)]
    for client in clients:
        if isinstance(client, Client1):
            client.request("player", struct.pack(">HB", 5, 4))
        else:
            client.mode(1)
        client.subscribe("position2d")
    for number in range(1, 51):
        data.time = number * 0.1
        server._next_poll = 0.0
        server.turn()
    for client in clients:
        times = [0.0]
        while times[-1] < 5.0:
            client.data("position2d")
            times.append(round(client.time, 2))
        assert times[-50:] == [round(0.1 * number, 2) for number in range(1, 51)]
        client.socket.close()


def test_requests_that_waited_for_room_are_answered_when_the_client_reads(serve, interfaces, monkeypatch):
    monkeypatch.setattr(connection, "MOST_UNSENT", 10_000)
    monkeypatch.setattr(server_module, "KERNEL_BUFFER", 4096)
    server = serve()
    with Client1(server) as client:
        client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        client.socket.send((HEADER1.pack(b"Xx", 3, 1, 0, 0, 0, 0, 0, 0, 2) + b"\0\1") * 300)
        turns(server, 100)
        assert [client.answer()[0] for _ in range(300)] == [ACK] * 300


def test_a_client_whose_version_lacks_what_it_subscribed_to(serve, interfaces):
    server = serve()
    with Client2(server) as client:
        client.sequence = 5  # as of 2.0
        client.mode(1)
        assert client.subscribe("truth")
        assert client.subscribe("position2d")
        client.command("position2d", 1, struct.pack(">3dI", 0.5, 0.0, 0.0, 1))  # as long as that of 2.1
        interfaces["truth"].data.time = interfaces["position"].data.time = float(next(STAMPS))
        turns(server)
        assert client.request("player", 1)[0] == ACK
        assert interfaces["position"].data.cmd_vel_pos[0] == 0.5
    assert well(server, interfaces)


def test_what_fails_for_one_client_disconnects_it_alone(serve, interfaces, monkeypatch, caplog):
    server = serve()
    with Client2(server) as client, Client2(server) as other:
        client.mode(1)
        other.mode(1)
        client.subscribe("position2d")
        monkeypatch.setattr(Conversation2, "_packed", lambda *_: 1 / 0)
        interfaces["position"].data.time = float(next(STAMPS))
        assert client.closed()
        monkeypatch.undo()
        assert other.request("player", 5, struct.pack(">I", 1))[0] == ACK
    assert well(server, interfaces)
    assert "disconnected a client" in caplog.text
