"""Joints of SDF: between models, at run time, with two axes, screws and suspensions."""

import math

import pytest
from sdf_worlds import inertial, joint, link, model, place, two_links, world

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzQuaternToEuler, GzVector
from libgz.sdf.reader import SdfFile
from libgz.sdfworld.axis import Axis


def test_joints_to_other_models_and_in_the_world(load, caplog):
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
    made = load(world(post, swing.replace("post::top", "post::foot")))
    assert not made.model("swing").sdf_joints
    assert (
        "<parent> names link 'post::foot'; model 'post' has no link 'foot'; it has top; it is left out" in caplog.text
    )


def test_a_joint_made_taken_away_and_made_again(load):
    made = load(world(two_links(), gravity="0 0 0"))
    whole = made.model("m")
    a, b = whole.GetBody("a"), whole.GetBody("b")
    hinge = whole.make_joint("j", "revolute", a, b, Axis(GzVector(0, 0, 1)))
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
    assert tuple(made.body("m", "b").GetAngularRate()) == pytest.approx((0, 0, 3))
    assert tuple(made.body("m", "c").GetAngularRate()) == (0, 0, 0)  # as in Gazebo, the child alone
    assert tuple(made.body("m", "a").GetLinearVel()) == (0, 0, 0)
    assert one.velocity() == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("kind", "linear", "angular"),
    [("revolute", (1.0, 2.0, -0.5), (0.0, 0.5, 5.0)), ("prismatic", (1.0, 0.0, 3.0), (7.0, 7.0, 7.0))],
)
def test_a_velocity_that_is_set_is_against_the_parent(load, kind, linear, angular):
    """As in Gazebo: a hinge leaves its child nothing of its own motion; a slider lets it turn on."""
    links = link("a", inertial()), link("b", inertial(), pose="1 0 0 0 0 0")
    made = load(world(model("m", *links, joint("j", kind, "a", "b", "0 0 1")), gravity="0 0 0"))
    parent, child = made.body("m", "a"), made.body("m", "b")
    parent.SetLinearVel((1, 0, 0))
    parent.SetAngularVel((0, 0.5, 2))
    child.SetLinearVel((7, 7, 7))
    child.SetAngularVel((7, 7, 7))
    made.model("m").sdf_joints["j"].set_velocity(3.0)
    assert tuple(child.GetLinearVel()) == pytest.approx(linear)
    assert tuple(child.GetAngularRate()) == pytest.approx(angular)


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
    sense = -1.0 if kind == "revolute2" else 1.0
    assert GzQuaternToEuler(made.body("m", "b").GetRotation()).z == pytest.approx(sense * cross.position(0), abs=1e-3)
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
    screw.set_param("thread_pitch", 4.0)  # as measured in Gazebo 11.1: the value is kept, and has no effect
    assert screw.get_param("thread_pitch") == 4.0
    made.run(0.5)
    assert screw.position(1) == pytest.approx(-screw.position(0) / 2.0, abs=1e-3)
    screw.set_position(1.0)
    assert (screw.position(0), screw.position(1)) == pytest.approx((1.0, -0.5), abs=1e-3)


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


@pytest.mark.parametrize("kind", ["universal", "revolute2"])
@pytest.mark.parametrize("parent", ["world", "a"])
def test_two_axes_at_any_angle_but_none(load, kind, parent, caplog):
    for first, second in (("0 1 0", "0 0 1"), ("0 1 0", "1 0 0"), ("1 0 0", "0 1 0"), ("0 0 1", "0 1 1")):
        crossed = joint("j", kind, parent, "b", first, f"<axis2><xyz>{second}</xyz></axis2>")
        made = load(world(two_links(crossed)))
        made.body("m", "b").SetAngularVel((1, 2, 3))
        made.step(50)
        assert made.model("m").failed is None
    made = load(world(two_links(joint("j", kind, parent, "b", "0 0 1", "<axis2><xyz>0 0 -2</xyz></axis2>"))))
    assert not made.model("m").sdf_joints
    assert "must not be parallel" in caplog.text


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


def test_a_joint_that_begins_to_act_is_updated_from_the_next_step_on(load):
    """Models are updated in Python only while a joint acts by itself."""
    implicit = "<physics><ode><implicit_spring_damper>1</implicit_spring_damper></ode></physics>"
    made = load(world(two_links(joint("j", "revolute", "a", "b", "0 1 0", implicit)), gravity="0 0 0"))
    hinge = made.model("m").sdf_joints["j"]
    made.step()
    assert not hinge.acts
    assert not made.rows.updating
    hinge.set_velocity(1.0)
    hinge.set_spring(0, 1e7, 0.0)
    made.step(200)
    assert hinge.acts
    assert abs(hinge.position()) < 0.01  # [rad]; 0.2 without the spring
    hinge.set_spring(0, 0.0, 0.0)
    made.step()
    assert not made.rows.updating


def test_a_state_holds_again_what_was_detached_though_names_are_equal(load):
    """A joint of the engine that is made anew comes last, after one of the same name."""
    hung = [
        model(name, link("link", inertial()), joint("seam", "fixed", "world", "link", axis=""), pose=f"{x} 0 5 0 0 0")
        for x, name in enumerate(("first", "second"))
    ]
    made = load(world(*hung))
    made.step(10)
    state = made.get_state()
    made.model("first").sdf_joints["seam"].detach()
    made.step(100)
    assert made.body("first").GetPosition().z < 4.99
    made.set_state(state)
    made.step(100)
    assert [made.body(name).GetPosition().z for name in ("first", "second")] == pytest.approx([5.0, 5.0], abs=1e-9)
    made.model("first").sdf_joints["seam"].detach()
    made.step(100)
    assert made.body("first").GetPosition().z < 4.99
    assert made.body("second").GetPosition().z == pytest.approx(5.0, abs=1e-9)


def test_a_joint_begins_where_its_links_are_as_in_gazebo(load, caplog):
    """Gazebo 11 does not use `<initial_position>`."""
    swing = joint("j", "revolute", "world", "l", "0 1 0", inside="<initial_position>0.5</initial_position>")
    made = load(world(model("m", link("l", inertial()), swing), gravity="0 0 0"))
    made.step(10)
    assert made.model("m").sdf_joints["j"].position() == 0.0
    assert "<initial_position> has no effect" in caplog.text


@pytest.mark.parametrize("kind", ["fixed", "ball"])
def test_a_fixed_or_ball_joint_is_not_softened_as_in_gazebo(load, caplog, kind):
    soft = "<physics><ode><cfm>1</cfm><erp>.1</erp></ode></physics>"
    made = load(world(model("m", link("l", inertial()), joint("j", kind, "world", "l", "", soft))))
    made.step(500)
    assert place(made.body("m")) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert "softens" not in caplog.text


def test_an_implicit_spring_on_one_of_two_axes_leaves_the_other_free(load):
    """A division by zero ended the first step."""
    spring = "<dynamics><spring_stiffness>5000</spring_stiffness><spring_reference>0</spring_reference></dynamics>"
    wish = "<physics><ode><implicit_spring_damper>1</implicit_spring_damper></ode></physics>"
    second = "<axis2><xyz>0 0 1</xyz></axis2>"
    holder = joint("f", "fixed", "world", "a", "")
    arm = link("b", inertial(1.0, (1.0, 1.0, 1.0)), pose="1 0 0 0 0 0")
    parts = joint("u", "universal", "a", "b", "0 1 0", second + wish, spring, "-1 0 0 0 0 0")
    made = load(world(model("m", link("a", inertial()), arm, holder, parts)))
    body = made.model("m").GetBody("b")
    body.SetAngularVel((0, 0, 1))
    made.step(200)
    found = made.model("m").sdf_joints["u"]
    assert abs(found.position(0)) < 0.01
    assert found.velocity(1) == pytest.approx(0.5, rel=0.01)  # of m r^2 + I = 2, half is about its own centre
