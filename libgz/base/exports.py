"""Exports: the public names of a package, each imported from its module when it is first used.

They stand in the package's `__init__.pyi`, which editors and type checkers read, too::

    from libgz.classic.math.vector3 import Vector3d as Vector3d

A program that uses few of the names loads few of the modules.
"""

from __future__ import annotations

import functools
import importlib
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

__all__ = ["Exports"]

_IMPORT = re.compile(r"^from (\S+) import (?:\(([^)]*)\)|(.*))$", re.MULTILINE)
_NAME = re.compile(r"(\w+) as (\w+)")


class Exports:
    """The `__getattr__` and `__dir__` of a package.

    Args:
        package: its `__name__`.
        missing: returns the value of a name that is not exported, or raises AttributeError.
    """

    def __init__(self, package: str, missing: Callable[[str], Any]) -> None:
        self._package, self._missing = sys.modules[package], missing

    @functools.cached_property
    def sources(self) -> dict[str, tuple[str, str]]:
        """Exported name -> module, and the name there."""
        file = Path(str(self._package.__file__)).with_suffix(".pyi")
        lines = _IMPORT.findall(file.read_text(encoding="utf-8"))
        return {
            exported: (module, name) for module, *names in lines for name, exported in _NAME.findall("".join(names))
        }

    def get(self, name: str) -> Any:
        """The value of a name, which is an attribute of the package from now on."""
        if name == "__all__":  # a star import
            return sorted(self.sources)
        if name.startswith("_") or name not in self.sources:  # tools ask for many private names
            return self._missing(name)
        module, original = self.sources[name]
        value = getattr(importlib.import_module(module), original)
        setattr(self._package, name, value)
        return value

    def names(self) -> list[str]:
        """What `dir` lists."""
        return sorted({*vars(self._package), *self.sources})
