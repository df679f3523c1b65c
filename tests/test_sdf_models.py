"""SDF models beyond single links: nested ones, joints between models, joints at run time, shapes, states, settings."""

import math
import struct

import numpy as np
import pytest
from PIL import Image
from sdf_worlds import GROUND, Loader, collision, inertial, joint, link, model, world

from libgz.errors import NotFoundError, ParameterError, WorldFileError
from libgz.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.ode.native_step import native_path
from libgz.ode.types import Surface
from libgz.sdf.reader import SdfFile
from libgz.simulation.sdf_settings import apply_profile, settings_of
from libgz.simulation.sdf_world import insert_sdf


@pytest.fixture
def load(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)
    monkeypatch.delenv("GAZEBO_RESOURCE_PATH", raising=False)
    loader = Loader(tmp_path)
    yield loader
    loader.close()


def place(body):
    return tuple(body.GetPosition())


# Nested models, joints between models ----------------------------------------------------------------------------


def test_a_model_of_models_alone(load):
    arm = model("arm", link("hand", inertial()), pose="0 0 1 0 0 0")
    made = load(world(model("robot", arm, pose="1 2 0 0 0 0"), gravity="0 0 0"))
    robot, inner = made.model("robot"), made.model("robot::arm")
    assert tuple(robot.GetPose().pos) == (1, 2, 0)
    assert robot.GetBody() is robot.GetBody("arm::hand") is inner.GetBody("hand")
    assert place(robot.GetBody()) == (1, 2, 1)
    made.SetModelPose(robot, GzPose(GzVector(5, 0, 0), GzQuaternFromEuler(0, 0, math.pi / 2)))
    assert place(inner.GetBody()) == pytest.approx((5, 0, 1))
    assert GzQuaternToEuler(inner.GetPose().rot).z == pytest.approx(math.pi / 2)
    made.reset()
    assert place(inner.GetBody()) == pytest.approx((1, 2, 1))
    with pytest.raises(NotFoundError, match="no link 'foot'; it has arm::hand"):
        robot.GetBody("foot")
    made.DeleteModel("robot")
    assert made.models == []


def test_joints_reach_into_nested_models(load):
    arm = model("arm", link("upper", inertial()), pose="0 0 1 0 0 0")
    body = model(
        "robot",
        link("base", inertial(5.0)),
        arm,
        joint("shoulder", "revolute", "base", "arm::upper", "0 1 0"),
    )
    made = load(world(body, gravity="0 0 0"))
    robot = made.model("robot")
    assert robot.sdf_joints["shoulder"].child is made.model("robot::arm").GetBody("upper")
    robot.sdf_joints["shoulder"].set_velocity(1.0)
    made.run(0.1)
    assert robot.sdf_joints["shoulder"].position() == pytest.approx(0.1, abs=1e-3)


def test_joints_to_other_models_and_in_the_world(load):
    post = model("post", "<static>1</static>", link("top"), pose="0 0 5 0 0 0")
    swing = model(
        "swing",
        link("seat", inertial()),
        joint("rope", "revolute", "post::top", "seat", "0 1 0", pose="-1 0 0 0 0 0"),
        pose="1 0 5 0 0 0",
    )
    lone = model("lone", link("block", inertial()), pose="9 0 3 0 0 0")
    beside = joint("nail", "fixed", "world", "lone::block", "")
    made = load(world(post, swing, lone, beside))
    made.run(0.4)
    assert made.model("swing").sdf_joints["rope"].position() > 0.3
    assert place(made.body("lone")) == pytest.approx((9, 0, 3), abs=1e-6)
    with pytest.raises(WorldFileError, match="<parent> names link 'post::foot'; model 'post' has no link 'foot'"):
        load(world(post, swing.replace("post::top", "post::foot")))


def test_frames_of_later_versions_are_refused(load):
    for text in ("<pose frame='x'>0 0 0 0 0 0</pose>", "<pose relative_to='x'>0 0 0 0 0 0</pose>"):
        with pytest.raises(WorldFileError, match=r"is of SDF 1\.7 and later, which libgz does not read"):
            load(world(f"<model name='m'>{text}<link name='l'/></model>"))


# Joints at run time ----------------------------------------------------------------------------------------------


def two_links(more=""):
    return model("m", link("a", inertial(2.0)), link("b", inertial(1.0), pose="1 0 0 0 0 0"), more)


def test_a_joint_made_taken_away_and_made_again(load):
    made = load(world(two_links(), gravity="0 0 0"))
    whole = made.model("m")
    a, b = whole.GetBody("a"), whole.GetBody("b")
    hinge = whole.make_joint("j", "revolute", a, b, GzVector(0, 0, 1))
    with pytest.raises(ParameterError, match="has a joint 'j' already"):
        whole.make_joint("j", "fixed", a, b)
    b.SetLinearVel((0, 0, 1))
    made.run(0.5)
    assert b.GetPosition().z - a.GetPosition().z == pytest.approx(0.0, abs=0.2)
    hinge.detach()
    assert not hinge.attached
    b.SetLinearVel((0, 0, 5))
    made.run(0.5)
    assert b.GetPosition().z - a.GetPosition().z > 1.0
    hinge.attach(None, b)
    height = b.GetPosition().z
    made.run(0.5)
    assert b.GetPosition().z == pytest.approx(height, abs=0.02)
    assert whole.remove_joint("j")
    assert not whole.remove_joint("j")


def test_a_joint_from_an_element(load):
    made = load(world(two_links(), gravity="0 0 0"))
    text = f"<sdf version='1.6'>{model('x', link('l'), joint('slide', 'prismatic', 'a', 'b', '1 0 0'))}</sdf>"
    element = SdfFile.from_string(text).root.child("model").child("joint")
    slide = made.model("m").add_joint(element)
    slide.set_velocity(0.5)
    made.run(0.2)
    assert slide.position() == pytest.approx(0.1, abs=1e-3)


def test_moving_a_joint_moves_what_hangs_on_it(load):
    chain = model(
        "m",
        link("a", inertial()),
        link("b", inertial(), pose="1 0 0 0 0 0"),
        link("c", inertial(), pose="2 0 0 0 0 0"),
        joint("one", "revolute", "a", "b", "0 0 1", inside="<limit><lower>-2</lower><upper>2</upper></limit>"),
        joint("two", "fixed", "b", "c", ""),
        joint("root", "fixed", "world", "a", ""),
    )
    made = load(world(chain, gravity="0 0 0"))
    one = made.model("m").sdf_joints["one"]
    one.set_position(math.pi / 2)
    assert place(made.body("m", "c")) == pytest.approx((1, 1, 0), abs=1e-9)
    assert one.position() == pytest.approx(math.pi / 2)
    one.set_position(9.0)
    assert one.position() == pytest.approx(2.0)
    one.set_position(0.0)
    one.set_velocity(3.0)
    assert tuple(made.body("m", "c").GetLinearVel()) == pytest.approx((0, 3, 0))
    assert tuple(made.body("m", "a").GetLinearVel()) == (0, 0, 0)
    assert one.velocity() == pytest.approx(3.0)


def test_limits_of_effort_and_velocity(load):
    weak = "<limit><lower>-1e16</lower><upper>1e16</upper><effort>2</effort><velocity>1</velocity></limit>"
    made = load(world(two_links(joint("j", "revolute", "world", "a", "0 0 1", inside=weak)), gravity="0 0 0"))
    hinge = made.model("m").sdf_joints["j"]
    hinge.add_force(50.0)
    hinge.add_force(0.5)
    assert hinge.force() == 2.5
    made.step()
    assert hinge.velocity() == pytest.approx(0.0025)
    for _ in range(2000):
        hinge.add_force(50.0)
        made.step()
    assert hinge.velocity() == pytest.approx(1.0, abs=0.01)
    hinge.add_force(-1.0)
    assert hinge.force() == -1.0
    with pytest.raises(ParameterError, match="has no axis 1; it has 1"):
        hinge.add_force(1.0, 1)


def test_parameters_by_their_keys(load):
    ode = "<physics><ode><limit><cfm>0.1</cfm><erp>0.3</erp></limit><fudge_factor>0.5</fudge_factor></ode></physics>"
    narrow = "<limit><lower>-1</lower><upper>1</upper></limit>"
    made = load(world(two_links(joint("j", "revolute", "world", "a", "0 0 1", ode, narrow)), gravity="0 0 0"))
    hinge = made.model("m").sdf_joints["j"]
    assert [hinge.get_param(key) for key in ("stop_cfm", "stop_erp", "fudge_factor")] == [0.1, 0.3, 0.5]
    assert (hinge.get_param("lo_stop"), hinge.get_param("hi_stop")) == (-1.0, 1.0)
    hinge.set_param("hi_stop", 0.2)
    hinge.set_param("friction", 3.0)
    assert [hinge.get_param(key) for key in ("hi_stop", "friction", "fmax", "vel")] == [0.2, 3.0, 3.0, 0.0]
    with pytest.raises(ParameterError, match=r"has no 'fmx' of axis 0; keys are .*did you mean 'fmax'"):
        hinge.set_param("fmx", 1.0)
    with pytest.raises(ParameterError, match="vel is NaN"):
        hinge.set_param("vel", math.nan)


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("parent", ["world", "a"])
def test_two_axes_turn_each_by_its_own_effort(load, kind, parent):
    second = "<axis2><xyz>0 1 0</xyz><limit><lower>-0.5</lower><upper>0.5</upper></limit></axis2>"
    heavy = link("a", inertial(1e6, (1e6,) * 3))
    crossed = joint("j", kind, parent, "b", "0 0 1", second)
    made = load(world(model("m", heavy, link("b", inertial()), crossed), gravity="0 0 0"))
    cross = made.model("m").sdf_joints["j"]
    for _ in range(200):
        cross.add_force(0.5, 0)
        made.step()
    assert cross.velocity(0) == pytest.approx(0.1, rel=0.01)
    assert abs(cross.velocity(1)) < 0.01
    assert GzQuaternToEuler(made.body("m", "b").GetRotation()).z == pytest.approx(cross.position(0), abs=1e-3)
    cross.set_velocity(0.0, 0)
    for _ in range(3000):
        cross.add_force(0.5, 1)
        made.step()
    assert cross.position(1) == pytest.approx(0.5, abs=0.01)
    assert cross.axis(1).y == pytest.approx(math.cos(cross.position(0)), abs=0.01)


def test_anchors_and_axes(load):
    offset = joint("j", "revolute", "a", "b", "0 0 2", pose="-0.5 0 0 0 0 0")
    made = load(world(two_links(offset), gravity="0 0 0"))
    hinge = made.model("m").sdf_joints["j"]
    assert tuple(hinge.anchor()) == pytest.approx((0.5, 0, 0))
    assert tuple(hinge.axis()) == pytest.approx((0, 0, 1))
    hinge.set_axis(0, (1, 0, 0))
    hinge.set_anchor((0, 0, 0))
    assert tuple(hinge.axis()) == pytest.approx((1, 0, 0))
    assert tuple(hinge.anchor()) == pytest.approx((0, 0, 0))
    assert hinge.position() == 0.0


def test_a_model_put_back_where_it_began(load):
    spin = joint("j", "revolute", "world", "a", "0 0 1")
    made = load(world(two_links(spin)))
    whole = made.model("m")
    whole.sdf_joints["j"].set_velocity(30.0)
    made.run(1.0)
    assert whole.sdf_joints["j"].position() == pytest.approx(30.0, abs=0.1)
    whole.restore()
    assert whole.sdf_joints["j"].position() == 0.0
    assert place(whole.GetBody("b")) == (1, 0, 0)
    assert tuple(whole.GetBody("b").GetLinearVel()) == (0, 0, 0)


# Links -----------------------------------------------------------------------------------------------------------


def test_kinematic_links_go_on_and_push(load):
    pusher = model(
        "pusher", link("l", "<kinematic>1</kinematic>", inertial(1.0), collision("box")), pose="-2 0 0.5 0 0 0"
    )
    made = load(world(GROUND, pusher, model("box", link("l", collision("box")), pose="0 0 0.5 0 0 0")))
    made.body("pusher").SetLinearVel((1, 0, 0))
    made.run(2.0)
    assert place(made.body("pusher")) == pytest.approx((0, 0, 0.5), abs=1e-6)
    assert made.body("box").GetPosition().x == pytest.approx(1.0, abs=0.02)


def test_decay_gravity_and_products_of_inertia(load):
    slow = "<velocity_decay><linear>0.01</linear><angular>0</angular></velocity_decay>"
    skew = "<inertial><inertia><ixx>2</ixx><iyy>2</iyy><izz>2</izz><ixy>0.5</ixy></inertia></inertial>"
    made = load(
        world(
            model("slow", link("l", slow)),
            model("free", link("l", "<gravity>0</gravity>")),
            model("skew", link("l", "<gravity>0</gravity>", skew)),
        )
    )
    made.body("skew").AddTorque(1, 0, 0)
    made.step()
    expected = np.linalg.solve([[2, 0.5, 0], [0.5, 2, 0], [0, 0, 2]], (1e-3, 0, 0))
    assert tuple(made.body("skew").GetAngularRate()) == pytest.approx(tuple(expected))
    made.run(2.0)
    assert made.body("slow").GetLinearVel().z == pytest.approx(-9.8 * 0.001 * 99, rel=0.02)
    assert made.body("free").GetLinearVel().z == 0.0


# Shapes ----------------------------------------------------------------------------------------------------------

CUBE = [(x, y, z) for z in (-0.5, 0.5) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def write_obj(path):
    path.with_suffix(".mtl").write_text("newmtl red\nKd 1 0 0\n")
    lines = [f"mtllib {path.stem}.mtl", *(f"v {x} {y} {z}" for x, y, z in CUBE), "o cube", "usemtl red"]
    lines += ["f " + " ".join(f"{i + 1}//1" for i in quad) for quad in QUADS]
    path.write_text("\n".join(lines))


def write_stl(path, *, binary):
    faces = [[CUBE[q[i]] for i in (0, k, k + 1)] for q in QUADS for k in (1, 2)]
    if binary:
        rows = b"".join(struct.pack("<12fH", 0, 0, 0, *sum(face, ()), 0) for face in faces)
        path.write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + rows)
        return
    text = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*v) for v in face)
        + "endloop\nendfacet\n"
        for face in faces
    )
    path.write_text(f"solid cube\n{text}endsolid cube\n")


def write_dae(path):
    points = " ".join(f"{10 * v}" for corner in CUBE for v in corner)
    corners = " ".join(f"{i} 0" for quad in QUADS for i in quad)
    path.write_text(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>"
        "<asset><unit meter='0.1'/><up_axis>Z_UP</up_axis></asset>"
        "<library_effects><effect id='e'><profile_COMMON><technique sid='t'><lambert><diffuse>"
        "<color>0 1 0 1</color></diffuse></lambert></technique></profile_COMMON></effect></library_effects>"
        "<library_materials><material id='green'><instance_effect url='#e'/></material></library_materials>"
        "<library_geometries><geometry id='g'><mesh><source id='p'><float_array id='pa' count='24'>"
        f"{points}</float_array></source><vertices id='v'><input semantic='POSITION' source='#p'/></vertices>"
        "<polylist count='6' material='m'><input semantic='VERTEX' source='#v' offset='0'/>"
        f"<input semantic='NORMAL' source='#p' offset='1'/><vcount>4 4 4 4 4 4</vcount><p>{corners}</p></polylist>"
        "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene id='s'>"
        "<node name='away'><translate>30 0 0</translate><instance_geometry url='#g'><bind_material>"
        "<technique_common><instance_material symbol='m' target='#green'/></technique_common></bind_material>"
        "</instance_geometry></node></visual_scene></library_visual_scenes></COLLADA>"
    )


def mesh(uri, more=""):
    return f"<mesh><uri>{uri}</uri>{more}</mesh>"


@pytest.mark.parametrize("kind", ["obj", "stl", "ascii.stl", "dae"])
def test_meshes_fall_and_rest(load, tmp_path, kind):
    path, more = tmp_path / f"cube.{kind}", ""
    if kind == "obj":
        write_obj(path)
    elif kind == "dae":
        write_dae(path)
        more = "<submesh><name>away</name><center>1</center></submesh>"
    else:
        write_stl(path, binary=kind == "stl")
    shape = mesh(path.name, f"<scale>2 2 1</scale>{more}")
    made = load(world(GROUND, model("m", link("l", collision(shape)), pose="0 0 1 0 0 0")))
    made.run(1.5)
    assert place(made.body("m")) == pytest.approx((0, 0, 0.5), abs=2e-3)
    geom = made.body("m").geoms[0]
    assert np.ptp(geom.vertices, axis=0) == pytest.approx((2, 2, 1))
    assert len(geom.triangles) == 12


def test_visuals_of_meshes_have_the_colours_of_their_files(load, tmp_path):
    write_obj(tmp_path / "cube.obj")
    write_dae(tmp_path / "cube.dae")
    visuals = "".join(
        f"<visual name='{name}'><geometry>{mesh('file://' + str(tmp_path / name))}</geometry></visual>"
        for name in ("cube.obj", "cube.dae")
    )
    made = load(world(model("m", link("l", visuals))))
    drawn = made.body("m").geoms
    assert [tuple(geom.GetDiffuseColor())[:3] for geom in drawn] == [(1, 0, 0), (0, 1, 0)]
    assert drawn[1].vertices[:, 0].mean() == pytest.approx(3.0)


def test_what_is_missing_or_broken_is_told_and_left_out(load, tmp_path, caplog):
    (tmp_path / "broken.obj").write_text("v 0 0 0\nf 1 2 3\n")
    write_dae(tmp_path / "cube.dae")
    shapes = [mesh("no.dae"), mesh("broken.obj"), mesh("cube.dae", "<submesh><name>awya</name></submesh>")]
    parts = [collision(shape, name=f"c{i}") for i, shape in enumerate(shapes)]
    made = load(world(model("m", link("l", *parts))))
    made.step()
    assert made.body("m").geoms == []
    assert "Unable to find uri[no.dae]; looked for" in caplog.text
    assert "broken.obj cannot be read" in caplog.text
    assert "has no submesh 'awya'; it has away; did you mean 'away'" in caplog.text


def test_a_height_map_carries(load, tmp_path):
    slope = np.tile(np.linspace(0, 255, 17), (17, 1)).astype(np.uint8)
    Image.fromarray(slope).save(tmp_path / "slope.png")
    shape = "<heightmap><uri>slope.png</uri><size>8 8 2</size><pos>0 0 1</pos></heightmap>"
    ground = model("ground", "<static>1</static>", link("l", collision(shape)))
    balls = [
        model(f"b{i}", link("l", inertial(1.0, (0.1,) * 3), collision("sphere")), pose=f"{x} 0 {z} 0 0 0")
        for i, (x, z) in enumerate(((-2.0, 2.05), (2.0, 3.05)))
    ]
    made = load(world(ground, *balls))
    made.run(0.6)
    assert made.body("b1").GetPosition().z - made.body("b0").GetPosition().z == pytest.approx(1.0, abs=0.05)
    geom = made.model("ground").bodies[0].geoms[0]
    assert geom.vertices[:, 2].min() == 1.0
    assert geom.vertices[:, 2].max() == pytest.approx(3.0)
    assert made.engine.surface[geom.row, Surface.MAX_VEL] == 0.0
    with pytest.raises(WorldFileError, match=r"<uri> is missing|needs the <uri>"):
        load(world(model("m", link("l", collision("<heightmap/>")))))


def test_the_top_of_a_picture_lies_at_plus_y(load, tmp_path):
    picture = np.zeros((9, 9), dtype=np.uint8)
    picture[0, :] = 255
    Image.fromarray(picture).save(tmp_path / "edge.png")
    shape = "<heightmap><uri>edge.png</uri><size>8 8 1</size></heightmap>"
    made = load(world(model("g", "<static>1</static>", link("l", collision(shape)))))
    vertices = made.model("g").bodies[0].geoms[0].vertices
    assert set(vertices[vertices[:, 2] > 0.5][:, 1]) == {4.0}


def points(*corners):
    return "".join(f"<point>{x} {y}</point>" for x, y in corners)


def test_outlines_are_solids_with_holes(load):
    outer = points((0, 0), (2, 0), (2, 2), (1, 1), (0, 2), (0, 0))
    hole = points((0.8, 0.3), (1.2, 0.3), (1.2, 0.6), (0.8, 0.6))
    shape = f"<polyline>{outer}<height>0.5</height></polyline><polyline>{hole}<height>0.5</height></polyline>"
    made = load(world(model("m", "<static>1</static>", link("l", collision(shape)))))
    geom = made.model("m").bodies[0].geoms[0]
    a, b, c = (geom.vertices[geom.triangles[:, i]] for i in range(3))
    volume = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    assert volume == pytest.approx(0.5 * (3.0 - 0.12))
    ranges, rows = np.empty(3), np.empty(3, dtype=np.int64)
    rays = np.array([[x, y, 5, 0, 0, -1, 20] for x, y in ((0.5, 0.5), (1.0, 0.45), (1.0, 1.5))], dtype=float)
    made.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), rays, 0, ranges, rows)
    assert ranges[0] == pytest.approx(4.5)
    assert list(rows[1:]) == [-1, -1]
    crossed = points((0, 0), (2, 2), (2, 0), (0, 2))
    with pytest.raises(WorldFileError, match=r"cross each other|span an area"):
        load(world(model("m", link("l", collision(f"<polyline>{crossed}<height>1</height></polyline>")))))


def test_more_contacts_than_ten_on_request(load, tmp_path):
    """A ring of teeth touches the ground at many points."""
    ring = [(math.cos(a), math.sin(a)) for a in np.linspace(0, 2 * math.pi, 24, endpoint=False)]
    rows = [f"v {x} {y} {z}" for z in (0, 1) for x, y in ring]
    rows += [
        f"f {i + 1} {(i + 1) % 24 + 1} {(i + 1) % 24 + 25}\nf {i + 1} {(i + 1) % 24 + 25} {i + 25}" for i in range(24)
    ]
    (tmp_path / "ring.obj").write_text("\n".join(rows))
    for own, all_, expected in ((10, 20, 10), (18, 20, 18), (100, 20, 20), (100, 24, 24)):
        most = f"<max_contacts>{own}</max_contacts>"
        ground = collision("<plane/>", more="<max_contacts>100</max_contacts>")
        made = load(
            world(
                model("g", "<static>1</static>", link("l", ground)),
                model("m", link("l", collision(mesh("ring.obj"), more=most)), pose="0 0 -0.001 0 0 0"),
                physics=f"<max_contacts>{all_}</max_contacts>",
            )
        )
        made.step()
        assert made.engine.contact_count == expected


# State and settings ----------------------------------------------------------------------------------------------


def test_a_state_moves_inserts_and_deletes(load):
    inserted = model("late", link("l"), pose="7 0 0 0 0 0")
    state = (
        "<state world_name='default'><sim_time>3 500000000</sim_time>"
        "<model name='m'><pose>1 2 3 0 0 0</pose><link name='link'><pose>1 2 3 0 0 0.5</pose>"
        "<velocity>0 0 1 0 0 2</velocity></link></model><model name='nobody'/>"
        "<light name='lamp'><pose>0 0 9 0 0 0</pose></light>"
        f"<insertions>{inserted}</insertions><deletions><name>gone</name></deletions></state>"
    )
    lamp = "<light name='lamp' type='point'><pose>0 0 1 0 0 0</pose></light>"
    made = load(world(model("m", link("link")), model("gone", link("l")), lamp, state, gravity="0 0 0"))
    body = made.body("m")
    assert made.GetSimTime() == 3.5
    assert place(body) == (1, 2, 3)
    assert GzQuaternToEuler(body.GetRotation()).z == pytest.approx(0.5)
    assert (tuple(body.GetLinearVel()), tuple(body.GetAngularRate())) == ((0, 0, 1), (0, 0, 2))
    assert made.model("lamp").GetPose().pos.z == 9
    assert made.model("late").GetPose().pos.x == 7
    with pytest.raises(NotFoundError):
        made.model("gone")


def test_profiles_scene_and_place_on_earth(load):
    slow = "<physics name='slow' type='ode'><max_step_size>0.01</max_step_size></physics>"
    fast = "<physics name='fast' default='1' type='ode'><max_step_size>0.002</max_step_size></physics>"
    more = (
        "<magnetic_field>1 2 3</magnetic_field><scene><ambient>.1 .2 .3 1</ambient><background>.4 .5 .6 1</background>"
        "<shadows>0</shadows><fog><type>linear</type><density>.5</density><color>.4 .5 .6 1</color></fog></scene>"
        "<spherical_coordinates><surface_model>EARTH_WGS84</surface_model><latitude_deg>47.4</latitude_deg>"
        "<longitude_deg>8.5</longitude_deg><elevation>400</elevation><heading_deg>0</heading_deg></spherical_coordinates>"
    )
    made = load(f"<world name='w'>{slow}{fast}<gravity>0 0 -5</gravity>{more}{model('m', link('l'))}</world>")
    settings = settings_of(made)
    assert (made.engine.step_time, made.engine.gravity) == (0.002, (0, 0, -5))
    assert list(settings.profiles) == ["slow", "fast"]
    assert tuple(settings.magnetic_field) == (1, 2, 3)
    assert settings.spherical_coordinates.Get(float, "latitude_deg") == 47.4
    assert tuple(made.backdrop.ambient)[:3] == (0.1, 0.2, 0.3)
    assert not settings.scene.Get(bool, "shadows")
    assert (made.fogEnable, made.fogDensity, tuple(made.skyColor)[:3]) == (True, 0.5, (0.4, 0.5, 0.6))
    apply_profile(made, "slow")
    assert made.engine.step_time == 0.01
    with pytest.raises(NotFoundError, match="no physics profile 'quick'; there are slow, fast"):
        apply_profile(made, "quick")


def test_models_join_a_running_world_whole_or_not_at_all(load):
    made = load(world(GROUND))
    made.run(0.1)
    text = f"<sdf version='1.6'>{model('late', link('l', collision('box')), pose='0 0 0.5 0 0 0')}</sdf>"
    assert [m.GetId() for m in insert_sdf(made, SdfFile.from_string(text))] == ["late"]
    made.run(0.5)
    assert made.body("late").GetPosition().z == pytest.approx(0.5, abs=1e-3)
    before = list(made.models)
    bad = f"<sdf version='1.6'>{model('x', link('a'), joint('j', 'screw', 'a', 'nowhere'))}</sdf>"
    with pytest.raises(WorldFileError, match="nowhere"):
        insert_sdf(made, SdfFile.from_string(bad))
    assert made.models == before


def test_a_joint_outlives_the_model_it_held(load):
    damped = "<dynamics><damping>1</damping></dynamics>"
    holder = model("holder", link("l", inertial()), joint("j", "revolute", "other::l", "l", "0 1 0", inside=damped))
    screwed = model("screwed", link("l", inertial()), joint("s", "screw", "other::l", "l", "0 0 1"))
    made = load(world(model("other", link("l", inertial())), holder, screwed))
    made.run(0.01)
    made.DeleteModel("other")
    made.run(0.01)
    assert not made.model("holder").sdf_joints["j"].attached
    assert not made.model("screwed").sdf_joints["s"].attached
    assert made.model("holder").failed is None
    assert made.model("screwed").failed is None


def test_a_screw_is_moved_along_its_thread(load):
    pitched = joint("s", "screw", "world", "l", "0 0 1", "<thread_pitch>2</thread_pitch>")
    made = load(world(model("m", link("l", inertial()), pitched), gravity="0 0 0"))
    screw = made.model("m").sdf_joints["s"]
    screw.set_position(3.0)
    assert (screw.position(0), screw.position(1)) == pytest.approx((3.0, -1.5))
    screw.set_velocity(1.0)
    made.run(0.5)
    assert (screw.position(0), screw.position(1)) == pytest.approx((3.5, -1.75), abs=1e-3)
    screw.set_velocity(1.0, 1)
    assert screw.velocity(0) == pytest.approx(-2.0)
    screw.set_param("thread_pitch", 4.0)
    assert screw.get_param("thread_pitch") == 4.0


def test_a_wheel_on_a_suspension(load):
    """A sprung wheel gives way along the steering axis as ODE's suspension does: weight h erp / (h^2 k) at rest."""
    spring = "<physics><ode><suspension><erp>0.5</erp><cfm>0.05</cfm></suspension></ode></physics>"
    car = model(
        "car",
        link("body", inertial(10.0), pose="0 0 1 0 0 0"),
        link("wheel", inertial(1.0), pose="0 0 0.5 0 0 0"),
        joint("j", "revolute2", "body", "wheel", "0 0 1", f"<axis2><xyz>0 1 0</xyz></axis2>{spring}"),
        joint("hold", "fixed", "world", "body", ""),
    )
    made = load(world(car))
    made.run(2.0)
    stiffness = 0.5 / (0.001 * 0.05)  # erp = h k / (h k + d), cfm = 1 / (h k + d)
    assert 0.5 - made.body("car", "wheel").GetPosition().z == pytest.approx(9.8 / stiffness, rel=0.05)
    made.model("car").sdf_joints["j"].set_velocity(2.0, 1)
    made.run(0.2)
    assert made.model("car").sdf_joints["j"].position(1) == pytest.approx(0.4, abs=0.02)


def test_lights_of_links_go_with_them(load):
    lamp = "<light name='lamp' type='point'><pose>0 0 1 0 0 0</pose><diffuse>1 0 0 1</diffuse></light>"
    made = load(world(model("m", link("l", lamp), pose="2 0 0 0 0 0"), gravity="0 0 0"))
    light = made.body("m").geoms[0]
    assert tuple(light.GetPose().pos) == (2, 0, 1)
    assert tuple(light.GetDiffuseColor())[:3] == (1, 0, 0)


def test_both_forms_of_the_step_run_sdf_worlds_to_the_bit(load, monkeypatch):
    if native_path() is None:
        pytest.skip("the native step was not built: there is no C compiler here")
    bouncy = "<friction><ode><mu>.5</mu><slip1>.01</slip1><fdir1>1 0 0</fdir1></ode></friction>"
    parts = [
        model(f"b{i}", link("l", collision(shape, bouncy)), pose=f"{0.3 * i} 0 {1 + i} {0.1 * i} 0 0")
        for i, shape in enumerate(("box", "sphere", "cylinder", "box"))
    ]
    limit = "<limit><lower>-5</lower><upper>5</upper></limit><dynamics><damping>.1</damping></dynamics>"
    parts.append(two_links(joint("h", "revolute", "a", "b", "0 1 0", inside=limit)))
    bolt = link("bolt", inertial(), pose="4 0 2 0 0 0")
    parts.append(model("screw", bolt, joint("s", "screw", "world", "bolt", "0 0 1", "<thread_pitch>8</thread_pitch>")))
    parts.append(
        model(
            "cross",
            link("l", inertial(), pose="8 0 2 0 0 0"),
            joint("u", "universal", "world", "l", "1 0 0", "<axis2><xyz>0 1 0</xyz></axis2>", pose="0.3 0.2 0 0 0 0"),
        )
    )
    ends = []
    for form in ("native", "python"):
        monkeypatch.setenv("LIBGZ_STEP", form)
        made = load(world(GROUND, *parts))
        made.engine.seed = 1
        joints = [made.model(name).sdf_joints[j] for name, j in (("m", "h"), ("screw", "s"), ("cross", "u"))]
        joints[0].set_velocity(9.0)
        kept = []
        for i in range(1500):
            made.step()
            if i % 100 == 99:
                kept += [joint.position(k) for joint in joints for k in range(joint.dof)]
        ends.append((kept, made.engine.states.tobytes()))
        assert max(map(abs, kept)) > math.pi
    assert ends[0] == ends[1]


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("parent", ["world", "a"])
def test_two_axes_at_any_angle_but_none(load, kind, parent):
    for first, second in (("0 1 0", "0 0 1"), ("0 1 0", "1 0 0"), ("1 0 0", "0 1 0"), ("0 0 1", "0 1 1")):
        crossed = joint("j", kind, parent, "b", first, f"<axis2><xyz>{second}</xyz></axis2>")
        made = load(world(two_links(crossed)))
        made.body("m", "b").SetAngularVel((1, 2, 3))
        made.step(50)
        assert made.model("m").failed is None
    with pytest.raises(WorldFileError, match="must not be parallel"):
        load(world(two_links(joint("j", kind, parent, "b", "0 0 1", "<axis2><xyz>0 0 -2</xyz></axis2>"))))


def test_insane_numbers_are_told_and_do_not_end_the_process(load):
    far = inertial(1.0, (1e-9,) * 3, "1e9 0 0 0 0 0")
    rough = "<friction><ode><fdir1>1 inf 0</fdir1></ode></friction>"
    for part, told in (
        (link("l", far), "beyond what can be reckoned with"),
        (link("l", collision("box", rough)), "fdir1 is"),
        (link("l") + joint("j", "screw", "world", "l", more="<thread_pitch>0</thread_pitch>"), "thread_pitch is 0"),
        (link("l") + joint("j", "revolute", "world", "l", "0 0 0"), "an axis must not be zero"),
        (link("l") + joint("j", "revolute", "world", "l", inside="<limit><lower>nan</lower></limit>"), "not a number"),
    ):
        with pytest.raises(WorldFileError, match=told):
            load(world(model("m", part)))
    soft = "<physics><ode><limit><cfm>1e308</cfm><erp>-7</erp></limit></ode></physics>"
    made = load(world(model("m", link("l"), joint("j", "revolute", "world", "l", "1e308 0 0", soft))))
    assert made.model("m").sdf_joints["j"].get_param("stop_erp") == 0.0
    made.step(10)


def test_a_body_that_runs_away_is_halted_and_told_once(load, monkeypatch, caplog):
    stiff = "<dynamics><spring_stiffness>1e15</spring_stiffness><spring_reference>1</spring_reference></dynamics>"
    ends = []
    for form in ("python", "native") if native_path() is not None else ("python",):
        monkeypatch.setenv("LIBGZ_STEP", form)
        caplog.clear()
        made = load(world(model("m", link("l"), joint("j", "prismatic", "world", "l", "1 0 0", inside=stiff))))
        made.step(50)
        assert caplog.text.count("body m::l ran away and was halted") == 1
        assert all(map(math.isfinite, made.body("m").GetPosition()))
        ends.append(made.engine.states.tobytes())
    assert len(set(ends)) == 1


def test_parameters_that_were_set_outlive_a_new_anchor_and_axis(load):
    rod = "<link name='rod'><gravity>0</gravity></link>"
    hinge = (
        "<joint name='j' type='revolute'><parent>world</parent><child>rod</child><axis><xyz>0 0 1</xyz></axis></joint>"
    )
    made = load(world(f"<model name='m'>{rod}{hinge}</model>"))
    joint = made.model("m").sdf_joints["j"]
    joint.set_param("fmax", 50.0)
    joint.set_param("vel", 2.0)
    joint.set_anchor((0.0, 0.1, 0.0))
    joint.set_axis(0, (1, 0, 0))
    made.run(0.2)
    assert joint.velocity() == pytest.approx(2.0, abs=1e-3)
