"""Editing worlds of both eras by requests: values, undo and redo, copies, differences, and models held by hand."""

import contextlib
import json
import random

import pytest

import libgz
from libgz.apps.world_control import WorldControl
from libgz.base.errors import GazeboError
from libgz.simulation import editor
from libgz.transport.control import Request

LEGACY = """<?xml version="1.0"?>
<gz:world xmlns:gz="http://playerstage.sourceforge.net/gazebo/xmlschema/#gz"
  xmlns:model="http://playerstage.sourceforge.net/gazebo/xmlschema/#model">
  <!-- the ground -->
  <model:GroundPlane><id>ground</id></model:GroundPlane>
  <model:SimpleSolid>
    <id>box1</id>   <!-- a box -->
    <xyz>1 2 0.5</xyz>
    <size>1 1 1</size>
  </model:SimpleSolid>
  <model:Pioneer2AT>
    <id>robot1</id>
    <model:SickLMS200><id>laser1</id><xyz>0.1 0 0.2</xyz></model:SickLMS200>
  </model:Pioneer2AT>
</gz:world>
"""
SDF = """<?xml version="1.0"?>
<sdf version="1.6">
  <world name="w">
    <!-- the sun -->
    <light name="lamp" type="point"><pose>0 0 5 0 0 0</pose></light>
    <include><uri>model://ground_plane</uri></include>
    <model name="box">
      <pose>0 0 0.5 0 0 0</pose>  <!-- above -->
      <link name="l">
        <inertial><mass>3</mass></inertial>
        <collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
        <visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual>
      </link>
    </model>
    <model name="arm">
      <pose>3 0 0.5 0 0 0</pose>
      <link name="base"/>
      <link name="beam"><pose>0 0 1 0 0 0</pose></link>
      <joint name="elbow" type="revolute"><parent>base</parent><child>beam</child>
        <axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
    </model>
  </world>
</sdf>
"""


class Asker:
    """Sends requests as a page does, without steps."""

    def __init__(self, world):
        self.world, self.control = world, WorldControl(world)

    def __call__(self, verb, argument="-", **content):
        request = Request(verb, argument, json.dumps(content).encode() if content else b"")
        answer = self.control.obey(request)
        return json.loads(answer) if answer else None

    def step(self, count):
        for _ in range(count):
            self.world.Step()
            self.control.stepped()

    def value(self, key, **content):
        return {row["key"]: row for row in self("attributes", **content)}[key]


@pytest.fixture(params=["legacy", "sdf"])
def ask(request, tmp_path):
    path = tmp_path / "my.world"
    path.write_text(LEGACY if request.param == "legacy" else SDF)
    with libgz.World.from_file(path) as world:
        world.paused = True
        yield Asker(world)


@pytest.fixture
def box(ask):
    return "box" if ask.world.sdf is not None else "box1"


def size(ask):
    return ("link[l]/collision[c]/geometry/box/size", "box") if ask.world.sdf is not None else ("size", "box1")


def edits(ask):
    """Edits of every kind of thing, as requests."""
    key, name = size(ask)
    made = [
        ("edit", "-", {"name": name, "key": key, "value": [2, 1.5, 1]}),
        ("move", "-", {"name": name, "pose": [4, 0, 2, 1, 0, 0, 0]}),
        ("duplicate", "-", {"name": name}),
        ("delete", "-", {"name": name}),
        ("align", "x", {"names": ["ground" if ask.world.sdf is None else "arm", name], "to": "low"}),
    ]
    if ask.world.sdf is None:
        return [
            *made,
            ("edit", "-", {"name": "box1", "key": "xyz", "value": [7, 7, 7]}),
            ("edit", "-", {"name": "robot1", "key": "id", "value": "robot9"}),
            ("edit", "-", {"name": "laser1", "key": "rangeMax", "value": 4.5}),
            ("edit", "-", {"name": "box1", "key": "gravity", "value": False}),
            ("edit", "-", {"name": "", "key": "gravity", "value": [0, 0, -1.6]}),
            ("edit", "-", {"name": "", "key": "stepTime", "value": 0.01}),
            ("insert", "-", {"model": "Pioneer2DX", "pose": [5, 5, 0, 1, 0, 0, 0]}),
        ]
    return [
        *made,
        ("edit", "-", {"name": "box", "key": "pose", "value": [1, 1, 3, 0, 0, 1]}),
        ("edit", "-", {"name": "box", "key": "link[l]/inertial/mass", "value": 12}),
        ("edit", "-", {"name": "box", "part": "l", "kind": "link", "key": "visual[v]/material/diffuse",
                       "value": [1, 0, 0, 1]}),
        ("edit", "-", {"name": "box", "key": "static", "value": True}),
        ("edit", "-", {"name": "box", "key": "@name", "value": "crate"}),
        ("edit", "-", {"name": "arm", "part": "elbow", "kind": "joint", "key": "axis/limit/upper", "value": 0.5}),
        ("edit", "-", {"name": "lamp", "key": "diffuse", "value": [0.2, 0.3, 0.4, 1]}),
        ("light", "-", {"name": "lamp", "color": [1, 0, 0]}),
        ("edit", "-", {"name": "", "key": "gravity", "value": [0, 0, -1.6]}),
        ("edit", "-", {"name": "", "key": "physics/max_step_size", "value": 0.002}),
        ("edit", "-", {"name": "", "key": "physics/ode/solver/iters", "value": 70}),
        ("insert", "-", {"model": "sphere", "pose": [5, 5, 0, 1, 0, 0, 0]}),
    ]  # fmt: skip


@pytest.mark.parametrize("steps", [0, 20])
def test_an_undone_edit_is_bit_equal_to_never_having_edited(ask, steps):
    if steps:
        ask.world.paused = False
        ask.step(steps)
        ask.world.paused = True
        ask.step(1)
    for verb, argument, content in edits(ask):
        before, text = ask.world.get_state(), ask.world.era.text
        ask(verb, argument, **content)
        after = ask.world.get_state()
        assert after != before, content
        label = ask("history")["undo"][-1]
        assert ask("undo")["text"] == label
        assert (ask.world.get_state(), ask.world.era.text) == (before, text), content
        assert ask("redo")["text"] == label
        assert ask.world.get_state() == after, content
        ask("undo")
        assert ask.world.get_state() == before, content
    assert ask("undo") is None
    ask.step(5)
    ask.world.paused = False
    ask.step(5)


def test_all_edits_together_are_undone_redone_and_run(ask):
    before = ask.world.get_state()
    made = edits(ask)
    last = {"delete", "duplicate"}
    made.sort(key=lambda edit: (edit[0] in last, edit[2].get("key") in ("@name", "id")))
    made = [edit for edit in made if edit[2].get("key") not in ("@name", "id")]
    for verb, argument, content in made:
        ask(verb, argument, **content)
    after = ask.world.get_state()
    while ask("undo") is not None:
        pass
    assert ask.world.get_state() == before
    while ask("redo") is not None:
        pass
    assert ask.world.get_state() == after
    ask.world.paused = False
    ask.step(20)
    ask("reset")
    assert ask.world.iterations == 0
    assert len(ask.world.entities) > 3


def test_values_have_types_limits_units_and_lines(ask, box):
    if ask.world.sdf is None:
        row = ask.value("size", name=box)
        assert (row["type"], row["value"], row["unit"], row["above"], row["line"]) == ("vector", [1, 1, 1], "m", 0, 9)
        assert ask.value("shape", name=box)["options"]
        assert ask.value("xyz", name=box)["value"] == [1, 2, 0.5]
        assert "plugin" not in {row["key"] for row in ask("attributes", name=box)}
        assert ask.value("stepTime", name="")["value"] == 0.02
    else:
        row = ask.value("link[l]/inertial/mass", name=box)
        assert (row["type"], row["value"], row["unit"], row["line"]) == ("number", 3, "kg", 10)
        assert ask.value("pose", name=box)["value"][2] == 0.5
        row = ask.value("axis/limit/upper", name="arm", part="elbow", kind="joint")
        assert (row["value"], row["group"]) == (1, "axis / limit")
        assert ask.value("physics/max_step_size", name="")["value"] == 0.001
        assert ask.value("diffuse", name="lamp")["type"] == "color"


def test_what_is_edited_has_its_effect(ask, box):
    if ask.world.sdf is None:
        ask("edit", name="laser1", key="rangeMax", value=4.5)
        ask.world.paused = False
        ask.step(20)
        assert ask.world.interface("laser", "laser1").data.max_range == 4.5
        answer = ask("edit", name="robot1", key="id", value="robot9")
        assert answer == {"value": "robot9", "name": "robot9"}
        assert ask.world.model("laser1").parent is ask.world.model("robot9")
        assert ask.world.interface("position", "robot9")
        ask("edit", name="", key="gravity", value=[0, 0, -1.5])
    else:
        ask("edit", name="box", key="link[l]/inertial/mass", value=12)
        assert ask.world.body("box", "l").mass == 12
        ask("edit", name="box", key="@name", value="crate")
        assert ask.world.model("crate")
        ask("edit", name="", key="gravity", value=[0, 0, -1.5])
        ask("edit", name="", key="physics/max_step_size", value=0.002)
        assert ask.world.engine.step_time == 0.002
    assert ask.world.engine.gravity[2] == -1.5


@pytest.mark.parametrize(
    "content",
    [
        {"key": "no such"},
        {"key": "size", "value": "large"},
        {"key": "size", "value": [float("inf"), 1, 1]},
        {"key": "size", "value": [1] * 500},
        {"key": "size", "value": [-1, 1, 1]},
        {"key": "plugin", "value": "/tmp/x.py"},
        {"key": "gravity", "value": "<evil/>"},
        {"key": "id", "value": "robot1"},
        {"key": "link[l]/collision[c]/geometry/box/size", "value": [0, "x", 1]},
        {"key": "link[l]/inertial/mass", "value": {}},
        {"key": "link[l]/inertial", "value": 1},
        {"key": "/" * 5000, "value": 1},
        {"key": "plugin/@filename", "value": "x.so"},
        {"key": "@name", "value": "arm"},
        {"key": "static", "value": 3},
        {"key": "static"},
    ],
)
def test_wrong_edits_are_refused_and_change_nothing(ask, box, content):
    before, text = ask.world.get_state(), ask.world.era.text
    with pytest.raises(GazeboError) as error:
        ask("edit", name=box, **content)
    assert str(error.value)
    assert (ask.world.get_state(), ask.world.era.text) == (before, text)
    assert ask("history") == {"undo": [], "redo": []}


def test_what_is_included_is_edited_where_it_is(ask):
    if ask.world.sdf is None:
        pytest.skip("worldfiles include nothing")
    with pytest.raises(GazeboError, match=r"included from .*model\.sdf"):
        ask("edit", name="ground_plane", key="static", value=False)


def test_a_difference_is_shown_and_written_with_comments_kept(ask, box, tmp_path):
    assert ask("diff")["text"] == ""
    for verb, argument, content in edits(ask)[:3]:
        ask(verb, argument, **content)
    ask("delete", name="robot1" if ask.world.sdf is None else "arm")
    shown = ask("diff")
    changed = [line for line in shown["text"].splitlines() if line[:1] in "+-" and line[:3] not in ("+++", "---")]
    assert any("2 1.5 1" in line for line in changed)
    assert not any("<!--" in line for line in changed if line[0] == "-" and "above" not in line)
    before = (tmp_path / "my.world").read_text()
    assert ask("write") == str(tmp_path / "my.world")
    assert (tmp_path / "my.world.bak").read_text() == before
    assert ask("diff")["text"] == ""
    names = sorted(entity.GetId() for entity in ask.world.models)
    written = (tmp_path / "my.world").read_text()
    assert all(comment in written for comment in (("the ground", "a box") if ask.world.sdf is None else ("the sun",)))
    with libgz.World.from_file(tmp_path / "my.world") as again:
        assert sorted(model.GetId() for model in again.models) == names
        for name in names:
            found, made = again.model(name).GetPose().pos, ask.world.model(name).GetPose().pos
            assert max(abs(a - b) for a, b in zip(found, made, strict=True)) < 1e-6


def test_inserted_models_are_edited_too_and_stay_at_a_reset(ask, box):
    names = ask("duplicate", name=box)
    key, _ = size(ask)
    ask("edit", name=names[0], key=key, value=[3, 3, 3])
    before = ask.world.get_state()
    ask.world.paused = False
    ask.step(10)
    ask("reset")
    ask.world.paused = True
    assert ask.world.get_state() == before
    assert ask.value(key, name=names[0])["value"] == [3, 3, 3]


def test_many_moves_of_a_hand_are_one_undo_and_the_history_is_bounded(ask, box, monkeypatch):
    before = ask.world.get_state()
    for step in range(5):
        ask("move", name=box, pose=[step, 0, 1, 1, 0, 0, 0])
    assert ask("history")["undo"] == [f"move {box}"]
    ask("undo")
    assert ask.world.get_state() == before
    monkeypatch.setattr(editor, "MOST_MOMENTS", 4)
    key, _ = size(ask)
    for step in range(8):
        ask("edit", name=box, key=key, value=[1 + step, 1, 1])
    assert len(ask("history")["undo"]) == 4
    monkeypatch.setattr(editor, "MOST_BYTES", 10)
    ask("edit", name=box, key=key, value=[5, 1, 1])
    assert len(ask("history")["undo"]) == 1


def test_what_is_held_neither_falls_nor_moves_until_it_is_let_go(ask, box):
    ask.world.paused = False
    ask("hold", "on", name=box, pose=[0, 5, 3, 1, 0, 0, 0])
    heights = []
    for _ in range(20):
        ask.step(1)
        heights.append(ask.world.model(box).GetPose().pos.z)
    body = ask.world.model(box).GetBody()
    assert max(abs(height - 3) for height in heights) < 1e-9
    assert max(map(abs, body.GetLinearVel())) < 1e-9
    ask("hold", "off", name=box)
    ask.step(20)
    assert ask.world.model(box).GetPose().pos.z < 3
    assert body.GetGravityMode()
    assert ask("history")["undo"] == [f"move {box}"]


def test_a_hold_ends_without_its_page(ask, box, monkeypatch):
    ask.world.paused = False
    ask("hold", "on", name=box, pose=[0, 5, 3, 1, 0, 0, 0])
    monkeypatch.setattr("libgz.apps.editing.HOLD", -1.0)
    ask("hold", "on", name=box)
    ask.step(2)
    assert not ask.control.follows
    ask.step(20)
    assert ask.world.model(box).GetPose().pos.z < 3


def test_watchers_edit_nothing(ask):
    control = WorldControl(ask.world, watch_only=True)
    for verb in ("edit", "undo", "redo", "duplicate", "align", "hold", "insert", "delete"):
        with pytest.raises(GazeboError, match="there is no request"):
            control.obey(Request(verb, "-", b""))


def test_random_requests_leave_a_world_that_can_be_undone_to_its_beginning(ask):
    numbers = random.Random(5)
    before = ask.world.get_state()
    for _ in range(40):
        verb, argument, content = numbers.choice(edits(ask))
        content = dict(content)
        if numbers.random() < 0.3 and "value" in content:
            content["value"] = numbers.choice([None, [], "x", 1e300, -1, [1, 2], {"a": 1}])
        with contextlib.suppress(GazeboError):
            ask(verb, argument, **content)
        if numbers.random() < 0.3:
            ask(numbers.choice(["undo", "redo"]))
    while ask("undo") is not None:
        pass
    assert ask.world.get_state() == before


class Stubborn(libgz.Model):
    """A model whose state cannot be saved."""

    STATE = ("odd",)

    def Load(self, file, node):
        self.odd = object()
        self.AddBody(libgz.Body(self.world), True)


def test_a_world_whose_state_cannot_be_saved_is_edited_without_undo(tmp_path):
    path = tmp_path / "my.world"
    path.write_text(
        LEGACY.replace("<model:SimpleSolid>", "<model:Stubborn><id>s</id></model:Stubborn><model:SimpleSolid>", 1)
    )
    world = libgz.World()
    world.legacy.factory.RegisterModel("Stubborn", "Stubborn", Stubborn)
    with world:
        world.LoadFile(path)
        world.Initialize()
        ask = Asker(world)
        ask("edit", name="box1", key="size", value=[2, 2, 2])
        ask("hold", "on", name="box1", pose=[0, 5, 3, 1, 0, 0, 0])
        assert ask.value("size", name="box1")["value"] == [2, 2, 2]
        assert ask("undo") is None
