"""Geoms: the masses they make, how they touch, and where rays find them."""

import math

import numpy as np
import pytest
from engine_parts import box, cylinder, ground, solid

import libgz
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.space import Space
from libgz.physics.surfaces import PointSetGeom


def test_geoms_place_the_centre_of_mass():
    engine = Engine()
    body, space = libgz.Body(engine), Space(engine)
    body.SetPosition((1, 2, 3))
    for x, mass in ((0.0, 1.0), (1.0, 3.0)):
        geom = libgz.BoxGeom(body, space, 0.1, 0.1, 0.1)
        geom.SetRelativePosition((x, 0, 0))
        geom.SetMass(mass)
    assert body.mass == pytest.approx(4.0)
    assert tuple(body.GetPosition()) == pytest.approx((1, 2, 3))
    assert tuple(body.GetCoMPose().pos) == pytest.approx((1.75, 2, 3))
    assert tuple(body.GetGeoms()[1].GetPose().pos) == pytest.approx((2, 2, 3))
    # Parallel axes: 1 kg and 3 kg, 0.75 m and 0.25 m from the common centre.
    own = (1.0 + 3.0) * (0.1**2 + 0.1**2) / 12
    assert body.GetMass().I[10] == pytest.approx(own + 1.0 * 0.75**2 + 3.0 * 0.25**2)


def test_massless_geoms():
    engine = Engine()
    body, space = libgz.Body(engine), Space(engine)
    plate = libgz.BoxGeom(body, space, 1, 1, 1)
    plate.SetMass(0)
    assert body.mass == pytest.approx(1.0)  # all massless: what the volume weighs at 1 kg/m^3
    heavy = libgz.BoxGeom(body, space, 1, 1, 1)
    heavy.SetMass(5)
    assert body.mass == pytest.approx(5.0)


def test_plates_may_have_no_thickness():
    engine = Engine(step_time=0.01)
    table = libgz.Body(engine, dummy=True)
    libgz.BoxGeom(table, Space(engine), 24, 18, 0).SetMass(1)
    plate = solid(engine, lambda body, space: libgz.BoxGeom(body, space, 0.6, 0.6, 0), 2.0)
    disc = solid(engine, lambda body, space: libgz.CylinderGeom(body, space, 0.3, 0), 1.0)
    assert (plate.mass, disc.mass) == (2.0, 1.0)
    assert plate.GetMass().I[0] == pytest.approx(2.0 * 0.6**2 / 12)
    assert disc.GetMass().I[10] == pytest.approx(0.3**2 / 2)
    ball = solid(engine, lambda body, space: libgz.SphereGeom(body, space, 0.2), 1.0, (5, 0, 0.25), kp=1e4, kd=300)
    for _ in range(200):
        engine.step()
    assert ball.GetPosition().z == pytest.approx(0.2, abs=0.002)


def pair_rests(first, second, height):
    engine = Engine(step_time=0.01)
    ground(engine)
    lower = solid(engine, first, position=(0, 0, 0.25), kp=1e5, kd=300)
    upper = solid(engine, second, position=(0, 0, 0.25 + height + 0.002), kp=1e5, kd=300)
    for _ in range(300):
        engine.step()
    assert upper.GetPosition().z - lower.GetPosition().z == pytest.approx(height, abs=0.005)
    assert np.linalg.norm(tuple(upper.GetLinearVel())) < 0.01


def test_cylinders_collide():
    pair_rests(cylinder, cylinder, 0.5)


def test_cylinders_touch_at_their_radius():
    engine = Engine(gravity=(0, 0, 0), step_time=0.005)
    still = solid(engine, cylinder, position=(0, 0, 0), kp=1e5, kd=1000)
    mover = solid(engine, cylinder, position=(-0.6, 0, 0), kp=1e5, kd=1000)
    mover.SetLinearVel((1.0, 0, 0))
    closest = 1.0
    for _ in range(200):
        engine.step()
        closest = min(closest, still.GetPosition().x - mover.GetPosition().x)
    assert closest == pytest.approx(0.4, abs=1e-3)
    assert still.GetLinearVel().x > 0.3


def test_capsule_meets_cylinder():
    engine = Engine(gravity=(0, 0, 0), step_time=0.005)
    still = solid(engine, cylinder, kp=1e5, kd=1000)
    capsule = solid(engine, lambda b, s: libgz.CapsuleGeom(b, s, 0.1, 0.3), position=(-0.5, 0, 0), kp=1e5, kd=1000)
    capsule.SetLinearVel((1.0, 0, 0))
    for _ in range(200):
        engine.step()
    assert still.GetLinearVel().x > 0.2


def test_box_on_a_mesh_and_on_a_heightfield():
    for make in (
        lambda b, s: libgz.TriMeshGeom(
            b, s, [(-2, -2, 0.5), (2, -2, 0.5), (2, 2, 0.5), (-2, 2, 0.5)], [(0, 1, 2), (0, 2, 3)]
        ),
        lambda b, s: libgz.HeightfieldGeom(b, s, np.full((5, 5), 0.5), 4.0, 4.0),
    ):
        engine = Engine(step_time=0.01)
        body, space = libgz.Body(engine, dummy=True), Space(engine)
        floor = make(body, space)
        floor.SetHardness(1e6, 0)
        box_ = solid(engine, box(0.3, 0.3, 0.3), position=(0.4, 0.3, 0.7), kp=1e5, kd=300)
        for _ in range(300):
            engine.step()
        assert box_.GetPosition().z == pytest.approx(0.65, abs=0.01)


def cast(engine, start, direction, length=20.0, owner=0):
    ranges, rows = np.empty(1), np.empty(1, dtype=np.int64)
    frame = np.array([*start, 1, 0, 0, 0], dtype=float)
    engine.scan(frame, np.array([[0, 0, 0, *direction, length]], dtype=float), owner, ranges, rows)
    return ranges[0], engine.geoms.get(rows[0])


def test_heightfield_lies_as_its_rows_and_columns_say():
    engine = Engine()
    body, space = libgz.Body(engine, dummy=True), Space(engine)
    heights = np.zeros((5, 9))
    heights[4, 8] = 1.0  # the corner at +x, +y
    heights[0, 8] = 2.0  # the corner at +x, -y
    field = libgz.HeightfieldGeom(body, space, heights, 8.0, 4.0)
    for x, y, height in ((4, 2, 1.0), (4, -2, 2.0), (-4, 2, 0.0), (0, 0, 0.0)):
        distance, geom = cast(engine, (x * 0.999, y * 0.999, 5), (0, 0, -1))
        assert 5 - distance == pytest.approx(height, abs=0.02)  # a thousandth off the corner, on a slope
        assert geom is field


def test_rays_see_shapes_at_their_distances():
    engine = Engine()
    plane = ground(engine)
    ball = solid(engine, lambda b, s: libgz.SphereGeom(b, s, 0.5), position=(5, 0, 1))
    crate = solid(engine, box(1, 1, 1), position=(-5, 0, 1))
    can = solid(engine, cylinder, position=(0, 5, 1))
    capsule = solid(engine, lambda b, s: libgz.CapsuleGeom(b, s, 0.3, 1.0), position=(0, -5, 1))
    for direction, distance, body in (
        ((1, 0, 0), 4.5, ball),
        ((-1, 0, 0), 4.5, crate),
        ((0, 1, 0), 4.8, can),
        ((0, -1, 0), 4.7, capsule),
    ):
        found, geom = cast(engine, (0, 0, 1), direction)
        assert found == pytest.approx(distance, abs=1e-9)
        assert geom is body.GetGeoms()[0]
    found, geom = cast(engine, (0, 0, 1), (0, 0, -1))
    assert found == pytest.approx(1.0, abs=1e-12)
    assert geom is plane
    assert cast(engine, (0, 0, 1), (1, 0, 0), length=4.0)[1] is None
    assert cast(engine, (0, 0, 1), (1, 0, 0), owner=ball.number)[1] is None


def test_point_sets_are_drawn_and_touch_nothing():
    engine = Engine()
    points = PointSetGeom(Body(engine, dummy=True), Space(engine), 2, [(0, 0, 0), (1, 2, 3)])
    assert points.points.tolist() == [[0, 0, 0], [1, 2, 3]]
    assert points.GetGeomId() == 0
    with pytest.raises(libgz.ParameterError, match="a point set of 3 got 2 points"):
        PointSetGeom(points.body, None, 3, points.points)
    engine.close()


def test_a_space_closes_with_its_parts():
    engine = Engine()
    whole = Space(engine)
    part = Space(engine, parent=whole)
    geom = libgz.BoxGeom(Body(engine), part, 1, 1, 1)
    other = libgz.SphereGeom(Body(engine), Space(engine), 0.5)
    other.body.SetPosition((0, 0, 0.9))
    engine.step()
    assert engine.contact_count > 0  # what is in a part is touched
    geom.close()
    whole.close()
    with pytest.raises(libgz.ClosedError):
        _ = part.id
    engine.step()
    assert engine.contact_count == 0
    engine.close()


def test_a_prism_has_the_mass_of_its_volume():
    with libgz.World() as world:
        body = Body(world)
        corners = [(-1.0, 0.0), (1.0, 0.0), (1.0, 0.5), (-1.0, 0.5)]
        prism = libgz.PrismGeom(body, None, corners, 3.0)
        box = libgz.BoxGeom(body, None, 2.0, 0.5, 3.0)
        box.SetRelativePosition((0.0, 0.25, 1.5))
        for geom in (prism, box):
            geom.SetMass(6.0)
        one, other = prism.GetBodyMassMatrix(), box.GetBodyMassMatrix()
        assert [one.mass, *one.c, *one.I] == pytest.approx([other.mass, *other.c, *other.I])
        # An L, whose notch has no mass; its corners may go either way round.
        notched = [(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)]
        assert libgz.PrismGeom(body, None, notched, 2.0).volume_mass.mass == pytest.approx(6.0)
        crossing, without_number = [(0, 0), (1, 1), (1, 0), (0, 1)], [(0, 0), (math.nan, 0), (0, 1)]
        for outline, height in (([(0, 0), (1, 0)], 1), (crossing, 1), (without_number, 1), (corners, 0)):
            with pytest.raises(libgz.ParameterError):
                libgz.PrismGeom(body, None, outline, height)
