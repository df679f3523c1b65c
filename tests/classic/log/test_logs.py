"""Logs of runs: recording, reading and playback."""

import base64
import bz2
import contextlib
import json
import re
import zlib
from pathlib import Path

import numpy as np
import pytest
from commands import run_libgz
from gzserver_process import new_environment, run
from lxml import etree
from sdf_worlds import GROUND, collision, inertial, link, model, world

import libgz.classic.log.file as log_file
import libgz.classic.log.play as log_play
from libgz.base import budget
from libgz.base.errors import ParameterError, WorldFileError
from libgz.base.geometry import GzPose, GzVector
from libgz.classic import msgs
from libgz.classic.log import LogPlay, LogReader, LogRecord, NamePattern, PlaybackControl, RecordControl, read_states
from libgz.classic.sensors import get_sensor
from libgz.classic.server import attach
from libgz.classic.transport import Node, TopicManager
from libgz.sdf.state import SdfState

BOX = model("box", link("link", inertial(2.0), collision()), pose="0 0 5 0.1 0.2 0.3")
BALL = model("ball", link("link", inertial(2.0), collision("sphere")), pose="3 0 5 0 0 0")
LAMP = "<light name='lamp' type='point'><pose>0 0 4 0 0 0</pose></light>"


@pytest.fixture
def place(tmp_path):
    """The environment of gzserver."""
    return new_environment(tmp_path)


def log_of(path):
    return list(read_states(LogReader(path)))


def poses(core):
    return {link.GetScopedName(): link.body.GetPose() for m in attach(core).world.all_models() for link in m.GetLinks()}


def test_a_log_has_the_motion_of_a_falling_box(load, tmp_path):
    core = load(world(BOX, LAMP))
    core.step(100)
    with LogRecord(core, tmp_path / "deep" / "state.log") as record:
        core.step(400)
    assert record.path.read_text().endswith("</gazebo_log>\n")
    states = log_of(record.path)
    assert [s.iterations for s in states] == list(range(100, 501))
    assert set(states[0].poses) == {"box::link", "lamp"}
    assert set(states[1].poses) == {"box::link"}, "only what moved"
    start = states[0].poses["box::link"].pos.z, states[0].velocities["box::link"][0].z
    for n, state in enumerate(states):
        assert state.sim_time == pytest.approx(0.1 + 0.001 * n, abs=1e-9)
        fallen = start[1] * 0.001 * n - 9.8 * 1e-6 * n * (n + 1) / 2.0
        assert state.poses["box::link"].pos.z == pytest.approx(start[0] + fallen, abs=1e-12)
        assert state.velocities["box::link"][0].z == pytest.approx(start[1] - 9.8e-3 * n, abs=1e-12)


@pytest.mark.parametrize(("encoding", "steps"), [("zlib", 1500), ("bz2", 200), ("txt", 200)])
def test_what_is_played_is_what_was_recorded(load, tmp_path, encoding, steps):
    nested = model("outer", link("base", inertial()), model("inner", link("arm", inertial(), pose="0 0 1 0 0 0")))
    core = load(world(GROUND, BOX, BALL, nested, LAMP))
    seen = []
    with LogRecord(core, tmp_path / "state.log", encoding=encoding):
        core.models[1].GetBody().SetAngularVel((1.0, 2.0, 3.0))
        for _ in range(steps):
            core.step()
            seen.append((core.GetSimTime(), poses(core)))
    with LogPlay(tmp_path / "state.log") as play:
        assert play.core.GetSimTime() == 0.0
        for when, expected in seen:
            assert play.Step()
            assert play.core.GetSimTime() == pytest.approx(when, abs=1e-9)
            for name, pose in poses(play.core).items():
                assert np.array((*pose.pos,)) == pytest.approx(np.array((*expected[name].pos,)), abs=1e-12), name
                same = abs(np.dot((*pose.rot,), (*expected[name].rot,)))
                assert same == pytest.approx(1.0, abs=1e-12), name
        assert play.core.iterations == steps
        assert play.core.paused
        assert not play.Step()


def test_models_come_and_go_as_they_did(load, tmp_path):
    core = load(world(GROUND, BOX))
    view = attach(core).world
    with LogRecord(core, tmp_path / "state.log"):
        core.step(10)
        view.InsertModelString(f"<sdf version='1.6'>{BALL}{LAMP}</sdf>")
        core.step(10)
        view.RemoveModel("box")
        view.InsertModelString(f"<sdf version='1.6'>{model('brief', link())}</sdf>")
        view.RemoveModel("brief")
        view.LightByName("lamp").SetWorldPose(GzPose(GzVector(1, 2, 3)))
        core.step(10)
    states = log_of(tmp_path / "state.log")
    assert [i for i, s in enumerate(states) if s.insertions] == [11]
    assert [(i, s.deletions) for i, s in enumerate(states) if s.deletions] == [(21, ["box"])]
    with LogPlay(tmp_path / "state.log") as play:

        def names():
            return {part.GetName() for part in play.world.children()}

        at_each = []
        while play.Step():
            at_each.append(names())
        assert at_each[9] == {"ground_plane", "box"}
        assert at_each[10] == {"ground_plane", "box", "ball", "lamp"}
        assert at_each[20] == {"ground_plane", "ball", "lamp"}
        assert tuple(play.world.LightByName("lamp").WorldPose().pos) == pytest.approx((1, 2, 3))
        ball = play.world.ModelByName("ball").WorldPose().pos.z
        play.Rewind()
        assert names() == {"ground_plane", "box"}
        play.Seek(0.015)
        assert names() == {"ground_plane", "box", "ball", "lamp"}
        assert play.core.GetSimTime() == pytest.approx(0.015)
        play.StepBack(10)
        assert names() == {"ground_plane", "box"}
        assert play.core.iterations == 5
        play.Forward()
        assert play.core.iterations == 30
        assert play.world.ModelByName("ball").WorldPose().pos.z == pytest.approx(ball, abs=1e-15)
        play.core.Reset()
        assert play.core.GetSimTime() == 0.0
        assert names() == {"ground_plane", "box"}


def test_plugins_do_not_act_in_a_played_world(load, tmp_path):
    loaded = tmp_path / "loaded"
    (tmp_path / "note.py").write_text(
        "from pathlib import Path\nfrom libgz.classic import *\n\n\nclass Note(ModelPlugin):\n"
        f"    def Load(self, model, sdf):\n        file = Path({str(loaded)!r})\n"
        "        file.write_text((file.read_text() if file.exists() else '') + model.GetName())\n\n\n"
        "GZ_REGISTER_MODEL_PLUGIN(Note)\n"
    )
    plugin = "<plugin name='note' filename='note.py'/>"
    box, ball = (text.replace("</model>", f"{plugin}</model>") for text in (BOX, BALL))
    core = load(world(box))
    with LogRecord(core, tmp_path / "state.log"):
        core.step(3)
        attach(core).world.InsertModelString(f"<sdf version='1.6'>{ball}</sdf>")
        core.step(3)
    assert loaded.read_text() == "boxball"
    with LogPlay(tmp_path / "state.log") as play:
        while play.Step():
            pass
        assert {part.GetName() for part in play.world.children()} == {"box", "ball"}
    assert loaded.read_text() == "boxball"


def test_period_and_filter(load, tmp_path):
    core = load(world(BOX, BALL))
    with LogRecord(core, tmp_path / "state.log", period=0.05, filter="b*x"):
        core.step(201)
    states = log_of(tmp_path / "state.log")
    assert [s.iterations for s in states] == [0, 50, 100, 150, 200]
    assert all(set(s.poses) == {"box::link"} for s in states)
    for words, wanted in (("", "ab"), ("b", "b"), ("a|b", "ab"), ("?", "ab"), ("[", ""), ("[a]*", "a")):
        assert "".join(filter(NamePattern(words), "ab")) == wanted
    assert NamePattern("outer")("outer::inner")
    assert NamePattern("outer::inner")("outer::inner::x")
    assert not NamePattern("inner")("outer::inner")


def test_a_reset_is_recorded_too(load, tmp_path):
    core = load(world(BOX))
    with LogRecord(core, tmp_path / "state.log"):
        core.step(5)
        core.Reset()
        core.step(3)
    assert [s.iterations for s in log_of(tmp_path / "state.log")] == [0, 1, 2, 3, 4, 5, 1, 2, 3]


def test_sensors_see_in_a_played_world_what_they_saw(load, tmp_path):
    fan = "<samples>5</samples><min_angle>-0.2</min_angle><max_angle>0.2</max_angle>"
    scan = f"<scan><horizontal>{fan}</horizontal></scan>"
    ray = f"<sensor name='ray' type='ray'><always_on>1</always_on><ray>{scan}<range><max>9</max></range></ray></sensor>"
    watcher = model("watcher", "<static>1</static>", link("link", ray), pose="-4 0 0.5 0 0 0")
    core = load(world(GROUND, watcher, BOX.replace("0 0 5", "0 0 3")))
    sensor = get_sensor("default::watcher::link::ray")
    with LogRecord(core, tmp_path / "state.log"):
        core.step(900)
    expected = list(sensor.Ranges())
    assert min(expected) < 4.0
    core.close()
    with LogPlay(tmp_path / "state.log") as play:
        while play.Step():
            pass
        assert list(get_sensor("default::watcher::link::ray").Ranges()) == pytest.approx(expected, abs=1e-9)


def test_logs_of_gazebo_7_are_read(tmp_path):
    """One as Gazebo 7 writes them: several documents in a chunk, with declarations, scales and wrenches."""
    first = f"<?xml version='1.0'?>\n<sdf version ='1.6'>\n{world(BOX)}</sdf>\n"
    state = (
        "<sdf version='1.6'><state world_name='default'><sim_time>{} 500000000</sim_time><real_time>1 0</real_time>"
        "<wall_time>1400000000 5</wall_time><iterations>{}</iterations><model name='box'><pose>1 2 3 0 -0 0</pose>"
        "<scale>1 1 1</scale><link name='link'><pose>1 2 {} 0 -0 0</pose><velocity>0 0 1 0 -0 0</velocity>"
        "<acceleration>0 0 -9.8 0 -0 0</acceleration><wrench>0 0 -9.8 0 -0 0</wrench></link></model></state></sdf>\n"
    )
    chunks = [
        ("txt", first),
        (
            "zlib",
            base64.b64encode(zlib.compress((state.format(1, 1500, 3) + state.format(2, 2500, 4)).encode())).decode(),
        ),
        ("bz2", base64.b64encode(bz2.compress(state.format(3, 3500, 5).encode())).decode()),
    ]
    body = "".join(f"<chunk encoding='{e}'>\n<![CDATA[{text}]]>\n</chunk>\n" for e, text in chunks)
    header = (
        "<header><log_version>1.0</log_version><gazebo_version>7.0.0</gazebo_version><rand_seed>42</rand_seed></header>"
    )
    path = tmp_path / "state.log"
    path.write_text(f"<?xml version='1.0'?>\n<gazebo_log>\n{header}\n{body}</gazebo_log>\n")
    assert LogReader(path).header == ("1.0", "7.0.0", 42)
    with LogPlay(path) as play:
        heights = [(play.core.GetSimTime(), play.world.ModelByName("box").WorldPose().pos.z)]
        while play.Step():
            heights.append((play.core.GetSimTime(), play.world.ModelByName("box").WorldPose().pos.z))
    assert heights == [(1.5, 3.0), (2.5, 4.0), (3.5, 5.0)]


def test_a_truncated_log_is_read_up_to_its_end(load, tmp_path):
    core = load(world(BOX))
    with LogRecord(core, tmp_path / "state.log", encoding="txt") as record:
        core.step(500)
    text = record.path.read_text()
    cut = tmp_path / "cut.log"
    cut.write_text(text[: text.rindex("<chunk") + 1000])
    states = log_of(cut)
    assert 0 < len(states) < 501
    assert [s.iterations for s in states] == list(range(len(states)))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not a log"),
        ("<sdf version='1.6'/>", "is not a log file"),
        ("<gazebo_log><header/></gazebo_log>", "begins with no world"),
        ("<gazebo_log><header/><chunk encoding='zip'>x</chunk></gazebo_log>", "bad encoding 'zip'; allowed are zlib"),
        ("<gazebo_log><header/><chunk encoding='zlib'>!!</chunk></gazebo_log>", ":1: <chunk>: is damaged"),
        ("<gazebo_log><header/><chunk encoding='bz2'>AAAA</chunk></gazebo_log>", ":1: <chunk>: is damaged"),
    ],
)
def test_an_invalid_log_is_an_error(tmp_path, text, said):
    path = tmp_path / "state.log"
    path.write_text(text)
    with pytest.raises(WorldFileError, match=said):
        LogPlay(path)
    with pytest.raises(WorldFileError, match="cannot be read: No such file"):
        LogReader(tmp_path / "none.log")


@pytest.mark.parametrize("pose", ["0 0 abc 0 0 0", "0 0 nan 0 0 0", "0 0 1e30 0 0 0", "0 0"])
def test_a_damaged_state_names_the_log(load, tmp_path, pose):
    core = load(world(GROUND, model("box", link("l", inertial(1)))))
    with LogRecord(core, tmp_path / "state.log", encoding="txt") as record:
        core.step(3)
    text = record.path.read_text()
    at = text.rindex("<pose>") + len("<pose>")
    record.path.write_text(text[:at] + pose + text[text.index("</pose>", at) :])

    def played():
        with LogPlay(record.path) as play:
            play.Forward()

    with pytest.raises(WorldFileError, match=re.escape(str(record.path))):
        played()


def test_models_without_a_name_are_no_lights(tmp_path):
    text = "<state world_name='w'><model name=''><link name='l'><pose>1 0 0 0 0 0</pose></link></model></state>"
    state = SdfState.parse(etree.fromstring(text))
    again = SdfState.parse(etree.fromstring(state.text("1.6")).find("state"))
    assert list(again.poses) == ["::l"]


@pytest.mark.parametrize("content", [b" " * (4 << 20), b"<a/>" * 20_000, b'<a b="" c="" d=""/>' * 5_000])
@pytest.mark.parametrize("encoding", ["zlib", "bz2"])
def test_a_small_log_that_becomes_large_is_refused(tmp_path, monkeypatch, content, encoding):
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    data = base64.b64encode({"zlib": zlib.compress, "bz2": bz2.compress}[encoding](content)).decode()
    path = tmp_path / "state.log"
    path.write_text(f"<gazebo_log><header/><chunk encoding='{encoding}'>{data}</chunk></gazebo_log>")
    said = r":1: <chunk>: it takes more than 1 MiB decompressed; the environment variable LIBGZ_DECOMPRESSED"
    with pytest.raises(WorldFileError, match=said):
        LogPlay(path)


@pytest.mark.parametrize(
    "what", ["<a/>", "<!---->", "<?a?>", "<header><a/></header>", "<chunk/>", "<chunk><a/></chunk>"]
)
def test_what_a_log_has_beside_its_states_is_not_held(tmp_path, what):
    """The elements of the tree are counted, by way of one that stands behind them."""
    path = tmp_path / "state.log"
    path.write_text(f"<gazebo_log><header/>{what * 50_000}<chunk>last</chunk></gazebo_log>")
    (last,) = (text for _, text in LogReader(path).chunks() if text)
    assert last == "last"
    (last,) = (element for element in LogReader(path)._elements("chunk") if element.text == "last")
    assert sum(1 for _ in last.getroottree().iter()) < 20_000


def test_a_log_that_begins_with_no_element_is_none(tmp_path, monkeypatch):
    path = tmp_path / "state.log"
    monkeypatch.setattr(log_file, "LONGEST_PROLOGUE", 100_000)
    entities = "".join(f"<!ENTITY e{i} 'x'>" for i in range(10_000))
    path.write_text(f"<!DOCTYPE gazebo_log [{entities}]><gazebo_log><header/></gazebo_log>")
    with pytest.raises(WorldFileError, match=":1: is not a log file: it begins with no element"):
        LogReader(path)


def log_of_states(path, states):
    chunks = "".join(f"<chunk encoding='txt'><![CDATA[{text}]]></chunk>" for text in states)
    path.write_text(f"<gazebo_log><header/>{chunks}</gazebo_log>")
    return path


WORLD = "<sdf version='1.6'><world name='w'><model name='m'><link name='l'/></model></world></sdf>"
STATE = "<sdf version='1.6'><state world_name='w'><sim_time>{} 0</sim_time>{}</state></sdf>"
NAMED = "<model name='{}'><link name='l'><pose>0 0 1 0 0 0</pose></link></model>"
INSERTED = "<insertions><model name='n{0}{1}'><link name='l'/></model></insertions>"


@pytest.mark.parametrize(
    ("part", "words"),
    [
        (NAMED.format("{0}{1}"), ("-i",)),
        (NAMED.format("{0}{1}"), ("-o", "new.log", "-z", "0.0001")),
        (INSERTED, ("-o", "new.log", "-z", "0.0001")),
        ("<deletions><name>{0}{1}</name></deletions>", ("-o", "new.log", "-z", "0.0001")),
    ],
)
def test_what_the_states_of_a_log_have_together_is_bounded(tmp_path, monkeypatch, part, words):
    monkeypatch.chdir(tmp_path)
    states = [STATE.format(number, part.format("x" * 10_000, number)) for number in range(300)]
    log_of_states(tmp_path / "state.log", [WORLD, *states])
    assert run_libgz("log", "-f", "state.log", *words).returncode == 0
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    done = run_libgz("log", "-f", "state.log", *words)
    assert done.returncode == 1
    assert done.stderr.startswith("libgz: state.log: it takes more than 1 MiB decompressed; the environment variable")


def test_a_played_log_inserts_no_more_than_its_budget_and_forgets_names(tmp_path, monkeypatch):
    names = [STATE.format(number, NAMED.format(f"a{number}")) for number in range(30)]
    monkeypatch.setattr(log_play, "MOST_NAMES", 10)
    with LogPlay(log_of_states(tmp_path / "names.log", [WORLD, *names])) as play:
        while play.Step():
            assert len(play._parts) <= 10
    many = [STATE.format(number, INSERTED.format("", number)) for number in range(30)]
    monkeypatch.setenv("LIBGZ_DECOMPRESSED", "1")
    monkeypatch.setattr(budget, "ELEMENT", 1 << 14)
    with LogPlay(log_of_states(tmp_path / "many.log", [WORLD, *many])) as play:
        with pytest.raises(WorldFileError, match=r"many.log: state \d+: it takes more than 1 MiB decompressed"):
            play.Forward()
        assert len(play.core.models) < 15
        with pytest.raises(WorldFileError):
            play.Forward()
    gone = "<deletions><name>n{}</name></deletions>"
    taken = [STATE.format(number, INSERTED.format("", number) + gone.format(number - 1)) for number in range(30)]
    with LogPlay(log_of_states(tmp_path / "taken.log", [WORLD, *taken])) as play:
        play.Forward()
        assert [model.GetName() for model in play.world.Models()] == ["m", "n29"]


def test_bad_arguments_and_worlds_that_cannot_be_recorded(load, tmp_path):
    core = load(world(BOX))
    with pytest.raises(ParameterError, match=r"bad log encoding 'gzip'.*allowed are zlib, bz2, txt"):
        LogRecord(core, tmp_path / "state.log", encoding="gzip")
    with pytest.raises(ParameterError, match="bad log period nan s"):
        LogRecord(core, tmp_path / "state.log", period=float("nan"))
    (tmp_path / "file").touch()
    with pytest.raises(WorldFileError, match="cannot be written"):
        LogRecord(core, tmp_path / "file" / "state.log")


def test_a_full_disk_ends_the_log_and_not_the_run(load, tmp_path, caplog):
    core = load(world(BOX))
    with LogRecord(core, tmp_path / "state.log", encoding="txt") as record:
        record._writer._file.close()
        record._writer._file = Path("/dev/full").open("w")  # noqa: SIM115
        core.step(1000)
        assert not record.running
    assert core.iterations == 1000
    assert caplog.text.count("cannot be written: No space left on device; it ends here") == 1


def test_topics_begin_and_end_a_log(load, tmp_path, monkeypatch):
    monkeypatch.setattr("libgz.classic.log.control.STATUS_PERIOD", 0.0)
    core = load(world(BOX))
    control = RecordControl(attach(core).world)
    node, heard = Node(), []
    node.Init("default")
    publisher, subscriber = (
        node.Advertise(msgs.LogControl, "~/log/control"),
        node.Subscribe("~/log/status", heard.append),
    )
    publisher.Publish(msgs.LogControl(start=True, base_path=str(tmp_path / "here"), encoding="txt"))
    core.step(11)
    assert control.record.running
    publisher.Publish(msgs.LogControl(paused=True))
    core.step(1)
    paused = core.iterations
    core.step(5)
    publisher.Publish(msgs.LogControl(stop=True))
    core.step(5)
    assert [bool(message.log_file.full_path) for message in heard] == [True] * (len(heard) - 1) + [False]
    assert len(heard) > 11
    assert heard[0].log_file.full_path == str(tmp_path / "here" / "state.log")
    assert (heard[0].log_file.uri, heard[0].log_file.base_path) == ("127.0.0.1", f"{tmp_path}/here/")
    assert [s.iterations for s in log_of(tmp_path / "here" / "state.log")] == list(range(1, paused))
    subscriber.Unsubscribe()
    control.close()


def test_a_path_that_is_none_does_not_end_the_control_of_logs(load, tmp_path, caplog):
    core = load(world(BOX))
    node = Node()
    node.Init("default")
    with contextlib.closing(RecordControl(attach(core).world)) as control:
        publisher = node.Advertise(msgs.LogControl, "~/log/control")
        for base in ("\0", "x" * 1000, "/proc/self/x"):
            publisher.Publish(msgs.LogControl(start=True, base_path=base))
            core.step(1)
            assert control.record is None
        assert caplog.text.count("cannot be written") == 3
        publisher.Publish(msgs.LogControl(start=True, base_path="/proc/self/x"))
        core.step(1)
        assert caplog.text.count("cannot be written") == 3  # clients can repeat it without end
        publisher.Publish(msgs.LogControl(start=True, base_path=str(tmp_path)))
        core.step(1)
        assert control.record.running
    publisher.Fini()


class Turns:
    """Time for two commands in each update."""

    def begin(self):
        self.left = 2

    def spend(self):
        self.left -= 1


def test_commands_of_playback_wait_when_they_have_had_their_time(load, tmp_path, monkeypatch):
    core = load(world(BOX))
    with LogRecord(core, tmp_path / "state.log") as record:
        core.step(100)
    monkeypatch.setattr(TopicManager.Instance(), "allowance", Turns())
    with LogPlay(record.path) as play, contextlib.closing(PlaybackControl(play)) as control:
        times = []
        monkeypatch.setattr(play, "Seek", times.append)
        for _ in range(3):
            control._received.append(msgs.LogPlaybackControl(seek=msgs.Time(sec=1)))
        control.update()
        assert times == [1.0, 1.0]
        control.update()
        assert times == [1.0, 1.0, 1.0]


def tool(place, *words):
    done = run_libgz(*words, env=place)
    return done.returncode, done.stdout, done.stderr


def test_gzserver_records_and_plays(place, tmp_path):
    path = tmp_path / "w.world"
    path.write_text(f"<sdf version='1.6'>{world(GROUND, BOX, BALL)}</sdf>".replace("'default'", "'hall &amp; yard'"))
    folder = tmp_path / "logs"
    done = run(place, path, "--record_path", folder, "--record_period", 0.01, "--iters", 301, "--seed", 7, "--verbose")
    assert done.returncode == 0, done.stderr
    assert f"recording to [{folder}/state.log]" in done.stderr + done.stdout
    code, said, _ = tool(place, "log", "-f", folder / "state.log", "--json")
    assert code == 0
    assert json.loads(said)["end_time"] > 0.0
    code, said, _ = tool(place, "log", "-f", folder / "state.log")
    assert code == 0
    for line in ("Random Seed:    7", "Duration:       0.300000 s", "Steps:          31", "Encoding:       zlib"):
        assert line in said
    assert "Models:         ball, box, ground_plane" in said
    code, said, _ = tool(place, "log", "-f", folder / "state.log", "-e", "--filter", "box", "-z", 10)
    assert code == 0
    assert said.count('<model name="box">') == 4
    assert "ball" not in said
    assert said.count('<state world_name="hall &amp; yard">') == 4
    played = run(place, "-p", folder / "state.log", "--iters", 99, "--verbose")
    assert played.returncode == 0, played.stderr
    assert f"playing [{folder}/state.log], recorded by libgz" in played.stderr + played.stdout
    assert run(place, "-p", tmp_path / "none.log", "--iters", 1).returncode == 255
    sentence = "libgz: no log file is given; use -f FILE, or -d 1 and -d 0 for a running server\n"
    assert tool(place, "log")[0::2] == (1, sentence)


def test_by_default_logs_lie_in_the_home_folder(place, tmp_path):
    path = tmp_path / "w.world"
    path.write_text(f"<sdf version='1.6'>{world(BOX)}</sdf>")
    assert run(place, path, "-r", "--record_encoding", "bz2", "--iters", 5).returncode == 0
    (found,) = Path(place["HOME"]).glob(".gazebo/log/*/gzserver/state.log")
    assert len(log_of(found)) == 6
