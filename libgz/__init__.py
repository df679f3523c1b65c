"""libgz: worlds, models and controllers of the Gazebo robot simulator, from Python.

The public names stand in `__init__.pyi`, each with the one module it comes from; editors and type checkers read it,
and so does this module when a name is first used. Importing the package costs next to nothing.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from libgz._version import __version__ as __version__
from libgz.base.exports import Exports

# In a source checkout interfaces/, models/ and worlds/ lie beside this package; installed, they lie in it.
_ROOT = Path(__file__).resolve().parent.parent
if not (Path(__file__).parent / "interfaces").is_dir() and (_ROOT / "interfaces" / "position.py").is_file():
    __path__.append(str(_ROOT))


def _missing(name: str) -> Any:
    from libgz.base.errors import nearest

    hint = "" if name.startswith("_") else nearest(name, _exports.sources)  # tools ask for many private names
    if name.endswith("Plugin") or name.startswith("GZ_REGISTER_"):
        hint = f"; from libgz.classic import {name} is for plugins of SDF worlds, see docs/plugins.md"
    raise AttributeError(f"module 'libgz' has no attribute {name!r}{hint}")


_exports = Exports(__name__, _missing)
__getattr__, __dir__ = _exports.get, _exports.names
