"""Rays on height fields beside rays on the same surface as a mesh."""

import sys

import numpy as np
import pytest

from libgz.base.geometry import GzPose, GzQuaternFromEuler, GzVector
from libgz.ode.context import RayScan
from libgz.physics.body import Body
from libgz.physics.engine import Engine
from libgz.physics.geoms import HeightfieldGeom, SphereGeom, TriMeshGeom
from libgz.physics.space import Space

SIZE = 13.0, 9.0  # [m]
COUNT = 5000


def mesh(heights):
    """The triangles that ODE makes of a field's cells."""
    rows, columns = heights.shape
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, columns) * SIZE[0], np.linspace(-0.5, 0.5, rows) * SIZE[1])
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
    cells = [first + np.array(corners) for corners in ((0, 1, columns), (1, columns + 1, columns))]
    return np.stack([x, y, heights], axis=-1).reshape(-1, 3), np.concatenate(cells)


def some_rays(random):
    """Rays from above, beside and below; some along axes, and along diagonals of cells."""
    rays = np.zeros((COUNT, 7))
    rays[:, :3] = random.uniform((-8, -6, -1), (8, 6, 6), (COUNT, 3))
    ways = random.normal(size=(COUNT, 3))
    ways[:1000, 2] = 0.0
    ways[:500, 0] = 0.0
    ways[1000:1200] = 0.0, 0.0, -1.0
    ways[1200:1400, :2] = 1.0, -1.0
    rays[:, 3:6] = ways / np.linalg.norm(ways, axis=1, keepdims=True)
    rays[:, 6] = random.uniform(0.1, 20.0, COUNT)
    return rays


def scanned(make, rays, yaw):
    engine = Engine()
    geom = make(Body(engine, dummy=True), Space(engine))
    geom.SetRelativePose(GzPose(GzVector(0.3, -0.2, 0.5), GzQuaternFromEuler(0.0, 0.0, yaw)))
    ranges, rows = np.zeros(COUNT), np.zeros(COUNT, dtype=np.int64)
    engine.scanner(RayScan(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), rays, 0, ranges, rows))()
    return ranges, rows


@pytest.mark.parametrize("yaw", [0.0, np.pi, 0.7])
def test_rays_meet_a_field_where_they_meet_its_triangles(yaw):
    random = np.random.default_rng(3)
    heights, rays = 2.0 * random.random((37, 53)), some_rays(random)
    ranges, rows = scanned(lambda body, space: HeightfieldGeom(body, space, heights, *SIZE), rays, yaw)
    expected, mesh_rows = scanned(lambda body, space: TriMeshGeom(body, space, *mesh(heights)), rays, yaw)
    hit = rows >= 0
    assert (hit == (mesh_rows >= 0)).all()
    assert 500 < hit.sum() < COUNT
    assert ranges[hit] == pytest.approx(expected[hit], abs=2e-5)
    assert (ranges[~hit] == sys.float_info.max).all()


def test_rays_pass_a_field_that_was_removed():
    engine = Engine()
    space, rays = Space(engine), np.array([[0.0, 0.0, 3.0, 0.0, 0.0, -1.0, 9.0]])
    fields = [HeightfieldGeom(Body(engine, dummy=True), space, np.full((2, 2), z), 2.0, 2.0) for z in (1.0, 2.0)]
    ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
    scan = engine.scanner(RayScan(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), rays, 0, ranges, rows))
    for expected in (1.0, 2.0):
        scan()
        assert ranges[0] == expected
        fields.pop().close()
    scan()
    assert rows[0] == -1


def test_a_field_that_is_turned_at_run_time_carries_and_is_seen_up_to_its_corners():
    engine = Engine()
    ground = Body(engine, dummy=True)
    field = HeightfieldGeom(ground, Space(engine), np.zeros((5, 5)), 4.0, 4.0)
    ball = Body(engine)
    SphereGeom(ball, Space(engine), 0.1).SetMass(1.0)
    ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
    rays = np.array([[2.6, 0.0, 3.0, 0.0, 0.0, -1.0, 9.0]])
    scan = engine.scanner(RayScan(np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]), rays, ball.number, ranges, rows))

    def height():
        """Where the ball comes to rest above a corner of the turned field."""
        ball.SetPose(GzPose(GzVector(2.6, 0.0, 0.15)))
        ball.SetLinearVel(GzVector())
        for _ in range(200):
            engine.step()
        scan()
        return ball.GetPose().pos.z

    flat = engine.get_state()
    assert height() < 0.0
    assert rows[0] == -1
    ground.SetPose(GzPose(GzVector(), GzQuaternFromEuler(0.0, 0.0, np.pi / 4.0)))
    turned = engine.get_state()
    assert height() == pytest.approx(0.1, abs=0.01)
    assert (ranges[0], rows[0]) == (3.0, field.row)
    engine.set_state(flat)
    assert height() < 0.0
    assert rows[0] == -1
    engine.set_state(turned)
    assert height() == pytest.approx(0.1, abs=0.01)
    field.close()
    field.close()
    assert height() < 0.0
