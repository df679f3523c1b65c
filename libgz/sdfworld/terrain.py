"""Height maps of SDF worlds: ground from an image, and the textures that cover it."""

from __future__ import annotations

import functools
import math
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import GazeboError, NotFoundError
from libgz.base.files import is_file
from libgz.base.geometry import GzVector
from libgz.physics.body import Body
from libgz.physics.check import positive
from libgz.physics.geoms import GridGeom
from libgz.physics.image_files import open_image
from libgz.physics.mesh_parts import MeshPart
from libgz.physics.meshes import grid_triangles, grid_vertices
from libgz.sdf.description import UNSET
from libgz.sdf.element import Element
from libgz.sdf.paths import find_uri

__all__ = ["Cover", "terrain_heights", "terrain_mesh", "terrain_visual"]

MOST_PIXELS = 4097 * 4097
SAMPLING = 2  # vertices of ground for each pixel, along x and y, where a file does not say
MOST_LAYERS = 16
MOST_IMAGES = 8  # that are kept, of terrains in use
FINEST, COARSEST = 1024, 64  # [px] sides of the image of a terrain
STRIP = 64  # rows of it that are computed at once

Array = NDArray[np.float64]
Note = Callable[[Element, str], None]


def terrain_mesh(path: Path, shape: Element) -> MeshPart:
    """The ground of a `<heightmap>`: black is the bottom, the brightest pixel is size z above it; the top row is at +y.

    Raises:
        GazeboError: the image cannot be read, or is no height map; the size is not positive.
    """
    x, y, z = _grid(shape, _heights(path, shape))
    return MeshPart("heightmap", grid_vertices(x, y, z), grid_triangles(len(y), len(x)))


def terrain_visual(path: Path, shape: Element, body: Body, note: Note) -> GridGeom:
    """The geom that shows the same ground, with its textures.

    Raises:
        GazeboError: as `terrain_mesh`.
    """
    heights = _heights(path, shape)
    geom = GridGeom(body, *_grid(shape, heights))
    cover = _cover(heights, shape, note)
    if cover is not None:
        geom.image = cover.image
    return geom


def _grid(shape: Element, heights: Array) -> tuple[Array, Array, Array]:
    """The x of the columns, the y of the rows, and the z of all vertices of a ground [m]."""
    size, pos = shape.Get(GzVector, "size"), shape.Get(GzVector, "pos")
    rows, columns = heights.shape
    x = np.linspace(-0.5 * size.x, 0.5 * size.x, columns) + pos.x
    y = np.linspace(-0.5 * size.y, 0.5 * size.y, rows) + pos.y
    return x, y, heights + pos.z if pos.z else heights


def terrain_heights(path: Path, shape: Element) -> Array:
    """Heights of the ground that things touch, above `<pos>` [m], rows from -y to +y, columns along +x.

    As in Gazebo, there are `<sampling>` vertices for each pixel along x and y, 2 if the file does not say: colours are
    mixed between pixels. A terrain that would be too large then has a vertex for each pixel.

    Raises:
        GazeboError: as `terrain_mesh`.
    """
    heights = _heights(path, shape)
    given = shape.Get(int, "sampling") if shape.HasElement("sampling") else SAMPLING
    finer = given if given > 0 and given & (given - 1) == 0 else SAMPLING  # Gazebo knows powers of two
    rows, columns = ((side - 1) * finer + 1 for side in heights.shape)
    if finer == 1 or rows * columns > MOST_PIXELS:
        return heights
    return _sampled(heights[..., None], np.arange(columns) / finer, np.arange(rows) / finer)[..., 0]


def _heights(path: Path, shape: Element) -> Array:
    """Above the bottom [m], rows from -y to +y."""
    size = shape.Get(GzVector, "size")
    for value, what in ((size.x, "heightmap size x [m]"), (size.y, "heightmap size y [m]")):
        positive(value, what)
    pixels = _grey(path, path.stat().st_mtime_ns if is_file(path) else 0).astype(np.float64)
    if not np.isfinite(pixels).all():
        raise GazeboError(f"{path} has pixels that are not finite numbers")
    brightest = float(pixels.max())
    heights = pixels * (size.z / brightest) if brightest > 0.0 else pixels
    return heights[::-1]


@functools.lru_cache(maxsize=1)  # one ground collides, is shown, and has textures by its heights
def _grey(path: Path, _changed: int) -> NDArray[Any]:
    """The pixels of an image, top row first, in the type in which it has them.

    Raises:
        GazeboError: it cannot be read, or has too few.
    """
    with open_image(path, MOST_PIXELS) as image:
        if min(image.size) < 2:
            raise GazeboError(f"{path} is {image.width} x {image.height} pixels; 2 x 2 to 4097 x 4097 are allowed")
        return np.array(image if image.mode in ("I", "I;16", "F", "L") else image.convert("L"))


BARE = np.full((1, 1, 3), 255.0)  # the image of a layer whose file is missing: white, as a ground without images is


@dataclass(frozen=True)
class _Layer:
    """A texture that repeats every `size` [m], from a height `above` the bottom on, mixed over `fade` [m]."""

    file: Path | None  # None: in one colour, that of a ground without images
    size: float
    above: float = -math.inf
    fade: float = 0.0


@dataclass(frozen=True, eq=False)
class Cover:
    """The textures of a terrain, mixed by height.

    Attributes:
        heights: above the bottom [m], rows from -y to +y, shape (rows, columns).
        sizes: of the terrain along x and y [m].
        layers: from the lowest up.
    """

    heights: Array
    sizes: tuple[float, float]
    layers: tuple[_Layer, ...]

    def image(self) -> NDArray[np.uint8]:
        """All of the terrain from above, top row at +y, shape (n, n, 3); computed when it is rendered."""
        found = _images.get(self)
        if found is None:
            found = self._compute_image()
            for oldest in list(_images)[: 1 - MOST_IMAGES]:
                _images.pop(oldest, None)
            _images[self] = found
        return found

    def _compute_image(self) -> NDArray[np.uint8]:
        images = [BARE if layer.file is None else _tile(layer.file) for layer in self.layers]
        # As fine as the finest texture, where that is not too fine.
        finest = min(layer.size / image.shape[0] for layer, image in zip(self.layers, images, strict=True))
        wanted = max(self.sizes) / finest if finest > 0.0 else FINEST
        side = 1 << math.ceil(math.log2(min(max(wanted, COARSEST), FINEST)))
        images = [
            _smoothed(image, layer.size / (max(self.sizes) / side))
            for layer, image in zip(self.layers, images, strict=True)
        ]
        found = np.empty((side, side, 3), dtype=np.uint8)
        x = (np.arange(side) + 0.5) / side
        for first in range(0, side, STRIP):
            y = 1.0 - x[first : first + STRIP]
            height = _sampled(self.heights[..., None], x * (self.heights.shape[1] - 1), y * (self.heights.shape[0] - 1))
            color = np.zeros((len(y), side, 3))
            for layer, image in zip(self.layers, images, strict=True):
                rows = _sampled(
                    image,
                    (x - 0.5) * self.sizes[0] / layer.size * image.shape[1] - 0.5,
                    (0.5 - y) * self.sizes[1] / layer.size * image.shape[0] - 0.5,
                )
                share = np.clip((height - layer.above) / layer.fade, 0.0, 1.0) if layer.fade else height >= layer.above
                color += share * (rows - color)
            found[first : first + STRIP] = np.round(color)
        return found


_images: weakref.WeakKeyDictionary[Cover, NDArray[np.uint8]] = weakref.WeakKeyDictionary()


def _cover(heights: Array, shape: Element, note: Note) -> Cover | None:
    """The textures of a `<heightmap>`; None if it has none that can be read, with a warning for each that cannot."""
    size = shape.Get(GzVector, "size")
    blends = list(shape.named("blend"))
    folder = Path(shape.file).parent if shape.file and not shape.file.startswith("<") else None
    layers: list[_Layer] = []
    for i, texture in enumerate(shape.named("texture")):
        if i > len(blends):
            note(texture, f"texture {i + 1} has no <blend>, which gives its lowest height; it is not rendered")
            break
        if i >= MOST_LAYERS:
            note(texture, f"texture {i + 1} and further ones are not rendered; {MOST_LAYERS} are")
            break
        above, fade = -math.inf, 0.0
        if i:
            above, fade = (blends[i - 1].Get(float, key) for key in ("min_height", "fade_dist"))
        uri, width = texture.Get(str, "diffuse"), texture.Get(float, "size")
        try:
            if uri in ("", UNSET):
                raise NotFoundError("it has no <diffuse>")
            layer = _Layer(find_uri(uri, folder), positive(width, "texture size [m]"), above, max(fade, 0.0))
            _tile(layer.file)
        except GazeboError as error:
            note(texture, f"{error}; it is shown in one colour")
            layer = _Layer(None, 1.0, above, max(fade, 0.0))
        layers.append(layer)
    if not any(layer.file for layer in layers):
        return None
    return Cover(heights, (size.x, size.y), tuple(layers))


@functools.lru_cache(maxsize=8)
def _tile(path: Path) -> Array:
    """An image, shape (rows, columns, 3), top row first.

    Raises:
        GazeboError: it cannot be read.
    """
    with open_image(path) as image:
        if max(image.size) > FINEST:
            image.thumbnail((FINEST, FINEST))
        return np.asarray(image.convert("RGB"), dtype=np.float64)


def _smoothed(image: Array, texels: float) -> Array:
    """An image reduced to the so many pixels that one repetition of it covers, so that it does not flicker."""
    from PIL import Image

    rows, columns = (max(1, min(side, math.ceil(texels))) for side in image.shape[:2])
    small = Image.fromarray(image.astype(np.uint8)).resize((columns, rows), Image.Resampling.BOX)
    return np.asarray(small, dtype=np.float64)


def _sampled(table: Array, x: Array, y: Array) -> Array:
    """Values between those of a table that repeats, at columns x and rows y; shape (len(y), len(x), channels)."""
    left, low = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    a, b = (x - left)[None, :, None], (y - low)[:, None, None]
    rows, columns = table.shape[:2]
    i, j = left % columns, low % rows
    right, high = (left + 1) % columns, (low + 1) % rows
    bottom = (1.0 - a) * table[np.ix_(j, i)] + a * table[np.ix_(j, right)]
    top = (1.0 - a) * table[np.ix_(high, i)] + a * table[np.ix_(high, right)]
    found: Array = (1.0 - b) * bottom + b * top
    return found
