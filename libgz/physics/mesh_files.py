"""Triangle meshes from files: STL, Wavefront OBJ and COLLADA by readers of our own, others by the package trimesh."""

from __future__ import annotations

import contextlib
import functools
import io
import itertools
import json
import logging
import math
import os
import struct
import threading
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.base.extras import install
from libgz.base.files import is_file, open_file, read_file, read_limited, read_text
from libgz.physics.faces import Effort, cut_fans, cut_polygons, cut_strips
from libgz.physics.image_files import quiet
from libgz.physics.mesh_parts import MeshPart, NamedImage, Texture
from libgz.physics.meshes import triangle_normals, units

__all__ = [
    "Collada",
    "read_mesh",
    "read_numbers",
    "reading",
    "step_matrix",
    "trimesh_parts",
    "used",
]

log = logging.getLogger("libgz.physics")

Array = NDArray[np.float64]
Found = TypeVar("Found")

MOST_TRIANGLES = 20_000_000
MOST_NUMBERS = 12 * MOST_TRIANGLES  # rows of all that a glTF file has: indices, positions, normals, coordinates
# Triangles of an OBJ file, beside one for each so many bytes, for a face may have any number of corners.
MOST_SMALL, TRIANGLE = 1_000_000, 8
MOST_KEPT = 256 << 20  # bytes of meshes that were read
TEXT_START = 4096  # bytes of an STL file in which a text has its first vertex
# Characters that are read because references of a COLLADA document lead to them, each time; and as many as the file's
# own times so many. An element takes as long as so many characters.
MOST_READ, TIMES_READ, ELEMENT = 2 << 30, 8, 500
GLTF = ("glb", "gltf")
ARCHIVES = ("3dxml", "3mf", "bz2", "gz", "tar", "zae", "zip")  # which trimesh reads, to any size
LARGEST_FILE = 4 << 30  # bytes; 20 million triangles have less
MOST_NODES = 100_000  # and geometries of a scene, with all that is instantiated; parts of any mesh
MOST_DEPTH = 1000  # of the nodes of a glTF scene: trimesh goes from each one up to the first
ROWS = {"MAT3": 3, "MAT4": 4}  # rows of four numbers, as which the values of a glTF file are counted that have more
LUMINANCE = (0.212671, 0.715160, 0.072169)  # of red, green, blue (ITU-R BT.709), as COLLADA says
LARGEST_COORDINATE = 1e6  # of a texture: how often it repeats
# Of maps in material libraries: how many values follow at most.
MAP_OPTIONS = {"-o": 3, "-s": 3, "-t": 3, "-mm": 2} | dict.fromkeys(
    ("-blendu", "-blendv", "-bm", "-boost", "-cc", "-clamp", "-imfchan", "-texres", "-type"), 1
)


def read_mesh(path: Path) -> list[MeshPart]:
    """All parts of a mesh file.

    Raises:
        GazeboError: it cannot be read, or holds no triangles.
    """
    path = path.resolve()
    when = _changed(path)
    found = _kept.get(path)
    if found is None or found.when != when or any(_changed(one) != then for one, then in found.libraries.items()):
        found = _read(path, when)
        _kept.put(path, found)
    return found.parts


def _changed(path: Path) -> int:
    """When a file was last changed [ns]; 0 if there is none."""
    return path.stat().st_mtime_ns if is_file(path) else 0


@dataclass(eq=False, repr=False)
class _Mesh:
    """A mesh that was read, and when its file, and each material library that it names, was last changed [ns]."""

    parts: list[MeshPart]
    when: int
    libraries: dict[Path, int]

    @property
    def size(self) -> int:
        """Bytes of its arrays."""
        arrays = [a for part in self.parts for a in (part.vertices, part.triangles, part.normals)]
        arrays += [part.texture.coordinates for part in self.parts if part.texture is not None]
        return sum(array.nbytes for array in arrays if array is not None)


class _Kept:
    """The meshes that were read last, as many as have a bounded size: worlds use the same ones again and again."""

    def __init__(self) -> None:
        self._meshes: dict[Path, _Mesh] = {}  # the one that was used last comes last
        self._lock = threading.Lock()

    def get(self, path: Path) -> _Mesh | None:
        """The mesh of a file, as it was when it was read; None if it is not kept."""
        with self._lock:
            found = self._meshes.pop(path, None)
            if found is not None:
                self._meshes[path] = found
            return found

    def put(self, path: Path, mesh: _Mesh) -> None:
        """Keep a mesh, and as many of the others as fit."""
        with self._lock:
            self._meshes.pop(path, None)
            self._meshes[path] = mesh
            total = sum(kept.size for kept in self._meshes.values())
            for old in list(self._meshes):
                if total <= MOST_KEPT:
                    break
                total -= self._meshes.pop(old).size


_kept = _Kept()


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


def _read(path: Path, when: int) -> _Mesh:
    libraries: dict[Path, int] = {}
    readers: dict[str, Callable[[Path], Iterator[MeshPart]]] = {
        ".stl": _read_stl,
        ".obj": functools.partial(_read_obj, libraries=libraries),
        ".dae": _read_dae,
    }
    reader = readers.get(path.suffix.lower(), _read_by_trimesh)
    if is_file(path) and path.stat().st_size > LARGEST_FILE:
        raise GazeboError(f"mesh {path} is larger than {LARGEST_FILE >> 20} MiB")
    with reading(path):
        parts = [part for part in _bounded(reader(path), path) if len(part.triangles)]
    if not parts:
        raise GazeboError(f"mesh {path} holds no triangles")
    for part in parts:
        outside = part.triangles.min() < 0 or part.triangles.max() >= len(part.vertices)
        if outside or not np.isfinite(part.vertices).all():
            raise GazeboError(f"mesh {path} cannot be read: a vertex is not finite, or a triangle names none")
    return _Mesh(parts, when, libraries)


def _bounded(parts: Iterable[MeshPart], path: Path) -> Iterator[MeshPart]:
    """The parts, as long as they are not too many: a file may refer to its parts again and again."""
    total = 0
    for number, part in enumerate(parts):
        if number >= MOST_NODES:
            raise GazeboError(f"mesh {path} has more than {MOST_NODES} parts")
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
        raise GazeboError(f"{what} {path} needs the package trimesh: {install('mesh')}") from None
    kind = path.suffix.lower().removeprefix(".")
    if kind in ARCHIVES:
        raise GazeboError(f"{what} {path} cannot be read: it is an archive")

    class Files(trimesh.resolvers.FilePathResolver):  # type: ignore[misc, unused-ignore]
        left = LARGEST_FILE  # bytes, of all files together

        def get(self, name: str) -> bytes:
            """The bytes of a file that this one names, but no image: pillow would read any format, and to any size."""
            if kind not in GLTF and Path(name.strip()).suffix.lower() != ".mtl":
                raise FileNotFoundError(name)
            data = read_limited(Path(self.parent) / name.strip(), self.left)
            self.left -= len(data)
            return data

    try:
        more = {"skip_materials": True} if kind == "ply" else {}  # of which it has images alone
        with open_file(path) as file, quiet():
            if os.fstat(file.fileno()).st_size > LARGEST_FILE:
                raise ValueError(f"it is larger than {LARGEST_FILE >> 20} MiB")
            data = _checked_gltf(file) if kind in GLTF else file
            loaded: Any = trimesh.load(data, file_type=kind, force="scene", resolver=Files(str(path)), **more)
            _check_size(loaded)
            parts = [part for part in loaded.dump() if len(getattr(part, "faces", ()))]
        if any(part.faces.min() < 0 or part.faces.max() >= len(part.vertices) for part in parts):
            raise ValueError("a triangle names a vertex that does not exist")
    except Exception as error:  # noqa: BLE001 - trimesh's readers raise whatever their formats suggest
        reason = "there is not enough memory for it" if isinstance(error, MemoryError) else error
        raise GazeboError(f"{what} {path} cannot be read: {reason}") from None
    return parts


def _checked_gltf(file: BinaryIO) -> BinaryIO:
    """The same glTF file without its images, which nobody looks at and each material would hold whole.

    Raises:
        ValueError: it declares more numbers than the largest mesh has, for those that it does not have are zeros; it
            has too many nodes, or too deep ones; it is damaged.
    """
    head = file.read(20)
    length = min(int.from_bytes(head[12:16], "little"), os.fstat(file.fileno()).st_size)
    binary = head.startswith(b"glTF")
    about = json.loads(file.read(length) if binary else head + file.read())
    declared = sum(
        max(int(accessor.get("count", 0)), 0) * ROWS.get(accessor.get("type"), 1)
        for accessor in about.get("accessors", ())
    )
    if declared > MOST_NUMBERS:
        raise ValueError(f"it declares {declared} vertices and indices; {MOST_NUMBERS} are allowed")
    _check_depth([node.get("children", ()) for node in about.get("nodes", ())])
    if not about.pop("images", None):
        file.seek(0)
        return file
    text = json.dumps(about).encode()
    if not binary:
        return io.BytesIO(text)
    text += b" " * (-len(text) % 4)
    rest = file.read()
    sizes = struct.pack("<II", (len(head) + len(text) + len(rest)) & 0xFFFFFFFF, len(text))
    return io.BytesIO(b"".join([head[:8], sizes, head[16:], text, rest]))


def _check_depth(children: list[list[int]]) -> None:
    """Check the nodes of a glTF file, given by the numbers of their children.

    Raises:
        ValueError: they are too many, or nested too deeply, as all are that contain themselves.
    """
    if len(children) > MOST_NODES or sum(map(len, children)) > MOST_NODES:
        raise ValueError(f"it has more than {MOST_NODES} nodes and geometries")
    if any(not 0 <= child < len(children) for some in children for child in some):
        raise ValueError("a node has a child that is not there")
    parents = Counter(itertools.chain.from_iterable(children))  # of each node, as far as they were not looked at
    level, looked = [node for node in range(len(children)) if not parents[node]], 0
    for _ in range(MOST_DEPTH + 1):
        looked += len(level)
        below, level = [child for node in level for child in children[node]], []
        for child in below:
            parents[child] -= 1
            if not parents[child]:
                level.append(child)
    if looked < len(children):
        raise ValueError(f"its nodes are nested more than {MOST_DEPTH} deep, or contain themselves")


def _check_size(scene: Any) -> None:
    """Check how much a scene of trimesh has with all its instances, each of which would be a copy.

    Raises:
        ValueError: it is too much.
    """
    nodes = triangles = vertices = 0
    for name, placed in scene.graph.geometry_nodes.items():
        shape, count = scene.geometry[name], len(placed)
        nodes += count
        triangles += count * len(getattr(shape, "faces", ()))
        vertices += count * len(getattr(shape, "vertices", ()))
    if nodes > MOST_NODES:
        raise ValueError(f"it has more than {MOST_NODES} nodes and geometries")
    if triangles > MOST_TRIANGLES or vertices > 3 * MOST_TRIANGLES:
        raise ValueError(f"it has more than {MOST_TRIANGLES} triangles, or three vertices for each of so many")


# STL -------------------------------------------------------------------------------------------------------------


def _read_stl(path: Path) -> Iterator[MeshPart]:
    data = read_file(path)
    count = struct.unpack_from("<I", data, 80)[0] if len(data) >= 84 else -1
    # Binary files may begin with the word solid, and end with anything.
    text = data.lstrip().startswith(b"solid") and b"vertex" in data[:TEXT_START]
    if count >= 0 and (len(data) == 84 + 50 * count or not text):
        if len(data) < 84 + 50 * count:
            raise ValueError(f"it has {(len(data) - 84) // 50} of {count} triangles")
        kind = [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]
        rows = np.frombuffer(data, dtype=kind, offset=84, count=count)
        yield _soup("", rows["corners"].reshape(-1, 3))
        return
    name, corners = "", []
    for line in data.decode("utf-8", "replace").splitlines():
        words = line.split()
        key = words[0].lower() if words else ""
        if key == "vertex":
            corners.append([float(word) for word in words[1:4]])
        elif key in ("solid", "endsolid"):
            if corners:
                yield _soup(name, np.array(corners[: len(corners) // 3 * 3]))
            name, corners = " ".join(words[1:]), []
    if len(corners) >= 3:  # the last solid has no end
        yield _soup(name, np.array(corners[: len(corners) // 3 * 3]))


def _soup(name: str, corners: NDArray[Any]) -> MeshPart:
    """Flat triangles given by their corners, three rows each; equal corners become one vertex."""
    points = np.array(corners, dtype=np.float64).reshape(-1, 3)
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    triangles = np.array(index, dtype=np.int64).reshape(-1, 3)
    flat = np.repeat(triangle_normals(vertices, triangles)[:, None, :], 3, axis=1)
    return MeshPart(name, vertices, triangles, normals=flat)


def _texels(table: Array) -> Array:
    """Texture coordinates, shape (n, 2); none if one of them is damaged."""
    return table if (np.abs(table) <= LARGEST_COORDINATE).all() else table[:0]


def _directions(table: Array) -> NDArray[Any]:
    """Unit normals, shape (n, 3); none if one of them is damaged."""
    return units(table) if len(table) and np.isfinite(table).all() else table[:0]


def _rows(table: NDArray[Any], corners: NDArray[np.int64]) -> Array | None:
    """What corners have, as rows of a table by number, -1: zeros; None if one is not in it, or all are -1."""
    if not len(table) or not len(corners) or not (corners.min() >= -1 and 0 <= corners.max() < len(table)):
        return None
    found: Array = np.where(corners[..., None] < 0, 0.0, table[corners])
    return found


# Wavefront OBJ ---------------------------------------------------------------------------------------------------


@dataclass(eq=False, repr=False)
class _Look:
    """A material of a library: its colour, its opacity, and the name of its image, as far as it has them."""

    file: Path
    color: tuple[float, ...] | None = None
    opacity: float = 1.0
    dissolved: bool = False  # whether `d` gave the opacity
    image: str = ""

    @property
    def shown(self) -> tuple[float, ...] | None:
        """The colour with the opacity; white for what is transparent without a colour."""
        if self.color is None and self.opacity >= 1.0:
            return None
        return (*(self.color or (1.0, 1.0, 1.0))[:3], self.opacity)


class _Faces:
    """Faces of one group of an OBJ file: the rows of vertices, texture coordinates and normals of their corners."""

    def __init__(self) -> None:
        self.counts: list[int] = []
        self.rows: tuple[list[int], list[int], list[int]] = [], [], []

    def add(self, words: list[str], counts: tuple[int, int, int]) -> None:
        """Add a face of corners such as `7/3/1`, where so many vertices, coordinates and normals stand before it."""
        self.counts.append(len(words))
        for place, rows in enumerate(self.rows):
            rows += [_row(word, place, counts[place]) for word in words]


def _read_obj(path: Path, libraries: dict[Path, int]) -> Iterator[MeshPart]:
    vertices: list[list[str]] = []
    coordinates: list[list[str]] = []
    normals: list[list[str]] = []
    looks: dict[str, _Look] = {}
    groups: dict[tuple[str, str], _Faces] = {}
    name = material = ""
    text, total = read_text(path), 0
    most = min(MOST_TRIANGLES, MOST_SMALL + len(text) // TRIANGLE)
    for line in text.replace("\\\n", " ").splitlines():
        key, rest = (*line.split(None, 1), "", "")[:2]  # spaces and tabs, as in Gazebo
        if key == "v":
            vertices.append(rest.split())
        elif key == "vt":
            coordinates.append(rest.split())
        elif key == "vn":
            normals.append(rest.split())
        elif key in ("o", "g"):
            name = rest.strip()
        elif key == "usemtl":
            material = rest.strip()
        elif key == "mtllib":
            for library in map(Path.resolve, _libraries(path.parent, rest.strip())):  # each once, by whatever name
                if library not in libraries:
                    libraries[library] = _changed(library)
                    looks |= _read_mtl(library)
        elif key == "f":
            group = groups.setdefault((name, material), _Faces())
            words = rest.split(None, most + 2)
            total += max(len(words) - 2, 0)
            if total > most:  # before they are kept
                raise GazeboError(f"mesh {path} has more than {most} triangles")
            group.add(words, (len(vertices), len(coordinates), len(normals)))
    effort = Effort()
    # Each table once, for there may be as many groups as rows.
    points, table, directions = _positions(vertices), _texels(_table(coordinates, 2)), _directions(_table(normals, 3))
    for (name, material), faces in groups.items():
        look = looks.get(material)
        corners, texels, lit = (np.array(rows, dtype=np.int64) for rows in faces.rows)
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            raise ValueError(f"a triangle names a vertex that does not exist; there are {len(points)}")
        cut = cut_polygons(np.array(faces.counts), points[corners], effort=effort)
        image = NamedImage(look.image, look.file) if look is not None and look.image else None
        placed = _rows(table, texels[cut])
        texture = Texture(image, placed) if image is not None or (placed is not None and texels.max() >= 0) else None
        shading = _rows(directions, lit[cut])
        yield used(name, points, corners[cut], look.shown if look is not None else None, texture, shading)


def _positions(rows: list[list[str]]) -> Array:
    """Positions of vertices; a number that is missing or damaged is 0, as in Gazebo."""
    try:
        return np.array([row[:3] for row in rows], dtype=np.float64).reshape(-1, 3)
    except ValueError:
        return np.array([[_number(word) for word in (*row, "0", "0", "0")[:3]] for row in rows])


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return 0.0


def _table(rows: list[list[str]], columns: int) -> Array:
    """Rows of numbers, such as texture coordinates, shape (n, columns); none if one is damaged."""
    try:
        return np.array([row[:columns] for row in rows], dtype=np.float64).reshape(len(rows), columns)
    except ValueError:
        return np.empty((0, columns))


def _row(word: str, place: int, count: int) -> int:
    """The row of vertex (place 0), texture coordinates (1) or normal (2) of a corner `7/3/1`, of so many rows.

    It is -1 if the corner has none, -2 if the number is damaged.
    """
    words = word.split("/", 2)
    if len(words) <= place or not words[place]:
        return -1
    try:
        number = int(words[place])
    except ValueError:
        return -2
    row = number - 1 if number > 0 else count + number
    return row if 0 <= row < 2**31 else -2


def _libraries(folder: Path, names: str) -> list[Path]:
    """The material libraries of a line: one, whose name may have spaces, or several."""
    whole = folder / names
    return [whole] if is_file(whole) else [folder / name for name in names.split()]


def _read_mtl(path: Path) -> dict[str, _Look]:
    """Diffuse colours, opacities and images by material; none if there is no such file.

    Raises:
        GazeboError: it cannot be read.
    """
    if not is_file(path):
        return {}
    name, found = "", dict[str, _Look]()
    try:
        text = read_text(path)
    except OSError as error:
        raise GazeboError(f"material library {path} cannot be read: {error.strerror}") from None
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.split()
        if words[:1] == ["newmtl"]:
            name = " ".join(words[1:])
        elif words[:1] == ["Kd"] and words[1:2] not in (["spectral"], ["xyz"]):
            color = _color(words[1:4])
            if color is None:
                log.warning("material library %s:%d: %r is not Kd RED GREEN BLUE", path, number, line.strip()[:80])
            found.setdefault(name, _Look(path)).color = color
        elif words[:1] in (["d"], ["Tr"]) and _is_number(words[-1]):  # `d -halo 0.5`, too
            value = min(max(float(words[-1]), 0.0), 1.0)
            look = found.setdefault(name, _Look(path))
            if words[0] == "d":
                look.opacity, look.dissolved = value, True
            elif not look.dissolved:  # programs disagree about what Tr means
                look.opacity = 1.0 - value
        elif words and words[0].lower() == "map_kd":
            found.setdefault(name, _Look(path)).image = _image_name(line.strip()[len("map_Kd") :].strip())
    return found


def _color(words: list[str]) -> tuple[float, ...] | None:
    """An opaque colour of one number for each channel, or one for all; None if they are no finite numbers."""
    try:
        channels = [float(word) for word in words]
    except ValueError:
        return None
    usable = len(channels) in (1, 3) and all(map(math.isfinite, channels))
    return (*(channels * 3)[:3], 1.0) if usable else None


def _image_name(text: str) -> str:
    """The file of a map of a material library, without its options; its name may have spaces."""
    words = text.split() if text.startswith("-") else [text]
    while words[0] in MAP_OPTIONS and len(words) > 1:
        more = itertools.takewhile(_is_number, words[2 : 1 + MAP_OPTIONS[words[0]]])
        words = words[2 + len(list(more)) :] or [""]
    return " ".join(words)


def _is_number(word: str) -> bool:
    try:
        return math.isfinite(float(word))
    except ValueError:
        return False


def used(
    name: str,
    points: Array,
    triangles: NDArray[np.int64],
    color: tuple[float, ...] | None,
    texture: Texture | None = None,
    normals: Array | None = None,
) -> MeshPart:
    """A part with only the vertices that its triangles name."""
    if len(triangles) and not 0 <= triangles.min() <= triangles.max() < len(points):
        raise ValueError(f"a triangle names a vertex that does not exist; there are {len(points)}")
    kept, index = np.unique(triangles, return_inverse=True)
    return MeshPart(name, points[kept], np.array(index, dtype=np.int64).reshape(-1, 3), color, texture, normals)


# COLLADA ---------------------------------------------------------------------------------------------------------


def read_numbers(text: str | None, kind: Any = np.float64) -> NDArray[Any]:
    """The numbers of a list in a document.

    Raises:
        ValueError: it has something else.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy's before 2.3, of text that is no number
        try:
            return np.fromstring(text or "", dtype=kind, sep=" ")
        except DeprecationWarning as error:
            raise ValueError(str(error)) from None


@dataclass(eq=False, repr=False)
class _Effect:
    """The look of a COLLADA material.

    Attributes:
        color: diffuse; None if it has none.
        image: the file that it shows, as it is written; empty if it has none.
        coordinates: the symbol of its texture coordinates.
    """

    color: tuple[float, ...] | None = None
    image: str = ""
    coordinates: str | None = None


FACES = ("triangles", "polylist", "polygons", "tristrips", "trifans")


class Collada:
    """A COLLADA document. Its unit is honoured, its up axis is not: classic took coordinates as they are."""

    def __init__(self, path: Path) -> None:
        from lxml import etree

        parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True, remove_comments=True)
        try:
            with open_file(path) as file:
                self.root = etree.parse(file, parser).getroot()
                self._left = MOST_READ + TIMES_READ * os.fstat(file.fileno()).st_size  # characters to be read
        except etree.XMLSyntaxError as error:
            raise ValueError(error.msg) from None
        self.path = path
        self.nodes = 0  # visited, and geometries in them
        self.above: list[Any] = []  # the nodes that are being visited
        self.ids = {element.get("id"): element for element in self.root.iter(etree.Element) if "id" in element.attrib}
        self._effort = Effort()
        self._looks: dict[str, _Effect] = {}
        self._sizes: dict[Any, int] = {}  # of what references lead to
        self._found: dict[tuple[Any, ...], Any] = {}  # numbers that were read, or the error that reading them raised

    @staticmethod
    def tag(element: Any) -> str:
        """The name of an element."""
        return str(element.tag).rpartition("}")[2]

    def all(self, element: Any, name: str) -> list[Any]:
        """The children of a name."""
        return list(element.iterchildren(f"{{*}}{name}")) if element is not None else []

    def deep(self, element: Any, name: str) -> Iterator[Any]:
        """The element and all in it of a name."""
        found: Iterator[Any] = element.iter(f"{{*}}{name}")
        return found

    def target(self, url: str | None) -> Any:
        """The element that a reference names; it is read again for each reference.

        Raises:
            ValueError: there is none, or too much is read again and again.
        """
        name = (url or "").removeprefix("#")
        if name not in self.ids:
            raise ValueError(f"it refers to {url!r}, which does not exist" if url else "a reference is missing")
        found = self.ids[name]
        if found not in self._sizes:
            self._sizes[found] = sum(ELEMENT + len(element.text or "") for element in found.iter())
        self._left -= self._sizes[found]
        if self._left < 0:
            raise ValueError("its parts refer to each other so often that reading it takes too long")
        return found

    def once(self, read: Callable[..., Found], *what: Any) -> Found:
        """What `read` makes of a part of the document: read once, for what is instanced may be so often.

        Raises:
            ValueError, OverflowError, IndexError: it is damaged.
        """
        key = (read, *what)
        if key not in self._found:
            try:
                self._found[key] = read(*what)
            except (ValueError, OverflowError, IndexError) as error:
                self._found[key] = error
        found = self._found[key]
        if isinstance(found, Exception):
            found.__traceback__ = None  # it would grow each time
            raise found
        return found  # type: ignore[no-any-return]

    def first(self, elements: Iterable[Any], what: str) -> Any:
        """The first of several elements.

        Raises:
            ValueError: there is none.
        """
        found = next(iter(elements), None)
        if found is None:
            raise ValueError(f"{what} is missing")
        return found

    @functools.cached_property
    def unit(self) -> float:
        """The document's unit of length [m]."""
        unit = next(self.deep(self.root, "unit"), None)
        return float(unit.get("meter", "1")) if unit is not None else 1.0

    def parts(self) -> Iterator[MeshPart]:
        """The triangles of its scene."""
        scale = self.unit
        axis = next(self.deep(self.root, "up_axis"), None)
        if axis is not None and (axis.text or "").strip() not in ("Z_UP", ""):
            noted = "mesh %s has <up_axis>%s</up_axis>; its coordinates are taken as they are, as in Gazebo classic"
            log.warning(noted, self.path, (axis.text or "").strip())
        scene = self.scene()
        if scene is None:
            for geometry in self.deep(self.root, "geometry"):
                yield from self.geometry(geometry, "", scale * np.eye(4), {})
            return
        for node in self.all(scene, "node"):
            yield from self.node(node, np.diag([scale, scale, scale, 1.0]))

    def scene(self) -> Any:
        """The visual scene that `<scene>` names, else the first one; None if there is none."""
        scenes = list(self.deep(self.root, "visual_scene"))
        for instance in self.deep(self.root, "instance_visual_scene"):
            named = (instance.get("url") or "").removeprefix("#")
            return next((scene for scene in scenes if scene.get("id") == named), next(iter(scenes), None))
        return next(iter(scenes), None)

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
            bound = {m.get("symbol"): m for m in self.deep(instance, "instance_material")}
            yield from self.geometry(self.target(instance.get("url")), name, frame, bound)
        for instance in self.all(node, "instance_controller"):
            bound = {m.get("symbol"): m for m in self.deep(instance, "instance_material")}
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
            return read_numbers(matrix.text).reshape(4, 4)
        return np.eye(4)

    def steps(self, node: Any) -> list[tuple[str, str, Array]]:
        """A node's transformations in their order: (sid, kind, numbers)."""
        return [
            (child.get("sid", ""), self.tag(child), read_numbers(child.text))
            for child in node
            if self.tag(child) in ("matrix", "translate", "scale", "rotate")
        ]

    def transform(self, node: Any) -> Array:
        """The product of a node's transformations, in their order."""
        result = np.eye(4)
        for _, kind, numbers in self.steps(node):
            result = result @ step_matrix(kind, numbers)
        return result

    def geometry(self, geometry: Any, name: str, frame: Array, bound: dict[str, Any]) -> Iterator[MeshPart]:
        """The triangles of a geometry, by material; `bound` has the `<instance_material>` of each symbol."""
        for mesh in self.all(geometry, "mesh"):
            for group in self.groups(mesh):
                points, triangles, cut = self.primitive(group)
                material = bound.get(group.get("material"))
                look = self.look(material)
                texture = self.texture(material, group, cut)
                shading = self.normals(group, cut, frame)
                part = used(name or geometry.get("name", ""), points, triangles, look.color, texture, shading)
                part.vertices = part.vertices @ frame[:3, :3].T + frame[:3, 3]  # after others are left out
                yield part

    def groups(self, mesh: Any) -> Iterator[Any]:
        """The groups of faces of a mesh."""
        for kind in FACES:
            yield from self.all(mesh, kind)

    def normals(self, group: Any, cut: NDArray[np.int64], frame: Array) -> Array | None:
        """The normals of the corners of a group's triangles in a frame; None if it has none, or damaged ones."""
        if np.linalg.det(frame[:3, :3]) <= 0.0:
            return None  # mirrored: they would point against the order of the corners
        vertex = self.first(self.inputs(group, "VERTEX"), "an <input> of vertices")
        shared = (i for i in self.inputs(self.target(vertex.get("source")), "NORMAL"))
        own = next(iter(self.inputs(group, "NORMAL")), None)
        given = own if own is not None else next(shared, None)
        if given is None:
            return None
        try:
            corners = self.corners(group, own if own is not None else vertex)
            lit = _rows(self.rows(self.target(given.get("source")), 3), corners[cut])
            # Only those that are used: a geometry of one triangle may be instanced again and again.
            turned = _directions(lit.reshape(-1, 3) @ np.linalg.inv(frame[:3, :3])) if lit is not None else None
            return turned.reshape(-1, 3, 3) if turned is not None and len(turned) else None
        except (ValueError, OverflowError, IndexError):
            return None

    def primitive(self, group: Any) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        """(positions, triangles, the corners of the group that those of the triangles are) of one group of faces."""
        return self.once(self._primitive, group)

    def _primitive(self, group: Any) -> tuple[Array, NDArray[np.int64], NDArray[np.int64]]:
        vertex = self.first(self.inputs(group, "VERTEX"), "an <input> of vertices")
        given = self.all(self.target(vertex.get("source")), "input")
        positions = self.first((i for i in given if i.get("semantic") == "POSITION"), "an <input> of positions")
        points = self.rows(self.target(positions.get("source")), 3)
        corners = self.corners(group, vertex)
        if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
            raise ValueError(f"a triangle names a vertex that does not exist; there are {len(points)}")
        cut = self.cut(group, points, corners)
        return points, corners[cut], cut

    def inputs(self, group: Any, semantic: str) -> list[Any]:
        """What a group of faces numbers, of one meaning."""
        return [i for i in self.all(group, "input") if i.get("semantic") == semantic]

    def runs(self, group: Any) -> list[NDArray[np.int64]]:
        """The numbers of a group of faces, of each `<p>`, and of each hole (`<h>`) in a polygon."""
        return [read_numbers(p.text, np.int64) for p in group.iter("{*}p", "{*}h")]

    def stride(self, group: Any) -> int:
        """How many numbers a corner of a group has."""
        return 1 + max(int(i.get("offset", "0")) for i in self.all(group, "input"))

    def corners(self, group: Any, wanted: Any) -> NDArray[np.int64]:
        """The numbers of one input for all corners of a group, in their order."""
        return self.once(self._corners, group, wanted)

    def _corners(self, group: Any, wanted: Any) -> NDArray[np.int64]:
        stride, offset = self.stride(group), int(wanted.get("offset", "0"))
        found = [run[offset::stride] for run in self.runs(group)]
        return np.concatenate(found) if found else np.zeros(0, dtype=np.int64)

    def cut(self, group: Any, points: Array, corners: NDArray[np.int64]) -> NDArray[np.int64]:
        """The triangles of a group by its corners, shape (m, 3)."""
        kind = self.tag(group)
        if kind == "triangles":
            return np.arange(len(corners) // 3 * 3).reshape(-1, 3)
        if kind == "polylist":
            counts = read_numbers(self.first(self.deep(group, "vcount"), "<vcount>").text, np.int64)
            return cut_polygons(counts, points[corners], effort=self._effort)
        stride = self.stride(group)
        counts = np.array([-(-len(run) // stride) for run in self.runs(group)], dtype=np.int64)
        if kind == "polygons":
            holes = np.array([self.tag(run) == "h" for run in group.iter("{*}p", "{*}h")], dtype=bool)
            return cut_polygons(counts, points[corners], holes, self._effort)
        return cut_strips(counts) if kind == "tristrips" else cut_fans(counts)

    def texture(self, material: Any, group: Any, cut: NDArray[np.int64]) -> Texture | None:
        """The image of a group, whose `<instance_material>` is given, and where it shows; None if it has neither."""
        look = self.look(material)
        try:
            chosen = self.coordinate_input(material, group, look.coordinates)
            corners = self.corners(group, chosen)
            coordinates = _rows(self.once(self._coordinates, self.target(chosen.get("source"))), corners[cut])
        except (ValueError, OverflowError, IndexError):
            coordinates = None
        image = NamedImage(look.image, self.path) if look.image else None
        return Texture(image, coordinates) if image is not None or coordinates is not None else None

    def coordinate_input(self, material: Any, group: Any, symbol: str | None) -> Any:
        """The texture coordinates of a group that an `<instance_material>` binds to a symbol; else its first ones.

        Raises:
            ValueError: the group has none.
        """
        bound = [
            bind.get("input_set", "0")
            for bind in self.all(material, "bind_vertex_input")
            if bind.get("semantic") == symbol and bind.get("input_semantic") == "TEXCOORD"
        ]
        inputs = self.inputs(group, "TEXCOORD")
        chosen = [i for i in inputs if i.get("set", "0") in bound] or inputs
        return self.first(chosen, "an <input> of texture coordinates")

    def rows(self, source: Any, columns: int = 2) -> Array:
        """The first numbers of each row of a source.

        Raises:
            ValueError: they are damaged.
        """
        return self.once(self._rows, source, columns)

    def _rows(self, source: Any, columns: int) -> Array:
        array = self.first(self.deep(source, "float_array"), "<float_array>")
        numbers = read_numbers(array.text)
        accessor = next(self.deep(source, "accessor"), None)
        stride = int(accessor.get("stride", "1")) if accessor is not None else columns
        if columns == 3:
            stride = max(stride, 3)  # positions and normals have three, whatever the accessor says
        if stride < columns:
            raise ValueError(f"rows of {columns} numbers have a stride of {stride}")
        return numbers[: len(numbers) // stride * stride].reshape(-1, stride)[:, :columns]

    def _coordinates(self, source: Any) -> Array:
        return _texels(self.rows(source))

    def look(self, material: Any) -> _Effect:
        """What the material of an `<instance_material>` looks like; nothing is set without one."""
        name = material.get("target", "") if material is not None else ""
        if name not in self._looks:
            self._looks[name] = self._effect(name) if name else _Effect()
        return self._looks[name]

    def _effect(self, material: str) -> _Effect:
        found = _Effect()
        for instance in self.all(self.target(material), "instance_effect"):
            effect = self.target(instance.get("url"))
            for diffuse in self.deep(effect, "diffuse"):
                for color in self.all(diffuse, "color"):
                    values = tuple(float(word) for word in (color.text or "").split())
                    usable = len(values) == 4 and all(map(math.isfinite, values))
                    found.color = found.color or (values if usable else None)
                for texture in self.all(diffuse, "texture") if not found.image else ():
                    found.image, found.coordinates = self.image(effect, texture), texture.get("texcoord")
            opacity = self.opacity(effect)
            if opacity < 1.0:
                r, g, b, alpha = found.color or (1.0, 1.0, 1.0, 1.0)
                found.color = (r, g, b, alpha * opacity)
        return found

    def opacity(self, effect: Any) -> float:
        """How opaque an effect is, 0 to 1: by `<transparent>` times `<transparency>`.

        As in Gazebo, an effect is opaque that does not say how its numbers are meant, by `opaque`: some programs write
        the opposite of what others do.
        """
        transparent = next(self.deep(effect, "transparent"), None)
        mode = transparent.get("opaque", "") if transparent is not None else ""
        color = next(iter(self.all(transparent, "color")), None) if mode else None
        if mode not in ("A_ONE", "A_ZERO", "RGB_ONE", "RGB_ZERO") or color is None:
            return 1.0
        factor = next((f for t in self.deep(effect, "transparency") for f in self.all(t, "float")), None)
        values = [float(word) for word in (color.text or "").split()]
        if not 3 <= len(values) <= 4:
            return 1.0
        by_alpha = mode.startswith("A")
        share = [*values, 1.0][3] if by_alpha else float(np.dot(LUMINANCE, values[:3]))
        share *= float(factor.text or "1") if factor is not None else 1.0
        share = min(max(share, 0.0), 1.0) if math.isfinite(share) else float(mode.endswith("ONE"))
        return share if mode.endswith("ONE") else 1.0 - share

    def image(self, effect: Any, texture: Any) -> str:
        """The file that a `<texture>` names, by sampler and surface or directly; empty if there is none."""
        parameters = {p.get("sid"): p for p in self.deep(effect, "newparam")}
        name = texture.get("texture", "")
        for _ in range(2):  # sampler, then surface
            if name not in parameters:
                break
            inner = [e for e in parameters[name].iter() if self.tag(e) in ("source", "init_from", "instance_image")]
            if not inner:
                return ""
            name = (inner[0].get("url") or "").removeprefix("#") or (inner[0].text or "").strip()
        found = self.ids.get(name)
        if found is None or self.tag(found) != "image":
            return ""
        written = next(self.deep(found, "init_from"), None)
        if written is None:
            return ""
        return next((e.text or "" for e in self.deep(written, "ref")), written.text or "").strip()


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
