"""Environment: the Python that has the user's rclpy: that of a sourced ROS 2, or of an environment that libgz made."""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from libgz.base.errors import LibraryError

__all__ = ["VARIABLE", "default_environment", "find_python"]

VARIABLE = "LIBGZ_ROS2_PYTHON"
INDEX = Path("share/ament_index/resource_index/packages")  # of a prefix of ROS 2: the names of its packages


def default_environment() -> Path:
    """Where `libgz ros venv` makes its environment, unless another folder is given."""
    return Path.home() / ".local" / "share" / "libgz" / "ros2"


def find_python() -> Path:
    """The Python that has rclpy: of LIBGZ_ROS2_PYTHON; of a sourced ROS 2; of the environment of `libgz ros venv`.

    Raises:
        LibraryError: there is none of these.
    """
    if given := os.environ.get(VARIABLE):
        path = Path(given)
        return path / "bin" / "python3" if path.is_dir() else path
    prefixes = [Path(part) for part in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if part]
    sourced = any((prefix / INDEX / "rclpy").exists() for prefix in prefixes)
    made = default_environment() / "bin" / "python3"
    if made.exists() and not sourced:
        return made
    found = _python_of_system() if prefixes else None
    if found is not None:
        return found
    if made.exists():
        return made
    raise LibraryError(
        "there is no ROS 2: source one, such as /opt/ros/jazzy/setup.bash; or run `libgz ros venv`, which makes an "
        f"environment with rclpy; or set {VARIABLE} to a Python that has it"
    )


def _python_of_system() -> Path | None:
    """The first Python in PATH that is not that of libgz's own environment."""
    own = Path(sys.prefix) / "bin"
    places = [part for part in os.environ.get("PATH", "").split(os.pathsep) if Path(part).is_absolute()]
    path = os.pathsep.join(part for part in places if sys.prefix == sys.base_prefix or Path(part) != own)
    found = shutil.which("python3", path=path)
    return Path(found) if found is not None else None
