"""Library: display lists and textures of a scene, made once and kept while used."""

from __future__ import annotations

import ctypes
import logging
import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError
from libgz.physics.geom import Geom
from libgz.physics.geoms import TriMeshGeom
from libgz.rendering.geom_meshes import meshes_of
from libgz.rendering.gl import Constant, floats
from libgz.rendering.ground import Sight, rings
from libgz.rendering.image import pyramid, read_image
from libgz.rendering.mesh import Material, Mesh
from libgz.rendering.selection import FINE, LEVELS, TINY, new_selector
from libgz.rendering.shot import Content, Item, pose_matrix
from libgz.rendering.skin import read_skin
from libgz.rendering.tape import Tape

__all__ = ["Compiled", "Level", "Library", "Look", "Table"]

log = logging.getLogger("libgz.rendering")

NEUTRAL = Material(diffuse=(0.8, 0.8, 0.8, 1.0), ambient=(0.16, 0.16, 0.16, 1.0))  # where materials are switched off
BLACK = (0.0, 0.0, 0.0, 1.0)
MOST_FINE = 4  # lists of a table on levels above FINE, or as many as one image has
MOST_TEXELS = 8 * 8192 * 8192  # [px] of all textures
MOST_PLANES = 64  # lists of planes, each for one height, field of view and look


Color = tuple[float, ...]


class Look(NamedTuple):
    """How content is shown."""

    skins: bool
    materials: bool
    textures: bool
    local_lights: bool  # whether light is computed at vertices, and there are lights other than directional ones
    shaded: bool = False  # whether all is textured, see `Shading`


class Compiled:
    """A display list, the radius [m] of the ball around the body's origin that contains it, and its own middle [m].

    `spread` is the radius [m] of the ball around that middle.
    """

    __slots__ = ("list", "middle", "radius", "spread")

    def __init__(
        self, number: int, radius: float, middle: tuple[float, ...] = (0.0, 0.0, 0.0), spread: float = 0.0
    ) -> None:
        self.list, self.radius, self.middle, self.spread = number, radius, middle, spread


class Level(NamedTuple):
    """A texture at one of its sizes: GL's number, width and height [px]."""

    number: int
    width: int
    height: int


class Table:
    """Lists and balls of all items of a content, for one look; see `Compiled`.

    Attributes:
        selector: selects what a view shows of them.
        radii, middles, spreads: of the items' balls [m], shapes (n,), (n, 3), (n,).
        clear: which items are transparent.
        colors: of images of models' numbers, shape (n, 3).
    """

    def __init__(self, library: Library, content: Content, look: Look, plain: bool) -> None:
        def find(i: int, level: int) -> Compiled:
            return library.item(content.items[i], look, LEVELS[level], plain)

        def forget(i: int, level: int) -> None:
            library.forget(content.items[i], look, LEVELS[level], plain)

        self._find, self._forget = find, forget
        self._fine: list[tuple[int, int]] = []  # level and place of large lists, the last ones used at the end
        least = [find(i, TINY) for i in range(len(content.items))]
        self.radii = np.array([compiled.radius for compiled in least], dtype=np.float64)
        self.middles = np.array([compiled.middle for compiled in least], dtype=np.float64).reshape(-1, 3)
        self.spreads = np.array([compiled.spread for compiled in least], dtype=np.float64)
        self.selector = new_selector(self.radii, content)
        self.clear = np.array([item.transparent for item in content.items], dtype=bool)
        numbers = np.array([item.model_id for item in content.items], dtype=np.int64)
        self.colors = np.stack([numbers, numbers >> 8, numbers >> 16], axis=1).astype(np.uint8)
        self._lists = np.zeros((len(LEVELS), len(least)), dtype=np.uint32)
        self._lists[TINY] = [compiled.list for compiled in least]

    def lists(self, places: NDArray[np.int64], levels: NDArray[np.int64]) -> NDArray[np.uint32]:
        """The lists of items by their places in the content, and by their levels of detail in `LEVELS`."""
        found = self._lists[levels, places]
        if not found.all():
            for k in np.flatnonzero(found == 0).tolist():
                place, level = int(places[k]), int(levels[k])
                found[k] = self._lists[level, place] = self._find(place, level).list
        if levels.max(initial=0) > FINE:
            self._bound([(int(levels[k]), int(places[k])) for k in np.flatnonzero(levels > FINE).tolist()])
        return found

    def _bound(self, used: list[tuple[int, int]]) -> None:
        """Delete large lists that were not used for long."""
        idle = [key for key in self._fine if key not in used]
        surplus = max(len(idle) - max(MOST_FINE - len(used), 0), 0)
        for level, place in idle[:surplus]:
            self._lists[level, place] = 0
            self._forget(place, level)
        self._fine = idle[surplus:] + used


class Library:
    """Display lists by item, look and detail; textures and skins by file."""

    def __init__(self, gl: Tape) -> None:
        self.gl = gl
        self._items: dict[tuple[tuple[int, ...], Look, int, bool], Compiled] = {}
        self._planes: dict[tuple[int, Sight, Look, bool], Compiled] = {}
        self._shapes: dict[str, Compiled] = {}
        self._textures: dict[tuple[Path, bool, bool], int] = {}
        self._images: dict[Callable[[], NDArray[np.uint8]], int] = {}  # textures that geoms compute
        self._levels: dict[Path, tuple[Level, ...]] = {}
        self._white = 0
        self._texels: dict[int, int] = {}  # of each texture [px], without its smaller images
        self._full = False  # whether a texture was left out
        self._colors: tuple[object, ...] | None = None  # of the list that is being compiled
        self._damaged: set[Path] = set()
        self._skins: dict[Path, list[Mesh]] = {}
        self._content: Content | None = None
        self._tables: dict[tuple[Look, bool], Table] = {}

    def use(self, content: Content) -> None:
        """Delete the lists of items that are no longer in the content."""
        if content is self._content:
            return
        self._content = content
        self._tables.clear()
        keys = {item.key for item in content.items}
        large = LEVELS[FINE]  # the new tables do not know of larger ones
        for key in [k for k in self._items if k[0] not in keys or k[2] > large]:
            self.gl.glDeleteLists(self._items.pop(key).list, 1)
        images = {geom.image for item in content.items for geom in item.geoms if isinstance(geom, TriMeshGeom)}
        for image in [image for image in self._images if image not in images]:
            self._delete(self._images.pop(image))
        if sum(self._texels.values()) > MOST_TEXELS // 2:
            self._forget_files()
        for compiled in self._planes.values():
            self.gl.glDeleteLists(compiled.list, 1)
        self._planes.clear()

    def _forget_files(self) -> None:
        """Delete the textures of files, with the lists that name them; what is still shown is read again."""
        for compiled in self._items.values():
            self.gl.glDeleteLists(compiled.list, 1)
        self._items.clear()
        for number in (*self._textures.values(), *(level.number for row in self._levels.values() for level in row)):
            self._delete(number)
        self._textures.clear()
        self._levels.clear()
        self._full = False

    def _delete(self, number: int) -> None:
        self._texels.pop(number, None)
        self.gl.glDeleteTextures(1, ctypes.c_uint(number))

    def table(self, content: Content, look: Look, plain: bool) -> Table:
        """The lists of all items of the content in use; plain: their shapes alone, without materials."""
        found = self._tables.get((look, plain))
        if found is None:
            found = self._tables[look, plain] = Table(self, content, look, plain)
        return found

    def item(self, item: Item, look: Look, segments: int, plain: bool) -> Compiled:
        """The list of an item, with so many segments of a full turn; plain: its shape alone, without materials."""
        key = (item.key, look, segments, plain)
        found = self._items.get(key)
        if found is None:
            found = self._items[key] = self._compile_item(item, look, segments, plain)
        return found

    def forget(self, item: Item, look: Look, segments: int, plain: bool) -> None:
        """Delete the list of an item; it is compiled again where it is asked for."""
        found = self._items.pop((item.key, look, segments, plain), None)
        if found is not None:
            self.gl.glDeleteLists(found.list, 1)

    def plane(self, geom: Geom, sight: Sight, look: Look, plain: bool) -> Compiled:
        """The list of a plane around the camera's foot, facing +z."""
        key = (geom.row, sight, look, plain)
        found = self._planes.get(key)
        if found is None:
            if len(self._planes) >= MOST_PLANES:
                self.gl.glDeleteLists(self._planes.pop(next(iter(self._planes))).list, 1)
            found = self._planes[key] = Compiled(self._compile_plane(geom, sight, look, plain), sight.reach)
        return found

    def _compile_plane(self, geom: Geom, sight: Sight, look: Look, plain: bool) -> int:
        gl, size = self.gl, geom.appearance.texture_size
        levels = () if plain else self.levels(geom.appearance.texture_file if look.textures else None)
        texel = min(size.x / levels[0].width, size.y / levels[0].height) if levels else math.inf
        white = self._white_texture() if look.shaded else 0
        number = self._begin()
        if not plain:
            self._material(*(geom.material() if look.materials else NEUTRAL.colors))
        if levels or look.shaded:
            gl.glEnable(Constant.TEXTURE_2D)
        if look.shaded:
            gl.glBindTexture(Constant.TEXTURE_2D, white)
        for level, shape in rings(sight, texel, max(len(levels), 1), (size.x, size.y)):
            if levels:
                gl.glBindTexture(Constant.TEXTURE_2D, levels[level].number)
            self._draw_mesh(shape, bool(levels))
        if levels or look.shaded:
            gl.glDisable(Constant.TEXTURE_2D)
        gl.glEndList()
        return number

    def shape(self, name: str, build: Callable[[], Mesh]) -> Compiled:
        """The list of a mesh that has no geom, built at first use."""
        found = self._shapes.get(name)
        if found is None:
            number = self._begin()
            self._draw_mesh(build(), True)
            self.gl.glEndList()
            found = self._shapes[name] = Compiled(number, 0.0)
        return found

    def _begin(self) -> int:
        self._colors = None
        number = self.gl.glGenLists(1)
        self.gl.glNewList(number, Constant.COMPILE)
        return int(number)

    def _compile_item(self, item: Item, look: Look, segments: int, plain: bool) -> Compiled:
        work = [(geom, self._meshes(geom, look, segments)) for geom in item.geoms]
        extent = _extent([shape for _, meshes in work for shape in meshes])
        if not plain:
            for geom, _ in work:
                self._load_texture(geom, look)
        number = self._begin()
        for geom, meshes in work:
            if plain:
                for shape in meshes:
                    self._draw_mesh(shape, False)
            else:
                self._draw_geom(geom, meshes, look)
        self.gl.glEndList()
        return Compiled(number, *extent)

    def _meshes(self, geom: Geom, look: Look, segments: int) -> list[Mesh]:
        """The visible meshes of a geom, in the frame of its body."""
        appearance, skins = geom.appearance, look.skins
        place = pose_matrix(geom.GetRelativePose())
        if skins and appearance.skin_null and (appearance.skin_instead is None or self._skin(appearance.skin_instead)):
            return []
        if skins and appearance.skin_file is not None:
            skin = self._skin(appearance.skin_file)
            if skin:
                on_geom = place @ pose_matrix(appearance.skin_pose)
                return [part.scaled(*appearance.skin_scale).moved(on_geom) for part in skin]
        shapes = meshes_of(geom, segments, local_lights=look.local_lights)
        if tuple(appearance.scale) != (1.0, 1.0, 1.0):
            shapes = [shape.scaled(*appearance.scale) for shape in shapes]
        return [shape.moved(place) for shape in shapes]

    def _skin(self, path: Path) -> list[Mesh]:
        """The meshes of a skin; none, and one warning, if it cannot be read."""
        if path not in self._skins:
            try:
                self._skins[path] = read_skin(path)
            except GazeboError as error:
                log.warning("%s; its own shape is shown instead", error)
                self._skins[path] = []
        return self._skins[path]

    def _load_texture(self, geom: Geom, look: Look) -> None:
        """Load a texture before a list begins; made inside the list, it would be made again in every image."""
        self._texture_of(geom, look)
        if look.shaded:
            self._white_texture()

    def _draw_geom(self, geom: Geom, meshes: list[Mesh], look: Look) -> None:
        """Submit meshes with the material and texture of their geom, or their own."""
        gl = self.gl
        texture = self._texture_of(geom, look)
        colors = geom.material()
        for shape in meshes:
            own = shape.material
            if not look.materials:
                own = NEUTRAL
            self._material(*(colors if own is None else own.colors))
            textured = bool(texture) and shape.texcoords is not None and shape.material is None
            if textured or look.shaded:
                gl.glEnable(Constant.TEXTURE_2D)
                gl.glBindTexture(Constant.TEXTURE_2D, texture if textured else self._white_texture())
            rejection = geom.appearance.alpha_rejection if textured else 0.0
            if rejection:
                gl.glAlphaFunc(Constant.GREATER, rejection)
                gl.glEnable(Constant.ALPHA_TEST)
            lit = shape.normals is not None
            if not lit:
                if look.shaded:
                    plain = (*(own.diffuse if own is not None else colors[1])[:3], 1.0)
                    self._material(BLACK, BLACK, BLACK, plain, 0.0)
                gl.glDisable(Constant.LIGHTING)
                gl.glColor3f(*(own.diffuse if own is not None else colors[1])[:3])
            self._draw_mesh(shape, textured)
            if not lit:
                gl.glEnable(Constant.LIGHTING)
            if rejection:
                gl.glDisable(Constant.ALPHA_TEST)
            if textured or look.shaded:
                gl.glDisable(Constant.TEXTURE_2D)

    def _material(
        self,
        ambient: tuple[float, ...],
        diffuse: tuple[float, ...],
        specular: tuple[float, ...],
        emission: tuple[float, ...],
        shininess: float,
    ) -> None:
        colors = (ambient, diffuse, specular, emission, shininess)
        if colors == self._colors:  # Mesa would end what it renders in one go
            return
        self._colors = colors
        gl, both = self.gl, Constant.FRONT_AND_BACK
        gl.glMaterialfv(both, Constant.AMBIENT, floats(*ambient))
        gl.glMaterialfv(both, Constant.DIFFUSE, floats(*diffuse))
        gl.glMaterialfv(both, Constant.SPECULAR, floats(*specular))
        gl.glMaterialfv(both, Constant.EMISSION, floats(*emission))
        gl.glMaterialf(both, Constant.SHININESS, min(max(shininess, 0.0), 128.0))

    def _draw_mesh(self, shape: Mesh, textured: bool) -> None:
        gl = self.gl
        if shape.two_sided:
            gl.glDisable(Constant.CULL_FACE)
            gl.glLightModeli(Constant.LIGHT_MODEL_TWO_SIDE, 1)
        gl.glEnableClientState(Constant.VERTEX_ARRAY)
        gl.glVertexPointer(3, Constant.FLOAT, 0, shape.vertices)
        if shape.normals is not None:
            gl.glEnableClientState(Constant.NORMAL_ARRAY)
            gl.glNormalPointer(Constant.FLOAT, 0, shape.normals)
        if textured and shape.texcoords is not None:
            gl.glEnableClientState(Constant.TEXTURE_COORD_ARRAY)
            gl.glTexCoordPointer(2, Constant.FLOAT, 0, shape.texcoords)
        if shape.indices is None:
            gl.glDrawArrays(shape.mode, 0, len(shape.vertices))
        else:
            gl.glDrawElements(shape.mode, len(shape.indices), Constant.UNSIGNED_INT, shape.indices)
        for array in (Constant.VERTEX_ARRAY, Constant.NORMAL_ARRAY, Constant.TEXTURE_COORD_ARRAY):
            gl.glDisableClientState(array)
        if shape.two_sided:
            gl.glLightModeli(Constant.LIGHT_MODEL_TWO_SIDE, 0)
            gl.glEnable(Constant.CULL_FACE)

    def _texture_of(self, geom: Geom, look: Look) -> int:
        """The number of the texture of a geom: of a file, or one that it computes; 0 if it has none."""
        image = geom.image if isinstance(geom, TriMeshGeom) else None
        if not look.textures or geom.appearance.texture_file is not None or image is None:
            rejects = geom.appearance.alpha_rejection > 0.0
            return self.texture(geom.appearance.texture_file if look.textures else None, alpha=rejects)
        if image not in self._images:
            if self._is_full():
                return 0
            smoothing = Constant.LINEAR, Constant.NEAREST_MIPMAP_NEAREST
            self._images[image] = self._upload(image(), Constant.CLAMP_TO_EDGE, *smoothing)
        return self._images[image]

    def texture(self, path: Path | None, repeat: bool = True, alpha: bool = False) -> int:
        """The number of a texture; 0, and one warning, if its file cannot be read."""
        if path is None:
            return 0
        key = path, repeat, alpha
        if key not in self._textures:
            image = self._read(path, alpha)
            vertical = Constant.REPEAT if repeat else Constant.CLAMP_TO_EDGE
            # Mixing the mipmaps as well would take as long as all the rest of an image rendered in software.
            smoothing = Constant.LINEAR, Constant.NEAREST_MIPMAP_NEAREST
            self._textures[key] = 0 if image is None else self._upload(image, vertical, *smoothing)
        return self._textures[key]

    def _white_texture(self) -> int:
        """The texture of all that has none, for `Shading`."""
        if not self._white:
            nearest = Constant.NEAREST
            self._white = self._upload(np.full((1, 1, 3), 255, dtype=np.uint8), Constant.REPEAT, nearest, nearest)
        return self._white

    def levels(self, path: Path | None) -> tuple[Level, ...]:
        """The levels of a texture that repeats, for planes; none, and one warning, if its file cannot be read."""
        if path is None:
            return ()
        if path not in self._levels:
            image = self._read(path)
            images = [] if image is None else pyramid(image)
            # Nearby texels are larger than pixels, and are smoothed; distant pixels show one texel each.
            filters = [Constant.LINEAR] + [Constant.NEAREST] * (len(images) - 1)
            self._levels[path] = tuple(map(self._upload_level, images, filters))
        return self._levels[path]

    def _read(self, path: Path, alpha: bool = False) -> NDArray[np.uint8] | None:
        """An image, top row first; None, and one warning, if its file cannot be read."""
        try:
            return None if self._is_full() else read_image(path, alpha=alpha)
        except GazeboError as error:
            if path not in self._damaged:
                log.warning("%s; rendered without a texture", error)
            self._damaged.add(path)
            return None

    def _is_full(self) -> bool:
        """Whether there may be no further texture; the first time it is reported."""
        if sum(self._texels.values()) < MOST_TEXELS:
            return False
        if not self._full:
            log.warning("the textures of this world have more than %d px; further ones are left out", MOST_TEXELS)
        self._full = True
        return True

    def _upload_level(self, pixels: NDArray[np.uint8], smoothing: int) -> Level:
        height, width, _ = pixels.shape
        return Level(self._upload(pixels, Constant.REPEAT, smoothing, smoothing), width, height)

    def _upload(self, pixels: NDArray[np.uint8], vertical: int, magnified: int, minified: int) -> int:
        """A texture that repeats horizontally, from an image with its bottom row last."""
        upward = np.ascontiguousarray(pixels[::-1])  # GL's rows begin at the bottom
        gl, kind, number = self.gl, Constant.TEXTURE_2D, ctypes.c_uint()
        gl.glGenTextures(1, ctypes.byref(number))
        gl.glBindTexture(kind, number.value)
        self._texels[number.value] = upward.shape[0] * upward.shape[1]
        gl.glPixelStorei(Constant.UNPACK_ALIGNMENT, 1)
        gl.glTexParameteri(kind, Constant.TEXTURE_WRAP_S, Constant.REPEAT)
        gl.glTexParameteri(kind, Constant.TEXTURE_WRAP_T, vertical)
        gl.glTexParameteri(kind, Constant.TEXTURE_MAG_FILTER, magnified)
        gl.glTexParameteri(kind, Constant.TEXTURE_MIN_FILTER, minified)
        images = [upward]
        if minified not in (Constant.NEAREST, Constant.LINEAR):
            # Mesa compiles a shader for each size. Where sides are powers of two, its smaller images are the same.
            if all(side & (side - 1) == 0 for side in upward.shape[:2]):
                images = pyramid(upward)
            else:
                gl.glTexParameteri(kind, Constant.GENERATE_MIPMAP, 1)
        for level, image in enumerate(images):
            size, form = (image.shape[1], image.shape[0]), (Constant.RGB, Constant.RGBA)[image.shape[2] - 3]
            gl.glTexImage2D(kind, level, Constant.RGBA8, *size, 0, form, Constant.UNSIGNED_BYTE, image)
        return int(number.value)


def _extent(meshes: list[Mesh]) -> tuple[float, tuple[float, ...], float]:
    """Of meshes: the radius of the ball around the origin, the middle of the box, the ball's around that [m]."""
    parts = [shape.vertices for shape in meshes if len(shape.vertices)]
    if not parts:
        return 0.0, (0.0, 0.0, 0.0), 0.0
    points = np.concatenate(parts)
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    spread = float(np.linalg.norm(points - middle, axis=1).max())
    return float(np.linalg.norm(points, axis=1).max()), tuple(middle.tolist()), spread
