"""Assets: the files that a scene names, as pages load them: arrays, textures, skins; addresses name their content."""

from __future__ import annotations

import functools
import gzip
import hashlib
import io
import json
import logging
import os
import struct
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.base.files import open_file
from libgz.rendering.mesh import Mesh
from libgz.view.source import Source

__all__ = ["Asset", "Assets"]

log = logging.getLogger("libgz.view")

LARGEST_TEXTURE = 1024  # [px]
OPAQUE = 255  # alpha
JPEG, PNG, GLB, RAW = "image/jpeg", "image/png", "model/gltf-binary", "application/octet-stream"
FLOAT, UINT = 5126, 5125  # glTF's numbers of types
ARRAY, ELEMENTS = 34962, 34963  # and of buffers
PLAIN = (0.8, 0.8, 0.8, 1.0)
BEST, FASTEST, LARGE = 6, 1, 1 << 20  # levels of compression, and from how many bytes on the second one is taken


@dataclass(frozen=True)
class Asset:
    """What a page loads.

    Attributes:
        body: the bytes.
        kind: their media type.
    """

    body: bytes
    kind: str

    @functools.cached_property
    def packed(self) -> bytes:
        """The bytes, compressed: the same for all pages."""
        return gzip.compress(self.body, BEST if len(self.body) < LARGE else FASTEST)


class Assets:
    """Finds what the scenes of a source name. Files are converted when a page first asks for them.

    Args:
        source: of the arrays.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._addresses: dict[str, str] = {}  # of files
        self._stamps: dict[str, tuple[int, int]] = {}
        self._makers: dict[str, Callable[[], Asset]] = {}
        self._made: dict[str, Asset | None] = {}  # None: its file cannot be read
        self._lock = threading.Lock()

    def clear(self) -> None:
        """Forget the arrays of another run, whose files may have the same names."""
        with self._lock:
            self._addresses, self._stamps, self._makers, self._made = {}, {}, {}, {}

    def of_scene(self, scene: dict[str, Any]) -> dict[str, str]:
        """The addresses of the files that a scene names, as far as they exist."""
        found: dict[str, str] = {}
        for kind, reference in _references(scene):
            file = reference["file"]
            if file in found:
                continue
            address = self._address(kind, reference)
            if address:
                found[file] = address
        with self._lock:
            present = set(found.values())
            self._makers = {name: make for name, make in self._makers.items() if name in present}
            self._made = {name: asset for name, asset in self._made.items() if name in present}
        return found

    def _address(self, kind: str, reference: dict[str, Any]) -> str:
        """The address of a file; empty if there is nothing."""
        file = reference["file"]
        try:
            if kind == "data":
                name = self._addresses.get(file, "")
                if not name or name not in self._makers:
                    body = _packed(reference, self._source.data(reference))
                    name = f"assets/{_digest(body)}.bin"
                    self._keep(file, name, lambda: Asset(body, RAW))
                return name
            with open_file(file) as opened:
                status = os.fstat(opened.fileno())
                stamp = status.st_mtime_ns, status.st_size
                name = self._addresses.get(file, "")
                if not name or name not in self._makers or self._stamps.get(file) != stamp:
                    self._stamps[file] = stamp
                    if kind == "texture":
                        name = f"assets/{hashlib.file_digest(opened, 'sha256').hexdigest()[:40]}.image"
                        self._keep(file, name, lambda: _texture(Path(file)))
                    else:
                        name = f"assets/{_digest(f'{file} {stamp}'.encode())}.glb"
                        self._keep(file, name, lambda: _skin(Path(file)))
            return name
        except (GazeboError, OSError) as error:
            if self._addresses.get(file) != "":
                log.warning("%s", error)
            self._addresses[file] = ""
            return ""

    def _keep(self, file: str, name: str, make: Callable[[], Asset]) -> None:
        with self._lock:
            self._addresses[file] = name
            self._makers[name] = make

    def get(self, name: str) -> Asset | None:
        """An asset by its address; None if there is none, or its file cannot be read. Safe in every thread."""
        with self._lock:
            make = self._makers.get(name)
            if make is None or name in self._made:
                return self._made.get(name)
        made = None
        try:
            made = make()
        except (GazeboError, OSError, ValueError) as error:
            log.warning("%s; it is not shown", error)
        with self._lock:
            if name in self._makers:
                self._made[name] = made
        return made


def _references(scene: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The kind of each file that a scene names, and what it says of it."""
    bodies = [body for entity in scene["entities"] for body in entity["bodies"]]
    for body in (*bodies, *scene["others"]):
        for shape in body["shapes"]:
            if shape.get("data"):
                yield "data", shape["data"]
            if shape.get("bones"):
                yield "data", shape["bones"]["data"]
            if shape.get("texture"):
                yield "texture", shape["texture"]
            for file in (shape.get("pbr") or {}).values():
                if isinstance(file, str) and file:
                    yield "texture", {"file": file}
            if shape.get("skin"):
                yield "skin", shape["skin"]
            if shape.get("hidden_by_skin"):
                yield "skin", {"file": shape["hidden_by_skin"]}
    for entity in scene["entities"]:
        for sensor in entity["sensors"]:
            if sensor.get("data"):
                yield "data", sensor["data"]
    if scene.get("sky"):
        yield "texture", {"file": scene["sky"]["texture"]}


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:40]


def _packed(reference: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> bytes:
    """Arrays at the places that their reference says."""
    parts = reference["arrays"]
    places = {
        name: (int(part["offset"]), np.ascontiguousarray(arrays[name], part["type"])) for name, part in parts.items()
    }
    body = bytearray(max((offset + array.nbytes for offset, array in places.values()), default=0))
    for offset, array in places.values():
        body[offset : offset + array.nbytes] = array.tobytes()
    return bytes(body)


def _texture(path: Path) -> Asset:
    """An image, reduced to what a page needs.

    Raises:
        GazeboError: the file cannot be read.
    """
    from PIL import Image

    from libgz.rendering.image import read_image

    pixels = read_image(path, alpha=True)
    image = Image.fromarray(pixels)
    image.thumbnail((LARGEST_TEXTURE, LARGEST_TEXTURE))
    file = io.BytesIO()
    if pixels[..., 3].min() < OPAQUE:
        image.save(file, "png")
        return Asset(file.getvalue(), PNG)
    image.convert("RGB").save(file, "jpeg", quality=90)
    return Asset(file.getvalue(), JPEG)


def _skin(path: Path) -> Asset:
    """A mesh as GLB.

    Raises:
        GazeboError: the file cannot be read.
    """
    from libgz.rendering.skin import read_skin

    return Asset(glb(read_skin(path)), GLB)


def glb(meshes: list[Mesh]) -> bytes:
    """Meshes as binary glTF, one primitive for all of the same colour. z stays up."""
    merged: dict[tuple[float, ...], list[Mesh]] = {}
    for part in meshes:
        color = tuple(float(c) for c in part.material.diffuse[:4]) if part.material is not None else PLAIN
        merged.setdefault(color, []).append(part)
    buffers = bytearray()
    views: list[Any] = []
    accessors: list[Any] = []
    primitives: list[Any] = []
    materials: list[Any] = []

    def add(array: NDArray[Any], kind: str, target: int) -> int:
        views.append({"buffer": 0, "byteOffset": len(buffers), "byteLength": array.nbytes, "target": target})
        accessor = {
            "bufferView": len(views) - 1,
            "componentType": FLOAT if array.dtype == np.float32 else UINT,
            "count": len(array),
            "type": kind,
        }
        if kind == "VEC3":
            accessor |= {"min": array.min(axis=0).tolist(), "max": array.max(axis=0).tolist()}
        accessors.append(accessor)
        buffers.extend(array.tobytes())
        return len(accessors) - 1

    for color, parts in merged.items():
        vertices, normals, faces, count = [], [], [], 0
        for part in parts:
            points = np.asarray(part.vertices, np.float32)
            order = np.arange(len(points)) if part.indices is None else np.asarray(part.indices).ravel()
            faces.append(order.astype(np.uint32) + np.uint32(count))
            vertices.append(points)
            normals.append(part.normals)
            count += len(points)
        if not count:
            continue
        attributes = {"POSITION": add(np.concatenate(vertices), "VEC3", ARRAY)}
        if all(one is not None for one in normals):
            attributes["NORMAL"] = add(np.concatenate(normals).astype(np.float32), "VEC3", ARRAY)  # type: ignore[arg-type]
        primitives.append(
            {
                "attributes": attributes,
                "indices": add(np.concatenate(faces), "SCALAR", ELEMENTS),
                "material": len(materials),
            }
        )
        linear = [((c + 0.055) / 1.055) ** 2.4 if c > 0.04045 else c / 12.92 for c in color[:3]]  # from sRGB
        opacity = color[3] if len(color) > 3 else 1.0
        materials.append(
            {
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*linear, opacity],
                    "metallicFactor": 0.0,
                    "roughnessFactor": 0.6,
                },
                "doubleSided": True,
            }
            | ({"alphaMode": "BLEND"} if opacity < 1.0 else {})
        )
    if not primitives:
        raise GazeboError("the mesh has no triangles")
    content = {
        "asset": {"version": "2.0", "generator": "libgz"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": primitives}],
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(buffers)}],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(buffers)
    head = struct.pack("<4s2I", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text
    return head + struct.pack("<I4s", len(buffers), b"BIN\0") + bytes(buffers)
