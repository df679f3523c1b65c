"""The contact rule of Gazebo classic: friction by direction, slip, minimum depth, limited push-out, bounce, bits."""

import math

import pytest
from engine_parts import dress, dressed_box, dressed_ground as ground, use_classic

import libgz
from libgz.ode.lib import ode
from libgz.ode.types import ContactRule
from libgz.physics.engine import Engine
from libgz.physics.space import Space


@pytest.fixture
def engine(classic_engine):
    return classic_engine


def box(engine, position, height=1.0, **surface):
    return dressed_box(engine, position, height=height, **surface).body


def run(engine, seconds):
    for _ in range(round(seconds / engine.step_time)):
        engine.step()


def test_a_dropped_box_rests_at_its_height(engine):
    ground(engine)
    body = box(engine, (0, 0, 1.0))
    run(engine, 2.0)
    assert body.GetPosition().z == pytest.approx(0.5, abs=1e-4)
    assert abs(body.GetLinearVel().z) < 0.0101


def test_friction_slides_by_the_smaller_coefficient(engine):
    engine.gravity = (0, -1.0, -1.0)
    ground(engine, mu=100)
    bodies = [(mu, box(engine, (3 * i, 0, 0.1), height=0.2, mu=mu)) for i, mu in enumerate((0.9, 0.99, 1.01))]
    run(engine, 2.0)
    for mu, body in bodies:
        velocity = body.GetLinearVel()
        assert velocity.y == pytest.approx(min(0.0, mu - 1.0) * 2.0, abs=5e-3)
        assert abs(velocity.x) < 1e-3


@pytest.mark.parametrize("angle", [0.0, 0.5, 1.2])
def test_fdir1_is_where_mu_counts(engine, angle):
    """Rough along fdir1, slippery across it: the box goes across, whatever gravity wants."""
    engine.gravity = (0, -1.0, -9.8)
    ground(engine, mu=100, mu2=100)
    body = box(engine, (0, 0, 0.5), mu=1.0, mu2=0.0, fdir1=(math.cos(angle), math.sin(angle), 0))
    run(engine, 1.0)
    velocity = body.GetLinearVel()
    along = velocity.x * math.cos(angle) + velocity.y * math.sin(angle)
    across = -velocity.x * math.sin(angle) + velocity.y * math.cos(angle)
    assert along == pytest.approx(0.0, abs=5e-3)
    assert across == pytest.approx(-math.cos(angle), abs=0.02)


def test_slip_lets_bodies_creep_under_a_force(engine):
    """Terminal speed is force times slip over the number of contact points, which the slip is multiplied with."""
    engine.gravity = (0, 2.0, -9.81)
    ground(engine, mu=100)
    body = libgz.Body(engine)
    ball = libgz.SphereGeom(body, Space(engine), 0.5)
    ball.SetMass(2.0)
    dress(ball, mu=100, SLIP1=0.1, SLIP2=0.1)
    body.SetPosition((0, 0, 0.5))
    hinge = libgz.SliderJoint(engine)  # keeps it from rolling
    hinge.Attach(body, None)
    hinge.SetAxis(0, 1, 0)
    run(engine, 3.0)
    assert body.GetLinearVel().y == pytest.approx(2.0 * 2.0 * 0.1, rel=0.015)


def test_bounce_needs_both_and_a_threshold(engine):
    ground(engine, BOUNCE=0.5, BOUNCE_VEL=0.1, KD=1e6)
    bouncing = box(engine, (0, 0, 1.5), BOUNCE=0.8, BOUNCE_VEL=0.1, KD=1e6)
    dull = box(engine, (3, 0, 1.5), BOUNCE=0.0, KD=1e6)
    peaks = [0.0, 0.0]
    for _ in range(1200):
        engine.step()
        for i, body in enumerate((bouncing, dull)):
            if body.GetLinearVel().z > 0:
                peaks[i] = max(peaks[i], body.GetPosition().z - 0.5)
    assert peaks[0] == pytest.approx(0.25, abs=0.02)  # e^2 h, e the smaller one
    assert peaks[1] < 0.02


def test_a_penetration_gives_no_more_velocity_than_max_vel(engine):
    ground(engine, MAX_VEL=0.0)  # it has no body, and so no influence
    engine.gravity = (0, 0, 0)
    body = box(engine, (0, 0, 0.4), MAX_VEL=0.01)
    run(engine, 1.0)
    assert body.GetLinearVel().z == pytest.approx(0.01, rel=1e-3)
    assert body.GetPosition().z == pytest.approx(0.51, abs=1e-3)  # set apart, and moved since


def test_bodies_that_overlap_come_to_rest_side_by_side(engine):
    ground(engine, MAX_VEL=0.01)
    deep, shallow = box(engine, (0, 0, 0.1), MAX_VEL=0.01), box(engine, (3, 0, 0.499), MAX_VEL=0.01)
    lower, upper = box(engine, (6, 0, 0.4), MAX_VEL=0.0), box(engine, (6, 0, 1.2), MAX_VEL=0.0)
    run(engine, 0.5)
    for body, height in ((deep, 0.5), (shallow, 0.5), (lower, 0.5), (upper, 1.5)):
        assert body.GetPosition().z == pytest.approx(height, abs=2e-4)
        assert abs(body.GetLinearVel().z) < 1e-3


def test_what_joints_connect_is_set_apart_together(engine):
    ground(engine, MAX_VEL=0.01)
    lower, upper = box(engine, (0, 0, 0.4), MAX_VEL=0.01), box(engine, (0, 0, 2.0), MAX_VEL=0.01)
    joint = libgz.HingeJoint(engine)
    joint.Attach(lower, upper)
    joint.SetAnchor((0, 0, 1.2))
    joint.SetAxis((0, 1, 0))
    run(engine, 0.3)
    assert lower.GetPosition().z == pytest.approx(0.5, abs=1e-3)
    assert upper.GetPosition().z - lower.GetPosition().z == pytest.approx(1.6, abs=1e-4)


@pytest.mark.parametrize("kp", [1e3, 1e5, 1e7])
def test_a_soft_contact_carries_what_its_spring_carries(engine, kp):
    ground(engine, MAX_VEL=0.0)
    body = box(engine, (0, 0, 0.5), KP=kp, KD=1.0, MAX_VEL=0.01)
    run(engine, 3.0)
    assert body.GetPosition().z == pytest.approx(0.5 - 9.8 / (4.0 * kp), abs=1e-5 + 0.02 * 9.8 / (4.0 * kp))
    assert abs(body.GetLinearVel().z) < 1e-4


def test_a_minimum_depth_is_not_corrected(engine):
    ground(engine)
    deep, shallow = box(engine, (0, 0, 0.48), MIN_DEPTH=0.01), box(engine, (3, 0, 0.495), MIN_DEPTH=0.01)
    run(engine, 3.0)
    assert deep.GetPosition().z == pytest.approx(0.49, abs=1e-3)
    assert shallow.GetPosition().z == pytest.approx(0.495, abs=1e-3)


def test_bits_select_pairs(engine):
    ground(engine, BITS=0xFF)
    falls, rests = box(engine, (0, 0, 0.5), BITS=0x10000), box(engine, (3, 0, 0.5), BITS=1)
    run(engine, 0.5)
    assert falls.GetPosition().z < 0
    assert rests.GetPosition().z == pytest.approx(0.5, abs=1e-3)


def test_fewer_contacts_on_request(engine):
    ground(engine, MAX_CONTACTS=3)
    box(engine, (0, 0, 0.499))
    engine.step()
    assert engine.contact_count == 3


def cube(engine, size, height, *, dummy=False, carries=False, **surface):
    """A cube; one that carries another is heavy, and gravity does not act on it."""
    body = libgz.Body(engine, dummy=dummy)
    geom = libgz.BoxGeom(body, Space(engine), size, size, size)
    geom.SetMass(1e6 if carries else 1.0)
    body.SetGravityMode(not carries)
    body.SetPosition((0, 0, height))
    dress(geom, **surface)
    return body


@pytest.mark.parametrize(
    ("upper", "lower", "moves", "acts"),
    [
        (0.5, 2.0, False, "upper"),
        (2.0, 0.5, False, "lower"),
        (0.9, 0.6, False, "lower"),  # of one level: what does not move
        (0.05, 0.2, False, "lower"),
        (0.6, 0.9, True, "upper"),  # what was made last
        (0.5, 2.0, True, "upper"),
        (0.5, None, False, "upper"),  # on a plane
    ],
)
def test_of_two_friction_directions_that_of_the_smaller_counts(upper, lower, moves, acts):
    """Measured in Gazebo 11.1; rough along x, slippery along y."""
    for chosen in ("upper", "lower"):
        engine = Engine(step_time=0.001)
        use_classic(engine)
        engine.gravity = (1.0, 1.0, -9.8)
        kinds = {name: {"mu2": 0.0, "fdir1": (1, 0, 0)} if name == chosen else {} for name in ("upper", "lower")}
        if lower:
            cube(engine, lower, lower / 2, dummy=not moves, carries=True, **kinds["lower"])
        else:
            ground(engine, **kinds["lower"])
        body = cube(engine, upper, upper / 2 + (lower or 0.0), **kinds["upper"])
        run(engine, 0.1)
        x, y, _ = body.GetLinearVel()
        if chosen == acts:
            assert (x, y) == pytest.approx((0.0, 0.1), abs=0.01)
        else:
            assert (x, y) != pytest.approx((0.0, 0.1), abs=0.01)


def test_a_running_surface_carries_what_lies_on_it_and_drives_what_has_it(engine):
    """By the right-hand rule about its axis: about y the top of a surface runs along x, and its bottom against x."""
    ground(engine, fdir1=(0, 1, 0), TRACK=1, TRACK_SPEED=0.5)  # a conveyor
    carried = box(engine, (0, 0, 0.5))
    run(engine, 1.0)
    assert carried.GetLinearVel().x == pytest.approx(0.5, abs=1e-3)
    assert carried.GetPosition().y == pytest.approx(0.0, abs=1e-3)
    twin = Engine(step_time=0.001)
    use_classic(twin)
    ground(twin)
    driven = box(twin, (0, 0, 0.5), fdir1=(0, 1, 0), TRACK=1, TRACK_SPEED=0.5)
    run(twin, 1.0)
    assert driven.GetLinearVel().x == pytest.approx(0.5, abs=1e-3)


def test_the_halves_of_a_step_are_a_step(engine):
    ground(engine)
    body = box(engine, (0, 0, 0.5))
    twin = Engine(step_time=0.001)
    use_classic(twin)
    ground(twin)
    other = box(twin, (0, 0, 0.5))
    for _ in range(50):
        engine.step()
        twin.collide()
        twin.solve()
    assert tuple(body.GetPosition()) == tuple(other.GetPosition())
    assert twin.contact_count == engine.contact_count > 0


def test_cylinders_collide_by_odes_own_collider_under_the_classic_rule():
    """Standing on each other; the stand-ins' contacts are at the corners of the inscribed square."""
    reach = {}
    for rule in (ContactRule.LEGACY, ContactRule.CLASSIC):
        engine = Engine(step_time=0.001)
        engine.contact_rule = rule
        engine.record_contacts = True
        for z in (0.25, 0.749):
            body = libgz.Body(engine)
            libgz.CylinderGeom(body, Space(engine), 0.25, 0.5)
            body.SetPosition((0, 0, z))
        engine.step()
        contacts = engine.native.contacts()
        assert len(contacts) >= 3
        reach[rule] = max(abs(contact["normal"][2]) for contact in contacts)
        assert engine._context.no_cylinder_pairs == (rule == ContactRule.LEGACY or not ode().collides_cylinders)
        engine.close()
    assert all(value == pytest.approx(1.0, abs=1e-6) for value in reach.values())
