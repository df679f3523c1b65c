"""SystemPaths: the search paths of plugins, models and other files."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from libgz.base.errors import NotFoundError
from libgz.base.files import exists
from libgz.classic.common.console import gzwarn
from libgz.classic.names import takes_names
from libgz.sdf import paths

__all__ = ["SystemPaths"]


def _append(added: list[Path], text: str) -> None:
    added.extend(path for path in dict.fromkeys(paths.folders_of(text)) if path not in added)


def _texts(folders: list[Path]) -> list[str]:
    return list(dict.fromkeys(map(str, folders)))


def _from_environment(variable: str, added: Callable[[SystemPaths], list[Path]]) -> Any:
    """Whether a variable is read; what it lists stays until folders are cleared."""

    def read(_self: SystemPaths) -> bool:
        return variable not in paths.unread

    def choose(self: SystemPaths, value: bool) -> None:
        if value:
            paths.unread.discard(variable)
        else:
            added(self)[:0] = paths.listed(variable)
            paths.unread.add(variable)

    return property(read, choose)


@takes_names
class SystemPaths:
    """The search paths of the process; `SystemPaths.Instance()` is the only instance.

    The variables GAZEBO_PLUGIN_PATH, GAZEBO_MODEL_PATH and GAZEBO_RESOURCE_PATH are read at each call. Added folders
    are searched after them, until the end of the process; SDF files use added folders of models and resources, too.
    Attributes say whether the variables are read: `pluginPathsFromEnv`, `modelPathsFromEnv`, `gazeboPathsFromEnv`.
    """

    pluginPathsFromEnv = _from_environment("GAZEBO_PLUGIN_PATH", lambda self: self._plugins)
    modelPathsFromEnv = _from_environment("GAZEBO_MODEL_PATH", lambda _self: paths.added_models)
    gazeboPathsFromEnv = _from_environment("GAZEBO_RESOURCE_PATH", lambda _self: paths.added_resources)

    _instance: SystemPaths | None = None

    def __init__(self) -> None:
        self._plugins: list[Path] = []

    @classmethod
    def Instance(cls) -> SystemPaths:
        """The search paths of the process."""
        if cls._instance is None:
            cls._instance = cls()
        return cls._instance

    def GetPluginPaths(self) -> list[str]:
        """The folders in which plugins are searched, in order."""
        return _texts([*paths.listed("GAZEBO_PLUGIN_PATH"), *self._plugins])

    def GetModelPaths(self) -> list[str]:
        """The folders in which `model://` is searched, in order; the last one has the models of libgz."""
        return _texts(paths.model_directories())

    def GetGazeboPaths(self) -> list[str]:
        """The folders in which `file://` and plain names are searched after the current one, in order."""
        return _texts([*paths.listed("GAZEBO_RESOURCE_PATH"), *paths.added_resources])

    def AddPluginPaths(self, path: str) -> None:
        """Add folders of plugins, separated by colons."""
        _append(self._plugins, path)

    def AddModelPaths(self, path: str) -> None:
        """Add folders of models, separated by colons."""
        _append(paths.added_models, path)

    def AddGazeboPaths(self, path: str) -> None:
        """Add folders of other files, separated by colons."""
        _append(paths.added_resources, path)

    def ClearPluginPaths(self) -> None:
        """Remove added folders of plugins."""
        self._plugins.clear()

    def ClearModelPaths(self) -> None:
        """Remove added folders of models."""
        paths.added_models.clear()

    def ClearGazeboPaths(self) -> None:
        """Remove added folders of other files."""
        paths.added_resources.clear()

    def GetLogPath(self) -> str:
        """The folder of log files: GAZEBO_LOG_PATH, or ~/.gazebo. It need not exist."""
        return str(Path(os.environ.get("GAZEBO_LOG_PATH") or "~/.gazebo").expanduser())

    def GetWorldPathExtension(self) -> str:
        """The path of worlds in a resource folder."""
        return "/worlds"

    def FindFile(self, filename: str, searchLocalPath: bool = True) -> str:
        """The path of a file or folder; an empty string, and a warning, if it does not exist.

        Args:
            filename: an absolute path; a URI; or a name, searched in the current folder and in the resource folders.
            searchLocalPath: whether to search the current folder.
        """
        try:
            if searchLocalPath or "://" in filename or Path(filename).is_absolute():
                return str(paths.find_uri(filename)) if filename else ""
            places = (folder / filename for folder in paths.resource_directories()[1:])
            found = next((place for place in places if exists(place)), None)
        except NotFoundError as error:
            gzwarn(error)
            return ""
        if found is None:
            gzwarn(f'File or path does not exist [""] [{filename}]')
        return str(found or "")

    def FindFileURI(self, uri: str) -> str:
        """The path of a URI, `model://name/...` or `file://path`; an empty string and a warning if none exists."""
        return self.FindFile(uri)
