"""Physics against formulas."""

import math

import numpy as np
import pytest
from engine_parts import G, box, busy_world, ground, solid

import libgz
from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.base.geometry import GzVector
from libgz.physics.engine import Engine
from libgz.physics.space import Space
from libgz.sdfworld.links import move_links


def test_free_fall_is_semi_implicit_euler():
    engine = Engine(step_time=0.01)
    body = solid(engine, box(0.1, 0.2, 0.3), position=(0, 0, 100))
    body.SetLinearVel((1.0, 0, 0))
    n, h = 200, 0.01
    for _ in range(n):
        engine.step()
    assert body.GetPosition().z == pytest.approx(100 - G * h * h * n * (n + 1) / 2, abs=1e-4)
    assert body.GetLinearVel().z == pytest.approx(-G * h * n, abs=1e-9)
    assert body.GetPosition().x == pytest.approx(n * h, abs=1e-9)


@pytest.mark.parametrize("solver", ["world", "quick", "tree"])
def test_explicit_gyroscopic_torque_is_that_of_the_begin_of_a_step(solver):
    engine = Engine(step_time=0.01, solver=solver)
    before = solid(engine, box(0.1, 0.2, 0.3))
    engine.explicit_gyroscopic = True
    after = solid(engine, box(0.1, 0.2, 0.3), position=(0, 0, 5))
    rate, moments = np.array((1.0, 2.0, 3.0)), np.array((0.13, 0.10, 0.05)) / 12  # of a box of 1 kg
    expected = rate - 0.01 * np.cross(rate, moments * rate) / moments
    for body in (before, after):  # was made before the switch, and after it
        body.SetAngularVel(tuple(rate))
    engine.step()
    for body in (before, after):
        assert tuple(body.GetAngularRate()) == pytest.approx(expected, abs=1e-14)
    state = engine.get_state()
    engine.explicit_gyroscopic = False
    for body in (before, after):
        body.SetRotation((1, 0, 0, 0))
        body.SetAngularVel(tuple(rate))
    engine.step()
    assert tuple(before.GetAngularRate()) == tuple(after.GetAngularRate()) != pytest.approx(expected, abs=1e-4)
    engine.set_state(state)
    assert engine.explicit_gyroscopic
    assert tuple(before.GetAngularRate()) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("slope", [10, 20, 30])
def test_box_on_a_slope_slides_by_its_friction(slope):
    angle, friction, seconds = math.radians(slope), math.tan(math.radians(20)), 1.0
    # Tilt gravity instead of the ground: the friction pyramid then lies along the slope.
    engine = Engine(gravity=(G * math.sin(angle), 0, -G * math.cos(angle)), step_time=0.002)
    ground(engine)
    body = solid(engine, box(0.4, 0.4, 0.1), position=(0, 0, 0.05), friction=friction, kp=1e6, kd=1e4)
    for _ in range(round(seconds / 0.002)):
        engine.step()
    acceleration = max(0.0, G * (math.sin(angle) - friction * math.cos(angle)))
    assert body.GetPosition().x == pytest.approx(acceleration / 2 * seconds**2, rel=0.02, abs=2e-3)


def test_pendulum_keeps_its_energy():
    engine = Engine(step_time=0.001)
    length, mass, radius = 1.0, 2.0, 0.05
    bob = solid(engine, lambda b, s: libgz.SphereGeom(b, s, radius), mass, (length, 0, 0))
    hinge = libgz.HingeJoint(engine)
    hinge.Attach(bob, None)
    hinge.SetAnchor((0, 0, 0))
    hinge.SetAxis((0, 1, 0))
    inertia = mass * length**2 + 0.4 * mass * radius**2
    energies = []
    for _ in range(5000):
        engine.step()
        energies.append(mass * G * bob.GetPosition().z + inertia * hinge.GetAngleRate() ** 2 / 2)
    assert max(map(abs, energies)) < 0.01 * mass * G * length
    assert math.hypot(bob.GetPosition().x, bob.GetPosition().z) == pytest.approx(length, abs=1e-3)


def test_wheel_rolls_its_circumference():
    engine = Engine(step_time=0.01)
    ground(engine)
    chassis = solid(engine, box(0.4, 0.2, 0.1), 2.0, (0, 0, 0.2))
    for x in (0.15, -0.15):
        for y in (0.15, -0.15):
            wheel = solid(engine, lambda b, s: libgz.WheelGeom(b, s, 0.1, 0.03), 0.5, (x, y, 0.1))
            hinge = libgz.HingeJoint(engine)
            hinge.Attach(wheel, chassis)
            hinge.SetAnchor((x, y, 0.1))
            hinge.SetAxis((0, 1, 0))
            hinge.SetParam(libgz.dParamVel, 2 * math.pi)
            hinge.SetParam(libgz.dParamFMax, 5.0)
    for _ in range(100):
        engine.step()
    start = chassis.GetPosition().x
    for _ in range(500):
        engine.step()
    assert chassis.GetPosition().x - start == pytest.approx(5.0 * 2 * math.pi * 0.1, rel=0.01)


def test_contact_is_a_spring():
    engine = Engine()
    ground(engine)
    body = solid(engine, lambda b, s: libgz.SphereGeom(b, s, 0.15), position=(0, 0, 0.15), kp=1e5, kd=500)
    for _ in range(500):
        engine.step()
    assert body.GetPosition().z - 0.15 == pytest.approx(-1.0 * G / 1e5, rel=1e-3)


def test_bounce_gives_speed_back():
    engine = Engine(step_time=0.001)
    ground(engine)
    body = solid(engine, lambda b, s: libgz.SphereGeom(b, s, 0.1), position=(0, 0, 1.1), kp=1e9, kd=1e6)
    body.GetGeoms()[0].SetBounce(0.5)
    peak, falling = 0.0, True
    for _ in range(1000):
        engine.step()
        velocity = body.GetLinearVel().z
        falling = falling and velocity <= 0
        if not falling:
            peak = max(peak, body.GetPosition().z - 0.1)
    assert peak == pytest.approx(0.25, abs=0.01)  # e^2 h


def test_slider_and_force():
    engine = Engine(gravity=(0, 0, 0), step_time=0.01)
    body = solid(engine, box(0.1, 0.1, 0.1), 2.0)
    slider = libgz.SliderJoint(engine)
    slider.Attach(body, None)
    slider.SetAxis(1, 0, 0)
    for _ in range(100):
        slider.SetSliderForce(4.0)
        engine.step()
    assert slider.GetPositionRate() == pytest.approx(2.0, rel=1e-6)
    assert slider.GetPosition() == pytest.approx(body.GetPosition().x)


def test_torque_turns_a_hinge():
    engine = Engine(gravity=(0, 0, 0), step_time=0.01)
    body = solid(engine, box(0.2, 0.2, 0.2), 3.0)
    hinge = libgz.HingeJoint(engine)
    hinge.Attach(body, None)
    hinge.SetAxis((0, 0, 1))
    for _ in range(100):
        hinge.SetTorque(0.1)
        engine.step()
    inertia = 3.0 * (0.2**2 + 0.2**2) / 12
    assert hinge.GetAngleRate() == pytest.approx(0.1 / inertia, rel=1e-6)
    assert body.GetAngularRate().z == pytest.approx(hinge.GetAngleRate())


def test_hinge2_steers_and_rolls():
    engine = Engine(gravity=(0, 0, 0), step_time=0.01)
    chassis = solid(engine, box(1, 1, 1), 1000.0)
    wheel = solid(engine, lambda b, s: libgz.WheelGeom(b, s, 0.1, 0.03), position=(1, 1, 0))
    joint = libgz.Hinge2Joint(engine)
    joint.Attach(chassis, wheel)
    joint.SetAnchor((1, 1, 0))
    joint.SetAxis1((0, 0, -1))
    joint.SetAxis2((0, -1, 0))
    joint.SetParam(libgz.dParamVel2, 3.0)
    joint.SetParam(libgz.dParamFMax2, 5.0)
    joint.SetParam(libgz.dParamFMax, 5.0)
    for _ in range(50):
        joint.SetParam(libgz.dParamVel, 10 * (0.4 - joint.GetAngle1()))
        engine.step()
    assert joint.GetAngle1() == pytest.approx(0.4, abs=0.01)
    assert joint.GetAngle2Rate() == pytest.approx(3.0, rel=0.02)
    assert joint.GetAxis2().x > 0.3  # positive steers left: the axle's right end came forward


def test_universal_and_ball_and_fixed_hold():
    engine = Engine(step_time=0.005)
    for kind in (libgz.UniversalJoint, libgz.BallJoint, libgz.FixedJoint):
        body = solid(engine, box(0.1, 0.1, 0.1), position=(0.5, 0, 0))
        joint = kind(engine)
        joint.Attach(body, None)
        joint.SetAnchor((0, 0, 0))
        if kind is libgz.UniversalJoint:
            joint.SetAxis1((1, 0, 0))
            joint.SetAxis2((0, 1, 0))
        if kind is libgz.FixedJoint:
            joint.SetFixed()
        for _ in range(200):
            engine.step()
        assert np.linalg.norm(tuple(body.GetPosition())) == pytest.approx(0.5, abs=5e-3)
        if kind is libgz.FixedJoint:
            assert body.GetPosition().x == pytest.approx(0.5, abs=1e-4)


@pytest.mark.parametrize(
    "misuse",
    [
        lambda e, b: libgz.BoxGeom(b, Space(e), 1, -1, 1),
        lambda e, b: libgz.SphereGeom(b, Space(e), math.nan),
        lambda e, b: libgz.PlaneGeom(b, Space(e), 0, (0, 0, 0)),
        lambda e, b: b.SetPosition((0, math.nan, 0)),
        lambda e, b: b.SetPosition((1, 2)),
        lambda e, b: b.SetRotation((0, 0, math.inf, 0)),
        lambda e, b: b.SetRotation((0, 0, 1)),
        lambda e, b: libgz.BoxGeom(b, Space(e), 1, 1, 1).SetRelativePosition((1, 2)),
        lambda e, b: b.SetLinearVel((math.inf, 0, 0)),
        lambda e, b: b.AddForce(math.nan, 0, 0),
        lambda e, b: libgz.BoxGeom(b, Space(e), 1, 1, 1).SetMass(-1),
        lambda e, b: libgz.BoxGeom(b, Space(e), 1, 1, 1).SetHardness(0, 0),
        lambda e, b: libgz.HingeJoint(e).SetAxis((0, 0, 0)),
        lambda e, b: libgz.HingeJoint(e).SetAxis(0, 0),
        lambda e, b: libgz.HingeJoint(e).SetParam(99, 0),
        lambda e, b: libgz.HingeJoint(e).SetParam(libgz.dParamVel, math.nan),
        lambda e, b: libgz.HingeJoint(e).Attach(b, b),
        lambda e, b: libgz.Hinge2Joint(e).Attach(b, None),
        lambda e, b: libgz.Hinge2Joint(e).Attach(b, libgz.Body(e, dummy=True)),
        lambda e, b: libgz.Hinge2Joint(e).SetAnchor((0, 0, 0)),
        lambda e, b: libgz.Hinge2Joint(e).SetAxis1((0, 0, 1)),
        lambda e, b: libgz.Hinge2Joint(e).SetTorque(1, 1),
        lambda e, b: libgz.SliderJoint(e).SetAxis(0, 0, 1),
        lambda e, b: libgz.SliderJoint(e).SetSliderForce(1),
        lambda e, b: libgz.TriMeshGeom(b, Space(e), [(0, 0, 0)], [(0, 1, 2)]),
        lambda e, b: Engine(step_time=0),
        lambda e, b: Engine(solver="fast"),
    ],
)
def test_bad_arguments_are_refused_before_ode_sees_them(misuse):
    engine = Engine()
    with pytest.raises(ParameterError):
        misuse(engine, libgz.Body(engine))


def test_axes_and_anchors_are_vectors_or_three_numbers():
    engine = Engine()
    body, other = libgz.Body(engine), libgz.Body(engine)
    for kind in (libgz.HingeJoint, libgz.SliderJoint, libgz.UniversalJoint, libgz.Hinge2Joint):
        joint = kind(engine)
        joint.Attach(body, other)
        names = [name for name in ("SetAxis", "SetAxis1", "SetAxis2") if hasattr(joint, name)]
        for name, axis in zip(names, ((0, 0, 1), (0, 1, 0)), strict=False):
            for form in (axis, (axis,), (np.array(axis),)):
                getattr(joint, name)(*form)
                assert tuple(getattr(joint, f"G{name[1:]}")()) == pytest.approx(axis)
        if kind is not libgz.SliderJoint:
            joint.SetAnchor(1, 2, 3)
            assert tuple(joint.GetAnchor()) == pytest.approx((1, 2, 3))


def test_parts_close_in_any_order():
    engine = Engine()
    body = solid(engine, box(1, 1, 1))
    other = solid(engine, box(1, 1, 1), position=(3, 0, 0))
    hinge = libgz.HingeJoint(engine)
    hinge.Attach(body, other)
    hinge.SetAxis((0, 0, 1))
    body.close()
    body.close()
    with pytest.raises(ClosedError):
        hinge.GetAngle()
    with pytest.raises(ClosedError):
        body.GetPose()
    engine.step()
    new = solid(engine, box(1, 1, 1), position=(0, 0, 9))
    engine.step()
    assert new.GetPosition().z == pytest.approx(9 - G * 0.02**2)
    engine.close()
    engine.close()
    with pytest.raises(ClosedError):
        engine.step()
    with pytest.raises(GazeboError):
        other.SetPosition((0, 0, 0))


def test_worlds_are_freed_without_being_closed():
    import gc
    import weakref

    engine = busy_world()
    engine.step()
    gone = weakref.ref(engine)
    del engine
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    "kind", ["HingeJoint", "SliderJoint", "Hinge2Joint", "UniversalJoint", "BallJoint", "FixedJoint"]
)
def test_joints_without_bodies_do_no_harm(kind):
    engine = Engine()
    one, two = (solid(engine, box(1, 1, 1), position=(x, 0, 0)) for x in (0, 3))
    joint = getattr(libgz, kind)(engine)
    for getter in [name for name in dir(joint) if name.startswith(("GetAngle", "GetPosition"))]:
        assert getattr(joint, getter)() == 0.0
    engine.step()
    joint.Attach(one, two)
    joint.Detach()
    joint.GetAnchor()
    joint.motors_off()
    engine.step()
    joint.Attach(one, two)
    one.close()
    engine.step()


def test_stops_taken_away_while_they_are_met(monkeypatch):
    """ODE alone goes on with a row of its solver that is not there any more."""
    engine = Engine(step_time=0.01, gravity=(0, 0, 0))
    body = libgz.Body(engine)
    libgz.BoxGeom(body, None, 1, 1, 1).SetMass(1.0)
    hinge = libgz.HingeJoint(engine)
    hinge.Attach(body, None)
    hinge.SetAxis((0, 0, 1))
    hinge.SetParam(libgz.dParamHiStop, 0.1)
    for push in (1.0, -1.0):
        for _ in range(200):
            hinge.SetTorque(push)
            engine.step()
        if push > 0:
            assert hinge.GetAngle() == pytest.approx(0.1, abs=1e-3)
            hinge.SetParam(libgz.dParamHiStop, math.inf)
            assert hinge.GetParam(libgz.dParamHiStop) == math.inf
            assert hinge.GetParam(libgz.dParamLoStop) == -math.inf
    hinge.SetTorque(50.0)
    for _ in range(300):
        hinge.SetTorque(5.0)
        engine.step()
    assert hinge.GetAngleRate() > 5.0


def poses_after(move, native, monkeypatch):
    """The states of three bodies, one of them a dummy, after one was moved with the others."""
    engine, random = Engine(), np.random.default_rng(2)
    bodies = [solid(engine, box(0.1, 0.2, 0.3), position=random.uniform(-2, 2, 3).tolist()) for _ in range(2)]
    bodies.insert(1, libgz.Body(engine, dummy=True))
    for body in bodies:
        body.SetRotation(random.normal(size=4).tolist())
        body.geoms and body.geoms[0].SetRelativePose(libgz.GzPose(libgz.GzVector(0.1, 0.2, 0.3), body.GetRotation()))
        body.SetLinearVel((1.0, 2.0, 3.0))
    engine.step()
    if not native:
        monkeypatch.setattr(engine, "turn_bodies", lambda *_: 0)
    move(engine, bodies)
    engine.step()
    return [(*body.GetPose().pos, *body.GetPose().rot, *body.GetLinearVel()) for body in bodies]


@pytest.mark.parametrize("still", [False, True])
@pytest.mark.parametrize("distance", [0.3, 5e8])
def test_bodies_are_turned_natively_as_in_python(still, distance, monkeypatch):
    def turn(_engine, bodies):
        move_links(bodies, GzVector(0.3, -0.2, 0.1), GzVector(0.4, 0.7, -0.2), GzVector(distance, 0.0, 0.2), not still)

    assert poses_after(turn, True, monkeypatch) == poses_after(turn, False, monkeypatch)
