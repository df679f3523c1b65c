"""Search paths of SDF files: models and media by URI, never on the network."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from lxml import etree

from libgz.base.errors import Diagnostics, NotFoundError, WorldFileError
from libgz.base.files import exists, expand, is_file, read_limited
from libgz.base.numbers import whole_number
from libgz.base.visible import one_line
from libgz.sdf.packages import find_package
from libgz.sdf.xml import parse_document

__all__ = [
    "find_model",
    "find_uri",
    "find_world",
    "folders_of",
    "listed",
    "model_directories",
    "package_directories",
    "resource_directories",
]

log = logging.getLogger("libgz.sdf")

# Folders that plugins add at run time; they come after those of the environment variables.
added_models: list[Path] = []
added_resources: list[Path] = []
unread: set[str] = set()  # environment variables that plugins have excluded

BUILT_IN = Path(__file__).parent / "models"  # ground_plane and sun
OLD_SUFFIXES = (".model", ".light")  # of models in Gazebo 1, before they had folders
MODEL_SCHEMES = ("model", "package")  # the second one is of ROS, where models lie in packages
MOST_PARTS, LARGEST_PART = 3, 99  # of a version
MEDIA = ("", "models", "media/models", "Media/models")


def folders_of(text: str) -> list[Path]:
    """The folders of a list that is separated by colons."""
    return [expand(part) for part in text.split(":") if part]


def listed(variable: str) -> list[Path]:
    """The folders that an environment variable lists; none if plugins have excluded it."""
    return folders_of("" if variable in unread else os.environ.get(variable, ""))


def model_directories() -> list[Path]:
    """Folders of `model://` URIs, in order: ~/.gazebo/models, GAZEBO_MODEL_PATH, added ones, those of libgz, of ROS."""
    listed_first = [expand("~/.gazebo/models"), *listed("GAZEBO_MODEL_PATH"), *added_models, BUILT_IN]
    return [*listed_first, *package_directories()]


def package_directories() -> list[Path]:
    """Folders in which packages of ROS lie, or below which they do."""
    return [*listed("ROS_PACKAGE_PATH"), *(prefix / "share" for prefix in listed("AMENT_PREFIX_PATH"))]


def resource_directories() -> list[Path]:
    """Folders of files: the current directory, GAZEBO_RESOURCE_PATH, added ones and libgz's, and the usual in these."""
    folders = [*listed("GAZEBO_RESOURCE_PATH"), *added_resources, BUILT_IN.parent]
    return [Path.cwd(), *(folder / sub for folder in folders for sub in MEDIA)]


def find_uri(uri: str, beside: Path | None = None) -> Path:
    """The file or folder of a URI: `model://name/...`, `package://name/...`, `file://path`, or a plain path.

    Args:
        uri: as written. A package may lie anywhere below the folders of ROS_PACKAGE_PATH, and is found by the name in
            its manifest, as rospack finds it.
        beside: folder of the file that contains the URI; plain paths are tried there first. A model or package that is
            nowhere else may be one of the folders around it, or stand beside one of them or in its folder `models`.

    Raises:
        NotFoundError: it does not exist; the message lists the places tried.
    """
    scheme, separator, rest = uri.strip().partition("://")
    if not separator:
        scheme, rest = "", uri.strip()
    if scheme in ("http", "https"):
        return _downloaded(uri)
    if scheme not in ("", "file", *MODEL_SCHEMES):
        known = "model://, package:// and file:// are"
        raise NotFoundError(f"Unable to find uri[{one_line(uri)}]: {one_line(scheme)}:// is not known; {known}")
    if scheme in MODEL_SCHEMES:
        folders = [*model_directories(), *_around(rest.partition("/")[0], beside)]
    else:
        folders = [*([beside] if beside else []), *resource_directories()]
    places = [Path(rest)] if Path(rest).is_absolute() else [folder / rest for folder in folders]
    for place in places:
        if exists(place):
            return place
    if scheme in MODEL_SCHEMES and beside is not None and rest.partition("/")[0] not in ("", ".", ".."):
        for folder in (beside.absolute(), *beside.absolute().parents):
            for place in (folder / rest, folder / "models" / rest):
                if exists(place):
                    return place
    if scheme in MODEL_SCHEMES:
        name, _, inside = rest.partition("/")
        package = find_package(name, package_directories())
        if package is not None and exists(package / inside):
            return package / inside
    tried = one_line(", ".join(dict.fromkeys(map(str, places))))
    advice = "; set GAZEBO_MODEL_PATH" if scheme in MODEL_SCHEMES else "; set GAZEBO_RESOURCE_PATH"
    raise NotFoundError(f"Unable to find uri[{one_line(uri)}]; looked for {tried}{advice}")


def _downloaded(uri: str) -> Path:
    """The model that an address of the network names, if it is on disk: `.../models/Ground Plane` is `ground_plane`.

    Raises:
        NotFoundError: it is not.
    """
    parts = [part for part in uri.strip().split("/") if part]
    name = parts[parts.index("models") + 1] if "models" in parts[:-1] else parts[-1]
    for folder in model_directories():
        for place in (folder / name, folder / name.lower().replace(" ", "_").replace("%20", "_")):
            if exists(place):
                return place
    raise NotFoundError(f"Unable to find uri[{one_line(uri)}]: libgz never looks on the network; put the model on disk")


def _around(name: str, beside: Path | None) -> list[Path]:
    """The folder that holds a model or package of this name, if `beside` is in it; or is one itself, of ROS."""
    inside = [folder for folder in (beside.absolute(), *beside.absolute().parents) if name] if beside else []
    paths = listed("ROS_PACKAGE_PATH")  # which may name packages themselves
    return [folder.parent for folder in (*inside, *paths) if folder.name == name]


def find_world(name: str) -> Path:
    """A world's file: the path as given, in GAZEBO_RESOURCE_PATH, or among the worlds of libgz.

    Raises:
        NotFoundError: it does not exist; the message lists the places tried.
    """
    path = expand(name)
    places = [path] if path.is_absolute() else [folder / path for folder in (*resource_directories(), BUILT_IN.parent)]
    for place in places:
        if is_file(place):
            return place
    tried = ", ".join(dict.fromkeys(map(str, places)))
    raise NotFoundError(f"there is no world {name!r}; looked for {tried}; set GAZEBO_RESOURCE_PATH")


def find_model(uri: str, beside: Path | None = None) -> Path:
    """The SDF file of an included model: the URI's file, or that of the highest version in its `model.config`.

    Raises:
        NotFoundError: there is no such model, or its folder names no SDF file.
    """
    try:
        place = find_uri(uri, beside)
    except NotFoundError:
        name = Path(uri.strip())
        if name.suffix not in OLD_SUFFIXES or "://" in uri:
            raise
        place = find_uri(f"model://{name.stem}", beside)
    return place if is_file(place) else _named_in_config(place)


def _named_in_config(folder: Path) -> Path:
    config = next((folder / name for name in ("model.config", "manifest.xml") if is_file(folder / name)), None)
    if config is None:
        raise NotFoundError(f"{folder} has no model.config")
    diagnostics = Diagnostics()
    try:
        files = parse_document(read_limited(config), str(config), diagnostics).findall("sdf")
    except (OSError, WorldFileError) as error:
        raise NotFoundError(f"{config} cannot be read: {error}") from None
    for remark in (*diagnostics.errors, *diagnostics.warnings):
        log.warning("%s", remark)
    if not files:
        raise NotFoundError(f"{config} names no <sdf> file")

    def version(element: etree._Element) -> tuple[int, ...]:
        words = (element.get("version") or "0").split(".")[:MOST_PARTS]
        numbers = (whole_number(word, LARGEST_PART) for word in words)
        return tuple(number for number in numbers if number is not None)

    supported = [f for f in files if version(f) <= (1, 6)] or files
    best = max(supported, key=version)
    return folder / (best.text or "").strip()
