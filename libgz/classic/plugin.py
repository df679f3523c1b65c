"""The six kinds of plugins: the base classes that users derive from, and how a file registers its class.

This module stands above the packages whose types it names, so that editors complete the arguments of `Load`; at run
time it imports none of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from libgz.base.errors import ParameterError
from libgz.classic.plugin_base import PluginT, PluginType
from libgz.simulation.plugins import collect

if TYPE_CHECKING:
    from libgz.classic.gui import GUI
    from libgz.classic.physics import Model, World
    from libgz.classic.rendering import Visual
    from libgz.classic.sensors import Sensor
    from libgz.sdf.element import Element

__all__ = [
    "GZ_REGISTER_GUI_PLUGIN",
    "GZ_REGISTER_MODEL_PLUGIN",
    "GZ_REGISTER_SENSOR_PLUGIN",
    "GZ_REGISTER_SYSTEM_PLUGIN",
    "GZ_REGISTER_VISUAL_PLUGIN",
    "GZ_REGISTER_WORLD_PLUGIN",
    "GUIPlugin",
    "ModelPlugin",
    "PluginT",
    "PluginType",
    "SensorPlugin",
    "SystemPlugin",
    "VisualPlugin",
    "WorldPlugin",
]

C = TypeVar("C", bound=type)


class WorldPlugin(PluginT):
    """A plugin of a `<world>`."""

    kind = "World"

    def Load(self, world: World, sdf: Element) -> None:
        """Called once: `world` is loaded, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(world, sdf)")


class ModelPlugin(PluginT):
    """A plugin of a `<model>`."""

    kind = "Model"

    def Load(self, model: Model, sdf: Element) -> None:
        """Called once: `model` and its sensors are ready, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(model, sdf)")


class SensorPlugin(PluginT):
    """A plugin of a `<sensor>`."""

    kind = "Sensor"

    def Load(self, sensor: Sensor, sdf: Element) -> None:
        """Called once: `sensor` is ready, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(sensor, sdf)")


class SystemPlugin(PluginT):
    """A plugin of the server or the client, named on the command line; it is loaded before any world."""

    kind = "System"

    def Load(self, argc: int = 0, argv: list[str] | None = None) -> None:
        """Called once, before there is a world: `argv` is the whole command line."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(argc, argv)")


class VisualPlugin(PluginT):
    """A plugin of a `<visual>`; loaded by processes that render the world."""

    kind = "Visual"

    def Load(self, visual: Visual, sdf: Element) -> None:
        """Called once: `visual` is ready, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(visual, sdf)")


class GUIPlugin(PluginT):
    """A plugin of the client, in `<gui>` or on the command line. `gui` is its widget, from Load on."""

    kind = "GUI"
    gui: GUI

    def Load(self, sdf: Element) -> None:
        """Called once: `sdf` is the `<plugin>` element, or an empty one."""


def _registrar(kind: type[PluginT]) -> Callable[[C], C]:
    name = f"GZ_REGISTER_{kind.kind.upper()}_PLUGIN"

    def register(plugin: C) -> C:
        if not (isinstance(plugin, type) and issubclass(plugin, kind)):
            raise ParameterError(f"{name}({plugin!r}): it needs a class that is derived from {kind.__name__}")
        collect(kind.kind, plugin)
        return plugin

    register.__name__ = register.__qualname__ = name
    register.__doc__ = (
        f"Register a {kind.__name__}: as the last line of its file, or as a decorator of its class. One per file."
    )
    return register


GZ_REGISTER_WORLD_PLUGIN = _registrar(WorldPlugin)
GZ_REGISTER_MODEL_PLUGIN = _registrar(ModelPlugin)
GZ_REGISTER_SENSOR_PLUGIN = _registrar(SensorPlugin)
GZ_REGISTER_SYSTEM_PLUGIN = _registrar(SystemPlugin)
GZ_REGISTER_VISUAL_PLUGIN = _registrar(VisualPlugin)
GZ_REGISTER_GUI_PLUGIN = _registrar(GUIPlugin)
