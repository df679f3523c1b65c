"""Logs that are small, and large when they are decompressed or parsed, are refused with a sentence."""

import struct
import zlib

import lz4.frame
import pytest
import zstandard
from commands import run_libgz

from libgz.base.budget import VARIABLE
from libgz.base.errors import ParameterError
from libgz.classic import msgs
from libgz.recording.mcap_file import McapFile
from libgz.recording.player import Player
from libgz.recording.reader import MAGIC, LogChannel, LogReader
from libgz.recording.readings import Readings
from libgz.recording.topic_player import TopicPlayer

MIB = 1 << 20
SAID = "takes more than 1 MiB decompressed"
_FOOTER = struct.Struct("<BQQQI")


@pytest.fixture(autouse=True)
def small_budget(monkeypatch):
    monkeypatch.setenv(VARIABLE, "1")


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def message(channel, size, time=0):
    return record(5, struct.pack("<HIQQ", channel, 0, time, time) + bytes(size))


def chunk(content, compression="zstd", size=None):
    pack = {"zstd": zstandard.compress, "lz4": lz4.frame.compress, "": bytes}[compression]
    data, size = pack(content), len(content) if size is None else size
    head = struct.pack("<QQQI", 0, 0, size, zlib.crc32(content))
    return record(6, head + text(compression) + struct.pack("<Q", len(data)) + data)


CHANNEL = record(4, struct.pack("<HH", 1, 0) + text("/a") + text("json") + struct.pack("<I", 0))


def indexed(body):
    """A finished file whose index names the chunk in it."""
    place = len(MAGIC)
    index = struct.pack("<QQQQ", 0, 0, place, len(body)) + struct.pack("<IHQ", 10, 1, 0)
    index += struct.pack("<Q", 0) + text("zstd") + struct.pack("<QQ", 0, 0)
    summary = CHANNEL + record(8, index)
    return MAGIC + body + summary + _FOOTER.pack(2, 20, place + len(body), 0, 0) + MAGIC


def test_a_chunk_within_the_budget_is_read(tmp_path):
    path = tmp_path / "a.mcap"
    for compression in ("zstd", "lz4", ""):
        body = chunk(CHANNEL + message(1, 1000), compression)
        for whole in (True, False):
            path.write_bytes(indexed(body) if whole else MAGIC + body)
            with LogReader(path) as log:
                assert log.complete is whole
                assert [len(one.data) for one in log.messages()] == [1000]
                assert list(log.last(1.0)) == ["/a"]


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_beyond_it_is_refused(tmp_path, compression, whole):
    path = tmp_path / "a.mcap"
    body = chunk(CHANNEL + message(1, 4 * MIB), compression)
    path.write_bytes(indexed(body) if whole else MAGIC + body)
    assert path.stat().st_size < MIB / 8
    ended = run_libgz("play", "--info", path)
    assert ended.returncode == 1
    assert SAID in ended.stderr
    assert "Traceback" not in ended.stderr
    assert f"{path} cannot be read at byte 8" in ended.stderr


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_that_states_too_small_a_size_is_damaged(tmp_path, compression):
    path = tmp_path / "a.mcap"
    path.write_bytes(indexed(chunk(CHANNEL + message(1, 4 * MIB), compression, size=2000)))
    with LogReader(path) as log, pytest.raises(ParameterError, match="has not the 2000 bytes that it states"):
        list(log.messages())


def test_a_chunk_in_the_index_is_not_decompressed(tmp_path):
    body = chunk(CHANNEL + message(1, 100))
    bomb = chunk(bytes(4 * MIB))
    data = indexed(body)
    end = len(data) - _FOOTER.size - len(MAGIC)
    path = tmp_path / "a.mcap"
    path.write_bytes(data[:end] + bomb + data[end:])
    with LogReader(path) as log:
        assert log.complete
        assert len(list(log.messages())) == 1


def test_records_that_state_more_than_the_file_has_are_damage(tmp_path):
    path = tmp_path / "a.mcap"
    for data in (
        MAGIC + struct.pack("<BQ", 6, 1 << 60) + bytes(100),
        MAGIC + chunk(CHANNEL + struct.pack("<BQ", 5, 1 << 60) + bytes(30)),
        MAGIC + record(12, struct.pack("<I", 1 << 31) + b"libgz"),
        MAGIC + _FOOTER.pack(2, 20, 1 << 62, 0, 0) + MAGIC,
    ):
        path.write_bytes(data)
        with LogReader(path) as log:
            assert not log.complete
            assert list(log.messages()) == []


def with_index(path, change):
    """A log of two messages in two chunks, with a change of the index."""
    with path.open("wb") as file:
        log = McapFile(file, "test")
        channel = log.add_channel("/a", "json", 0, {})
        for number in range(2):
            log.add_message(channel, 0, number, number, b"0")
            log.flush()
        change(log._chunks)
        log.finish()


@pytest.mark.parametrize("place", [-1, 30, 1 << 62, (1 << 63) - 1, (1 << 64) - 1])
def test_an_index_that_lies_is_not_used(tmp_path, place):
    def change(chunks):
        if place < 0:
            chunks.extend(chunks * 100)
        else:
            chunks[1].chunk_start_offset = place

    path = tmp_path / "a.mcap"
    with_index(path, change)
    with LogReader(path) as log:
        assert not log.complete
        assert [message.time for message in log.messages()] == [0, 1]


def test_records_are_read_only_if_they_are_needed_and_small(tmp_path):
    path = tmp_path / "a.mcap"
    attachment = struct.pack("<BQ", 9, 1 << 40)
    path.write_bytes(MAGIC + chunk(CHANNEL + message(1, 8)) + attachment)
    with path.open("r+b") as file:
        file.truncate(path.stat().st_size + (1 << 40))  # sparse
    with LogReader(path) as log:
        assert len(list(log.messages())) == 1
    path.write_bytes(MAGIC + struct.pack("<BQ", 6, 2 * MIB) + bytes(2 * MIB))
    with pytest.raises(ParameterError, match=SAID):
        LogReader(path)


def test_zeros_are_no_records(tmp_path):
    path = tmp_path / "a.mcap"
    path.write_bytes(MAGIC + chunk(CHANNEL + message(1, 8)))
    with path.open("r+b") as file:
        file.truncate(1 << 40)  # sparse: as records, they would take days
    with LogReader(path) as log:
        assert len(list(log.messages())) == 1


def test_the_last_messages_of_many_channels_are_bounded(tmp_path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        log = McapFile(file, "test")
        for number in range(1, 5):
            channel = log.add_channel(f"/a{number}", "json", 0, {})
            log.add_message(channel, 0, number, number, bytes(MIB // 2))
            log.flush()
        log.finish()
    with LogReader(path) as log, pytest.raises(ParameterError, match=SAID):
        log.last(1.0)


def schema(number, name="", data=b""):
    return record(3, struct.pack("<H", number) + text(name) + text("") + struct.pack("<I", len(data)) + data)


def channel(number, topic, **about):
    entries = b"".join(text(key) + text(value) for key, value in about.items())
    return record(4, struct.pack("<HH", number, 0) + text(topic) + text("") + struct.pack("<I", len(entries)) + entries)


@pytest.mark.parametrize(
    "content",
    [
        lambda i: schema(i + 1, "s" * (MIB // 2)),
        lambda i: channel(i + 1, "t" * (MIB // 2)),
        lambda i: channel(i + 1, "/a", declaration="d" * (MIB // 2)),
        lambda i: CHANNEL + b"".join(message(number, 0) for number in range(i, 5000 + i)),
    ],
)
def test_what_is_kept_of_all_chunks_is_bounded(tmp_path, content):
    """Each chunk is within its budget, and a file of some KB may have thousands of them."""
    path = tmp_path / "a.mcap"
    path.write_bytes(MAGIC + b"".join(chunk(content(number)) for number in range(5)))
    assert path.stat().st_size < MIB // 4
    with pytest.raises(ParameterError, match=SAID):
        LogReader(path)


def test_images_of_many_topics_are_held_up_to_a_budget():
    held = Readings("default")
    sensors = [{"kind": "camera", "name": f"s{i}", "body": "b", "topic": f"/t{i}"} for i in range(9)]
    held.show({"entities": [{"id": "m", "bodies": [{"id": "b", "name": "l"}], "sensors": sensors}]})
    data = msgs.ImageStamped()
    data.image.width, data.image.height, data.image.data = 300, 300, bytes(3 * 300 * 300)
    for _ in range(2):
        for i in range(9):
            about = {"type": "gazebo.msgs.ImageStamped"}
            held.take(LogChannel(i, f"/t{i}", "topic", "", "protobuf", about), data.SerializeToString())
    names = [f"m::l::s{i}" for i in range(9)]
    assert list(held.answer(names)["images"]) == names[-3:]


def test_damaged_messages_of_a_topic_are_logged_once(caplog):
    player = TopicPlayer("default")
    try:
        for name in ("/gazebo/default/a", "/gazebo/default/b"):
            one = LogChannel(1, name, "topic", "", "protobuf", {"type": "gazebo.msgs.ImageStamped"})
            for _ in range(3):
                player.publish(one, b"\xff")
    finally:
        player.close()
    assert [record.getMessage().split(":")[0] for record in caplog.records] == [
        "topic /gazebo/default/a",
        "topic /gazebo/default/b",
    ]


def test_what_chunks_say_again_is_kept_once(tmp_path):
    path = tmp_path / "a.mcap"
    said = schema(1, "s" * 50_000, bytes(MIB // 2)) + channel(1, "/a", declaration="d" * 50_000)
    said += b"".join(message(number, 0) for number in range(1000))
    path.write_bytes(MAGIC + b"".join(chunk(said) for _ in range(20)))
    with LogReader(path) as log:
        assert [one.topic for one in log.channels.values()] == ["/a"]


def test_a_scene_of_many_small_parts_is_bounded(tmp_path):
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        log = McapFile(file, "test")
        log.add_metadata("libgz", {"format": "1"})
        channel = log.add_channel("/gz/scene", "json", 0, {"kind": "own"})
        log.add_message(channel, 0, 1, 1, b"[" + b"[]," * 50_000 + b"[]]")
        log.finish()
    with pytest.raises(ParameterError, match=SAID):
        Player(path, 941_777)


@pytest.mark.parametrize("name", ["/a/..", "/" + "a" * 5000, "/a/" + "b" * 300])
def test_names_of_files_that_no_folder_can_hold_are_damage(tmp_path, name):
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        log = McapFile(file, "test")
        log.add_metadata("libgz", {"format": "1"})
        scene = log.add_channel("/gz/scene", "json", 0, {"kind": "own"})
        files = log.add_channel("/gz/files", "json", 0, {"kind": "own"})
        log.add_message(files, 0, 1, 1, struct.pack("<I", len(name)) + name.encode() + struct.pack("<I", 1) + b"x")
        log.add_message(scene, 0, 1, 1, b'{"entities": [{"texture": "%b"}]}' % name.encode())
        log.finish()
    with pytest.raises(ParameterError, match=r"the log is damaged: a scene is not understood"):
        Player(path, 941_778)


@pytest.mark.parametrize("limit", ["nan", "-1", "1e400", "0", "²"])
def test_an_invalid_limit_is_no_damage_of_the_file(tmp_path, monkeypatch, limit):
    path = tmp_path / "a.mcap"
    path.write_bytes(indexed(chunk(CHANNEL + message(1, 1000))))
    monkeypatch.setenv(VARIABLE, limit)
    with pytest.raises(ParameterError, match=f"{VARIABLE} is '{limit}'"):
        LogReader(path)
