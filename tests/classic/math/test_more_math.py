"""Splines, planes, oriented boxes, Matrix4d, filters and functions, against numbers worked out by hand."""

import math

import pytest

from libgz.base.errors import ParameterError
from libgz.classic.math import (
    AxisAlignedBox,
    BiQuad,
    Color,
    Matrix4d,
    OnePole,
    OnePoleVector3,
    OrientedBoxd,
    Planed,
    PlaneSide,
    Pose3d,
    Quaterniond,
    RollingMean,
    RotationSpline,
    Spline,
    Vector3d,
    isPowerOfTwo,
    mean,
    parseFloat,
    parseInt,
    roundUpMultiple,
    roundUpPowerOfTwo,
    signum,
    variance,
)


def test_a_spline_passes_its_points_and_is_as_long_as_it_should_be():
    spline = Spline()
    for x in range(4):
        spline.AddPoint((x, 0, 0))
    assert spline.PointCount() == 4
    assert spline.ArcLength() == pytest.approx(3.0, abs=1e-3)
    assert spline.Interpolate(0.0) == Vector3d(0, 0, 0)
    assert spline.Interpolate(1.0) == Vector3d(3, 0, 0)
    assert spline.Interpolate(1, 0.0) == Vector3d(1, 0, 0)
    assert spline.Interpolate(1, 0.5) == Vector3d(1.5, 0, 0)
    assert spline.Tangent(1) == Vector3d(1, 0, 0)
    assert spline.Tangent(0) == Vector3d(0.5, 0, 0)
    spline.SetTension(1.0)
    assert spline.Tangent(1) == Vector3d()
    assert spline.UpdatePoint(1, (1, 1, 0))
    assert not spline.UpdatePoint(9, (0, 0, 0))
    assert spline.Point(1) == Vector3d(1, 1, 0)
    assert spline.Point(9).X() == math.inf


def test_a_closed_spline_is_smooth_where_it_closes():
    spline = Spline()
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 0)):
        spline.AddPoint((x, y, 0))
    assert spline.Tangent(0) == spline.Tangent(4) == Vector3d(0, 1, 0)
    assert spline.Interpolate(0.125).Length() == pytest.approx(0.9, abs=0.03)  # between two points, inside the circle
    assert 4 * math.sqrt(2) < spline.ArcLength() < 2 * math.pi


def test_a_spline_without_points_says_so():
    with pytest.raises(ParameterError, match="AddPoint adds one"):
        Spline().Interpolate(0.5)


def test_a_rotation_spline_passes_its_rotations():
    spline = RotationSpline()
    for yaw in (0.0, 0.5, 1.0):
        spline.AddPoint(Quaterniond(0, 0, yaw))
    assert spline.Interpolate(0.5).Yaw() == pytest.approx(0.5)
    assert spline.Interpolate(0.25).Yaw() == pytest.approx(0.25, abs=0.04)
    assert spline.Interpolate(1.0).Yaw() == pytest.approx(1.0)


def test_a_plane_has_sides_and_distances():
    plane = Planed((0, 0, 1), 2.0)
    assert plane.Distance((5, 5, 3)) == 1.0
    assert plane.Distance((0, 0, 0), (0, 0, 2)) == 1.0
    assert plane.Intersection((1, 2, 0), (0, 0, 1)) == Vector3d(1, 2, 2)
    assert plane.Intersection((0, 0, 0), (1, 0, 0)) is None
    assert plane.Side((0, 0, 1)) is PlaneSide.NEGATIVE_SIDE
    assert plane.Side(AxisAlignedBox((0, 0, 1), (1, 1, 3))) is PlaneSide.BOTH_SIDE
    assert plane.Side(AxisAlignedBox((0, 0, 3), (1, 1, 4))) is PlaneSide.POSITIVE_SIDE


def test_an_oriented_box_contains_points_in_its_own_frame():
    box = OrientedBoxd((2, 4, 6), Pose3d(1, 0, 0, 0, 0, math.pi / 2))
    assert box.Volume() == 48.0
    assert box.Contains((2.9, 0.9, 2.9))
    assert not box.Contains((1, 1.5, 0))


def test_a_ray_meets_an_axis_aligned_box():
    box = AxisAlignedBox((1, -1, -1), (3, 1, 1))
    assert box.Intersect((0, 0, 0), (2, 0, 0), 0.0, 10.0) == (True, 1.0, Vector3d(1, 0, 0))
    assert not box.IntersectCheck((0, 0, 0), (0, 1, 0), 0.0, 10.0)
    assert not box.IntersectCheck((0, 0, 0), (1, 0, 0), 0.0, 0.5)
    assert box.IntersectDist((2, 0, 5), (0, 0, -1), 0.0, 10.0) == (True, 4.0)


def test_matrix4_is_a_pose():
    pose = Pose3d(1, 2, 3, 0.1, 0.2, 0.3)
    matrix = Matrix4d(pose)
    assert matrix.Pose().Equal(pose, 1e-9)
    assert (matrix * Vector3d(1, 0, 0)).Equal(pose.Pos() + pose.Rot() * Vector3d(1, 0, 0), 1e-9)
    assert (matrix * matrix.Inverse()).Equal(Matrix4d.Identity)
    assert matrix.Determinant() == pytest.approx(1.0)
    assert tuple(matrix.EulerRotation()) == pytest.approx((0.1, 0.2, 0.3))
    assert matrix.IsAffine()
    look = Matrix4d.LookAt((0, 0, 0), (0, 5, 0))
    assert (look * Vector3d(1, 0, 0)).Equal(Vector3d(0, 1, 0), 1e-12)
    with pytest.raises(ParameterError, match="takes 16 numbers"):
        Matrix4d(1, 2, 3)


def test_filters_settle_at_their_input():
    one = OnePole(10.0, 1000.0)
    assert one.Process(1.0) == pytest.approx(1.0 - math.exp(-2 * math.pi * 0.01))
    for _ in range(1000):
        one.Process(1.0)
    assert one.Value() == pytest.approx(1.0)
    three = OnePoleVector3(10.0, 1000.0)
    assert three.Process((1, 0, 2)).Z() == pytest.approx(2.0 * (1.0 - math.exp(-2 * math.pi * 0.01)))
    two = BiQuad(10.0, 1000.0)
    for _ in range(1000):
        two.Process(3.0)
    assert two.Value() == pytest.approx(3.0)
    rolling = RollingMean(2)
    for value in (5.0, 1.0, 2.0):
        rolling.Push(value)
    assert (rolling.Mean(), rolling.Count()) == (1.5, 2)
    with pytest.raises(ParameterError, match="a rate above 0 Hz"):
        OnePole(1.0, 0.0)


def test_functions_of_numbers():
    assert (signum(-2.5), signum(0.0)) == (-1, 0)
    assert (mean([1, 2, 3]), variance([1, 2, 3])) == (2.0, pytest.approx(2.0 / 3.0))
    assert (isPowerOfTwo(64), isPowerOfTwo(65), roundUpPowerOfTwo(65), roundUpMultiple(7, 5)) == (True, False, 128, 10)
    assert (parseInt("42 m"), parseInt("x"), parseFloat("2.5e1s")) == (42, 0, 25.0)
    assert math.isnan(parseFloat("x"))


def test_colours_as_one_number():
    color = Color(1.0, 0.5019607843137255, 0.0, 1.0)
    assert color.AsRGBA() == 0xFF8000FF
    assert color.AsARGB() == 0xFFFF8000
    other = Color()
    other.SetFromABGR(color.AsABGR())
    assert other.Equal(color, 1e-9)
