"""ROS 2 by a bridge that the tests play: declarations, bytes, services, names, a bridge that ends; attacks."""

import contextlib
import functools
import json
import logging
import os
import queue
import re
import runpy
import signal
import socket
import struct
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from unittest.mock import MagicMock

import pytest
from gzserver_process import SERVER, new_environment
from ros2_robots import ARM, CONTROL, DRIVE, ROBOT, WAGON, WHEEL, wagon
from ros_bridge import ANSWER, DECLARE, DECLARED, DROP, EMPTY, HELLO, LISTENED, MESSAGE, REQUEST, cdr, fields
from ros_peers import PATIENCE, read_exactly, wait_for, within
from ros_types import JAZZY
from topics import Heard

from libgz.base.errors import GazeboError, LibraryError, NotFoundError, ParameterError
from libgz.classic.server import attach
from libgz.ros import bridged, metrics, session
from libgz.ros.control.drive import DiffDrive2
from libgz.ros.control.hardware import VELOCITY
from libgz.ros.control.ros2 import JointStates2, JointTrajectories2
from libgz.ros.environment import VARIABLE, find_python
from libgz.ros.names import read_names_of_ros2
from libgz.ros.parameters import Parameters
from libgz.ros.server import Ros2
from libgz.ros.types import message_type, service_type
from libgz.ros.world import RosWorld
from libgz.simulation import watchdog
from libgz.simulation.problems import Problem

OURS = ("Point", "Pose", "Twist", "Wrench", "Vector3", "Quaternion", "Transform", "PoseStamped")  # in geometry_msgs
BOX = "<link name='l'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link>"


def channel_of(server, topic):
    return next(one for one in server.ros.node._channels.values() if one.topic == topic)


@pytest.fixture
def start(start_ros2):
    return start_ros2


def test_the_clock_is_best_effort_and_has_its_rate(start, graph):
    server = start(EMPTY, "--ros-args", "-p", "publish_rate:=100.0")
    declared = wait_for(lambda: graph.declared.get("/clock"))
    assert declared["qos"] == {"depth": 1, "reliability": "best_effort"}
    assert declared["node"] == ["/", "gazebo"]
    for _ in range(20):
        server.core.Step()
    assert not graph.received["/clock"]  # nobody listens
    server.topic("/clock")
    begin = server.core.GetSimTime()

    def times():  # without those of messages that were on their way
        found = [JAZZY.deserialize_cdr(body, "rosgraph_msgs/msg/Clock").clock for body in graph.received["/clock"]]
        return [time for one in found if (time := one.sec + one.nanosec * 1e-9) > begin + 1e-6]

    for _ in range(1000):
        server.core.Step()
    wait_for(lambda: len(times()) >= 100)
    assert len(times()) == 100
    assert times()[0] == pytest.approx(begin + 0.01, abs=0.01)


def test_entities_are_spawned_asked_for_moved_and_deleted(start):
    server = start()
    text = f"<sdf version='1.6'><model name='x'><static>true</static>{BOX}</model></sdf>"
    answer = server.call("/spawn_entity", "gazebo_msgs/SpawnEntity", name="crate", xml=text)
    assert (answer.success, answer.status_message) == (True, "SpawnEntity: Successfully spawned entity [crate]")
    again = server.call("/spawn_entity", "gazebo_msgs/SpawnEntity", name="crate", xml=text)
    assert (again.success, again.status_message) == (False, "Entity [crate] already exists.")
    for _ in range(2):  # without a name that of the text is used, with a number if it is taken
        assert server.call("/spawn_entity", "gazebo_msgs/SpawnEntity", xml=text).success
        server.core.Step()
    listed = server.call("/get_model_list", "gazebo_msgs/GetModelList")
    assert listed.model_names == ["crate", "x", "x_0"]
    state = message_type("gazebo_msgs/EntityState", 2)(name="crate")
    state.pose.position.x, state.pose.orientation.w = 3.0, 1.0
    assert server.call("/set_entity_state", "gazebo_msgs/SetEntityState", state=state).success
    found = server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name="crate", reference_frame="x")
    assert found.success
    assert found.state.pose.position.x == pytest.approx(3.0)
    assert not server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name="nobody").success
    state.pose.position.x = float("nan")
    assert not server.call("/set_entity_state", "gazebo_msgs/SetEntityState", state=state).success
    properties = server.call("/get_model_properties", "gazebo_msgs/GetModelProperties", model_name="crate")
    assert (properties.canonical_body_name, properties.is_static) == ("l", True)
    gone = server.call("/delete_entity", "gazebo_msgs/DeleteEntity", name="crate")
    assert gone.status_message == "Successfully deleted entity [crate]"
    wrong = server.call("/delete_entity", "gazebo_msgs/DeleteEntity", name="crate")
    assert wrong.status_message == "Entity [crate] does not exist"
    assert server.topic("/model_states").name == ["x", "x_0"]


def test_a_spawn_fails_by_its_own_error_only(start):
    server = start()
    (world,) = (one for one in server.core.companions if isinstance(one, RosWorld))
    spawn = world._services.handler("spawn_entity")
    text = f"<sdf version='1.6'><model name='x'>{BOX}</model></sdf>"
    request = service_type("gazebo_msgs/SpawnEntity", 2).request(name="crate", xml=text)
    with server.core.hold():
        first, second = spawn(request), spawn(request)
        server.core.problems.add(Problem("a plugin", "it fails", "", "error"))
        assert first.poll() is second.poll() is None
    assert first.poll().success
    assert "already exists" in second.poll().status_message


def test_physics_is_paused_and_reset(start):
    server = start()
    server.core.step(5000)
    server.call("/pause_physics", "std_srvs/Empty")
    assert server.core.paused
    server.call("/unpause_physics", "std_srvs/Empty")
    assert not server.core.paused
    server.call("/reset_simulation", "std_srvs/Empty")
    assert server.core.GetSimTime() < 5.0


def test_a_bridge_that_ends_is_started_again(start, graph, caplog):
    server = start()
    server.topic("/clock")
    clock = channel_of(server, "/clock")
    server.ros.node.process.kill()
    wait_for(lambda: not clock.listened)
    assert clock.codec.pack(message_type("rosgraph_msgs/Clock")())  # a step may just have begun to publish
    wait_for(lambda: graph.links == 2 and "/clock" in graph.declared, server.core.Step)
    server.topic("/clock")
    assert "the bridge has ended" in caplog.text


def test_a_bridge_that_says_nothing_is_started_again(start, graph, monkeypatch):
    server = start()
    monkeypatch.setattr(bridged, "START_PATIENCE", 1.0)
    graph.silent = True
    server.ros.node.process.kill()
    wait_for(lambda: graph.links == 2)
    graph.silent = False
    wait_for(lambda: graph.links >= 3 and "/clock" in graph.declared)


def test_a_channel_that_is_collected_within_a_lock_ends(start, graph):
    server = start()
    number = graph.number("/pause_physics")
    channel = channel_of(server, "/pause_physics")
    assert within(server.ros.node._declaring, lambda: server.ros.node.withdraw(channel))
    wait_for(lambda: all(one["number"] != number for one in graph.declared.values()))


def test_a_new_bridge_gets_no_answers_to_requests_of_the_last_one(start, graph):
    server = start()
    number = graph.number("/pause_physics")
    late, key = [], struct.pack("<Q", 77)
    channel_of(server, "/pause_physics").serve = lambda _body, answer: not late.append(answer)
    graph.send(REQUEST, number, key)
    wait_for(lambda: late)
    server.ros.node.process.kill()
    wait_for(lambda: graph.links == 2 and "/unpause_physics" in graph.declared, server.core.Step)
    late[0](True, b"")
    server.call("/unpause_physics", "std_srvs/Empty")
    assert key not in graph.answers


class Executor:
    """A stand-in for that of rclpy, which does what it is given."""

    def __init__(self, num_threads):
        self.tasks, self.nodes = queue.SimpleQueue(), []
        self.add_node, self.remove_node = self.nodes.append, self.nodes.remove
        self.create_task = self.tasks.put

    def spin_once(self):
        self.tasks.get()()


@pytest.fixture
def bridge(monkeypatch):
    """The bridge of the program, with a stand-in for rclpy, and our end of its socket."""
    stand_in = MagicMock(MultiThreadedExecutor=Executor)
    stand_in.create_node.side_effect = lambda *_, **_more: MagicMock()
    for name in ("", ".callback_groups", ".duration", ".executors", ".parameter", ".qos", ".serialization"):
        monkeypatch.setitem(sys.modules, f"rclpy{name}", stand_in)
    kind = MagicMock(SLOT_TYPES=[])
    kind.get_fields_and_field_types.return_value = {}
    monkeypatch.setitem(sys.modules, "some_msgs.msg", MagicMock(Some=kind))
    ours, theirs = socket.socketpair()
    with ours, theirs:
        found = runpy.run_path(str(bridged.PROGRAM))["Bridge"](theirs)
        yield found, ours
        for number in list(found._channels):
            found._act(DROP, number, b"")


def declare(bridge, number, verb, node):
    about = {"verb": verb, "name": "/a", "type": "some_msgs/msg/Some", "node": ["/", node], "qos": {}}
    bridge._act(DECLARE, number, json.dumps(about).encode())
    return bridge.node("/", node)


def test_a_node_of_a_bridge_looks_at_its_own_and_ends_with_its_last_channel(bridge):
    found, _ = bridge
    one, other, again = (declare(found, n, "publish", name) for n, name in enumerate(("a", "b", "a")))
    assert one is again
    assert (one._executor.nodes, other._executor.nodes) == ([one.node], [other.node])
    found._act(DROP, 0, b"")
    assert set(found._nodes.values()) == {one, other}
    found._act(DROP, 2, b"")
    wait_for(lambda: one.node.destroy_node.called)
    assert list(found._nodes.values()) == [other]
    assert not other.node.destroy_node.called


def test_a_bridge_says_what_the_fields_are_before_messages_come(bridge):
    found, ours = bridge
    own = found.node("/", "n")
    own.node.create_subscription = lambda _kind, _name, receive, _quality, raw: receive(b"kept")
    declare(found, 7, "subscribe", "n")
    sorts = []
    for _ in range(2):
        size, sort, _ = struct.unpack("<IBI", read_exactly(ours, 9))
        read_exactly(ours, size - 5)
        sorts.append(sort)
    assert sorts == [DECLARED, MESSAGE]


def test_types_that_the_bridge_does_not_have_are_named_once(start, graph, caplog):
    graph.refused.add("gazebo_msgs")
    server = start()
    server.topic("/clock")
    told = [one for one in caplog.messages if "there is no package gazebo_msgs" in one]
    assert len(told) == 1


def test_hostile_frames_are_left_out(start, graph, caplog):
    caplog.set_level(logging.WARNING)
    world = f"""<sdf version='1.6'><world name='default'><model name='robot'>{BOX}
      <plugin name='drive' filename='libgazebo_ros_planar_move.so'/></model></world></sdf>"""
    server = start(world)
    number = graph.number("/cmd_vel")
    service = graph.number("/pause_physics")
    for body in (b"", b"\0\1\0\0", b"\xff" * 300, b"\0\1\0\0" + struct.pack("<6d", *[float("nan")] * 6)):
        graph.send(MESSAGE, number, body)
    graph.send(MESSAGE, 12345, b"x")
    graph.send(99, number, b"x")
    graph.send(LISTENED, graph.number("/clock"), b"")
    graph.send(DECLARED, number, b"[{}]")
    graph.send(DECLARED, number, b"\xff{")
    graph.send(HELLO, 0, b"[]")
    graph.send(REQUEST, service, b"1")
    graph.send(REQUEST, service, b"12345678\xff")
    graph.send(ANSWER, service, b"x")
    server.topic("/clock")
    x, y, _ = attach(server.core).world.ModelByName("robot").WorldPose().Pos()
    assert abs(x) + abs(y) < 1e-3
    assert "is not obeyed" in caplog.text
    graph.socket.sendall(struct.pack("<IBI", 1 << 31, MESSAGE, number))  # a length beyond all bounds ends the bridge
    wait_for(lambda: graph.links == 2, server.core.Step)


@contextlib.contextmanager
def stopped(server):
    """The bridge reads nothing meanwhile."""
    process = server.ros.node.process
    process.send_signal(signal.SIGSTOP)
    try:
        yield process
    finally:
        process.send_signal(signal.SIGCONT)


def test_a_bridge_that_hangs_at_the_end_is_killed(start):
    server = start()
    with stopped(server) as process:
        server.ros.close()
        assert process.returncode == -signal.SIGKILL
    assert 2.0 * bridged.END_PATIENCE <= watchdog.PATIENCE  # no user is reminded of a second signal


def test_a_signal_ends_a_start_whose_bridge_says_nothing(graph, tmp_path):
    graph.silent = True
    environment = {**new_environment(tmp_path), VARIABLE: str(graph.python)}
    with subprocess.Popen([*SERVER, "--ros2"], env=environment) as process:
        try:
            wait_for(lambda: graph.links)
            process.terminate()
            assert process.wait(PATIENCE) == 128 + signal.SIGTERM
        finally:
            process.kill()


def test_a_slow_bridge_costs_no_memory(start, graph, caplog):
    server = start()
    server.topic("/clock")
    channel = channel_of(server, "/clock")
    with stopped(server):
        for _ in range(bridged.MOST_WAITING + 100):
            channel.publish([bytes(1 << 16)])
    assert channel.waiting_bytes <= bridged.MOST_BYTES + (1 << 16)
    assert "too slow for /clock" in caplog.text


def test_a_slow_bridge_costs_no_memory_by_many_topics(start, graph, caplog, monkeypatch):
    monkeypatch.setattr(bridged, "MOST_TOGETHER", 1 << 22)
    server = start()
    for topic in ("/clock", "/model_states", "/link_states"):
        graph.number(topic)
    channels = [channel_of(server, topic) for topic in ("/clock", "/model_states", "/link_states")]
    wait_for(lambda: all(channel.declared for channel in channels))
    link = server.ros.node._link

    def fill():
        for channel in channels * 30:
            channel.publish([bytes(1 << 16)])

    with stopped(server):
        fill()
        wait_for(lambda: link.slow, fill)  # from then on, nothing leaves
        fill()
        waiting = link.waiting_bytes
        assert (1 << 22) < waiting <= (1 << 22) + (1 << 17)
        assert sum(channel.waiting_bytes for channel in channels) == waiting
    assert "too slow for /link_states" in caplog.text
    wait_for(lambda: not link.waiting_bytes)


def test_large_messages_of_a_hurried_world_are_not_left_out(start, graph, caplog, monkeypatch):
    monkeypatch.setattr(bridged, "MOST_BYTES", 1 << 16)
    server = start()
    graph.number("/clock")
    channel, node = channel_of(server, "/clock"), server.ros.node
    wait_for(lambda: channel.declared)
    node.follow_pace(lambda: True)
    node._loop._due = time.monotonic() + 5.0  # something was sent just now
    for _ in range(4):
        channel.publish([bytes(40_000)])
    wait_for(lambda: len(graph.received["/clock"]) == 4)
    assert "too slow" not in caplog.text


def test_declarations_that_a_bridge_does_not_take_are_bounded(start, graph, caplog, monkeypatch):
    monkeypatch.setattr(bridged, "MOST_ENDED", 100)
    server = start()
    graph.number("/pause_physics")
    node, kind = server.ros.node, service_type("std_srvs/Empty", 2)
    link = node._link
    server.ros.node.process.send_signal(signal.SIGSTOP)

    def come_and_go():
        node.withdraw(node.serve(f"/{'x' * 100_000}", kind, lambda _body, _answer: True))

    wait_for(lambda: link.closed, come_and_go)
    assert len(link.queue) <= len(node._channels) + 102
    assert "it takes no declarations" in caplog.text
    wait_for(lambda: graph.links == 2 and "/pause_physics" in graph.declared)


def test_what_a_bridge_says_is_one_short_line(start, graph, caplog):
    caplog.set_level(logging.INFO)
    graph.about = {"distribution": "one\ntwo\x1b[2J", "middleware": "m" * 100_000}
    server = start()
    table = {"": {"f": "no\x1b" * 100_000}}
    graph.send(DECLARED, graph.number("/clock"), json.dumps([table]).encode())
    wait_for(lambda: "is left out" in caplog.text)
    assert server.core
    assert all(len(one) < 2500 and "\n" not in one and "\x1b" not in one for one in caplog.messages)


def test_an_end_of_a_channel_is_not_counted_among_what_waits(start, graph):
    server = start()
    graph.number("/pause_physics")
    channel = channel_of(server, "/pause_physics")
    server.ros.node.withdraw(channel)
    wait_for(lambda: "/pause_physics" not in graph.declared)
    assert (channel.waiting, channel.waiting_bytes, server.ros.node._link.waiting_bytes) == (0, 0, 0)


def test_what_waits_for_a_bridge_that_is_gone_is_not_counted(start, graph, monkeypatch):
    monkeypatch.setattr(bridged, "FIRST_PAUSE", 60.0)
    server = start()
    graph.number("/pause_physics")
    channel, link = channel_of(server, "/pause_physics"), server.ros.node._link
    with stopped(server) as process:
        while channel.waiting < 10:
            server.ros.node.push(channel, ANSWER, [bytes(1 << 16)])
        wait_for(lambda: link.unsent)
        process.kill()
        wait_for(lambda: link.closed and not channel.waiting)
        server.ros.node.push(channel, ANSWER, [bytes(1 << 16)])
    assert (channel.waiting, channel.waiting_bytes) == (0, 0)


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ({"": {"f": "uint8[999999999]"}}, "more than 65536 values"),
        ({"": {"f": f"uint8[{'9' * 5000}]"}}, "is not supported"),
        ({"": {f"f{number}": "uint8[60000]" for number in range(2)}}, "more than 65536 values"),
        ({"": {"f": "a/A"}, "a/A": {"b": "a/A"}}, "in more than 16 levels"),
        ({"": {"f": "nobody/Knows"}}, "there is no message type"),
        ({"": {"clock": "string"}}, "field 'clock' is a string; it must be a time"),
        ({"": {"clock": "builtin_interfaces/Time[2]"}}, r"is a time\[2\]; it must be a time"),
        ({"": {f"f{number}": "uint8" for number in range(70_000)}}, "does not say what the fields are"),
        ({"": {f"f{number}": "uint8" for number in range(10_000)}}, "there are more than 10000 fields"),
        (
            {
                name: {f"f{number}": kind for number in range(9)}
                for name, kind in pairwise(["", *(f"geometry_msgs/{one}" for one in OURS), "uint8"])
            },
            "more than 65536 values",
        ),
        ({"": {"f": "sequence<geometry_msgs/Pose>"}, "geometry_msgs/Pose": {}}, "geometry_msgs/Pose has no fields"),
        ({"": {"f": "sequence<std_msgs/Empty>"}}, "std_msgs/Empty has no fields"),
    ],
)
def test_hostile_types_are_left_out(start, graph, caplog, table, why):
    server = start()
    graph.send(DECLARED, graph.number("/clock"), json.dumps([table]).encode())
    graph.listen("/clock")
    wait_for(lambda: re.search(rf"/clock .* is left out: .*{why}", caplog.text), server.core.Step)
    assert not graph.received["/clock"]


@pytest.mark.parametrize("table", [{"": {"a": "uint8"}}, {"": {"a": "string", "b": "uint8[3]"}}])
def test_types_without_the_numbers_of_ours_do_not_end_the_server(start, graph, caplog, table):
    server = start()
    graph.send(DECLARED, graph.number("/clock"), json.dumps([table]).encode())
    graph.listen("/clock")
    wait_for(lambda: graph.received["/clock"], server.core.Step)
    assert caplog.text.count("rosgraph_msgs/Clock has no numbers 'clock'") == 1
    assert server.call("/get_model_list", "gazebo_msgs/GetModelList").success


def without(table, name):
    return {key: {field: kind for field, kind in rows.items() if field != name} for key, rows in table.items()}


@pytest.mark.parametrize(
    "changed",
    [
        lambda table: without(table, "orientation"),
        lambda table: without(table, "z"),
        lambda table: {key: {"f": "double", **rows} for key, rows in table.items()},
        lambda table: {key: dict(reversed(rows.items())) for key, rows in table.items()},
        lambda table: table | {"": table[""] | {"f": "std_msgs/Header[3]"}},
        lambda table: table | {"": table[""] | {"f": "string[3]"}},
        lambda table: table | {"": table[""] | {"f": "builtin_interfaces/Time[3]"}},
    ],
)
def test_other_types_than_ours_do_not_end_the_server(start, graph, changed):
    server = start((Path(__file__).parent / "robot2.world").read_text())
    names = "/clock", "/demo/model_states", "/bot/odom", "/tf"
    topics = {name: wait_for(functools.partial(graph.declared.get, name)) for name in names}
    for row in topics.values():
        package, _, name = row["type"].split("/")
        table = changed(fields(f"{package}/{name}", "msg")[0])
        graph.send(DECLARED, row["number"], json.dumps([table]).encode())
        graph.send(LISTENED, row["number"], struct.pack("<I", 1))
    wait_for(lambda: all(graph.received[topic] for topic in topics), server.core.Step)


def test_numbers_that_a_bridge_has_in_another_order_are_found(start, graph):
    server = start((Path(__file__).parent / "robot2.world").read_text())
    kind = message_type("gazebo_msgs/ModelStates", 2)
    table = {key: dict(reversed(rows.items())) for key, rows in fields(kind.name, "msg")[0].items()}
    number = graph.number("/demo/model_states")
    graph.send(DECLARED, number, json.dumps([table]).encode())
    graph.send(LISTENED, number, struct.pack("<I", 1))
    body = wait_for(lambda: graph.received["/demo/model_states"], server.core.Step)[0]
    x, y, z = attach(server.core).world.ModelByName("wall").WorldPose().Pos()
    place = cdr(kind, table).unpack(body).pose[1].position
    assert (place.x, place.y, place.z) == pytest.approx((x, y, z))


def test_floods_of_a_bridge_cost_no_memory(start, graph, caplog):
    server = start()
    clock, service = graph.number("/clock"), graph.number("/pause_physics")
    channel = channel_of(server, "/pause_physics")
    for number in range(2000):  # between two steps
        graph.send(LISTENED, clock, struct.pack("<I", number % 2))
    for number in range(session.MOST_REQUESTS + 10):
        graph.send(REQUEST, service, struct.pack("<Q", number) + bytes(4))
    wait_for(lambda: "/pause_physics has too many requests" in caplog.text)
    assert len(server.ros.node.changed) <= len(server.ros.node._channels)
    assert len(server.ros.requests) == session.MOST_REQUESTS
    with stopped(server):
        for _ in range(bridged.MOST_WAITING + 100):
            server.ros.node.push(channel, ANSWER, [bytes(1 << 16)])
    assert channel.waiting_bytes <= bridged.MOST_BYTES + (1 << 17)
    assert "too slow for /pause_physics; an answer is left out" in caplog.text


def test_large_requests_are_bounded_together(start, graph, caplog, monkeypatch):
    monkeypatch.setattr(session, "MOST_REQUEST_BYTES", 1 << 20)
    server = start()
    service = graph.number("/spawn_entity")
    for number in range(3):
        graph.send(REQUEST, service, struct.pack("<Q", number) + bytes(600_000))
    wait_for(lambda: caplog.text.count("/spawn_entity has too many requests") == 1)
    wait_for(lambda: len(graph.answers) >= 2)
    assert [len(body) for _, body, _ in server.ros.requests] == [600_000]


def test_without_a_ros_the_error_says_what_to_do(monkeypatch, tmp_path, capfd):
    for name in ("LIBGZ_ROS2_PYTHON", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    with pytest.raises(LibraryError, match="libgz ros venv"):
        find_python()
    bad = tmp_path / "python3"
    bad.write_text("#!/bin/sh\necho no rclpy >&2; exit 1\n")
    bad.chmod(0o755)
    begin = time.monotonic()
    with pytest.raises(LibraryError, match="cannot run rclpy"):
        Ros2([], bad)
    assert time.monotonic() - begin < bridged.START_PATIENCE
    capfd.readouterr()


def test_plugins_have_nodes_names_and_qualities_of_ros2(start, graph):
    server = start((Path(__file__).parent / "robot2.world").read_text())
    scan = server.topic("/bot/scan")
    assert scan.header.frame_id == "lidar"
    assert min(scan.ranges) == pytest.approx(2.9, abs=0.02)
    declared = graph.declared
    assert declared["/bot/scan"]["node"] == ["/bot", "laser"]
    assert declared["/bot/scan"]["qos"] == {
        "depth": 2, "reliability": "best_effort", "history": "keep_last", "deadline": 0.25
    }  # fmt: skip
    cloud = server.topic("/cloud_driver/out")
    assert (cloud.header.frame_id, cloud.width, cloud.point_step) == ("base", 30, 16)
    sonar = server.topic("/sonar_driver/out")
    assert (sonar.radiation_type, sonar.range) == (0, pytest.approx(2.9, abs=0.02))
    imu = server.topic("/bot/imu/data")
    assert imu.header.frame_id == "base"
    assert imu.linear_acceleration.z == pytest.approx(9.8, abs=0.2)
    fix = server.topic("/gps_driver/out")
    assert (fix.latitude, fix.longitude) == (pytest.approx(50.0, abs=1e-3), pytest.approx(8.0, abs=1e-3))
    assert server.topic("/gps_driver/vel").vector.z == pytest.approx(0.0, abs=0.1)
    server.topic("/bumper_states")
    assert server.topic("/joint_states").name == ["left_joint", "right_joint"]
    assert server.topic("/truth").child_frame_id == "base"
    assert server.topic("/wrench").header.frame_id == "left"
    assert server.topic("/grasping").data is False
    assert server.topic("/demo/model_states").name == ["ground", "wall", "robot"]
    assert len(server.topic("/demo/link_states").name) == 5
    depths = {
        name: declared[name]["qos"]["depth"] for name in ("/bot/imu/data", "/bot/odom", "/joint_states", "/truth")
    }
    assert depths == {"/bot/imu/data": 5, "/bot/odom": 1, "/joint_states": 1000, "/truth": 5}
    assert "/demo/get_entity_state" in declared
    twist = message_type("geometry_msgs/Twist")()
    twist.linear.x = 0.5
    graph.publish("/bot/go", cdr(twist.kind, fields("geometry_msgs/Twist", "msg")[0]).pack(twist))
    moved = attach(server.core).world.ModelByName("robot")
    wait_for(lambda: moved.WorldPose().Pos().X() > 0.1, server.core.Step)
    assert server.topic("/bot/odom").twist.twist.linear.x == pytest.approx(0.5, abs=0.05)
    assert server.topic("/tf").transforms[0].child_frame_id == "base_footprint"
    assert server.call("/switch", "std_srvs/SetBool", data=True).success
    assert server.call("/demo/get_entity_state", "gazebo_msgs/GetEntityState", name="robot").success


def describe_robot(server, graph, robot=ROBOT):
    text = message_type("std_msgs/String")(data=robot)
    body = cdr(text.kind, fields("std_msgs/String", "msg")[0]).pack(text)
    assert wait_for(lambda: graph.declared.get("/robot_description"))["qos"]["durability"] == "transient_local"
    graph.publish("/robot_description", body)
    wait_for(lambda: "/controller_manager/list_controllers" in graph.declared, server.core.Step)


def manage(server, service, kind, /, **values):
    return server.call(f"/controller_manager/{service}", f"controller_manager_msgs/{kind}", **values)


def test_controllers_of_ros2_are_loaded_configured_and_switched(start, graph, tmp_path):
    (tmp_path / "control.yaml").write_text(CONTROL)
    server = start(ARM.format(file=tmp_path / "control.yaml"))
    describe_robot(server, graph)
    for name in ("states", "mover", "follower"):
        assert manage(server, "load_controller", "LoadController", name=name).ok
        assert not manage(server, "load_controller", "LoadController", name=name).ok
        assert manage(server, "configure_controller", "ConfigureController", name=name).ok
    assert manage(server, "switch_controller", "SwitchController", activate_controllers=["states", "mover"]).ok
    listed = manage(server, "list_controllers", "ListControllers").controller
    assert {one.name: one.state for one in listed} == {"states": "active", "mover": "active", "follower": "inactive"}
    assert next(one for one in listed if one.name == "mover").claimed_interfaces == ["elbow/velocity"]
    array = message_type("std_msgs/Float64MultiArray")(data=[0.5])
    server.topic("/clock")
    graph.publish("/mover/commands", cdr(array.kind, fields("std_msgs/Float64MultiArray", "msg")[0]).pack(array))
    joint = attach(server.core).world.ModelByName("arm").GetJoint("elbow")
    wait_for(lambda: joint.Position(0) > 0.05, server.core.Step)
    states = server.topic("/joint_states")
    assert states.name == ["elbow"]
    assert states.velocity[0] == pytest.approx(0.5, abs=0.01)
    switched = {"activate_controllers": ["follower"], "deactivate_controllers": ["mover"]}
    assert manage(server, "switch_controller", "SwitchController", **switched).ok
    identity = list(range(16))
    goal = message_type("control_msgs/FollowJointTrajectory_Goal", 2)()
    point = message_type("trajectory_msgs/JointTrajectoryPoint")(positions=[1.0])
    point.time_from_start.nsecs = 200_000_000
    goal.trajectory.joint_names, goal.trajectory.points = ["elbow"], [point]
    uuid = message_type("unique_identifier_msgs/UUID", 2)(uuid=identity)
    action = "/follower/follow_joint_trajectory/_action"
    kind = "control_msgs/FollowJointTrajectory"
    assert graph.declared[f"{action}/send_goal"]["type"] == f"control_msgs/action/{kind[13:]}.Impl.SendGoalService"
    assert server.call(f"{action}/send_goal", f"{kind}_SendGoal", goal_id=uuid, goal=goal).accepted
    asked, (request, response) = service_type(f"{kind}_GetResult", 2), fields(f"{kind}_GetResult", "srv")
    body = cdr(asked.request, request).pack(asked.request(goal_id=uuid))
    keys = [struct.pack("<Q", 1000 + number) for number in range(100)]
    for key in keys:  # of so many that wait for one result, the first ones get an empty one
        graph.send(REQUEST, graph.number(f"{action}/get_result"), key + body)
    wait_for(lambda: len(server.ros.requests) == len(keys))
    server.core.Step()
    early = wait_for(lambda: graph.answers.get(keys[0]))
    assert cdr(asked.response, response).unpack(early[1:]).status == 0
    assert server.call("/get_model_list", "gazebo_msgs/GetModelList").success
    assert server.call(f"{action}/get_result", f"{kind}_GetResult", goal_id=uuid).status == 4  # succeeded
    for _ in range(20):  # the last command is applied at the next update
        server.core.Step()
    assert joint.Position(0) == pytest.approx(1.0, abs=0.01)
    wrong = message_type("trajectory_msgs/JointTrajectory")(joint_names=["knee"], points=[point])
    goal.trajectory = wrong
    uuid.uuid = identity[::-1]
    assert not server.call(f"{action}/send_goal", f"{kind}_SendGoal", goal_id=uuid, goal=goal).accepted
    cancelled = server.call(f"{action}/cancel_goal", "action_msgs/CancelGoal")
    assert cancelled.return_code == 1  # nothing runs


def test_requests_do_not_fill_the_log(start, graph, tmp_path, caplog):
    (tmp_path / "control.yaml").write_text(CONTROL)
    server = start(ARM.format(file=tmp_path / "control.yaml"))
    describe_robot(server, graph)
    caplog.clear()
    unknown = [f"nobody{number}" for number in range(1000)]
    assert manage(server, "switch_controller", "SwitchController", activate_controllers=unknown).ok
    for number in range(150):
        assert not manage(server, "load_controller", "LoadController", name=f"one\nmore{number}").ok
    assert 1000 < len(caplog.records) < 1010
    long = "x" * (1 << 20)
    for _ in range(3):
        assert not server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name=f"_{long}").success
    assert 1000 < len(caplog.records) < 1010
    assert all(len(one) < 2500 and "\n" not in one for one in caplog.messages)


def test_models_that_are_spawned_do_not_fill_the_log(start, caplog):
    """Nor do those that fail, which are refused each time."""
    server = start()
    text = "<sdf version='1.6'><model name='m'><link name='l'/>{}</model></sdf>"
    wrong = "<joint name='j' type='x'/>"
    for number in range(110):
        name = f"m{number}"
        spawned = server.call("/spawn_entity", "gazebo_msgs/SpawnEntity", name=name, xml=text.format("<other/>"))
        assert spawned.success
        refused = server.call("/spawn_entity", "gazebo_msgs/SpawnEntity", name="x", xml=text.format(wrong))
        assert not refused.success
    assert 3 <= len(caplog.messages) <= 6
    assert sum("(100 times so far)" in text for text in caplog.messages) >= len(caplog.messages) // 2


def test_a_long_refusal_is_one_short_line(start, graph, caplog):
    server = start()
    name = "x\n" * (1 << 19)
    for _ in range(3):
        assert not server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name=name).success
    (line,) = caplog.messages
    assert len(line) < 5000
    assert "\n" not in line


def test_the_command_line_is_read_as_nodes_of_ros2_read_it(tmp_path):
    (tmp_path / "world.yaml").write_text(
        "/**: {ros__parameters: {publish_rate: 5.0, depth: {x: 1}}}\n"
        "sim: {gazebo: {ros__parameters: {publish_rate: 20.0, depth.y: 2, live: true}}}\n"
        "other: {ros__parameters: {publish_rate: 7.0}}\n"
    )
    words = ["-s", "libgazebo_ros_init.so", "w.world", "--ros-args", "-r", "__ns:=/sim", "--remap", "gazebo:a:=b"]
    words += ["--params-file", str(tmp_path / "world.yaml"), "-p", "live:=false", "--param", "gazebo:name:=box"]
    words += ["-p", "other:name:=none", "-r", "other:c:=d", "--log-level", "debug", "--disable-rosout-logs", "--", "-v"]
    names = read_names_of_ros2(words)
    assert names.name == "/sim/gazebo"
    assert names.remappings == {"/sim/a": "/sim/b"}
    assert names.parameters == {"publish_rate": 20.0, "depth": {"x": 1, "y": 2}, "live": False, "name": "box"}
    assert read_names_of_ros2(["__node:=x", "a:=/b"]).remappings == {"/a": "/b"}
    assert read_names_of_ros2(["--ros-args", "-p", "x:=\udcff"]).parameters == {"x": "\udcff"}  # not in UTF-8
    for wrong, why in {"-p": "has no value", "-p x": "must have the form", "-r x": "must have the form"}.items():
        with pytest.raises(ParameterError, match=why):
            read_names_of_ros2(["--ros-args", *wrong.split()])
    with pytest.raises(NotFoundError):
        read_names_of_ros2(["--ros-args", "--params-file", str(tmp_path / "none.yaml")])


@pytest.mark.parametrize(
    ("pattern", "matches"),
    [("/**", True), ("/a/**", True), ("/*/*/c", True), ("c", True), ("/c", True), ("/a/c", False), ("/**/b", False),
     ("/b/**", False), ("/**/c", True), ("*", True), ("/a/b/c/**", True), ("/" + "/".join(["**"] * 500), True)],
)  # fmt: skip
def test_names_of_nodes_have_wildcards(pattern, matches):
    parameters = Parameters()
    parameters.set(pattern, "x", "1")
    assert bool(parameters.of("/a/b/c")) == matches


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("a: " + "{b: " * 100, "nested|line"),
        ("/**: {ros__parameters: {" + "a." * 100 + "b: 1}}", "has 100 points"),
        ("a0: &a0 {ros__parameters: {x: 1}}\n"
         + "".join(f"a{n}: &a{n} {{x: *a{n - 1}, y: *a{n - 1}}}\n" for n in range(1, 30)), "more than"),
        ("[1]", "has no parameters"),
        ("x" * (1 << 20), "has no parameters|too"),
    ],
)  # fmt: skip
def test_files_of_parameters_are_bounded(tmp_path, text, why):
    (tmp_path / "x.yaml").write_text(text)
    with pytest.raises(GazeboError, match=rf"x\.yaml.*({why})"):
        Parameters().read(tmp_path / "x.yaml")


def test_metrics_say_how_fast_sensors_are(start):
    server = start((Path(__file__).parent / "robot2.world").read_text())
    server.topic("/bot/scan")

    def rates():
        metrics = server.topic("/performance_metrics")
        assert metrics.real_time_factor > 0.0
        return {one.name: one.sim_update_rate for one in metrics.sensors}.get("default::robot::base::scan")

    assert wait_for(rates) == pytest.approx(10.0, rel=0.02)


def test_metrics_forget_what_was_while_nobody_listens_and_what_is_gone(monkeypatch):
    sent, session, sensor, time_now = [], MagicMock(), MagicMock(), [1000.0]
    monkeypatch.setattr(metrics.time, "monotonic", lambda: time_now[0])
    topic = session.publish.return_value
    topic.kind, topic.publish, topic.listened = message_type("gazebo_msgs/PerformanceMetrics"), sent.append, True
    sensor.ScopedName.return_value, sensor.Camera.return_value = "scan", None
    sensors = [sensor]
    made = metrics.Metrics(session, "performance_metrics", lambda: sensors)

    def run(begin, count=10):
        for number in range(count):
            time_now[0] += 0.2
            sensor.schedule.measured = begin + 0.1 * number
            made.update(begin + 0.1 * number)
        return sent[-1]

    assert run(0.0).sensors[0].sim_update_rate == pytest.approx(10.0)
    topic.listened = False
    session.publish.call_args.kwargs["changed"]()
    time_now[0] += 3600.0
    topic.listened, sent[:] = True, []
    last = run(3600.0)
    assert {round(one.real_time_factor, 6) for one in sent} == {0.5}
    assert {round(rate.real_update_rate, 6) for one in sent for rate in one.sensors} == {5.0}
    assert last.sensors[0].name == "scan"
    sensors.clear()
    assert not run(3602.0).sensors
    assert not made._seen


def test_a_pipe_is_no_file_of_parameters(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    with pytest.raises(NotFoundError, match="it is a pipe, not a file"):
        Parameters().read(tmp_path / "pipe.yaml")


def test_controllers_start_by_themselves_where_nobody_could_start_them(start, graph, tmp_path):
    graph.refused.add("controller_manager_msgs")
    text = CONTROL.replace("    follower: {type: joint_trajectory_controller/JointTrajectoryController}\n", "")
    text = text.replace("    states:", "    odd: {type: [none]}\n    states:")
    (tmp_path / "control.yaml").write_text(text)
    server = start(ARM.format(file=tmp_path / "control.yaml"))
    describe_robot(server, graph)
    assert server.topic("/joint_states").name == ["elbow"]
    assert "/mover/commands" in graph.declared


def part(name, place, parent, axis, inside=WHEEL):
    return (
        f"<link name='{name}'><pose>{place} 0.1 {'-1.5708' if inside else 0} 0 0</pose><inertial><mass>0.5</mass>"
        f"<inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>{inside}</link>"
        f"<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{name}</child>"
        f"<axis><xyz>{axis}</xyz></axis></joint>"
    )


def car():
    sides = {"left": 0.2, "right": -0.2}
    parts = [part(f"rear_{side}", f"0 {y}", "base", "0 0 1") for side, y in sides.items()]
    parts += [part(f"{side}_steer", f"0.8 {y}", "base", "0 0 1", "") for side, y in sides.items()]
    parts += [part(f"front_{side}", f"0.8 {y}", f"{side}_steer", "0 0 1") for side, y in sides.items()]
    names = "".join(
        f"<{end}_{side}_joint>{end}_{side}</{end}_{side}_joint>" for end in ("front", "rear") for side in sides
    )
    names += "".join(
        f"<{side}_steering_joint>{side}_steer</{side}_steering_joint>"
        f"<{side}_steering_pid_gain>20 0 2</{side}_steering_pid_gain>"
        for side in sides
    )
    slip = "<wheel link_name='rear_left'><wheel_normal_force>10</wheel_normal_force></wheel>"
    return f"""<sdf version='1.6'><world name='default'><model name='ground'><static>true</static><link name='l'>
      <collision name='c'><geometry><plane/></geometry></collision></link></model><model name='car'>
      <link name='base'><pose>0.4 0 0.1 0 0 0</pose><inertial><mass>5</mass></inertial></link>{"".join(parts)}
      <plugin name='drive' filename='libgazebo_ros_ackermann_drive.so'>{names}
      <linear_velocity_pid_gain>2 0 0</linear_velocity_pid_gain><publish_odom>true</publish_odom>
      <publish_distance>true</publish_distance><publish_steerangle>true</publish_steerangle></plugin>
      <plugin name='slip' filename='libgazebo_ros_wheel_slip.so'>{slip}</plugin></model>
      <model name='puppet'><pose>0 3 1 0 0 0</pose><link name='l'><inertial><mass>1</mass></inertial></link>
      <plugin name='hand' filename='libgazebo_ros_hand_of_god.so'><link_name>l</link_name><frame_id>hog</frame_id>
      </plugin></model></world></sdf>"""


def test_a_car_is_steered_and_a_hand_pulls(start, graph):
    server = start(car())
    server.topic("/odom")
    twist = message_type("geometry_msgs/Twist")()
    twist.linear.x, twist.angular.z = 0.5, 0.3
    graph.publish("/cmd_vel", cdr(twist.kind, fields("geometry_msgs/Twist", "msg")[0]).pack(twist))
    model = attach(server.core).world.ModelByName("car")
    wait_for(lambda: model.WorldAngularVel().Z() > 0.1, server.core.Step)
    wait_for(lambda: server.topic("/steerangle").data > 0.25)
    assert server.topic("/distance").data > 0.0
    for _ in range(1500):
        server.core.Step()
    slip = server.topic("/wheel_slip")
    assert slip.name == ["rear_left"]
    assert abs(slip.longitudinal_slip[0]) < 0.1, slip
    assert graph.taken["/tf_static"]["qos"]["durability"] == "transient_local"
    send_transform(graph, "/tf_static", "world", "x" * 2000, (0.0, 0.0, 0.0))  # which is not kept
    send_transform(graph, "/tf_static", "world", "stage", (0.0, 3.0, 0.5))
    send_transform(graph, "/tf", "stage", "hog_desired", (0.0, 0.0, 1.5))
    puppet = attach(server.core).world.ModelByName("puppet")
    wait_for(lambda: abs(puppet.WorldPose().Pos().Z() - 2.0) < 0.05, server.core.Step)
    (hand,) = server.core.facade.server.plugins.of_model(puppet)
    assert set(hand.plugin.frames) == {"stage", "hog_desired"}


def send_transform(graph, topic, parent, child, place):
    one = message_type("geometry_msgs/TransformStamped")()
    one.header.frame_id, one.child_frame_id, one.transform.rotation.w = parent, child, 1.0
    part = one.transform.translation
    part.x, part.y, part.z = place
    moved = message_type("tf2_msgs/TFMessage")(transforms=[one])
    graph.publish(topic, cdr(moved.kind, fields("tf2_msgs/TFMessage", "msg")[0]).pack(moved))


EYES = """<sdf version='1.6'><world name='default'><model name='wall'><static>true</static><pose>2 0 0 0 0 0</pose>
  <link name='l'><visual name='v'><geometry><box><size>0.2 9 9</size></box></geometry></visual></link></model>
  <model name='m'><static>true</static><link name='head'><sensor name='eye' type='depth'><update_rate>10</update_rate>
  <camera><horizontal_fov>1</horizontal_fov><image><width>32</width><height>24</height></image>
  <clip><near>0.1</near><far>9</far></clip></camera>
  <plugin name='eye_driver' filename='libgazebo_ros_camera.so'><min_depth>0.2</min_depth></plugin>
  </sensor></link></model></world></sdf>"""


def test_a_camera_of_ros2_has_its_sensors_name_depths_and_points(start, graph):
    server = start(EYES)
    image = server.topic("/eye/image_raw")
    assert (image.width, image.height, image.header.frame_id) == (32, 24, "head")
    assert graph.declared["/eye/image_raw"]["node"] == ["/", "eye_driver"]
    depths = {
        name: graph.declared[f"/eye/{name}"]["qos"]["depth"] for name in ("image_raw", "depth/image_raw", "points")
    }
    assert depths == {"image_raw": 5, "depth/image_raw": 5, "points": 1}
    assert server.topic("/eye/camera_info").D.tolist() == [0.0] * 5
    deep = server.topic("/eye/depth/image_raw")
    assert struct.unpack_from("<f", bytes(deep.data), 4 * (12 * 32 + 16))[0] == pytest.approx(1.9, abs=0.01)
    assert server.topic("/eye/points").width == 32
    assert server.topic("/eye/image_raw/compressed").format == "rgb8; jpeg compressed bgr8"


PAIR = """<sdf version='1.6'><world name='default'><model name='m'><static>true</static><link name='head'>
  <sensor name='pair' type='multicamera'><update_rate>10</update_rate>
  <camera name='left'><image><width>16</width><height>12</height></image></camera>
  <camera name='right'><pose>0 -0.1 0 0 0 0</pose><image><width>16</width><height>12</height></image></camera>
  <plugin name='pair_driver' filename='libgazebo_ros_camera.so'><hack_baseline>0.1</hack_baseline></plugin></sensor>
  <sensor name='still' type='camera'><update_rate>10</update_rate><camera><image><width>8</width><height>8</height>
  </image></camera><plugin name='still_driver' filename='libgazebo_ros_camera.so'><triggered>true</triggered></plugin>
  </sensor><sensor name='duo' type='multicamera'><update_rate>10</update_rate>
  <camera name='left'><image><width>8</width><height>8</height></image></camera>
  <camera name='right'><image><width>8</width><height>8</height></image></camera>
  <plugin name='duo_driver' filename='libgazebo_ros_camera.so'><triggered>true</triggered></plugin></sensor>
  </link></model></world></sdf>"""


def test_cameras_of_ros2_are_several_or_triggered(start, graph):
    server = start(PAIR)
    assert server.topic("/pair/left/image_raw").width == 16
    right = server.topic("/pair/right/camera_info")
    assert right.P[3] == pytest.approx(-0.1 * right.P[0])
    images = ("/still/image_raw", "/duo/left/image_raw", "/duo/right/image_raw")
    for topic in images:
        graph.listen(topic)
    for _ in range(500):
        server.core.Step()
    assert not any(graph.received[topic] for topic in images)
    kind = message_type("std_msgs/Empty", 2)
    for topic in ("/still/image_trigger", "/duo/image_trigger"):
        graph.publish(topic, cdr(kind, fields("std_msgs/Empty", "msg")[0]).pack(kind()))
    wait_for(lambda: all(graph.received[topic] for topic in images), server.core.Step)
    for _ in range(500):
        server.core.Step()
    assert [len(graph.received[topic]) for topic in images] == [1, 1, 1]


def test_switches_of_projectors_reach_their_topic_of_gazebo(start, graph):
    server = start(
        f"""<sdf version='1.6'><world name='default'><model name='m'><static>true</static>{BOX}
      <plugin name='p' filename='libgazebo_ros_projector.so'><projector_link>l</projector_link>
      <projector_name>beam</projector_name></plugin></model></world></sdf>"""
    )
    heard = Heard("~/m/l/beam")
    kind = message_type("std_msgs/Bool", 2)
    graph.publish("/switch", cdr(kind, fields("std_msgs/Bool", "msg")[0]).pack(kind(data=True)))
    wait_for(lambda: heard, server.core.Step)
    assert (heard[0].name, heard[0].enabled) == ("texture_projector", True)


def test_what_a_bridge_nests_too_deeply_is_nothing():
    assert bridged._parsed(b"[" * 200_000) is None


def test_a_legacy_world_is_served_in_ros2(start, graph):
    server = start((Path(__file__).parent / "legacy.world").read_text())
    assert server.topic("/robot/odom").child_frame_id == "robot/base_link"
    assert len(server.topic("/laser/scan").ranges) > 100
    twist = message_type("geometry_msgs/Twist")()
    twist.linear.x = 0.4
    graph.publish("/robot/cmd_vel", cdr(twist.kind, fields("geometry_msgs/Twist", "msg")[0]).pack(twist))
    wait_for(lambda: server.topic("/robot/odom").pose.pose.position.x > 0.1)
    goal = message_type("control_msgs/GripperCommand_Goal", 2)()
    goal.command.position = 1.0
    uuid = message_type("unique_identifier_msgs/UUID", 2)(uuid=list(range(16)))
    action, kind = "/gripper/gripper_cmd/_action", "control_msgs/GripperCommand"
    assert server.call(f"{action}/send_goal", f"{kind}_SendGoal", goal_id=uuid, goal=goal).accepted
    done = server.call(f"{action}/get_result", f"{kind}_GetResult", goal_id=uuid)
    assert (done.status, done.result.reached_goal) == (4, True)
    assert "robot" in server.call("/get_model_list", "gazebo_msgs/GetModelList").model_names
    state = server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name="robot")
    assert state.success
    assert not server.call("/get_entity_state", "gazebo_msgs/GetEntityState", name="nobody").success
    assert server.call("/delete_entity", "gazebo_msgs/DeleteEntity", name="robot").success


def test_a_diff_drive_controller_drives_within_its_limits(start, graph, tmp_path):
    graph.refused.add("controller_manager_msgs")
    (tmp_path / "drive.yaml").write_text(DRIVE)
    server = start(wagon(tmp_path / "drive.yaml"))
    describe_robot(server, graph, WAGON)
    assert server.topic("/states/joint_states").name == ["right"]
    dynamic = server.topic("/states/dynamic_joint_states")
    assert dynamic.interface_values[0].interface_names == ["position", "velocity", "effort"]
    kind = message_type("geometry_msgs/TwistStamped")
    command = kind()
    command.twist.linear.x, command.twist.angular.z = 2.0, 0.5
    body = cdr(kind, fields(kind.name, "msg")[0]).pack(command)
    speeds = []
    begin = server.core.GetSimTime()
    while server.core.GetSimTime() < begin + 1.5:
        graph.publish("/drive/cmd_vel", body)
        speeds.append(server.topic("/drive/cmd_vel_out").twist.linear.x)
    assert all(after - before < 0.1 for before, after in pairwise(speeds))
    assert speeds[-1] == pytest.approx(0.5)
    wagon_model = attach(server.core).world.ModelByName("wagon")
    odometry, pose = server.topic("/drive/odom"), wagon_model.WorldPose()
    assert odometry.twist.twist.linear.x == pytest.approx(0.5, abs=0.03)
    assert odometry.twist.twist.angular.z == pytest.approx(0.5, abs=0.05)
    at = odometry.pose.pose.position
    assert (at.x, at.y) == (pytest.approx(pose.Pos().X(), abs=0.02), pytest.approx(pose.Pos().Y(), abs=0.02))
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "base_link")
    assert odometry.pose.covariance[:8].tolist() == [0.1, 0, 0, 0, 0, 0, 0, 0.2]
    assert server.topic("/tf").transforms[0].child_frame_id == "base_link"
    wait_for(lambda: abs(wagon_model.WorldLinearVel().X()) < 0.01, server.core.Step)  # commands are too old


GOOD = {"left_wheel_names": ["left"], "right_wheel_names": ["right"], "wheel_separation": 0.4, "wheel_radius": 0.1}


@pytest.mark.parametrize(
    ("wrong", "why"),
    [
        ({"right_wheel_names": None}, "its joints are None"),
        ({"right_wheel_names": ["right", "left"]}, "there are 1 left wheels, 2 right"),
        ({"wheel_radius": 0.0}, "wheel_separation and wheel_radius must be given and positive"),
        ({"wheel_radius": "wide"}, "wheel_radius is 'wide'; it must be a number"),
        ({"wheel_radius": 10**400}, "wheel_radius is too large a number"),
        ({"linear": {"x": {"has_jerk_limits": True}}}, "min_jerk and max_jerk are -?nan and nan: no limits"),
        ({"angular": {"z": {"has_velocity_limits": True, "max_velocity": -1.0}}}, "are 1 and -1: no limits"),
        ({"pose_covariance_diagonal": [1.0]}, "it must have six numbers"),
    ],
)
def test_a_diff_drive_controller_says_which_parameter_is_wrong(wrong, why):
    with pytest.raises(ParameterError, match=why):
        DiffDrive2("/drive", GOOD | wrong, MagicMock(), MagicMock(), lambda: 0.0, VELOCITY)


@pytest.mark.parametrize(
    ("made", "wrong", "why"),
    [
        (JointStates2, {"joints": [["left"]]}, r"there is no joint \['left'\]"),
        (JointTrajectories2, {"joints": ["left"], "command_interfaces": [["position"]]}, "must be one of position, "),
    ],
)
def test_lists_in_lists_are_no_names(made, wrong, why):
    with pytest.raises(ParameterError, match=why):
        made("/one", wrong, MagicMock(joints={"left": None}), MagicMock(), lambda: 0.0, "")
