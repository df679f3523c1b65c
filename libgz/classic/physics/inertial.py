"""Inertial: mass, centre of mass and moments of inertia of a link."""

from __future__ import annotations

from libgz.classic.math import Matrix3d, Pose3d, Vector3d
from libgz.errors import ParameterError
from libgz.geometry import GzPose, GzVector, VectorLike
from libgz.physics import mass as mass_
from libgz.physics.body import Body

__all__ = ["Inertial"]


class Inertial:
    """Mass [kg], centre of mass [m] in the link's frame, moments about it [kg m^2] in the link's axes.

    Args:
        body: the link's body: what is set changes it at once. None for values of its own: 1 kg, unit moments.
    """

    def __init__(self, body: Body | None = None) -> None:
        self._body = body
        self._mass, self._centre = 1.0, Vector3d()
        self._moments = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]  # xx, yy, zz, xy, xz, yz
        if body is not None and not body.dummy:
            held = body.GetMass()
            i = held.I
            self._mass, self._moments = float(held.mass), [i[0], i[5], i[10], i[1], i[2], i[6]]
            self._centre = Vector3d(*body.com)

    def matrix(self) -> mass_.Mass:
        """ODE's mass matrix in the link's frame."""
        return mass_.given_mass(self._mass, self._moments, GzPose(GzVector(*self._centre)))

    def _set(self) -> None:
        if self._body is not None:
            self._body.SetMassMatrix(self.matrix())

    def Ign(self) -> Inertial:
        """Itself: one class serves both generations of names."""
        return self

    MassMatrix = Ign

    def Mass(self) -> float:
        """[kg]."""
        return self._mass

    GetMass = Mass

    def SetMass(self, m: float) -> None:
        """Set the mass [kg].

        Raises:
            ParameterError: it is not positive.
        """
        if not m > 0.0:
            raise ParameterError(f"mass is {m:g} kg; it must be positive")
        self._mass = float(m)
        self._set()

    def CoG(self) -> Vector3d:
        """Centre of mass in the link's frame [m]."""
        return Vector3d(*self._centre)

    GetCoG = CoG

    def SetCoG(self, *centre: VectorLike | float) -> None:
        """Set the centre of mass [m]: three numbers or a vector."""
        values = centre[0] if len(centre) == 1 else centre
        self._centre = Vector3d(*values)  # type: ignore[misc]
        self._set()

    def Pose(self) -> Pose3d:
        """The centre of mass as a pose [m]."""
        return Pose3d(GzPose(GzVector(*self._centre)))

    GetPose = Pose

    def SetInertiaMatrix(self, ixx: float, iyy: float, izz: float, ixy: float, ixz: float, iyz: float) -> None:
        """Set the moments [kg m^2]."""
        self._moments = [ixx, iyy, izz, ixy, ixz, iyz]
        self._set()

    def rows(self) -> list[list[float]]:
        """The moments as three rows of three [kg m^2]."""
        xx, yy, zz, xy, xz, yz = self._moments
        return [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]

    def MOI(self) -> Matrix3d:
        """The moments as a matrix [kg m^2]."""
        return Matrix3d(*(value for row in self.rows() for value in row))

    GetMOI = MOI
    Moi = MOI

    def PrincipalMoments(self) -> Vector3d:
        """Moments on the diagonal [kg m^2], as in Gazebo: ixx, iyy, izz."""
        return Vector3d(*self._moments[:3])

    GetPrincipalMoments = PrincipalMoments

    def ProductsOfInertia(self) -> Vector3d:
        """Moments off the diagonal [kg m^2]: ixy, ixz, iyz."""
        return Vector3d(*self._moments[3:])

    GetProductsofInertia = ProductsOfInertia

    def IXX(self) -> float:
        """Moment ixx [kg m^2]."""
        return self._moments[0]

    def SetIXX(self, value: float) -> None:
        """Set the moment ixx [kg m^2]."""
        self._moment(0, value)

    def IYY(self) -> float:
        """Moment iyy [kg m^2]."""
        return self._moments[1]

    def SetIYY(self, value: float) -> None:
        """Set the moment iyy [kg m^2]."""
        self._moment(1, value)

    def IZZ(self) -> float:
        """Moment izz [kg m^2]."""
        return self._moments[2]

    def SetIZZ(self, value: float) -> None:
        """Set the moment izz [kg m^2]."""
        self._moment(2, value)

    def IXY(self) -> float:
        """Moment ixy [kg m^2]."""
        return self._moments[3]

    def SetIXY(self, value: float) -> None:
        """Set the moment ixy [kg m^2]."""
        self._moment(3, value)

    def IXZ(self) -> float:
        """Moment ixz [kg m^2]."""
        return self._moments[4]

    def SetIXZ(self, value: float) -> None:
        """Set the moment ixz [kg m^2]."""
        self._moment(4, value)

    def IYZ(self) -> float:
        """Moment iyz [kg m^2]."""
        return self._moments[5]

    def SetIYZ(self, value: float) -> None:
        """Set the moment iyz [kg m^2]."""
        self._moment(5, value)

    def _moment(self, index: int, value: float) -> None:
        self._moments[index] = float(value)
        self._set()

    GetIXX, GetIYY, GetIZZ, GetIXY, GetIXZ, GetIYZ = IXX, IYY, IZZ, IXY, IXZ, IYZ
    Ixx, Iyy, Izz, Ixy, Ixz, Iyz = IXX, IYY, IZZ, IXY, IXZ, IYZ
