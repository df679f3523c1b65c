"""Inertial: mass, centre of mass and moments of inertia of a link."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzVector, VectorLike
from libgz.classic.math import Inertiald, MassMatrix3d, Matrix3d, Pose3d, Quaterniond, Vector3d
from libgz.ode.types import Mass as OdeMass
from libgz.physics.body import Body
from libgz.physics.check import finite
from libgz.physics.mass import about_centre, given_mass

if TYPE_CHECKING:
    from libgz.classic import msgs
    from libgz.sdf.element import Element

__all__ = ["Inertial"]

AXES = ("xx", "yy", "zz", "xy", "xz", "yz")


class Inertial:
    """Mass [kg], a frame at the centre of mass, and moments of inertia about its origin along its axes [kg m^2].

    Values that are set act, all together, at the link's UpdateMass; so their order does not matter. Until then the
    object has the new values, and the link the old ones.

    Args:
        given: the body of a link, whose values it has; of a static model, all 0, as in Gazebo. Otherwise values of its
            own: those of another object, or a mass [kg] and unit moments; None is 1 kg.
        sdf: the element of the link, which has the axes of the frame.
    """

    STATE = ("_changed", "_mass", "_pose", "_held", "_before")
    _loaded: tuple[MassMatrix3d, Pose3d] | None = None

    def __init__(self, given: Body | Inertial | Inertiald | float | None = None, sdf: Element | None = None) -> None:
        body = given if isinstance(given, Body) else None
        self._static = body is not None and body.dummy
        self._body, self._sdf = (None, None) if self._static else (body, sdf)
        self._stale = False
        self._begin()
        if isinstance(given, Inertial | Inertiald):
            self.copy_from(given)
        elif given is not None and body is None:
            self.SetMass(given)  # type: ignore[arg-type]

    def forget(self) -> None:
        """Take the values of the link's element and of the body, as they are when they are first asked for."""
        self._changed, self._stale = False, True

    def _begin(self) -> None:
        self._changed = self._stale = False
        own = 0.0 if self._static else 1.0
        self._mass, self._pose = MassMatrix3d(own, (own, own, own)), Pose3d()
        self._held = b""  # the body's mass matrix and centre of mass, of which these values are
        self._before = self._mass, self._pose  # the values before the changes
        if self._sdf is not None:
            self._read_file(self._sdf)
        self._read()

    def _read_file(self, sdf: Element) -> None:
        """Take the values of a link's element, as far as the body still has them."""
        self._mass, self._pose = _of_element(sdf.child("inertial"))
        if self._body is not None:
            try:
                given = _numbers(self._matrix())
            except ParameterError:
                return  # the body got others as it was loaded
            held = _of_body(self._body)
            scale = np.array([held[0], *[1.0] * 3, *[np.abs(held[4:]).max()] * 9])
            if np.all(np.abs(given - held) <= 1e-9 * scale):
                self._held = held.tobytes()

    def _read(self) -> None:
        """Take the values of the body if they are not those of this object; the axes of the frame stay."""
        if self._stale:
            self._begin()
        if self._body is None or self._changed:
            return
        numbers = _of_body(self._body)
        if numbers.tobytes() == self._held:
            return
        self._held = numbers.tobytes()
        turn = np.asarray(Matrix3d(self._pose.rot))
        moments = turn.T @ numbers[4:].reshape(3, 3) @ turn
        self._mass.mass = float(numbers[0])
        self._mass.Moi(Matrix3d(*moments.ravel().tolist()))
        self._pose = Pose3d(GzPose(GzVector(*numbers[1:4].tolist()), self._pose.rot))

    def matrix(self) -> OdeMass:
        """ODE's mass matrix in the link frame.

        Raises:
            ParameterError: no body can have these values.
        """
        self._read()
        return self._matrix()

    def _matrix(self) -> OdeMass:
        m = self._mass
        return given_mass(m.mass, [m.ixx, m.iyy, m.izz, m.ixy, m.ixz, m.iyz], self._pose)

    def copy_from(self, other: Inertial | Inertiald) -> None:
        """Set all values to those of another object."""
        mass = other._values() if isinstance(other, Inertial) else other.MassMatrix()
        self._change()
        self._mass, self._pose = copy.deepcopy(mass), Pose3d(other.Pose())

    def Load(self, sdf: Element) -> None:
        """Take the values of an `<inertial>` element, to which Reset() goes back."""
        self._change()
        self._loaded = _of_element(sdf)
        self._mass, self._pose = copy.deepcopy(self._loaded[0]), Pose3d(self._loaded[1])

    UpdateParameters = Load

    def Reset(self) -> None:
        """Take mass and moments of the element again; the centre of mass is the origin then, as in Gazebo."""
        self._change()
        loaded = self._loaded
        if loaded is None:
            loaded = _of_element(self._sdf.child("inertial")) if self._sdf is not None else (Inertial()._mass, Pose3d())
        self._mass, self._pose = copy.deepcopy(loaded[0]), Pose3d()

    def ProcessMsg(self, msg: msgs.Inertial) -> None:
        """Take the values that a message has; the axes of the frame stay."""
        if msg.HasField("mass"):
            self.SetMass(msg.mass)
        if msg.HasField("pose"):
            self.SetCoG(msg.pose.position.x, msg.pose.position.y, msg.pose.position.z)
        for axes in AXES:
            if msg.HasField(f"i{axes}"):
                setattr(self._change(), f"i{axes}", finite(getattr(msg, f"i{axes}"), f"i{axes} [kg m^2]"))

    def __add__(self, other: Inertial) -> Inertial:
        """Both bodies as one: about the common centre of mass, along the axes of the link frame, as Gazebo does it."""
        if not isinstance(other, Inertial):
            return NotImplemented
        both = Inertial(self.Mass() + other.Mass())
        if both.Mass() != 0.0:  # else Gazebo's has no numbers
            both.SetCoG((self.CoG() * self.Mass() + other.CoG() * other.Mass()) / both.Mass())
        both.SetMOI(self.MOI(both.Pose()) + other.MOI(both.Pose()))
        return both

    def __call__(self, offset: VectorLike | GzPose) -> Inertial:
        """The values for a link frame that is moved by an offset [m]; the angles of a pose do nothing, as in Gazebo.

        The frame keeps its axes. The moments are about a point that lies off the old centre of mass by the offset,
        along the axes of the link frame.
        """
        moved = Inertial(self)
        moved.SetCoG(self.CoG() - Vector3d(*(offset.pos if isinstance(offset, GzPose) else offset)))
        moved.SetMOI(self.MOI(Pose3d(GzPose(GzVector(*moved.CoG())))))
        return moved

    def Rotate(self, turn: Quaterniond) -> None:
        """Turn the frame about the origin of the link frame; the moments along its axes stay."""
        self._change()
        self._pose = Pose3d(GzPose(GzVector(*turn.RotateVector(self.CoG())), turn * Quaterniond(*self._pose.rot)))

    def apply(self) -> None:
        """Set the mass matrix of the body to these values.

        Raises:
            ParameterError: no body can have them; the values before the changes are restored.
        """
        if not self._changed:
            return
        if self._body is not None:
            try:
                self._body.SetMassMatrix(self._matrix())
            except ParameterError:
                (self._mass, self._pose), self._changed = self._before, False
                raise
            self._held = _of_body(self._body).tobytes()
        self._changed = False

    def _values(self) -> MassMatrix3d:
        """Mass and moments, up to date."""
        self._read()
        return self._mass

    def _change(self) -> MassMatrix3d:
        """Mass and moments, which are going to be changed."""
        self._read()
        if not self._changed:
            self._before = copy.deepcopy(self._mass), Pose3d(self._pose)
            self._changed = True
        return self._mass

    def Ign(self) -> Inertial:
        """The object itself: one class has both generations of names."""
        return self

    MassMatrix = Ign

    def Mass(self) -> float:
        """The mass [kg]."""
        return self._values().mass

    GetMass = Mass

    def SetMass(self, m: float) -> None:
        """Set the mass [kg].

        Raises:
            ParameterError: it is the mass of a link, and not positive.
        """
        if self._body is not None and not m > 0.0:
            raise ParameterError(f"mass is {m:g} kg; it must be positive")
        self._change().mass = finite(m, "mass [kg]")

    def CoG(self) -> Vector3d:
        """The centre of mass in the link frame [m]."""
        self._read()
        return Vector3d(*self._pose.pos)

    GetCoG = CoG

    def SetCoG(self, *centre: VectorLike | GzPose | float) -> None:
        """Set the centre of mass [m]: three numbers or a vector; or its frame: a pose or six numbers."""
        values = centre[0] if len(centre) == 1 else centre
        self._change()
        if isinstance(values, GzPose):
            self._pose = Pose3d(values)
        elif len(values) == 6:  # type: ignore[arg-type]
            self._pose = Pose3d(*values)  # type: ignore[misc]
        else:
            self._pose = Pose3d(GzPose(GzVector(*values), self._pose.rot))  # type: ignore[misc]

    def Pose(self) -> Pose3d:
        """The frame in which the moments are given: its origin is the centre of mass [m]."""
        self._read()
        return Pose3d(self._pose)

    GetPose = Pose

    def SetInertiaMatrix(self, ixx: float, iyy: float, izz: float, ixy: float, ixz: float, iyz: float) -> None:
        """Set the moments of inertia [kg m^2]."""
        matrix = self._change()
        matrix.SetDiagonalMoments((ixx, iyy, izz))
        matrix.SetOffDiagonalMoments((ixy, ixz, iyz))

    def MOI(self, pose: GzPose | None = None) -> Matrix3d:
        """The matrix of inertia [kg m^2], along the axes of Pose(); with a pose, about its origin, along its axes."""
        moi = self._values().Moi()
        if pose is None:
            return moi
        away = self._pose - Pose3d(pose)
        turn, d = Matrix3d(away.rot), Vector3d(*away.pos)
        offset = Matrix3d.Identity * d.SquaredLength() - Matrix3d([d * d.x, d * d.y, d * d.z])
        return turn * moi * turn.Transposed() + offset * self._mass.mass

    GetMOI = MOI
    Moi = MOI

    def SetMOI(self, moi: Matrix3d) -> None:
        """Set the matrix of inertia [kg m^2], along the axes of Pose()."""
        self._change().Moi(moi)

    def PrincipalMoments(self) -> Vector3d:
        """The moments on the diagonal [kg m^2]: ixx, iyy, izz, whatever the products are, as in Gazebo."""
        return self._values().DiagonalMoments()

    GetPrincipalMoments = PrincipalMoments

    def ProductsOfInertia(self) -> Vector3d:
        """The moments off the diagonal [kg m^2]: ixy, ixz, iyz."""
        return self._values().OffDiagonalMoments()

    GetProductsofInertia = ProductsOfInertia

    def IXX(self) -> float:
        """The moment ixx [kg m^2]."""
        return self._values().ixx

    def SetIXX(self, value: float) -> None:
        """Set the moment ixx [kg m^2]."""
        self._change().ixx = finite(value, "ixx [kg m^2]")

    def IYY(self) -> float:
        """The moment iyy [kg m^2]."""
        return self._values().iyy

    def SetIYY(self, value: float) -> None:
        """Set the moment iyy [kg m^2]."""
        self._change().iyy = finite(value, "iyy [kg m^2]")

    def IZZ(self) -> float:
        """The moment izz [kg m^2]."""
        return self._values().izz

    def SetIZZ(self, value: float) -> None:
        """Set the moment izz [kg m^2]."""
        self._change().izz = finite(value, "izz [kg m^2]")

    def IXY(self) -> float:
        """The moment ixy [kg m^2]."""
        return self._values().ixy

    def SetIXY(self, value: float) -> None:
        """Set the moment ixy [kg m^2]."""
        self._change().ixy = finite(value, "ixy [kg m^2]")

    def IXZ(self) -> float:
        """The moment ixz [kg m^2]."""
        return self._values().ixz

    def SetIXZ(self, value: float) -> None:
        """Set the moment ixz [kg m^2]."""
        self._change().ixz = finite(value, "ixz [kg m^2]")

    def IYZ(self) -> float:
        """The moment iyz [kg m^2]."""
        return self._values().iyz

    def SetIYZ(self, value: float) -> None:
        """Set the moment iyz [kg m^2]."""
        self._change().iyz = finite(value, "iyz [kg m^2]")

    GetIXX, GetIYY, GetIZZ, GetIXY, GetIXZ, GetIYZ = IXX, IYY, IZZ, IXY, IXZ, IYZ
    Ixx, Iyy, Izz, Ixy, Ixz, Iyz = IXX, IYY, IZZ, IXY, IXZ, IYZ


def _of_element(inertial: Element) -> tuple[MassMatrix3d, Pose3d]:
    """Mass and moments, and their frame, of an `<inertial>` element."""
    inertia = inertial.child("inertia")
    numbers = [inertia.Get(float, f"i{axes}") for axes in AXES]
    return MassMatrix3d(inertial.Get(float, "mass"), numbers[:3], numbers[3:]), Pose3d(inertial.Get(GzPose, "pose"))


def _numbers(mass: OdeMass) -> NDArray[np.float64]:
    """Mass, centre of mass, and the moments about that, shape (13,)."""
    about = about_centre(mass)
    return np.array([mass.mass, *mass.c[:3], *(about.I[4 * i + j] for i in range(3) for j in range(3))])


def _of_body(body: Body) -> NDArray[np.float64]:
    """The same of the mass matrix that a body has."""
    mass = body.GetMass()
    return np.array([mass.mass, *body.com, *(mass.I[4 * i + j] for i in range(3) for j in range(3))])
