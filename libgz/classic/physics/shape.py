"""Shapes: the geometry of a collision or visual; sizes can be changed at run time."""

from __future__ import annotations

import math
from typing import ClassVar

from libgz.classic.math import Vector3d
from libgz.geometry import VectorLike
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CapsuleGeom, CylinderGeom, PlaneGeom, SphereGeom, TriMeshGeom

__all__ = ["BoxShape", "CylinderShape", "MeshShape", "PlaneShape", "Shape", "SphereShape", "shape_of"]


class Shape:
    """Base of all shapes."""

    kind: ClassVar[str] = "empty"

    def __init__(self, geom: Geom) -> None:
        self.geom = geom

    def GetType(self) -> str:
        """box, sphere, cylinder, plane, mesh or empty."""
        return self.kind

    def SetScale(self, scale: VectorLike) -> None:
        """Scale it to this multiple of its first size; without effect on planes and meshes.

        Raises:
            ParameterError: a factor is not above zero.
        """
        new = tuple(map(float, scale))
        self._rescale(new, self.geom.scale)
        self.geom.scale = new

    def ComputeVolume(self) -> float:
        """The volume [m^3]: of box, sphere, cylinder, capsule; 0 for planes; else of the bounding box."""
        if isinstance(self.geom, CapsuleGeom):
            return math.pi * self.geom.radius**2 * (self.geom.length + 4.0 / 3.0 * self.geom.radius)
        low, high = self.geom.bounds()
        volume = math.prod(b - a for a, b in zip(low, high, strict=True))
        return volume if 0.0 < volume < math.inf else 0.0

    def _rescale(self, new: tuple[float, ...], old: tuple[float, ...]) -> None:
        """Change the size from one set of factors to another."""


class BoxShape(Shape):
    """A box."""

    kind = "box"
    geom: BoxGeom

    def Size(self) -> Vector3d:
        """Full lengths [m]."""
        return Vector3d(*self.geom.size)

    GetSize = Size

    def SetSize(self, size: VectorLike) -> None:
        """Set the full lengths [m]."""
        self.geom.resize(*size)

    def ComputeVolume(self) -> float:
        """The volume [m^3]."""
        return math.prod(self.geom.size)

    def _rescale(self, new: tuple[float, ...], old: tuple[float, ...]) -> None:
        self.SetSize([length * a / b for length, a, b in zip(self.geom.size, new, old, strict=True)])


class SphereShape(Shape):
    """A sphere."""

    kind = "sphere"
    geom: SphereGeom

    def GetRadius(self) -> float:
        """The radius [m]."""
        return self.geom.radius

    def SetRadius(self, radius: float) -> None:
        """Set the radius [m]."""
        self.geom.resize(radius)

    def ComputeVolume(self) -> float:
        """The volume [m^3]."""
        return 4.0 / 3.0 * math.pi * self.geom.radius**3

    def _rescale(self, new: tuple[float, ...], old: tuple[float, ...]) -> None:
        self.SetRadius(self.geom.radius * max(new) / max(old))  # the largest factor applies


class CylinderShape(Shape):
    """A cylinder along z."""

    kind = "cylinder"
    geom: CylinderGeom

    def GetRadius(self) -> float:
        """The radius [m]."""
        return self.geom.radius

    def GetLength(self) -> float:
        """The length [m]."""
        return self.geom.length

    def SetRadius(self, radius: float) -> None:
        """Set the radius [m]."""
        self.geom.resize(radius, self.geom.length)

    def SetLength(self, length: float) -> None:
        """Set the length [m]."""
        self.geom.resize(self.geom.radius, length)

    def SetSize(self, radius: float, length: float) -> None:
        """Set radius and length [m]."""
        self.geom.resize(radius, length)

    def ComputeVolume(self) -> float:
        """The volume [m^3]."""
        return math.pi * self.geom.radius**2 * self.geom.length

    def _rescale(self, new: tuple[float, ...], old: tuple[float, ...]) -> None:
        self.SetSize(self.geom.radius * max(new[:2]) / max(old[:2]), self.geom.length * new[2] / old[2])


class PlaneShape(Shape):
    """An infinite plane."""

    kind = "plane"
    geom: PlaneGeom

    def Normal(self) -> Vector3d:
        """The normal, in the world frame."""
        return Vector3d(*self.geom.normal)

    GetNormal = Normal

    def ComputeVolume(self) -> float:
        """0 [m^3]."""
        return 0.0


class MeshShape(Shape):
    """A triangle mesh."""

    kind = "mesh"
    geom: TriMeshGeom


KINDS: tuple[tuple[type[Geom], type[Shape]], ...] = (
    (BoxGeom, BoxShape),
    (SphereGeom, SphereShape),
    (CylinderGeom, CylinderShape),
    (PlaneGeom, PlaneShape),
    (TriMeshGeom, MeshShape),
)


def shape_of(geom: Geom) -> Shape:
    """The shape of a geom, by its class."""
    return next((shape(geom) for kind, shape in KINDS if isinstance(geom, kind)), Shape(geom))
