"""Shapes: the parts of a scene as meshes for the page. Shapes of one form are instances of one mesh."""

from __future__ import annotations

import importlib
import io
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from libgz.base.errors import GazeboError
from libgz.physics.appearance import SAME
from libgz.rendering import mesh
from libgz.rendering.dome import dome_mesh
from libgz.rendering.image import read_image
from libgz.rendering.mesh import Mesh
from libgz.rendering.skin import read_skin
from libgz.view.source import Source

__all__ = ["Form", "Instance", "Shapes", "compose", "extent_corners"]

log = logging.getLogger("libgz.view")

trimesh: Any = importlib.import_module("trimesh")  # its functions have no types

SEGMENTS = 28  # of a full turn
PLANE = 2000.0  # [m] side of what stands for an infinite plane
LARGEST_TEXTURE = 1024  # [px]
SKY = 900.0  # [m] radius of the sky
BRIGHTEST = 235  # of 255: white surfaces get brighter in light
SMOOTH = ("mesh", "heightfield", "skin")  # shown with normals of their own
NOT_SHOWN = ("light", "frustum", "ray", "dome", "other")


@dataclass(frozen=True)
class Form:
    """A mesh, with what all of its instances have in common.

    Attributes:
        key: distinguishes it from others.
        vertices, faces: shape (n, 3); plain forms take the colours of their instances.
        glb: the whole of one with a texture or colours of its own; None for a plain form.
        clear: whether instances can be seen through.
        both: whether it is visible from both sides.
    """

    key: tuple[Any, ...]
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    glb: bytes | None = None
    clear: bool = False
    both: bool = False


@dataclass(frozen=True)
class Instance:
    """One place where a form is shown.

    Attributes:
        form: of it.
        pose: in the frame of its body: position [m] and quaternion (u, x, y, z).
        scale: along the form's axes.
        color: 0 to 255.
        opacity: 0 to 1.
        extent: smallest and largest corner of it in its own frame [m], shape (2, 3).
    """

    form: Form
    pose: tuple[float, ...]
    scale: tuple[float, float, float]
    color: tuple[int, int, int]
    opacity: float
    extent: NDArray[np.float64]


class Shapes:
    """Makes instances of the scene's shapes. Files that cannot be read are named in one warning each.

    Args:
        source: of the meshes' arrays.
    """

    def __init__(self, source: Source) -> None:
        self._source = source
        self._forms: dict[tuple[Any, ...], list[Form]] = {}
        self._images: dict[str, Image.Image | None] = {}
        self._skins: dict[str, list[Mesh]] = {}

    def clear(self) -> None:
        """Forget the forms of another run, whose files may have the same names."""
        self._forms.clear()

    def instances(self, shape: dict[str, Any], collisions: bool = False) -> Iterator[Instance]:
        """What a shape of the scene looks like; `collisions`: what collides, instead of what is visible."""
        shown = shape["collides"] if collisions else shape["visible"]
        if not shown or shape["kind"] in NOT_SHOWN:
            return
        material, pose = shape["material"], tuple(shape["pose"])
        scale: Any = tuple(float(factor) for factor in shape["scale"])
        skin = shape["skin"]
        if not collisions and shape["hidden_by_skins"]:
            other = shape["hidden_by_skin"]
            if other is None or self._skin(other):
                return
        forms: list[Form] = []
        if skin is not None and not collisions:
            forms = self._skin_forms(skin["file"])
            if forms:
                pose, scale = _compose(pose, tuple(skin["pose"])), tuple(skin["scale"])
        if not forms:
            forms, scale = self._own_forms(shape, scale)
        color = _bytes(material["diffuse"], material["emission"])
        for form in forms:
            low, high = form.vertices.min(axis=0), form.vertices.max(axis=0)
            ends = np.array((low, high), dtype=float) * scale
            own = form.key[-1] if form.key[0] == "skin" else color
            yield Instance(form, pose, scale, own, float(material["opacity"]), np.sort(ends, axis=0))

    def sky(self, scene: dict[str, Any]) -> bytes | None:
        """The sky as a dome around everything; None if the scene has none, or its image cannot be read."""
        sky = scene["sky"]
        image = self._image(sky["texture"]) if sky is not None else None
        if image is None:
            return None
        dome, strip = dome_mesh(), _strip(image, sky)
        faces = np.asarray(dome.indices).reshape(-1, 3)
        return _shining(dome.vertices, np.concatenate([faces, faces[:, ::-1]]), np.asarray(dome.texcoords)[:, 1], strip)

    def horizon(self, scene: dict[str, Any]) -> NDArray[np.float64] | None:
        """The colour of the sky at the horizon, 0 to 1; None if the scene has no sky."""
        sky = scene["sky"]
        image = self._image(sky["texture"]) if sky is not None else None
        return None if image is None else np.asarray(_strip(image, sky), dtype=float)[-1, 0] / 255.0

    # Forms -----------------------------------------------------------------------------------------------------------

    def _own_forms(self, shape: dict[str, Any], scale: tuple[float, ...]) -> tuple[list[Form], Any]:
        """The forms of a shape, and how they are stretched."""
        material, texture = shape["material"], shape["texture"]
        key, factor = _key(shape)
        stretched = tuple(float(a * b) for a, b in zip(factor, scale, strict=True))
        clear = material["opacity"] < 1.0
        image = self._image(texture["file"]) if texture is not None else self._own_image(shape)
        look: tuple[Any, ...] = ()
        if image is not None and texture is not None:
            look = (texture["file"], tuple(texture["size"]), _matrix(texture), tuple(material["diffuse"]))
        if not look and key[0] in SMOOTH:
            look = (tuple(material["diffuse"]), tuple(material["emission"]), material["opacity"])
        full = (*key, *look, clear)
        if full not in self._forms:
            try:
                meshes, colors = self._meshes(shape, tuple(texture["size"]) if texture is not None else (2.0, 2.0))
            except GazeboError as error:
                log.warning("%s", error)
                return [], stretched
            if texture is not None:
                meshes = [part.textured_by(_matrix(texture)) for part in meshes]
            parts = [part for part in meshes if len(_faces(part))]  # a mesh whose file is missing has no faces
            self._forms[full] = self._finished(full, parts, image, material, colors, clear) if parts else []
        return self._forms[full], stretched

    def _finished(
        self,
        key: tuple[Any, ...],
        meshes: list[Mesh],
        image: Image.Image | None,
        material: dict[str, Any],
        colors: NDArray[Any] | None,
        clear: bool,
    ) -> list[Form]:
        both = key[0] == "mesh"
        if image is None and colors is None and key[0] in SMOOTH:
            color = (*_bytes(material["diffuse"], material["emission"]), round(255 * material["opacity"]))
            return [
                Form((*key, i), part.vertices, _faces(part), _plain(part, color), clear, both)
                for i, part in enumerate(meshes)
            ]
        if image is None and colors is None:
            vertices, faces = _joined(meshes)
            return [Form(key, vertices, faces, None, clear, both)]
        found = []
        for i, part in enumerate(meshes):
            faces = _faces(part)
            if image is not None and part.texcoords is not None:
                glb = _textured(part, faces, image, material)
                found.append(Form((*key, i), part.vertices, faces, glb, clear, both))
            elif colors is not None:
                glb = _colored(part.vertices, faces, part.normals, colors)
                found.append(Form((*key, i), part.vertices, faces, glb, clear, both))
            else:
                found.append(Form((*key, i), part.vertices, faces, None, clear, both))
        return found

    def _meshes(self, shape: dict[str, Any], size: tuple[float, ...]) -> tuple[list[Mesh], NDArray[Any] | None]:
        """The meshes of a shape, of size 1 where it can be stretched; and colours of the vertices, if it has any."""
        kind = shape["kind"]
        if kind == "mesh":
            arrays = self._source.data(shape["data"])
            shown = mesh.triangles(arrays["vertices"], arrays["triangles"], (size[0], size[1]))
            corners = np.asarray(arrays["triangles"]).ravel()
            normals, coordinates = arrays.get("normals"), arrays.get("texture_coordinates")
            shown = Mesh(
                shown.vertices,
                shown.normals if normals is None else np.ascontiguousarray(normals[corners]),
                shown.texcoords if coordinates is None else np.ascontiguousarray(coordinates[corners]),
            )
            colors = arrays.get("colors")
            return [shown], None if colors is None else colors[corners]
        if kind == "heightfield":
            heights = self._source.data(shape["data"])["heights"]
            return [mesh.heightfield(heights, shape["size"], (size[0], size[1]))], None
        if kind == "plane":
            return [_plane(shape["normal"], float(shape["altitude"]), size)], None
        if kind == "box":
            return [mesh.box(1.0, 1.0, 1.0)], None
        if kind == "sphere":
            return [mesh.sphere(1.0, SEGMENTS)], None
        if kind == "cylinder":
            return mesh.cylinder(1.0, 1.0, SEGMENTS), None
        if kind == "capsule":
            return [mesh.capsule(shape["radius"], shape["length"], SEGMENTS)], None
        tire, hub = shape["tire_radius"], 0.8 * shape["radius"]
        parts = [mesh.torus(max(shape["radius"] - tire, 0.0), tire, SEGMENTS)]
        return parts + [mesh.disc(hub, 0.8 * tire * up, SEGMENTS, up) for up in (1.0, -1.0)], None

    # Files -----------------------------------------------------------------------------------------------------------

    def _skin(self, file: str) -> list[Mesh]:
        if file not in self._skins:
            try:
                self._skins[file] = read_skin(Path(file))
            except GazeboError as error:
                log.warning("%s; its own shape is shown instead", error)
                self._skins[file] = []
        return self._skins[file]

    def _skin_forms(self, file: str) -> list[Form]:
        key = ("skin", file)
        if key not in self._forms:
            merged: dict[tuple[int, int, int], list[Mesh]] = {}
            for part in self._skin(file):
                if not len(_faces(part)):
                    continue
                merged.setdefault(_bytes(part.material.diffuse[:3] if part.material else (0.8,) * 3), []).append(part)
            found = []
            for color, parts in merged.items():
                vertices, faces = _joined(parts)
                lit = [part.normals for part in parts if part.normals is not None]
                normals = np.concatenate(lit) if len(lit) == len(parts) else None
                glb = _plain(Mesh(vertices, normals, None, faces), (*color, 255))
                found.append(Form((*key, color), vertices, faces, glb, False, True))
            self._forms[key] = found
        return self._forms[key]

    def _own_image(self, shape: dict[str, Any]) -> Image.Image | None:
        """The texture that a mesh has beside its triangles, if any."""
        pixels = self._source.data(shape["data"]).get("image") if shape["kind"] == "mesh" else None
        return None if pixels is None else Image.fromarray(np.ascontiguousarray(pixels, dtype=np.uint8))

    def tone(self, texture: dict[str, Any] | None) -> tuple[float, ...]:
        """The mean colour of a shape's texture, 0 to 1; white without one."""
        image = self._image(texture["file"]) if texture is not None else None
        if image is None:
            return 1.0, 1.0, 1.0
        return tuple(float(c) / 255.0 for c in np.asarray(image.convert("RGB")).reshape(-1, 3).mean(axis=0))

    def _image(self, file: str) -> Image.Image | None:
        """A texture, reduced to what a page needs; None, and one warning, if it cannot be read."""
        if file not in self._images:
            try:
                image = Image.fromarray(read_image(Path(file)))
                image.thumbnail((LARGEST_TEXTURE, LARGEST_TEXTURE))
                self._images[file] = image
            except GazeboError as error:
                log.warning("%s; the page shows no texture there", error)
                self._images[file] = None
        return self._images[file]


def _key(shape: dict[str, Any]) -> tuple[tuple[Any, ...], tuple[float, float, float]]:
    """What distinguishes the form of a shape, and how a form of size 1 is stretched to it."""
    kind = shape["kind"]
    if kind == "box":
        x, y, z = shape["size"]
        return ("box",), (x, y, z)
    if kind == "sphere":
        return ("sphere",), (shape["radius"],) * 3
    if kind == "cylinder":
        return ("cylinder",), (shape["radius"], shape["radius"], shape["length"])
    if kind == "plane":
        return ("plane", tuple(shape["normal"]), shape["altitude"]), (1.0, 1.0, 1.0)
    if kind in ("mesh", "heightfield"):
        return (kind, shape["data"]["file"], *shape.get("size", ())), (1.0, 1.0, 1.0)
    sizes = tuple(shape.get(name, 0.0) for name in ("radius", "length", "tire_radius"))
    return (kind, *sizes), (1.0, 1.0, 1.0)


def _plane(normal: Any, altitude: float, size: tuple[float, ...]) -> Mesh:
    """A large part of a plane; texture coordinates follow the world's axes as far as the plane is level."""
    n = np.asarray(normal, dtype=float)
    n = n / (np.linalg.norm(n) or 1.0)
    across = np.cross((0.0, 1.0, 0.0), n) if abs(n[1]) < 0.9 else np.array((1.0, 0.0, 0.0))
    across = across / (np.linalg.norm(across) or 1.0)
    up = np.cross(n, across)
    corners = np.array(((-1, -1), (1, -1), (1, 1), (-1, 1))) * (PLANE / 2.0)
    vertices = (corners @ np.array((across, up)) + n * altitude).astype(np.float32)
    texcoords = (corners / (size[0] or 1.0, size[1] or 1.0)).astype(np.float32)
    normals = np.tile(n, (4, 1)).astype(np.float32)
    return Mesh(vertices, normals, texcoords, np.array((0, 1, 2, 0, 2, 3), np.uint32))


def _faces(part: Mesh) -> NDArray[np.uint32]:
    count = len(part.vertices)
    indices = np.arange(count, dtype=np.uint32) if part.indices is None else part.indices
    return np.ascontiguousarray(indices, dtype=np.uint32).reshape(-1, 3)


def _joined(meshes: list[Mesh]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    starts = np.cumsum([0, *(len(part.vertices) for part in meshes)])
    faces = [_faces(part) + np.uint32(start) for part, start in zip(meshes, starts, strict=False)]
    return np.concatenate([part.vertices for part in meshes]), np.concatenate(faces)


def _bytes(color: Any, emission: Any = (0.0, 0.0, 0.0)) -> tuple[int, int, int]:
    """A colour as the page wants it: in sRGB, so that the page's light gives the tones of the old renderer."""
    red, green, blue = (
        round(BRIGHTEST * min(max(float(c) + 0.6 * float(e), 0.0), 1.0))
        for c, e in zip(color[:3], emission[:3], strict=True)
    )
    return red, green, blue


def _pbr(**more: Any) -> Any:
    return trimesh.visual.material.PBRMaterial(metallicFactor=0.0, roughnessFactor=0.9, doubleSided=True, **more)


def _plain(part: Mesh, color: tuple[int, int, int, int]) -> bytes:
    linear = [round(255 * (c / 255) ** 2.2) for c in color[:3]]
    pbr = _pbr(baseColorFactor=[*linear, color[3]], alphaMode="BLEND" if color[3] < 255 else None)
    visual = trimesh.visual.TextureVisuals(material=pbr)
    return _glb(trimesh.Trimesh(part.vertices, _faces(part), vertex_normals=part.normals, visual=visual, process=False))


def _matrix(texture: dict[str, Any]) -> tuple[float, ...]:
    """The matrix of texture coordinates; logs of older versions have none."""
    return tuple(texture.get("matrix", SAME))


def _textured(part: Mesh, faces: NDArray[Any], image: Image.Image, material: dict[str, Any]) -> bytes:
    buffer = io.BytesIO()
    image.convert("RGB").save(buffer, "JPEG", quality=90)
    buffer.seek(0)
    tint = [*(min(max(float(c), 0.0), 1.0) for c in material["diffuse"][:3]), float(material["opacity"])]
    bright = max(tint[:3]) or 1.0
    factor = [round(255 * (c / bright) ** 2.2) for c in tint[:3]] if bright < 0.99 else [255] * 3
    pbr = _pbr(
        baseColorTexture=Image.open(buffer),
        baseColorFactor=[*factor, round(255 * tint[3])],
        alphaMode="BLEND" if tint[3] < 1.0 else None,
    )
    visual = trimesh.visual.TextureVisuals(uv=part.texcoords, material=pbr)
    return _glb(trimesh.Trimesh(part.vertices, faces, vertex_normals=part.normals, visual=visual, process=False))


def _colored(vertices: NDArray[Any], faces: NDArray[Any], normals: Any, colors: NDArray[Any]) -> bytes:
    shades = np.clip(np.asarray(colors, dtype=float), 0.0, 1.0)
    if shades.shape[1] == 3:
        shades = np.column_stack([shades, np.ones(len(shades))])
    shades[:, :3] = shades[:, :3] ** 2.2  # GLB has linear colours
    visual = trimesh.visual.ColorVisuals(vertex_colors=(255 * shades).astype(np.uint8))
    body = trimesh.Trimesh(vertices, faces, vertex_normals=normals, process=False)
    body.visual = visual
    return _glb(body)


def _strip(image: Image.Image, sky: dict[str, Any]) -> Image.Image:
    """The colours of the sky now: an image one pixel wide, zenith at the top."""
    column = int(float(sky["time_of_day"] or 0.0) / 86400.0 % 1.0 * image.width)
    column = min(column, image.width - 1)
    return image.convert("RGB").crop((column, 0, column + 1, image.height))


def _shining(vertices: NDArray[Any], faces: NDArray[Any], t: NDArray[Any], strip: Image.Image) -> bytes:
    """The sky: it shines by itself, in the colours of an image one pixel wide."""
    pbr = trimesh.visual.material.PBRMaterial(
        baseColorFactor=[0, 0, 0, 255], emissiveTexture=strip, emissiveFactor=[1.0, 1.0, 1.0], roughnessFactor=1.0
    )
    t = np.clip(t, 0.5 / strip.height, 1.0 - 0.5 / strip.height)  # images repeat
    visual = trimesh.visual.TextureVisuals(uv=np.column_stack([np.full(len(t), 0.5), t]), material=pbr)
    return _glb(trimesh.Trimesh(vertices * SKY, faces, vertex_normals=-vertices, visual=visual, process=False))


def _glb(body: Any) -> bytes:
    return bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene([body]), include_normals=True))


def _compose(outer: tuple[float, ...], inner: tuple[float, ...]) -> tuple[float, ...]:
    a, b = np.array([outer]), np.array([inner])
    position, rotation = compose(a[:, :3], a[:, 3:], b[:, :3], b[:, 3:])
    return (*position[0].tolist(), *rotation[0].tolist())


def compose(p: NDArray[Any], q: NDArray[Any], at: NDArray[Any], turn: NDArray[Any]) -> tuple[Any, Any]:
    """Positions [m] and quaternions of poses `at`, `turn` given in frames `p`, `q`; shapes (n, 3) and (n, 4)."""
    u, v = q[:, :1], q[:, 1:]
    cross = np.cross(v, at)
    position = p + at + 2.0 * (u * cross + np.cross(v, cross))
    w, s = turn[:, :1], turn[:, 1:]
    rotation = np.concatenate([u * w - np.sum(v * s, axis=1, keepdims=True), u * s + w * v + np.cross(v, s)], axis=1)
    return position, rotation


def extent_corners(extent: NDArray[Any]) -> NDArray[np.float64]:
    """The eight corners of a box, from its smallest and largest one."""
    picks = np.array([[(i >> k) & 1 for k in range(3)] for i in range(8)])
    corners: NDArray[np.float64] = np.where(picks == 1, extent[1], extent[0])
    return corners
