"""Packages of ROS, by the manifests that are anywhere below some folders, as rospack finds them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from libgz.base.files import is_folder, open_file

__all__ = ["all_packages", "find_package", "manifest_of"]

DEEPEST = 6  # folders below an entry of the path
MOST_FOLDERS = 20_000
LONGEST_MANIFEST = 10_000  # [byte] that are read
IGNORED = ("CATKIN_IGNORE", "COLCON_IGNORE", "rospack_nosubdirs")
NAME = re.compile(r"<name>\s*([\w.-]+)\s*</name>")


def all_packages(places: Sequence[Path]) -> Iterator[Path]:
    """The folders of all packages in some folders, these included."""
    count = [0]
    for place in places:
        yield from _packages(place, 0, count)


def find_package(name: str, places: Sequence[Path]) -> Path | None:
    """The folder of a package in some folders: that of its manifest's name, or else of this name itself.

    What is there is looked for once, and again when something comes or goes directly in these folders.
    """
    return _named(tuple(places), tuple(map(_changed, places))).get(name)


def manifest_of(folder: Path) -> str:
    """The beginning of the manifest of a package; empty where it cannot be read."""
    try:
        with open_file(folder / "package.xml") as file:
            return file.read(LONGEST_MANIFEST).decode(errors="replace")
    except OSError:
        return ""


def _packages(folder: Path, depth: int, count: list[int]) -> Iterator[Path]:
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
        path = Path(entry.path)
        if not name.startswith(".") and (is_folder(path) if entry.is_symlink() else entry.is_dir()):
            yield from _packages(path, depth + 1, count)


def _changed(place: Path) -> int:
    try:
        return place.stat().st_mtime_ns
    except OSError:
        return 0


@lru_cache(maxsize=4)
def _named(places: tuple[Path, ...], _changed: tuple[int, ...]) -> Mapping[str, Path]:
    folders: dict[str, Path] = {}
    manifests: dict[str, Path] = {}
    for folder in all_packages(places):
        folders.setdefault(folder.name, folder)
        if match := NAME.search(manifest_of(folder)):
            manifests.setdefault(match.group(1), folder)
    return folders | manifests
