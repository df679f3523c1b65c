"""Mass matrices: mass, centre of mass and inertia, computed by ODE's mass functions."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzHomoFromQuatern, GzPose
from libgz.ode.lib import ode
from libgz.ode.types import Mass
from libgz.physics.check import LARGEST, finite_tuple, positive

__all__ = [
    "Mass",
    "MassSum",
    "about_centre",
    "about_origin",
    "box_mass",
    "capsule_mass",
    "cylinder_mass",
    "given_mass",
    "is_possible",
    "moved",
    "positive_definite",
    "scaled",
    "solid_mass",
    "sphere_mass",
]

_ALONG_Z = 3
T = TypeVar("T")


def _address(mass: Mass) -> int:
    return ctypes.addressof(mass)


def sphere_mass(radius: float, density: float = 1.0) -> Mass:
    """A solid sphere; density [kg/m^3]."""
    mass = Mass()
    ode().dMassSetSphere(_address(mass), density, radius)
    return mass


def box_mass(x: float, y: float, z: float, density: float = 1.0) -> Mass:
    """A solid box of full lengths x, y, z [m]."""
    mass = Mass()
    ode().dMassSetBox(_address(mass), density, x, y, z)
    return mass


def cylinder_mass(radius: float, length: float, density: float = 1.0) -> Mass:
    """A solid cylinder along z."""
    mass = Mass()
    ode().dMassSetCylinder(_address(mass), density, _ALONG_Z, radius, length)
    return mass


def capsule_mass(radius: float, length: float, density: float = 1.0) -> Mass:
    """A solid capsule along z; `length` is that of its cylinder [m]."""
    mass = Mass()
    ode().dMassSetCapsule(_address(mass), density, _ALONG_Z, radius, length)
    return mass


def solid_mass(vertices: NDArray[np.float64], triangles: NDArray[Any], density: float = 1.0) -> Mass:
    """A solid whose surface is a closed triangle mesh, seen from the origin of its vertices.

    Sums over the tetrahedra of the triangles with the origin (Blow and Binstock, 2004).
    """
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    volumes = np.einsum("ni,ni->n", a, np.cross(b, c)) / 6.0
    total = a + b + c
    centre = np.einsum("n,ni->i", volumes, total) / 4.0
    square = sum(np.einsum("n,ni,nj->ij", volumes, p, p) for p in (a, b, c, total)) / 20.0
    inertia = density * (np.trace(square) * np.eye(3) - square)
    kilograms = density * float(volumes.sum())
    mass = Mass()
    moments = (inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 1], inertia[0, 2], inertia[1, 2])
    ode().dMassSetParameters(_address(mass), kilograms, *(density * centre / kilograms), *moments)
    return mass


def _copy(mass: Mass) -> Mass:
    return Mass.from_buffer_copy(mass)


def scaled(mass: Mass, kilograms: float) -> Mass:
    """The same shape with another total mass [kg]."""
    result = _copy(mass)
    ode().dMassAdjust(_address(result), positive(kilograms, "mass [kg]"))
    return result


def moved(mass: Mass, pose: GzPose) -> Mass:
    """The mass matrix of a shape whose own frame stands at `pose`, seen from the outer frame."""
    result = _copy(mass)
    rows = GzHomoFromQuatern(pose.rot).m
    ode().dMassRotate(_address(result), (ctypes.c_double * 12)(*(v for row in rows for v in (*row, 0.0))))
    ode().dMassTranslate(_address(result), *pose.pos)
    return result


class MassSum(Generic[T]):
    """The mass matrix of several shapes together, of which only the last one changes, or others follow.

    Args:
        part: the mass matrix of a shape, or None if it is massless.
    """

    def __init__(self, part: Callable[[T], Mass | None]) -> None:
        self._part = part
        self._begin()

    def _begin(self) -> None:
        self._count, self._before, self._any = 0, Mass(), False

    def of(self, shapes: Sequence[T]) -> Mass | None:
        """The sum; None if all are massless."""
        if len(shapes) <= self._count:  # some were removed
            self._begin()
        for shape in shapes[self._count : -1]:
            self._any |= self._add(self._before, shape)
        self._count = max(len(shapes) - 1, 0)
        total = _copy(self._before)
        last = bool(shapes) and self._add(total, shapes[-1])
        return total if self._any or last else None

    def _add(self, total: Mass, shape: T) -> bool:
        """Add a shape to a sum; whether it has a mass."""
        mass = self._part(shape)
        if mass is not None:
            ode().dMassAdd(_address(total), _address(mass))
        return mass is not None


def positive_definite(moments: Iterable[float]) -> bool:
    """Whether moments of inertia ixx, iyy, izz, ixy, ixz, iyz [kg m^2] are positive about every axis."""
    ixx, iyy, izz, ixy, ixz, iyz = moments
    if ixy == ixz == iyz == 0.0:
        return ixx > 0.0 and iyy > 0.0 and izz > 0.0
    matrix = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
    return bool(np.linalg.eigvalsh(matrix).min() > 0.0)


def given_mass(kilograms: float, moments: Iterable[float], pose: GzPose) -> Mass:
    """A mass matrix from its numbers.

    Args:
        kilograms: mass [kg].
        moments: ixx, iyy, izz, ixy, ixz, iyz [kg m^2] about the centre of mass, along the axes of `pose`.
        pose: the centre of mass and those axes, in the body frame.

    Raises:
        ParameterError: the mass is not above zero, or the moments are not positive definite.
    """
    mass = Mass()
    numbers = finite_tuple(moments, 6, "moments of inertia [kg m^2]", LARGEST * LARGEST)
    finite_tuple(pose.pos, 3, "centre of mass [m]", LARGEST)
    if not positive_definite(numbers):
        raise ParameterError(f"moments of inertia {numbers} are not positive definite")
    ode().dMassSetParameters(_address(mass), positive(kilograms, "mass [kg]"), 0.0, 0.0, 0.0, *numbers)
    return moved(mass, pose)


def is_possible(mass: Mass) -> bool:
    """Whether ODE can use a mass matrix about its own centre of mass: finite, positive definite to its last bits."""
    return math.isfinite(sum(mass.I)) and bool(ode().dMassCheck(_address(mass)))


def about_centre(mass: Mass) -> Mass:
    """The same body seen from its own centre of mass, as ODE requires."""
    result = _copy(mass)
    ode().dMassTranslate(_address(result), *(-c for c in mass.c[:3]))
    result.c[:] = (0.0, 0.0, 0.0, 0.0)
    return result


def about_origin(mass: Mass) -> Mass:
    """The error of the legacy server: the inertia stays that about the body's origin, whatever the centre of mass."""
    result = _copy(mass)
    result.c[:] = (0.0, 0.0, 0.0, 0.0)
    return result
