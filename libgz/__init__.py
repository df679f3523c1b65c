"""libgz: worlds, models and controllers of the Gazebo robot simulator, from Python.

The public names stand in `__init__.pyi`, each with the one module it comes from; editors and type checkers read it,
and so does this module when a name is first used. Importing the package costs next to nothing.
"""

from __future__ import annotations

import ast
import functools
import importlib
from pathlib import Path
from typing import Any

from libgz._version import __version__ as __version__

# In a source checkout interfaces/, models/ and worlds/ lie beside this package; installed, they lie in it.
_ROOT = Path(__file__).resolve().parent.parent
if not (Path(__file__).parent / "interfaces").is_dir() and (_ROOT / "interfaces" / "position.py").is_file():
    __path__.append(str(_ROOT))


@functools.cache
def _exports() -> dict[str, str]:
    """Public name -> module."""
    tree = ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: node.module or "" for node in imports for alias in node.names}


def __getattr__(name: str) -> Any:
    if name == "__all__":  # from libgz import *
        return sorted(_exports())
    if name.startswith("_") or name not in _exports():
        from libgz.base.errors import nearest

        hint = "" if name.startswith("_") else nearest(name, _exports())  # tools ask for many private names
        if name.endswith("Plugin") or name.startswith("GZ_REGISTER_"):
            hint = f"; from libgz.classic import {name} is for plugins of SDF worlds, see docs/plugins.md"
        raise AttributeError(f"module 'libgz' has no attribute {name!r}{hint}")
    value = getattr(importlib.import_module(_exports()[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *_exports()])
