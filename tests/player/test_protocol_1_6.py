"""Player's protocol of 1.6: what a client sends and receives, byte for byte."""

import struct

import pytest
from player_clients import ACK, CODES, DATA, ERROR, NACK, SYNCH, Client1, free_port

PUSH_ALL, PULL_ALL, PUSH_NEW, PULL_NEW, PUSH_ASYNC = range(5)


@pytest.fixture
def client(serve):
    with Client1(serve()) as client:
        set_mode(client, PUSH_ASYNC)  # as the C library
        yield client


def set_mode(client, mode):
    assert client.request("player", struct.pack(">HB", 5, mode))[0] == ACK


def rounds(client, count=1):
    """Interface codes of the data of so many rounds."""
    found, part = [], []
    while len(found) < count:
        kind, code, *_ = client.message()
        part += [code] if kind == DATA else []
        if kind == SYNCH:
            found.append(part)
            part = []
    return found


def test_banner_and_lists(client):
    assert client.banner.startswith(b"Player v.")
    kind, code, index, reply = client.request("player", struct.pack(">H", 1))
    count = struct.unpack_from(">HH", reply)[1]
    listed = [struct.unpack_from(">3H", reply, 4 + 6 * i) for i in range(count)]
    assert (kind, code, index, len(reply)) == (ACK, 1, 0, 4 + 256 * 6)
    assert (CODES["position2d"], 0, client.server.ports[0]) in listed
    assert CODES["actarray"] not in [code for code, _, _ in listed]  # later than 1.6
    reply = client.request("player", struct.pack(">4H", 2, CODES["laser"], 0, 6665))[3]
    assert reply[8:].rstrip(b"\0") == b"gz_laser"
    assert len(reply) == 72
    assert client.request("player", struct.pack(">H", 99))[0] == NACK
    assert client.request("player", b"\0")[0] == NACK


def test_position(client, interfaces):
    data = interfaces["position"].data
    data.pos[:], data.rot[2] = (1.5, -0.25, 9.0), -1.0
    data.vel_pos[:], data.vel_rot[2], data.stall, data.time = (0.4, 0.0, 0.0), 0.5, 1, 12.25
    assert client.subscribe("position2d") == ("a", "gz_position")
    assert struct.unpack(">6iB", client.data("position2d")) == (1500, -250, -57, 400, 0, 29, 1)
    assert client.time == 12.25
    client.command("position2d", struct.pack(">6i2B", 7, 7, 7, 300, -200, 90, 1, 0))
    geometry = client.request("position2d", b"\x01")
    assert geometry == (ACK, 4, 0, struct.pack(">B3h2H", 1, 0, 0, 0, 530, 380))
    assert (data.cmd_vel_pos[0], data.cmd_vel_pos[1]) == (0.3, -0.2)
    assert data.cmd_vel_rot[2] == pytest.approx(1.5707963, abs=1e-6)
    assert client.request("position2d", struct.pack(">2B", 2, 1)) == (ACK, 4, 0, b"")
    assert data.cmd_enable_motors == 1
    assert client.request("position2d", b"\x02")[0] == NACK  # without a value
    assert client.request("position2d", b"\x33\0\0")[0] == NACK  # of another robot


def test_odometry_is_set_for_clients_of_player_only(client, interfaces):
    data = interfaces["position"].data
    data.pos[0], data.rot[2], data.time = 2.0, 0.5, 1.0
    client.subscribe("position2d")
    assert client.request("position2d", struct.pack(">B3i", 9, 1000, 500, 90))[0] == ACK
    data.time = 2.0
    first = struct.unpack(">6iB", client.data("position2d"))
    while first[0] == 2000:
        first = struct.unpack(">6iB", client.data("position2d"))
    assert (first[:3], data.pos[0]) == ((1000, 500, 90), 2.0)
    assert client.request("position2d", b"\x04")[0] == ACK
    data.time = 3.0
    assert struct.unpack(">6iB", client.data("position2d"))[:3] == (0, 0, 0)


def test_laser_and_sonar(client, interfaces):
    laser, sonar = interfaces["laser"].data, interfaces["sonar"].data
    laser.min_angle, laser.max_angle, laser.res_angle, laser.range_count = -1.5707963, 1.5707963, 0.0174533, 181
    laser.ranges[:181], laser.intensity[7], laser.max_range, laser.time = [i / 100 for i in range(181)], 1, 8.0, 0.1
    sonar.sonar_count, sonar.sonar_ranges[1], sonar.time = 16, 3.25, 0.1
    sonar.sonar_pos[1][:], sonar.sonar_rot[1][2] = (0.1, -0.2, 0.3), 0.873
    client.subscribe("laser", access="r")
    scan = client.data("laser")
    assert struct.unpack_from(">2h3H", scan) == (-9000, 9000, 100, 1, 181)
    assert struct.unpack_from(">181H", scan, 10) == tuple(10 * i for i in range(181))
    assert (len(scan), scan[10 + 802 + 7]) == (1213, 1)
    laser.max_range, laser.time = 80.0, 0.2
    scan = client.data("laser")
    assert struct.unpack_from(">H", scan, 6) + struct.unpack_from(">H", scan, 10 + 2 * 180) == (10, 180)
    client.subscribe("sonar", access="r")
    ranges = client.data("sonar")
    assert (len(ranges), struct.unpack_from(">3H", ranges)) == (130, (16, 0, 3250))
    _, _, _, poses = client.request("sonar", b"\x01")
    assert (len(poses), struct.unpack_from(">BH6h", poses)) == (387, (1, 16, 0, 0, 0, 100, -200, 50))
    config = client.request("laser", b"\x03")[3]
    assert struct.unpack(">B2h2HB", config) == (3, -9000, 9000, 100, 10, 1)
    client.request("laser", struct.pack(">B2h2HB", 2, -4500, 4500, 50, 1, 1))
    assert (laser.cmd_new_angle, laser.cmd_range_count, laser.cmd_min_angle) == (1, 181, pytest.approx(-0.7853982))


def test_head_gripper_and_others(client, interfaces):
    ptz, gripper, power = interfaces["ptz"].data, interfaces["gripper"].data, interfaces["power"].data
    ptz.pan, ptz.tilt, ptz.zoom, ptz.time = 0.5, -0.25, 1.0, 0.1
    gripper.paddles_opened, gripper.lift_down, gripper.inner_beam_obstruct, gripper.time = 1, 1, 1, 0.1
    power.levels[0], power.time = 12.34, 0.1
    for interface in ("ptz", "gripper", "power"):
        client.subscribe(interface)
    assert struct.unpack(">5h", client.data("ptz")) == (29, -14, 57, 0, 0)
    assert struct.unpack(">2B", client.data("gripper")) == (0x21, 0x08)
    assert struct.unpack(">H", client.data("power")) == (123,)
    client.command("ptz", struct.pack(">5h", -30, 10, 40, 0, 0))
    client.command("gripper", struct.pack(">2B", 4, 0))
    client.request("player", struct.pack(">H", 1))
    assert (ptz.cmd_pan, ptz.cmd_tilt, ptz.cmd_zoom) == pytest.approx((-0.5235988, 0.1745329, 0.6981317))
    assert gripper.cmd == 4


def test_camera_and_truth(client, interfaces):
    camera, truth = interfaces["camera"], interfaces["truth"].data
    camera.data.width, camera.data.height, camera.data.image_size, camera.data.time = 4, 2, 24, 0.1
    camera.array("image")[:24] = range(24)
    truth.pos[:], truth.rot[:], truth.time = (1.0, 2.0, 3.0), (0.7071068, 0.0, 0.0, 0.7071068), 0.1
    client.subscribe("camera", access="r")
    assert client.data("camera") == struct.pack(">2H2BHBI", 4, 2, 24, 5, 1, 0, 24) + bytes(range(24))
    client.subscribe("truth")
    assert struct.unpack(">6i", client.data("truth")) == (1000, 2000, 3000, 0, 0, 1571)
    assert client.request("truth", struct.pack(">B6i", 1, 500, 0, 250, 0, 0, 1571))[0] == ACK
    assert (truth.cmd_new, list(truth.cmd_pos)) == (1, [0.5, 0.0, 0.25])
    assert truth.cmd_rot[3] == pytest.approx(0.7071, abs=1e-3)


def test_access_modes(client, interfaces):
    data = interfaces["position"].data
    data.time = 1.0
    move = struct.pack(">6i2B", 0, 0, 0, 500, 0, 0, 1, 0)
    assert client.request("position2d", b"\x01")[0] == ERROR  # not subscribed
    assert client.subscribe("position2d", access="r")[0] == "r"
    client.command("position2d", move)
    assert client.subscribe("position2d", 5)[0] == "e"
    assert data.cmd_vel_pos[0] == 0.0
    assert client.subscribe("position2d", access="w")[0] == "w"
    client.command("position2d", move)
    assert client.subscribe("position2d", access="?")[0] == "e"
    assert data.cmd_vel_pos[0] == 0.5
    assert client.subscribe("position2d", access="c")[0] == "c"
    client.server.turn()
    assert data.cmd_vel_pos[0] == 0.0  # the last one stops the robot


def test_modes(client, interfaces):
    position, power, sim = interfaces["position"].data, interfaces["power"].data, interfaces["sim"].data
    position.time = power.time = 0.1
    set_mode(client, PULL_NEW)
    client.subscribe("position2d")
    client.subscribe("power")
    ask = struct.pack(">H", 4)
    assert client.request("player", ask)[0] == ACK
    assert rounds(client) == [[4, 2]]
    position.time = 0.2
    client.request("player", ask)
    assert rounds(client) == [[4]]
    set_mode(client, PULL_ALL)
    client.request("player", ask)
    assert rounds(client) == [[4, 2]]
    set_mode(client, PUSH_ASYNC)
    assert client.request("player", ask)[0] == NACK
    power.time = 0.3
    assert rounds(client) == [[2]]
    set_mode(client, PUSH_NEW)
    assert client.request("player", struct.pack(">HH", 6, 5))[0] == ACK  # 5 Hz
    sim.sim_time = 10.0
    client.server.turn(0.01)
    position.time = 10.05
    assert [4] in rounds(client, 2)
    assert client.request("player", struct.pack(">HB", 5, 77))[0] == NACK


def test_frequency_is_of_sim_time_and_loses_nothing(client, interfaces):
    position, sim = interfaces["position"].data, interfaces["sim"].data
    set_mode(client, PUSH_NEW)
    client.subscribe("position2d")
    times = []
    for step in range(1, 101):  # 10 Hz of data, and 10 Hz of rounds
        sim.sim_time = step * 0.02
        if step % 5 == 0:
            position.time = step * 0.02
        client.server._next_poll = 0.0
        client.server.turn()
    while len(times) < 20:
        client.data("position2d")
        times.append(round(client.time, 3))
    assert times == [round(0.1 * i, 3) for i in range(20)]


def test_key(serve):
    server = serve(key="secret")
    with Client1(server) as client:
        assert client.request("player", struct.pack(">H32s", 7, b"secret"))[0] == ACK
        assert client.subscribe("position2d")[0] == "a"
    for first in (struct.pack(">H32s", 7, b"guess"), struct.pack(">H", 1)):
        with Client1(server) as client:
            client.send(3, 1, 0, first)
            assert client.closed()


def test_programs_pass_messages(client):
    client.subscribe("mcom")

    def ask(number, text=b""):
        return client.request("mcom", struct.pack(">BH8sB128s", number, 5, b"all", 0, text))

    assert ask(1)[0] == NACK  # empty
    assert [ask(0, text)[0] for text in (b"one", b"two")] == [ACK, ACK]
    reply = ask(2)[3]
    assert struct.unpack(">H8sB128s", reply)[3].rstrip(b"\0") == b"two"
    assert [ask(1)[3][11:14] for _ in range(2)] == [b"two", b"one"]
    for number in range(20):
        ask(0, b"%d" % number)
    assert ask(3)[0] == ACK
    assert ask(1)[0] == NACK


def test_two_ports(serve, interfaces):
    other = free_port()
    server = serve(
        'driver ( name "gz_position" provides ["position:0"] gz_id "one" robotname "anna" )\n'
        f'driver ( name "gz_power" provides ["{other}:power:0"] gz_id "one" robotname "bert" )'
    )
    with Client1(server, other) as client:
        assert client.subscribe("power")[0] == "a"
        assert client.subscribe("position2d")[0] == "e"
        reply = client.request("player", struct.pack(">H64sH", 8, b"bert", 0))[3]
        assert struct.unpack(">H64sH", reply)[2] == other
