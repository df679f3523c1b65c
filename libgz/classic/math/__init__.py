"""The mathematics of Gazebo classic: vectors, quaternions, poses, inertia, and others.

The names are those of ignition::math (`Vector3d`, `v.X()`, `q.Euler()`) and of the older gazebo::math (`Vector3`,
`v.x`, `q.GetAsEuler()`). The names of Python's own `math` (`sin`, `pi`, ...) are available, too, because
`from libgz.classic import math` hides that module.
"""

from __future__ import annotations

import math as _math
from typing import Any

from libgz.base.exports import Exports
from libgz.classic.api import without

_without = without(__name__)


def _of_python(name: str) -> Any:
    if name.startswith("_") or not hasattr(_math, name):
        return _without(name)
    return getattr(_math, name)


_exports = Exports(__name__, _of_python)
__getattr__, __dir__ = _exports.get, _exports.names
