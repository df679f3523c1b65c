"""Shapes: the form of a collision or visual, which can be changed at run time."""

from __future__ import annotations

from typing import ClassVar

from libgz.classic.math import Vector3d
from libgz.geometry import VectorLike
from libgz.physics.geom import Geom
from libgz.physics.geoms import BoxGeom, CylinderGeom, PlaneGeom, SphereGeom, TriMeshGeom

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
        """Shapes without a size have nothing to scale."""


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

    def SetScale(self, scale: VectorLike) -> None:
        """Multiply the lengths."""
        self.SetSize([length * factor for length, factor in zip(self.geom.size, scale, strict=True)])


class SphereShape(Shape):
    """A sphere."""

    kind = "sphere"
    geom: SphereGeom

    def GetRadius(self) -> float:
        """[m]."""
        return self.geom.radius

    def SetRadius(self, radius: float) -> None:
        """Set the radius [m]."""
        self.geom.resize(radius)

    def SetScale(self, scale: VectorLike) -> None:
        """Multiply the radius by the largest factor."""
        self.SetRadius(self.geom.radius * max(scale))


class CylinderShape(Shape):
    """A cylinder along z."""

    kind = "cylinder"
    geom: CylinderGeom

    def GetRadius(self) -> float:
        """[m]."""
        return self.geom.radius

    def GetLength(self) -> float:
        """[m]."""
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

    def SetScale(self, scale: VectorLike) -> None:
        """Multiply the radius by the larger of x and y, the length by z."""
        x, y, z = scale
        self.SetSize(self.geom.radius * max(x, y), self.geom.length * z)


class PlaneShape(Shape):
    """An infinite plane."""

    kind = "plane"
    geom: PlaneGeom

    def Normal(self) -> Vector3d:
        """The direction it faces, global."""
        return Vector3d(*self.geom.normal)

    GetNormal = Normal


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
    """The shape of a geom."""
    return next((shape(geom) for kind, shape in KINDS if isinstance(geom, kind)), Shape(geom))
