"""Materials by name: those that Gazebo knew as `Gazebo/...`, and those of Ogre material scripts."""

from __future__ import annotations

import csv
import functools
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from libgz.base.errors import NotFoundError
from libgz.base.files import installed_worlds, is_file, is_folder, read_text
from libgz.sdf.paths import find_uri, resource_directories

__all__ = ["NEUTRAL", "Material", "find_material", "own_texture"]

TABLE = Path(__file__).with_name("materials.tsv")
PREFIX = "Gazebo/"
COLORS = ("ambient", "diffuse", "specular", "emissive")
TEXTURES = ("", "../textures", "textures", "../materials/textures")  # of a script's images, relative to the script

Color = tuple[float, float, float, float]


@dataclass(frozen=True)
class Material:
    """Colours as red, green, blue, alpha; shininess of highlights; a texture; whether it is lit."""

    ambient: Color = (1.0, 1.0, 1.0, 1.0)
    diffuse: Color = (1.0, 1.0, 1.0, 1.0)
    specular: Color = (0.0, 0.0, 0.0, 1.0)
    emissive: Color = (0.0, 0.0, 0.0, 1.0)
    shininess: float = 0.0
    texture: Path | None = None
    lit: bool = True


NEUTRAL = Material((0.3, 0.3, 0.3, 1.0), (0.7, 0.7, 0.7, 1.0))  # for unknown names


@functools.cache
def _known() -> Mapping[str, tuple[Material, str]]:
    """Name without prefix -> material, and the file name of its texture."""
    found = {}
    with TABLE.open(encoding="utf-8", newline="") as table:
        for row in csv.DictReader(table, delimiter="\t"):
            ambient, diffuse, specular, emissive = (_color(row[key].split()) for key in COLORS)
            diffuse = (*diffuse[:3], float(row["alpha"]))
            material = Material(ambient, diffuse, specular, emissive, float(row["shininess"]))
            found[row["name"]] = found[row["name"].replace("Grey", "Gray")] = (material, row["texture"])
    return found


def _color(words: Iterable[str]) -> Color:
    r, g, b, *a = map(float, words)
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
    return replace(material, texture=own_texture(texture)) if material is not None and texture else material


def _of_scripts(name: str, uris: Iterable[str], beside: Path | None) -> Material | None:
    places = [place for uri in uris for place in _place(uri, beside)]
    scripts = (_read_script(script, tuple(places)) for script in _scripts(places))
    return next((found[name] for found in scripts if name in found), None)


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


@functools.lru_cache(maxsize=64)
def _read_script(path: Path, places: tuple[Path, ...]) -> dict[str, Material]:
    """All materials of a script; lines about anything but colours and textures are skipped."""
    try:
        text = read_text(path)
    except OSError:
        return {}
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    folders = [path.parent / sub for sub in TEXTURES]
    folders += [place if is_folder(place) else place.parent for place in places]
    found: dict[str, Material] = {}
    current, depth, header = "", 0, ""
    for line in re.split(r"([{}\n])", re.sub(r"//[^\n]*", "", text)):
        words = line.split()
        if line == "{":
            depth += 1
            if depth == 1:
                current, _, parent = (part.strip(' "') for part in header.partition(":"))
                found[current] = found.get(parent, _known().get(parent.removeprefix(PREFIX), (Material(), ""))[0])
        elif line == "}":
            depth = max(depth - 1, 0)
        elif words and depth == 0:
            header = line.strip().removeprefix("material").strip() if words[0] == "material" else f"({words[0]})"
        elif words:
            found[current] = _with(found[current], words, folders)
    return found


def _with(material: Material, words: list[str], folders: list[Path]) -> Material:
    """A material after one line of a script."""
    key, values = words[0], words[1:]
    if key == "texture" and values:
        name = values[0].strip('"')
        candidates = [folder / name for folder in (*folders, *resource_directories())]
        return replace(material, texture=next((file for file in candidates if is_file(file)), material.texture))
    if key == "lighting" and values:
        return replace(material, lit=values[0] != "off")
    numbers = [_number(value) for value in values]
    if key == "alpha_op_ex" and "src_manual" in values and numbers[-1] is not None:
        return replace(material, diffuse=(*material.diffuse[:3], numbers[-1]))
    if key not in COLORS or len(numbers) < 3 or None in numbers:
        return material
    if key == "specular" and len(numbers) > 3:
        *color, shininess = values
        return replace(material, specular=_color(color), shininess=float(shininess))
    return replace(material, **{key: _color(values)})  # type: ignore[arg-type]


def _number(word: str) -> float | None:
    try:
        return float(word)
    except ValueError:
        return None
