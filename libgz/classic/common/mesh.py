"""Mesh, SubMesh and MeshManager: triangle meshes of files, and made ones."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, ParameterError
from libgz.base.geometry import VectorLike
from libgz.classic.common.console import gzerr
from libgz.classic.common.system_paths import SystemPaths
from libgz.classic.math.vector3 import Vector3d
from libgz.classic.names import takes_names
from libgz.physics.mesh_files import read_mesh
from libgz.physics.meshes import vertex_normals

__all__ = ["Mesh", "MeshManager", "SubMesh"]

Points = NDArray[np.float64]
SUFFIXES = ("dae", "stl", "stla", "stlb", "obj", "gltf", "glb")


@takes_names
class SubMesh:
    """A part of a mesh: vertices and triangles, by indices of vertices."""

    POINTS, LINES, LINESTRIPS, TRIANGLES, TRIFANS, TRISTRIPS = range(6)

    def __init__(self, name: str = "") -> None:
        self._name = name
        self.vertices: Points = np.zeros((0, 3))
        self.normals: Points = np.zeros((0, 3))
        self.indices: list[int] = []

    def GetName(self) -> str:
        """Its name."""
        return self._name

    def SetName(self, name: str) -> None:
        """Set its name."""
        self._name = name

    def GetPrimitiveType(self) -> int:
        """TRIANGLES."""
        return self.TRIANGLES

    def AddVertex(self, *place: Any) -> None:
        """Add a vertex [m], a vector or three numbers."""
        self.vertices = np.vstack([self.vertices, [*Vector3d(*place)]])

    def AddNormal(self, *normal: Any) -> None:
        """Add the normal of a vertex, a vector or three numbers."""
        self.normals = np.vstack([self.normals, [*Vector3d(*normal)]])

    def AddIndex(self, index: int) -> None:
        """Add a corner; three make a triangle."""
        self.indices.append(int(index))

    def _row(self, table: Points, index: int, what: str) -> int:
        if not 0 <= index < len(table):
            raise ParameterError(f"submesh {self._name!r} has no {what} {index}; it has {len(table)}")
        return index

    def Vertex(self, index: int) -> Vector3d:
        """A vertex [m].

        Raises:
            ParameterError: there is none of this index.
        """
        return Vector3d(*self.vertices[self._row(self.vertices, index, "vertex")])

    def SetVertex(self, index: int, place: VectorLike) -> None:
        """Move a vertex [m].

        Raises:
            ParameterError: there is none of this index.
        """
        self.vertices[self._row(self.vertices, index, "vertex")] = [*place]

    def Normal(self, index: int) -> Vector3d:
        """The normal of a vertex.

        Raises:
            ParameterError: there is none of this index.
        """
        return Vector3d(*self.normals[self._row(self.normals, index, "normal")])

    def SetNormal(self, index: int, normal: VectorLike) -> None:
        """Set the normal of a vertex.

        Raises:
            ParameterError: there is none of this index.
        """
        self.normals[self._row(self.normals, index, "normal")] = [*normal]

    def GetIndex(self, i: int) -> int:
        """The vertex of a corner; -1 if there is no such corner."""
        return self.indices[i] if 0 <= i < len(self.indices) else -1

    def GetVertexCount(self) -> int:
        """The number of vertices."""
        return len(self.vertices)

    def GetNormalCount(self) -> int:
        """The number of normals."""
        return len(self.normals)

    def GetIndexCount(self) -> int:
        """The number of corners."""
        return len(self.indices)

    def GetMaxIndex(self) -> int:
        """The largest vertex of a corner; 0 without corners."""
        return max(self.indices, default=0)

    def HasVertex(self, place: VectorLike) -> bool:
        """Whether there is a vertex at a place [m], up to 1e-6."""
        return bool((np.abs(self.vertices - np.array([*place])) < 1e-6).all(axis=1).any())

    def GetVertexIndex(self, place: VectorLike) -> int:
        """The first vertex at a place [m], up to 1e-6; 0 if there is none, as in Gazebo."""
        near = (np.abs(self.vertices - np.array([*place])) < 1e-6).all(axis=1)
        return int(near.argmax()) if len(near) else 0

    def Min(self) -> Vector3d:
        """The lower corner of the vertices' box [m]."""
        return Vector3d(*self.vertices.min(axis=0)) if len(self.vertices) else Vector3d()

    def Max(self) -> Vector3d:
        """The upper corner of the vertices' box [m]."""
        return Vector3d(*self.vertices.max(axis=0)) if len(self.vertices) else Vector3d()

    def Scale(self, factor: float) -> None:
        """Scale it by a factor."""
        self.vertices = self.vertices * float(factor)

    def SetScale(self, factors: VectorLike) -> None:
        """Scale it along its axes."""
        self.vertices = self.vertices * np.array([*factors])

    def Translate(self, by: VectorLike) -> None:
        """Move it [m]."""
        self.vertices = self.vertices + np.array([*by])

    def Center(self, center: VectorLike = (0.0, 0.0, 0.0)) -> None:
        """Move the middle of its box to a point [m]."""
        middle = (self.Min() + self.Max()) * 0.5
        self.Translate(Vector3d(*center) - middle)

    def triangles(self) -> NDArray[np.int64]:
        """Its triangles as indices of vertices, shape (m, 3)."""
        whole = len(self.indices) // 3 * 3
        return np.array(self.indices[:whole], dtype=np.int64).reshape(-1, 3)

    def RecalculateNormals(self) -> None:
        """Compute the normals of all vertices from the triangles."""
        self.normals = vertex_normals(self.vertices, self.triangles())

    def FillArrays(self) -> tuple[NDArray[np.float64], list[int]]:
        """(the vertices' coordinates in one row [m], the corners)."""
        return self.vertices.ravel().copy(), list(self.indices)

    def Volume(self) -> float:
        """The volume of a closed mesh [m^3]."""
        a, b, c = (self.vertices[self.triangles()[:, i]] for i in range(3))
        return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6.0

    GetVertex, GetNormal, GetMin, GetMax = Vertex, Normal, Min, Max


@takes_names
class Mesh:
    """A named mesh of submeshes."""

    def __init__(self, name: str = "unknown") -> None:
        self._name, self._path = name, ""
        self._parts: list[SubMesh] = []

    def GetName(self) -> str:
        """Its name."""
        return self._name

    def SetName(self, name: str) -> None:
        """Set its name."""
        self._name = name

    def GetPath(self) -> str:
        """The path of its file; an empty string for none."""
        return self._path

    def SetPath(self, path: str) -> None:
        """Set the path of its file."""
        self._path = path

    def AddSubMesh(self, part: SubMesh) -> None:
        """Add a submesh."""
        self._parts.append(part)

    def GetSubMeshCount(self) -> int:
        """The number of submeshes."""
        return len(self._parts)

    def GetSubMesh(self, which: int | str) -> SubMesh | Any:
        """A submesh by index or name; None if there is none."""
        if isinstance(which, int):
            return self._parts[which] if 0 <= which < len(self._parts) else None
        return next((part for part in self._parts if part.GetName() == which), None)

    def GetVertexCount(self) -> int:
        """The number of vertices of all submeshes."""
        return sum(part.GetVertexCount() for part in self._parts)

    def GetNormalCount(self) -> int:
        """The number of normals of all submeshes."""
        return sum(part.GetNormalCount() for part in self._parts)

    def GetIndexCount(self) -> int:
        """The number of corners of all submeshes."""
        return sum(part.GetIndexCount() for part in self._parts)

    def Min(self) -> Vector3d:
        """The lower corner of the vertices' box [m]."""
        return Vector3d(*np.min([[*part.Min()] for part in self._parts], axis=0)) if self._parts else Vector3d()

    def Max(self) -> Vector3d:
        """The upper corner of the vertices' box [m]."""
        return Vector3d(*np.max([[*part.Max()] for part in self._parts], axis=0)) if self._parts else Vector3d()

    def GetAABB(self) -> tuple[Vector3d, Vector3d, Vector3d]:
        """(centre, lower corner, upper corner) of the vertices' box [m]."""
        return (self.Min() + self.Max()) * 0.5, self.Min(), self.Max()

    def Volume(self) -> float:
        """The volume of closed submeshes [m^3]."""
        return sum(part.Volume() for part in self._parts)

    def Scale(self, factor: float) -> None:
        """Scale it by a factor."""
        for part in self._parts:
            part.Scale(factor)

    def SetScale(self, factors: VectorLike) -> None:
        """Scale it along its axes."""
        for part in self._parts:
            part.SetScale(factors)

    def Translate(self, by: VectorLike) -> None:
        """Move it [m]."""
        for part in self._parts:
            part.Translate(by)

    def Center(self, center: VectorLike = (0.0, 0.0, 0.0)) -> None:
        """Move the middle of its box to a point [m]."""
        self.Translate(Vector3d(*center) - self.GetAABB()[0])

    def RecalculateNormals(self) -> None:
        """Compute the normals of all vertices from the triangles."""
        for part in self._parts:
            part.RecalculateNormals()

    def FillArrays(self) -> tuple[NDArray[np.float64], list[int]]:
        """(all vertices' coordinates in one row [m], all corners)."""
        starts = np.cumsum([0, *(part.GetVertexCount() for part in self._parts)])
        corners = [int(i + start) for part, start in zip(self._parts, starts, strict=False) for i in part.indices]
        rows = [part.vertices.ravel() for part in self._parts] or [np.zeros(0)]
        return np.concatenate(rows), corners

    GetMin, GetMax = Min, Max

    def __repr__(self) -> str:
        return f"<Mesh {self._name!r} of {self.GetSubMeshCount()} submeshes, {self.GetIndexCount() // 3} triangles>"


@takes_names
class MeshManager:
    """All meshes by name: those of files, by the names that were loaded, made ones, and Gazebo's basic shapes."""

    _instance: MeshManager | None = None

    def __init__(self) -> None:
        self._meshes: dict[str, Mesh] = {}
        self.CreatePlane("unit_plane", (0.0, 0.0, 1.0), 0.0, (1.0, 1.0), (1, 1), (1, 1))
        self.CreateSphere("unit_sphere", 0.5, 32, 32)
        self.CreateSphere("joint_anchor", 0.01, 32, 32)
        self.CreateBox("body_cg", (0.014, 0.014, 0.014))
        self.CreateBox("unit_box", (1.0, 1.0, 1.0))
        self.CreateBox("axis_box", (1.0, 1.0, 1.0))
        self.CreateCylinder("unit_cylinder", 0.5, 1.0, 1, 32)
        self.CreateCone("unit_cone", 0.5, 1.0, 5, 32)
        self.CreateCylinder("axis_shaft", 0.01, 0.2, 1, 16)
        self.CreateCone("axis_head", 0.02, 0.08, 1, 16)

    @classmethod
    def Instance(cls) -> MeshManager:
        """The only one."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    def IsValidFilename(self, filename: str) -> bool:
        """Whether a file has a suffix that Load reads."""
        return Path(filename).suffix.lower().removeprefix(".") in SUFFIXES

    def Load(self, filename: str) -> Mesh | Any:
        """The mesh of a file, by path or URI; None if it cannot be read, which is logged."""
        if filename in self._meshes:
            return self._meshes[filename]
        path = SystemPaths.Instance().FindFile(filename)
        if not path:
            gzerr(f"Unable to find file[{filename}]")
            return None
        try:
            parts = read_mesh(Path(path))
        except GazeboError as error:
            gzerr(error)
            return None
        mesh = Mesh(filename)
        mesh.SetPath(str(Path(path).parent))
        for part in parts:
            mesh.AddSubMesh(_part(part.name, part.vertices, part.triangles))
        self._meshes[filename] = mesh
        return mesh

    def AddMesh(self, mesh: Mesh) -> None:
        """Add a mesh under its name; one of that name stays."""
        self._meshes.setdefault(mesh.GetName(), mesh)

    def HasMesh(self, name: str) -> bool:
        """Whether there is a mesh of this name."""
        return name in self._meshes

    def GetMesh(self, name: str) -> Mesh | Any:
        """A mesh by name; None if there is none."""
        return self._meshes.get(name)

    def GetMeshAABB(self, mesh: Mesh) -> tuple[Vector3d, Vector3d, Vector3d]:
        """(centre, lower corner, upper corner) of a mesh's box [m]."""
        return mesh.GetAABB()

    def _add(self, name: str, vertices: Any, triangles: Any) -> None:
        if not self.HasMesh(name):
            mesh = Mesh(name)
            mesh.AddSubMesh(_part(name, np.array(vertices, dtype=np.float64), np.array(triangles, dtype=np.int64)))
            self._meshes[name] = mesh

    def CreateBox(self, name: str, sides: VectorLike, uvCoords: VectorLike = (1.0, 1.0, 0.0)) -> None:
        """Make a box of full lengths [m]; a mesh of that name stays."""
        corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
        faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
        self._add(name, corners * np.array([*sides]), [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])

    def CreateSphere(self, name: str, radius: float, rings: int, segments: int) -> None:
        """Make a sphere of a radius [m]; a mesh of that name stays."""
        rings, segments = max(2, int(rings)), max(3, int(segments))
        points = [(0.0, 0.0, radius)]
        for ring in range(1, rings):
            polar = math.pi * ring / rings
            level, around = radius * math.cos(polar), radius * math.sin(polar)
            points += [(around * math.cos(a), around * math.sin(a), level) for a in _turn(segments)]
        points.append((0.0, 0.0, -radius))
        last = len(points) - 1
        triangles = []
        for i in range(segments):
            j = (i + 1) % segments
            triangles += [(0, 1 + i, 1 + j), (last, last - segments + j, last - segments + i)]
            for ring in range(rings - 2):
                a, b = 1 + ring * segments + i, 1 + ring * segments + j
                triangles += [(a, a + segments, b + segments), (a, b + segments, b)]
        self._add(name, points, triangles)

    def CreateCylinder(self, name: str, radius: float, height: float, rings: int, segments: int) -> None:
        """Make a cylinder along z [m]; a mesh of that name stays."""
        self._frustum(name, radius, radius, height, segments)

    def CreateCone(self, name: str, radius: float, height: float, rings: int, segments: int) -> None:
        """Make a cone along z, its tip above [m]; a mesh of that name stays."""
        self._frustum(name, radius, 0.0, height, segments)

    def _frustum(self, name: str, low: float, high: float, height: float, segments: int) -> None:
        count = max(3, int(segments))
        rings = [
            [(r * math.cos(a), r * math.sin(a), z) for a in _turn(count)]
            for r, z in ((low, -0.5 * height), (high, 0.5 * height))
        ]
        bottom, top = 2 * count, 2 * count + 1
        triangles = []
        for i in range(count):
            j = (i + 1) % count
            triangles += [(i, j, count + j), (i, count + j, count + i), (bottom, j, i), (top, count + i, count + j)]
        self._add(name, [*rings[0], *rings[1], (0.0, 0.0, -0.5 * height), (0.0, 0.0, 0.5 * height)], triangles)

    def CreatePlane(
        self, name: str, normal: VectorLike, d: float, size: VectorLike, segments: VectorLike, uvTile: VectorLike
    ) -> None:
        """Make a rectangle at right angles to a normal, at a distance from the origin [m]."""
        up = Vector3d(*normal).Normalize()
        ahead = Vector3d(1.0, 0.0, 0.0) if abs(up.x) < 0.9 else Vector3d(0.0, 0.0, -1.0)
        left = up.Cross(ahead).Normalize()
        ahead = left.Cross(up)
        width, length, *_ = size
        corners = [
            up * float(d) + ahead * (x * width) + left * (y * length)
            for x, y in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
        ]
        self._add(name, [[*corner] for corner in corners], [(0, 1, 2), (0, 2, 3)])


def _turn(segments: int) -> list[float]:
    return [2.0 * math.pi * i / segments for i in range(segments)]


def _part(name: str, vertices: Points, triangles: NDArray[np.integer]) -> SubMesh:
    part = SubMesh(name)
    part.vertices, part.indices = np.array(vertices, dtype=np.float64), triangles.ravel().tolist()
    part.RecalculateNormals()
    return part
