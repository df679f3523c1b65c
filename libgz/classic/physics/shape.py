"""Shapes: the geometry of a collision or visual; sizes can be changed at run time."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import GzVector, VectorLike
from libgz.classic.math import Vector2i, Vector3d
from libgz.classic.physics.base import Base
from libgz.physics.check import LARGEST, finite_tuple
from libgz.physics.geom import Geom
from libgz.physics.geoms import (
    BoxGeom,
    CapsuleGeom,
    CylinderGeom,
    HeightfieldGeom,
    PlaneGeom,
    SphereGeom,
    TriMeshGeom,
)
from libgz.sdf.value import parse

if TYPE_CHECKING:
    from libgz.classic.common import Image
    from libgz.sdf.element import Element

__all__ = [
    "BoxShape",
    "CylinderShape",
    "HeightmapShape",
    "MeshShape",
    "PlaneShape",
    "PolylineShape",
    "Shape",
    "SphereShape",
    "shape_of",
]


class Shape:
    """Base of all shapes."""

    kind: ClassVar[str] = "empty"  # SDF's name
    entity_type: ClassVar[int] = Base.SHAPE

    def __init__(self, geom: Geom, sdf: Element | None = None) -> None:
        self.geom, self._sdf = geom, sdf

    def GetType(self) -> int:
        """The bit mask of its types: Base.SHAPE, Base.BOX_SHAPE and so on."""
        return self.entity_type

    def HasType(self, kind: int) -> bool:
        """Whether it is of this type, such as Base.BOX_SHAPE."""
        return self.entity_type & kind == kind

    def GetParent(self) -> Base | Any:
        """Its collision; None for the shape of a visual."""
        return self.geom.facade if self.geom.space is not None else None

    def Scale(self) -> Vector3d:
        """The multiple of its first size that SetScale has set."""
        return Vector3d(*self.geom.scale)

    GetScale = Scale

    def SetScale(self, scale: VectorLike) -> None:
        """Scale it to this multiple of its first size; without effect on planes and meshes.

        Raises:
            ParameterError: a factor is not above zero, or too large.
        """
        new = finite_tuple(scale, 3, "scale", LARGEST)
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
    entity_type = Base.SHAPE | Base.BOX_SHAPE
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
    entity_type = Base.SHAPE | Base.SPHERE_SHAPE
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
    entity_type = Base.SHAPE | Base.CYLINDER_SHAPE
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
    entity_type = Base.SHAPE | Base.PLANE_SHAPE
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
    entity_type = Base.SHAPE | Base.MESH_SHAPE
    geom: TriMeshGeom

    def Size(self) -> Vector3d:
        """The lengths of its vertices' box [m]."""
        return Vector3d(*np.ptp(self.geom.vertices, axis=0))

    GetSize = Size

    def GetMeshURI(self) -> str:
        """The `<uri>` of its file; an empty string if it was not made from one."""
        return self._text("uri")

    def _text(self, key: str) -> str:
        geometry = self._sdf.child("geometry") if self._sdf is not None else None
        shape = geometry.GetElement(self.kind) if geometry is not None and geometry.HasElement(self.kind) else None
        return shape.Get(str, key) if shape is not None else ""


class PolylineShape(MeshShape):
    """A solid extruded from an outline."""

    kind = "polyline"
    entity_type = Base.SHAPE | Base.POLYLINE_SHAPE


class HeightmapShape(MeshShape):
    """Ground from an image; vertices are counted along +x, and along -y from the image's top row on."""

    kind = "heightmap"
    entity_type = Base.SHAPE | Base.HEIGHTMAP_SHAPE
    geom: HeightfieldGeom | TriMeshGeom  # type: ignore[assignment]  # the latter where it is turned, or moves

    def GetURI(self) -> str:
        """The `<uri>` of its image."""
        return self._text("uri")

    GetMeshURI = GetURI

    def Size(self) -> Vector3d:
        """The `<size>` [m]."""
        return Vector3d(*self._vector("size"))

    def Pos(self) -> Vector3d:
        """The `<pos>` [m]."""
        return Vector3d(*self._vector("pos"))

    def VertexCount(self) -> Vector2i:
        """The number of vertices along x and y."""
        rows, columns = self.heights().shape
        return Vector2i(columns, rows)

    def GetHeight(self, x: int, y: int) -> float:
        """The height of a vertex [m], relative to the collision; 0 outside, as in Gazebo."""
        heights = self.heights()
        index = y * heights.shape[1] + x  # behind a row is the next one
        return float(heights.flat[index]) if x >= 0 and y >= 0 and index < heights.size else 0.0

    def GetMaxHeight(self) -> float:
        """The greatest height [m], relative to the collision."""
        return float(self.heights().max())

    def GetMinHeight(self) -> float:
        """The least height [m], relative to the collision."""
        return float(self.heights().min())

    def GetSubSampling(self) -> int:
        """How many vertices there are for each pixel, along x and y; see `<sampling>`."""
        vertices, pixels = int(self.heights().shape[1]), int(self.GetImage().GetWidth())
        return max(1, (vertices - 1) // max(1, pixels - 1))

    def GetImage(self) -> Image:
        """The image.

        Raises:
            FileError: it is not there any more, or cannot be read.
        """
        from libgz.classic.common.image import Image

        return Image(self.GetURI())

    GetSize, GetPos, GetVertexCount = Size, Pos, VertexCount

    def _vector(self, key: str) -> GzVector:
        return parse(GzVector, self._text(key) or "0 0 0")

    def heights(self) -> NDArray[np.float64]:
        """The heights of all vertices [m], relative to the collision; shape (rows, columns), the row at +y first."""
        if isinstance(self.geom, HeightfieldGeom):
            return self.geom.heights[::-1] + self._vector("pos").z
        points = self.geom.vertices
        columns = int(np.argmax(points[:, 1] != points[0, 1])) or len(points)
        heights: NDArray[np.float64] = points[:, 2].reshape(-1, columns)[::-1]
        return heights


KINDS: tuple[tuple[type[Geom], type[Shape]], ...] = (
    (BoxGeom, BoxShape),
    (SphereGeom, SphereShape),
    (CylinderGeom, CylinderShape),
    (PlaneGeom, PlaneShape),
    (TriMeshGeom, MeshShape),
)


def shape_of(geom: Geom, sdf: Element | None = None) -> Shape:
    """The shape of a geom, by its class, and by the element of its collision."""
    geometry = sdf.child("geometry") if sdf is not None else None
    by_file = next(
        (s for s in (HeightmapShape, PolylineShape) if geometry is not None and geometry.HasElement(s.kind)), None
    )
    found = by_file or next((shape for kind, shape in KINDS if isinstance(geom, kind)), Shape)
    return found(geom, sdf)
