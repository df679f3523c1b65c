"""Triangle meshes from files: STL, Wavefront OBJ and COLLADA by readers of our own, others by the package trimesh."""

from __future__ import annotations

import contextlib
import functools
import struct
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.errors import GazeboError
from libgz.files import is_file

__all__ = ["Collada", "MeshPart", "read_mesh", "reading", "step_matrix", "trimesh_parts", "used"]

Array = NDArray[np.float64]

MOST_TRIANGLES = 20_000_000
MOST_NODES = 100_000  # and geometries of a COLLADA scene, with all that is instantiated


@dataclass
class MeshPart:
    """A piece of a mesh: vertices [m], shape (n, 3); triangles, shape (m, 3); its colour, if the file gives one."""

    name: str
    vertices: Array
    triangles: NDArray[np.int64]
    color: tuple[float, ...] | None = None


def read_mesh(path: Path) -> list[MeshPart]:
    """All parts of a mesh file.

    Raises:
        GazeboError: it cannot be read, or holds no triangles.
    """
    return _read(path.resolve(), path.stat().st_mtime_ns if is_file(path) else 0)


@contextlib.contextmanager
def reading(path: Path) -> Iterator[None]:
    """Whatever is raised while a mesh file is read becomes an error of the file.

    Raises:
        GazeboError: it cannot be read.
    """
    try:
        with np.errstate(all="ignore"):  # what is not finite is found afterwards
            yield
    except OSError as error:
        raise GazeboError(f"mesh {path} cannot be read: {error.strerror}") from None
    except GazeboError:
        raise
    except MemoryError:
        raise GazeboError(f"mesh {path} cannot be read: there is not enough memory for it") from None
    except RecursionError:
        raise GazeboError(f"mesh {path} cannot be read: it is nested too deeply") from None
    except Exception as error:  # noqa: BLE001 - damaged files have wrong things in any place
        reason = str(error) or type(error).__name__
        raise GazeboError(f"mesh {path} cannot be read: it is damaged ({reason})") from None


@functools.lru_cache(maxsize=32)
def _read(path: Path, _changed: int) -> list[MeshPart]:
    readers = {".stl": _read_stl, ".obj": _read_obj, ".dae": _read_dae}
    reader = readers.get(path.suffix.lower(), _read_by_trimesh)
    with reading(path):
        parts = [part for part in _bounded(reader(path), path) if len(part.triangles)]
    if not parts:
        raise GazeboError(f"mesh {path} holds no triangles")
    for part in parts:
        outside = part.triangles.min() < 0 or part.triangles.max() >= len(part.vertices)
        if outside or not np.isfinite(part.vertices).all():
            raise GazeboError(f"mesh {path} cannot be read: a vertex is not finite, or a triangle names none")
    return parts


def _bounded(parts: Iterable[MeshPart], path: Path) -> Iterator[MeshPart]:
    """The parts, as long as they are not too many: a file may refer to its parts again and again."""
    total = 0
    for part in parts:
        total += len(part.triangles)
        if total > MOST_TRIANGLES:
            raise GazeboError(f"mesh {path} has more than {MOST_TRIANGLES} triangles")
        yield part


def _read_by_trimesh(path: Path) -> Iterator[MeshPart]:
    for part in trimesh_parts(path, "mesh"):
        yield MeshPart("", np.array(part.vertices, dtype=np.float64), np.array(part.faces, dtype=np.int64))


def trimesh_parts(path: Path, what: str) -> list[Any]:
    """The parts of a file that have faces, as the package trimesh reads them; `what` the file is, for messages.

    Raises:
        GazeboError: the package is missing, or cannot read the file.
    """
    try:
        import trimesh  # type: ignore[import-not-found, unused-ignore]
    except ImportError:
        raise GazeboError(f"{what} {path} needs the package trimesh: pip install 'libgz[mesh]'") from None
    try:
        loaded: Any = trimesh.load(path, force="scene")
        parts = loaded.dump()
    except Exception as error:  # noqa: BLE001 - trimesh's readers raise whatever their formats suggest
        raise GazeboError(f"{what} {path} cannot be read: {error}") from None
    return [part for part in parts if len(getattr(part, "faces", ()))]


# STL -------------------------------------------------------------------------------------------------------------


def _read_stl(path: Path) -> Iterator[MeshPart]:
    data = path.read_bytes()
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        rows = np.frombuffer(data, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")], offset=84)
        yield _soup("", rows["corners"].reshape(-1, 3))
        return
    name, corners = "", []
    for line in data.decode("utf-8", "replace").splitlines():
        words = line.split()
        if words[:1] == ["solid"]:
            name = " ".join(words[1:])
        elif words[:1] == ["vertex"]:
            corners.append([float(word) for word in words[1:4]])
        elif words[:1] == ["endsolid"] and corners:
            yield _soup(name, np.array(corners))
            corners = []


def _soup(name: str, corners: NDArray[Any]) -> MeshPart:
    """Triangles given by their corners, three rows each; equal corners become one vertex."""
    points = np.array(corners, dtype=np.float64).reshape(-1, 3)
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    return MeshPart(name, vertices, np.array(index, dtype=np.int64).reshape(-1, 3))


def _fans(polygons: Iterable[list[int]]) -> NDArray[np.int64]:
    """Convex polygons as triangles."""
    rows = [(p[0], p[i], p[i + 1]) for p in polygons for i in range(1, len(p) - 1)]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


# Wavefront OBJ ---------------------------------------------------------------------------------------------------


def _read_obj(path: Path) -> Iterator[MeshPart]:
    vertices: list[list[float]] = []
    colors: dict[str, tuple[float, ...]] = {}
    groups: dict[tuple[str, str], list[list[int]]] = {}
    name = material = ""
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        key, _, rest = line.strip().partition(" ")
        if key == "v":
            vertices.append([float(word) for word in rest.split()[:3]])
        elif key in ("o", "g"):
            name = rest.strip()
        elif key == "usemtl":
            material = rest.strip()
        elif key == "mtllib":
            colors |= _read_mtl(path.parent / rest.strip())
        elif key == "f":
            corners = [int(word.partition("/")[0]) for word in rest.split()]
            face = [corner - 1 if corner > 0 else len(vertices) + corner for corner in corners]
            groups.setdefault((name, material), []).append(face)
    points = np.array(vertices, dtype=np.float64).reshape(-1, 3)
    for (part, look), faces in groups.items():
        yield used(part, points, _fans(faces), colors.get(look))


def _read_mtl(path: Path) -> dict[str, tuple[float, ...]]:
    """Diffuse colours by material."""
    if not is_file(path):
        return {}
    name, found = "", {}
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["newmtl"]:
            name = " ".join(words[1:])
        elif words[:1] == ["Kd"] and len(words) >= 4:
            found[name] = (*(float(word) for word in words[1:4]), 1.0)
    return found


def used(name: str, points: Array, triangles: NDArray[np.int64], color: tuple[float, ...] | None) -> MeshPart:
    """A part with only the vertices that its triangles name."""
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(points):
        raise ValueError(f"a triangle names a vertex that does not exist; there are {len(points)}")
    kept, index = np.unique(triangles, return_inverse=True)
    return MeshPart(name, points[kept], np.array(index, dtype=np.int64).reshape(-1, 3), color)


# COLLADA ---------------------------------------------------------------------------------------------------------


class Collada:
    """A COLLADA document. Its unit is honoured, its up axis is not: classic took coordinates as they are."""

    def __init__(self, path: Path) -> None:
        from lxml import etree

        parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True, remove_comments=True)
        try:
            self.root = etree.parse(str(path), parser).getroot()
        except etree.XMLSyntaxError as error:
            raise ValueError(error.msg) from None
        self.nodes = 0  # visited, and geometries in them
        self.above: list[Any] = []  # the nodes that are being visited
        self.ids = {element.get("id"): element for element in self.root.iter() if element.get("id")}

    @staticmethod
    def tag(element: Any) -> str:
        """The name of an element."""
        return str(element.tag).rpartition("}")[2]

    def all(self, element: Any, name: str) -> list[Any]:
        """The children of a name."""
        return [child for child in element if self.tag(child) == name]

    def deep(self, element: Any, name: str) -> Iterator[Any]:
        """The element and all in it of a name."""
        return (child for child in element.iter() if self.tag(child) == name)

    def target(self, url: str | None) -> Any:
        """The element that a reference names.

        Raises:
            ValueError: there is none.
        """
        name = (url or "").removeprefix("#")
        if name not in self.ids:
            raise ValueError(f"it refers to {url!r}, which does not exist" if url else "a reference is missing")
        return self.ids[name]

    def first(self, elements: Iterable[Any], what: str) -> Any:
        """The first of several elements.

        Raises:
            ValueError: there is none.
        """
        found = next(iter(elements), None)
        if found is None:
            raise ValueError(f"{what} is missing")
        return found

    @property
    def unit(self) -> float:
        """The document's unit of length [m]."""
        unit = next(self.deep(self.root, "unit"), None)
        return float(unit.get("meter", "1")) if unit is not None else 1.0

    def parts(self) -> Iterator[MeshPart]:
        """The triangles of its scene."""
        scale = self.unit
        scenes = list(self.deep(self.root, "visual_scene"))
        if not scenes:
            for geometry in self.deep(self.root, "geometry"):
                yield from self.geometry(geometry, "", scale * np.eye(4), {})
        for node in (node for scene in scenes[:1] for node in self.all(scene, "node")):
            yield from self.node(node, np.diag([scale, scale, scale, 1.0]))

    def node(self, node: Any, frame: Array) -> Iterator[MeshPart]:
        """The triangles of a node and of all below it, in a frame.

        Raises:
            ValueError: it contains itself, or the scene is too large.
        """
        if any(node is other for other in self.above):
            raise ValueError(f"node {node.get('id')!r} contains itself")
        self.above.append(node)
        self.nodes += 1 + len(self.all(node, "instance_geometry"))
        if self.nodes > MOST_NODES:
            raise ValueError(f"its scene has more than {MOST_NODES} nodes and geometries")
        frame = frame @ self.transform(node)
        name = node.get("name") or node.get("id") or ""
        for instance in self.all(node, "instance_geometry"):
            bound = {m.get("symbol"): m.get("target", "") for m in self.deep(instance, "instance_material")}
            yield from self.geometry(self.target(instance.get("url")), name, frame, bound)
        for instance in self.all(node, "instance_controller"):
            bound = {m.get("symbol"): m.get("target", "") for m in self.deep(instance, "instance_material")}
            for skin in self.all(self.target(instance.get("url")), "skin"):
                place = np.diag([self.unit] * 3 + [1.0]) @ self.bind_shape(skin)  # a node does not move its skin
                yield from self.geometry(self.target(skin.get("source")), name, place, bound)
        for instance in self.all(node, "instance_node"):
            yield from self.node(self.target(instance.get("url")), frame)
        for child in self.all(node, "node"):
            yield from self.node(child, frame)
        self.above.pop()

    def bind_shape(self, skin: Any) -> Array:
        """The transformation of a skin's mesh before bones move it."""
        for matrix in self.all(skin, "bind_shape_matrix"):
            return np.array([float(word) for word in (matrix.text or "").split()]).reshape(4, 4)
        return np.eye(4)

    def steps(self, node: Any) -> list[tuple[str, str, Array]]:
        """A node's transformations in their order: (sid, kind, numbers)."""
        return [
            (child.get("sid", ""), self.tag(child), np.array([float(word) for word in (child.text or "").split()]))
            for child in node
            if self.tag(child) in ("matrix", "translate", "scale", "rotate")
        ]

    def transform(self, node: Any) -> Array:
        """The product of a node's transformations, in their order."""
        result = np.eye(4)
        for _, kind, numbers in self.steps(node):
            result = result @ step_matrix(kind, numbers)
        return result

    def geometry(self, geometry: Any, name: str, frame: Array, bound: dict[str, str]) -> Iterator[MeshPart]:
        """The triangles of a geometry, by material."""
        for mesh in self.all(geometry, "mesh"):
            for kind in ("triangles", "polylist", "polygons"):
                for group in self.all(mesh, kind):
                    points, triangles = self.primitive(group, kind)
                    points = points @ frame[:3, :3].T + frame[:3, 3]
                    color = self.color(bound.get(group.get("material"), ""))
                    yield used(name or geometry.get("name", ""), points, triangles, color)

    def primitive(self, group: Any, kind: str) -> tuple[Array, NDArray[np.int64]]:
        """(positions, triangles) of one group of faces."""
        inputs = self.all(group, "input")
        vertex = self.first((i for i in inputs if i.get("semantic") == "VERTEX"), "an <input> of vertices")
        stride = 1 + max(int(i.get("offset", "0")) for i in inputs)
        given = self.all(self.target(vertex.get("source")), "input")
        positions = self.first((i for i in given if i.get("semantic") == "POSITION"), "an <input> of positions")
        source = self.target(positions.get("source"))
        array = self.first(self.deep(source, "float_array"), "<float_array>")
        points = np.array((array.text or "").split(), dtype=np.float64).reshape(-1, 3)
        offset = int(vertex.get("offset", "0"))
        runs = [np.array((p.text or "").split(), dtype=np.int64)[offset::stride] for p in self.all(group, "p")]
        if kind == "triangles":
            return points, np.concatenate(runs).reshape(-1, 3) if runs else np.zeros((0, 3), dtype=np.int64)
        if kind == "polygons":
            return points, _fans(run.tolist() for run in runs)
        counts = np.array((self.first(self.deep(group, "vcount"), "<vcount>").text or "").split(), dtype=np.int64)
        corners = np.split(np.concatenate(runs), np.cumsum(counts)[:-1])
        return points, _fans(corner.tolist() for corner in corners)

    def color(self, material: str) -> tuple[float, ...] | None:
        """The diffuse colour of a material."""
        if not material:
            return None
        effects = self.all(self.target(material), "instance_effect")
        for effect in effects:
            for diffuse in self.deep(self.target(effect.get("url")), "diffuse"):
                for color in self.all(diffuse, "color"):
                    values = tuple(float(word) for word in (color.text or "").split())
                    return values if len(values) == 4 else None
        return None


def step_matrix(kind: str, numbers: Array) -> Array:
    """The matrix of one transformation: matrix, translate, scale, or rotate with degrees; shape (4, 4)."""
    step = np.eye(4)
    if kind == "matrix":
        step = numbers.reshape(4, 4)
    elif kind == "translate":
        step[:3, 3] = numbers
    elif kind == "scale":
        step[[0, 1, 2], [0, 1, 2]] = numbers
    else:
        step[:3, :3] = _turn(numbers[:3], np.radians(numbers[3]))
    return step


def _turn(axis: Array, angle: float) -> Array:
    """The rotation matrix about an axis of any length by an angle [rad] (Rodrigues' formula)."""
    x, y, z = axis / max(float(np.linalg.norm(axis)), 1e-12)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result: Array = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return result


def _read_dae(path: Path) -> Iterator[MeshPart]:
    return Collada(path).parts()
