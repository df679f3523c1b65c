"""Gazebo classic's plugins in Python, and the names they use: views on the engine's objects.

Each name is imported when it is first used. A star import brings all but `gui` and `rendering`, which a world without
cameras does not need to load.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # for type checkers; at run time each is imported when it is first used
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
    from libgz.classic.common import (
        gzdbg as gzdbg,
        gzerr as gzerr,
        gzlog as gzlog,
        gzmsg as gzmsg,
        gzthrow as gzthrow,
        gzwarn as gzwarn,
    )
    from libgz.classic.plugin import (
        GZ_REGISTER_GUI_PLUGIN as GZ_REGISTER_GUI_PLUGIN,
        GZ_REGISTER_MODEL_PLUGIN as GZ_REGISTER_MODEL_PLUGIN,
        GZ_REGISTER_SENSOR_PLUGIN as GZ_REGISTER_SENSOR_PLUGIN,
        GZ_REGISTER_SYSTEM_PLUGIN as GZ_REGISTER_SYSTEM_PLUGIN,
        GZ_REGISTER_VISUAL_PLUGIN as GZ_REGISTER_VISUAL_PLUGIN,
        GZ_REGISTER_WORLD_PLUGIN as GZ_REGISTER_WORLD_PLUGIN,
        GUIPlugin as GUIPlugin,
        ModelPlugin as ModelPlugin,
        PluginType as PluginType,
        SensorPlugin as SensorPlugin,
        SystemPlugin as SystemPlugin,
        VisualPlugin as VisualPlugin,
        WorldPlugin as WorldPlugin,
    )

# Public name -> the module that has it; a module by its own name.
_MODULES = ("common", "event", "math", "msgs", "physics", "sdf", "sensors", "transport")
_ON_REQUEST = ("gui", "rendering")
_NAMES = {
    "GUIPlugin": "plugin",
    "GZ_REGISTER_GUI_PLUGIN": "plugin",
    "ModelPlugin": "plugin",
    "PluginType": "plugin",
    "GZ_REGISTER_MODEL_PLUGIN": "plugin",
    "SensorPlugin": "plugin",
    "GZ_REGISTER_SENSOR_PLUGIN": "plugin",
    "SystemPlugin": "plugin",
    "GZ_REGISTER_SYSTEM_PLUGIN": "plugin",
    "VisualPlugin": "plugin",
    "GZ_REGISTER_VISUAL_PLUGIN": "plugin",
    "WorldPlugin": "plugin",
    "GZ_REGISTER_WORLD_PLUGIN": "plugin",
    "gzdbg": "common",
    "gzerr": "common",
    "gzlog": "common",
    "gzmsg": "common",
    "gzthrow": "common",
    "gzwarn": "common",
}

__all__ = [*_MODULES, *_NAMES]


def __getattr__(name: str) -> Any:
    if name not in _NAMES and name not in (*_MODULES, *_ON_REQUEST):
        from libgz.classic.api import without

        return without(__name__)(name)
    module = importlib.import_module(f"libgz.classic.{_NAMES.get(name, name)}")
    value = getattr(module, name) if name in _NAMES else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_ON_REQUEST})
