"""Robot descriptions: what becomes of links, joints, shapes and extensions, and what is reported.

data/urdf/sdformat12.json has what Debian's libsdformat 12.3 makes of the same robots: poses as the first three rows of
their matrices, in the model or the link; inertias about the centre of mass, along the link's axes.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import libgz
from libgz.base.errors import WorldFileError
from libgz.base.geometry import GzCoordPoseAdd, GzPose, GzVector, rotate
from libgz.sdf.conversion import upgrade_document
from libgz.sdf.reader import SdfFile
from libgz.sdf.recognition import is_sdf, is_sdf_text

ROBOTS = Path(__file__).parent.parent / "data" / "urdf"
REFERENCE = json.loads((ROBOTS / "sdformat12.json").read_text())
MASS = "<inertial><mass value='1'/><inertia ixx='0.1' ixy='0' ixz='0' iyy='0.1' iyz='0' izz='0.1'/></inertial>"
SENSOR = "<sensor name='s' type='imu'><pose>0 0 0 0 0 inf</pose></sensor>"
STRAY = "<xacro:wing span='2'/>"
BALL = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"


def link(name, inside=MASS):
    return f"<link name='{name}'>{inside}</link>\n"


def joint(name, kind="fixed", parent="a", child="b", inside=""):
    return f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>\n"


def read(*parts):
    return SdfFile.from_string(f"<robot name='r'>\n{''.join(parts)}</robot>", "r.urdf")


def model(*parts):
    file = read(*parts)
    assert [str(one) for one in file.diagnostics.found] == []
    return file.root.child("model")


def named(element, tag, name):
    return next(one for one in element.named(tag) if one.Get(str, "name") == name)


# The reference ---------------------------------------------------------------------------------------------------


def matrix(pose):
    columns = [tuple(rotate(pose.rot, axis)) for axis in np.eye(3)]
    return np.column_stack([*columns, tuple(pose.pos)])


def same(value, expected):
    assert np.ravel(value) == pytest.approx(expected, abs=2e-5)  # sensors' poses have six digits there


@pytest.mark.parametrize("name", REFERENCE)
def test_links_are_those_of_sdformat(name):
    robot = SdfFile.load(ROBOTS / name).root.child("model")
    expected = REFERENCE[name]["links"]
    assert sorted(one.Get(str, "name") for one in robot.named("link")) == sorted(expected)
    for found in robot.named("link"):
        about = expected[found.Get(str, "name")]
        inertial = found.child("inertial")
        pose, values = inertial.Get(GzPose, "pose"), inertial.child("inertia")
        xx, xy, xz, yy, yz, zz = (values.Get(float, key) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"))
        turn = matrix(pose)[:, :3]
        assert inertial.Get(float, "mass") == pytest.approx(about["mass"])
        same(tuple(pose.pos), about["centre"])
        same(turn @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.T, about["inertia"])
        same(matrix(found.Get(GzPose, "pose")), about["pose"])
        parts = [part for part in found.children if part.name in ("collision", "visual", "sensor")]
        shapes = {f"{part.name} {part.Get(str, 'name')}": matrix(part.Get(GzPose, "pose")) for part in parts}
        wanted = {**about["shapes"], **{f"sensor {key}": value for key, value in about["sensors"].items()}}
        assert sorted(shapes) == sorted(wanted)
        for key, place in shapes.items():
            same(place, wanted[key])


@pytest.mark.parametrize("name", REFERENCE)
def test_joints_are_those_of_sdformat(name):
    robot = SdfFile.load(ROBOTS / name).root.child("model")
    places = {one.Get(str, "name"): one.Get(GzPose, "pose") for one in robot.named("link")}
    expected = REFERENCE[name]["joints"]
    assert sorted(one.Get(str, "name") for one in robot.named("joint")) == sorted(expected)
    for found in robot.named("joint"):
        about = expected[found.Get(str, "name")]
        assert [found.Get(str, key) for key in ("type", "parent", "child")] == [
            about[key] for key in ("type", "parent", "child")
        ]
        if "axis" not in about:
            continue
        frame = GzCoordPoseAdd(found.Get(GzPose, "pose"), places[about["child"]])
        axis = found.child("axis")
        same(tuple(frame.pos), about["place"])
        same(tuple(rotate(frame.rot, axis.Get(GzVector, "xyz"))), about["axis"])
        limit, dynamics = axis.child("limit"), axis.child("dynamics")
        for key, none in (("lower", -1e16), ("upper", 1e16), ("effort", -1.0), ("velocity", -1.0)):
            assert limit.Get(float, key) == pytest.approx(about.get(key, none))
        for key in ("damping", "friction", "spring_stiffness", "spring_reference"):
            assert dynamics.Get(float, key) == about.get(key, 0.0)


# Links and fixed joints ------------------------------------------------------------------------------------------


def test_fixed_joints_lump_mass_by_the_parallel_axis_theorem():
    robot = model(link("a"), link("b"), joint("j", inside="<origin xyz='0 0 2' rpy='1 0 0'/>"))
    inertial = next(robot.named("link")).child("inertial")
    inertia = inertial.child("inertia")
    assert inertial.Get(float, "mass") == 2.0
    assert inertial.Get(GzPose, "pose").pos == GzVector(0, 0, 1)
    assert [inertia.Get(float, key) for key in ("ixx", "iyy", "izz")] == pytest.approx([2.2, 2.2, 0.2])


@pytest.mark.parametrize(
    ("flag", "kind"), [("preserveFixedJoint", "fixed"), ("disableFixedJointLumping", "revolute"), ("", None)]
)
def test_fixed_joints_are_kept_if_asked(flag, kind):
    extra = f"<gazebo reference='j'><{flag}>true</{flag}></gazebo>" if flag else ""
    robot = model(link("a"), link("b"), joint("j"), extra)
    assert [one.Get(str, "type") for one in robot.named("joint")] == ([kind] if kind else [])
    assert len(list(robot.named("link"))) == (2 if kind else 1)
    if kind == "revolute":
        limit = robot.child("joint").child("axis").child("limit")
        assert (limit.Get(float, "lower"), limit.Get(float, "upper")) == (0.0, 0.0)


def test_what_turns_on_a_massless_bracket_stays():
    robot = model(
        link("a"),
        link("bracket", BALL),
        link("b"),
        joint("j", child="bracket", inside="<origin xyz='1 0 0'/>"),
        joint("k", "continuous", "bracket", "b", "<origin xyz='0 1 0'/><axis xyz='0 1 0'/>"),
    )
    turning = robot.child("joint")
    assert (turning.Get(str, "parent"), turning.Get(str, "child")) == ("a", "b")
    assert named(robot, "link", "b").Get(GzPose, "pose").pos == GzVector(1, 1, 0)
    assert named(robot, "link", "a").child("collision").Get(str, "name") == "a_fixed_joint_lump__bracket_collision"


def test_links_without_mass_are_left_out_with_what_is_behind_them():
    turning = "<axis xyz='0 0 1'/>"
    file = read(
        link("a"), link("b", ""), link("c"), joint("j", "continuous", inside=turning),
        joint("k", "continuous", "b", "c", turning),
    )  # fmt: skip
    warned = "r.urdf:3: <link>: there is no <inertial>, so link 'b' is left out, and with it c, as Gazebo classic did"
    assert [str(one) for one in file.diagnostics.found] == [warned]
    assert [one.Get(str, "name") for one in file.root.child("model").named("link")] == ["a"]


def test_a_link_world_stands_for_the_world():
    robot = model("<link name='world'/>", link("b"), joint("j", parent="world", inside="<origin xyz='0 0 2'/>"))
    assert [one.Get(str, "name") for one in robot.named("link")] == ["b"]
    assert (robot.child("joint").Get(str, "type"), robot.child("joint").Get(str, "parent")) == ("fixed", "world")
    assert robot.child("link").Get(GzPose, "pose").pos == GzVector(0, 0, 2)


def test_long_chains_are_read():
    count = 1200  # deeper than Python recurses
    links = "".join(link(f"l{i}", MASS + BALL) for i in range(count))
    joints = "".join(joint(f"j{i}", parent=f"l{i}", child=f"l{i + 1}") for i in range(count - 1))
    assert model(links, joints).child("link").child("inertial").Get(float, "mass") == count


# Extensions ------------------------------------------------------------------------------------------------------


def test_extensions_of_links():
    words = "<mu1>0.5</mu1><mu2 value='0.6'/><fdir1>0 1 0</fdir1><kp>1e5</kp><kd>3</kd><minDepth>0.002</minDepth>"
    words += (
        "<maxVel>0.3</maxVel><maxContacts>5</maxContacts><laserRetro>7</laserRetro><dampingFactor>0.1</dampingFactor>"
    )
    words += "<turnGravityOff>true</turnGravityOff><selfCollide>true</selfCollide>"
    words += "<material>Gazebo/Red</material>"
    look = "<visual><geometry><box size='1 2 3'/></geometry></visual>"
    one = model(link("a", MASS + BALL + BALL + look), f"<gazebo reference='a'>{words}</gazebo>").child("link")
    assert [c.Get(str, "name") for c in one.named("collision")] == ["a_collision", "a_collision_1"]
    for collision in one.named("collision"):
        friction, contact = (collision.child("surface").child(k).child("ode") for k in ("friction", "contact"))
        assert (friction.Get(float, "mu"), friction.Get(float, "mu2")) == (0.5, 0.6)
        assert friction.Get(GzVector, "fdir1") == GzVector(0, 1, 0)
        assert [contact.Get(float, k) for k in ("kp", "kd", "min_depth", "max_vel")] == [1e5, 3.0, 0.002, 0.3]
        assert (collision.Get(int, "max_contacts"), collision.Get(float, "laser_retro")) == (5, 7.0)
    assert (one.Get(bool, "gravity"), one.Get(bool, "self_collide")) == (False, True)
    assert one.child("velocity_decay").Get(float, "angular") == 0.1
    assert one.child("visual").child("material").child("script").Get(str, "name") == "Gazebo/Red"
    assert one.child("visual").child("geometry").child("box").Get(GzVector, "size") == GzVector(1, 2, 3)


def test_what_gazebo_writes_itself_is_not_set_in_words_of_sdf():
    """sdformat writes gravity, decay and a joint's physics first; what <gazebo> says of them is the second."""
    decay = "<velocity_decay><linear>1</linear></velocity_decay>"
    spring = "<physics><ode><limit><cfm>1</cfm></limit></ode></physics>"
    file = read(
        link("a"), link("b"), joint("j", "revolute", inside="<limit lower='0' upper='1'/>"),
        f"<gazebo reference='b'><gravity>0</gravity>{decay}<kinematic>1</kinematic></gazebo>",
        f"<gazebo reference='j'>{spring}</gazebo>",
    )  # fmt: skip
    second = "occurs more than once in <{}>; only the first one has an effect"
    found = [(one.element, one.message) for one in file.diagnostics.found]
    assert found == [
        ("gravity", second.format("link")),
        ("velocity_decay", second.format("link")),
        ("physics", second.format("joint")),
    ]
    robot = file.root.child("model")
    one = list(robot.named("link"))[1]
    assert (one.Get(bool, "gravity"), one.Get(bool, "kinematic")) == (True, True)
    assert one.child("velocity_decay").Get(float, "linear") == 0.0
    assert not robot.child("joint").child("physics").HasElement("ode")


def test_extensions_of_lumped_links_reach_their_own_shapes():
    names = BALL.replace("<collision>", "<collision name='bumper'>")
    robot = model(
        link("a", MASS + BALL), link("b", MASS + names), joint("j"),
        "<gazebo reference='b'><mu1>0.1</mu1></gazebo>",
    )  # fmt: skip
    found = {c.Get(str, "name"): c for c in robot.child("link").named("collision")}
    assert list(found) == ["a_collision", "a_fixed_joint_lump__bumper_collision_1"]
    assert not found["a_collision"].HasElement("surface")
    lumped = found["a_fixed_joint_lump__bumper_collision_1"]
    assert lumped.child("surface").child("friction").child("ode").Get(float, "mu") == 0.1


def test_extensions_of_joints():
    words = "<stopCfm>0.1</stopCfm><stopErp>0.4</stopErp><springReference>0.2</springReference>"
    words += "<fudgeFactor>0.3</fudgeFactor><springStiffness>9</springStiffness><provideFeedback>true</provideFeedback>"
    words += "<implicitSpringDamper>1</implicitSpringDamper><sensor name='ft' type='force_torque'/>"
    robot = model(
        link("a"), link("b"), joint("j", "continuous", inside="<axis xyz='0 0 1'/>"),
        f"<gazebo reference='j'>{words}</gazebo>",
    )  # fmt: skip
    one = robot.child("joint")
    ode = one.child("physics").child("ode")
    assert (ode.child("limit").Get(float, "cfm"), ode.child("limit").Get(float, "erp")) == (0.1, 0.4)
    assert (ode.Get(bool, "implicit_spring_damper"), ode.Get(float, "fudge_factor")) == (True, 0.3)
    assert one.child("physics").Get(bool, "provide_feedback")
    dynamics = one.child("axis").child("dynamics")
    assert (dynamics.Get(float, "spring_stiffness"), dynamics.Get(float, "spring_reference")) == (9.0, 0.2)
    assert one.child("sensor").Get(str, "type") == "force_torque"


def test_names_and_places_in_extensions_follow_lumped_links():
    robot = model(
        link("a"), link("b", MASS + BALL), link("c"),
        joint("j", inside="<origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/>"),
        joint("k", "continuous", "b", "c", "<axis xyz='0 0 1'/>"),
        "<gazebo reference='b'><sensor name='s' type='contact'><pose>1 0 0 0 0 0</pose>"
        "<contact><collision>b_collision</collision></contact>"
        "<plugin name='in' filename='libi.so'><frameName>b</frameName></plugin></sensor></gazebo>",
        "<gazebo><plugin name='p' filename='libp.so'><bodyName>b</bodyName><xyzOffset>1 0 0</xyzOffset></plugin>"
        "<plugin name='q' filename='libq.so'><frameName>c</frameName></plugin>"
        "<gripper name='g'><gripper_link>c</gripper_link><palm_link>b</palm_link></gripper>"
        "<joint name='extra' type='ball'><parent>c</parent><child>b</child></joint><static>true</static></gazebo>",
    )  # fmt: skip
    sensor = named(robot, "link", "a").child("sensor")
    assert sensor.child("contact").Get(str, "collision") == "a_fixed_joint_lump__b_collision"
    assert tuple(sensor.Get(GzPose, "pose").pos) == pytest.approx((0, 1, 1))
    assert sensor.child("plugin").Get(str, "frameName") == "b"  # as in Gazebo: that is a frame of TF
    first, second = robot.named("plugin")
    assert first.Get(str, "bodyName") == "a"
    assert tuple(first.Get(GzVector, "xyzOffset")) == pytest.approx((0, 1, 1))
    assert second.Get(str, "frameName") == "c"
    assert robot.child("gripper").Get(str, "palm_link") == "a"
    extra = named(robot, "joint", "extra")
    assert (extra.Get(str, "parent"), extra.Get(str, "child")) == ("c", "a")
    assert extra.Get(GzPose, "pose").pos == GzVector(0, 0, 1)
    assert robot.Get(bool, "static")


def test_extensions_without_effect_are_reported():
    file = read(
        link("a"), link("b"), joint("j"),
        "<gazebo reference='j'><provideFeedback>true</provideFeedback></gazebo>\n",
        "<gazebo reference='aa'><mu1>1</mu1></gazebo>\n<gazebo><mu1>1</mu1></gazebo>\n",
        "<transmission name='t'/><transmission name='u'/>",
    )  # fmt: skip
    texts = [str(one) for one in file.diagnostics.warnings]
    assert any(t.startswith("r.urdf:5: <provideFeedback>: has no effect: joint 'j' is fixed") for t in texts)
    assert any(t.startswith("r.urdf:6: <gazebo>: reference is 'aa'") and "did you mean" in t for t in texts)
    assert any(t.startswith("r.urdf:7: <mu1>: has no effect in <gazebo> without") for t in texts)
    assert [t for t in texts if "these 2 have no effect" in t] == [t for t in texts if "<transmission>" in t] != []


def test_colours_come_from_the_robot_or_the_link():
    shape = "<visual><geometry><sphere radius='1'/></geometry><material name='{}'>{}</material></visual>"
    paint = "<material name='paint'><color rgba='0.1 0.2 0.3 1'/></material>"
    own = shape.format("own", "<color rgba='1 0 0 0.5'/>")
    robot = model(paint, link("a", MASS + shape.format("paint", "") + own + shape.format("own", "")))
    colours = [one.child("material").Get(str, "diffuse") for one in robot.child("link").named("visual")]
    assert colours == ["0.1 0.2 0.3 1", "1 0 0 0.5", "1 0 0 0.5"]


# Errors ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ([""], "r.urdf:1: <robot>: there is no <link>"),
        ([link("a"), link("b")], "r.urdf:3: <link>: links a, b have no parent"),
        ([link("a"), joint("j", child="bb"), link("b")], "r.urdf:3: <child>: there is no link 'bb'; did you mean 'b'"),
        ([link("a"), joint("j", "hinge"), link("b")], "r.urdf:3: <joint>: type is 'hinge'; it must be revolute"),
        ([link("a"), link("a")], "r.urdf:3: <link>: there is a link 'a' already, at line 2"),
        ([link("a", "<inertial><mass value='x'/><inertia ixx='1' iyy='1' izz='1'/></inertial>")], "must be a number"),
        ([link("a"), link("b"), joint("j", inside="<origin xyz='0 nan 0'/>")], "'0 nan 0'; it must be 3 numbers"),
        ([link("a"), link("b"), joint("j"), joint("k", "fixed", "b", "a")], "the joints are a loop"),
        ([link("a"), link("b"), link("c"), joint("j", parent="c"), joint("k")], "is the child of joint 'j', too"),
        ([link("a", MASS + BALL), "<gazebo reference='a'><mu1>slippery</mu1></gazebo>"], "'slippery' is not allowed"),
    ],
)  # fmt: skip
def test_errors_have_file_and_line(parts, message):
    text = f"<robot name='r'>\n{''.join(parts)}</robot>"
    if parts == [""]:
        text = "<robot name='r'/>"
    file = SdfFile.from_string(text, "r.urdf")
    found = [str(one) for one in file.diagnostics.errors]
    assert any(message in one and one.startswith("r.urdf:") for one in found), found


@pytest.mark.parametrize(
    ("written", "read_as"), [("1, 2, 3", "1 2 3"), ("1 2 3 4", "1 2 3"), ("1m 2m 3.", "1 2 3."), ("1 2", "1 2 0")]
)
def test_odd_numbers_are_warnings(written, read_as):
    file = read(link("a"), link("b"), joint("j", "floating", inside=f"<origin xyz='{written}'/>"))
    found = [str(one) for one in file.diagnostics.found]
    assert found == ([f"r.urdf:4: <origin>: xyz {written!r} is read as {read_as!r}; it should be 3 numbers"])
    place = named(file.root.child("model"), "link", "b").Get(GzPose, "pose").pos
    assert place == GzVector(1, 2, 0 if written == "1 2" else 3)


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (
            [link("a"), "<gazebo reference='a'><gravity>often</gravity></gazebo>"],
            "<gravity>: 'often' is read as 'false'",
        ),
        (
            [link("a"), link("b"), joint("j"), "<gazebo reference='b'>", SENSOR, "</gazebo>"],
            "<pose>: '0 0 0 0 0 inf' is read as '0 0 0 0 0 0'",
        ),
        ([link("a"), "<wing span='2'/>"], "<wing>: is not part of URDF and has no effect"),
    ],
)
def test_extensions_are_as_lenient_as_sdf(parts, message):
    found = read(*parts).diagnostics
    assert not found.errors
    assert any(message in str(one) for one in found.warnings), found.warnings


@pytest.mark.parametrize("declared", [" xmlns:xacro='http://www.ros.org/wiki/xacro'", ""])
def test_a_stray_macro_leaves_the_rest_of_a_robot(tmp_path, declared):
    path = tmp_path / "r.urdf"
    path.write_text(f"<robot name='r'{declared}>\n{link('a')}{STRAY}\n{link('b')}{joint('j', 'continuous')}</robot>")
    file = SdfFile.load(path)
    assert not file.diagnostics.errors
    assert [one.Get(str, "name") for one in file.root.child("model").named("link")] == ["a", "b"]
    assert any(one.line == 3 and "the element is left out" in one.message for one in file.diagnostics.warnings)


def test_what_gazebo_passed_over_is_a_warning():
    light = link("a", "<inertial><mass value='2'/></inertial><collision><geometry><mesh/></geometry></collision>")
    parts = [light, link("b"), joint("j", "continuous", inside="<mimic joint='jj'/>")]
    parts.append(link("c", "<inertial/>") + joint("k", "fixed", child="c"))
    file = read(*parts)
    inertial = file.root.child("model").child("link").child("inertial")
    assert (inertial.Get(float, "mass"), inertial.child("inertia").Get(float, "ixx")) == (2.0, 0.0)
    texts = "\n".join(str(one) for one in file.diagnostics.warnings)
    assert file.diagnostics.errors == []
    assert "r.urdf:2: <inertial>: <inertia> is missing: zero moments are read" in texts
    assert "r.urdf:2: <mesh>: attribute 'filename' is missing: the shape is left out" in texts
    assert "<mimic>: joint is 'jj', which is not another joint; did you mean 'j'" in texts
    assert "<inertial>: <mass value='...'> is missing: the link is read as one without mass" in texts


def test_limits_that_are_missing_or_exchanged_are_warnings():
    file = read(
        link("a"), link("b"), link("c"), joint("j", "revolute"),
        joint("k", "prismatic", "b", "c", "<limit lower='2' upper='-1' effort='3' velocity='4'/>"),
    )  # fmt: skip
    assert [str(one) for one in file.diagnostics.found] == [
        "r.urdf:5: <joint>: <limit> is missing, which revolute joints must have; it moves without limits",
        "r.urdf:6: <limit>: lower is 2 and upper -1; they are exchanged",
    ]
    limit = named(file.root.child("model"), "joint", "k").child("axis").child("limit")
    assert [limit.Get(float, key) for key in ("lower", "upper", "effort", "velocity")] == [-1.0, 2.0, 3.0, 4.0]


def test_lines_are_those_of_the_robot(tmp_path, caplog):
    path = tmp_path / "r.urdf"
    path.write_text(
        "<robot name='r'>\n"
        + link("a")
        + link("b")
        + joint("j", "continuous", inside="<axis xyz='0 0 0'/>")
        + "</robot>"
    )
    libgz.World.from_file(path).close()
    assert f"{path}:4: <joint>: <axis> is zero; 1 0 0 in the world is used instead" in caplog.text


# Where robots are read -------------------------------------------------------------------------------------------


def test_robots_load_where_sdf_does(tmp_path, monkeypatch):
    path, text = ROBOTS / "pendulum.urdf", (ROBOTS / "pendulum.urdf").read_text()
    assert is_sdf(path)
    assert is_sdf_text(text)
    for world in (libgz.World.from_file(path), libgz.World.from_string(text)):
        with world:
            assert [one.GetId() for one in world.models] == ["pendulum"]
            assert world.model("pendulum").sdf_joints["tip_joint"].kind == "revolute"
    folder = tmp_path / "swinger"
    folder.mkdir()
    (folder / "model.config").write_text("<model><name>x</name><sdf version='1.4'>swinger.urdf</sdf></model>")
    (folder / "swinger.urdf").write_text(text)
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tmp_path))
    include = "<include><uri>model://swinger</uri><name>second</name><pose>0 0 3 0 0 0</pose></include>"
    with libgz.World.from_string(f"<sdf version='1.6'><world name='w'>{include}</world></sdf>") as world:
        assert world.model("second").GetPose().pos == GzVector(0, 0, 3)


def test_robots_can_be_inserted_and_restored():
    from libgz.classic.server import attach

    with libgz.World.from_string("<sdf version='1.6'><world name='w'/></sdf>") as world:
        view = attach(world).world
        view.InsertModelString((ROBOTS / "scara.urdf").read_text())
        view.InsertModelFile(str(ROBOTS / "robot_pack/urdf/mesh_bot.urdf"))
        world.step(5)
        state = world.get_state()
        view.RemoveModel("mesh_bot")
        world.step(1)
        world.set_state(state)
        assert view.ModelByName("scara").GetJoint("lift").UpperLimit(0) == 0.1
        assert len(world.model("mesh_bot").GetBody("body").geoms) == 4


def test_robots_are_written_as_sdf(tmp_path):
    path = ROBOTS / "robot_pack/urdf/mesh_bot.urdf"
    text, changes = upgrade_document(path.read_bytes(), str(path))
    assert [str(one) for one in changes] == [f"{path}:3: <robot>: became <sdf version='1.6'>"]
    again = SdfFile.from_string(text)
    assert again.diagnostics.found == {}
    assert again.root.ToString() == SdfFile.load(path).root.ToString()


@pytest.mark.parametrize("variable", ["GAZEBO_MODEL_PATH", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_packages_are_found(variable, tmp_path, monkeypatch):
    for name in ("GAZEBO_MODEL_PATH", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    folder = tmp_path / "share" if variable.startswith("AMENT") else tmp_path
    (folder / "blocks" / "meshes").mkdir(parents=True)
    mesh = (ROBOTS / "robot_pack/meshes/block.stl").read_text()
    (folder / "blocks" / "meshes" / "block.stl").write_text(mesh)
    shape = "<collision><geometry><mesh filename='package://blocks/meshes/block.stl'/></geometry></collision>"
    text = f"<robot name='r'>{link('a', MASS + shape)}</robot>"
    for value, count in (("", 0), (str(tmp_path), 1)):
        monkeypatch.setenv(variable, value)
        with libgz.World.from_string(text) as world:
            assert len(world.model("r").GetBody("a").geoms) == count
    if variable == "ROS_PACKAGE_PATH":
        monkeypatch.setenv(variable, str(folder / "blocks"))  # it may name packages themselves
        with libgz.World.from_string(text) as world:
            assert len(world.model("r").GetBody("a").geoms) == 1


# Macros ----------------------------------------------------------------------------------------------------------

XACRO = """<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>
<xacro:include filename='$(find parts)/parts.xacro'/>
<xacro:property name='size' value='${1 + 1}'/>
<xacro:ball name='a' radius='${size/4}'/>
</robot>"""
PARTS = f"""<robot xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:macro name='ball' params='name radius'>
<link name='${{name}}'>{MASS}<collision><geometry><sphere radius='${{radius}}'/></geometry></collision></link>
</xacro:macro></robot>"""


def test_macros_are_expanded(tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "parts.xacro").write_text(PARTS)
    (tmp_path / "r.urdf.xacro").write_text(XACRO)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    file = SdfFile.load(tmp_path / "r.urdf.xacro")
    for one in (file, file.read_again()):
        collision = one.root.child("model").child("link").child("collision")
        assert collision.child("geometry").child("sphere").Get(float, "radius") == 0.5
    assert SdfFile.from_string(XACRO).root.ToString() == file.root.ToString()
    (tmp_path / "bad.xacro").write_text(XACRO.replace("size/4", "sise/4"))
    with pytest.raises(WorldFileError, match=r"bad\.xacro:4: <xacro:ball>: name 'sise' is not defined"):
        SdfFile.load(tmp_path / "bad.xacro")
    (tmp_path / "far.xacro").write_text(XACRO.replace("find parts", "find elsewhere"))
    with pytest.raises(WorldFileError, match=r"far\.xacro:2: .*package://elsewhere"):
        SdfFile.load(tmp_path / "far.xacro")


# Mimic -----------------------------------------------------------------------------------------------------------


def test_a_joint_follows_another():
    with libgz.World.from_file(ROBOTS / "gripper.urdf") as world:
        world.step(1500)
        joints = world.model("gripper").sdf_joints
        assert joints["left_finger_joint"].position() == pytest.approx(0.03, abs=1e-4)
        assert joints["right_finger_joint"].position() == pytest.approx(0.04, abs=1e-4)
        joints["left_finger_joint"].set_position(0.01)
        world.step(1)
        assert joints["right_finger_joint"].velocity() == pytest.approx(-0.2, abs=0.01)  # its limit
        world.step(999)
        leader = joints["left_finger_joint"].position()
        assert joints["right_finger_joint"].position() == pytest.approx(leader + 0.01, abs=1e-4)
        world.model("gripper").remove_joint("left_finger_joint")
        world.step(10)


def test_a_follower_has_its_limits_of_effort_and_range():
    turning = "<axis xyz='1 0 0'/><limit lower='-1' upper='1' effort='{}' velocity='3'/>"
    heavy = MASS.replace("<mass", "<origin xyz='0 1 0'/><mass")
    robot = (
        "<link name='world'/>" + link("a") + link("b", heavy)
        + joint("lead", "revolute", "world", "a", turning.format(100))
        + joint("follow", "revolute", "world", "b", turning.format("{}") + "<mimic joint='lead' multiplier='-2'/>")
    )  # fmt: skip
    for effort, reached in ((30, 0.6), (3, -1.0)):  # 9.8 N m hold the link level
        with libgz.World.from_string(f"<robot name='r'>{robot.format(effort)}</robot>") as world:
            lead, follow = (world.model("r").sdf_joints[name] for name in ("lead", "follow"))
            lead.set_position(-0.3)
            world.step(1500)
            assert follow.position() == pytest.approx(reached, abs=0.01)
            assert math.isfinite(follow.velocity())


@pytest.mark.parametrize("effort", [0, 1000])
def test_a_strong_motor_at_a_stop_leaves_light_links_alone(effort):
    light = (
        "<inertial><mass value='0.02'/><inertia ixx='1e-5' ixy='0' ixz='0' iyy='1e-5' iyz='0' izz='1e-5'/></inertial>"
    )
    turning = f"<axis xyz='0 0 1'/><limit lower='0' upper='0.8' effort='{effort}' velocity='2'/>"
    robot = (
        link("base") + link("a", light) + link("b", light)
        + joint("lead", "revolute", "base", "a", turning.replace(f"effort='{effort}'", "effort='10'"))
        + joint("follow", "revolute", "base", "b", turning + "<mimic joint='lead'/>")
    )  # fmt: skip
    with libgz.World.from_string(f"<robot name='r'>{robot}</robot>") as world:
        joints = world.model("r").sdf_joints
        world.step(200)
        assert [abs(joints[name].position()) for name in ("lead", "follow")] == pytest.approx([0.0, 0.0], abs=1e-6)
        for _ in range(300):
            joints["lead"].add_force(1e-4)
            world.step()
        assert joints["lead"].position() > 0.1
        assert joints["follow"].position() == pytest.approx(joints["lead"].position(), abs=0.01)
