"""Gazebo classic's plugins in Python, and the names they use: views on the engine's objects.

Each name is imported when it is first used. A star import brings all but `gui` and `rendering`, which a world without
pictures has no need to load.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # what type checkers see; at run time each is imported when it is first used
    from libgz.classic import (
        common as common,
        event as event,
        math as math,
        msgs as msgs,
        physics as physics,
        rendering as rendering,
        sdf as sdf,
        sensors as sensors,
        transport as transport,
    )
    from libgz.classic.common import gzdbg as gzdbg, gzerr as gzerr, gzlog as gzlog, gzmsg as gzmsg, gzwarn as gzwarn
    from libgz.classic.plugin import (
        GZ_REGISTER_GUI_PLUGIN as GZ_REGISTER_GUI_PLUGIN,
        GZ_REGISTER_MODEL_PLUGIN as GZ_REGISTER_MODEL_PLUGIN,
        GZ_REGISTER_SENSOR_PLUGIN as GZ_REGISTER_SENSOR_PLUGIN,
        GZ_REGISTER_SYSTEM_PLUGIN as GZ_REGISTER_SYSTEM_PLUGIN,
        GZ_REGISTER_VISUAL_PLUGIN as GZ_REGISTER_VISUAL_PLUGIN,
        GZ_REGISTER_WORLD_PLUGIN as GZ_REGISTER_WORLD_PLUGIN,
        GUIPlugin as GUIPlugin,
        ModelPlugin as ModelPlugin,
        SensorPlugin as SensorPlugin,
        SystemPlugin as SystemPlugin,
        VisualPlugin as VisualPlugin,
        WorldPlugin as WorldPlugin,
    )

# Submodules by Gazebo's names; everything else is in libgz.classic.plugin.
_MODULES = ("common", "event", "math", "msgs", "physics", "sdf", "sensors", "transport")
_ON_REQUEST = ("gui", "rendering")
_KINDS = ("GUI", "Model", "Sensor", "System", "Visual", "World")
_PLUGIN = [name for kind in _KINDS for name in (f"{kind}Plugin", f"GZ_REGISTER_{kind.upper()}_PLUGIN")]
_CONSOLE = ("gzdbg", "gzerr", "gzlog", "gzmsg", "gzwarn")

__all__ = [*_MODULES, *_PLUGIN, *_CONSOLE]


def __getattr__(name: str) -> Any:
    if name in _MODULES or name in _ON_REQUEST:
        value: Any = importlib.import_module(f"libgz.classic.{name}")
    elif name in _PLUGIN:
        value = getattr(importlib.import_module("libgz.classic.plugin"), name)
    elif name in _CONSOLE:
        value = getattr(importlib.import_module("libgz.classic.common"), name)
    else:
        from libgz.errors import nearest

        raise AttributeError(f"module 'libgz.classic' has no attribute {name!r}{nearest(name, __all__)}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ON_REQUEST})
