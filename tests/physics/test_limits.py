"""What would make ODE end the process or fail: refused, recovered from, or skipped, and reported."""

import logging
import math
from pathlib import Path

import numpy as np
import pytest
from engine_parts import INF, box, solid, unsolvable, use_classic

import libgz
from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzVector
from libgz.physics.engine import Engine
from libgz.physics.space import Space


@pytest.mark.parametrize("place", [1e8, 3e8, 1e9])
def test_small_bodies_far_away(place):
    engine = Engine(gravity=(0, 0, 0))
    body = solid(engine, box(0.1, 0.1, 0.1), position=(place, -place, place))
    engine.step()
    assert tuple(body.GetPosition()) == (place, -place, place)
    for bad in (1.1e9, -3e9, math.nan, math.inf):
        with pytest.raises(ParameterError, match="position"):
            body.SetPosition((0, bad, 0))
    ball = libgz.SphereGeom(body, body.geoms[0].space, 0.1)
    ball.SetMass(0)
    with pytest.raises(ParameterError, match="relative position"):
        ball.SetRelativePosition((1.1e9, 0, 0))
    ball.SetRelativePosition((1e9, 0, 0))
    engine.step()
    assert not body.diverged


def test_small_bodies_on_their_way_out():
    engine = Engine(gravity=(0, 0, 0), step_time=1.0)
    body = solid(engine, box(0.1, 0.1, 0.1))
    body.SetLinearVel((9e6, 0, 0))
    for _ in range(200):
        engine.step()
    assert body.GetPosition().x == pytest.approx(200 * 9e6)
    assert not body.diverged


def diverge(classic):
    """Three bodies of four that diverge in one world; the states of all in the end."""
    engine = Engine(step_time=0.1)
    if classic:
        use_classic(engine)
    names = ("flung", "accelerated", "spun", "calm")
    bodies = [solid(engine, box(0.1, 0.1, 0.1), position=(3.0 * i, 0, 1)) for i in range(4)]
    for body, name in zip(bodies, names, strict=True):
        body.bodyName = name
    bodies[0].SetPosition((9.9e8, 0, 0))
    for i in range(1200):
        bodies[0].SetLinearVel((9.9e6, 0, 0))
        if i == 3:
            bodies[1].AddForce(1e300, 0, 0)
        if i == 4:
            bodies[2].SetAngularVel((0, 1e9, 0))
        engine.step()
    assert bodies[0].GetPosition().x < 2e9
    assert bodies[1].GetPosition().x == pytest.approx(3.0)
    assert bodies[3].GetPosition().z < -1000
    return engine.states.tobytes()


def test_diverged_bodies_are_reset(caplog):
    with caplog.at_level(logging.ERROR):
        assert diverge(True) == diverge(True)
    for name in ("flung", "accelerated", "spun"):
        assert caplog.text.count(f"body {name} diverged; its velocity was reset") == 2
    assert "calm" not in caplog.text


def test_they_are_reset_in_legacy_worlds_too(caplog):
    with caplog.at_level(logging.ERROR):
        diverge(False)
    for name in ("flung", "accelerated", "spun"):
        assert caplog.text.count(f"body {name} diverged; its velocity was reset") == 1
    assert "calm" not in caplog.text


@pytest.mark.parametrize("kind", [libgz.Hinge2Joint, libgz.UniversalJoint])
def test_axes_in_any_order_and_never_parallel(kind):
    engine = Engine(gravity=(0, 0, 0))
    one, two = (solid(engine, box(0.1, 0.1, 0.1), position=(x, 0, 0)) for x in (0, 1))
    joint = kind(engine)
    joint.Attach(one, two)
    joint.SetAnchor((0.5, 0, 0))
    joint.SetAxis1((0, 2, 0))  # which is where ODE has the second one
    joint.SetAxis2((1, 0, 0))  # which is where ODE has the first one
    assert tuple(joint.GetAxis1()) == pytest.approx((0, 1, 0))
    assert tuple(joint.GetAxis2()) == pytest.approx((1, 0, 0))
    for misuse in (
        lambda: joint.SetAxis1((-3, 0, 0)),
        lambda: joint.SetAxis2((0, 1, 0)),
        lambda: joint.SetAxes((0, 0, 1), (0, 0, 1)),
    ):
        with pytest.raises(ParameterError, match="parallel; SetAxes sets both at once"):
            misuse()
    engine.step()
    joint.SetAxes((1, 0, 0), (0, 1, 0))
    engine.step()
    assert tuple(joint.GetAxis1()) == pytest.approx((1, 0, 0))


def test_hinge2_without_bodies_has_no_axes():
    joint = libgz.Hinge2Joint(Engine())
    for getter in (joint.GetAxis1, joint.GetAxis2):
        with pytest.raises(ParameterError, match="attached to two bodies"):
            getter()


@pytest.mark.parametrize(
    ("parameter", "bad"),
    [
        (libgz.dParamLoStop, INF),
        (libgz.dParamHiStop, -INF),
        (libgz.dParamLoStop2, INF),
        (libgz.dParamVel, INF),
        (libgz.dParamVel2, -1e300),
        (libgz.dParamCFM, -1.0),
        (libgz.dParamStopCFM, INF),
        (libgz.dParamStopERP, INF),
        (libgz.dParamSuspensionCFM2, -1.0),
        (libgz.dParamBounce, INF),
    ],
)
def test_joint_parameters_out_of_range(parameter, bad):
    joint = libgz.UniversalJoint(Engine())
    with pytest.raises(ParameterError, match=r"dParam\w+ is .*; it must be within"):
        joint.SetParam(parameter, bad)


def test_settings_out_of_range():
    engine = Engine()
    for settings in ((INF, 0, 1), (0.2, INF, 1), (math.nan, 0, 1), (0.2, 0, -1)):
        with pytest.raises(ParameterError):
            engine.set_constraints(*settings)
    with pytest.raises(ParameterError, match=r"bounce of BoxGeom 1 of .* is inf"):
        solid(engine, box(1, 1, 1)).geoms[0].SetBounce(INF)


def test_joint_parameters_without_bounds():
    engine = Engine()
    joint = libgz.HingeJoint(engine)
    joint.Attach(solid(engine, box(1, 1, 1)), None)
    for parameter, value in ((libgz.dParamLoStop, -INF), (libgz.dParamHiStop, INF), (libgz.dParamFMax, INF)):
        joint.SetParam(parameter, value)
        assert joint.GetParam(parameter) == value
    engine.step()


def mesh(corners, triangles):
    return lambda body, space: libgz.TriMeshGeom(body, space, corners, triangles)


def test_meshes_of_one_triangle_meet_other_meshes():
    engine = Engine(gravity=(0, 0, 0))
    flat, upright = [(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 0, -1), (0, 0, 1), (0, -0.5, 0)]
    bodies = [solid(engine, mesh(corners, [(0, 1, 2)])) for corners in (flat, upright)]
    engine.step()
    assert engine.contact_count > 0
    assert all(len(body.geoms[0].triangles) == 1 for body in bodies)


@pytest.mark.parametrize(
    ("corners", "triangles", "message"),
    [
        ([(0, 0, 0), (1, 0, 0), (0, 1e30, 0)], [(0, 1, 2)], "a vertex lies at 1e"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, -2)], "names vertex -2; there are 3"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 3)], "names vertex 3; there are 3"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [0, 1], r"triangles have shape \(2,\)"),
        ([0, 0, 0, 1], [(0, 1, 2)], "vertices have shape"),
    ],
)
def test_meshes_that_are_none(corners, triangles, message):
    body = libgz.Body(Engine())
    with pytest.raises(ParameterError, match=message):
        mesh(corners, triangles)(body, None)
    assert body.geoms == []


def test_a_pair_whose_collision_detection_fails_is_skipped(monkeypatch, caplog):
    """A box so wide that the cells of a height field under it cannot be counted."""
    engine = Engine()
    ground, space = libgz.Body(engine, "ground", dummy=True), Space(engine)
    libgz.HeightfieldGeom(ground, space, np.zeros((3, 3)), 0.01, 0.01)
    ground.SetPose(GzPose(GzVector(1, 2, 3), GzQuatern()))
    wide = solid(engine, box(1e8, 1e8, 1), position=(0, 0, 3.2))
    wide.bodyName = "wide"
    ball = solid(engine, lambda b, s: libgz.SphereGeom(b, s, 0.5), position=(0, 0, 9))
    with caplog.at_level(logging.ERROR):
        for _ in range(5):
            engine.step()
    message = "collision detection between"
    assert caplog.text.count(message) == 1
    assert "BoxGeom of wide" in caplog.text
    assert "HeightfieldGeom of ground" in caplog.text
    fall = 9.8 * 0.02**2 * 15
    assert tuple(wide.GetPosition()) == pytest.approx((0, 0, 3.2 - fall))
    assert tuple(ball.GetPosition()) == pytest.approx((0, 0, 9 - fall))


def test_a_step_that_ode_cannot_solve_is_reported(monkeypatch, caplog):
    engine, two = unsolvable()
    two.SetLinearVel((1, 0, 0))
    with caplog.at_level(logging.ERROR):
        engine.step()
        engine.step()
    assert caplog.text.count("step 1 was abandoned and nothing moved in it") == 1
    two.SetRotation((1, 0, 0, 0))
    engine.step()
    assert two.GetPosition().x > 1.0


def test_abandoned_steps_leak_no_memory(monkeypatch):
    engine, _ = unsolvable()

    def pages():
        return int(Path("/proc/self/statm").read_text().split()[1])

    engine.step()
    before = pages()
    for _ in range(6000):
        engine.step()
    assert engine.abandoned
    assert (pages() - before) * 4096 < 12e6  # they were 37 MB


def asleep(engine, position, support=None):
    """A box that has fallen asleep."""
    body = solid(engine, box(0.3, 0.3, 0.3), position=position)
    body.set_auto_disable(True)
    joint = libgz.HingeJoint(engine)
    joint.Attach(body, None)
    joint.SetAnchor(position)
    if support is not None:
        joint.close()
    for _ in range(200):
        engine.step()
    assert not body.IsEnabled()
    return body, joint


@pytest.mark.parametrize(
    "act",
    [
        lambda geom: geom.close(),
        lambda geom: geom.resize(2, 2, 0.2),
        lambda geom: geom.SetRelativePosition((0, 0, -3)),
        lambda geom: geom.SetCollideBits(0) or geom.SetCategoryBits(0),
    ],
)
def test_bodies_that_sleep_on_a_geom_wake_when_it_is_removed(act):
    engine = Engine()
    table = libgz.BoxGeom(libgz.Body(engine, dummy=True), Space(engine), 2, 2, 1)
    body, _ = asleep(engine, (0, 0, 0.65), table)
    act(table)
    for _ in range(10):
        engine.step()
    assert body.GetPosition().z < 0.6


@pytest.mark.parametrize("act", [lambda joint: joint.close(), lambda joint: joint.Detach()])
def test_bodies_that_sleep_in_a_joint_wake_when_it_is_removed(act):
    engine = Engine()
    body, joint = asleep(engine, (0, 0, 2))
    act(joint)
    for _ in range(10):
        engine.step()
    assert body.GetPosition().z < 1.95


@pytest.mark.parametrize("bad", [math.nan, INF])
def test_times_that_are_none(bad):
    with libgz.World.from_string("<gz:world xmlns:gz='g'/>") as world:
        with pytest.raises(ParameterError, match=r"time to run \[s\] is"):
            world.run(bad)
        with pytest.raises(ParameterError, match=r"sim time \[s\] is"):
            world.set_sim_time(bad)


def test_bodies_closed_between_contacts_and_motion():
    def run():
        engine = Engine(step_time=0.01)
        engine.record_contacts = True
        bodies = [solid(engine, box(0.3, 0.3, 0.3), position=(0.1 * i, 0, 0.25 * i)) for i in range(12)]
        table = libgz.BoxGeom(libgz.Body(engine, dummy=True), Space(engine), 9, 9, 0.2)
        for k in range(40):
            engine.collide()
            if k % 4 == 1 and len(bodies) > 3:
                bodies.pop(k % len(bodies)).close()
            if k == 30:
                table.close()
            engine.solve()
        assert len(engine.contacts) == 0 or engine.contact_count > 0
        return engine.states[sorted(engine.bodies)].tobytes()

    assert run() == run()


@pytest.mark.parametrize("start", [0.0, 1.7e308, -1.7e308, math.nan])
def test_a_ray_that_is_not_finite_hits_nothing(start):
    engine = Engine()
    libgz.BoxGeom(libgz.Body(engine, dummy=True), Space(engine), 1.0, 1.0, 1.0)
    rays = np.tile([-3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 10.0], (6, 1))
    rays[1:4, 3], rays[4, 6], rays[5, 6] = (math.nan, math.inf, 1e308), math.inf, 1e308
    ranges, rows = np.empty(6), np.empty(6, dtype=np.int64)
    engine.scan(np.array([start, 0, 0, 1, 0, 0, 0]), rays, 0, ranges, rows)
    assert list(rows >= 0) == [start == 0.0, False, False, False, False, start == 0.0]
    if start == 0.0:
        assert ranges[0] == ranges[5] == pytest.approx(2.5)
