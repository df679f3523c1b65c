"""Logs whose records are whole and whose contents are hostile are refused with a sentence, and read no other file."""

import base64
import json
import os
import struct

import pytest
from commands import run_libgz

import libgz
from libgz.recording.capture import Capture
from libgz.recording.reader import MAGIC, LogReader

BODIES = """<sdf version="1.6"><world name="w"><model name="m"><link name="l"><visual name="v"><geometry><polyline>
<point>0 0</point><point>1 0</point><point>1 1</point><height>1</height></polyline></geometry></visual></link></model>
</world></sdf>"""
SECRET = "this is nobody's business, and long enough to be found again"


def record(kind, content):
    return struct.pack("<BQ", kind, len(content)) + content


def text(value):
    data = value.encode()
    return struct.pack("<I", len(data)) + data


def pairs(values):
    content = b"".join(text(key) + text(value) for key, value in values.items())
    return struct.pack("<I", len(content)) + content


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """What a log holds: what it says about itself, and the messages of libgz's own topics."""
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    with libgz.World.from_string(BODIES) as world, Capture(world, path) as log:
        world.Step()
        log.take()
    with LogReader(path) as reader:
        return dict(reader.about), [(one.channel.topic, one.data) for one in reader.messages(("own",))]


def write(path, good, change=None, more=()):
    """A log of this, with a change of its scene, and with more channels (topic, what is said of it, message)."""
    about, messages = good
    found = [(topic, {"kind": "own"}, data) for topic, data in messages]
    if change is not None:
        scene = json.loads(next(data for topic, data in messages if topic == "/gz/scene"))
        change(scene)
        data = json.dumps(scene).encode()
        found = [(topic, kind, data if topic == "/gz/scene" else old) for topic, kind, old in found]
    found = sorted([*found, *more], key=lambda one: one[0] != "/gz/scene")
    channels = {topic: (i, said) for i, (topic, said, _) in enumerate(found, start=1)}
    content = b"".join(
        record(4, struct.pack("<HH", i, 0) + text(topic) + text("json") + pairs(said))
        for topic, (i, said) in channels.items()
    )
    content += b"".join(record(5, struct.pack("<HIQQ", channels[topic][0], 0, 0, 0) + data) for topic, _, data in found)
    head = struct.pack("<QQQI", 0, 0, len(content), 0) + text("") + struct.pack("<Q", len(content))
    path.write_bytes(MAGIC + record(12, text("libgz") + pairs(about)) + record(6, head + content))
    return path


def shape(scene):
    return scene["entities"][0]["bodies"][0]["shapes"][0]


def ended(done):
    assert "Traceback" not in done.stderr
    assert not {"\x1b", "\x9b"} & {*done.stdout, *done.stderr}
    return done


def name_data(name):
    def change(scene):
        shape(scene)["data"] = {
            "file": name,
            "arrays": {"vertices": {"type": "uint8", "shape": [len(SECRET)], "offset": 0}},
        }

    return change


def test_a_page_has_no_file_that_a_scene_names_as_data(tmp_path, good):
    """The address of data is that of a file of the played server, not of any file."""
    secret, page = tmp_path / "secret", tmp_path / "page.html"
    secret.write_text(SECRET)
    for name in (str(secret), f"../../../../../../../../..{secret}", 5, "\ud800", ".observer.data.../../../x"):
        log = write(tmp_path / "a.mcap", good, name_data(name))
        done = ended(run_libgz("play", log, "--html", page))
        assert done.returncode == 0, done.stderr
        assert "which is no file of its own" in done.stderr
        assert base64.b64encode(SECRET.encode()).decode() not in page.read_text()


@pytest.mark.parametrize("kind", ["texture", "skin"])
def test_textures_and_skins_of_a_log_are_plain_files(tmp_path, good, kind):
    os.mkfifo(tmp_path / "pipe")
    names = [str(tmp_path / "pipe"), "/dev/zero", "/a\0b", "\ud800", str(tmp_path)]

    def change(scene):
        bodies = scene["entities"][0]["bodies"][0]["shapes"]
        bodies[:] = [{**shape(scene), kind: {"file": name}} for name in names]

    log = write(tmp_path / "a.mcap", good, change)
    done = ended(run_libgz("play", log, "--html", tmp_path / "page.html", timeout=60))
    assert done.returncode == 0, done.stderr
    assert "it is a pipe, not a file" in done.stderr
    assert "it is a device, not a file" in done.stderr


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: scene.pop("others"),
        lambda scene: shape(scene).update(pose=[1.0]),
        lambda scene: shape(scene).update(texture={"file": []}),
        lambda scene: scene["entities"][0].update(sensors=[{"name": "s", "kind": "camera", "body": 0, "topic": 5}]),
        lambda scene: scene.update(sky=5),
        lambda scene: scene.update(gravity=[float("nan")]),
    ],
)
def test_a_page_of_a_damaged_scene_is_refused(tmp_path, good, change):
    log = write(tmp_path / "a.mcap", good, change)
    done = ended(run_libgz("play", log, "--html", tmp_path / "page.html"))
    assert done.returncode == 1
    assert "the log is damaged: a scene is not understood" in done.stderr


@pytest.mark.parametrize(
    ("change", "more"),
    [
        (lambda scene: scene.pop("entities"), ()),
        (lambda scene: scene["entities"][0]["bodies"][0].update(row=999), ()),
        (lambda scene: scene["entities"][0]["bodies"][0].update(row="x"), ()),
        (lambda scene: scene["entities"][0]["bodies"][0].update(id=[]), ()),
        (lambda scene: scene["entities"][0].update(body=77), ()),
        (lambda scene: scene["entities"].append(5), ()),
        (None, [("/position/a", {"kind": "interface"}, b"")]),
        (None, [("/position/a", {"kind": "interface", "type": "position", "id": "a", "version": "x"}, b"")]),
        (None, [("", {"kind": "topic"}, b"")]),
    ],
)
def test_tables_of_a_damaged_log_are_refused(tmp_path, good, change, more):
    log = write(tmp_path / "a.mcap", good, change, more)
    done = ended(run_libgz("export", log, "-o", tmp_path / "out"))
    assert done.returncode == 1
    assert "is damaged" in done.stderr


def test_names_in_a_log_do_not_choose_files(tmp_path, good):
    names = ["../../up", "a\x1b[31m\x9b", "a\nb", "a\0", "\ud800", "a/b", "a_b"]

    def change(scene):
        body = scene["entities"][0]["bodies"][0]
        scene["entities"] = [{**scene["entities"][0], "id": name, "bodies": [{**body}]} for name in names]

    log = write(tmp_path / "a.mcap", good, change)
    done = ended(run_libgz("export", log, "-o", tmp_path / "out"))
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == len(names)
    assert {one.name for one in (tmp_path / "out").iterdir()} == {
        "state..._.._up.l.csv",
        *(rf"state.a{rest}.l.csv" for rest in (r"\x1b[31m\x9b", r"\nb", r"\x00", "_b")),
        r"state.\ud800.l.csv",
        "state.a_b.l_2.csv",
    }


def test_tables_are_not_written_through_links_and_pipes(tmp_path, good):
    log, out, victim = write(tmp_path / "a.mcap", good), tmp_path / "out", tmp_path / "victim"
    out.mkdir()
    for make in (lambda path: path.symlink_to(victim), os.mkfifo):
        make(out / "state.m.l.csv")
        done = ended(run_libgz("export", log, "state.m::l", "-o", out, timeout=60))
        assert done.returncode == 1
        assert "cannot be written" in done.stderr
        (out / "state.m.l.csv").unlink()
    assert not victim.exists()
