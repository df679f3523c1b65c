"""Editing worlds of both eras by requests: values, undo and redo, copies, differences, and models held by hand."""

import contextlib
import json
import math
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


MODEL = """<sdf version="{version}"><model name="stone"><link name="l">
  <inertial><mass>3</mass></inertial>
  <collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
  <visual name="v"><geometry><mesh><uri>skin.stl</uri></mesh></geometry></visual>
  <visual name="w"><pose>0 0 1 0 0 0</pose><geometry><sphere><radius>0.1</radius></sphere></geometry></visual>
  </link>
  <link name="top"><pose>0 0 1 0 0 0</pose></link>
  <joint name="turn" type="revolute"><pose>0 0 0 0 0 1</pose><parent>l</parent><child>top</child>
    <axis><xyz>1 0 0</xyz>{axis}<limit><lower>-1</lower><upper>1</upper></limit></axis></joint>
</model></sdf>
"""
INCLUDING = """<sdf version="{version}"><world name="w">
  <include><uri>model://stone</uri></include>
  <!-- the second -->
  <include>
    <uri>model://stone</uri>
    <name>pebble</name>
    <pose>5 0 0 0 0 0</pose>
  </include>
  <model name="pile">
    <include><uri>model://stone</uri><name>inner</name><pose>0 9 0 0 0 0</pose></include>
    <link name="own"/>
  </model>
</world></sdf>
"""


@pytest.fixture
def including(tmp_path, monkeypatch):
    """A function that opens a world with includes."""

    @contextlib.contextmanager
    def opened(version="1.6", model="1.6", axis=""):
        folder = tmp_path / "models" / "stone"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "model.config").write_text("<model><name>stone</name><sdf>model.sdf</sdf></model>")
        (folder / "model.sdf").write_text(MODEL.format(version=model, axis=axis))
        (folder / "skin.stl").write_text("solid a\nendsolid a\n")
        monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path / "models"))
        path = tmp_path / "my.world"
        path.write_text(INCLUDING.format(version=version))
        with libgz.World.from_file(path) as world:
            world.paused = True
            yield Asker(world)

    return opened


def test_an_include_sets_name_pose_and_static(including, tmp_path):
    with including("1.9") as ask:
        before = ask.world.get_state(), ask.world.era.text
        assert (ask.value("pose", name="pebble")["line"], ask.value("static", name="pebble")["line"]) == (7, 4)
        assert ask.value("include", name="pebble")["value"].endswith("stone/model.sdf")
        ask("edit", name="pebble", key="pose", value=[1, 2, 3, 0, 0, 0.5])
        ask("edit", name="pebble", key="static", value=True)
        assert ask.world.model("pebble").static
        assert not ask.world.model("stone").static
        assert ask("edit", name="pebble", key="@name", value="rock")["name"] == "rock"
        assert ask("edit", name="pile::inner", key="pose", value=[0, 3, 0, 0, 0, 0])["name"] == "pile::inner"
        assert ask.world.model("pile::inner").GetPose().pos.y == 3
        ask("write")
        written = (tmp_path / "my.world").read_text()
        for text in ("<name>rock</name>", "<static>true</static>", "<!-- the second -->", "<pose>0 3 0 0 0 0</pose>"):
            assert text in written
        assert written.count("<include>") == 3
        while ask("undo") is not None:
            pass
        assert (ask.world.get_state(), ask.world.era.text) == before


def test_includes_of_one_line_are_known_by_their_names_and_folders(including, monkeypatch):
    first, second = "<include><uri>model://sun</uri></include>", "<include><uri>model://ground_plane</uri></include>"
    pebble = "<include><name>pebble</name><uri>model://stone</uri></include>"
    world = f"<sdf version='1.6'><world name='w'>{first}{second}{pebble}</world></sdf>"
    monkeypatch.setitem(globals(), "INCLUDING", world)
    with including() as ask:
        for name in ("sun", "ground_plane", "pebble"):
            assert ask.value("include", name=name)["value"].endswith("model.sdf")
        ask("edit", name="ground_plane", key="pose", value=[0, 0, 1, 0, 0, 0])
        added = next(line for line in ask("diff")["text"].splitlines() if line.startswith("+<"))
        assert added.replace("<pose>0 0 1 0 0 0</pose>", "") == f"+{world}"


def test_the_pose_of_an_include_is_edited_as_it_is_shown(including, monkeypatch):
    frame = '<frame name="f"><pose>0 4 0 0 0 0</pose></frame>'
    own = '<pose relative_to="f" degrees="true">0 5 0 0 0 90</pose>'
    text = INCLUDING.replace("<pose>0 9 0 0 0 0</pose>", own).replace('name="pile">', f'name="pile">{frame}')
    monkeypatch.setitem(globals(), "INCLUDING", text)
    with including("1.9") as ask:
        shown = ask.value("pose", name="pile::inner")["value"]
        assert shown == pytest.approx([0, 9, 0, 0, 0, math.pi / 2], abs=1e-12)
        edited = [0, 3, 0, 0, 0, 0.5]
        assert ask("edit", name="pile::inner", key="pose", value=edited)["value"] == edited
        assert ask.world.model("pile::inner").GetPose().pos.y == 3


@pytest.mark.parametrize("edited", [True, False])
@pytest.mark.parametrize("own", [True, False])
def test_an_include_is_placed_by_its_pose_once_it_was_moved(including, tmp_path, monkeypatch, edited, own):
    if own:
        monkeypatch.setitem(globals(), "MODEL", MODEL.replace('name="stone"', 'name="stone" placement_frame="top"'))
    else:
        text = INCLUDING.replace("<pose>5 0", "<placement_frame>top</placement_frame><pose>5 0")
        monkeypatch.setitem(globals(), "INCLUDING", text)
    with including("1.9", "1.9") as ask:
        assert ask.value("pose", name="pebble")["value"][:3] == [5, 0, -1]
        if edited:
            ask("edit", name="pebble", key="pose", value=[1, 2, 3, 0, 0, 0])
        else:
            ask("move", name="pebble", pose=[1, 2, 3, 1, 0, 0, 0])
        ask("write")
        with libgz.World.from_file(tmp_path / "my.world") as again:
            assert [*again.model("pebble").GetPose().pos] == [1, 2, 3]


def test_what_an_include_cannot_set_says_where_it_is(including):
    with including("1.9") as ask:
        for content, key, value in (
            ({"name": "pebble"}, "link[l]/inertial/mass", 5),
            ({"name": "pebble", "part": "turn", "kind": "joint"}, "axis/limit/upper", 0.5),
            ({"name": "pile::inner", "part": "l", "kind": "link"}, "inertial/mass", 5),
        ):
            part = {k: v for k, v in content.items() if k != "name"}
            shown = key if part else "self_collide"
            assert "libgz edit" in ask.value(shown, **content)["reason"]
            with pytest.raises(GazeboError, match=r"is in .*stone/model\.sdf, which is included: copy it into"):
                ask("edit", key=key, value=value, **content)
        assert ask("history")["undo"] == []


@pytest.mark.parametrize(
    ("part", "kind", "key"), [("l", "link", "inertial/mass"), ("turn", "joint", "axis/limit/upper")]
)
def test_parts_that_an_included_model_gives_to_the_one_around_say_where_they_are(including, part, kind, key):
    with including() as ask:
        content = {"name": "pile", "part": f"inner::{part}", "kind": kind}
        shown = ask.value(key, **content)
        assert shown["value"] == (3 if kind == "link" else 1)
        assert shown["reason"].endswith("model.sdf`")
        with pytest.raises(GazeboError, match=r"is in .*stone/model\.sdf, which is included: `libgz edit"):
            ask("edit", key=key, value=0.5, **content)
        ask("edit", name="pile", part="own", kind="link", key="inertial/mass", value=7)
        assert ask.world.body("pile", "own").mass == 7
        (copied,) = ask("duplicate", name="pile")
        ask("edit", name=copied, part="inner::l", kind="link", key="inertial/mass", value=4)
        assert ask.world.body(copied, "inner::l").mass == 4


@pytest.mark.parametrize(
    ("version", "model", "axis"),
    [
        ("1.6", "1.6", ""),
        ("1.6", "1.6", "<use_parent_model_frame>1</use_parent_model_frame>"),
        ("1.4", "1.4", ""),
        ("1.7", "1.6", "<use_parent_model_frame>1</use_parent_model_frame>"),
        ("1.9", "1.7", ""),
        ("1.6", "1.9", ""),
    ],
)
def test_an_included_model_is_copied_into_the_world_and_edited_there(including, tmp_path, version, model, axis):
    with including(version, model, axis) as ask:
        before = ask.world.get_state(), ask.world.era.text
        joint = ask.world.model("pebble").sdf_joints["turn"]
        axes = [*joint.axis(0)]
        nested = version > "1.7"  # else the parts of what a model includes are its own
        for name in ("pebble", "pile::inner") if nested else ("pebble",):
            assert ask("embed", name=name) == {"name": name}
            assert all(not row.get("reason") for row in ask("attributes", name=name))
            with pytest.raises(GazeboError, match=r"is in .*my\.world already"):
                ask("embed", name=name)
        assert [*ask.world.model("pebble").sdf_joints["turn"].axis(0)] == pytest.approx(axes, abs=1e-12)
        ask("edit", name="pebble", part="l", kind="link", key="inertial/mass", value=7)
        assert [ask.world.body(name, "l").mass for name in ("stone", "pebble")] == [3, 7]
        ask("write")
        written = (tmp_path / "my.world").read_text()
        assert (written.count("<include>"), written.count("<model name=")) == ((1, 3) if nested else (2, 2))
        assert str(tmp_path / "models/stone/skin.stl") in written
        with libgz.World.from_file(tmp_path / "my.world") as again:
            assert again.body("pebble", "l").mass == 7
            assert [*again.model("pebble").sdf_joints["turn"].axis(0)] == pytest.approx(axes, abs=1e-9)
        while ask("undo") is not None:
            pass
        assert (ask.world.get_state(), ask.world.era.text) == before


def test_comments_stay_where_a_model_is_copied_into_the_world(including, tmp_path, monkeypatch):
    text = MODEL.replace("<mass>3</mass>", "<mass>3</mass> <!-- kg --><!-- weighed -->")
    text = text.replace('  <visual name="w">', '  <!-- a knob -->\n  <visual name="w">')
    monkeypatch.setitem(globals(), "MODEL", text.replace("</model>", "  <!-- the end -->\n</model>"))
    monkeypatch.setitem(globals(), "INCLUDING", INCLUDING.replace("<name>pebble", "<!-- ours -->\n    <name>pebble"))
    with including() as ask:
        ask("embed", name="pebble")
        ask("write")
    lines = [line.strip() for line in (tmp_path / "my.world").read_text().splitlines()]
    for comment, follower in (
        ("<!-- ours -->", "<model name"),
        ("<!-- the second -->", "<!-- ours -->"),
        ("<!-- kg -->", "<!-- weighed -->"),
        ("<!-- weighed -->", "<mass>3</mass>"),
        ("<!-- a knob -->", '<visual name="w">'),
        ("<!-- the end -->", "<joint name"),
    ):
        assert lines[lines.index(comment) + 1].startswith(follower)


def test_a_model_with_a_placement_frame_is_where_it_was_moved(tmp_path):
    path = tmp_path / "my.world"
    links = "<link name='l'/><link name='top'><pose>0 0 1 0 0 0</pose></link>"
    model = f"<model name='m' placement_frame='top'><pose>0 0 5 0 0 0</pose>{links}</model>"
    path.write_text(f"<sdf version='1.9'><world name='w'>{model}</world></sdf>")
    with libgz.World.from_file(path) as world:
        ask = Asker(world)
        assert ask.value("pose", name="m")["value"][:3] == [0, 0, 4]
        ask("edit", name="m", key="pose", value=[1, 2, 3, 0, 0, 0])
        ask("write")
    with libgz.World.from_file(path) as again:
        assert [*again.model("m").GetPose().pos] == [1, 2, 3]


def test_inserted_models_are_moved_in_as_those_around_them(ask, tmp_path):
    sdf = ask.world.sdf is not None
    ask("insert", model="sphere" if sdf else "Pioneer2DX", pose=[5, 0, 0, 1, 0, 0, 0])
    ask("write")
    lines = (tmp_path / "my.world").read_text().splitlines()
    begin, end, inside = (
        ("<model name", "</model>", "<pose") if sdf else ("<model:Pioneer2DX>", "</model:Pioneer2DX>", "<xyz>")
    )
    margins = [
        next(line for line in lines[::-1] if line.strip().startswith(text)).partition("<")[0]
        for text in (begin, inside, end)
    ]
    assert margins == (["    ", "      ", "    "] if sdf else ["  ", "    ", "  "])


def test_what_was_inserted_is_written_as_it_was_given(including, tmp_path):
    """Reading a model makes elements with their defaults, which no file is to be filled with."""
    shape = "<geometry><box><size>1 1 1</size></box></geometry>"
    link = f"<link name='l'><collision name='c'>{shape}</collision><visual name='v'>{shape}</visual></link>"
    with including() as ask:
        [name] = ask("insert", text=f"<sdf version='1.6'><model name='plain'>{link}</model></sdf>")
        ask("duplicate", name=name)
        ask("write")
    text = (tmp_path / "my.world").read_text()
    inserted = text[text.index('<model name="plain">') :]
    assert inserted.count("<model ") == 2
    assert inserted.count("<size>") == 4
    assert [tag for tag in ("<inertial", "<surface", "<ode", "<friction") if tag in inserted] == []


def test_no_world_is_written_that_could_not_be_loaded(ask, tmp_path, monkeypatch, caplog):
    ask("duplicate", name="arm" if ask.world.sdf is not None else "box1")
    before = (tmp_path / "my.world").read_text()
    monkeypatch.setattr("libgz.base.files.LARGEST_FILE", len(before) + 10)
    with pytest.raises(GazeboError):
        ask("write")
    assert "would be larger than" in caplog.text
    assert (tmp_path / "my.world").read_text() == before


def test_what_an_old_file_cannot_say_is_not_copied_into_it(including):
    with including("1.4", "1.6") as ask:
        before = ask.world.get_state(), ask.world.era.text
        with pytest.raises(GazeboError, match=r"would mean something else; convert .*my\.world with `libgz upgrade`"):
            ask("embed", name="pebble")
        assert (ask.world.get_state(), ask.world.era.text) == before


def test_no_copy_makes_a_file_too_large_to_be_loaded(including, monkeypatch):
    with including() as ask:
        monkeypatch.setattr("libgz.base.files.LARGEST_FILE", len(ask.world.era.text) + 100)
        before = ask.world.get_state(), ask.world.era.text
        with pytest.raises(GazeboError, match=r"my\.world would be larger than"):
            ask("embed", name="pebble")
        assert (ask.world.get_state(), ask.world.era.text) == before
        assert ask("history")["undo"] == []


def test_the_file_of_a_model_is_edited_too(including, tmp_path):
    with including():
        pass
    path = tmp_path / "models/stone/model.sdf"
    with libgz.World.from_file(path) as world:
        ask = Asker(world)
        assert ask("attributes", name="") == []
        ask("edit", name="stone", part="l", kind="link", key="inertial/mass", value=7)
        assert ask("write") == str(path)
    assert path.read_text() == MODEL.format(version="1.6", axis="").replace("<mass>3<", "<mass>7<")


@pytest.mark.parametrize("more", ["<old:more/>", "<more xmlns='relative'/>", "<more xml:space='some'/>"])
def test_a_file_that_has_prefixes_without_xmlns_or_slight_slips_is_edited(more, tmp_path):
    path = tmp_path / "my.world"
    path.write_text(SDF.replace("<!-- above -->", more))
    with libgz.World.from_file(path) as world:
        Asker(world)("edit", name="box", key="pose", value=[1, 1, 3, 0, 0, 1])
        Asker(world)("write")
    assert f"<pose>1 1 3 0 0 1</pose>  {more}" in path.read_text()


def test_worldfiles_include_nothing(ask, box):
    with pytest.raises(GazeboError, match="include nothing" if ask.world.sdf is None else "already"):
        ask("embed", name=box)


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


def test_a_model_is_aligned_once_however_often_it_is_named(ask, box, monkeypatch):
    other, moved = "ground" if ask.world.sdf is None else "arm", []
    monkeypatch.setattr(type(ask.world), "SetModelPose", lambda _world, entity, _pose: moved.append(entity.GetId()))
    ask("align", "x", names=[other, *[box] * 100, other])
    assert moved == [box]
    with pytest.raises(GazeboError, match="two or more models"):
        ask("align", "x", names=[box] * 2)


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


def test_an_edited_model_moves_on_as_it_did(ask, box):
    ask.world.paused = False
    body = ask.world.model(box).GetBody()
    ask.world.SetModelPose(ask.world.model(box), libgz.GzPose(libgz.GzVector(0, 5, 3)))
    body.SetLinearVel((1, 0, 2))
    body.SetAngularVel((0, 0.5, 0))
    if ask.world.sdf is not None:
        ask.world.body("arm", "beam").SetAngularVel((0, 2, 0))
    else:
        robot = ask.world.model("robot1")
        ask.world.SetModelPose(robot, libgz.GzPose(libgz.GzVector(-5, 0, 4)))
        robot.bodies[1].SetAngularVel((0, 30, 0))  # a wheel
    ask.step(5)
    key, _ = size(ask)
    edited = [(box, {"key": key, "value": [2, 1.5, 1]})]
    if ask.world.sdf is not None:
        edited += [("arm", {"part": "beam", "kind": "link", "key": "inertial/mass", "value": 2})]
    else:
        edited += [("robot1", {"key": "gravity", "value": False})]
    for name, content in edited:
        before = motion(ask.world.model(name))
        assert any(abs(number) > 0.4 for row in before for number in row[7:])
        ask("edit", name=name, **content)
        for one, other in zip(motion(ask.world.model(name)), before, strict=True):
            assert one == pytest.approx(other, abs=1e-12)
    ask.step(5)


def test_an_edited_light_stays_where_it_was_moved_to(ask):
    if ask.world.sdf is None:
        pytest.skip("lights of worldfiles are models")
    ask("move", name="lamp", pose=[1, 2, 5, 1, 0, 0, 0])
    ask("edit", name="lamp", key="diffuse", value=[0.2, 0.3, 0.4, 1])
    assert [*ask.world.model("lamp").GetPose().pos] == [1, 2, 5]


def motion(model):
    """Poses and velocities of the bodies of a model."""
    return [
        [*body.GetPose().pos, *body.GetPose().rot, *body.GetLinearVel(), *body.GetAngularRate()]
        for body in model.bodies
    ]


def test_an_edited_joint_keeps_its_turns_and_a_moved_link_its_place_in_the_model(tmp_path):
    path = tmp_path / "my.world"
    path.write_text(SDF.replace("<lower>-1</lower><upper>1</upper>", "<lower>-1e16</lower><upper>1e16</upper>"))
    with libgz.World.from_file(path) as world:
        ask = Asker(world)
        joint = world.model("arm").sdf_joints["elbow"]
        joint.set_position(9.0)
        ask.step(2)
        before = joint.position()
        assert before > 8
        ask("edit", name="arm", part="elbow", kind="joint", key="axis/dynamics/damping", value=0.5)
        assert world.model("arm").sdf_joints["elbow"].position() == pytest.approx(before, abs=1e-9)
        base = world.body("arm", "base").GetPose()
        ask("edit", name="arm", part="base", kind="link", key="pose", value=[0, 0, 0.25, 0, 0, 0])
        shift = [a - b for a, b in zip(world.body("arm", "base").GetPose().pos, base.pos, strict=True)]
        assert math.hypot(*shift) == pytest.approx(0.25, abs=1e-6)
