"""SDF models beyond single links: nested ones, links, states, settings, models that join, insane numbers."""

import contextlib
import math

import numpy as np
import pytest
from sdf_worlds import GROUND, collision, inertial, joint, link, model, place, world

from libgz.base.errors import ClosedError, NotFoundError, WorldFileError, listed
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.physics import mass
from libgz.physics.body import Body
from libgz.physics.space import Space
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.world import SdfWorld

# Nested models ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("own", "static"), [("", True), ("<static>0</static>", False), ("<static>1</static>", True)])
def test_a_model_that_includes_a_static_one_is_static_unless_it_states_otherwise(load, tmp_path, caplog, own, static):
    (tmp_path / "shelf").mkdir()
    (tmp_path / "shelf" / "model.config").write_text("<model><name>shelf</name><sdf version='1.6'>m.sdf</sdf></model>")
    shelf = model("shelf", "<static>1</static>", link("frame"))
    (tmp_path / "shelf" / "m.sdf").write_text(f"<sdf version='1.6'>{shelf}</sdf>")
    include = f"<include><uri>file://{tmp_path}/shelf</uri></include>"
    made = load(world(model("cell", own, include, link("crate", inertial()), pose="0 0 5 0 0 0")))
    made.run(0.1)
    assert (made.body("cell", "crate").GetPosition().z == 5.0) == static
    assert made.model("cell").static == static
    assert [body.bodyName for body in made.model("cell").bodies] == ["shelf::frame", "crate"]
    assert ("is static as a whole" in caplog.text) == (own == "")


ARM = """<link name='base'/><link name='hand'/>
<joint name='turn' type='revolute'><parent>world</parent><child>hand</child>
<axis><xyz>0 1 0</xyz><use_parent_model_frame>1</use_parent_model_frame></axis></joint>
<plugin name='base' filename='libnone.so'><link_name>hand</link_name><size>hands</size></plugin>"""


@pytest.mark.parametrize("version", ["1.4", "1.6", "1.8"])
def test_parts_of_an_included_model_belong_to_the_model_around_it_up_to_version_1_7(load, tmp_path, version):
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "model.config").write_text("<model><name>arm</name><sdf version='1.6'>m.sdf</sdf></model>")
    (tmp_path / "arm" / "m.sdf").write_text(f"<sdf version='1.6'>{model('arm', ARM)}</sdf>")
    include = f"<include><name>left</name><uri>file://{tmp_path}/arm</uri><pose>0 0 1 0 0 .5</pose></include>"
    tip = link("tip", inertial()) + joint("hold", "fixed", "left::hand", "tip")
    text = world(model("robot", include, tip, pose="1 2 3 0 0 .3"), gravity="0 0 0")
    made = load(text, version)
    robot = made.model("robot")
    assert place(robot.GetBody("left::hand")) == pytest.approx((1, 2, 4))
    assert "hold" in robot.sdf_joints
    if version == "1.8":
        assert [one.GetId() for one in made.entities] == ["robot", "robot::left"]
        return
    assert [one.GetId() for one in made.entities] == ["robot"]
    assert [body.bodyName for body in robot.bodies] == ["left::base", "left::hand", "tip"]
    assert tuple(robot.sdf_joints["left::turn"].axis(0)) == pytest.approx((-math.sin(0.8), math.cos(0.8), 0))
    plugin = next(SdfFile.from_string(f"<sdf version='{version}'>{text}</sdf>").root.find("plugin"))
    assert (plugin.Get(str, "name"), plugin.Get(str, "link_name"), plugin.Get(str, "size")) == (
        "left::base", "left::hand", "hands",
    )  # fmt: skip


def test_a_long_name_of_an_included_model_is_bounded_with_those_of_its_parts(tmp_path):
    (tmp_path / "many").mkdir()
    (tmp_path / "many" / "model.config").write_text("<model><name>many</name><sdf version='1.6'>m.sdf</sdf></model>")
    many = model("many", "".join(f"<link name='l{number}'/>" for number in range(300)))
    (tmp_path / "many" / "m.sdf").write_text(f"<sdf version='1.6'>{many}</sdf>")
    include = f"<include><name>{'n' * (1 << 20)}</name><uri>file://{tmp_path}/many</uri></include>"
    read = SdfFile.from_string(f"<sdf version='1.6'>{world(model('robot', include))}</sdf>")
    assert [one.message for one in read.diagnostics.errors] == ["includes have more than 256 MiB together"]


def test_a_joint_may_be_named_world(load):
    named = "<frame name='f' attached_to='leaf'/>" + joint("world", "fixed", "world", "f")
    made = load(world(model("door", link("leaf", inertial()), named)))
    assert set(made.model("door").sdf_joints) == {"world"}


@pytest.mark.parametrize("iterations", [0, 5])
def test_iterations_with_a_preconditioner_are_a_warning(load, caplog, iterations):
    load(world(physics=f"<ode><solver><precon_iters>{iterations}</precon_iters></solver></ode>"))
    assert ("w0.world:1: <solver>: precon_iters has no effect" in caplog.text) == (iterations > 0)


def test_an_axis_of_a_fixed_joint_has_no_effect(load):
    made = load(world(model("m", link("a"), link("b"), joint("j", "fixed", "a", "b", "0 0 1"))))
    assert made.model("m").sdf_joints["j"].dof == 0


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


@pytest.mark.parametrize("kind", ["model", "light"])
def test_what_cannot_be_inserted_leaves_nothing_in_the_engine(load, kind):
    """As with a pose of a message; a space that is left would later be taken for that of another model."""
    made = load(world(model("m", link("l", collision()))))
    engine = made.engine
    before = [len(things) for things in (engine.spaces, engine.bodies, engine.dummies, engine.geoms)]
    inside = f"<link name='l'>{collision()}</link>" if kind == "model" else ""
    file = SdfFile.from_string(f"<sdf version='1.6'><{kind} name='new'>{inside}</{kind}></sdf>")
    file.root.child(kind).AddElement("pose").Set(GzPose(GzVector(1.0, math.nan, 0.0)))
    with pytest.raises(WorldFileError, match="is not a GzPose"):
        made.extension(SdfWorld).insert(file)
    assert [len(things) for things in (engine.spaces, engine.bodies, engine.dummies, engine.geoms)] == before


def test_a_geom_that_cannot_be_moved_stays_where_it_was(load):
    """ODE ends the process for a geom that is taken out of a space that it is not in."""
    made = load(world(model("m", link("l", collision()))))
    (geom,) = made.body("m", "l").geoms
    closed, other = Space(made.engine), Space(made.engine)
    closed.close()
    with pytest.raises(ClosedError, match="this space was closed"):
        geom.move_to(closed)
    geom.move_to(other)
    assert geom.space is other


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
    settings = made.extension(SdfWorld).settings
    assert (made.engine.step_time, made.engine.gravity) == (0.002, (0, 0, -5))
    assert list(settings.profiles) == ["slow", "fast"]
    assert tuple(settings.magnetic_field) == (1, 2, 3)
    assert settings.spherical_coordinates.Get(float, "latitude_deg") == 47.4
    assert tuple(made.backdrop.ambient)[:3] == (0.1, 0.2, 0.3)
    assert not settings.scene.Get(bool, "shadows")
    assert (made.fogEnable, made.fogDensity, tuple(made.skyColor)[:3]) == (True, 0.5, (0.4, 0.5, 0.6))
    made.extension(SdfWorld).apply_profile("slow")
    assert made.engine.step_time == 0.01
    with pytest.raises(NotFoundError, match="no physics profile 'quick'; there are slow, fast"):
        made.extension(SdfWorld).apply_profile("quick")


def test_models_join_a_running_world_whole_or_not_at_all(load, monkeypatch):
    made = load(world(GROUND))
    made.run(0.1)
    text = f"<sdf version='1.6'>{model('late', link('l', collision('box')), pose='0 0 0.5 0 0 0')}</sdf>"
    assert [m.GetId() for m in made.extension(SdfWorld).insert(SdfFile.from_string(text))] == ["late"]
    made.run(0.5)
    assert made.body("late").GetPosition().z == pytest.approx(0.5, abs=1e-3)
    before = list(made.models)
    monkeypatch.setattr("libgz.sdfworld.model.SdfModel._decay", lambda *_: [][0])
    with pytest.raises(WorldFileError, match="<link>: libgz cannot handle it"):
        made.extension(SdfWorld).insert(SdfFile.from_string(f"<sdf version='1.6'>{model('x', link('a'))}</sdf>"))
    assert made.models == before


def test_lights_of_links_go_with_them(load):
    lamp = "<light name='lamp' type='point'><pose>0 0 1 0 0 0</pose><diffuse>1 0 0 1</diffuse></light>"
    made = load(world(model("m", link("l", lamp), pose="2 0 0 0 0 0"), gravity="0 0 0"))
    light = made.body("m").geoms[0]
    assert tuple(light.GetPose().pos) == (2, 0, 1)
    assert tuple(light.GetDiffuseColor())[:3] == (1, 0, 0)


def test_insane_numbers_are_replaced_and_do_not_end_the_process(load, caplog):
    far = inertial(1.0, (1e-9,) * 3, "1e9 0 0 0 0 0")
    rough = "<friction><ode><fdir1>1 inf 0</fdir1></ode></friction>"
    for part, told in (
        (link("l", far), "the centre of mass is too far away; the link's origin is used instead"),
        (link("l", inertial(-1.0)), "mass is -1; 1 kg is used instead"),
        (link("l", inertial(1.0, ("nan", "nan", "nan"))), "<ixx>: 'nan' is read as '1.0'"),
        (link("l", collision("box", rough)), "'1 inf 0' is read as '1 0 0'"),
        (link("l") + joint("j", "screw", "world", "l", more="<thread_pitch>0</thread_pitch>"), "'0' is out of range"),
        (
            link("l") + joint("j", "revolute", "world", "l", inside="<limit><lower>nan</lower></limit>"),
            "'nan' is read as '-1e16'",
        ),
    ):
        made = load(world(model("m", part)))
        made.step(10)
        assert told in caplog.text
    soft = "<physics><ode><limit><cfm>1e308</cfm><erp>-7</erp></limit></ode></physics>"
    made = load(world(model("m", link("l"), joint("j", "revolute", "world", "l", "1e308 0 0", soft))))
    assert made.model("m").sdf_joints["j"].get_param("stop_erp") == 0.0
    made.step(10)


def test_a_body_that_runs_away_is_halted_and_told_once(load, caplog):
    stiff = "<dynamics><spring_stiffness>1e15</spring_stiffness><spring_reference>1</spring_reference></dynamics>"
    made = load(world(model("m", link("l"), joint("j", "prismatic", "world", "l", "1 0 0", inside=stiff))))
    made.step(50)
    assert caplog.text.count("body m::l diverged; its velocity was reset") == 1
    assert all(map(math.isfinite, made.body("m").GetPosition()))


def test_a_place_on_earth_must_be_finite(load, caplog):
    where = "<spherical_coordinates><heading_deg>inf</heading_deg></spherical_coordinates>"
    load(world(where))
    assert "<heading_deg>: 'inf' is out of range; '0.0' is used" in caplog.text


def test_links_that_are_rods_to_the_last_bits_of_their_moments_load_with_a_warning(load, caplog):
    turn, centre = 0.0133, "1e-7 0.07 -0.005 0 0 0"
    c, s = math.cos(turn), math.sin(turn)
    rod = f"<ixx>1e-3</ixx><iyy>{1e-3 * c * c!r}</iyy><izz>{1e-3 * s * s!r}</izz><iyz>{1e-3 * s * c!r}</iyz>"
    inside = f"<inertial><pose>{centre}</pose><mass>0.2</mass><inertia>{rod}</inertia></inertial>"
    made = load(world(model("m", link("l", inside, collision()))))
    made.step(100)
    assert (
        "they are not positive definite, or singular but for rounding; 1 kg m^2 about each axis is used" in caplog.text
    )
    assert all(map(math.isfinite, made.body("m").GetPosition()))


def test_static_links_need_no_mass(load, caplog):
    empty = inertial(0.0, ("nan", "nan", "nan"))
    wall = "<static>true</static>" + link("l", empty, collision())
    made = load(world(model("wall", wall), model("box", link("l", inertial(), collision()), pose="0 0 1 0 0 0")))
    made.step(200)
    assert place(made.body("box"))[2] == pytest.approx(1.0, abs=1e-3)


def test_the_time_of_a_new_geom_does_not_grow_with_their_number(load, monkeypatch):
    counted, moved = [], mass.moved
    monkeypatch.setattr(mass, "moved", lambda *given: counted.append(given) or moved(*given))
    load(model("m", link("l", *(collision(name=f"c{i}") for i in range(60)))))
    assert 60 <= len(counted) < 10 * 60  # 60 squared if each new one added up all


@pytest.mark.parametrize("given", ["", inertial(pose="0.1 0.2 0.3 0 0 0")])
def test_a_body_is_the_same_however_its_geoms_are_added(load, monkeypatch, given):
    def numbers():
        shapes = [collision(name=f"c{i}", pose=f"0.{i} 0.3 {i} 0.1 0.2 0.{i}") for i in range(7)]
        world = load(model("m", link("l", given, *shapes, pose="0.1 0.2 0.3 0.4 0.5 0.6"), pose="0.7 3 9 1 2 3"))
        body = world.model("m").GetBody("l")
        places = [number for geom in body.geoms for corner in geom.bounds() for number in corner]
        return [*body.GetPose().pos, *body.GetPose().rot, *body.com, *places]

    together = numbers()
    monkeypatch.setattr(Body, "assembly", lambda body: contextlib.nullcontext())
    assert together == numbers()
    assert len(set(together)) > 20


def test_names_in_messages_are_bounded():
    assert listed([]) == "none"
    assert listed(["a", "b"]) == "a, b"
    assert listed(str(i) for i in range(10**6)).endswith("198, 199, ...")
