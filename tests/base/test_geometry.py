"""The old conventions, by round trips and by known values."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from libgz.base.geometry import (
    NORMALIZE,
    GzCoordPoseAdd,
    GzCoordPoseSolve,
    GzCoordPoseSub,
    GzHomoFromQuatern,
    GzHomoInverse,
    GzHomoMul,
    GzPose,
    GzPosePointAt,
    GzQuatern,
    GzQuaternFromAxis,
    GzQuaternFromEuler,
    GzQuaternFromHomo,
    GzQuaternInverse,
    GzQuaternMul,
    GzQuaternNormal,
    GzQuaternScale,
    GzQuaternToAxis,
    GzQuaternToEuler,
    GzVector,
    GzVectorCross,
    GzVectorDot,
    GzVectorSub,
    GzVectorUnit,
    rotate,
)

coordinate = st.floats(-100.0, 100.0)
vectors = st.builds(GzVector, coordinate, coordinate, coordinate)
angles = st.floats(-3.1, 3.1)
components = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: sum(c * c for c in q) > 1e-3)
quaternions = components.map(GzQuaternNormal)
poses = st.builds(GzPose, vectors, quaternions)


def same_rotation(a, b):
    return abs(abs(np.dot(tuple(a), tuple(b))) - 1.0) < 1e-9


def close(a, b):
    return np.allclose(tuple(a), tuple(b), atol=1e-7)


@given(angles, st.floats(-1.5, 1.5), angles)
def test_euler_round_trip(roll, pitch, yaw):
    assert close(GzQuaternToEuler(GzQuaternFromEuler(roll, pitch, yaw)), (roll, pitch, yaw))


def test_euler_order_is_roll_then_pitch_then_yaw():
    about_x, about_y, about_z = (GzQuaternFromAxis(*axis, 0.7) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
    assert same_rotation(GzQuaternFromEuler(0.7, 0.7, 0.7), GzQuaternMul(about_z, GzQuaternMul(about_y, about_x)))
    assert close(rotate(GzQuaternFromEuler(0, 0, math.pi / 2), (1, 0, 0)), (0, 1, 0))
    assert close(rotate(GzQuaternFromEuler(0, math.pi / 2, 0), (1, 0, 0)), (0, 0, -1))


@given(poses, poses)
def test_pose_composition_round_trip(b, a):
    c = GzCoordPoseAdd(b, a)
    back = GzCoordPoseSub(c, a)
    assert close(back.pos, b.pos)
    assert same_rotation(back.rot, b.rot)
    solved = GzCoordPoseSolve(b, c)
    assert close(solved.pos, a.pos)
    assert same_rotation(solved.rot, a.rot)


@given(poses, poses, poses)
def test_pose_composition_is_associative(a, b, c):
    left, right = GzCoordPoseAdd(GzCoordPoseAdd(a, b), c), GzCoordPoseAdd(a, GzCoordPoseAdd(b, c))
    assert close(left.pos, right.pos)
    assert same_rotation(left.rot, right.rot)


@given(quaternions, vectors)
def test_rotation_matrix_and_quaternion_agree(q, v):
    assert close(GzHomoMul(GzHomoFromQuatern(q), v), rotate(q, v))
    assert same_rotation(GzQuaternFromHomo(GzHomoFromQuatern(q)), q)
    assert close(GzHomoMul(GzHomoInverse(GzHomoFromQuatern(q)), rotate(q, v)), v)
    assert close(rotate(GzQuaternInverse(q), rotate(q, v)), v)


def test_matrix_of_a_half_turn():
    for q in ((0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)):
        assert same_rotation(GzQuaternFromHomo(GzHomoFromQuatern(q)), q)


@given(vectors, st.floats(0.1, 3.0))
def test_axis_and_angle(axis, angle):
    if sum(c * c for c in axis) < 1e-6:
        return
    q = GzQuaternFromAxis(*axis, angle)
    assert GzQuaternToAxis(q).u == pytest.approx(angle, abs=1e-6)
    assert same_rotation(GzQuaternScale(0.5, q), GzQuaternFromAxis(*axis, angle / 2))


def test_axis_of_no_length_is_no_rotation():
    assert tuple(GzQuaternFromAxis(0, 0, 0, 1.0)) == (1, 0, 0, 0)


def test_subtraction_is_first_minus_second():
    assert GzVectorSub((3, 2, 1), (1, 1, 1)) == GzVector(2, 1, 0)


def test_dot_uses_all_components():
    assert GzVectorDot((1, 2, 3), (4, 5, 6)) == 32


@given(vectors, vectors)
def test_cross_is_perpendicular(a, b):
    cross = GzVectorCross(a, b)
    assert GzVectorDot(cross, a) == pytest.approx(0, abs=1e-3)


def test_unit_of_zero_is_nan():
    assert all(map(math.isnan, GzVectorUnit((0, 0, 0))))


def test_point_at_looks_along_x_with_z_up():
    pose = GzPosePointAt((0, 0, 0), (0, 2, 0), (0, 0, 1))
    assert close(rotate(pose.rot, (1, 0, 0)), (0, 1, 0))
    assert close(rotate(pose.rot, (0, 0, 1)), (0, 0, 1))
    behind = GzPosePointAt((0, 0, 0), (-1, 0, 0), (0, 0, 1))
    assert close(rotate(behind.rot, (1, 0, 0)), (-1, 0, 0))


def test_normalize_angle():
    assert pytest.approx(-math.pi / 2) == NORMALIZE(1.5 * math.pi)


def test_structs_behave_like_the_old_ones_and_like_tuples():
    pose = GzPose()
    pose.pos.z = 2.0
    x, y, z = pose.pos
    assert (x, y, z, pose.pos[2], len(pose.rot)) == (0, 0, 2, 2, 4)
    assert np.asarray(GzQuatern(1, 2, 3, 4)).tolist() == [1, 2, 3, 4]
    assert GzPose().pos is not GzPose().pos


@pytest.mark.parametrize("pitch", [1.5, math.pi / 2 - 1e-6, math.pi / 2, -math.pi / 2, -1.5])
@pytest.mark.parametrize(("roll", "yaw"), [(0.3, 0.5), (-2.0, 1.0), (3.0, -3.0)])
def test_euler_angles_hold_however_steep(roll, pitch, yaw):
    q = GzQuaternFromEuler(roll, pitch, yaw)
    again = GzQuaternFromEuler(*GzQuaternToEuler(q))
    assert abs(sum(a * b for a, b in zip(q, again, strict=True))) == pytest.approx(1.0, abs=1e-14)
