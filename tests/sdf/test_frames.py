"""Named frames: resolved when a document is read; what cannot be resolved is a warning with its line."""

import math

import pytest
from commands import run_libgz

import libgz
from libgz.base.geometry import GzPose
from libgz.classic import physics
from libgz.sdf import frames
from libgz.sdf.reader import SdfFile

LINK = "<link name='l'/>"


def read(body, version="1.8"):
    return SdfFile.from_string(f"<sdf version='{version}'>\n<world name='w'>\n{body}\n</world></sdf>", "w.sdf")


def warnings(body, version="1.8"):
    found = read(body, version).diagnostics
    assert not found.errors
    return [str(warning) for warning in found.warnings]


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (
            f"<model name='m'>{LINK}\n<link name='k'><pose relative_to='L'>0 0 0 0 0 0</pose></link></model>",
            "w.sdf:4: <pose>: it names frame 'L', which there is not in <model> 'm'; did you mean 'l'?",
        ),
        (
            "<model name='m'><pose relative_to='nowhere'/><link name='l'/></model>",
            "w.sdf:3: <pose>: it names frame 'nowhere', which there is not in <world> 'w'",
        ),
        (
            "<model name='m'><link name='a'><pose relative_to='b'/></link>\n"
            "<link name='b'><pose relative_to='a'/></link></model>",
            "w.sdf:3: <link>: its pose is relative to itself: a -> b -> a",
        ),
        (
            f"<model name='m'>{LINK}<frame name='f' attached_to='g'><pose relative_to='l'/></frame>\n"
            "<frame name='g' attached_to='f'><pose relative_to='l'/></frame></model>",
            "is attached to itself: ",
        ),
        (f"<model name='m'>{LINK}<frame name='f' attached_to='x'/></model>", "attached_to names frame 'x'"),
        (
            f"<model name='m'>{LINK}<joint name='j' type='revolute'><parent>world</parent><child>l</child>"
            "<axis><xyz expressed_in='q'>0 0 1</xyz></axis></joint></model>",
            "<xyz>: expressed_in names frame 'q'",
        ),
        (f"<model name='m' placement_frame='sole'>{LINK}</model>", "placement_frame names frame 'sole'"),
        (
            "<model name='m'><pose relative_to='m::l'/><link name='l'/></model>",
            "its pose is relative to itself: m -> m",
        ),
    ],
)
def test_names_that_lead_nowhere_are_warnings(body, said):
    found = warnings(body)
    assert any(said in error for error in found)
    assert all(warning.startswith("w.sdf:") for warning in found)


def test_an_unknown_frame_of_1_6_is_a_warning_and_an_empty_one_is_none():
    body = "<model name='m'><link name='l'><pose frame='{}'>1 0 0 0 0 0</pose></link></model>"
    assert "names frame 'base'" in warnings(body.format("base"), "1.6")[0]
    assert read(body.format(""), "1.6").diagnostics.found == {}


def test_poses_of_names_that_lead_nowhere_stay_as_they_are_written():
    link = "<link name='{}'><pose relative_to='{}'>{} 0 0 0 0 0</pose></link>"
    links = "".join(map(link.format, "abcde", ("", "nowhere", "b", "e", "d"), (1, 2, 3, 4, 5)))
    root = read(f"<model name='m'><pose relative_to='lost'>9 0 0 0 0 0</pose>{links}</model>").root
    model = root.child("world").child("model")
    assert model.Get(GzPose, "pose").pos.x == 9.0
    assert [found.Get(GzPose, "pose").pos.x for found in model.named("link")] == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("link", ["<link/>", "<link name='l'/>"])
def test_links_of_a_world_are_warnings_beside_its_joints(link):
    body = f"<joint name='j' type='fixed'><parent>l</parent><child>m::l</child></joint>\n{link}"
    assert any(w.startswith("w.sdf:4: <link>: is not part of SDF 1.8 in <world>") for w in warnings(body))


def test_a_canonical_link_that_is_not_there_is_replaced_by_the_first_one(caplog):
    frame = "<frame name='f'/><joint name='j' type='fixed'><parent>world</parent><child>f</child></joint>"
    text = f"<sdf version='1.7'><model name='m' canonical_link='x'>{LINK}{frame}</model></sdf>"
    with libgz.World.from_string(text) as world:
        assert world.model("m").sdf_joints["j"].child is world.model("m").links["l"]
    assert "canonical_link is 'x'; it must be a link; the first one is used" in caplog.text


def test_documents_have_plain_poses_afterwards():
    root = read(
        "<frame name='f'><pose>1 0 0 0 0 0</pose></frame>"
        "<model name='m'><pose relative_to='f'>0 1 0 0 0 0</pose><link name='l'/></model>"
    ).root
    pose = root.child("world").child("model").child("pose")
    assert not pose.HasAttribute("relative_to")
    assert tuple(pose.Get(GzPose).pos) == (1, 1, 0)


def test_the_model_frame_follows_its_canonical_link():
    text = (
        "<sdf version='1.7'><world name='w'><gravity>0 0 0</gravity><model name='m' canonical_link='b'>"
        "<link name='a'/><link name='b'><pose>1 0 0 0 0 0</pose></link></model></world></sdf>"
    )
    with libgz.World.from_string(text) as world:
        model = world.model("m")
        model.GetBody("b").SetLinearVel((0, 1, 0))
        model.GetBody("a").SetLinearVel((0, 0, 5))
        world.step(1000)
        assert tuple(model.GetPose().pos) == pytest.approx((0, 1, 0), abs=1e-6)


def test_a_merged_model_keeps_its_frames(tmp_path, monkeypatch):
    folder = tmp_path / "part"
    folder.mkdir()
    (folder / "model.config").write_text("<model><sdf version='1.9'>model.sdf</sdf></model>")
    (folder / "model.sdf").write_text(
        "<sdf version='1.9'><model name='part'><link name='p'><pose>1 0 0 0 0 0</pose></link>"
        "<frame name='tip' attached_to='p'><pose>1 0 0 0 0 0</pose></frame>"
        "<link name='q'><pose relative_to='tip'>1 0 0 0 0 0</pose></link>"
        "<joint name='j' type='revolute'><parent>p</parent><child>q</child>"
        "<axis><xyz expressed_in='__model__'>1 0 0</xyz></axis></joint></model></sdf>"
    )
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    quarter = math.pi / 2
    text = (
        "<sdf version='1.9'><world name='w'><model name='m'><link name='own'/><include merge='true'>"
        f"<uri>model://part</uri><pose>0 0 1 0 0 {quarter}</pose></include>"
        "<link name='r'><pose relative_to='tip'>0 0 1 0 0 0</pose></link></model></world></sdf>"
    )
    with libgz.World.from_string(text) as world:
        model = world.model("m")
        assert list(model.links) == ["own", "p", "q", "r"]
        assert tuple(model.GetBody("p").GetPosition()) == pytest.approx((0, 1, 1))
        assert tuple(model.GetBody("q").GetPosition()) == pytest.approx((0, 3, 1))
        assert tuple(model.GetBody("r").GetPosition()) == pytest.approx((0, 2, 2))
        assert tuple(model.sdf_joints["j"].axis(0)) == pytest.approx((0, 1, 0), abs=1e-9)


def test_a_thousand_frames_in_a_chain():
    chain = "".join(
        f"<frame name='f{i}' attached_to='f{i - 1}'><pose>1 0 0 0 0 0</pose></frame>" for i in range(1, 150)
    )
    body = f"<model name='m'>{LINK}<frame name='f0'/>{chain}<link name='k'><pose relative_to='f149'/></link></model>"
    root = read(body).root
    links = list(root.child("world").child("model").named("link"))
    assert links[1].Get(GzPose, "pose").pos.x == pytest.approx(149)
    endless = body.replace("f149'/>", "f3999'/>") + "".join(
        f"<frame name='f{i}' attached_to='f{i - 1}'/>" for i in range(150, 160)
    )
    assert all("w.sdf:" in warning for warning in warnings(endless))


def test_saved_worlds_have_no_frames(tmp_path):
    path = tmp_path / "w.world"
    path.write_text(
        "<sdf version='1.7'><world name='w'><plugin name='p' filename='x.py'/><model name='m'>"
        "<frame name='f'><pose>1 0 0 0 0 0</pose></frame>"
        "<link name='l'><pose relative_to='f'/></link></model></world></sdf>"
    )
    with libgz.World.from_file(path):
        physics.get_world("w").Save(str(tmp_path / "saved.world"))
    text = (tmp_path / "saved.world").read_text()
    assert "relative_to" not in text
    assert "frame" not in text
    done = run_libgz("sdf", "--check", tmp_path / "saved.world")
    assert done.returncode == 0
    assert "no effect" not in done.stderr


def test_the_link_of_a_long_chain_of_frames_is_found_along_the_chain_once(monkeypatch):
    found, find = [], frames._Scope.find
    monkeypatch.setattr(frames._Scope, "find", lambda scope, name: found.append(name) or find(scope, name))
    count = 3000
    chain = "".join(f"<frame name='f{i}' attached_to='{f'f{i - 1}' if i else 'l'}'/>" for i in range(count))
    assert warnings(f"<model name='m'>{LINK}{chain}</model>") == []
    assert count <= len(found) < 10 * count


def test_joints_on_a_long_chain_of_frames_of_the_world_follow_it_once(monkeypatch):
    looked, find = [], frames._Scope.find
    monkeypatch.setattr(frames._Scope, "find", lambda scope, name: looked.append(name) or find(scope, name))
    count = 300
    chain = "".join(f"<frame name='f{i}' attached_to='{f'f{i - 1}' if i else 'world'}'/>" for i in range(count))
    held = "".join(
        f"<joint name='j{i}' type='fixed'><parent>f{count - 1}</parent><child>m</child></joint>" for i in range(count)
    )
    file = SdfFile.from_string(
        f"<sdf version='1.9'><world name='w'>{chain}<model name='m'>{LINK}</model>{held}</world></sdf>"
    )
    assert not file.diagnostics.errors
    joints = list(next(file.root.named("world")).named("joint"))
    assert {joint.Get(str, "parent") for joint in joints} == {"world"}
    assert len(looked) < 20 * count  # count squared if each joint followed the chain


def test_frames_on_a_chain_that_leads_nowhere_follow_it_once(monkeypatch):
    followed, reference = [], frames._reference
    monkeypatch.setattr(frames, "_reference", lambda element: followed.append(element) or reference(element))
    count = 100
    chain = "".join(f"<frame name='f{i}'><pose relative_to='f{i + 1}'/></frame>" for i in range(count))
    others = "".join(f"<frame name='g{i}'><pose relative_to='f0'/></frame>" for i in range(count))
    assert len(warnings(f"<model name='m'>{LINK}{chain}{others}</model>")) == 1
    assert len(followed) < 20 * count  # count squared if each of the others followed the chain


def test_joints_look_through_the_names_of_links_once(monkeypatch):
    looked, attribute = [], frames._attribute
    monkeypatch.setattr(frames, "_attribute", lambda *given: looked.append(given) or attribute(*given))
    links = "".join(f"<link name='l{i}'/>" for i in range(100))
    joints = "".join(
        f"<joint name='j{i}' type='fixed'><parent>l{i}</parent><child>l{i + 1}</child></joint>" for i in range(99)
    )
    assert warnings(f"<model name='m'>{links}{joints}</model>") == []
    assert len(looked) < 10 * 100
