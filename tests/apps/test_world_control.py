"""What viewers ask of a running world, in both eras."""

import base64
import json
import logging
from collections import deque
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import libgz
from libgz.apps.snapshot_control import SnapshotControl
from libgz.apps.world_control import WorldControl
from libgz.base.errors import GazeboError
from libgz.transport.control import Request

SDF = """<sdf version="1.6"><world name="w"><include><uri>model://ground_plane</uri></include>
<model name="box"><pose>0 0 0.5 0 0 0</pose><link name="l"><inertial><mass>3</mass></inertial><collision name="c">
<geometry><box><size>1 1 1</size></box></geometry></collision></link></model></world></sdf>"""

WITH_LIGHT = """<gz:world xmlns:gz='g' xmlns:model='m'><model:LightSource><id>sun</id></model:LightSource></gz:world>"""


class Asker:
    """Sends requests as a viewer does, and steps the world as a server does."""

    def __init__(self, world):
        self.world, self.control = world, WorldControl(world)

    def __call__(self, verb, argument="-", **content):
        answer = self.control.obey(Request(verb, argument, json.dumps(content).encode() if content else b""))
        self.step(1)
        return json.loads(answer) if answer else None

    def step(self, count):
        for _ in range(count):
            self.world.Step()
            self.control.stepped()


@pytest.fixture(params=["legacy", "sdf"])
def ask(request):
    if request.param == "legacy":
        world = libgz.World.from_file("worlds/pioneer2at.world")
    else:
        world = libgz.World.from_string(SDF)
    with world:
        yield Asker(world)


@pytest.fixture
def name(ask):
    return "crate" if ask.world.sdf is None else "box"


def test_pause_step_and_reset(ask, name):
    ask("pause", "on")
    steps = ask.world.iterations
    ask.step(5)
    assert ask.world.iterations == steps
    ask("step", "3")
    ask.step(10)
    assert ask.world.iterations == steps + 3
    assert ask.world.paused
    ask("reset")
    assert ask.world.GetSimTime() == 0.0
    ask("pause", "off")
    ask.step(2)
    assert ask.world.iterations > 0
    ask("speed", "2.5")
    assert ask.control.speed == ask.world.simSpeed == 2.5


def test_models_are_moved_described_and_deleted(ask, name):
    ask("move", name=name, pose=[5.0, 1.0, 0.6, 2.0, 0.0, 0.0, 0.0])
    pose = ask.world.model(name).GetPose()
    assert np.allclose([pose.pos.x, pose.pos.y], [5.0, 1.0], atol=0.01)
    assert ask("describe", name=name)["mass"] > 0.0
    ask.step(300)
    ask("contacts")
    assert all(len(row) == 7 for row in ask("contacts"))
    assert ask("contacts")
    ask("delete", name=name)
    with pytest.raises(GazeboError, match="there is no model"):
        ask.world.model(name)


def test_models_of_the_catalogue_are_inserted(ask):
    names = ask("catalogue")
    wanted = "Pioneer2DX" if ask.world.sdf is None else "box"
    assert wanted in names
    full = ask("catalogue", "full")
    assert [entry["name"] for entry in full] == names
    assert all(entry["title"] and entry["group"] for entry in full)
    before = len(ask.world.models)
    for place in (3.0, 6.0):
        ask("insert", model=wanted, pose=[place, -4.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    assert len(ask.world.models) == before + 2
    assert [round(model.GetPose().pos.x, 1) for model in ask.world.models[before:]] == [3.0, 6.0]


def test_models_of_installed_worlds_are_inserted(ask):
    names = [name for name in ask("catalogue") if "/" in name and "://" not in name]
    if ask.world.sdf is not None:
        assert not names
        return
    assert {"pioneer2at/robot1", "pioneer2at/crate", "shrimp/robot1"} <= set(names)
    ask("pause", "on")
    for name in names:
        new = ask("insert", model=name, pose=[30.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        assert new
        ask("delete", name=new[0])
    assert ask("insert", model="pioneer2at/robot1") == ["robot2", "laser2"]


PLUGIN = "<plugin name='p' filename='libevil.so'/>"
CONFIG = "<model><name>{0}</name><sdf version='1.6'>model.sdf</sdf></model>"
INCLUDE = "<sdf version='1.6'><world name='w'><include><uri>{}</uri></include></world></sdf>"


@pytest.mark.parametrize("uri", ["{evil}/a", "file://{evil}/a", "model://{evil}/a", "model://../evil/a", "model://b"])
def test_a_page_includes_no_plugins_from_elsewhere(tmp_path, monkeypatch, uri):
    (tmp_path / "models").mkdir()
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path / "models"))
    for place, inside in (
        ("evil/a", PLUGIN),
        ("models/b", f"<include><uri>{tmp_path}/evil/a</uri></include>"),
        ("models/c", PLUGIN),
    ):
        folder = tmp_path / place
        folder.mkdir(parents=True)
        (folder / "model.config").write_text(CONFIG.format("m"))
        (folder / "model.sdf").write_text(
            f"<sdf version='1.6'><model name='{folder.name}'><link name='l'/>{inside}</model></sdf>"
        )
    with libgz.World.from_string(SDF) as world:
        world.attach_era()
        ask, count = Asker(world), len(world.models)
        with pytest.raises(GazeboError, match="a page inserts no plugins but those of models of the model directories"):
            ask("insert", text=INCLUDE.format(uri.format(evil=tmp_path / "evil")), of_page=True)
        assert len(world.models) == count
        assert ask("insert", text=INCLUDE.format("model://c"), of_page=True) == ["c"]
        assert ask("insert", text=INCLUDE.format(tmp_path / "evil" / "a")) == ["a"]  # of a program of the user


CORNERS = {"o": "0 0 5", "x": "200 0 5", "y": "0 100 5", "z": "0 0 305"}  # of a tetrahedron [mm]
FACETS = "".join(
    f"facet normal 0 0 0\nouter loop\n{''.join(f'vertex {CORNERS[one]}{chr(10)}' for one in names)}endloop\nendfacet\n"
    for names in ("oxy", "oyz", "ozx", "xzy")
)
STL = f"solid s\n{FACETS}endsolid s\n".encode()


def test_a_dropped_mesh_becomes_a_model(ask, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    data = base64.b64encode(STL).decode()
    ask("pause", "on")
    for expected in ("mesh_my_part", "mesh_my_part_2"):
        [new] = ask("mesh", file="../My part.STL", data=data, pose=[3.0, 2.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        assert (tmp_path / ".gazebo/models" / expected / "model.config").is_file()
        low, high = np.array([g.bounds() for b in ask.world.model(new).bodies for g in b.geoms], float).reshape(
            -1, 2, 3
        )[0]
        assert np.allclose(high - low, [0.2, 0.1, 0.3], atol=1e-6)  # from millimetres
        assert np.allclose(0.5 * (low + high), [3.0, 2.0, 0.15], atol=0.01)
        assert ask.world.model(new).bodies[0].GetMass().mass == pytest.approx(0.6)
    ask("undo")
    with pytest.raises(GazeboError):
        ask.world.model(new)
    ask("redo")
    assert ask.world.model(new)
    if ask.world.sdf is not None:
        assert "model://mesh_my_part" in ask("catalogue")
    kept = sorted(one.name for one in (tmp_path / ".gazebo/models").iterdir())
    assert kept == ["mesh_my_part", "mesh_my_part_2"]
    for file, content in (
        ("a.png", data),
        ("a.stl", ""),
        ("a.stl", "?"),
        ("a.stl", None),
        ("a.stl", "AAAA"),
        ("a.obj", ""),
    ):
        with pytest.raises(GazeboError, match=r"mesh|empty"):
            ask("mesh", file=file, data=content)
    far = base64.b64encode(b"v 1e300 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n").decode()
    with pytest.raises(GazeboError, match=r"^mesh far\.obj: a vertex lies at 1e\+300; allowed is 1e\+09 at most"):
        ask("mesh", file="far.obj", data=far)
    with pytest.raises(GazeboError, match=r"^mesh a hollow\.stl "):  # not the file in which it was kept
        ask("mesh", file="a hollow.stl", data=base64.b64encode(b"solid s").decode())
    with pytest.raises(GazeboError, match="a pose is seven finite numbers"):
        ask("mesh", file="a.stl", data=data, pose=[1.0])  # after it was kept
    assert sorted(one.name for one in (tmp_path / ".gazebo/models").iterdir()) == kept


def test_rewinding_and_saving(ask, tmp_path, monkeypatch):
    ask("keep", "10")
    ask.step(200)
    ask.world.rewind(0.1)
    if ask.world.sdf is not None:
        monkeypatch.chdir(tmp_path)
        written = ask("write")
        assert "<world" in (tmp_path / "w_saved.world").read_text()
        assert written == str(tmp_path / "w_saved.world")


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("../w", ".._w"),
        ("{tmp_path}/out/w", None),
        ("a/b", "a_b"),
        ("w" * 300, "w" * 80),
        ("my world-1.2", "my world-1.2"),
    ],
)
def test_the_name_of_a_world_names_no_folder(tmp_path, monkeypatch, name, file):
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path / "in")
    text = f"<sdf version='1.6'><world name='{name.format(tmp_path=tmp_path)}'/></sdf>"
    with libgz.World.from_string(text) as world:
        written = Path(Asker(world)("write"))
    assert [*tmp_path.glob("**/*.world")] == [written]
    assert written.parent == tmp_path / "in"
    assert file is None or written.name == f"{file}_saved.world"


@pytest.mark.parametrize(
    ("verb", "argument", "content"),
    [
        ("fly", "-", {}),
        ("pause", "perhaps", {}),
        ("step", "-3", {}),
        ("step", "9999999999", {}),
        ("speed", "nan", {}),
        ("speed", "-1", {}),
        ("move", "-", {"name": "nobody", "pose": [0, 0, 0, 1, 0, 0, 0]}),
        ("move", "-", {"name": "ground_plane", "pose": [0, 0, float("inf"), 1, 0, 0, 0]}),
        ("move", "-", {"name": "ground_plane", "pose": [[0], None, {}, 1, 0, 0, 0]}),
        ("delete", "-", {}),
        ("insert", "-", {"model": "Nothing2000"}),
        ("insert", "-", {"text": "<model:"}),
        ("publish", "~/x", {"type": "no such type"}),
    ],
)
def test_wrong_requests_are_refused_with_a_sentence(ask, verb, argument, content):
    with pytest.raises(GazeboError) as error:
        ask(verb, argument, **content)
    assert str(error.value)


def test_states_have_what_joints_are_held_at():
    with libgz.World.from_file("examples/sdf/gripper.world") as world:
        ask = Asker(world)
        model = next(m for m in world.models if getattr(m, "sdf_joints", None))
        joint = next(n for n, j in model.sdf_joints.items() if j.axes)
        free = world.get_state()
        ask("joint", name=model.GetId(), joint=joint, axis=0, position=0.01)
        held = world.get_state()
        ask.step(30)
        seen = world.engine.states.tobytes()
        ask("pause", "on")
        ask("step", "5")
        with ask.control.replaced():
            world.set_state(free)
        assert not ask.control.follows
        with ask.control.replaced():
            world.set_state(held)
        assert ask.control.follows
        ask.step(30)
        assert world.engine.states.tobytes() == seen
        with pytest.raises(GazeboError), ask.control.replaced():
            world.set_state(b"no state")
        assert ask.control.follows


def test_problems_are_told_once_with_their_place_and_time(tmp_path):
    path = tmp_path / "a.world"
    model = "<model:SimpleSolid><id>a</id><colour>1</colour></model:SimpleSolid>"
    path.write_text(f"<gz:world xmlns:gz='g' xmlns:model='m'>\n{model}</gz:world>")
    with libgz.World.from_file(path) as world:
        ask = Asker(world)
        first = ask("problems", since=0)
        (warning,) = first["problems"]
        assert (warning["level"], warning["file"], warning["line"]) == ("warning", str(path), 2)
        assert "<colour>" in warning["text"]
        assert str(path) not in warning["text"]
        assert first["count"] == 1
        assert ask("problems", since=1) == {"problems": [], "count": 1}
        ask.step(4)
        with world.lock:
            logging.getLogger("libgz.physics").error("a wheel diverged")
        (error,) = ask("problems", since=1)["problems"]
        assert (error["number"], error["level"], error["text"], error["file"]) == (2, "error", "a wheel diverged", "")
        assert error["time"] == pytest.approx(world.clock.sim_time, abs=0.1)
        for wrong in (-5, 10**30, "x", None):
            assert ask("problems", since=wrong)["count"] <= 2


CLOCK = """from libgz.classic import plugin
class Clock(plugin.WorldPlugin):
    def Load(self, world, sdf):
        self.turns, self._hidden, self.ready, self.name = 7.5, 1.0, True, "clock"
plugin.GZ_REGISTER_WORLD_PLUGIN(Clock)
"""


def test_numbers_of_topics_and_plugins_are_read(tmp_path):
    (tmp_path / "clock.py").write_text(CLOCK)
    plugin = f"<plugin name='the clock' filename='{tmp_path}/libclock.so'/></world>"
    with libgz.World.from_string(SDF.replace("</world>", plugin)) as world:
        ask = Asker(world)
        listed = ask("probes")
        [clock] = [one for one in listed if one["group"] == "plugin the clock"]
        assert clock["label"] == "turns"
        stats = {one["label"]: one["key"] for one in listed if one["group"] == "topic /gazebo/w/world_stats"}
        assert {"sim_time.sec", "iterations"} <= set(stats)
        assert not [one for one in ask("probes", name="box") if one["group"] == "plugin the clock"]
        wanted = [clock["key"], stats["iterations"]]
        ask("values", names=wanted)
        ask.step(400)
        answer = ask("values", names=wanted)
        assert answer["values"][clock["key"]] == 7.5
        assert 0 < answer["values"][stats["iterations"]] <= world.iterations
        assert answer["time"] > 0.0
        secret = json.dumps(["plugin", "", "the clock", "_hidden"])
        message = json.dumps(["topic", "/gazebo/w/world_stats", "sim_time"])
        fields = ("iterations[0]", f"sim_time[{'9' * 5000}]", "sim_time.sec.x")
        beside = [json.dumps(["topic", "/gazebo/w/world_stats", field]) for field in fields]
        odd = [secret, message, "[", "[" * 100000, 7, '["topic", "/none", "x"]', "[]", *beside]
        assert ask("values", names=odd)["values"] == {}


def test_numbers_of_legacy_models_are_read():
    with libgz.World.from_file("worlds/pioneer2at.world") as world:
        world.model("robot1").charge = 0.25
        ask = Asker(world)
        [charge] = ask("probes", name="robot1")
        assert ask("values", names=[charge["key"]])["values"] == {charge["key"]: 0.25}


def test_no_request_ends_the_server(monkeypatch, caplog):
    with libgz.World() as world:
        world.Initialize()
        control = SnapshotControl(world)
        nested, failing = Request("insert", "-", b"[" * 200_000), Request("save", "-", b"")
        control._control = SimpleNamespace(waiting=deque((nested, failing)))
        monkeypatch.setattr(type(world), "get_state", lambda _self: 1 // 0)
        control.act()
    assert nested._answer[0] == failing._answer[0] == "error"
    assert b"is no JSON" in nested._answer[1]
    assert b"ZeroDivisionError" in failing._answer[1]
    assert "request 'save' failed" in caplog.text


def test_requests_that_fail_do_not_fill_the_log(monkeypatch, caplog):
    """A page sends 500 a second."""
    with libgz.World() as world:
        world.Initialize()
        control = SnapshotControl(world)
        control._control = SimpleNamespace(waiting=deque(Request("save", "-", b"") for _ in range(150)))
        monkeypatch.setattr(type(world), "get_state", lambda _self: 1 // 0)
        control.act()
    assert caplog.text.count("Traceback") == 2  # the first, and the hundredth


@pytest.mark.parametrize(
    ("verb", "content"),
    [
        ("light", {"color": ["a", "b", "c"]}),
        ("light", {"color": [None] * 3}),
        ("light", {"color": [10**400] * 3}),
        ("light", {}),
        ("move", {"pose": [0.0] * 7}),
        ("move", {"pose": [10**400] * 7}),
        ("move", {"pose": [None] * 7}),
        ("move", {"pose": {}}),
    ],
)
def test_numbers_of_no_use_are_refused_with_a_sentence(verb, content):
    with libgz.World.from_string(WITH_LIGHT) as world, pytest.raises(GazeboError, match="number"):
        Asker(world)(verb, name="sun", **content)


def test_the_smallest_quaternion_is_a_rotation():
    with libgz.World.from_string(WITH_LIGHT) as world:
        Asker(world)("move", name="sun", pose=[1.0, 2.0, 3.0, 5e-324, 0.0, 0.0, 0.0])
        assert [*world.model("sun").GetPose().rot] == [1.0, 0.0, 0.0, 0.0]


def test_pacing_begins_anew_where_a_request_sets_another_time():
    with libgz.World() as world:
        world.Initialize()
        control = SnapshotControl(world)
        assert not control.act()
        begin = world.get_state()
        world.step(100)
        later = world.get_state()
        for state, moved in ((later, False), (begin, True), (later, True)):
            request = Request("restore", "-", state)
            control._control = SimpleNamespace(waiting=deque([request]))
            assert control.act() == moved
            assert request._answer[0] == "ok"
