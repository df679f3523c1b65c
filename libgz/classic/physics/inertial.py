"""Inertial: mass, centre of mass and moments of inertia of a link."""

from __future__ import annotations

from libgz.classic.math import MassMatrix3d, Matrix3d, Pose3d, Vector3d
from libgz.errors import ParameterError
from libgz.geometry import GzPose, GzVector, VectorLike
from libgz.physics.body import Body
from libgz.physics.mass import Mass as OdeMass, given_mass

__all__ = ["Inertial"]


class Inertial:
    """Mass [kg], centre of mass [m] in the link frame, and moments about it [kg m^2] along the link's axes.

    Args:
        body: the link's body, to which changes are written at once. None: values of its own, 1 kg and unit moments.
    """

    def __init__(self, body: Body | None = None) -> None:
        self._body = body
        self._matrix, self._centre = MassMatrix3d(1.0, (1.0, 1.0, 1.0)), Vector3d()
        if body is not None and not body.dummy:
            held = body.GetMass()
            i = held.I
            self._matrix = MassMatrix3d(held.mass, (i[0], i[5], i[10]), (i[1], i[2], i[6]))
            self._centre = Vector3d(*body.com)

    def matrix(self) -> OdeMass:
        """ODE's mass matrix in the link frame."""
        m = self._matrix
        moments = [m.ixx, m.iyy, m.izz, m.ixy, m.ixz, m.iyz]
        return given_mass(m.mass, moments, GzPose(GzVector(*self._centre)))

    def _write(self) -> None:
        """Write all values to the body."""
        if self._body is not None:
            self._body.SetMassMatrix(self.matrix())

    def Ign(self) -> Inertial:
        """The object itself: one class has both generations of names."""
        return self

    MassMatrix = Ign

    def Mass(self) -> float:
        """The mass [kg]."""
        return self._matrix.mass

    GetMass = Mass

    def SetMass(self, m: float) -> None:
        """Set the mass [kg].

        Raises:
            ParameterError: it is not positive.
        """
        if not m > 0.0:
            raise ParameterError(f"mass is {m:g} kg; it must be positive")
        self._matrix.mass = float(m)
        self._write()

    def CoG(self) -> Vector3d:
        """The centre of mass in the link frame [m]."""
        return Vector3d(*self._centre)

    GetCoG = CoG

    def SetCoG(self, *centre: VectorLike | float) -> None:
        """Set the centre of mass [m]: three numbers or a vector."""
        values = centre[0] if len(centre) == 1 else centre
        self._centre = Vector3d(*values)  # type: ignore[misc]
        self._write()

    def Pose(self) -> Pose3d:
        """The centre of mass as a pose [m]."""
        return Pose3d(GzPose(GzVector(*self._centre)))

    GetPose = Pose

    def SetInertiaMatrix(self, ixx: float, iyy: float, izz: float, ixy: float, ixz: float, iyz: float) -> None:
        """Set the moments of inertia [kg m^2]."""
        self._matrix.SetDiagonalMoments((ixx, iyy, izz))
        self._matrix.SetOffDiagonalMoments((ixy, ixz, iyz))
        self._write()

    def MOI(self) -> Matrix3d:
        """The matrix of inertia [kg m^2]."""
        return self._matrix.Moi()

    GetMOI = MOI
    Moi = MOI

    def PrincipalMoments(self) -> Vector3d:
        """The moments on the diagonal [kg m^2], as in Gazebo: ixx, iyy, izz."""
        return self._matrix.DiagonalMoments()

    GetPrincipalMoments = PrincipalMoments

    def ProductsOfInertia(self) -> Vector3d:
        """The moments off the diagonal [kg m^2]: ixy, ixz, iyz."""
        return self._matrix.OffDiagonalMoments()

    GetProductsofInertia = ProductsOfInertia

    def IXX(self) -> float:
        """The moment ixx [kg m^2]."""
        return self._matrix.ixx

    def SetIXX(self, value: float) -> None:
        """Set the moment ixx [kg m^2]."""
        self._matrix.ixx = float(value)
        self._write()

    def IYY(self) -> float:
        """The moment iyy [kg m^2]."""
        return self._matrix.iyy

    def SetIYY(self, value: float) -> None:
        """Set the moment iyy [kg m^2]."""
        self._matrix.iyy = float(value)
        self._write()

    def IZZ(self) -> float:
        """The moment izz [kg m^2]."""
        return self._matrix.izz

    def SetIZZ(self, value: float) -> None:
        """Set the moment izz [kg m^2]."""
        self._matrix.izz = float(value)
        self._write()

    def IXY(self) -> float:
        """The moment ixy [kg m^2]."""
        return self._matrix.ixy

    def SetIXY(self, value: float) -> None:
        """Set the moment ixy [kg m^2]."""
        self._matrix.ixy = float(value)
        self._write()

    def IXZ(self) -> float:
        """The moment ixz [kg m^2]."""
        return self._matrix.ixz

    def SetIXZ(self, value: float) -> None:
        """Set the moment ixz [kg m^2]."""
        self._matrix.ixz = float(value)
        self._write()

    def IYZ(self) -> float:
        """The moment iyz [kg m^2]."""
        return self._matrix.iyz

    def SetIYZ(self, value: float) -> None:
        """Set the moment iyz [kg m^2]."""
        self._matrix.iyz = float(value)
        self._write()

    GetIXX, GetIYY, GetIZZ, GetIXY, GetIXZ, GetIYZ = IXX, IYY, IZZ, IXY, IXZ, IYZ
    Ixx, Iyy, Izz, Ixy, Ixz, Iyz = IXX, IYY, IZZ, IXY, IXZ, IYZ
