"""Packages of ROS: where they are, by the manifests below the folders of ROS_PACKAGE_PATH."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

from libgz.base.errors import NotFoundError
from libgz.classic.common import SystemPaths

__all__ = ["add_exported_folders", "exported_folders", "find_package", "with_paths"]

DEEPEST = 6  # folders below an entry of the path
MOST_FOLDERS = 20_000
LONGEST_MANIFEST = 10_000  # characters that are read
IGNORED = ("CATKIN_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs")
URI = re.compile(r"package://([\w.-]+)")
EXPORT = re.compile(r"<gazebo_ros\s([^<>]*)>")  # in <export> of a manifest
FOLDERS = re.compile(r"""(gazebo_model_path|gazebo_media_path)\s*=\s*["']([^"'<>]*)["']""")


def _packages(folder: Path, depth: int, count: list[int]) -> Iterator[Path]:
    """The folders of packages in a folder, itself included."""
    count[0] += 1
    if depth > DEEPEST or count[0] > MOST_FOLDERS:
        return
    try:
        with os.scandir(folder) as found:
            entries = {entry.name: entry for entry in found}
    except OSError:
        return
    if any(name in entries for name in IGNORED[:2]):
        return
    if "package.xml" in entries or "manifest.xml" in entries:
        yield folder
        return
    if IGNORED[2] in entries:
        return
    for name, entry in sorted(entries.items()):
        if not name.startswith(".") and entry.is_dir():
            yield from _packages(Path(entry.path), depth + 1, count)


def _all_packages() -> Iterator[Path]:
    """The folders of all packages of ROS_PACKAGE_PATH and AMENT_PREFIX_PATH."""
    places = [Path(part) for part in os.environ.get("ROS_PACKAGE_PATH", "").split(":") if part]
    places += [Path(part) / "share" for part in os.environ.get("AMENT_PREFIX_PATH", "").split(":") if part]
    count = [0]
    for place in places:
        yield from _packages(place, 0, count)


def exported_folders() -> dict[str, list[Path]]:
    """The folders that packages export for Gazebo, of gazebo_model_path and gazebo_media_path.

    In a manifest, that is `<export><gazebo_ros gazebo_model_path="${prefix}/models"/></export>`.
    """
    found: dict[str, list[Path]] = {"gazebo_model_path": [], "gazebo_media_path": []}
    for package in _all_packages():
        for attributes in EXPORT.findall(_manifest(package)):
            for name, value in FOLDERS.findall(attributes):
                parts = value.replace("${prefix}", str(package)).split(":")
                found[name] += [Path(part) for part in parts if Path(part).is_absolute()]
    return found


def add_exported_folders() -> None:
    """Search what packages export for Gazebo from now on, as its paths plugin does in servers and clients.

    It is no use to wait for a look-up: these folders come before those of the models that nearly all worlds include.
    """
    paths, exported = SystemPaths.Instance(), exported_folders()
    for name, add in (("gazebo_model_path", paths.AddModelPaths), ("gazebo_media_path", paths.AddGazeboPaths)):
        for folder in exported[name]:
            add(str(folder))


def find_package(name: str) -> Path:
    """The folder of a package.

    Raises:
        NotFoundError: there is none of this name in ROS_PACKAGE_PATH.
    """
    for folder in _all_packages():
        if folder.name == name or _manifest_name(folder) == name:
            return folder
    raise NotFoundError(f"Package[{name}] does not have a path: it is not in ROS_PACKAGE_PATH")


def _manifest(folder: Path) -> str:
    """The beginning of the manifest of a package; empty where it cannot be read."""
    try:
        with (folder / "package.xml").open(errors="replace") as file:
            return file.read(LONGEST_MANIFEST)
    except OSError:
        return ""


def _manifest_name(folder: Path) -> str:
    match = re.search(r"<name>\s*([\w.-]+)\s*</name>", _manifest(folder))
    return match.group(1) if match else ""


def with_paths(text: str) -> str:
    """A robot description with the paths of packages in place of ``package://name``.

    Raises:
        NotFoundError: a package is unknown.
    """
    found: dict[str, str] = {}
    for name in dict.fromkeys(URI.findall(text)):
        found[name] = f"file://{find_package(name)}"
    return URI.sub(lambda match: found[match.group(1)], text)
