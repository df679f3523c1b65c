"""Player's protocols of 2.0 and 2.1: XDR, modes, and how the versions are told apart."""

import struct

import pytest
from player_clients import ACK, CODES, DATA, NACK, SYNCH, Client2, free_port

import libgz
from libgz.apps.world_control import WorldControl
from libgz.player.configuration import read_configuration
from libgz.player.server import PlayerServer
from libgz.player.simulator import Simulator
from libgz.transport.control import Control
from libgz.transport.paths import server_directory

PUSH, PULL = 1, 2


@pytest.fixture
def old(serve):
    """A client of 2.0, whose messages have any number."""
    with Client2(serve()) as client:
        client.sequence = 0xFFFFFFB8
        client.mode(PUSH)
        yield client


@pytest.fixture
def new(serve):
    """A client of 2.1, which chooses a mode first."""
    with Client2(serve()) as client:
        client.mode(PUSH)
        yield client


def array(payload, at, kind, size):
    """The elements of an array, which its count precedes twice, and where it ends."""
    count, again = struct.unpack_from(">2I", payload, at)
    assert count == again
    return struct.unpack_from(f">{count}{kind}", payload, at + 8), at + 8 + count * size


def test_lists(old, new):
    for client in (old, new):
        payload = client.request("player", 1)[4]
        count, again = struct.unpack_from(">2I", payload)
        listed = [struct.unpack_from(">4I", payload, 8 + 16 * i) for i in range(count)]
        assert (count, len(payload)) == (again, 8 + 16 * count)
        assert (client.server.ports[0], CODES["actarray"], 0) in [entry[1:] for entry in listed]
        assert (CODES["truth"] in [code for _, _, code, _ in listed]) is (client is old)  # not in 2.1
        found = client.request("player", 2, struct.pack(">6I", 0, 0, CODES["laser"], 0, 0, 0))[4]
        assert found[24:32] == b"gz_laser"
        assert client.request("player", 77)[0] == NACK
        assert client.request("player", 2, struct.pack(">6I", 0, 0, 99, 0, 0, 0))[0] == NACK


@pytest.mark.parametrize(("version", "real", "size"), [("old", "f", 4), ("new", "d", 8)])
def test_position(request, interfaces, version, real, size):
    client, data = request.getfixturevalue(version), interfaces["position"].data
    data.pos[:], data.rot[2], data.vel_pos[0], data.stall, data.time = (1.5, -0.25, 9.0), -1.0, 0.5, 1, 12.25
    assert client.subscribe("position2d") == (1, "gz_position")
    payload = client.data("position2d")
    assert struct.unpack(f">6{real}I", payload) == (1.5, -0.25, -1.0, 0.5, 0.0, 0.0, 1)
    assert client.time == 12.25
    client.command("position2d", 1, struct.pack(f">3{real}I", 0.25, 0.5, -0.75, 1))
    assert client.request("position2d", 2, struct.pack(">I", 1))[0] == ACK
    assert (data.cmd_vel_pos[0], data.cmd_vel_pos[1], data.cmd_vel_rot[2]) == (0.25, 0.5, -0.75)
    kind, *_, geometry = client.request("position2d", 1)
    assert kind == ACK
    if real == "f":
        assert struct.unpack(">5f", geometry) == pytest.approx((0, 0, 0, 0.38, 0.53))
    else:
        assert struct.unpack(">9d", geometry) == (0, 0, 0, 0, 0, 0, 0.38, 0.53, 0.31)
    assert client.request("position2d", 5, struct.pack(f">3{real}", 10.0, 0.0, 0.0))[0] == ACK
    data.time = 13.0
    assert struct.unpack_from(f">{real}", client.data("position2d"))[0] == pytest.approx(10.0)
    assert client.request("position2d", 7, b"")[0] == NACK  # gains of a motor
    assert client.subscribe("position2d", access=2)[0] == 2
    assert data.cmd_vel_pos[0] == 0.0


def test_sensors(new, interfaces):
    laser, sonar, gps = interfaces["laser"].data, interfaces["sonar"].data, interfaces["gps"].data
    laser.min_angle, laser.max_angle, laser.max_range, laser.range_count, laser.time = -1.0, 1.0, 8.0, 3, 0.1
    laser.ranges[:3], laser.intensity[:3] = (1.0, 2.5, 8.0), (0, 1, 0)
    new.subscribe("laser")
    payload = new.data("laser")
    ranges, at = array(payload, 16, "f", 4)
    intensity, end = array(payload, at, "B", 1)
    assert (struct.unpack_from(">2f", payload), ranges, intensity) == ((-1.0, 1.0), (1.0, 2.5, 8.0), (0, 1, 0))
    assert len(payload) == end + 1 + 4  # three bytes are padded; the number of the scan follows
    sonar.sonar_count, sonar.sonar_ranges[1], sonar.time = 2, 3.25, 0.1
    sonar.sonar_pos[1][:], sonar.sonar_rot[1][2] = (0.1, -0.2, 0.3), 0.875
    new.subscribe("sonar")
    assert array(new.data("sonar"), 0, "f", 4)[0] == (0.0, 3.25)
    poses = new.request("sonar", 1)[4]
    assert struct.unpack_from(">2I6d6d", poses)[8:] == (0.1, -0.2, 0.3, 0.0, 0.0, 0.875)
    gps.latitude, gps.utm_e, gps.satellites, gps.hdop, gps.time = -33.5, 500000.25, 10, 1.0, 1.0
    new.subscribe("gps")
    fix = struct.unpack(">2I3i2d4I2d", new.data("gps"))
    assert (fix[2], fix[5], fix[8:10]) == (-335000000, 500000.25, (10, 10))


def test_head_and_gripper(old, new, interfaces):
    ptz, gripper = interfaces["ptz"].data, interfaces["gripper"].data
    ptz.pan, ptz.time = 0.5, 0.1
    gripper.paddles_closed, gripper.lift_up, gripper.time = 1, 1, 0.1
    for client, size in ((old, 20), (new, 24)):
        client.subscribe("ptz")
        payload = client.data("ptz")
        assert (len(payload), struct.unpack_from(">f", payload)) == (size, (0.5,))
    old.command("ptz", 1, struct.pack(">5f", 0.25, -0.5, 1.0, 0.0, 0.0))
    assert old.request("ptz", 2, struct.pack(">I", 1))[0] == ACK
    assert old.request("ptz", 2, struct.pack(">I", 0))[0] == NACK  # by velocity
    assert (ptz.cmd_pan, ptz.cmd_tilt, ptz.cmd_zoom) == (0.25, -0.5, 1.0)
    old.subscribe("gripper")
    new.subscribe("gripper")
    assert struct.unpack(">2I", old.data("gripper")) == (0x12, 0)
    assert struct.unpack(">3I", new.data("gripper")) == (2, 0, 0)
    old.command("gripper", 1, struct.pack(">2I", 8, 0))
    old.request("gripper", 1)
    assert gripper.cmd == 8
    for subtype, code in ((1, 1), (2, 2), (3, 3), (4, 4), (5, 5)):
        new.command("gripper", subtype)
        assert len(new.request("gripper", 1)[4]) == 12 * 8 + 8
        assert gripper.cmd == code


def test_arm(old, new, interfaces):
    arm = interfaces["actarray"].data
    arm.actuators_count, arm.time = 3, 0.1
    arm.actuators_data[1].position, arm.actuators_data[1].state = 0.5, 4
    for client in (old, new):
        client.subscribe("actarray")
    assert struct.unpack_from(">2I2fI2fI", old.data("actarray")) == (3, 3, 0, 0, 0, 0.5, 0, 4)
    assert struct.unpack_from(">2I4fI4fI", new.data("actarray"))[7:] == (0.5, 0, 0, 0, 8)
    before = arm.new_cmd
    new.command("actarray", 1, struct.pack(">if", 2, 0.75))
    new.command("actarray", 2, struct.pack(">2I2f", 2, 2, 0.25, 0.5))
    new.command("actarray", 3, struct.pack(">if", -1, 0.125))
    new.command("actarray", 1, struct.pack(">if", 3, 9.0))  # there is none
    new.request("actarray", 3)
    assert list(arm.cmd_pos[:4]) == [0.25, 0.5, 0.75, 0.0]
    assert (list(arm.cmd_speed[:3]), list(arm.joint_mode[:4]), arm.new_cmd - before) == ([0.125] * 3, [1, 1, 1, 0], 3)


def next_round(client):
    """The data of a round of PULL, as (code, time), and the type of its end."""
    found = []
    while True:
        kind, code, _, subtype, payload = client.message()
        if kind == SYNCH:
            return found, subtype, payload
        assert kind == DATA
        found.append((code, client.time))


def test_pull(new, interfaces, monkeypatch):
    data = interfaces["position"].data
    new.mode(PULL)
    new.subscribe("position2d")
    for number in range(1, 4):
        data.time = float(number)
        new.request("player", 1)
        new.server._next_poll = 0.0
        new.server.turn()
    assert new.request("player", 4)[0] == ACK
    assert next_round(new) == ([(4, time) for time in (0.0, 1.0, 2.0, 3.0)], 1, b"")
    assert new.request("player", 4)[0] == ACK  # nothing is new: the round waits for data
    data.time = 4.0
    assert next_round(new) == ([(4, 4.0)], 1, b"")
    assert new.request("player", 10, struct.pack(">5i", -1, -1, DATA, -1, 1))[0] == ACK  # the latest only
    for number in (5, 6):
        data.time = float(number)
        new.server._next_poll = 0.0
        new.server.turn()
    new.request("player", 4)
    assert next_round(new) == ([(4, 6.0)], 1, b"")
    new.request("player", 10, struct.pack(">5i", -1, -1, DATA, -1, 0))
    monkeypatch.setattr("libgz.player.conversation.MOST_QUEUED", 2)
    for number in range(7, 12):
        data.time = float(number)
        new.server._next_poll = 0.0
        new.server.turn()
    new.request("player", 4)
    assert next_round(new) == ([(4, 10.0), (4, 11.0)], 2, struct.pack(">I", 3))  # three were lost


def test_pull_of_2_0_ends_each_round_at_once(old, interfaces):
    interfaces["position"].data.time = 1.0
    old.request("player", 5, struct.pack(">I", PULL))
    old.subscribe("position2d")
    old.request("player", 4)
    assert next_round(old) == ([(4, 1.0)], 0, b"")
    old.request("player", 4)
    assert next_round(old) == ([], 0, b"")


def test_a_length_shows_the_version(serve, interfaces):
    data = interfaces["position"].data
    data.time = 1.0
    server = serve()
    for first, command, size in (("subscribe", ">3dI", 52), ("mode", ">3fI", 28)):
        with Client2(server) as client:
            if first == "mode":
                client.mode(PUSH)
            client.subscribe("position2d")
            client.data("position2d")
            client.command("position2d", 1, struct.pack(command, 0.5, 0.0, 0.0, 1))
            data.time += 1.0
            payload = client.data("position2d")
            while len(payload) != size:
                payload = client.data("position2d")
            assert data.cmd_vel_pos[0] == 0.5
    with Client2(server) as client:
        client.request("player", 1, bytes(8))  # as the library for Java
        client.subscribe("position2d")
        assert len(client.data("position2d")) == 52
    with Client2(serve(version="2.1")) as client:
        client.subscribe("position2d")
        assert len(client.data("position2d")) == 52


def test_key(serve):
    server = serve(key="secret")
    with Client2(server) as client:
        assert client.request("player", 7, struct.pack(">2I8s", 6, 6, b"secret"))[0] == ACK
        assert client.subscribe("laser")[0] == 1
    with Client2(server) as client:
        client.send(3, 1, 0, 1)
        assert client.closed()


class Loop:
    """The loops of a Player server and of the world of its simulation."""

    def __init__(self, server, world, control):
        self.server, self.ports, self.world = server, server.ports, world
        self.control, self.obedient = control, WorldControl(world)

    def turn(self, timeout):
        while self.control.waiting:
            request = self.control.waiting.popleft()
            request.answer(self.obedient.obey(request))
        self.world.step()
        self.server.turn(timeout)


def test_simulation_moves_models_and_pauses(wire, tmp_path):
    (tmp_path / "s.cfg").write_text('driver ( name "gazebo" provides ["simulation:0"] )')
    names = "xmlns:gz='g' xmlns:model='m' xmlns:param='p'"
    text = f"<gz:world {names}><model:SimpleSolid><id>box</id><xyz>1 2 3</xyz></model:SimpleSolid></gz:world>"
    with libgz.World.from_string(text, server_id=wire) as world:
        world.step()
        control, configuration = Control(server_directory(wire)), read_configuration(tmp_path / "s.cfg", free_port())
        with (
            PlayerServer(configuration, Simulator(wire)) as server,
            Client2(Loop(server, world, control)) as client,
        ):
            client.mode(PUSH)
            assert client.subscribe("simulation")[0] == 1
            box, nobody = (struct.pack(">2I4s3d", 4, 4, name, -1.0, 0.5, 0.25) for name in (b"box\0", b"who\0"))
            kind, *_, payload = client.request("simulation", 1, box)
            assert (kind, struct.unpack_from(">2d", payload, 12)) == (ACK, (1.0, 2.0))
            assert client.request("simulation", 2, box)[::4] == (ACK, b"")
            x, y, yaw = struct.unpack_from(">3d", client.request("simulation", 1, box)[4], 12)
            assert (x, y, yaw) == pytest.approx((-1.0, 0.5, 0.25))
            assert client.request("simulation", 1, nobody)[0] == NACK
            assert client.request("simulation", 5, box)[0] == NACK  # a property
            client.command("simulation", 1)
            client.request("simulation", 5)
            assert world.paused
        control.close()
