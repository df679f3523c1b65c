"""Materials by name: those that Gazebo knew as `Gazebo/...`, and those of Ogre material scripts."""

from __future__ import annotations

import csv
import functools
import itertools
import logging
import math
import re
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from libgz.base.errors import NotFoundError
from libgz.base.files import installed_worlds, is_file, is_folder, read_limited
from libgz.sdf.bounds import LARGEST
from libgz.sdf.paths import find_uri, resource_directories

__all__ = ["NEUTRAL", "Material", "find_material", "own_texture"]

log = logging.getLogger("libgz.sdf")

TABLE = Path(__file__).with_name("materials.tsv")
PREFIX = "Gazebo/"
UNIT = "texture_unit"
LONGEST, MOST_KEPT = 4 << 20, 64 << 20  # bytes of a script, and of all that a process keeps
BLOCK = 512  # bytes that a script, and each block of it, is counted as beside its letters: a material takes far more
IDLE = 60.0  # [s] after which a script that nothing has named makes place for others
MOST_IMAGES = 100  # of a material that are looked for; the first one that is found counts
SMALLEST = 1e-9  # scale of an image
REJECTIONS = {"greater": 0.0, "greater_equal": 1.0}  # what is kept, and by how much its bound is lower
COLORS = ("ambient", "diffuse", "specular", "emissive")
TEXTURES = ("", "../textures", "textures", "../materials/textures")  # of a script's images, relative to the script

Color = tuple[float, float, float, float]


class Material(NamedTuple):
    """Colours as red, green, blue, alpha; shininess of highlights; a texture and its matrix; whether it is lit.

    The matrix (a, b, c, d, e, f) is that of texture coordinates, (0, 0) is the lower left: u' = a u + b v + c,
    v' = d u + e v + f.
    """

    ambient: Color = (1.0, 1.0, 1.0, 1.0)
    diffuse: Color = (1.0, 1.0, 1.0, 1.0)
    specular: Color = (0.0, 0.0, 0.0, 1.0)
    emissive: Color = (0.0, 0.0, 0.0, 1.0)
    shininess: float = 0.0
    texture: Path | None = None
    lit: bool = True
    texture_matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
    alpha_rejection: float = 0.0  # what of its image has no more alpha than that is left out, 0 to 1; 0 for nothing


NEUTRAL = Material((0.3, 0.3, 0.3, 1.0), (0.7, 0.7, 0.7, 1.0))  # for unknown names


@functools.cache
def _known() -> Mapping[str, tuple[Material, str]]:
    """Name without prefix -> material, and the file name of its texture."""
    found = {}
    with TABLE.open(encoding="utf-8", newline="") as table:
        for row in csv.DictReader(table, delimiter="\t"):
            ambient, diffuse, specular, emissive = (_color(map(float, row[key].split())) for key in COLORS)
            diffuse = (*diffuse[:3], float(row["alpha"]))
            material = Material(ambient, diffuse, specular, emissive, float(row["shininess"]))
            found[row["name"]] = found[row["name"].replace("Grey", "Gray")] = (material, row["texture"])
    return found


def _color(numbers: Iterable[float]) -> Color:
    r, g, b, *a = numbers
    return r, g, b, a[0] if a else 1.0


def find_material(name: str, uris: Iterable[str] = (), beside: Path | None = None) -> Material | None:
    """A material by name; None if it is not known.

    Args:
        name: ``Gazebo/Grey``, or one that a script defines.
        uris: material scripts, and folders of scripts and textures.
        beside: folder of the file that contains these URIs.
    """
    name = name.strip()
    if name.startswith(PREFIX):
        return _of_table(name) or _of_scripts(name, uris, beside)
    # Without the prefix it may be a script's own `Wood`.
    return _of_scripts(name, uris, beside) or _of_table(name)


def _of_table(name: str) -> Material | None:
    material, texture = _known().get(name.removeprefix(PREFIX), (None, ""))
    return material._replace(texture=own_texture(texture)) if material is not None and texture else material


def _of_scripts(name: str, uris: Iterable[str], beside: Path | None) -> Material | None:
    places = [place for uri in uris for place in _place(uri, beside)]
    scripts = ((script, _kept.find(script)) for script in _scripts(places))
    return next((found[name].material_with_image(script, places) for script, found in scripts if name in found), None)


def own_texture(name: str) -> Path | None:
    """One of the textures that are installed with libgz's worlds; None if it is not."""
    file = installed_worlds() / name
    return file if is_file(file) else None


def _place(uri: str, beside: Path | None) -> list[Path]:
    try:
        return [find_uri(uri, beside)]
    except NotFoundError:
        return []  # file://media/materials/scripts/gazebo.material is in the table and not on disk


def _scripts(places: Iterable[Path]) -> Iterator[Path]:
    for place in places:
        if is_file(place):
            yield place
        else:
            yield from sorted(place.glob("*.material"))


# Scripts ---------------------------------------------------------------------------------------------------------


class _Defined:
    """A material of a script, whose images have not been looked for."""

    def __init__(self, parent: _Defined | None, basis: Material) -> None:
        self._parent, self.material = parent, basis
        self.units: list[_Unit] = []

    def material_with_image(self, script: Path, places: Iterable[Path]) -> Material:
        """The material with its first image that is there, or else that of its parents: others are such as normal maps.

        Args:
            script: its script.
            places: folders, and files in folders, where its images are, too.
        """
        folders = [script.parent / sub for sub in TEXTURES]
        folders += [place if is_folder(place) else place.parent for place in places]
        folders += resource_directories()
        for unit in itertools.islice(self._all_units(), MOST_IMAGES):
            file = next((file for folder in folders if is_file(file := folder / unit.texture)), None)
            if file is not None:
                return self.material._replace(texture=file, texture_matrix=unit.matrix())
        return self.material

    def _all_units(self) -> Iterator[_Unit]:
        one: _Defined | None = self
        while one is not None:
            yield from one.units
            one = one._parent


class _Script(NamedTuple):
    """A script that was read: its materials, the bytes that it is counted as, and when it was named last [s]."""

    materials: dict[str, _Defined]
    size: int
    named: float


class _Scripts:
    """The scripts of a process, read once, up to a bound.

    Each visual of a world may name all of them: if those that are in use made place for others, all would be read again
    and again.
    """

    def __init__(self, most: int) -> None:
        self._most, self._held = most, 0
        self._scripts: dict[Path, _Script] = {}  # the one that was named last comes last
        self._lock = threading.Lock()
        self._full_until = -math.inf

    def find(self, path: Path) -> dict[str, _Defined]:
        """All materials of a script; none of one that is too long, or too much beside those that are in use."""
        now = time.monotonic()
        with self._lock:
            found = self._scripts.pop(path, None)
            if found is not None:
                self._scripts[path] = found._replace(named=now)
                return found.materials
            if now < self._full_until:
                return {}
        try:
            data = read_limited(path, LONGEST)
        except OSError:
            data = b""
        size = BLOCK + len(data) + BLOCK * data.count(b"{")
        fits = size <= self._most
        with self._lock:
            if not fits:
                data, size = b"", BLOCK
            if not self._make_place(size, now):
                self._full_until, fits = now + IDLE, False
            else:
                self._held += size
        if not fits:
            log.warning(
                "%s: not read; all material scripts that are in use may have %d MiB together", path, MOST_KEPT >> 20
            )
            if now < self._full_until:
                return {}
        found = _Script(_materials(data), size, now)
        with self._lock:
            self._drop(path)  # another thread may have read it meanwhile
            self._scripts[path] = found
        return found.materials

    def _make_place(self, size: int, now: float) -> bool:
        """Drop what has not been named for a while, as far as it is in the way of so many bytes; whether they fit."""
        for path, script in list(self._scripts.items()):
            if self._held + size <= self._most or now - script.named < IDLE:
                break
            self._drop(path)
        return self._held + size <= self._most

    def _drop(self, path: Path) -> None:
        dropped = self._scripts.pop(path, None)
        if dropped is not None:
            self._held -= dropped.size


_kept = _Scripts(MOST_KEPT)


def _materials(data: bytes) -> dict[str, _Defined]:
    """All materials of a script; lines about anything but colours and textures are skipped."""
    text = data.decode("utf-8", "replace")
    text = re.sub(r"/\*.*?(?:\*/|\Z)", "", text, flags=re.DOTALL)
    found: dict[str, _Defined] = {}
    current, header = "", ""
    blocks: list[str] = []  # first words of the blocks around a line
    unit = _Unit()
    for line in re.split(r"([{}\n])", re.sub(r"//[^\n]*", "", text)):
        words = line.split()
        if line == "{":
            if not blocks:
                current, _, parent = (part.strip(' "') for part in header.partition(":"))
                known = _known().get(parent.removeprefix(PREFIX), (Material(), ""))[0]
                above = found.get(parent)
                found[current] = _Defined(above, above.material if above is not None else known)
            blocks.append(header.split()[0] if header.split() else "")
            if blocks[-1] == UNIT:
                unit = _Unit()
        elif line == "}":
            if blocks and blocks.pop() == UNIT and unit.texture:
                found[current].units.append(unit)
        elif words and not blocks:
            header = line.strip().removeprefix("material").strip() if words[0] == "material" else f"({words[0]})"
        elif words and blocks[-1] == UNIT:
            unit.read(words)
            found[current].material = _with(found[current].material, words)
        elif words:
            header = line.strip()
            found[current].material = _with(found[current].material, words)
    return found


class _Unit:
    """A `texture_unit` of a script: its image, and how the image is scaled, moved and turned, as in Ogre's manual."""

    def __init__(self) -> None:
        self.texture = ""
        self.scale, self.scroll, self.turn = (1.0, 1.0), (0.0, 0.0), 0.0

    def read(self, words: list[str]) -> None:
        """Take one line."""
        key, values = words[0], words[1:]
        if key == "texture" and values:
            self.texture = values[0].strip('"')
        numbers = [number for number in map(_number, values) if number is not None]
        if key == "scale" and len(numbers) == 2 and all(abs(number) >= SMALLEST for number in numbers):
            self.scale = numbers[0], numbers[1]
        elif key == "scroll" and len(numbers) == 2:
            self.scroll = numbers[0], numbers[1]
        elif key == "rotate" and len(numbers) == 1:
            self.turn = math.radians(numbers[0])

    def matrix(self) -> tuple[float, ...]:
        """Of texture coordinates that grow upwards; Ogre's grow downwards."""
        (x, y), (right, down) = self.scale, self.scroll
        stretched = np.array([[1.0 / x, 0.0, 0.5 - 0.5 / x], [0.0, 1.0 / y, 0.5 - 0.5 / y], [0.0, 0.0, 1.0]])
        moved = np.array([[1.0, 0.0, right], [0.0, 1.0, down], [0.0, 0.0, 1.0]])
        c, s = math.cos(self.turn), math.sin(self.turn)
        turned = np.array([[c, -s, 0.5 - 0.5 * c + 0.5 * s], [s, c, 0.5 - 0.5 * s - 0.5 * c], [0.0, 0.0, 1.0]])
        flip = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 1.0], [0.0, 0.0, 1.0]])
        return tuple((flip @ turned @ moved @ stretched @ flip)[:2].round(12).ravel().tolist())


def _with(material: Material, words: list[str]) -> Material:
    """A material after one line of a script that is not about its image."""
    key, values = words[0], words[1:]
    if key == "lighting" and values:
        return material._replace(lit=values[0] != "off")
    numbers = [_number(value) for value in values]
    if key == "alpha_rejection" and len(numbers) > 1 and numbers[1] is not None and values[0] in REJECTIONS:
        return material._replace(alpha_rejection=min(max(numbers[1] - REJECTIONS[values[0]], 0.0), 254.0) / 255.0)
    if key == "alpha_op_ex" and "src_manual" in values and numbers[-1] is not None:
        return material._replace(diffuse=(*material.diffuse[:3], numbers[-1]))
    known = [number for number in numbers if number is not None]
    if key not in COLORS or len(known) < max(len(numbers), 3):
        return material
    if key == "specular" and len(known) > 3:
        *color, shininess = known
        return material._replace(specular=_color(color), shininess=shininess)
    return material._replace(**{key: _color(known)})  # type: ignore[arg-type]


def _number(word: str) -> float | None:
    """A number within the bounds of SDF files; None if it is none."""
    try:
        number = float(word)
    except ValueError:
        return None
    return None if math.isnan(number) else max(-LARGEST, min(LARGEST, number))
