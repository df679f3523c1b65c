"""SDF documents: defaults by version, getters, errors, includes."""

import math
import threading

import pytest
from commands import run_libgz
from hypothesis import given, strategies as st

from libgz.base.errors import NotFoundError, ParameterError, WorldFileError
from libgz.base.geometry import GzColor, GzPose, GzQuaternToEuler, GzVector
from libgz.sdf import description
from libgz.sdf.description import VERSIONS, describe
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.value import format_value, parse


@pytest.fixture(autouse=True)
def no_paths(monkeypatch, tmp_path):
    for name in ("GAZEBO_MODEL_PATH", "GAZEBO_RESOURCE_PATH"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))


def read(body, version="1.6", **options):
    return SdfFile.from_string(f"<sdf version='{version}'>{body}</sdf>", **options)


def model(body, version="1.6"):
    file = read(f"<model name='m'>{body}</model>", version)
    assert file.diagnostics.found == {}
    return file.root.child("model")


def texts(file):
    return [str(error) for error in file.diagnostics.found]


# Descriptions ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", VERSIONS)
def test_every_block_that_is_referenced_is_described(version):
    blocks = describe(version)

    def walk(description, seen):
        if description.block:
            assert description.block in blocks
            if description.block in seen:
                return
            seen = seen | {description.block}
        for child in description.children.values():
            walk(child, seen)

    for name, block in blocks.items():
        walk(block, {name})


def test_versions_differ_where_they_should():
    assert "gravity" in describe("1.4")["physics"].children
    assert "gravity" not in describe("1.6")["physics"].children
    assert "gravity" in describe("1.6")["world"].children
    assert "use_parent_model_frame" not in describe("1.4")["joint"].children["axis"].children
    assert describe("1.4")["surface"].children["contact"].children["collide_bitmask"].default == "1"
    assert describe("1.6")["surface"].children["contact"].children["collide_bitmask"].default == "65535"
    with pytest.raises(ParameterError, match=r"1\.4, .*1\.9"):
        describe("2.0")


def test_another_thread_sees_no_block_before_it_is_complete(monkeypatch):
    blocks, complete, seen = describe.__wrapped__("1.6"), description._complete_poses, []

    def look():
        seen.append(set(blocks["link"].children["pose"].all_attributes))

    def interrupted(element, attributes):
        if not seen and threading.current_thread() is threading.main_thread():
            other = threading.Thread(target=look)
            other.start()
            other.join()
        complete(element, attributes)

    monkeypatch.setattr(description, "_complete_poses", interrupted)
    assert "pose" in blocks["link"].children
    assert seen == [{"frame"}]


# Getters ---------------------------------------------------------------------------------------------------------


def test_typed_getters():
    link = model(
        "<pose>1 2 3 0 0 1.5</pose><link name='l'><gravity>1</gravity><inertial><mass>2.5</mass></inertial></link>"
    )
    assert link.Get(str, "name") == "m"
    pose = link.Get(GzPose, "pose")
    assert tuple(pose.pos) == (1, 2, 3)
    assert GzQuaternToEuler(pose.rot).z == pytest.approx(1.5)
    inner = link.child("link")
    assert inner.Get(bool, "gravity") is True
    assert inner.child("inertial").Get(float, "mass") == 2.5


def test_defaults_of_the_description():
    link = model("<link name='l'/>").child("link")
    assert not link.HasElement("inertial")
    assert link.child("inertial").Get(float, "mass") == 1.0
    assert link.HasElement("inertial")  # asking made it
    assert link.child("inertial").child("inertia").Get(float, "ixx") == 1.0
    assert link.Get(bool, "kinematic") is False
    assert link.GetElement("no_such_thing") is None
    with pytest.raises(NotFoundError, match="has no <no_such_thing>"):
        link.child("no_such_thing")


def test_required_children_are_made():
    world = read("<world name='w'/>").root.child("world")
    assert world.Get(GzVector, "gravity") == GzVector(0, 0, -9.8)
    assert world.child("physics").Get(float, "max_step_size") == 0.001
    assert world.child("scene").Get(GzColor, "ambient") == GzColor(0.4, 0.4, 0.4, 1.0)
    old = read("<world name='w'/>", "1.4").root.child("world")
    assert old.child("physics").Get(GzVector, "gravity") == GzVector(0, 0, -9.8)


def test_plugins_keep_all_their_content():
    plugin = model(
        "<plugin name='p' filename='libp.so'><speed unit='m'>0.5</speed><list><a>1</a><a>2</a></list></plugin>"
    ).child("plugin")
    assert plugin.Get(str, "filename") == "libp.so"
    assert plugin.Get(float, "speed") == 0.5
    assert plugin.child("speed").GetAttribute("unit").GetAsString() == "m"
    assert plugin.Get(float, "missing") == 0.0
    assert plugin.Get(str, "missing") == ""
    assert plugin.Get(float, "missing", 7.0) == (7.0, False)
    assert plugin.Get(float, "speed", 7.0) == (0.5, True)
    first = plugin.child("list").GetFirstElement()
    assert (first.Get(int), first.GetNextElement("a").Get(int)) == (1, 2)
    assert first.GetNextElement("a").GetNextElement("a") is None
    with pytest.raises(ParameterError, match=r"<string>:1: <speed>: '0\.5' is not a int"):
        plugin.Get(int, "speed")


def test_values_of_own_classes():
    class Angle(float):
        @classmethod
        def from_sdf(cls, text):
            return cls(math.radians(float(text)))

    assert parse(Angle, "180") == pytest.approx(math.pi)
    with pytest.raises(ParameterError, match="is not a type of SDF values"):
        parse(list, "1")


@given(st.floats(-1e6, 1e6))
def test_numbers_round_trip(value):
    element = Element("x")
    element.Set(value)
    assert element.Get(float) == value


@pytest.mark.parametrize("value", [True, 3, "text", GzVector(1, 2, 3), GzColor(0.1, 0.2, 0.3, 1.0)])
def test_values_round_trip(value):
    assert parse(type(value), format_value(value)) == value


def test_editing_cloning_and_printing():
    link = model("<link name='l'><pose>0 0 1 0 0 0</pose></link>").child("link")
    copy = link.Clone()
    link.child("pose").Set(GzPose(GzVector(1, 0, 0)))
    assert copy.Get(GzPose, "pose").pos.z == 1
    assert link.Get(GzPose, "pose").pos.x == 1
    added = link.AddElement("collision")
    assert added.HasElement("geometry")  # required in a collision
    text = link.ToString("  ")
    assert text.startswith('  <link name="l">\n    <pose>1 0 0 0 0 0</pose>\n')
    link.RemoveChild(added)
    assert not link.HasElement("collision")


def test_printed_documents_read_the_same():
    file = read(
        "<world name='w'><include><uri>model://ground_plane</uri></include><include><uri>model://sun</uri></include></world>"
    )
    text = file.root.ToString()
    again = SdfFile.from_string(text)
    assert again.root.ToString() == text
    assert again.diagnostics.errors == []


# Errors ----------------------------------------------------------------------------------------------------------


def test_all_errors_at_once_with_their_lines():
    file = read(
        "\n<model nam='m'>\n<link name='l'>\n<pose>1 a</pose>\n<gravty>1</gravty>\n<gravity>maybe</gravity>"
        "<collision name='c'><max_contacts>many</max_contacts></collision></link>\n"
        "<joint name='j' type='revolute'><parent>a</parent></joint></model>",
        label="x.sdf",
    )
    assert [str(f) for f in file.diagnostics.errors] == [
        "x.sdf:2: <model>: attribute 'name' is missing and must be given",
        "x.sdf:6: <max_contacts>: 'many' is not allowed; it must be a whole number",
        "x.sdf:7: <joint>: <child> is missing and must be given",
    ]
    warnings = [str(f) for f in file.diagnostics.warnings]
    assert "x.sdf:2: <model>: attribute 'nam' is not part of SDF 1.6 and is ignored; did you mean 'name'?" in warnings
    assert any("<gravty>: is not part of SDF 1.6 in <link>" in w and "did you mean 'gravity'?" in w for w in warnings)
    pose = "'1 a' is read as '1 0 0 0 0 0'; it should be 6 finite numbers: x y z [m] roll pitch yaw [rad]"
    assert f"x.sdf:4: <pose>: {pose}" in warnings
    assert "x.sdf:6: <gravity>: 'maybe' is read as 'false'; it should be true, false, 1 or 0" in warnings


def test_joints_need_an_axis_but_balls_do_not():
    joint = "<joint name='j' type='{}'><parent>a</parent><child>b</child></joint>"
    assert texts(read(f"<model name='m'>{joint.format('ball')}</model>", "1.4")) == []
    assert (
        "<axis> is missing; it is 0 0 1" in texts(read(f"<model name='m'>{joint.format('revolute')}</model>", "1.4"))[0]
    )


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("<sdf version='1.6'><a></sdf>", "mismatch"),
        ("<gz:world xmlns:gz='x'/>", "root of an SDF file must be <sdf"),
        ("", "empty"),
    ],
)
def test_what_is_not_sdf_is_an_error(text, what):
    with pytest.raises(WorldFileError, match=what) as caught:
        SdfFile.from_string(text, "y.sdf")
    assert str(caught.value).startswith("y.sdf:")


def test_other_versions():
    assert "version 1.3 is read as 1.4" in texts(read("", "1.3"))[0]
    assert "version 1.12 is read as 1.9" in texts(read("", "1.12"))[0]
    assert "version is empty; 1.6 is used" in texts(read("", ""))[0]
    assert texts(read("", "1.9")) == []
    assert "version 'x' is not allowed" in texts(read("", "x"))[0]


@given(st.binary(max_size=200))
def test_no_bytes_crash_the_reader(data):
    try:
        SdfFile.from_string(data)
    except WorldFileError as error:
        assert str(error)


# Includes --------------------------------------------------------------------------------------------------------


def write_model(folder, name="box", version="1.5", body="<link name='l'/>", config="model.sdf"):
    place = folder / name
    place.mkdir(parents=True)
    (place / "model.config").write_text(
        f"<model><sdf version='1.2'>old.sdf</sdf><sdf version='{version}'>{config}</sdf></model>"
    )
    (place / "model.sdf").write_text(f"<sdf version='{version}'><model name='{name}'>{body}</model></sdf>")
    return place


INCLUDE = "<include><uri>{}</uri>{}</include>"


def world(*includes, **options):
    return read(f"<world name='w'>{''.join(includes)}</world>", **options)


def test_includes_by_model_path(tmp_path, monkeypatch):
    write_model(tmp_path / "models")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"/nowhere:{tmp_path / 'models'}")
    plugin = "<plugin name='p' filename='p.so'><a>1</a></plugin>"
    extra = f"<name>crate</name><pose>1 2 3 0 0 0</pose><static>true</static>{plugin}"
    file = world(INCLUDE.format("model://box", ""), INCLUDE.format("model://box", extra))
    assert texts(file) == []
    first, second = file.root.child("world").named("model")
    assert (first.Get(str, "name"), second.Get(str, "name")) == ("box", "crate")
    assert tuple(second.Get(GzPose, "pose").pos) == (1, 2, 3)
    assert second.Get(bool, "static") is True
    assert second.child("plugin").Get(int, "a") == 1
    assert "link" in first.description.children


def test_ground_and_sun_come_with_the_package():
    file = world(INCLUDE.format("model://ground_plane", ""), INCLUDE.format("model://sun", ""))
    assert texts(file) == []
    ground = file.root.child("world").child("model")
    friction = ground.child("link").child("collision").child("surface").child("friction").child("ode")
    assert (friction.Get(float, "mu"), friction.Get(float, "mu2")) == (100, 50)
    assert file.root.child("world").child("light").Get(GzVector, "direction") == GzVector(-0.5, 0.1, -0.9)


def test_includes_by_file(tmp_path, monkeypatch):
    place = write_model(tmp_path)
    assert texts(world(INCLUDE.format(f"file://{place}/model.sdf", ""))) == []
    assert texts(world(INCLUDE.format("box/model.sdf", ""), folder=tmp_path)) == []
    monkeypatch.setenv("GAZEBO_RESOURCE_PATH", str(tmp_path.parent))
    assert texts(world(INCLUDE.format(f"file://{tmp_path.name}/box", ""))) == []


@pytest.mark.parametrize(
    ("uri", "what"),
    [
        ("model://nothing", r"Unable to find uri\[model://nothing\]; looked for .*; set GAZEBO_MODEL_PATH"),
        ("http://models.example/x", "never looks on the network"),
        ("ftp://x", "ftp:// is not known"),
        ("", "<uri> is missing"),
    ],
)
def test_missing_includes(uri, what):
    import re

    file = world(INCLUDE.format(uri, ""))
    assert re.search(what, texts(file)[0])
    assert not file.root.child("world").HasElement("model")


@pytest.mark.parametrize("place", ["models", "", "worlds/models"])
def test_models_of_a_checkout_are_found_without_a_path(place, tmp_path):
    write_model(tmp_path / place)
    (tmp_path / "worlds").mkdir(exist_ok=True)
    file = world(INCLUDE.format("model://box", ""), folder=tmp_path / "worlds")
    assert texts(file) == []
    assert file.root.child("world").HasElement("model")


def test_an_address_of_the_network_names_a_model_on_disk():
    place = "https://fuel.gazebosim.org/1.0/OpenRobotics/models/{}"
    for name in ("Ground Plane", "Ground%20Plane", "ground_plane/3"):
        file = world(INCLUDE.format(place.format(name), ""))
        assert texts(file) == []
        assert file.root.child("world").child("model").Get(str, "name") == "ground_plane"


def test_a_model_that_includes_itself(tmp_path, monkeypatch):
    write_model(tmp_path, body="<include><uri>model://box</uri></include>")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    assert [t for t in texts(world(INCLUDE.format("model://box", ""))) if "itself" in t] == [
        f"{tmp_path}/box/model.sdf:1: <include>: model://box includes itself"
    ]


# Command ---------------------------------------------------------------------------------------------------------


def test_the_command(tmp_path):
    good, bad = tmp_path / "good.sdf", tmp_path / "bad.sdf"
    good.write_text("<sdf version='1.5'><model name='m'><link name='l'/></model></sdf>")
    bad.write_text("<sdf version='1.5'><model><link name='l'/></model></sdf>")
    assert run_libgz("sdf", "--check", good).stdout == "Check complete\n"
    done = run_libgz("sdf", "--check", bad)
    assert (done.returncode, done.stdout) == (1, "")
    assert f"error   : {bad}:1: <model>: attribute 'name' is missing" in done.stderr
    assert '<model name="m">' in run_libgz("sdf", "--print", good).stdout
    assert run_libgz("sdf", "--check", tmp_path / "none.sdf").returncode == 1


def test_elements_of_one_kind_and_name_in_one_parent_are_a_warning():
    shape = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    parts = "".join(f"<{kind} name='v'>{shape}</{kind}>" for kind in ("visual", "visual", "collision"))
    link = f"<link name='l'>{parts}</link>"
    found = texts(world(f"<model name='m'>{link}</model>\n<model name='m'/>\n<light name='m' type='point'/>"))
    assert found == [
        "<string>:2: <model>: 'm' is the name of another <model>, at <string>:1; it is left out",
        "<string>:1: <visual>: 'v' is the name of another <visual>, at <string>:1; names must differ",
    ]


def test_what_is_not_simulated_is_one_warning_for_each_kind():
    projector = "<projector name='p'><texture>x.png</texture></projector>"
    camera = "<sensor name='{}' type='camera'><camera><distortion><k1>{}</k1></distortion></camera></sensor>"
    wide = "<sensor name='w' type='rfid'/><sensor name='t' type='rfidtag'><rfidtag/></sensor>"
    link = f"<link name='l'>{projector}{projector}{camera.format('a', -0.1)}{camera.format('b', 0)}{wide}</link>"
    ends = "<parent>world</parent><child>l</child><physics><ode><cfm>{}</cfm></ode></physics>"
    joints = "".join(f"<joint name='j{cfm}' type='revolute'>{ends.format(cfm)}</joint>" for cfm in (0, 0.1))
    assert texts(world(f"<model name='m'>{link}{joints}</model>")) == [
        "<string>:1: <projector>: projectors are not simulated: nothing is projected (1 more in this world)",
        "<string>:1: <sensor>: type 'rfid' is not simulated; the sensor is left out",
        "<string>:1: <sensor>: type 'rfidtag' is not simulated; the sensor is left out",
        "<string>:1: <cfm>: softens the joint's motor and stops only, not what holds its links together as in Gazebo",
    ]


def test_air_population_and_actors_are_part_of_all_versions():
    parts = "<wind><linear_velocity>1 0 0</linear_velocity></wind><atmosphere type='adiabatic'/><actor name='a'/>"
    population = "<population name='p'><model name='m'><link name='l'/></model><distribution/></population>"
    for version in ("1.4", "1.5", "1.6"):
        file = SdfFile.from_string(f"<sdf version='{version}'><world name='w'>{parts}{population}</world></sdf>")
        assert not file.diagnostics.warnings
        assert not file.diagnostics.errors
