"""What packages of ROS give to Gazebo: folders that they export, and the files that robot descriptions name."""

from __future__ import annotations

import re
from pathlib import Path

from libgz.base.errors import NotFoundError
from libgz.classic.common import SystemPaths
from libgz.sdf.packages import all_packages, find_package, manifest_of
from libgz.sdf.paths import package_directories

__all__ = ["add_exported_folders", "exported_folders", "with_paths"]

URI = re.compile(r"package://([\w.-]+)")
EXPORT = re.compile(r"<gazebo_ros\s([^<>]*)>")  # in <export> of a manifest
FOLDERS = re.compile(r"""(gazebo_model_path|gazebo_media_path)\s*=\s*["']([^"'<>]*)["']""")


def exported_folders() -> dict[str, list[Path]]:
    """The folders that packages export for Gazebo, of gazebo_model_path and gazebo_media_path.

    In a manifest, that is `<export><gazebo_ros gazebo_model_path="${prefix}/models"/></export>`.
    """
    found: dict[str, list[Path]] = {"gazebo_model_path": [], "gazebo_media_path": []}
    for package in all_packages(package_directories()):
        for attributes in EXPORT.findall(manifest_of(package)):
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


def with_paths(text: str) -> str:
    """A robot description with the paths of packages in place of ``package://name``.

    Raises:
        NotFoundError: a package is unknown.
    """
    found: dict[str, str] = {}
    for name in dict.fromkeys(URI.findall(text)):
        folder = find_package(name, package_directories())
        if folder is None:
            raise NotFoundError(f"Package[{name}] does not have a path: it is not in ROS_PACKAGE_PATH")
        found[name] = f"file://{folder}"
    return URI.sub(lambda match: found[match.group(1)], text)
