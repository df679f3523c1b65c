"""Boxes, and moments of inertia by known formulas."""

import math as pymath

import pytest

from libgz.classic.math import (
    AxisAlignedBox,
    Inertiald,
    MassMatrix3d,
    Matrix3d,
    Pose3d,
    Quaterniond,
    Vector3d,
)


def test_boxes():
    box = AxisAlignedBox(Vector3d(1, 1, 1), Vector3d(-1, 0, 3))
    assert (box.Min(), box.max) == (Vector3d(-1, 0, 1), Vector3d(1, 1, 3))
    assert box.Center() == Vector3d(0, 0.5, 2)
    assert box.GetSize() == Vector3d(2, 1, 2)
    assert box.Volume() == 4.0
    assert box.Contains((0, 0.5, 2))
    assert not box.Contains((0, 0.5, 3.1))
    assert box.Intersects(AxisAlignedBox(0, 0, 0, 5, 5, 5))
    assert not box.Intersects(AxisAlignedBox(2, 2, 2, 5, 5, 5))
    assert box + AxisAlignedBox(2, 2, 2, 5, 5, 5) == AxisAlignedBox(-1, 0, 1, 5, 5, 5)
    assert box - (1, 0, 0) == AxisAlignedBox(-2, 0, 1, 0, 1, 3)
    empty = AxisAlignedBox()
    assert empty.Size() == Vector3d.Zero
    assert not empty.Intersects(box)
    empty.Merge(box)
    assert empty == box
    assert str(box) == "Min[-1 0 1] Max[1 1 3]"


def test_inertia_of_shapes_by_known_formulas():
    m = MassMatrix3d()
    m.SetFromBox(12.0, (1, 2, 3))
    assert m.DiagonalMoments() == Vector3d(13, 10, 5)
    assert m.PrincipalMoments().Equal((5, 10, 13), 1e-9)
    sides, turn = m.EquivalentBox()
    assert sorted(sides) == pytest.approx([1, 2, 3])
    assert turn.Determinant() == pytest.approx(1.0)
    m.SetFromSphere(10.0, 0.5)
    assert m.IXX() == m.IZZ() == 1.0
    m.SetFromCylinderZ(12.0, 2.0, 1.0)
    assert (m.IXX(), m.IZZ()) == (7.0, 6.0)
    assert m.IsValid()
    m.SetIZZ(100.0)
    assert m.IsPositive()
    assert not m.IsValid()


def test_inertia_turns_and_adds_up():
    half = MassMatrix3d()
    half.SetFromBox(6.0, (1, 2, 1.5))
    low = Inertiald(half, Pose3d(0, 0, 0.25, 0, 0, 0))
    high = Inertiald(half, Pose3d(0, 0, 1.75, 0, 0, 0))
    both = low + high
    assert both.Mass() == 12.0
    assert both.CoG() == Vector3d(0, 0, 1.0)
    whole = MassMatrix3d()
    whole.SetFromBox(12.0, (1, 2, 3))
    assert both.MOI().Equal(whole.Moi(), 1e-9)
    turned = Inertiald(whole, Pose3d(0, 0, 0, 0, 0, pymath.pi / 2))
    assert turned.MOI().Equal(Matrix3d(10, 0, 0, 0, 13, 0, 0, 0, 5), 1e-9)
    before = turned.MOI()
    turned.SetMassMatrixRotation(Quaterniond(0.1, 0.2, 0.3))
    assert turned.MOI().Equal(before, 1e-9)
    assert turned.Pose().Rot().Equal(Quaterniond(0.1, 0.2, 0.3), 1e-12)
