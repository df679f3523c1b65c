"""SDF worlds on the engine: what falls, slides, swings and collides does so by the formulas."""

import math

import numpy as np
import pytest

import libgz
from libgz.base.errors import WorldFileError
from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzQuaternToEuler, GzVector
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.world import SdfWorld

GROUND = "<include><uri>model://ground_plane</uri></include>"
SHAPES = {
    "box": "<box><size>1 1 1</size></box>",
    "sphere": "<sphere><radius>0.5</radius></sphere>",
    "cylinder": "<cylinder><radius>0.5</radius><length>1</length></cylinder>",
}


@pytest.fixture(autouse=True)
def no_paths(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("GAZEBO_MODEL_PATH", raising=False)


@pytest.fixture
def load(tmp_path):
    worlds = []

    def make(body, version="1.6", **options):
        path = tmp_path / f"w{len(worlds)}.world"
        path.write_text(f"<sdf version='{version}'>{body}</sdf>")
        worlds.append(libgz.World.from_file(path, **options))
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()


def world(*parts, physics="", gravity="0 0 -9.8"):
    settings = f"<physics type='ode'>{physics}</physics><gravity>{gravity}</gravity>"
    return f"<world name='default'>{settings}{''.join(parts)}</world>"


def model(name, shape="box", pose="0 0 0 0 0 0", link="", surface="", extra=""):
    collision = f"<collision name='c'><geometry>{SHAPES[shape]}</geometry>{surface}</collision>" if shape else ""
    return f"<model name='{name}'><pose>{pose}</pose>{extra}<link name='link'>{link}{collision}</link></model>"


def friction(mu):
    return f"<surface><friction><ode><mu>{mu}</mu><mu2>{mu}</mu2></ode></friction></surface>"


@pytest.mark.parametrize(
    ("asked", "written", "used"),
    [
        ("world", "", "quick"),
        ("world", "world", "world"),
        ("tree", "", "tree"),
        ("tree", "quick", "tree"),
        ("world", "tree", "tree"),
    ],
)
def test_tree_holds_for_files_that_know_two_solvers(load, asked, written, used):
    physics = f"<ode><solver><type>{written}</type></solver></ode>" if written else ""
    assert load(world(physics=physics), solver=asked).engine.solver == used


@pytest.mark.parametrize(("asked", "used"), [("world", ["tree", "quick"]), ("tree", ["tree", "tree"])])
def test_tree_holds_for_other_profiles_if_the_world_was_made_with_it(load, asked, used):
    profile = "<physics name='{0}' type='ode'><ode><solver><type>{0}</type></solver></ode></physics>"
    made = load(f"<world name='w'>{profile.format('tree')}{profile.format('quick')}</world>", solver=asked)
    found = [made.engine.solver]
    made.extension(SdfWorld).apply_profile("quick")
    assert [*found, made.engine.solver] == used


def test_settings_of_the_world(load):
    physics = "<max_step_size>0.002</max_step_size><real_time_update_rate>1000</real_time_update_rate>"
    physics += "<ode><solver><type>world</type></solver></ode>"
    made = load(world(physics=physics, gravity="0 0 -1.6"))
    assert (made.engine.step_time, made.engine.solver, made.engine.gravity) == (0.002, "world", (0, 0, -1.6))
    assert made.simSpeed == pytest.approx(2.0)
    made.step(10)
    assert made.GetSimTime() == pytest.approx(0.02)


def test_gravity_stands_in_physics_in_older_versions(load):
    text = "<world name='w'><physics type='ode'><gravity>0 0 -3</gravity></physics></world>"
    assert load(text, "1.4").engine.gravity == (0, 0, -3)
    assert load("<world name='w'/>", "1.5").engine.gravity == (0, 0, -9.8)


@pytest.mark.parametrize("shape", list(SHAPES))
def test_dropped_things_fall_and_rest(load, shape):
    made = load(world(GROUND, model("thing", shape, "0 0 10.5 0 0 0"), gravity="0 0 -10"))
    thing, z, v = made.model("thing"), 10.5, 0.0
    for _ in range(1000):
        made.step()
        v -= 10 * 0.001
        z += v * 0.001
        assert thing.GetPose().pos.z == pytest.approx(z, abs=1e-4)
        assert thing.GetBody().GetLinearVel().z == pytest.approx(v, abs=1e-4)
    made.run(3.0)
    assert thing.GetPose().pos.z == pytest.approx(0.5, abs=1e-4)
    assert abs(thing.GetBody().GetLinearVel().z) < 0.011


def test_a_link_without_collision_falls_on(load):
    made = load(world(GROUND, model("ghost", "", "0 0 1 0 0 0")))
    made.run(1.0)
    assert made.model("ghost").GetPose().pos.z < -1


def test_inelastic_collision_shares_momentum(load):
    made = load(world(model("box", "box"), model("sphere", "sphere", "2 0 0 0 0 0"), gravity="0 0 0"))
    box, sphere = made.body("box"), made.body("sphere")
    box.AddForce(1000.0, 0, 0)
    speed = 1000.0 * 0.001
    made.run(0.99)
    assert box.GetLinearVel().x == pytest.approx(speed, abs=1e-6)
    assert sphere.GetLinearVel().x == 0.0
    made.run(1.0)
    assert box.GetLinearVel().x == pytest.approx(speed / 2, abs=0.01)
    assert sphere.GetLinearVel().x == pytest.approx(speed / 2, abs=0.01)


def test_friction_holds_or_lets_slide(load):
    boxes = [
        model(
            f"b{i}",
            "box",
            f"{3 * i} 0 0.5 0 0 0",
            surface=friction(mu),
            link="<inertial><pose>0 0 -0.4 0 0 0</pose></inertial>",
        )
        for i, mu in enumerate((0.2, 0.5, 1.2))
    ]
    made = load(world(GROUND, *boxes, gravity="0 -1 -1"))
    made.run(2.0)
    for i, mu in enumerate((0.2, 0.5, 1.2)):
        velocity = made.body(f"b{i}", "link").GetLinearVel()
        assert velocity.y == pytest.approx(min(0.0, -1 + mu) * 2.0, abs=5e-3)
        assert abs(velocity.x) < 1e-3


PENDULUM = """<model name='p'><pose>0 0 5 0 0 0</pose>
<link name='bob'><pose>1 0 0 0 0 0</pose><inertial><mass>2</mass>
<inertia><ixx>.1</ixx><iyy>.1</iyy><izz>.1</izz></inertia></inertial></link>
<joint name='j' type='revolute'><pose>-1 0 0 0 0 0</pose><parent>world</parent><child>bob</child>
<axis><xyz>0 1 0</xyz>{}</axis></joint></model>"""


def test_a_pendulum_keeps_its_energy(load):
    made = load(world(PENDULUM.format("")))
    joint, bob = made.model("p").sdf_joints["j"], made.body("p")
    inertia = 2 * 1.0**2 + 0.1
    for _ in range(2500):
        made.step()
        energy = 2 * 9.8 * (bob.GetPosition().z - 5) + inertia * joint.velocity() ** 2 / 2
        assert abs(energy) < 0.01 * 2 * 9.8
    # z = -sin(angle): the angle is the child's, about the axis.
    assert bob.GetPosition().z - 5 == pytest.approx(-math.sin(joint.position()), abs=1e-3)


def test_joint_limits_damping_springs_and_friction(load):
    limited = load(world(PENDULUM.format("<limit><lower>-0.1</lower><upper>0.5</upper></limit>")))
    limited.run(3.0)
    assert limited.model("p").sdf_joints["j"].position() == pytest.approx(0.5, abs=0.02)
    damped = load(world(PENDULUM.format("<dynamics><damping>3</damping></dynamics>"), gravity="0 0 0"))
    joint = damped.model("p").sdf_joints["j"]
    joint.add_force(1000.0)
    damped.step()
    start = joint.velocity()
    damped.run(0.5)
    assert joint.velocity() == pytest.approx(start * math.exp(-3 / 2.1 * 0.5), rel=0.01)
    spring = "<spring_stiffness>40</spring_stiffness><spring_reference>0.3</spring_reference><damping>15</damping>"
    spring = f"<dynamics>{spring}</dynamics>"
    sprung = load(world(PENDULUM.format(spring), gravity="0 0 0"))
    sprung.run(3.0)
    assert sprung.model("p").sdf_joints["j"].position() == pytest.approx(0.3, abs=5e-3)
    held = load(world(PENDULUM.format("<dynamics><friction>25</friction></dynamics>")))
    held.run(1.0)
    assert abs(held.model("p").sdf_joints["j"].position()) < 0.01


def test_axes_are_of_the_model_or_of_the_joint(load):
    turned = """<model name='m'><pose>0 0 0 0 0 1.5707963</pose><link name='a'/>
    <link name='b'><pose>1 0 0 0 0 1.5707963</pose></link>
    <joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz>{}</axis></joint></model>"""
    for version, more, expected in (
        ("1.4", "", (0, 1, 0)),  # the model's x
        ("1.6", "", (-1, 0, 0)),  # the joint's x: turned once more with the child
        ("1.6", "<use_parent_model_frame>1</use_parent_model_frame>", (0, 1, 0)),
    ):
        made = load(f"<world name='w'>{turned.format(more)}</world>", version)
        assert tuple(made.model("m").sdf_joints["j"].joint.GetAxis()) == pytest.approx(expected, abs=1e-6)


def test_sliders_and_two_axes(load):
    slider = """<model name='m'><link name='a'/><joint name='j' type='prismatic'><parent>world</parent><child>a</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-0.5</lower><upper>0.2</upper></limit></axis></joint></model>"""
    made = load(world(slider))
    made.run(2.0)
    assert made.model("m").sdf_joints["j"].position() == pytest.approx(-0.5, abs=5e-3)
    double = """<model name='m'><link name='a'/><link name='base'><inertial><mass>1e6</mass>
    <inertia><ixx>1e6</ixx><iyy>1e6</iyy><izz>1e6</izz></inertia></inertial></link>
    <joint name='j' type='{}'><parent>base</parent><child>a</child>
    <axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model>"""
    for kind in ("universal", "revolute2"):
        made = load(world(double.format(kind), gravity="0 0 0"))
        joint = made.model("m").sdf_joints["j"]
        for _ in range(100):
            joint.add_force(0.5, 0)
            made.step()
        assert joint.velocity(0) > 0.03
        assert abs(joint.velocity(1)) < 0.01
        sense = -1.0 if kind == "revolute2" else 1.0  # as in Gazebo
        assert sense * GzQuaternToEuler(made.body("m").GetRotation()).z > 1e-3


def test_static_models_stand_and_can_be_stood_on(load):
    table = model("table", "box", "0 0 1 0 0 0", extra="<static>true</static>")
    made = load(world(table, model("ball", "sphere", "0.1 0 2.2 0 0 0")))
    made.run(1.0)
    assert made.model("table").GetPose().pos.z == 1.0
    assert made.model("ball").GetPose().pos.z == pytest.approx(2.0, abs=1e-3)


def test_inertials_are_what_the_file_says(load):
    inertial = """<inertial><pose>0.1 0 0 0 0 1.5707963</pose><mass>3</mass>
    <inertia><ixx>1</ixx><iyy>2</iyy><izz>2.5</izz>
    <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"""
    made = load(world(model("m", "box", "1 2 3 0 0 0", link=inertial)))
    mass = made.body("m").GetMass()
    assert mass.mass == 3
    assert (mass.I[0], mass.I[5], mass.I[10]) == pytest.approx((2, 1, 2.5), abs=1e-6)  # turned by a quarter
    assert tuple(made.body("m").GetCoMPose().pos) == pytest.approx((1.1, 2, 3))
    assert tuple(made.model("m").GetPose().pos) == pytest.approx((1, 2, 3))


def test_the_model_frame_may_be_apart_from_its_first_link(load):
    link = "<pose>1 0 0 0 0 1.5707963</pose>"
    made = load(world(model("m", "box", "0 0 5 0 0 1.5707963", link=link), gravity="0 0 0"))
    assert tuple(made.model("m").GetPose().pos) == pytest.approx((0, 0, 5), abs=1e-6)
    assert tuple(made.body("m").GetPosition()) == pytest.approx((0, 1, 5), abs=1e-6)
    made.SetModelPose(made.model("m"), GzPose(GzVector(2, 0, 0), GzQuaternFromEuler(0, 0, 0)))
    assert tuple(made.body("m").GetPosition()) == pytest.approx((3, 0, 0), abs=1e-6)
    made.reset()
    assert tuple(made.body("m").GetPosition()) == pytest.approx((0, 1, 5), abs=1e-6)


def test_self_collision_on_request(load):
    for wish, apart in (("", False), ("<self_collide>true</self_collide>", True)):
        collision = f"<collision name='c'><geometry>{SHAPES['box']}</geometry></collision>"
        links = "".join(
            f"<link name='{name}'><pose>0 0 {z} 0 0 0</pose>{collision}</link>"
            for name, z in (("low", 0.5), ("high", 1.6))
        )
        made = load(world(GROUND, f"<model name='m'>{wish}{links}</model>"))
        made.run(1.0)
        assert (made.body("m", "high").GetPosition().z > 1.4) == apart


def test_nested_models_and_lights(load):
    inner = model("inner", "box", "0 0 2 0 0 0")
    outer = f"<model name='outer'><pose>1 0 0 0 0 0</pose><link name='l'/>{inner}</model>"
    made = load(world("<include><uri>model://sun</uri></include>", outer, gravity="0 0 0"))
    assert tuple(made.model("outer::inner").GetPose().pos) == pytest.approx((1, 0, 2))
    assert made.model("sun").GetPose().pos.z == 10


def test_models_alone_in_a_file(load):
    made = load(model("alone", "box", "0 0 4 0 0 0"))
    made.step(10)
    assert made.model("alone").GetPose().pos.z < 4


def test_joints_that_cannot_be_made_are_left_out_and_names_that_are_taken_replaced(load, caplog):
    hinge = "<joint name='{}' type='{}'><parent>a</parent><child>{}</child><axis><xyz>0 0 1</xyz></axis></joint>"
    rows = [("j", "piston", "a_1"), ("k", "revolute", "nowhere"), ("l", "revolute", "a"), *2 * [("m", "revolute", "n")]]
    joints = "".join(hinge.format(*row) for row in rows)
    links = "<link name='a'/><link name='a'><pose>2 0 0 0 0 0</pose></link><link name='n'/>"
    made = load(world(f"<model name='m'>{links}<model name='n'><link name='o'/></model>{joints}</model>"))
    found = made.model("m")
    assert list(found.link_names()) == ["a", "a_1", "n", "n_1::o"]
    assert found.find_link("a_1").GetPose().pos.x == 2.0
    assert list(found.sdf_joints) == ["m"]
    for said in (
        "<link>: 'a' is the name of another <link>, at ",
        "; it is 'a_1' here",
        "<model>: 'n' is the name of another <link>, at ",
        "type 'piston' is not a kind of joint here; allowed are revolute, prismatic",
        "<child> names link 'nowhere'; there are a",
        "cannot join body 'm::a' with itself; it is left out",
        "model 'm' has a joint 'm' already; it is left out",
    ):
        assert said in caplog.text
    made.step(10)


def test_of_two_models_of_a_name_in_a_world_the_first_is_built(load, caplog):
    parts = model("m", "box", "0 0 4 0 0 0"), model("m", "sphere", "3 0 4 0 0 0"), "<light name='m' type='point'/>"
    made = load(world(*parts, "<include><uri>model://ground_plane</uri><name>m</name></include>"))
    assert [entity.GetPose().pos.x for entity in made.entities if isinstance(entity, SdfModel)] == [0.0]
    assert caplog.text.count("<model>: 'm' is the name of another <model>, at ") == 2
    assert caplog.text.count("; it is left out") == 2


def test_a_joint_of_the_world_that_cannot_be_made_is_left_out(load, caplog):
    joint = "<joint name='{}' type='{}'><parent>world</parent><child>m::link</child></joint>"
    made = load(world(model("m", "box"), joint.format("j", "piston"), joint.format("k", "fixed")))
    assert list(made.model("world_joints").sdf_joints) == ["k"]
    assert "w0.world:1: <joint>: type 'piston' is not a kind of joint here" in caplog.text
    assert "; it is left out" in caplog.text


def test_a_wrong_number_is_told_with_its_place(load):
    with pytest.raises(WorldFileError, match=r"w0\.world:1: <max_step_size>: 'z' .* must be a number"):
        load("<world name='w'><physics type='ode'><max_step_size>z</max_step_size></physics></world>")


def test_a_state_with_a_wrong_number_has_no_effect_from_there_on(load, caplog):
    state = "<state world_name='w'><sim_time>soon</sim_time><model name='m'><pose>9 0 0 0 0 0</pose></model></state>"
    made = load(f"<world name='w'><model name='m'><link name='l'/></model>{state}</world>")
    assert made.model("m").GetPose().pos.x == 0.0
    assert "w0.world:1: <state>: <sim_time>: 'soon' is not allowed; it must be seconds" in caplog.text


@pytest.mark.parametrize("xmlns", ["", " xmlns:old='http://old'"])
def test_a_state_may_have_names_with_prefixes(load, xmlns):
    state = f"<state world_name='w'><model name='m'><pose>9 0 0 0 0 0</pose><old:more{xmlns}/></model></state>"
    made = load(f"<world name='w'><model name='m'><link name='l'/></model>{state}</world>")
    assert made.model("m").GetPose().pos.x == 9.0


@pytest.mark.parametrize(
    "key", ["max_step_size", "real_time_update_rate", "real_time_factor", "sor", "erp", "kp", "mu"]
)
def test_what_is_no_number_is_one_warning_at_its_element(load, key, caplog):
    ode = f"<ode><solver>{_given('sor', key)}</solver><constraints>{_given('erp', key)}</constraints></ode>"
    physics = "".join(_given(name, key) for name in ("max_step_size", "real_time_update_rate", "real_time_factor"))
    surface = (
        f"<surface><contact><ode>{_given('kp', key)}</ode></contact>"
        f"<friction><ode>{_given('mu', key)}</ode></friction></surface>"
    )
    geometry = "<geometry><sphere><radius>1</radius></sphere></geometry>"
    body = f"<model name='m'><link name='l'><collision name='c'>{geometry}{surface}</collision></link></model>"
    load(f"<world name='w'><physics type='ode'>{physics}{ode}</physics>{body}</world>")
    assert caplog.text.count(f"w0.world:1: <{key}>: 'nan' is read as '") == 1


def _given(name, key):
    return f"<{name}>nan</{name}>" if name == key else ""


@pytest.mark.parametrize(
    ("inside", "said"),
    [
        ("<real_time_update_rate>-1</real_time_update_rate>", "<real_time_update_rate>: -1.0 is not allowed; 0.0 is"),
        ("<max_contacts>-1</max_contacts>", "<max_contacts>: -1 is not allowed; 0 is used instead"),
        ("<ode><solver><iters>-3</iters></solver></ode>", "<iters>: -3 is not allowed; 1 is used instead"),
    ],
)
def test_a_negative_number_of_physics_that_is_replaced_is_a_warning(load, caplog, inside, said):
    made = load(f"<world name='w'><physics type='ode'>{inside}</physics></world>")
    assert said in caplog.text
    assert made.simSpeed >= 0.0


def test_a_pose_at_infinity_is_one_message(load, caplog):
    load("<world name='w'><model name='m'><pose>0 0 0 1e400 0 0</pose><link name='l'/></model></world>")
    assert caplog.text.count("w0.world:1: <pose>: '0 0 0 1e400 0 0' is read as '0 0 0 0 0 0'") == 1


def test_a_wrong_number_does_not_hide_what_else_is_wrong(load):
    with pytest.raises(WorldFileError) as caught:
        load("<world name='w'><physics><max_step_size>z</max_step_size></physics><model/></world>")
    assert "<max_step_size>: 'z' is not allowed; it must be a number" in str(caught.value)
    assert "attribute 'name' is missing" in str(caught.value)


def test_unknown_shapes_and_engines_are_warnings(load, caplog):
    shape = "<geometry><image><uri>x.png</uri></image></geometry>"
    body = f"<model name='m'><link name='l'><collision name='c'>{shape}</collision></link></model>"
    made = load("<world name='w'><physics type='bullet'/>" + body + "</world>")
    made.step()
    assert "<image>: this shape is not simulated, and is left out; box, sphere" in caplog.text
    assert "type 'bullet' is not supported; ODE is used instead" in caplog.text


def test_collisions_are_seen_by_rays_and_visuals_are_not(load):
    visual = f"<visual name='v'><pose>-2 0 0 0 0 0</pose><geometry>{SHAPES['box']}</geometry></visual>"
    made = load(world(model("m", "box", "5 0 0 0 0 0", link=visual), gravity="0 0 0"))
    ranges, rows = np.empty(1), np.empty(1, dtype=np.int64)
    made.engine.scan(np.array([0, 0, 0, 1.0, 0, 0, 0]), np.array([[0, 0, 0, 1.0, 0, 0, 20]]), 0, ranges, rows)
    assert ranges[0] == pytest.approx(4.5)
    drawn = [g for g in made.engine.geoms.values() if g.appearance.visible]
    assert len(drawn) == 1


def test_the_command_runs_sdf_worlds(gazebo, tmp_path):
    path = tmp_path / "drop.world"
    path.write_text(f"<sdf version='1.6'>{world(GROUND, model('m', 'box', '0 0 2 0 0 0'))}</sdf>")
    server = gazebo(path, "-n")
    with libgz.Client(server.id) as client:
        sim = client.sim()
        while sim.sim_time < 0.5:
            assert client.wait(timeout=10.0)
    assert server.stop()[0] == 0
