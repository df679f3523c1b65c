"""The kinds of geom. All constructors begin with the body and the model's space."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from libgz.base.errors import ParameterError
from libgz.base.geometry import GzPose, GzQuaternFromAxis, GzVector, VectorLike, rotate
from libgz.ode.context import NO_HIT
from libgz.ode.lib import ode
from libgz.ode.mesh_data import new_mesh_data
from libgz.physics import mass as mass_
from libgz.physics.appearance import RENDER_LIGHT
from libgz.physics.body import Body
from libgz.physics.check import LARGEST, WIDE, finite, finite_tuple, not_negative, positive, table, unit_axis
from libgz.physics.geom import Geom
from libgz.physics.lock import built, exclusive
from libgz.physics.meshes import Mesh, grid_triangles, grid_vertices, vertex_normals
from libgz.physics.outlines import extrude
from libgz.physics.space import Space

if TYPE_CHECKING:
    from libgz.physics.skeletons import SkinPart

__all__ = [
    "BoxGeom",
    "CapsuleGeom",
    "CylinderGeom",
    "DomeGeom",
    "FrustrumGeom",
    "GridGeom",
    "HeightfieldGeom",
    "LightGeom",
    "PlaneGeom",
    "PrismGeom",
    "RayGeom",
    "SkinGeom",
    "SphereGeom",
    "TriMeshGeom",
    "WheelGeom",
]


THINNEST = 1e-6  # [m]
SQUARE = 1.0 - 1e-12  # cosine from which an axis counts as one of the world's


def _thin(length: float, what: str) -> float:
    """A length of a box or cylinder. Old worlds have plates of thickness 0, without volume or mass."""
    return THINNEST if length == 0.0 else positive(length, what)


def _space_id(body: Body, space: Space | None) -> int | None:
    """The handle of the space in which ODE makes a geom.

    Raises:
        ClosedError: the body or the space was closed.
        ParameterError: they are no body and space of one world: ODE would end the process, or leave a geom that is
            nobody's.
    """
    if not isinstance(body, Body):
        raise ParameterError(f"a geom belongs to a body; {body!r} is none")
    if space is not None and not (isinstance(space, Space) and space.engine is body.engine):
        raise ParameterError(f"a geom is made in a space of the world of its body, or in None; {space!r} is neither")
    body.GetBodyId()
    return None if space is None else space.id


class BoxGeom(Geom):
    """A box.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        xDim, yDim, zDim: its full lengths [m]; 0 makes a thin plate.

    Raises:
        ParameterError: a length is negative or not finite.
    """

    SAVED = ("size",)

    @built
    def __init__(self, body: Body, space: Space | None, xDim: float, yDim: float, zDim: float) -> None:
        self.size = tuple(_thin(length, "box length [m]") for length in (xDim, yDim, zDim))
        handle = ode().dCreateBox(_space_id(body, space), *self.size)
        super().__init__(body, space, handle, mass_.box_mass(*self.size))

    @exclusive
    def resize(self, xDim: float, yDim: float, zDim: float) -> None:
        """Change the lengths [m]; the mass stays."""
        self.size = tuple(positive(length, "box length [m]") for length in (xDim, yDim, zDim))
        if self.id:
            ode().dGeomBoxSetLengths(self.id, *self.size)
        self._reshaped()


class SphereGeom(Geom):
    """A sphere.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        radius: [m].

    Raises:
        ParameterError: the radius is not positive.
    """

    SAVED = ("radius",)

    @built
    def __init__(self, body: Body, space: Space | None, radius: float) -> None:
        self.radius = positive(radius, "sphere radius [m]")
        super().__init__(
            body, space, ode().dCreateSphere(_space_id(body, space), self.radius), mass_.sphere_mass(self.radius)
        )

    @exclusive
    def resize(self, radius: float) -> None:
        """Change the radius [m]; the mass stays."""
        self.radius = positive(radius, "sphere radius [m]")
        if self.id:
            ode().dGeomSphereSetRadius(self.id, self.radius)
        self._reshaped()


class CylinderGeom(Geom):
    """A cylinder along z, centred.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        radius: [m].
        length: [m]; 0 makes a thin disc.

    Raises:
        ParameterError: a length is not positive.
    """

    SAVED = ("radius", "length")

    @built
    def __init__(self, body: Body, space: Space | None, radius: float, length: float) -> None:
        self.radius = positive(radius, "cylinder radius [m]")
        self.length = _thin(length, "cylinder length [m]")
        handle = ode().dCreateCylinder(_space_id(body, space), self.radius, self.length)
        super().__init__(body, space, handle, mass_.cylinder_mass(self.radius, self.length))
        body.UpdateCoM()

    @exclusive
    def resize(self, radius: float, length: float) -> None:
        """Change radius and length [m]; the mass stays."""
        self.radius = positive(radius, "cylinder radius [m]")
        self.length = positive(length, "cylinder length [m]")
        if self.id:
            ode().dGeomCylinderSetParams(self.id, self.radius, self.length)
        self._reshaped()


class CapsuleGeom(Geom):
    """A cylinder along z with round caps, centred.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        radius: of cylinder and caps [m].
        length: of the cylinder, without the caps [m].

    Raises:
        ParameterError: a length is not positive.
    """

    @built
    def __init__(self, body: Body, space: Space | None, radius: float, length: float) -> None:
        self.radius = positive(radius, "capsule radius [m]")
        self.length = positive(length, "capsule length [m]")
        handle = ode().dCreateCapsule(_space_id(body, space), self.radius, self.length)
        super().__init__(body, space, handle, mass_.capsule_mass(self.radius, self.length))


class WheelGeom(SphereGeom):
    """A wheel about z: shape and mass are those of a sphere of the total radius, appearance that of a tire.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        totalRadius: of the wheel [m].
        tireRadius: of the tire's cross-section [m].

    Raises:
        ParameterError: a radius is not positive.
    """

    def __init__(self, body: Body, space: Space | None, totalRadius: float, tireRadius: float) -> None:
        self.tire_radius = positive(tireRadius, "tire radius [m]")
        super().__init__(body, space, totalRadius)


class PlaneGeom(Geom):
    """An infinite plane, normal . p = altitude, in global terms: it does not follow its body.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        altitude: its distance from the origin along the normal [m].
        normal: its direction, upwards; of any length.

    Raises:
        ParameterError: the altitude is not finite, or the normal is zero.
    """

    @built
    def __init__(self, body: Body, space: Space | None, altitude: float, normal: VectorLike) -> None:
        self.altitude = finite(altitude, "altitude [m]")
        self.normal = GzVector(*unit_axis(normal, "normal"))
        handle = ode().dCreatePlane(_space_id(body, space), *self.normal, self.altitude)
        super().__init__(body, space, handle, placeable=False)


class TriMeshGeom(Geom):
    """A triangle mesh without mass.

    Args:
        vertices: [m], shape (n, 3).
        triangles: indices of corners, counter-clockwise seen from outside, shape (m, 3).

    Raises:
        ParameterError: an index is out of range, or a coordinate is not finite.
    """

    # For rendering, one row a vertex; None if a mesh has none.
    normals: NDArray[np.float64] | None = None
    texture_coordinates: NDArray[np.float64] | None = None
    colors: NDArray[np.float64] | None = None
    image: Callable[[], NDArray[np.uint8]] | None = None  # a texture that is computed, shape (n, m, 3), top row first
    SAVED = ("changed_mesh",)
    _mesh: Mesh | None = None  # the present one
    _first_mesh: Mesh | None = None
    columns = 0  # of vertices in a row, if it is a flat rectangle that shows its image once

    @built
    def __init__(self, body: Body, space: Space | None, vertices: ArrayLike, triangles: ArrayLike) -> None:
        mesh = _checked_mesh(vertices, triangles)  # first: what is wrong leaves no geom behind
        body.engine.triangles.set(self, len(mesh.triangles))
        super().__init__(body, space)
        self._data: int | None = None
        self._ode_vertices: NDArray[np.float64] | None = None
        self._ode_triangles: NDArray[np.uint32] | None = None
        self._take(mesh)

    @property
    def changed_mesh(self) -> Mesh | None:
        """The mesh, if it is not the first one."""
        return None if self._mesh is self._first_mesh else self._mesh

    @changed_mesh.setter
    def changed_mesh(self, mesh: Mesh | None) -> None:
        mesh = mesh or self._first_mesh
        if mesh is not None and mesh is not self._mesh:
            self.set_mesh(mesh.vertices, mesh.triangles)
            self._mesh = mesh

    @exclusive
    def set_mesh(self, vertices: ArrayLike, triangles: ArrayLike) -> None:
        """Replace the mesh.

        Raises:
            ParameterError: an index is out of range, or a coordinate is not finite.
        """
        self._take(_checked_mesh(vertices, triangles))

    def _take(self, mesh: Mesh) -> None:
        points, corners = mesh.vertices, mesh.triangles
        self.body.engine.triangles.set(self, len(corners))
        if _reach(points) > WIDE:
            self.body.engine.extend_range()
        self.vertices, self.triangles = points, corners
        self._mesh = mesh
        self._first_mesh = self._first_mesh or self._mesh
        self._reshaped()
        if self.space is None:
            return  # it is only rendered
        self.body.engine.collide_alone()
        if len(corners) == 1:
            points, corners = _halved(points[corners[0]])
        padded = np.zeros((len(points), 4))  # dVector3 is 4 doubles wide; ODE keeps the addresses
        padded[:, :3] = points
        data, old = new_mesh_data(padded, corners), self._data
        self._adopt(ode().dCreateTriMesh(_space_id(self.body, self.space), data, None, None, None))
        self._ode_vertices, self._ode_triangles, self._data = padded, corners, data
        if old is not None:
            ode().dGeomTriMeshDataDestroy(old)

    @exclusive
    def close(self) -> None:
        """Destroy the geom and its mesh."""
        super().close()
        self.body.engine.triangles.set(self, 0)
        if self._data is not None:
            ode().dGeomTriMeshDataDestroy(self._data)
            self._data = None
        # Large, and a closed world is in memory until Python collects its cycles.
        self.vertices, self.triangles = np.empty((0, 3)), np.empty((0, 3), dtype=np.uint32)
        self.normals = self.texture_coordinates = self.colors = self.image = None
        self._mesh = self._first_mesh = None
        self._ode_vertices = self._ode_triangles = None


def _checked_mesh(vertices: ArrayLike, triangles: ArrayLike) -> Mesh:
    points = table(vertices, 3, "vertices").astype(np.float64, copy=False)
    numbers = table(triangles, 3, "triangles")
    if not len(numbers) or not np.isfinite(points).all():
        raise ParameterError("a triangle mesh needs at least one triangle and finite vertices")
    _reach(points)
    for number in (numbers.min(), numbers.max()):
        if not 0 <= number < len(points):
            raise ParameterError(f"a triangle names vertex {number}; there are {len(points)}, from 0 on")
    return Mesh(points, np.ascontiguousarray(numbers, dtype=np.uint32))


def _reach(points: NDArray[np.float64]) -> float:
    """The largest coordinate of finite vertices [m].

    Raises:
        ParameterError: it is too large.
    """
    reach = max(float(points.max()), -float(points.min())) if points.size else 0.0
    if reach > LARGEST:
        raise ParameterError(f"a vertex lies at {reach:g} m; allowed is {LARGEST:g} m at most")
    return reach


class _Made:
    """An array of a geom that is made each time it is read, unless another one has been set."""

    def __init__(self, make: Callable[[Any], Any]) -> None:
        self._make = make

    def __get__(self, geom: Any, _owner: object) -> Any:
        return self._make(geom)


class GridGeom(TriMeshGeom):
    """Smooth ground above a grid, which is only rendered. Its arrays are far larger than its heights.

    Args:
        body: the body it belongs to.
        x, y: of the columns and rows of vertices [m].
        z: their heights [m], shape (rows, columns).

    Raises:
        ParameterError: a coordinate is too large.
    """

    @built
    def __init__(self, body: Body, x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64]) -> None:
        self._x, self._y, self._z = x, y, z
        reach = max(map(_reach, (x, y, z)))
        body.engine.triangles.set(self, 2 * (len(x) - 1) * (len(y) - 1))
        Geom.__init__(self, body, None)
        self._data = None
        if reach > WIDE:
            body.engine.extend_range()

    def _make_texture_coordinates(self) -> NDArray[np.float64] | None:
        """The ground shows the whole image once."""
        if self.image is None:
            return None
        rows, columns = self._z.shape
        coordinates = np.empty((rows, columns, 2))
        coordinates[..., 0], coordinates[..., 1] = np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)[:, None]
        return coordinates.reshape(-1, 2)

    vertices = _Made(lambda self: grid_vertices(self._x, self._y, self._z))
    triangles = _Made(lambda self: grid_triangles(*self._z.shape))
    normals = _Made(lambda self: vertex_normals(self.vertices, self.triangles))
    texture_coordinates = _Made(_make_texture_coordinates)

    @exclusive
    def close(self) -> None:
        """Destroy the geom and its heights."""
        super().close()
        self._x = self._y = np.empty(0)
        self._z = np.empty((0, 0))


class PrismGeom(TriMeshGeom):
    """An upright prism, such as a piece of wall.

    Args:
        outline: corners of its base, in order, at z = 0 [m], shape (n, 2).
        height: along z [m].

    Raises:
        ParameterError: the outline spans no area or crosses itself, or the height is not positive.
    """

    def __init__(self, body: Body, space: Space | None, outline: ArrayLike, height: float) -> None:
        corners = table(outline, 2, "corners")
        finite_tuple(corners.ravel(), corners.size, "corners [m]", LARGEST)
        super().__init__(body, space, *extrude([corners], positive(height, "prism height [m]")))
        self._mass = self.volume_mass = mass_.solid_mass(self.vertices, self.triangles)


class SkinGeom(TriMeshGeom):
    """A mesh that bones bend, as a skin; it is only rendered.

    Args:
        body: the body it belongs to.
        part: of a figure's skin.
        bones: the bodies that are the figure's bones, in its order.
    """

    def __init__(self, body: Body, part: SkinPart, bones: Sequence[Body]) -> None:
        used, self.places = np.unique(part.bones, return_inverse=True)
        self.places = self.places.reshape(part.bones.shape)
        self.bones = [bones[bone] for bone in used]
        self.inverse_binds = part.inverse_binds[used]
        self.weights, self.rest = part.weights, part.vertices
        self.bends = 0  # how often it was bent into another shape
        self._frames: NDArray[np.float64] | None = None
        self._smooth = Mesh(part.vertices, part.triangles.astype(np.uint32))  # as the file has it
        self._seams: NDArray[np.int64] | None = None  # the vertex of the file that each one is
        super().__init__(body, None, part.vertices, part.triangles)
        if part.texture is not None and part.texture.coordinates is not None:
            self._split(part.triangles, part.texture.coordinates.reshape(-1, 2))
        self.bend()

    def _split(self, triangles: NDArray[np.int64], coordinates: NDArray[np.float64]) -> None:
        """Make several vertices of one that lies in different places of the image."""
        rows = np.concatenate([triangles.reshape(-1, 1), coordinates], axis=1)
        kept, index = np.unique(rows, axis=0, return_inverse=True)
        seams = kept[:, 0].astype(np.int64)
        self.rest, self.weights, self.places = self.rest[seams], self.weights[seams], self.places[seams]
        self.set_mesh(self.rest, index.reshape(-1, 3))
        self._first_mesh, self._seams, self.texture_coordinates = self._mesh, seams, kept[:, 1:]

    def bend(self) -> bool:
        """Take the shape that the bones give it now (linear blend skinning); whether it is another one."""
        root, *poses = (_matrix(body.GetPose()) for body in (self.body, *self.bones))
        frames = np.asarray(np.linalg.inv(root) @ np.stack(poses), dtype=np.float64)
        if self._frames is not None and np.allclose(frames, self._frames, rtol=0.0, atol=1e-9):
            return False
        self._frames = frames
        moved = (frames @ self.inverse_binds)[:, :3]
        points = np.concatenate([self.rest, np.ones((len(self.rest), 1))], axis=1)
        blend = np.einsum("nj,njab->nab", self.weights, moved[self.places])
        vertices: NDArray[np.float64] = np.einsum("nab,nb->na", blend, points)
        self.vertices, whole = vertices, vertices
        if self._seams is not None:  # which are as smooth as the rest
            whole = np.empty_like(self._smooth.vertices)
            whole[self._seams] = vertices
        normals = vertex_normals(whole, self._smooth.triangles)
        self.normals = normals if self._seams is None else normals[self._seams]
        self.bends += 1
        return True


def _matrix(pose: GzPose) -> NDArray[np.float64]:
    from libgz.physics.skeletons import turn_matrices  # for actors alone

    matrix: NDArray[np.float64] = turn_matrices(np.array([*pose.rot]))
    matrix[:3, 3] = (*pose.pos,)
    return matrix


def _halved(triangle: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
    """One triangle as two: ODE misses collisions of two meshes of one triangle, or crashes in them."""
    middle = 0.5 * (triangle[:1] + triangle[1:2])
    return np.concatenate([triangle, middle]), np.array([[0, 3, 2], [3, 1, 2]], dtype=np.uint32)


class HeightfieldGeom(Geom):
    """Ground of varying height, centred on its pose.

    While it stands still, turned by another angle than a right one, it collides as a mesh of its triangles: ODE's
    bounding box of such a field is too small.

    Args:
        heights: [m], shape (rows, columns): rows along +y, columns along +x.
        xSize, ySize: extent [m].
        thickness: how far the ground reaches below its lowest point [m].
    """

    # ODE's field lies in x and z with heights along y; turned about x, its y is our z and its z our -y.
    extra_rotation = GzQuaternFromAxis(1.0, 0.0, 0.0, math.pi / 2.0)

    @built
    def __init__(
        self, body: Body, space: Space | None, heights: ArrayLike, xSize: float, ySize: float, thickness: float = 1.0
    ) -> None:
        self.heights: NDArray[np.float64] = np.array(heights, dtype=np.float64, order="C")
        if self.heights.ndim != 2 or min(self.heights.shape) < 2 or not (np.abs(self.heights) <= WIDE).all():
            raise ParameterError(f"heights must be at least 2 x 2 numbers within +-{WIDE:g} m")
        self.size = (positive(xSize, "extent [m]"), positive(ySize, "extent [m]"))
        depth = finite(not_negative(thickness, "thickness [m]"), "thickness [m]")
        place = _space_id(body, space)
        body.engine.triangles.set(self, 2 * self.heights.size)
        body.engine.collide_alone()
        samples = np.ascontiguousarray(self.heights[::-1])
        rows, columns = samples.shape
        self._data = ode().dGeomHeightfieldDataCreate()
        ode().dGeomHeightfieldDataBuildDouble(
            self._data, samples.ctypes.data, 1, *self.size, columns, rows, 1.0, 0.0, depth, 0
        )
        self._mesh: tuple[int, NDArray[np.float64], NDArray[np.uint32]] | None = None  # ODE's data, and what it reads
        super().__init__(body, space, ode().dCreateHeightfield(place, self._data, 1))

    @staticmethod
    def suits(pose: GzPose) -> bool:
        """Whether ODE has the right bounding box of a field at a pose: its axes lie along those of the world."""
        return all(max(map(abs, rotate(pose.rot, axis))) > SQUARE for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))

    @exclusive
    def follow_dummy(self) -> None:
        """Place it as its dummy body is, as a field where that suits."""
        as_mesh = not self.suits(self.GetPose())
        if as_mesh != (self._mesh is not None):
            self._collide(as_mesh)  # which places it
        else:
            super().follow_dummy()

    def _collide(self, as_mesh: bool) -> None:
        """Use a field or a mesh of ODE from now on."""
        space, before = _space_id(self.body, self.space), self._mesh
        if as_mesh:
            points, corners = self.triangulated()
            padded = np.zeros((len(points), 4))  # as of a TriMeshGeom, and turned as the field
            padded[:, 0], padded[:, 1], padded[:, 2] = points[:, 0], points[:, 2], -points[:, 1]
            data = new_mesh_data(padded, corners)
            self._mesh = data, padded, corners
            self._adopt(ode().dCreateTriMesh(space, data, None, None, None))
        else:
            self._mesh = None
            self._adopt(ode().dCreateHeightfield(space, self._data, 1))
        if before is not None:
            ode().dGeomTriMeshDataDestroy(before[0])

    def _adopt(self, handle: int) -> None:
        super()._adopt(handle)
        if self._id == handle and self._mesh is None:
            self.body.engine.show_field_to_rays(handle, self.heights, self.size)

    def _destroy_handle(self) -> None:
        if self._id is not None:
            self.body.engine.hide_field_from_rays(self._id)
        super()._destroy_handle()

    def triangulated(self) -> tuple[NDArray[np.float64], NDArray[np.uint32]]:
        """(vertices, triangles) of the ground [m], two triangles per cell as ODE has them."""
        rows, columns = self.heights.shape
        x, y = np.meshgrid(
            *(np.linspace(-0.5, 0.5, n) * side for n, side in zip((columns, rows), self.size, strict=True))
        )
        corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
        cells = [corner + np.array(offsets) for offsets in ((0, 1, columns), (1, columns + 1, columns))]
        return np.stack([x, y, self.heights], axis=-1).reshape(-1, 3), np.concatenate(cells).astype(np.uint32)

    @exclusive
    def close(self) -> None:
        """Destroy the geom and its heights."""
        super().close()
        self.body.engine.triangles.set(self, 0)
        if self._data is not None:
            ode().dGeomHeightfieldDataDestroy(self._data)
            self._data = None
        if self._mesh is not None:
            ode().dGeomTriMeshDataDestroy(self._mesh[0])
            self._mesh = None
        self.heights = np.empty((0, 0))  # as those of a mesh


class RayGeom(Geom):
    """One ray in global terms, for a model's own use: set it, cast it, read it. Nothing collides with it."""

    def __init__(self, body: Body, space: Space | None = None) -> None:
        super().__init__(body, space, placeable=False)
        self._start, self._direction, self._length = GzVector(), GzVector(1.0, 0.0, 0.0), 1.0
        self.depth = math.inf

    def Set(self, pos: VectorLike, dir: VectorLike) -> None:
        """Place the ray: start [m] and direction, global."""
        self._start = GzVector(*finite_tuple(pos, 3, "ray start [m]"))
        self._direction = GzVector(*unit_axis(dir, "ray direction"))

    def Get(self) -> tuple[GzVector, GzVector]:
        """(start [m], unit direction), global."""
        return self._start, self._direction

    def SetLength(self, length: float) -> None:
        """Length of the ray [m]."""
        self._length = positive(length, "ray length [m]")

    def GetLength(self) -> float:
        """Length of the ray [m]."""
        return self._length

    def Cast(self) -> float:
        """Distance to what the ray hits [m], infinite for nothing; geoms of its own body are ignored."""
        frame = np.array([*self._start, 1.0, 0.0, 0.0, 0.0])
        rays = np.array([[0.0, 0.0, 0.0, *self._direction, self._length]])
        ranges, rows = np.empty(1), np.empty(1, dtype=np.int64)
        self.body.engine.scan(frame, rays, self.body.number, ranges, rows)
        self.depth = math.inf if ranges[0] == NO_HIT else float(ranges[0])
        return self.depth


class LightGeom(Geom):
    """A light where its body is.

    Attributes:
        attenuation: constant, linear [1/m] and quadratic [1/m^2] part of how it fades with distance.
        kind: point, directional or spot.
        direction: in which directional lights and spots shine, in the body frame.
        spot: inner and outer angle of a spot's cone [rad] and the falloff between them, as a power.
        range: nothing beyond is lit [m].
        cast_shadows: whether bodies cast shadows in its light, where images have shadows.
    """

    SAVED = ("attenuation", "kind", "direction", "spot", "range", "cast_shadows")

    def __init__(self, body: Body, space: Space | None = None) -> None:
        super().__init__(body, space, placeable=True)
        self.attenuation = GzVector(1.0, 0.0, 0.0)
        self.kind = "point"
        self.direction = GzVector(0.0, 0.0, -1.0)
        self.spot = (0.0, 0.0, 0.0)
        self.range = math.inf
        self.cast_shadows = True
        self.appearance.render_order = RENDER_LIGHT

    def SetAttenuation(self, factors: VectorLike) -> None:
        """Constant, linear [1/m] and quadratic [1/m^2] part of how light fades with distance.

        Raises:
            ParameterError: one is negative, or no number.
        """
        numbers = finite_tuple(factors, 3, "attenuation")
        if min(numbers) < 0.0:
            raise ParameterError(f"attenuation is {numbers}; its numbers must not be negative")
        self.attenuation = GzVector(*(min(number, LARGEST) for number in numbers))

    def SetDirection(self, direction: VectorLike) -> None:
        """In which directional lights and spots shine, in the body frame.

        Raises:
            ParameterError: it is not three numbers within +-1e9.
        """
        self.direction = GzVector(*finite_tuple(direction, 3, "direction", LARGEST))

    def SetSpot(self, inner: float, outer: float, falloff: float) -> None:
        """Inner and outer angle of a spot's cone [rad] and the falloff between them, as a power.

        Raises:
            ParameterError: one is not finite.
        """
        inner, outer, falloff = finite_tuple((inner, outer, falloff), 3, "the cone of the light")
        self.spot = (inner, outer, falloff)

    def SetRange(self, distance: float) -> None:
        """Beyond which nothing is lit [m]; may be infinite.

        Raises:
            ParameterError: it is no number.
        """
        if math.isnan(distance):
            raise ParameterError("the range of a light must be a number")
        self.range = float(distance)

    @staticmethod
    def CheckAvailable() -> bool:
        """Always true."""
        return True


class DomeGeom(Geom):
    """The sky around every camera; its texture is a tone map: midnight to midnight, zenith to horizon.

    Attributes:
        start: time since midnight at the start [s].
        elapsed: time since the start [s].
    """

    def __init__(self, body: Body, space: Space | None = None) -> None:
        super().__init__(body, space, placeable=False)
        self.appearance.render_order = RENDER_LIGHT
        self.start = self.elapsed = 0.0

    def SetDayTime(self, seconds: float) -> None:
        """Time since midnight at the start [s]."""
        self.start = finite(seconds, "time of day [s]")

    def SetElapsedTime(self, seconds: float) -> None:
        """Time since the start [s]."""
        self.elapsed = finite(seconds, "elapsed time [s]")

    @property
    def day_share(self) -> float:
        """The time of day as a share of 24 hours, 0 to 1."""
        return math.fmod((self.start + self.elapsed) / 86400.0, 1.0)


class FrustrumGeom(Geom):
    """The outline of a camera's field of view: it is rendered on request and touches nothing.

    Args:
        body: the body it belongs to.
        space: the model's space (`modelSpaceId`), or None for a geom that nothing touches.
        aspect: width / height of the image.
        nearClip, farClip: distances of the ends [m].

    Raises:
        ParameterError: a number is not positive.
    """

    def __init__(self, body: Body, space: Space | None, aspect: float, nearClip: float, farClip: float) -> None:
        super().__init__(body, space, placeable=True)
        self.aspect = positive(aspect, "aspect")
        self.near_clip, self.far_clip = positive(nearClip, "near clip [m]"), positive(farClip, "far clip [m]")
        self.fov = math.pi / 6.0

    def SetFOV(self, fov: float) -> None:
        """Horizontal field of view [rad]."""
        self.fov = positive(fov, "field of view [rad]")
