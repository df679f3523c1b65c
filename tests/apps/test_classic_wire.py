"""gzserver by the protocol of Gazebo classic: an independent client, and hostile ones."""

import contextlib
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from classic_wire import PATIENCE, Connection, Publication, Subscription, close_all, frame, new, packet, receive, types
from gzserver_process import new_environment

WORLD = """
<sdf version='1.6'><world name='w'>
  <model name='wall'><static>1</static><pose>3 0 0.5 0 0 0</pose><link name='link'>
    <collision name='c'><geometry><box><size>1 10 1</size></box></geometry></collision>
    <visual name='v'><pose>0 0 0.25 0 0 0</pose><geometry><box><size>1 10 1</size></box></geometry>
      <material><diffuse>0.5 0.25 0 1</diffuse></material></visual>
  </link></model>
  <model name='robot'><static>1</static><pose>0 0 0.5 0 0 0</pose><link name='link'>
    <sensor name='laser' type='ray'><always_on>1</always_on><update_rate>20</update_rate><ray>
      <scan><horizontal><samples>3</samples><min_angle>-0.1</min_angle><max_angle>0.1</max_angle></horizontal></scan>
      <range><min>0.1</min><max>10</max></range></ray></sensor>
  </link></model>
</world></sdf>
"""
BALL = """<sdf version='1.6'><model name='ball'><static>1</static><link name='l'>
  <collision name='c'><geometry><sphere><radius>0.5</radius></sphere></geometry></collision></link></model></sdf>"""


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    """(port, process) of a gzserver at a free port."""
    folder = tmp_path_factory.mktemp("server")
    (folder / "w.world").write_text(WORLD)
    environment = {**new_environment(folder), "GAZEBO_MASTER_URI": "http://localhost:0"}
    del environment["GAZEBO_IP"]
    command = [sys.executable, "-u", "-m", "libgz.apps.gzserver", str(folder / "w.world")]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        assert line.startswith("GAZEBO_MASTER_URI=http://127.0.0.1:")
        yield int(line.rpartition(":")[2]), process
        assert process.poll() is None
        process.terminate()
        assert process.wait(20) == 0


@pytest.fixture(autouse=True)
def _closed():
    yield
    close_all()


@pytest.fixture
def master(server):
    found = Connection(server[0])  # and wait for the last topic of the server's start
    eventually(lambda: "/gazebo/w/log/status" in found.ask("get_topics", "topic_list", "GzString_V").data)
    yield found
    found.close()


def eventually(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.05)


def test_a_master_begins_as_that_of_classic(server, master):
    again = Connection(server[0])
    assert [found.type for found in again.first] == ["version_init", "topic_namepaces_init", "publishers_init"]
    version, names, publishers = (
        types()[name].FromString(found.serialized_data)
        for name, found in zip(("GzString", "GzString_V", "Publishers"), again.first, strict=True)
    )
    assert version.data == "gazebo 11.1"  # clients read major and minor, one of them as a float
    assert list(names.data) == ["w"]
    found = {one.topic: one for one in publishers.publisher}
    assert found["/gazebo/w/pose/info"].msg_type == "gazebo.msgs.PosesStamped"
    assert all(one.host == "127.0.0.1" and one.port for one in found.values())
    assert list(again.ask("get_topic_namespaces", "get_topic_namespaces_response", "GzString_V").data) == ["w"]
    assert set(found) <= {one.topic for one in again.ask("get_publishers", "publisher_list", "Publishers").publisher}
    info = again.ask("topic_info", "topic_info_response", "TopicInfo", "/gazebo/w/factory")
    assert [one.topic for one in info.subscriber] == ["/gazebo/w/factory"]
    again.close()


def test_poses_and_statistics_are_published(master):
    poses = Subscription(master, "/gazebo/w/pose/local/info", "PosesStamped")
    found = {pose.name: pose for pose in poses.next().pose}
    assert (found["wall"].position.x, found["wall"].orientation.w, found["wall::link"].position.x) == (3.0, 1.0, 0.0)
    assert found["wall"].id != found["robot"].id
    statistics = Subscription(master, "/gazebo/w/world_stats", "WorldStatistics")
    first = statistics.next()
    later = statistics.until(lambda message: message.iterations > first.iterations)
    assert (later.sim_time.sec, later.sim_time.nsec) > (first.sim_time.sec, first.sim_time.nsec)
    assert later.model_count == 2
    poses.close()
    statistics.close()


def test_a_laser_is_published(master):
    scans = Subscription(master, "/gazebo/w/robot/link/laser/scan", "LaserScanStamped")
    scan = scans.next().scan
    assert scan.count == 3
    assert scan.ranges[1] == pytest.approx(2.5, abs=0.01)
    scans.close()


def test_the_world_is_paused_and_stepped(master):
    control = Publication(master, "/gazebo/w/world_control", "WorldControl")
    statistics = Subscription(master, "/gazebo/w/world_stats", "WorldStatistics")
    control.publish(new("WorldControl", pause=True))
    paused = statistics.until(lambda message: message.paused)
    control.publish(new("WorldControl", multi_step=5))
    stepped = statistics.until(lambda message: message.iterations == paused.iterations + 5)
    assert stepped.paused
    control.publish(new("WorldControl", pause=False))
    statistics.until(lambda message: not message.paused)
    control.close()
    statistics.close()


def test_a_model_is_inserted_moved_and_deleted(master):
    poses = Subscription(master, "/gazebo/w/pose/info", "PosesStamped")
    news = Subscription(master, "/gazebo/w/model/info", "Model")
    factory = Publication(master, "/gazebo/w/factory", "Factory")
    modify = Publication(master, "/gazebo/w/model/modify", "Model")
    requests = Publication(master, "/gazebo/w/request", "Request")
    made = new("Factory", sdf=BALL)
    made.pose.position.x, made.pose.position.y, made.pose.position.z = 0.0, 5.0, 1.0
    made.pose.orientation.x = made.pose.orientation.y = made.pose.orientation.z = 0.0
    made.pose.orientation.w = 1.0
    factory.publish(made)
    model = news.next()
    assert (model.name, model.link[0].name) == ("ball", "ball::l")
    assert model.link[0].collision[0].geometry.sphere.radius == 0.5

    def place(message):
        return next(((p.position.x, p.position.y, p.position.z) for p in message.pose if p.name == "ball"), None)

    poses.until(lambda message: place(message) == (0.0, 5.0, 1.0))
    moved = new("Model", name="ball", id=model.id)
    moved.pose.CopyFrom(made.pose)
    moved.pose.position.y = 7.5
    modify.publish(moved)
    poses.until(lambda message: place(message) == (0.0, 7.5, 1.0))
    requests.publish(new("Request", id=5, request="entity_delete", data="ball"))
    poses.until(lambda message: place(message) is None)
    for end in (poses, news, factory, modify, requests):
        end.close()


def test_a_client_is_given_the_scene(master):
    """What gzclient does at its start."""
    responses = Subscription(master, "/gazebo/w/response", "Response")
    requests = Publication(master, "/gazebo/w/request", "Request")
    requests.publish(new("Request", id=42, request="scene_info"))
    response = responses.until(lambda message: message.id == 42)
    assert (response.request, response.response, response.type) == ("scene_info", "success", "gazebo.msgs.Scene")
    scene = types()["Scene"].FromString(response.serialized_data)
    assert scene.name == "w"
    wall = next(model for model in scene.model if model.name == "wall")
    assert (wall.is_static, wall.pose.position.x) == (True, 3.0)
    [visual] = [visual for visual in wall.link[0].visual if visual.name == "wall::link::v"]
    assert (visual.parent_name, visual.parent_id) == ("wall::link", wall.link[0].id)
    assert visual.geometry.type == types()["Geometry"].BOX
    assert (visual.geometry.box.size.y, visual.pose.position.z) == (10.0, 0.25)
    assert (visual.material.diffuse.r, visual.material.diffuse.g) == (0.5, 0.25)
    # gzclient hangs visuals on those of the entities, by their ids, and shows nothing without these.
    kinds, link = types()["Visual"], wall.link[0]
    for part, kind, parent in (
        (wall, kinds.MODEL, (scene.name, wall.visual[0].parent_id)),
        (link, kinds.LINK, (wall.name, wall.id)),
        (link.collision[0], kinds.COLLISION, (link.name, link.id)),
    ):
        own = part.visual[0]
        assert (own.name, own.id, own.type) == (part.name, part.id, kind)
        assert (own.parent_name, own.parent_id, own.pose) == (*parent, part.pose)
    shown = link.collision[0].visual[1]
    assert (shown.name, shown.geometry) == (f"{link.collision[0].name}__COLLISION_VISUAL__", link.collision[0].geometry)
    assert scene.grid
    assert scene.origin_visual
    responses.close()
    requests.close()


SHOWN = {  # what a client of classic subscribes to when its window opens
    "pose/info": "PosesStamped", "pose/local/info": "PosesStamped", "model/info": "Model", "joint": "Joint",
    "visual": "Visual", "light": "Light", "light/modify": "Light", "factory/light": "Light", "scene": "Scene",
    "request": "Request", "response": "Response", "world_stats": "WorldStatistics", "diagnostics": "Diagnostics",
    "user_cmd_stats": "UserCmdStats", "log/status": "LogStatus", "physics/contacts": "Contacts", "sensor": "Sensor",
    "skeleton_pose/info": "PoseAnimation", "sky": "Sky", "gui": "GUI", "selection": "Selection", "roads": "Road",
}  # fmt: skip
ASKED = {
    "scene_info": "Scene", "physics_info": "Physics", "wind_info": "Wind", "atmosphere_info": "Atmosphere",
    "spherical_coordinates_info": "SphericalCoordinates", "entity_list": "Model_V", "world_sdf": "GzString",
}  # fmt: skip


def test_a_client_s_window_opens(server):
    """The start of gzclient: all topics of its window, all its requests, and what a user does first."""
    master = Connection(server[0])
    eventually(lambda: "/gazebo/w/log/status" in master.ask("get_topics", "topic_list", "GzString_V").data)
    topics = set(master.ask("get_topics", "topic_list", "GzString_V").data)
    assert topics >= {
        f"/gazebo/w/{name}" for name in ("factory", "world_control", "user_cmd")
    }  # the server's subscriptions
    assert list(master.ask("get_topic_namespaces", "get_topic_namespaces_response", "GzString_V").data) == ["w"]
    published = {one.topic: one.msg_type for one in
                 master.ask("get_publishers", "publisher_list", "Publishers").publisher}  # fmt: skip
    shown = {}
    for topic, kind in SHOWN.items():
        name = f"/gazebo/w/{topic}"
        if name in published:
            assert published[name] == f"gazebo.msgs.{kind}"
            shown[topic] = Subscription(master, name, kind)
        else:
            master.send(
                "subscribe", new("Subscribe", topic=name, host="127.0.0.1", port=1, msg_type="", latching=False)
            )
    assert shown.keys() >= {"pose/info", "model/info", "joint", "visual", "light", "factory/light", "scene", "request",
                            "response", "world_stats", "diagnostics", "user_cmd_stats", "log/status"}  # fmt: skip
    used = {
        topic: Publication(master, f"/gazebo/w/{topic}", kind)
        for topic, kind in (("request", "Request"), ("user_cmd", "UserCmd"), ("undo_redo", "UndoRedo"),
                            ("light/modify", "Light"), ("factory/light", "Light"), ("scene", "Scene"),
                            ("visual", "Visual"), ("factory", "Factory"), ("world_control", "WorldControl"))
    }  # fmt: skip
    for number, (request, kind) in enumerate(ASKED.items(), 100):
        used["request"].publish(new("Request", id=number, request=request))
        answer = shown["response"].until(lambda message, number=number: message.id == number)
        assert (answer.request, answer.response, answer.type) == (request, "success", f"gazebo.msgs.{kind}")
        found = types()[kind].FromString(answer.serialized_data)
        if request == "entity_list":
            assert {model.name for model in found.models} >= {"wall", "robot"}
        elif request == "scene_info":
            robot = next(model for model in found.model if model.name == "robot")
            [sensor] = robot.link[0].sensor
            assert (sensor.name, sensor.type, sensor.update_rate, sensor.parent) == (
                "laser",
                "ray",
                20.0,
                "robot::link",
            )
    used["request"].publish(new("Request", id=120, request="entity_info", data="nobody"))
    assert shown["response"].until(lambda message: message.id == 120).response == "nonexistent"
    assert shown["diagnostics"].next().sim_time.nsec > 0
    lamp = new("Light", name="lamp", type="POINT", range=4.0)
    used["factory/light"].publish(lamp)
    assert shown["light"].next().name == "lamp"
    made = new("Factory", sdf=BALL.replace("ball", "toy"))
    used["factory"].publish(made)
    assert shown["model/info"].until(lambda message: message.name == "toy").link[0].name == "toy::l"
    command = new("UserCmd", description="Translate [toy]", type="MOVING")
    moved = command.model.add(name="toy")
    moved.pose.position.x, moved.pose.position.y, moved.pose.position.z = 0.0, 9.0, 1.0
    moved.pose.orientation.x = moved.pose.orientation.y = moved.pose.orientation.z = 0.0
    moved.pose.orientation.w = 1.0
    used["user_cmd"].publish(command)
    assert [one.description for one in shown["user_cmd_stats"].next().undo_cmd] == ["Translate [toy]"]
    assert shown["model/info"].until(lambda message: message.name == "toy").pose.position.y == 9.0
    used["undo_redo"].publish(new("UndoRedo", undo=True))
    assert shown["user_cmd_stats"].next().redo_cmd_count == 1
    at = shown["pose/info"].until(lambda message: any(p.name == "toy" and p.position.y == 0.0 for p in message.pose))
    used["request"].publish(new("Request", id=121, request="entity_delete", data="toy"))
    gone = shown["request"].until(lambda message: message.request == "entity_delete")
    assert (gone.data, len(at.pose)) == ("toy", len({pose.name for pose in at.pose}))
    used["request"].publish(new("Request", id=122, request="entity_delete", data="lamp"))
    shown["request"].until(lambda message: message.data == "lamp")
    for one in (*shown.values(), *used.values(), master):
        one.close()


def test_the_physics_are_set_and_asked_for(master):
    responses = Subscription(master, "/gazebo/w/response", "Response")
    physics = Publication(master, "/gazebo/w/physics", "Physics")
    requests = Publication(master, "/gazebo/w/request", "Request")
    message = new("Physics", iters=77)
    message.gravity.x, message.gravity.y, message.gravity.z = 0.0, 0.0, -1.5
    physics.publish(message)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        requests.publish(new("Request", id=7, request="physics_info"))
        response = responses.until(lambda message: message.id == 7)
        found = types()["Physics"].FromString(response.serialized_data)
        if found.iters == 77:
            break
    assert (found.iters, found.gravity.z) == (77, -1.5)
    for one in (responses, physics, requests):
        one.close()


def test_a_log_is_started_and_stopped(master):
    control = Publication(master, "/gazebo/w/log/control", "LogControl")
    status = Subscription(master, "/gazebo/w/log/status", "LogStatus")
    control.publish(new("LogControl", start=True))
    started = status.until(lambda message: message.log_file.full_path)
    assert started.log_file.full_path.endswith("state.log")
    control.publish(new("LogControl", stop=True))
    status.until(lambda message: not message.log_file.full_path)
    control.close()
    status.close()


def test_a_latching_subscriber_gets_the_last_message_from_before(master):
    requests = Publication(master, "/gazebo/w/request", "Request")
    first = Subscription(master, "/gazebo/w/response", "Response")
    requests.publish(new("Request", id=1001, request="entity_list"))
    first.until(lambda message: message.id == 1001)
    late = Subscription(master, "/gazebo/w/response", "Response", latching=True)
    assert late.next().id == 1001
    for one in (requests, first, late):
        one.close()


def test_a_closed_client_is_forgotten(master):
    other = Connection(master.socket.getpeername()[1])
    other.send("advertise", new("Publish", topic="/a", msg_type="gazebo.msgs.Int", host="127.0.0.1", port=9))
    master.wait("publisher_add", "Publish", lambda message: message.topic == "/a")
    other.close()
    master.wait("publisher_del", "Publish", lambda message: message.topic == "/a")


# Hostile clients ------------------------------------------------------------------------------------------------------


def closed(connection):
    """Whether the other end closes a connection."""
    connection.settimeout(PATIENCE)
    try:
        while connection.recv(1 << 16):
            pass
    except ConnectionError:
        pass
    return True


@pytest.mark.parametrize(
    "data",
    [
        b"GET / HTTP/1.1\r\n\r\n",
        b"-0000001" + b"x" * 100,
        b"ffffffff" + b"x" * 1000,
        b"00000003\xff\xff\xff",
        frame(b"\x0a\x04\x08\x01\x10\x01\x12\x09advertise\x1a\x02\x0a\xff"),
    ],
    ids=["http", "sign", "4 GB", "no packet", "no message"],
)
@pytest.mark.parametrize("topic", [False, True], ids=["master", "topic"])
def test_what_is_no_message_ends_the_connection(master, server, data, topic):
    port = server[0]
    if topic:
        publishers = master.ask("get_publishers", "publisher_list", "Publishers").publisher
        port = next(one.port for one in publishers if one.topic == "/gazebo/w/world_stats")
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(data)
        assert closed(connection)
    test_poses_and_statistics_are_published(master)


def test_half_a_packet_and_silence_hold_up_nobody(master, server):
    whole = packet("request", new("Request", id=1, request="get_topics"))
    with contextlib.ExitStack() as stack:
        halves = [stack.enter_context(socket.create_connection(("127.0.0.1", server[0]))) for _ in range(5)]
        for number, half in enumerate(halves):
            half.sendall(whole[: 3 + 5 * number])
        test_poses_and_statistics_are_published(master)
        halves[0].sendall(whole[3:])  # slow, but valid
        kinds = []
        halves[0].settimeout(PATIENCE)
        while "topic_list" not in kinds:
            kinds.append(types()["Packet"].FromString(receive(halves[0])).type)


@pytest.mark.parametrize("count", [100, pytest.param(1000, marks=pytest.mark.trial)])
def test_many_connections(server, count):
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            stack.enter_context(socket.create_connection(("127.0.0.1", server[0]), timeout=PATIENCE))
        master = Connection(server[0])
        test_poses_and_statistics_are_published(master)


def test_a_subscriber_that_never_reads(master, server):
    """The server's memory stays bounded, and other subscribers get their messages."""
    deaf = [Subscription(master, "/gazebo/w/pose/info", "PosesStamped") for _ in range(20)]
    test_poses_and_statistics_are_published(master)
    used = int(Path(f"/proc/{server[1].pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    assert used < 1 << 30
    for one in deaf:
        one.close()


def test_invalid_commands_are_reported_and_the_world_runs_on(master):
    factory = Publication(master, "/gazebo/w/factory", "Factory")
    factory.publish(new("Factory", sdf="<sdf"))
    factory.socket.sendall(frame(b"\x0a\x01\xff"))
    factory.socket.sendall(frame(b"\xff" * 50))
    test_poses_and_statistics_are_published(master)
    factory.close()
