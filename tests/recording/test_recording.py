"""Logs: what they hold, that nothing of it is lost, and that a replay shows the same."""

import base64
import ctypes
import io
import json
import os
import re
import subprocess
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from commands import command_line, run_command, run_libgz
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.JointStates_pb2 import JointStates
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from log_kills import LOST, SLACK, WORLD, kill_while_recording
from mcap.reader import make_reader
from PIL import Image

import libgz
from libgz.base.errors import GazeboError, LibraryError, NotFoundError, ParameterError, ServerError
from libgz.classic import msgs
from libgz.classic.msgs.declare import declare, known_types, message_type
from libgz.interfaces.catalog import INTERFACES
from libgz.interfaces.gripper import GripperDataCvs
from libgz.recording import capture
from libgz.recording.capture import Capture
from libgz.recording.player import Player
from libgz.recording.reader import LogReader
from libgz.recording.schemas import descriptors_of, struct_schema
from libgz.transport.control import ask

ROOT = Path(__file__).parent.parent.parent
ROS_SIZES = {"float64": 8, "float32": 4, "int32": 4, "uint32": 4, "uint16": 2, "uint8": 1, "uint64": 8, "int64": 8}
SERVER_ID = 940_000 + os.getpid()

CAMERA = """<model:SonyVID30><id>cam1</id><xyz>0.3 0 0.4</xyz><imageSize>32 24</imageSize></model:SonyVID30>"""
SDF = """<sdf version="1.6"><world name="default"><include><uri>model://ground_plane</uri></include>
<model name="box"><pose>0 0 2 0 0 0</pose><link name="link"><collision name="c"><geometry><box><size>1 1 1</size></box>
</geometry></collision><visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual>
<sensor name="ray" type="ray"><update_rate>20</update_rate><always_on>1</always_on><ray><scan><horizontal>
<samples>9</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal></scan>
<range><min>0.6</min><max>5</max></range></ray></sensor></link></model></world></sdf>"""


@pytest.fixture
def world():
    with libgz.World.from_string(WORLD, server_id=SERVER_ID) as world:
        yield world


def contents(folder):
    """The bytes of all interface files."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name[0] != "." and "." in path.name[1:]}


def interfaces_of(world):
    return {
        f"{kind}.{name}": bytes(one.memory)
        for (kind, name), one in world.gz_server.interfaces.items()
        if one.descriptor is not None
    }


def record(world, path, steps=50, between=lambda step: None):
    """Record steps of a world; the bytes of all interfaces after each."""
    with Capture(world, path) as log:
        found = [interfaces_of(world)]
        for step in range(steps):
            between(step)
            world.Step()
            log.take()
            found.append(interfaces_of(world))
    return found


# Exact replay ------------------------------------------------------------------------------------------------------


def test_a_replay_shows_the_recorded_bytes(world, tmp_path):
    def command(step):
        if step == 10:
            world.interface("position", "robot1").command(vx=0.3, vyaw=0.2)
        if step == 20:
            world.interface("laser", "laser1").configure(-1.0, 1.0, 5.0, 91)

    expected = record(world, tmp_path / "a.mcap", 60, command)
    poses = world.body("robot1").GetPose()
    world.close()
    with Player(tmp_path / "a.mcap", SERVER_ID) as player, libgz.Observer(SERVER_ID) as observer:
        folder = Path(player.server.path)
        shown = [contents(folder)]
        while player.step():
            shown.append({name: data for name, data in contents(folder).items() if name != "gazebo.pid"})
        shown[0].pop("gazebo.pid", None)
        assert len(shown) == len(expected)
        for before, after in zip(expected, shown, strict=True):
            assert before == after
        assert tuple(observer.pose("robot1::canonical").pos) == tuple(poses.pos)
        assert observer.state().steps == 60


def test_seeking_shows_the_same_as_playing(world, tmp_path):
    expected = record(world, tmp_path / "a.mcap", 40)
    world.close()
    with Player(tmp_path / "a.mcap", SERVER_ID) as player, libgz.Observer(SERVER_ID) as observer:
        folder = Path(player.server.path)
        for step in (30, 7, 40, 0, 21):
            player.seek(step * 0.02)
            assert player.time == pytest.approx(step * 0.02)
            found = contents(folder)
            assert {name: found[name] for name in expected[step]} == expected[step]
            assert observer.state().steps == step
        player.seek(1e9)
        assert player.at_end
        player.seek(-5.0)
        assert player.time == 0.0


def test_models_that_come_and_go(world, tmp_path):
    def change(step):
        if step == 5:
            world.InsertModel("<model:SimpleSolid><id>new</id><xyz>5 0 1</xyz></model:SimpleSolid>")
        if step == 9:
            world.InsertModel(f"<model:Pioneer2DX><id>robot2</id><xyz>0 3 0</xyz>{CAMERA}</model:Pioneer2DX>")
        if step == 15:
            world.DeleteModel("robot2")

    expected = record(world, tmp_path / "a.mcap", 20, change)
    world.close()
    with Player(tmp_path / "a.mcap", SERVER_ID) as player, libgz.Observer(SERVER_ID) as observer:
        folder, seen = Path(player.server.path), []
        for before in expected[1:]:
            player.step()
            found = contents(folder)
            found.pop("gazebo.pid", None)
            assert found == before
            seen.append({entity.id for entity in observer.entities})
        assert "new" not in seen[2]
        assert "new" in seen[6]
        assert "robot2" in seen[10]
        assert "robot2" not in seen[-1]
        player.seek(0.2)
        assert "robot2" in {entity.id for entity in observer.entities}
        player.seek(0.0)
        assert {entity.id for entity in observer.entities} == {"ground", "robot1", "laser1"}


@pytest.mark.parametrize("version", [0x050, 0x060])
def test_wire_versions(tmp_path, version):
    text = WORLD.replace(
        "</model:Pioneer2AT>", CAMERA + "<model:TruthWidget><id>t</id></model:TruthWidget></model:Pioneer2AT>"
    )
    with libgz.World.from_string(text, server_id=SERVER_ID, wire_version=version) as world:
        expected = record(world, tmp_path / "a.mcap", 15)
    with Player(tmp_path / "a.mcap", SERVER_ID, speed=0.0) as player:
        player.run()
        found = contents(Path(player.server.path))
        assert {name: found[name] for name in expected[-1]} == expected[-1]


def test_old_clients_read_a_replay(world, tmp_path):
    record(world, tmp_path / "a.mcap", 30, lambda step: world.interface("position", "robot1").command(vx=0.5))
    ranges = world.interface("laser", "laser1").ranges.copy()
    world.close()
    with Player(tmp_path / "a.mcap", SERVER_ID, speed=0.0) as player, libgz.Client(SERVER_ID, 0) as client:
        laser, sim = client.laser("laser1"), client.sim()
        player.run()
        assert client.wait(timeout=1.0)
        assert sim.sim_time == pytest.approx(0.6)
        np.testing.assert_array_equal(laser.ranges, ranges)


def test_buttons_and_requests(world, tmp_path):
    record(world, tmp_path / "a.mcap", 30)
    world.close()
    with Player(tmp_path / "a.mcap", SERVER_ID) as player, libgz.Client(SERVER_ID, 0) as client:
        sim = client.sim()
        player.seek(0.3)
        sim.data.pause = 1
        player.advance()
        assert player.paused
        player.advance()
        assert player.time == pytest.approx(0.3)
        sim.data.pause = 0
        player.advance()
        assert not player.paused
        sim.data.reset = 1
        player.advance()
        assert player.time < 0.1
        for verb, argument in (("seek", "0.5"), ("speed", "3"), ("rewind", "0.1"), ("step", "2"), ("resume", "-")):
            player._act(verb, argument)
        assert player.status["time"] == pytest.approx(0.44)
        assert player.status["speed"] == 3.0
        assert not player.paused
        with pytest.raises(ParameterError, match="takes a number"):
            player._act("seek", "soon")
        with pytest.raises(ParameterError, match="there are pause, resume"):
            player._act("fly", "-")


# The file ----------------------------------------------------------------------------------------------------------


def fields_size(schema, name=""):
    """The size of a message of ROS 1 without arrays of any length [byte]."""
    parts = re.split(r"={80}\nMSG: ", schema)
    texts = {"": parts[0], **{part.partition("\n")[0]: part.partition("\n")[2] for part in parts[1:]}}

    def size(text):
        total = 0
        for kind, count, _ in re.findall(r"^([\w/]+)(?:\[(\d+)\])? (\w+)$", text, re.MULTILINE):
            total += int(count or 1) * (ROS_SIZES[kind] if kind in ROS_SIZES else size(texts[kind]))
        return total

    return size(texts[name])


@pytest.mark.parametrize(
    "layout",
    [*(kind.data_class for kind in INTERFACES.values()), *INTERFACES["camera"].older.values(), GripperDataCvs],
)
def test_a_struct_is_a_message_without_gaps(layout):
    assert fields_size(struct_schema(layout)) == ctypes.sizeof(layout)


def test_other_programs_read_a_log(world, tmp_path):
    path = tmp_path / "a.mcap"
    record(world, path, 50, lambda step: world.interface("position", "robot1").command(vx=0.5))
    ranges, robot = world.interface("laser", "laser1").ranges.tolist(), world.body("robot1").GetPose()
    wheel = world.joint("robot1", "left_front").GetAngleRate()
    found = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            found[channel.topic] = schema, channel, message
        summary = reader.get_summary()
    assert summary.statistics.channel_message_counts[summary.statistics.channel_count] > 0
    assert summary.statistics.message_count == sum(summary.statistics.channel_message_counts.values())
    schema, channel, message = found["/laser/laser1/scan"]
    assert (schema.name, schema.encoding, channel.message_encoding) == ("foxglove.LaserScan", "protobuf", "protobuf")
    scan = LaserScan.FromString(message.data)
    assert list(scan.ranges) == ranges
    assert scan.frame_id == "laser1::canonical"
    transforms = FrameTransforms.FromString(found["/tf"][2].data).transforms
    mine = next(one for one in transforms if one.child_frame_id == "robot1::canonical")
    assert mine.parent_frame_id == "world"
    assert found["/tf"][2].log_time == 1_000_000_000
    assert mine.timestamp.seconds == 1
    assert mine.timestamp.nanos == 0
    assert (mine.translation.x, mine.translation.y) == pytest.approx((robot.pos.x, robot.pos.y))
    assert mine.rotation.w == pytest.approx(robot.rot.u)
    scene = SceneUpdate.FromString(found["/scene"][2].data)
    assert {entity.frame_id for entity in scene.entities} >= {"robot1::canonical", "laser1::canonical"}
    joints = JointStates.FromString(found["/joint_states"][2].data).joints
    assert next(one.velocity for one in joints if one.name == "robot1::left_front") == pytest.approx(wheel)
    assert found["/position/robot1/odometry"][0].name == "foxglove.Odometry"
    assert found["/power/robot1"][0].encoding == "ros1msg"


def test_the_index_names_the_places_of_chunks_and_their_messages(world, tmp_path):
    path = tmp_path / "a.mcap"
    record(world, path, 60)
    data = path.read_bytes()
    with path.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert chunks
    for chunk in chunks:
        assert data[chunk.chunk_start_offset] == 6  # a chunk
        assert chunk.chunk_length == 9 + int.from_bytes(data[chunk.chunk_start_offset + 1 :][:8], "little")
        at = begin = chunk.chunk_start_offset + chunk.chunk_length
        places = {}
        while data[at] == 7:  # an index of messages
            places[int.from_bytes(data[at + 9 : at + 11], "little")] = at
            at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        assert (places, at - begin) == (chunk.message_index_offsets, chunk.message_index_length)
    with LogReader(path) as log:
        assert f"{log.end - log.begin:.3f} s" in repr(log)


def test_every_message_type_of_classic_has_a_schema():
    declare("test_log.msgs.Wheels", "double left, double right = 2, Vector3d points[], bool on")
    for name in (*known_types(), "test_log.msgs.Wheels"):
        files = descriptor_pb2.FileDescriptorSet.FromString(descriptors_of(message_type(name).DESCRIPTOR))
        pool = descriptor_pool.DescriptorPool()
        for file in files.file:
            pool.Add(file)
        assert pool.FindMessageTypeByName(name)
    kind = message_factory.GetMessageClass(pool.FindMessageTypeByName("test_log.msgs.Wheels"))
    message = message_type("test_log.msgs.Wheels")(left=1.5)
    message.points.add(x=3.0)
    made = kind.FromString(message.SerializeToString())
    assert (made.left, made.right, made.points[0].x) == (1.5, 2.0, 3.0)


def test_textures_of_another_machine(world, tmp_path):
    texture = tmp_path / "grass.png"
    texture.write_bytes((ROOT / "worlds" / "grass.png").read_bytes())
    world.model("ground").GetBody().geoms[0].appearance.change(texture_file=texture)

    def wait(step):
        if step == 2:  # looks are searched for changes at times
            time.sleep(max(0.0, world.publication._next_look - time.monotonic()))

    record(world, tmp_path / "a.mcap", 5, wait)
    world.close()
    content = texture.read_bytes()
    texture.unlink()
    with Player(tmp_path / "a.mcap", SERVER_ID, speed=0.0) as player, libgz.Observer(SERVER_ID) as observer:
        player.run()
        files = [shape.data["texture"]["file"] for shape in observer.shapes if shape.data["texture"]]
        assert [Path(file).read_bytes() for file in files if Path(file).name == "grass.png"] == [content]


# Kills and errors --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_a_killed_server_leaves_a_log(tmp_path, seed):
    assert kill_while_recording(tmp_path, seed, SERVER_ID) <= LOST + SLACK


def test_a_log_that_ends_anywhere_is_read(world, tmp_path):
    path = tmp_path / "a.mcap"
    record(world, path, 30)
    content, short = path.read_bytes(), tmp_path / "short.mcap"
    with LogReader(path) as log:
        assert log.complete
        whole = [(one.channel.topic, one.time, one.data) for one in log.messages()]
    for size in (8, 20, len(content) // 3, len(content) // 2, len(content) - 9, len(content) - 1):
        short.write_bytes(content[:size])
        with LogReader(short) as log:
            found = [(one.channel.topic, one.time, one.data) for one in log.messages()]
            assert not log.complete
            assert found == whole[: len(found)]
    assert len(found) == len(whole)


def test_what_is_no_log(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        LogReader(tmp_path / "none.mcap")
    (tmp_path / "a.mcap").write_text("hello")
    with pytest.raises(ParameterError, match="is no log"):
        LogReader(tmp_path / "a.mcap")
    (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n")
    with pytest.raises(ParameterError, match="not recorded by libgz"):
        Player(tmp_path / "a.mcap", SERVER_ID)


def test_damaged_bytes_raise_errors_of_libgz(world, tmp_path):
    path, bad = tmp_path / "a.mcap", tmp_path / "bad.mcap"
    record(world, path, 20)
    world.close()
    content, dice = path.read_bytes(), np.random.default_rng(7)
    for _ in range(40):
        mutant = bytearray(content)
        for place in dice.integers(8, len(content), 3):
            mutant[place] = dice.integers(256)
        bad.write_bytes(mutant)
        try:
            with Player(bad, SERVER_ID, speed=0.0) as player:
                player.run()
        except GazeboError:
            pass


def test_where_a_log_cannot_be_written(world, tmp_path, monkeypatch):
    with pytest.raises(ParameterError, match="cannot be written: No such file"):
        Capture(world, tmp_path / "no" / "a.mcap")
    monkeypatch.setattr(capture, "_NEEDED", {"no_such_module": "no-such-module"})
    with pytest.raises(LibraryError, match=r"pip install .*mcap"):
        Capture(world, tmp_path / "a.mcap")


def test_a_full_disk_ends_the_log_and_not_the_server(world, caplog, capfd):
    with Capture(world, "/dev/full") as log:
        log._writer.wait(20)
        for _ in range(3):
            world.Step()
            log.take()
    assert "cannot be written any more" in caplog.text
    assert "No space left on device" in capfd.readouterr().err


def test_a_writer_that_is_killed_ends_the_log_and_not_the_server(world, tmp_path, caplog):
    with Capture(world, tmp_path / "a.mcap") as log:
        log._writer.kill()
        log._writer.wait(20)
        for _ in range(3):
            world.Step()
            log.take()
    assert "cannot be written any more" in caplog.text
    world.Step()


# Classic worlds ------------------------------------------------------------------------------------------------------


def test_topics_of_a_classic_world(tmp_path):
    from libgz.classic.transport import Node
    from libgz.recording.topic_player import TopicPlayer

    path = tmp_path / "a.mcap"
    with libgz.World.from_string(SDF) as world:
        publisher = world.facade.server.topics._node.Advertise(msgs.Vector3d, "~/mine")
        with Capture(world, path) as log:
            for step in range(200):
                if step % 50 == 10:
                    publisher.Publish(msgs.Vector3d(x=float(step)))
                world.Step()
                log.take()
        height = world.body("box", "link").GetPose().pos.z
    with LogReader(path) as log:
        names = {channel.topic for channel in log.channels.values() if channel.kind == "topic"}
        scans = list(log.messages(("topic",), ("/gazebo/default/box/link/ray/scan",)))
        assert len(scans) == 4
        mine = [message.data for message in log.messages(("topic",), ("/gazebo/default/mine",))]
    assert {"/gazebo/default/pose/info", "/gazebo/default/world_stats"} <= names
    received = []
    with Player(path, SERVER_ID, speed=0.0, topics=TopicPlayer("default")) as player:
        node = Node()
        node.Init("default")
        held = node.Subscribe("~/mine", received.append)
        player.run()
        with libgz.Observer(SERVER_ID) as observer:
            assert observer.pose("box::link").pos.z == height
        held.Unsubscribe()
    assert [message.SerializeToString() for message in received] == mine


# Commands ------------------------------------------------------------------------------------------------------------


def test_the_commands(tmp_path):
    world, path = tmp_path / "a.world", tmp_path / "a.mcap"
    world.write_text(WORLD)
    words = ("-n", "--steps", 40, "-s", SERVER_ID, "-d", 0, "--mcap", path, world)
    assert run_command("gazebo", *words).returncode == 0
    info = run_libgz("play", path, "--info")
    assert "0.800 s" in info.stdout
    assert "/laser/laser1" in info.stdout
    assert run_libgz("play", path, "--speed", "0", "-s", SERVER_ID).returncode == 0
    with subprocess.Popen(command_line("libgz", "play", path, "-s", SERVER_ID, "--hold", "--pause")) as player:
        try:
            with libgz.Observer(SERVER_ID, timeout=20.0) as observer:
                status = run_libgz("play", "-s", SERVER_ID, "--seek", "0.5", "--speed", "2")
                assert "0.500 s of 0.800 s, speed 2, paused" in status.stdout
                assert observer.state().sim_time == pytest.approx(0.5)
                ask(SERVER_ID, "resume")
                while observer.state().sim_time < 0.8 - 1e-6:
                    pass
        finally:
            player.terminate()
    missing = run_libgz("play", "-s", SERVER_ID, "--status")
    assert missing.returncode == 1
    assert "no server" in missing.stderr
    nothing = run_libgz("play")
    assert nothing.returncode == 1
    assert "no log is given" in nothing.stderr


def test_a_log_that_is_held_at_its_end_can_be_played_again(world, tmp_path):
    record(world, tmp_path / "a.mcap", 5)
    with Player(tmp_path / "a.mcap", SERVER_ID + 1, speed=0.0) as player:
        moments = player.moments(hold=True)
        for _ in range(2):
            while not player.paused:
                next(moments)
            next(moments)
            assert player.at_end
            player.paused = False
            next(moments)
            assert not player.at_end


def test_unknown_topics_are_named(world, tmp_path):
    record(world, tmp_path / "a.mcap", 3)
    with LogReader(tmp_path / "a.mcap") as log, pytest.raises(NotFoundError, match="/laser/laser1"):
        log.topic("/laser/laser2")
    with Player(tmp_path / "a.mcap", SERVER_ID + 1), pytest.raises(ServerError):
        Player(tmp_path / "a.mcap", SERVER_ID + 1)


def test_a_replay_has_the_readings_of_sensors(tmp_path):
    camera = (
        "<model name='eye'><static>1</static><pose>-3 0 2 0 0 0</pose><link name='link'>"
        "<sensor name='cam' type='camera'><always_on>1</always_on><update_rate>20</update_rate><topic>~/picture</topic>"
        "<camera><image><width>24</width><height>16</height></image></camera></sensor></link></model></world>"
    )
    with libgz.World.from_string(SDF.replace("</world>", camera)) as world:
        record(world, tmp_path / "a.mcap", 200)
        ranges = libgz.classic.sensors.get_sensor("ray").Ranges()
    names = ["box::link::ray", "eye::link::cam", "eye::link::other"]
    with Player(tmp_path / "a.mcap", SERVER_ID) as player:
        assert player.readings.answer(names) == {"images": {}, "ranges": {}}
        player.seek(player.reader.end)
        request = json.dumps({"names": names}).encode()
        thread = threading.Thread(target=lambda: found.append(json.loads(ask(SERVER_ID, "readings", content=request))))
        found = []
        thread.start()
        while thread.is_alive():
            player.advance()
    assert list(found[0]["ranges"]) == ["box::link::ray"]
    assert found[0]["ranges"]["box::link::ray"] == [r if np.isfinite(r) else -1.0 for r in ranges]
    image = Image.open(io.BytesIO(base64.b64decode(found[0]["images"]["eye::link::cam"])))
    assert image.size == (24, 16)
    assert np.ptp(np.asarray(image)) > 20  # the box and what is around it
