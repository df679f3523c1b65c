"""Vectors, quaternions, poses and others: algebra, both spellings of names, agreement with the engine's functions."""

import copy
import math as pymath
import pickle

import numpy as np
import pytest
from hypothesis import given, strategies as st

from libgz.base import geometry as gz
from libgz.base.errors import ParameterError
from libgz.classic import math
from libgz.classic.math import (
    Angle,
    Color,
    Matrix3d,
    Pose3d,
    Quaterniond,
    Rand,
    Vector2d,
    Vector2i,
    Vector3d,
)
from libgz.sdf.value import format_value, parse

coordinate = st.floats(-100.0, 100.0)
vectors = st.builds(Vector3d, coordinate, coordinate, coordinate)
part = st.floats(-1.0, 1.0)
quaternions = (
    st.builds(Quaterniond, part, part, part, part).filter(lambda q: q.Dot(q) > 0.01).map(lambda q: q.Normalized())
)
poses = st.builds(Pose3d, vectors, quaternions)
angles = st.floats(-pymath.pi, pymath.pi)


def near(a, b, tolerance=1e-9):
    return np.allclose(np.asarray(a), np.asarray(b), rtol=0.0, atol=tolerance)


def same_rotation(a, b, tolerance=1e-9):
    return near(a, b, tolerance) or near(a, -b, tolerance)


# Vectors


def test_a_vector_is_made_in_every_way_that_plugins_use():
    assert Vector3d() == Vector3d(0, 0, 0) == Vector3d.Zero
    assert Vector3d(gz.GzVector(1, 2, 3)) == Vector3d([1, 2, 3]) == Vector3d(np.array([1.0, 2.0, 3.0]))
    assert math.Vector3 is Vector3d
    assert parse(Vector3d, "1 2 3") == Vector3d(1, 2, 3)
    assert format_value(Vector3d(1, 2, 0.1)) == "1 2 0.1"
    for wrong in ((1, 2), (5,), ([1, 2],)):
        with pytest.raises(ParameterError, match="three numbers"):
            Vector3d(*wrong)
    with pytest.raises(ParameterError, match="is not a Vector3d"):
        parse(Vector3d, "1 2 x")


def test_both_spellings_of_a_vector():
    v = Vector3d(1.0, 2.0, 3.0)
    assert (v.x, v.y, v.z) == (v.X(), v.Y(), v.Z()) == tuple(v) == (v[0], v[1], v[2])
    v.X(4.0)
    v.Y(0.0)
    v[2] = 6.0
    assert v == Vector3d(4.0, 0.0, 6.0)
    v.Set(3.0, 0.0, 4.0)
    assert v.GetLength() == v.Length() == 5.0
    assert v.Normalize() is v
    assert v == Vector3d(0.6, 0.0, 0.8)
    assert Vector3d.Zero.Normalized() == Vector3d.Zero
    assert str(Vector3d(1, -0.0, 0.1 + 0.2)) == "1 0 0.3"
    assert repr(Vector3d(1.0, 2.0, 3.0)) == "Vector3d(1.0, 2.0, 3.0)"


def test_a_vector_equals_the_engines_vector_of_equal_numbers_both_ways_round():
    ours, engines = Vector3d(1.0, 2.0, 3.0), gz.GzVector(1.0, 2.0, 3.0)
    assert ours == engines
    assert engines == ours
    assert ours != gz.GzVector(1.0, 2.0, 4.0)
    assert gz.GzVector(1.0, 2.0, 4.0) != ours
    assert ours != (1.0, 2.0, 3.0)
    assert ours.Equal((1.0005, 2.0, 3.0))
    assert not ours.Equal((1.002, 2.0, 3.0))
    assert Quaterniond(1, 0, 0, 0) == gz.GzQuatern()
    assert gz.GzQuatern() == Quaterniond()
    assert gz.GzPose() == Pose3d()
    assert Pose3d() == gz.GzPose()
    assert gz.GzColor(1, 0, 0) == Color.Red


def test_constants_and_operands_are_not_modified():
    zero = Vector3d.Zero
    zero.x = 5.0
    Pose3d.Zero.pos.x = 5.0
    assert Vector3d.Zero.x == Pose3d.Zero.pos.x == 0.0
    a = b = Vector3d(1.0, 1.0, 1.0)
    a += Vector3d.UnitX
    assert a == Vector3d(2.0, 1.0, 1.0)
    assert b == Vector3d.One
    with pytest.raises(TypeError, match="unhashable"):
        hash(a)


def test_numbers_of_every_kind_mix_with_vectors():
    v = Vector3d(1.0, 2.0, 4.0)
    for two in (2, 2.0, np.float64(2.0), np.float32(2.0), np.int64(2)):
        assert two * v == v * two == Vector3d(2, 4, 8)
        assert v / two == Vector3d(0.5, 1.0, 2.0)
        assert two - v == Vector3d(1, 0, -2)
        assert type(two * v) is Vector3d
    assert v * v == Vector3d(1, 4, 16)
    assert v / v == Vector3d.One
    assert v + 1 == 1 + v == Vector3d(2, 3, 5)
    assert v + gz.GzVector(1, 1, 1) == gz.GzVector(1, 1, 1) + v == v + Vector3d.One == np.ones(3) + v
    assert type(gz.GzVector(1, 1, 1) - v) is Vector3d
    for wrong in ("abc", "1", (1, 2), None, Quaterniond()):
        with pytest.raises(TypeError):
            v + wrong
    with pytest.raises(ZeroDivisionError):
        v / 0.0


def test_the_smaller_functions_of_a_vector():
    v = Vector3d(1.4, -2.6, 3.5)
    assert v.Rounded() == Vector3d(1, -3, 4)
    assert v.Abs() == Vector3d(1.4, 2.6, 3.5)
    assert (v.Max(), v.Min()) == (3.5, -2.6)
    v.Max((2.0, -5.0, 0.0))
    assert v == Vector3d(2.0, -2.6, 3.5)
    v.SetToMin((0.0, -5.0, 10.0))
    assert v == Vector3d(0.0, -5.0, 3.5)
    v.Set(pymath.nan, pymath.inf, 1.0)
    assert not v.IsFinite()
    v.Correct()
    assert v == Vector3d.UnitZ
    assert Vector3d(0, 0, 0).Distance(3, 4, 0) == Vector3d(0, 0, 0).Distance((3, 4, 0)) == 5.0
    assert Vector3d(0, 2, 0).DistToLine((-1, 0, 0), (5, 0, 0)) == 2.0
    assert Vector3d.Normal((0, 0, 0), (1, 0, 0), (0, 1, 0)) == Vector3d.UnitZ


@given(vectors, vectors, vectors)
def test_vectors_form_a_vector_space_with_two_products(a, b, c):
    assert near(a + b, b + a)
    assert near((a + b) - b, a)
    assert near(a.Cross(b), -b.Cross(a))
    assert abs(a.Dot(a.Cross(b))) < 1e-7
    assert near(a.Cross(b.Cross(c)), b * a.Dot(c) - c * a.Dot(b), 1e-6)  # Lagrange
    assert a.Dot(b) == pytest.approx(gz.GzVectorDot(a, b))
    assert a.Length() == pytest.approx(gz.GzVectorMag(a))
    assert abs(a.Perpendicular().Dot(a)) < 1e-9


def test_vectors_are_plain_values_to_copy_and_pickle():
    pose = Pose3d(1, 2, 3, 0.1, 0.2, 0.3)
    for value in (Vector3d(1, 2, 3), pose, pose.rot, Color.Red, Angle(1.0), Vector2i(1, 2), Matrix3d(pose.rot)):
        assert copy.deepcopy(value) == value
        assert pickle.loads(pickle.dumps(value)) == value
    assert np.asarray(Vector3d(1, 2, 3)).tolist() == [1.0, 2.0, 3.0]
    assert np.asarray(Quaterniond()).tolist() == [1.0, 0.0, 0.0, 0.0]
    assert np.array([Vector3d(1, 2, 3), Vector3d(4, 5, 6)]).shape == (2, 3)


def test_vectors_of_two():
    v = Vector2d(3.0, 4.0)
    assert v.Length() == 5.0
    assert v + 1 == 1 + v == Vector2d(4, 5)
    assert v * 2 - (1, 1) == Vector2d(5, 7)
    assert 2 - v == Vector2d(-1, -2)
    assert v.Normalized() == Vector2d(0.6, 0.8)
    assert v.Distance((0, 0)) == 5.0
    assert str(v) == "3 4"
    assert parse(Vector2d, "0.5 1") == Vector2d(0.5, 1.0)
    with pytest.raises(ParameterError, match="Vector2d"):
        parse(Vector2d, "1 2 3")
    i = Vector2i(7, -7)
    assert i / 2 == Vector2i(3, -3)
    assert type((i / 2).X()) is int
    i.X(2.9)
    assert i.x == 2
    assert np.float64(2) * v == Vector2d(6, 8)
    assert np.asarray(v).tolist() == [3.0, 4.0]


# Quaternions


def test_a_quaternion_is_made_in_every_way_that_plugins_use():
    half = Quaterniond(0.0, 0.0, pymath.pi / 2)
    s = pymath.sqrt(0.5)
    assert near(half, (s, 0, 0, s))
    assert near(Quaterniond(Vector3d(0, 0, 2), pymath.pi / 2), half)
    assert near(Quaterniond(Vector3d(0, 0, pymath.pi / 2)), half)
    assert near(Quaterniond(Matrix3d(half)), half)
    assert Quaterniond(gz.GzQuatern(*half)) == Quaterniond(tuple(half)) == half
    assert Quaterniond() == Quaterniond.Identity
    assert near(parse(Quaterniond, f"0 0 {pymath.pi / 2}"), half)
    assert parse(Quaterniond, "0.5 0.5 0.5 0.5") == Quaterniond(0.5, 0.5, 0.5, 0.5)
    for wrong in ([1, 2], 5, "x"):
        with pytest.raises(ParameterError, match="Quaterniond takes"):
            Quaterniond(wrong)


def test_both_spellings_of_a_quaternion():
    q = Quaterniond(0.1, 0.2, 0.3)
    assert (q.w, q.x, q.y, q.z) == (q.W(), q.X(), q.Y(), q.Z()) == tuple(q)
    assert q.u == q.w
    assert near(q.GetAsEuler(), (0.1, 0.2, 0.3))
    assert (q.Roll(), q.GetPitch(), q.Yaw()) == pytest.approx((0.1, 0.2, 0.3))
    assert str(q) == "0.1 0.2 0.3"
    assert q.Euler(Vector3d(0.3, 0.2, 0.1)).Equal(q.Euler(0.3, 0.2, 0.1), 1e-12)
    q.w = 0.5
    assert q.u == 0.5
    q.SetFromAxis(0, 0, 1, 0.5)
    assert near(q, Quaterniond(0, 0, 0.5))
    q.Axis(Vector3d(0, 3, 0), 0.25)
    assert near(q, Quaterniond(0, 0.25, 0))
    axis, angle = q.GetAsAxis()
    assert near(axis, (0, 1, 0))
    assert angle == pytest.approx(0.25)
    q.Scale(2.0)
    assert near(q, Quaterniond(0, 0.5, 0))
    assert near(Quaterniond.EulerToQuaternion(0.1, 0.2, 0.3), gz.GzQuaternFromEuler(0.1, 0.2, 0.3))


def test_rotations_by_known_values():
    quarter = Quaterniond(0, 0, pymath.pi / 2)
    assert near(quarter.RotateVector(Vector3d.UnitX), Vector3d.UnitY)
    assert near(quarter.RotateVectorReverse(Vector3d.UnitX), -Vector3d.UnitY)
    assert near(quarter * Vector3d(1, 2, 3), (-2, 1, 3))
    assert near(quarter.XAxis(), (0, 1, 0))
    assert near(quarter.YAxis(), (-1, 0, 0))
    assert near(quarter.ZAxis(), (0, 0, 1))
    assert near(quarter * quarter, Quaterniond(0, 0, pymath.pi))
    assert near(Quaterniond().Integrate((0, 0, 0.5), 2.0), Quaterniond(0, 0, 1.0))
    q = Quaterniond()
    q.From2Axes((2, 0, 0), (0, 0, 3))
    assert near(q * Vector3d.UnitX, Vector3d.UnitZ)
    q.From2Axes((0, 1, 0), (0, -1, 0))
    assert near(q * Vector3d.UnitY, -Vector3d.UnitY)


@given(quaternions, quaternions, vectors)
def test_quaternions_agree_with_the_engine_and_with_matrices(a, b, v):
    assert near(a * b, gz.GzQuaternMul(a, b))
    assert near(a * v, gz.rotate(a, v))
    assert near(a * v, Matrix3d(a) * v)
    assert near((a * b) * v, a * (b * v), 1e-8)
    assert near(a.Inverse() * (a * v), v, 1e-8)
    assert near(a.RotateVectorReverse(a.RotateVector(v)), v, 1e-8)
    assert near((a * v).Length(), v.Length())
    assert near((a * 3.0) * v, a * v)  # of any length
    assert near((a * 3.0) * (a * 3.0).Inverse(), Quaterniond.Identity)
    assert same_rotation(Quaterniond(Matrix3d(a)), a)
    assert same_rotation(a.Log().Exp(), a)  # the logarithm of -1 has no direction


@given(angles, st.floats(-1.57, 1.57), angles)
def test_euler_angles_come_back(roll, pitch, yaw):
    q = Quaterniond(roll, pitch, yaw)
    assert near(q, gz.GzQuaternFromEuler(roll, pitch, yaw))
    assert near(np.exp(1j * np.asarray(q.Euler())), np.exp(1j * np.array([roll, pitch, yaw])), 1e-6)
    if abs(pitch) < 1.5:
        assert near(np.exp(1j * np.asarray(q.Euler())), np.exp(1j * np.asarray(gz.GzQuaternToEuler(q))), 1e-9)


@given(quaternions, st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.sampled_from([-0.5, 0.5]))
def test_euler_angles_mean_the_rotation_they_come_from_even_straight_up_and_down(q, roll, yaw, quarters):
    assert same_rotation(Quaterniond(q.Euler()), q, 1e-8)
    upright = Quaterniond(roll, quarters * pymath.pi, yaw)
    assert same_rotation(Quaterniond(upright.Euler()), upright, 1e-8)
    assert upright.Euler().z == 0.0


@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_slerp_turns_evenly_and_squad_hits_its_ends(a, b, t):
    if a.Dot(b) < -0.999:
        return
    middle = Quaterniond.Slerp(t, a, b, True)
    whole = (a.Inverse() * b).AxisAngle()[1]
    whole = min(whole, 2 * pymath.pi - whole)
    angle = (a.Inverse() * middle).AxisAngle()[1]
    assert min(angle, 2 * pymath.pi - angle) == pytest.approx(whole * t, abs=1e-6)
    assert near(Quaterniond.Squad(0.0, a, a, b, b), a, 1e-8)
    assert near(Quaterniond.Squad(1.0, a, a, b, b), b, 1e-8)


def test_broken_quaternions_are_mended():
    q = Quaterniond(pymath.nan, 0, 0, 0)
    assert not q.IsFinite()
    q.Correct()
    assert q == Quaterniond.Identity
    assert Quaterniond.Zero.Normalized() == Quaterniond.Zero.Inverse() == Quaterniond.Identity


# Poses


def test_a_pose_is_made_in_every_way_that_plugins_use():
    pose = Pose3d(1, 2, 3, 0.1, 0.2, 0.3)
    assert Pose3d(Vector3d(1, 2, 3), Quaterniond(0.1, 0.2, 0.3)) == pose
    assert Pose3d((1, 2, 3), (0.1, 0.2, 0.3)) == pose
    assert Pose3d(*pose.pos, *pose.rot) == pose
    assert Pose3d(pose) == pose
    assert Pose3d(gz.GzPose(pose.pos, pose.rot)) == pose
    assert parse(Pose3d, "1 2 3 0.1 0.2 0.3") == pose
    assert math.Pose is Pose3d
    assert str(pose) == "1 2 3 0.1 0.2 0.3"
    assert format_value(pose) == "1 2 3 0.1 0.2 0.3"
    with pytest.raises(ParameterError, match="Pose3d takes"):
        Pose3d(1, 2, 3)
    with pytest.raises(ParameterError, match="Pose3d"):
        parse(Pose3d, "1 2 3")


def test_both_spellings_of_a_pose_and_its_parts():
    pos = Vector3d(1, 2, 3)
    pose = Pose3d(pos, Quaterniond(0, 0, 0.5))
    assert pose.pos is pose.Pos()
    assert pose.rot is pose.Rot()
    pose.Pos().X(10.0)
    pose.SetY(20.0)
    pose.pos.z = 30.0
    assert (pose.X(), pose.Y(), pose.Z()) == (10.0, 20.0, 30.0)
    assert pos == Vector3d(1, 2, 3)
    assert (pose.Roll(), pose.Pitch(), pose.Yaw()) == pytest.approx((0, 0, 0.5))
    pose.Set(0, 0, 1, 0, 0, pymath.pi)
    assert near(pose.rot * Vector3d.UnitX, -Vector3d.UnitX)
    pose.SetPos((1, 1, 1))
    pose.SetRot((1, 0, 0, 0))
    assert pose == Pose3d(1, 1, 1, 0, 0, 0)
    pose.Reset()
    assert pose == Pose3d.Zero


def test_composition_by_known_values():
    a = Pose3d(1, 0, 0, 0, 0, pymath.pi / 2)  # at x 1, looking along y
    b = Pose3d(2, 0, 0, 0, 0, 0)  # two metres ahead of it
    assert (a * b).Equal(Pose3d(1, 2, 0, 0, 0, pymath.pi / 2), 1e-12)
    assert (b + a).Equal(a * b, 1e-12)
    assert (a + b).Equal(Pose3d(3, 0, 0, 0, 0, pymath.pi / 2), 1e-12)
    assert (a * b - a).Equal(b, 1e-12)
    assert near(a.CoordPositionAdd(Vector3d(2, 0, 0)), (1, 2, 0))
    assert near(b.CoordPositionAdd(a), (1, 2, 0))
    assert near((a * b).CoordPositionSub(a), (2, 0, 0))
    assert near(a.RotatePositionAboutOrigin(a.rot).pos, (0, 1, 0))


@given(poses, poses, poses)
def test_poses_form_a_group(a, b, c):
    assert ((a * b) * c).Equal(a * (b * c), 1e-7)
    assert (a * a.Inverse()).Equal(Pose3d.Zero, 1e-8)
    assert (a + b).Equal(b * a, 1e-9)
    assert ((a - b) + b).Equal(a, 1e-7)
    assert (-a).Equal(Pose3d.Zero - a, 1e-8)
    assert (a - b).Equal(b.Inverse() * a, 1e-7)


@given(poses, poses)
def test_poses_agree_with_the_engine(a, b):
    assert (a + b).Equal(Pose3d(gz.GzCoordPoseAdd(a, b)), 1e-9)
    assert (a - b).Equal(Pose3d(gz.GzCoordPoseSub(a, b)), 1e-9)
    assert (a + a.CoordPoseSolve(b)).Equal(b, 1e-6)
    assert near(a.CoordRotationAdd(b.rot), gz.GzCoordRotationAdd(a.rot, b.rot))
    assert near(a.CoordRotationSub(b.rot), gz.GzCoordRotationSub(a.rot, b.rot))
    plain = gz.GzPose(gz.GzVector(*a.pos), gz.GzQuatern(*a.rot))
    assert (plain + b).Equal(a + b, 1e-12)
    assert (plain - b).Equal(a - b, 1e-12)
    assert (plain * b).Equal(a * b, 1e-12)


# The rest


def test_angles():
    a = Angle(pymath.pi / 2)
    assert (a.Degree(), a.GetAsDegree(), a.Radian(), a(), float(a)) == (90.0, 90.0, a.radian, a.radian, a.radian)
    assert Angle.Pi / 2 == a == pymath.pi / 2
    assert Angle.HalfPi + 1.0 == 1.0 + a
    assert 2 * a - a == a
    assert a < 2.0 <= Angle(2.0) < Angle.Pi
    assert pymath.sin(a) == 1.0
    assert type(np.float64(2.0) * a) is Angle
    wound = Angle(3 * pymath.pi / 2)
    assert wound.Normalized().Degree() == pytest.approx(-90.0)
    wound.Normalize()
    assert wound.Equal(-a, 1e-12)
    wound.SetFromDegree(180)
    assert wound == Angle.Pi
    assert parse(Angle, "0.5") == 0.5
    assert Angle(0.5) != "0.5"


def test_colours():
    c = Color(0.2, 0.4, 0.6)
    assert (c.R(), c.g, c.B(), c.a) == (0.2, 0.4, 0.6, 1.0)
    assert c.HSV().Equal((210.0, 2 / 3, 0.6), 1e-9)
    again = Color()
    again.SetFromHSV(*c.HSV())
    assert again.Equal(c, 1e-12)
    assert Color.Red + Color.Green == Color(1, 1, 0, 2)
    assert (c * 0.5).Equal(Color(0.1, 0.2, 0.3, 0.5), 1e-12)
    loud = Color(255, -1, 0.5, 1)
    loud.Clamp()
    assert loud == Color(1, 0, 0.5, 1)
    assert parse(Color, "1 0 0") == Color.Red
    assert gz.GzVectorAdd(tuple(c)[:3], (0, 0, 0)) == Vector3d(0.2, 0.4, 0.6)


def test_matrices():
    m = Matrix3d(2, 0, 1, 0, 3, 0, 1, 0, 4)
    assert m[0][2] == m(0, 2) == 1.0
    assert m.Determinant() == pytest.approx(np.linalg.det(np.asarray(m))) == 21.0
    assert (m * m.Inverse()).Equal(Matrix3d.Identity, 1e-12)
    assert m * Vector3d(1, 2, 3) == Vector3d(5, 6, 13)
    assert Vector3d(1, 2, 3) * m == m.Transposed() * Vector3d(1, 2, 3)
    assert 2 * m - m == m
    m.Set(0, 1, 5.0)
    assert m.Transposed()[1][0] == 5.0
    m.SetFromAxis((0, 0, 1), pymath.pi / 2)
    assert near(m * Vector3d.UnitX, Vector3d.UnitY)
    assert near(gz.GzQuaternFromHomo(m), Quaterniond(0, 0, pymath.pi / 2))
    m.SetAxes((1, 0, 0), (0, 1, 0), (0, 0, 1))
    assert m == Matrix3d.Identity == gz.GzHomo()
    with pytest.raises(ParameterError, match="no inverse"):
        Matrix3d.Zero.Inverse()
    with pytest.raises(ParameterError, match="nine numbers"):
        Matrix3d([[1, 2], [3, 4]])


def test_random_numbers_repeat_with_their_seed():
    Rand.Seed(42)
    first = [Rand.DblUniform(-1, 1), Rand.GetDblNormal(5, 2), Rand.IntUniform(1, 6), Rand.IntNormal(10, 3)]
    Rand.SetSeed(Rand.GetSeed())
    again = [Rand.GetDblUniform(-1, 1), Rand.DblNormal(5, 2), Rand.GetIntUniform(1, 6), Rand.GetIntNormal(10, 3)]
    assert first == again
    draws = [Rand.IntUniform(1, 3) for _ in range(200)]
    assert set(draws) == {1, 2, 3}
    normal = np.array([Rand.DblNormal(5.0, 2.0) for _ in range(4000)])
    assert normal.mean() == pytest.approx(5.0, abs=0.15)
    assert normal.std() == pytest.approx(2.0, abs=0.1)


def test_small_functions_and_pythons_own():
    assert (math.clamp(5, 0, 3), math.clamp(-1.0, 0.0, 3.0), math.clamp(1, 0, 3)) == (3, 0.0, 1)
    assert math.equal(1.0, 1.0 + 1e-7)
    assert not math.equal(1.0, 1.1)
    assert math.equal(1.0, 1.1, 0.2)
    assert math.isnan(math.NAN_D)
    assert math.fixnan(math.inf) == 0.0
    assert math.precision(1.23456, 2) == 1.23
    assert math.sin(math.IGN_PI_2) == 1.0
    assert math.IGN_RTOD(math.IGN_DTOR(30.0)) == pytest.approx(30.0)
    with pytest.raises(AttributeError, match="no attribute 'sine'"):
        _ = math.sine
