"""MassMatrix3d and Inertiald: mass, centre of mass, and moments of inertia."""

from __future__ import annotations

import math

import numpy as np

from libgz.base.geometry import GzHomo, GzPose, QuaternLike, VectorLike
from libgz.classic.math.matrix3 import Matrix3d
from libgz.classic.math.pose import Pose3d
from libgz.classic.math.vector3 import Vector3d

__all__ = ["Inertiald", "MassMatrix3d"]


class MassMatrix3d:
    """A mass [kg] and the moments of inertia about its centre [kg m^2]."""

    __slots__ = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz", "mass")
    __hash__ = None  # type: ignore[assignment]

    def __init__(
        self,
        mass: float = 0.0,
        diagonal: VectorLike = (0.0, 0.0, 0.0),
        off_diagonal: VectorLike = (0.0, 0.0, 0.0),
    ) -> None:
        """From the mass [kg], ixx, iyy, izz and ixy, ixz, iyz [kg m^2]."""
        self.mass = float(mass)
        self.ixx, self.iyy, self.izz = map(float, diagonal)
        self.ixy, self.ixz, self.iyz = map(float, off_diagonal)

    def Mass(self, value: float | None = None) -> float:
        """The mass [kg]; an argument sets it first."""
        if value is not None:
            self.mass = float(value)
        return self.mass

    def IXX(self, value: float | None = None) -> float:
        """The moment about x [kg m^2]; an argument sets it first."""
        if value is not None:
            self.ixx = float(value)
        return self.ixx

    def IYY(self, value: float | None = None) -> float:
        """The moment about y [kg m^2]; an argument sets it first."""
        if value is not None:
            self.iyy = float(value)
        return self.iyy

    def IZZ(self, value: float | None = None) -> float:
        """The moment about z [kg m^2]; an argument sets it first."""
        if value is not None:
            self.izz = float(value)
        return self.izz

    def IXY(self, value: float | None = None) -> float:
        """The product of x and y [kg m^2]; an argument sets it first."""
        if value is not None:
            self.ixy = float(value)
        return self.ixy

    def IXZ(self, value: float | None = None) -> float:
        """The product of x and z [kg m^2]; an argument sets it first."""
        if value is not None:
            self.ixz = float(value)
        return self.ixz

    def IYZ(self, value: float | None = None) -> float:
        """The product of y and z [kg m^2]; an argument sets it first."""
        if value is not None:
            self.iyz = float(value)
        return self.iyz

    def DiagonalMoments(self, value: VectorLike | None = None) -> Vector3d:
        """ixx, iyy, izz [kg m^2]; an argument sets them first."""
        if value is not None:
            self.ixx, self.iyy, self.izz = map(float, value)
        return Vector3d(self.ixx, self.iyy, self.izz)

    def OffDiagonalMoments(self, value: VectorLike | None = None) -> Vector3d:
        """ixy, ixz, iyz [kg m^2]; an argument sets them first."""
        if value is not None:
            self.ixy, self.ixz, self.iyz = map(float, value)
        return Vector3d(self.ixy, self.ixz, self.iyz)

    def Moi(self, value: GzHomo | None = None) -> Matrix3d:
        """The matrix of inertia [kg m^2]; an argument sets it first, products as the mean of both sides."""
        if value is not None:
            m = value.m
            self.ixx, self.iyy, self.izz = m[0][0], m[1][1], m[2][2]
            self.ixy, self.ixz, self.iyz = (
                0.5 * (m[0][1] + m[1][0]),
                0.5 * (m[0][2] + m[2][0]),
                0.5 * (m[1][2] + m[2][1]),
            )
        return Matrix3d(self.ixx, self.ixy, self.ixz, self.ixy, self.iyy, self.iyz, self.ixz, self.iyz, self.izz)

    def PrincipalMoments(self) -> Vector3d:
        """The moments about the principal axes [kg m^2], the smallest first."""
        return Vector3d(*map(float, np.linalg.eigvalsh(np.asarray(self.Moi()))))

    def IsPositive(self) -> bool:
        """Whether mass and matrix are positive, as a body requires."""
        return self.mass > 0.0 and self.PrincipalMoments().x > 0.0

    def IsValid(self) -> bool:
        """Whether a real body can have them: positive, and no principal moment larger than the sum of the others."""
        moments = self.PrincipalMoments()
        return self.mass > 0.0 and moments.x > 0.0 and moments.x + moments.y >= moments.z * (1.0 - 1e-9)

    def _set(self, mass: float, diagonal: VectorLike) -> None:
        self.mass = float(mass)
        self.DiagonalMoments(diagonal)
        self.OffDiagonalMoments((0.0, 0.0, 0.0))

    def SetFromBox(self, mass: float, size: VectorLike) -> None:
        """Set them to those of a box [kg, m]: ixx = m (y^2 + z^2) / 12, and so on."""
        x, y, z = size
        m = mass / 12.0
        self._set(mass, (m * (y * y + z * z), m * (z * z + x * x), m * (x * x + y * y)))

    def SetInertiaMatrix(self, ixx: float, iyy: float, izz: float, ixy: float, ixz: float, iyz: float) -> None:
        """Set the moments and products [kg m^2]."""
        self.DiagonalMoments((ixx, iyy, izz))
        self.OffDiagonalMoments((ixy, ixz, iyz))

    def SetFromCylinderZ(self, mass: float, length: float, radius: float) -> None:
        """Set them to those of a cylinder along z [kg, m]: izz = m r^2 / 2, ixx = iyy = m (3 r^2 + l^2) / 12."""
        across = mass * (3.0 * radius * radius + length * length) / 12.0
        self._set(mass, (across, across, mass * radius * radius / 2.0))

    def SetFromSphere(self, mass: float, radius: float) -> None:
        """Set them to those of a solid sphere [kg, m]: 2 m r^2 / 5."""
        self._set(mass, (0.4 * mass * radius * radius,) * 3)

    def EquivalentBox(self) -> tuple[Vector3d, Matrix3d]:
        """Sides [m] and rotation of the homogeneous box with this mass and these moments.

        With principal moments a, b, c the side along the first axis is sqrt(6 (b + c - a) / m), and so on.
        """
        values, vectors = np.linalg.eigh(np.asarray(self.Moi()))
        if np.linalg.det(vectors) < 0.0:
            vectors[:, 2] = -vectors[:, 2]
        sides = [math.sqrt(max(0.0, 6.0 * float(values.sum() - 2.0 * value) / self.mass)) for value in values]
        return Vector3d(*sides), Matrix3d(vectors)

    def _values(self) -> tuple[float, ...]:
        return self.mass, self.ixx, self.iyy, self.izz, self.ixy, self.ixz, self.iyz

    def __eq__(self, other: object) -> bool:
        return self._values() == other._values() if isinstance(other, MassMatrix3d) else NotImplemented

    def __repr__(self) -> str:
        diagonal, products = (self.ixx, self.iyy, self.izz), (self.ixy, self.ixz, self.iyz)
        return f"MassMatrix3d({self.mass!r}, {diagonal!r}, {products!r})"

    SetMass = Mass
    SetIXX, SetIYY, SetIZZ = IXX, IYY, IZZ
    Ixx, Iyy, Izz, Ixy, Ixz, Iyz = IXX, IYY, IZZ, IXY, IXZ, IYZ
    SetIxx, SetIyy, SetIzz, SetIxy, SetIxz, SetIyz = IXX, IYY, IZZ, IXY, IXZ, IYZ
    SetIXY, SetIXZ, SetIYZ = IXY, IXZ, IYZ
    SetDiagonalMoments, SetOffDiagonalMoments = DiagonalMoments, OffDiagonalMoments
    MOI = SetMoi = Moi


class Inertiald:
    """The mass of a body: mass and moments about the centre of mass, and the pose of their frame.

    The frame lies at the centre of mass; its pose is relative to the link.
    """

    __slots__ = ("mass_matrix", "pose")
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, mass_matrix: MassMatrix3d | None = None, pose: GzPose | None = None) -> None:
        self.mass_matrix = mass_matrix or MassMatrix3d()
        self.pose = Pose3d(pose) if pose else Pose3d()

    def MassMatrix(self, value: MassMatrix3d | None = None) -> MassMatrix3d:
        """Mass and moments about the centre, in the frame of `Pose()`; an argument sets them first."""
        if value is not None:
            self.mass_matrix = value
        return self.mass_matrix

    def Pose(self, value: GzPose | None = None) -> Pose3d:
        """The frame of the mass, in that of the link; an argument sets it first."""
        if value is not None:
            self.pose = Pose3d(value)
        return self.pose

    def Mass(self) -> float:
        """The mass [kg]."""
        return self.mass_matrix.mass

    def CoG(self) -> Vector3d:
        """The centre of mass in the link [m]."""
        return self.pose.pos

    def MOI(self) -> Matrix3d:
        """The matrix of inertia about the centre of mass, along the link's axes [kg m^2]."""
        turn = Matrix3d(self.pose.rot)
        return turn * self.mass_matrix.Moi() * turn.Transposed()

    def SetMassMatrixRotation(self, rot: QuaternLike) -> None:
        """Set the rotation of the frame of the mass in the link, and convert the moments to its axes."""
        moi = self.MOI()
        self.pose.SetRot(rot)
        turn = Matrix3d(self.pose.rot)
        self.mass_matrix.Moi(turn.Transposed() * moi * turn)

    def __add__(self, other: Inertiald) -> Inertiald:
        """Both bodies combined, along the link's axes (parallel axis theorem)."""
        if not isinstance(other, Inertiald):
            return NotImplemented
        mass = self.Mass() + other.Mass()
        centre = (self.CoG() * self.Mass() + other.CoG() * other.Mass()) / mass
        moi = Matrix3d()
        for part in (self, other):
            d = part.CoG() - centre
            away = Matrix3d.Identity * d.SquaredLength() - Matrix3d([d * d.x, d * d.y, d * d.z])
            moi = moi + part.MOI() + away * part.Mass()
        matrix = MassMatrix3d(mass)
        matrix.Moi(moi)
        return Inertiald(matrix, Pose3d(centre, (1.0, 0.0, 0.0, 0.0)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Inertiald):
            return NotImplemented
        return self.mass_matrix == other.mass_matrix and self.pose == other.pose

    def __repr__(self) -> str:
        return f"Inertiald({self.mass_matrix!r}, {self.pose!r})"

    SetMassMatrix = MassMatrix
    SetPose = Pose
    Moi = MOI
    GetMass = Mass
    GetCoG = CoG
