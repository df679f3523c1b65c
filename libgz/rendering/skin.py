"""Skins: meshes from files, rendered in place of a geom's own shape."""

from __future__ import annotations

import functools
import itertools
import logging
import re
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.base.files import read_limited
from libgz.physics.mesh_files import LARGEST_FILE, trimesh_parts
from libgz.rendering import mesh
from libgz.rendering.mesh import Material, Mesh

__all__ = ["read_skin"]

log = logging.getLogger("libgz.rendering")

# Chunks of a 3DS file: an id, a length that counts the 6 bytes of both, data, chunks inside.
MAIN, EDITOR, OBJECT, TRIMESH = 0x4D4D, 0x3D3D, 0x4000, 0x4100
VERTICES, FACES, FACE_MATERIAL = 0x4110, 0x4120, 0x4130
MATERIAL, MATERIAL_NAME, DIFFUSE, SPECULAR, SHININESS = 0xAFFF, 0xA000, 0xA020, 0xA030, 0xA040
# An object's head: its chunk's length, its name, and the chunk inside that says what it is.
OBJECT_HEAD = re.compile(rb"(?=\x00\x40(.{4})[^\0]{0,63}\0\x00[\x41\x46\x47].{4})", re.DOTALL)
VERTICES_HEAD = re.compile(rb"\x10\x41.{4}", re.DOTALL)
FACES_HEAD = re.compile(rb"\x20\x41.{4}", re.DOTALL)
LARGEST = np.float32(1e9)  # a coordinate beyond is no coordinate
LEAST_SHARE = 0.5  # of its faces that a damaged file must still give
FLOAT_COLORS, BYTE_COLORS, PERCENTS = (0x0010, 0x0013), (0x0011, 0x0012), (0x0030,)


def read_skin(path: Path) -> list[Mesh]:
    """The meshes of a file: 3DS by the reader below, other formats by the package trimesh.

    A damaged 3DS file gives the parts that can be read, with one warning.

    Raises:
        GazeboError: nothing can be read from it.
    """
    if path.suffix.lower() == ".3ds":
        return _read_3ds(path)
    return _read_by_trimesh(path)


def _read_by_trimesh(path: Path) -> list[Mesh]:
    found = []
    for part in trimesh_parts(path, "skin"):
        color = np.asarray(getattr(part.visual, "main_color", (204, 204, 204, 255)), dtype=float) / 255.0
        material = Material(diffuse=tuple(color.tolist()))
        found.append(_part(part.vertices, part.faces, material))
    if not found:
        raise GazeboError(f"skin {path} holds no triangles")
    return found


def _part(vertices: NDArray[Any], faces: NDArray[Any], material: Material) -> Mesh:
    shape = mesh.triangles(vertices, faces)
    return Mesh(shape.vertices, shape.normals, material=material, two_sided=True)


@dataclass(eq=False, repr=False)
class _Object:
    vertices: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 3), np.float32))
    faces: NDArray[np.uint16] = field(default_factory=lambda: np.zeros((0, 3), np.uint16))
    groups: list[tuple[str, NDArray[np.uint16]]] = field(default_factory=list)


class _Damaged(Exception):
    pass


@dataclass(eq=False, repr=False)
class _Reader3DS:
    data: bytes
    materials: dict[str, Material] = field(default_factory=dict)
    objects: list[_Object] = field(default_factory=list)
    damage: str = ""  # the first found
    end: int = 0  # where the objects end by the lengths in the file

    def chunks(self, start: int, end: int) -> Iterator[tuple[int, int, int]]:
        """(id, begin of data, end) of each chunk in a stretch of the file.

        Raises:
            _Damaged: a length is impossible.
        """
        while start + 6 <= end:
            kind, length = struct.unpack_from("<HI", self.data, start)
            if length >= 6:
                yield kind, start + 6, min(start + length, end)  # a truncated one may contain complete ones
            if length < 6 or start + length > end:
                raise _Damaged(f"chunk {kind:#06x} at byte {start} claims {length} bytes of {end - start}")
            start += length

    def text(self, start: int, end: int) -> tuple[str, int]:
        """A text that ends with a zero byte, and where the next thing begins."""
        stop = self.data.find(b"\0", start, end)
        if stop < 0:
            raise _Damaged(f"the name at byte {start} has no end")
        return self.data[start:stop].decode("latin-1"), stop + 1

    def array(self, kind: str, start: int, end: int, columns: int) -> NDArray[Any]:
        """A count and that number of rows."""
        if start + 2 > end:
            raise _Damaged(f"the count at byte {start} is missing")
        count = int(np.frombuffer(self.data, "<u2", 1, start)[0])
        fitting = (end - start - 2) // (np.dtype(kind).itemsize * columns)
        if count > fitting:
            self.note(f"{count} rows at byte {start} do not fit into their chunk")
            count = fitting
        return np.frombuffer(self.data, kind, columns * count, start + 2).reshape(count, columns)

    def shown(self) -> int:
        """How many of the triangles that were read have valid corners."""
        return sum(int((item.faces < len(item.vertices)).all(axis=1).sum()) for item in self.objects)

    def note(self, damage: object) -> None:
        """Remember the first damage."""
        self.damage = self.damage or str(damage)

    def read(self) -> None:
        """Read the whole file; damage in one material or object loses the rest of that one only.

        Raises:
            _Damaged: the rest of the file cannot be read; what came before is kept.
        """
        kind, length = struct.unpack_from("<HI", self.data) if len(self.data) >= 6 else (0, 0)
        if kind != MAIN:
            raise _Damaged("it does not start like a 3DS file")
        for kind, start, end in self.chunks(6, max(6, min(length, len(self.data)))):
            if kind == EDITOR:
                self.end = min(length, start - 6 + int(struct.unpack_from("<I", self.data, start - 4)[0]))
                for inner, first, last in self.chunks(start, end):
                    part = {MATERIAL: self.material, OBJECT: self.object}.get(inner)
                    if part is not None:
                        self.attempt(part, first, last)
        if length > len(self.data):
            raise _Damaged(f"{length - len(self.data)} bytes are missing at its end")

    # Damaged files ---------------------------------------------------------------------------------------------------

    def recover(self) -> None:
        """Read the objects again, each from its head to the next one's, wherever that is.

        Where bytes are missing, nothing behind them lies where lengths say. An object without its own bytes is kept
        if its triangles are whole, and left out if not.
        """
        self.objects = []
        heads = [match.start() for match in OBJECT_HEAD.finditer(self.data)]
        for start, following in itertools.pairwise([*heads, len(self.data)]):
            end = start + int(struct.unpack_from("<I", self.data, start + 2)[0])
            before = len(self.objects)
            if end <= following or following == len(self.data):
                self.attempt(self.object, start + 6, min(end, following))
            if len(self.objects) == before or end > following:
                del self.objects[before:]
                self._recover_object(start + 6, following)

    def _recover_object(self, start: int, end: int) -> None:
        """Take an object from which bytes are missing, if its vertices and triangles are whole."""
        for vertices, _ in self._tables(VERTICES_HEAD, "<f4", 3, start, end):
            if not (np.abs(vertices) < LARGEST).all():  # NaN is not, either
                continue
            for rows, place in self._tables(FACES_HEAD, "<u2", 4, start, end):
                if len(rows) and rows[:, :3].max() < len(vertices):
                    found = _Object(vertices, rows[:, :3])
                    self.objects.append(found)
                    self.attempt(functools.partial(self.face_materials, found), place, end)
                    return

    def _tables(
        self, head: re.Pattern[bytes], kind: str, columns: int, start: int, end: int
    ) -> Iterator[tuple[NDArray[Any], int]]:
        """(rows, where they end) of what looks like a chunk of rows."""
        for match in head.finditer(self.data, start, max(start, end - 2)):
            length, count = struct.unpack_from("<IH", self.data, match.start() + 2)
            size = np.dtype(kind).itemsize * columns * count
            first = match.start() + 8
            if size and length >= 8 + size and first + size <= end:
                yield np.frombuffer(self.data, kind, columns * count, first).reshape(count, columns), first + size

    def face_count(self) -> int:
        """How many faces the file has: those of all tables that can be found, whether they are whole or not, and where
        bytes are missing, as many for each as the other objects have.
        """
        total, place, end = 0, 0, 0
        while (match := FACES_HEAD.search(self.data, place, max(place, len(self.data) - 2))) is not None:
            length, count = struct.unpack_from("<IH", self.data, match.start() + 2)
            place, rows = match.start(), 8 * count
            if 8 + rows <= length <= max(self.end, len(self.data)):
                total, end = total + count, place + length
                place += 7 + rows
            place += 1
        first = OBJECT_HEAD.search(self.data)
        if first is None or self.end <= len(self.data):
            return total
        return total + round(total * max(0, self.end - end) / max(1, end - first.start()))

    def attempt(self, part: Callable[[int, int], None], start: int, end: int) -> None:
        """Read one part; if it is damaged, note that and continue."""
        try:
            part(start, end)
        except _Damaged as error:
            self.note(error)

    def material(self, start: int, end: int) -> None:
        """Read one material."""
        name, colors, shininess = "", {DIFFUSE: (0.8, 0.8, 0.8), SPECULAR: (0.0, 0.0, 0.0)}, 0.0
        for kind, first, last in self.chunks(start, end):
            if kind == MATERIAL_NAME:
                name = self.text(first, last)[0]
            elif kind in colors:
                colors[kind] = self.color(first, last, colors[kind])
            elif kind == SHININESS:
                for inner, begin, stop in self.chunks(first, last):
                    if inner in PERCENTS and begin + 2 <= stop:
                        shininess = 1.28 * min(100, struct.unpack_from("<H", self.data, begin)[0])
        self.materials[name] = Material((*colors[DIFFUSE], 1.0), (*colors[SPECULAR], 1.0), shininess=shininess)

    def color(self, start: int, end: int, default: tuple[float, float, float]) -> tuple[float, float, float]:
        """The colour inside a chunk."""
        for kind, first, last in self.chunks(start, end):
            if kind in FLOAT_COLORS and first + 12 <= last:
                r, g, b = struct.unpack_from("<3f", self.data, first)
                return r, g, b
            if kind in BYTE_COLORS and first + 3 <= last:
                r, g, b = self.data[first : first + 3]
                return r / 255.0, g / 255.0, b / 255.0
        return default

    def object(self, start: int, end: int) -> None:
        """Read one object, if it is a mesh."""
        _, first = self.text(start, end)
        for kind, begin, stop in self.chunks(first, end):
            if kind == TRIMESH:
                found = _Object()
                self.objects.append(found)
                for inner, inner_begin, inner_stop in self.chunks(begin, stop):
                    if inner == VERTICES:
                        found.vertices = self.array("<f4", inner_begin, inner_stop, 3)
                    elif inner == FACES:
                        self.faces(found, inner_begin, inner_stop)

    def faces(self, found: _Object, start: int, end: int) -> None:
        """Read the triangles of an object and their materials."""
        rows = self.array("<u2", start, end, 4)
        found.faces = rows[:, :3]
        self.face_materials(found, start + 2 + rows.nbytes, end)

    def face_materials(self, found: _Object, start: int, end: int) -> None:
        """Read which triangles have which material."""
        for kind, first, last in self.chunks(start, end):
            if kind == FACE_MATERIAL:
                name, members = self.text(first, last)
                found.groups.append((name, self.array("<u2", members, last, 1).ravel()))


def _read_3ds(path: Path) -> list[Mesh]:
    try:
        reader = _Reader3DS(read_limited(path, LARGEST_FILE))
    except OSError as error:
        raise GazeboError(f"skin {path} cannot be read: {error.strerror}") from None
    try:
        reader.read()
    except _Damaged as error:
        reader.note(error)
    before, shown = reader.objects, reader.shown()
    if reader.damage:
        reader.recover()
        if reader.shown() < shown:
            reader.objects = before
    count, shown = reader.face_count() if reader.damage else 0, reader.shown()
    if 0 < shown < LEAST_SHARE * count:
        raise GazeboError(f"skin {path} is damaged ({reader.damage}): only {shown} of its {count} faces can be read")
    found = [part for item in reader.objects for part in _parts(item, reader.materials)]
    if not found:
        raise GazeboError(f"skin {path} cannot be read: {reader.damage or 'it holds no triangles'}")
    if reader.damage:
        log.warning("skin %s is damaged (%s); %d of %d faces are shown", path, reader.damage, shown, max(count, shown))
    return found


def _parts(item: _Object, materials: dict[str, Material]) -> Iterator[Mesh]:
    """One mesh for each material of an object; triangles with invalid corners are skipped."""
    rest = np.ones(len(item.faces), dtype=bool)
    groups = []
    for name, members in item.groups:
        inside = members[members < len(item.faces)]
        rest[inside] = False
        groups.append((materials.get(name, Material()), item.faces[inside]))
    groups.append((Material(), item.faces[rest]))
    sane = np.where(np.isfinite(item.vertices), item.vertices, 0.0)
    for material, faces in groups:
        good = faces[(faces < len(sane)).all(axis=1)] if len(faces) else faces
        if len(good):
            yield _part(sane, good, material)
