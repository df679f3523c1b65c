"""Functions of files."""

from __future__ import annotations

import os
from pathlib import Path

from libgz.classic.common.system_paths import SystemPaths
from libgz.classic.names import takes_names

__all__ = ["cwd", "exists", "find_file", "find_file_path", "getEnv", "isDirectory", "isFile"]


def find_file(file: str, searchLocalPath: bool = True) -> str:
    """The path of a file; an empty string, and a warning, if it does not exist; see SystemPaths.FindFile."""
    return SystemPaths.Instance().FindFile(file, searchLocalPath)


def find_file_path(file: str) -> str:
    """The folder of a file; an empty string, and a warning, if it does not exist."""
    found = find_file(file)
    return str(Path(found).parent) if found else ""


def exists(path: str) -> bool:
    """Whether there is a file or folder."""
    return Path(path).exists()


def isFile(path: str) -> bool:
    """Whether there is a file."""
    return Path(path).is_file()


def isDirectory(path: str) -> bool:
    """Whether there is a folder."""
    return Path(path).is_dir()


def cwd() -> str:
    """The current folder."""
    return str(Path.cwd())


@takes_names
def getEnv(name: str) -> str:
    """The value of an environment variable; an empty string for none."""
    return os.environ.get(name, "")
