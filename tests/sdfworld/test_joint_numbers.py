"""Figures that Gazebo classic's own tests asked of joints: pendulums, springs, forces, screws, gears, motors."""

import math

import pytest
from sdf_worlds import GROUND, Loader, collision, inertial, joint, link, model, world

from libgz.base.geometry import GzQuaternToEuler


@pytest.fixture
def load(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    loader = Loader(tmp_path)
    yield loader
    loader.close()


def limits(low, high, more=""):
    return f"<limit><lower>{low}</lower><upper>{high}</upper>{more}</limit>"


def dynamics(**values):
    return "<dynamics>" + "".join(f"<{key}>{value}</{key}>" for key, value in values.items()) + "</dynamics>"


def pendulum(inside="", more="", arm=1.0, mass=2.0, moment=0.1, kind="revolute"):
    """A bob `arm` ahead of a hinge about y at z 20."""
    bob = link("bob", inertial(mass, (moment,) * 3), pose=f"{arm} 0 0 0 0 0")
    hinge = joint("j", kind, "world", "bob", "0 1 0", more, inside, pose=f"{-arm} 0 0 0 0 0")
    return model("p", bob, hinge, pose="0 0 20 0 0 0")


def swing(angle, rate, steps, step, damping, weight, inertia):
    """The pendulum's angle and rate by Runge and Kutta's method: inertia a = weight cos(angle) - damping rate."""

    def slope(state):
        return state[1], (weight * math.cos(state[0]) - damping * state[1]) / inertia

    state = (angle, rate)
    for _ in range(steps):
        k1 = slope(state)
        k2 = slope([s + step / 2 * k for s, k in zip(state, k1, strict=True)])
        k3 = slope([s + step / 2 * k for s, k in zip(state, k2, strict=True)])
        k4 = slope([s + step * k for s, k in zip(state, k3, strict=True)])
        state = tuple(
            s + step / 6 * (a + 2 * b + 2 * c + d) for s, a, b, c, d in zip(state, k1, k2, k3, k4, strict=True)
        )
    return state


@pytest.mark.parametrize("implicit", [False, True])
def test_row_5_joint_damping(load, implicit):
    """Damping 10 for 1.5 s. The world of the original is not described; the integrated equation stands in for it."""
    wish = f"<physics><ode><implicit_spring_damper>{int(implicit)}</implicit_spring_damper></ode></physics>"
    made = load(world(pendulum(dynamics(damping=10), wish, arm=2.0, mass=3.0, moment=0.5)))
    bob = made.body("p")
    made.run(1.5)
    assert made.GetSimTime() == pytest.approx(1.5)
    angle, rate = swing(0.0, 0.0, 1500, 0.001, 10.0, 3.0 * 9.8 * 2.0, 3.0 * 4.0 + 0.5)
    speed = 2.0 * rate
    velocity, place = bob.GetLinearVel(), bob.GetPosition()
    assert (velocity.x, velocity.z) == pytest.approx((-speed * math.sin(angle), -speed * math.cos(angle)), abs=0.01)
    assert (place.x, place.z) == pytest.approx((2 * math.cos(angle), 20 - 2 * math.sin(angle)), abs=0.01)
    assert made.model("p").sdf_joints["j"].position() == pytest.approx(angle, abs=0.01)


def test_row_10_box_pendulum_keeps_its_energy(load):
    made = load(world(pendulum()))
    bob, hinge = made.body("p"), made.model("p").sdf_joints["j"]
    start = 2.0 * 9.8 * 20.0
    for _ in range(2500):
        made.step()
        kinetic = (2.0 * 1.0 + 0.1) * hinge.velocity() ** 2 / 2
        assert (kinetic + 2.0 * 9.8 * bob.GetPosition().z) / start == pytest.approx(1.0, abs=0.01)


def test_row_10_a_hinge_counts_its_turns(load):
    made = load(world(pendulum(), gravity="0 0 0"))
    hinge = made.model("p").sdf_joints["j"]
    hinge.set_velocity(2 * math.pi)
    for i in range(1500):
        made.step()
        assert hinge.velocity() == pytest.approx(2 * math.pi, abs=0.01)
        assert hinge.position() == pytest.approx(2 * math.pi * (i + 1) * 0.001, abs=0.01)
    made.run(3.0)
    assert hinge.position() == pytest.approx(9 * math.pi, abs=0.02)


def test_row_10_long_pendulum(load):
    made = load(world(pendulum(arm=10.0, moment=1e-3), physics="<max_step_size>0.0001</max_step_size>"))
    hinge = made.model("p").sdf_joints["j"]
    for _ in range(10):
        made.step(100)
    angle, _ = swing(0.0, 0.0, 1000, 0.0001, 0.0, 2.0 * 9.8 * 10.0, 2.0 * 100.0 + 1e-3)
    assert hinge.position() == pytest.approx(angle, abs=0.01)


def two_boxes():
    """Two boxes of 10 kg, one hanging on the other, on hinges about x that can tip by a right angle."""
    boxes = link("one", inertial(10.0), pose="0 0 0.5 0 0 0") + link("two", inertial(10.0), pose="0 0 1 0 0 0")
    told = "<physics><ode><provide_feedback>true</provide_feedback></ode></physics>"
    lower = joint("low", "revolute", "world", "one", "1 0 0", told, limits(-1.5708, 0), pose="0 0 -0.5 0 0 0")
    upper = joint("high", "revolute", "one", "two", "1 0 0", told, limits(0, 0), pose="0 0 -0.5 0 0 0")
    return model("m", boxes, lower, upper)


def test_row_11_forces_of_joints(load):
    made = load(world(two_boxes(), gravity="0 0 -50", physics="<ode><solver><type>world</type></solver></ode>"))
    made.step(10)
    low, high = (made.model("m").sdf_joints[name] for name in ("low", "high"))
    for found, expected in ((low, 1000.0), (high, 500.0)):
        parent_force, _, force, _ = found.wrench
        assert tuple(force) == pytest.approx((0.0, 0.0, expected), rel=1e-6, abs=1e-6)
        assert tuple(parent_force) == pytest.approx([-v for v in force], abs=1e-9)


def test_row_11_forces_of_tipped_joints(load):
    made = load(world(two_boxes(), gravity="-30 10 -50", physics="<ode><solver><type>world</type></solver></ode>"))
    made.run(2.0)
    low = made.model("m").sdf_joints["low"]
    assert low.position() == pytest.approx(-math.pi / 2, abs=0.02)
    _, _, force, torque = low.wrench
    for found, expected, slack in (
        (force, (600.0, -200.0, 1000.0), (6.0, 10.0, 2.0)),
        (torque, (750.0, 0.0, -450.0), (7.5, 4.5, 0.1)),
    ):
        for value, wanted, bound in zip(found, expected, slack, strict=True):
            assert value == pytest.approx(wanted, abs=bound)


def test_row_11_a_torque_on_a_hinge_accelerates(load):
    rotor = link("rotor", inertial(10.0, (0.8, 1, 1)))
    made = load(world(model("m", rotor, joint("j", "revolute", "world", "rotor", "1 0 0")), gravity="0 0 0"))
    hinge = made.model("m").sdf_joints["j"]
    before = 0.0
    for _ in range(20):
        hinge.add_force(1.3)
        assert hinge.force() == 1.3
        made.step()
        assert (hinge.velocity() - before) / 0.001 == pytest.approx(1.3 / 0.8, abs=1e-6)
        before = hinge.velocity()


K, MASS = 120.0, 1.0  # 10.95 rad/s: 17 half oscillations in 5 s


def oscillate(made, value, push=None):
    """How often a value passes through zero in 5000 steps."""
    passes, before = 0, value()
    for _ in range(5000):
        if push is not None:
            push()
        made.step()
        now = value()
        passes += (now > 0) != (before > 0)
        before = now
    return passes


def spring_world(load, inside="", implicit=False, initial=0.1):
    wish = f"<physics><ode><implicit_spring_damper>{int(implicit)}</implicit_spring_damper></ode></physics>"
    slider = joint("j", "prismatic", "world", "mass", "1 0 0", wish, inside)
    made = load(world(model("m", link("mass", inertial(MASS)), slider), gravity="0 0 0"))
    slide = made.model("m").sdf_joints["j"]
    slide.set_position(initial)
    return made, slide


def energy(slide):
    return K * slide.position() ** 2 / 2 + MASS * slide.velocity() ** 2 / 2


@pytest.mark.parametrize("by", ["plugin", "file"])
def test_row_12_explicit_springs(load, by):
    made, slide = spring_world(load, dynamics(spring_stiffness=K, spring_reference=0) if by == "file" else "")
    start = energy(slide)
    push = (lambda: slide.add_force(-K * slide.position())) if by == "plugin" else None
    assert oscillate(made, slide.position, push) == 17
    # Explicit in the force, implicit in the position: the energy swings about its start by h w / 2, and does not drift.
    assert energy(slide) / start == pytest.approx(1.0, abs=0.001 * math.sqrt(K / MASS))


def test_row_12_implicit_springs(load):
    """A gentle one keeps its energy; a stiff one is solved with the constraints, and comes to rest."""
    made, slide = spring_world(load, dynamics(spring_stiffness=K, spring_reference=0), implicit=True)
    start = energy(slide)
    assert oscillate(made, slide.position) == 17
    # Where it turns round, energy is what it was; between, it swings about that by h w / 2.
    assert energy(slide) / start == pytest.approx(1.0, abs=0.001 * math.sqrt(K / MASS))
    while slide.velocity() * slide.position() > 0.0:  # outwards
        made.step()
    while slide.velocity() * slide.position() < 0.0:  # inwards, and out again
        made.step()
    before = slide.velocity()
    while slide.velocity() * before > 0.0:
        made.step()
    assert energy(slide) / start == pytest.approx(1.0, abs=1e-3)
    stiff, slide = spring_world(load, dynamics(spring_stiffness=1e8, spring_reference=0), implicit=True)
    stiff.step(100)
    assert abs(slide.position()) < 1e-6


def test_an_implicit_spring_becomes_stiff_and_gentle_again_with_the_step(load):
    made, slide = spring_world(load, dynamics(spring_stiffness=K, spring_reference=0), implicit=True)
    made.step(100)
    made.engine.step_time = 1.0  # now pushing would throw the mass away
    made.step(50)
    assert abs(slide.position()) < 0.1
    made.engine.step_time = 0.001
    slide.set_position(0.1)
    slide.set_velocity(0.0)
    start = energy(slide)
    assert oscillate(made, slide.position) == 17
    assert energy(slide) / start == pytest.approx(1.0, abs=0.02)


def test_row_12_a_soft_contact_is_a_spring(load):
    """A ball that lies on a soft ground, pushed down: it swings about where it rests."""
    soft = f"<contact><ode><kp>{K}</kp><kd>0</kd><max_vel>1e9</max_vel></ode></contact>"
    ball = link("link", inertial(MASS), collision("sphere", soft))
    awake = "<allow_auto_disable>0</allow_auto_disable>"
    made = load(world(GROUND, model("m", awake, ball, pose=f"0 0 {0.5 - 3.2 / K} 0 0 0"), gravity="0 0 -2"))
    body, rest = made.body("m"), 0.5 - MASS * 2 / K
    assert oscillate(made, lambda: body.GetPosition().z - rest) == 17


def screw(pitch, more="", parent="world"):
    bolt = link("bolt", inertial(2.0, (0.4, 0.4, 0.3)))
    base = link("base", inertial(5.0, (1, 1, 1))) if parent == "base" else ""
    pitched = f"<thread_pitch>{pitch}</thread_pitch>{more}"
    return model("m", base, bolt, joint("j", "screw", parent, "bolt", "0 0 1", pitched))


@pytest.mark.parametrize("pitch", [1.0, -0.5, 50.0])
@pytest.mark.parametrize("solver", ["world", "quick"])
def test_row_13_screw(load, pitch, solver):
    """position(1) = -position(0) / pitch, and the energy that goes in is there."""
    physics = f"<ode><solver><type>{solver}</type></solver></ode>"
    made = load(world(screw(pitch), gravity="0 0 0", physics=physics))
    thread = made.model("m").sdf_joints["j"]
    work = 0.0
    for _ in range(1000):
        thread.add_force(0.5)
        before = thread.position()
        made.step()
        work += 0.5 * (thread.position() - before)
        assert thread.position(1) == pytest.approx(-thread.position(0) / pitch, abs=1e-4)
    assert thread.velocity(1) == pytest.approx(-thread.velocity(0) / pitch, rel=1e-3)
    inertia = 0.3 + 2.0 / pitch**2
    assert thread.velocity(0) == pytest.approx(0.5 / inertia, rel=1e-3)
    assert inertia * thread.velocity(0) ** 2 / 2 == pytest.approx(work, rel=5e-3)


def test_row_13_a_screw_between_two_links_keeps_momentum(load):
    made = load(world(screw(2.0, parent="base"), gravity="0 0 0"))
    thread = made.model("m").sdf_joints["j"]
    for _ in range(500):
        thread.add_force(1.0)
        made.step()
    base, bolt = made.body("m", "base"), made.body("m", "bolt")
    assert thread.position(1) == pytest.approx(-thread.position(0) / 2.0, abs=1e-4)
    assert 5 * base.GetLinearVel().z + 2 * bolt.GetLinearVel().z == pytest.approx(0.0, abs=1e-6)
    assert base.GetAngularRate().z + 0.3 * bolt.GetAngularRate().z == pytest.approx(0.0, abs=1e-4)
    assert abs(thread.velocity()) > 0.5


def test_row_13_weight_drives_a_screw_as_on_an_incline(load):
    made = load(world(screw(1.5)))
    thread = made.model("m").sdf_joints["j"]
    made.run(1.0)
    mass = 2.0 + 0.3 * 1.5**2
    assert thread.velocity(1) == pytest.approx(-2.0 * 9.8 / mass, rel=1e-3)
    assert thread.position(0) == pytest.approx(-1.5 * thread.position(1), abs=1e-2)


def test_row_13_screw_limits_are_those_of_the_angle(load):
    stop = model(
        "m",
        link("bolt", inertial(2.0, (0.4, 0.4, 0.3))),
        joint("j", "screw", "world", "bolt", "0 0 1", "<thread_pitch>10</thread_pitch>", limits(-1, 8)),
    )
    made = load(world(stop))
    thread = made.model("m").sdf_joints["j"]
    made.run(4.0)
    assert thread.position(0) == pytest.approx(8.0, abs=0.02)
    assert thread.position(1) == pytest.approx(-0.8, abs=0.01)


def gears(ratio, axis2="0 0 1", base="<static>1</static>", reference="base"):
    parts = [
        link("base", inertial(100.0, (50, 50, 50))),
        link("one", inertial(2.0, (0.3, 0.3, 0.25)), pose="0 0 1 0 0 0"),
        link("two", inertial(5.0, (0.2, 0.1, 0.1)), pose="1 0 1 0 0 0"),
        joint("joint1", "revolute", "base", "one", "0 0 1"),
        joint("joint3", "revolute", "base", "two", axis2),
        joint(
            "gears",
            "gearbox",
            "one",
            "two",
            axis2,  # of the child, as in Gazebo
            f"<axis2><xyz>0 0 1</xyz></axis2><gearbox_ratio>{ratio}</gearbox_ratio>"
            f"<gearbox_reference_body>{reference}</gearbox_reference_body>",
        ),
    ]
    fixed = joint("hold", "fixed", "world", "base", "") if base else ""
    return model("m", *parts, fixed)


@pytest.mark.parametrize(("ratio", "axis2"), [(-1.5, "0 0 1"), (2.0, "0 0 1"), (-1.5, "1 0 0")])
@pytest.mark.parametrize("solver", ["world", "quick"])
def test_row_13_gearbox(load, ratio, axis2, solver):
    """velocity(joint1) ratio = -velocity(joint3), and both turn as their inertias together let them."""
    physics = f"<ode><solver><type>{solver}</type></solver></ode>"
    made = load(world(gears(ratio, axis2), gravity="0 0 0", physics=physics))
    joints = made.model("m").sdf_joints
    first, second = joints["joint1"], joints["joint3"]
    for i in range(600):
        (first if i < 300 else second).add_force(0.4)
        made.step()
        assert first.velocity() * ratio == pytest.approx(-second.velocity(), abs=1e-6)
    inertia = 0.25 + ratio**2 * (0.1 if axis2 == "0 0 1" else 0.2)
    expected = 0.3 * 0.4 / inertia * (1 - ratio)
    assert first.velocity() == pytest.approx(expected, rel=5e-3, abs=1e-3)
    # as in Gazebo, axis 0 is the child's
    rates = [joints["gears"].velocity(index) for index in (0, 1)]
    assert rates == pytest.approx([second.velocity(), first.velocity()], abs=1e-6)
    assert first.position() * ratio == pytest.approx(-second.position(), abs=1e-4)


def test_row_13_velocity_set_each_step_holds(load):
    made = load(world(pendulum()))
    hinge = made.model("p").sdf_joints["j"]
    for _ in range(1000):
        hinge.set_velocity(0.2)
        made.step()
    assert hinge.velocity() == pytest.approx(0.2, abs=0.05)
    assert hinge.position() == pytest.approx(0.2, abs=0.02)


def test_row_13_a_motor_holds_its_velocity(load):
    made = load(world(pendulum()))
    hinge = made.model("p").sdf_joints["j"]
    hinge.set_param("fmax", 200.0)
    hinge.set_param("vel", 0.2)
    made.run(5.0)
    assert (hinge.get_param("fmax"), hinge.get_param("vel")) == (200.0, 0.2)
    assert hinge.velocity() == pytest.approx(0.2, abs=1e-3)
    assert hinge.position() == pytest.approx(1.0, abs=5e-3)


def test_positions_beyond_a_turn_and_their_stops(load):
    made = load(world(pendulum(limits(-10, 12)), gravity="0 0 0"))
    hinge = made.model("p").sdf_joints["j"]
    for push, stop in ((30.0, 12.0), (-30.0, -10.0)):
        for _ in range(3000):
            hinge.add_force(push)
            made.step()
        assert hinge.position() == pytest.approx(stop, abs=0.05)
    hinge.set_position(7.0)
    made.step()
    assert hinge.position() == pytest.approx(7.0, abs=0.2)
    assert GzQuaternToEuler(made.body("p").GetRotation()).y == pytest.approx(7.0 - 2 * math.pi, abs=0.2)


@pytest.mark.parametrize("limit", [3.1, math.pi, 3.2, 2 * math.pi, 20.0])
def test_stops_about_half_a_turn_hold(load, limit):
    made = load(world(pendulum(limits(-limit, limit)), gravity="0 0 0"))
    hinge = made.model("p").sdf_joints["j"]
    for push in (20.0, -20.0):
        for _ in range(4000):
            hinge.add_force(push)
            made.step()
        assert hinge.position() == pytest.approx(math.copysign(limit, push), abs=0.02)


def test_a_box_beside_a_joint_that_rests_on_its_stop_is_not_asleep_too_soon(load):
    """Steps that are solved twice count twice for what is idle; so they are only while a stop moves the joint."""
    arm = link("arm", inertial(1.0, (0.1,) * 3), pose="0.3 0 3 0 0 0")
    hinge = joint("j", "revolute", "world", "arm", pose="-.3 0 0 0 0 0", axis="0 -1 0", inside=limits(-0.1, 1.0))
    box = model("box", link("link", collision("box")), pose="5 0 .5 0 0 0")
    slow = "<ode><constraints><contact_max_correcting_vel>0</contact_max_correcting_vel></constraints></ode>"
    made = load(world(GROUND, model("m", arm, hinge), box, physics=slow))
    made.run(0.75)
    assert made.model("m").sdf_joints["j"].position() == pytest.approx(-0.1, abs=1e-6)
    assert made.body("box").IsEnabled()
    made.run(0.3)
    assert not made.body("box").IsEnabled()


@pytest.mark.parametrize("lower", [1.0, 4.0, 10.0])
def test_a_joint_that_begins_below_its_limits_turns_towards_them(load, lower):
    """However many half turns away they are; the other way round, too, with less speed, as in Gazebo."""
    hinges = [joint("j", "revolute", "world", "l", inside=limits(*ends)) for ends in ((lower, 12), (-12, -lower))]
    parts = [model(name, link("l", inertial(1.0, (1.0,) * 3)), hinge) for name, hinge in zip("ab", hinges, strict=True)]
    made = load(world(*parts, gravity="0 0 0"))
    made.run(1.0)
    low, high = (made.model(name).sdf_joints["j"].position() for name in "ab")
    assert lower < low < 12.0
    assert lower < -high < 12.0
    if lower == 1.0:
        assert (low, high) == pytest.approx((1.5043, -1.2622), abs=1e-3)  # in Gazebo 11.1
