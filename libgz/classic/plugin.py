"""The six kinds of plugins: what users subclass, how a file registers its class, and how a plugin is called."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, TypeVar

from libgz.errors import ParameterError
from libgz.sdf.element import Element
from libgz.simulation.plugins import collect

if TYPE_CHECKING:
    from libgz.classic.gui import GUI
    from libgz.classic.physics import Model, World
    from libgz.classic.rendering import Visual
    from libgz.classic.sensors import Sensor

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
    "SensorPlugin",
    "SystemPlugin",
    "VisualPlugin",
    "WorldPlugin",
]

console = logging.getLogger("libgz.classic.console")

T = TypeVar("T")
C = TypeVar("C", bound=type)


class PluginT:
    """Base of all plugins."""

    kind: ClassVar[str] = ""
    _handle = ""
    _filename = ""

    def GetFilename(self) -> str:
        """The file as the world names it."""
        return self._filename

    def GetHandle(self) -> str:
        """The plugin's name in the world."""
        return self._handle

    def GetType(self) -> str:
        """The kind: World, Model, Sensor, System, Visual or GUI."""
        return self.kind

    def LoadParam(self, sdf: Element, name: str, default: T) -> T:
        """The value of a child of the plugin's element, or `default`; either is told on the console."""
        value, found = sdf.Get(type(default), name, default)
        handle = self._handle
        if found:
            console.info("%s Plugin <%s> set to <%s>", handle, name, value)
        else:
            console.info("%s Plugin missing <%s>, defaults to <%s>", handle, name, value)
        return value

    def Init(self) -> None:
        """Called right after Load."""

    def Reset(self) -> None:
        """Called when the world is reset."""


class WorldPlugin(PluginT):
    """A plugin of a `<world>`."""

    kind = "World"

    def Load(self, world: World, sdf: Element) -> None:
        """Begin: `world` is loaded, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(world, sdf)")


class ModelPlugin(PluginT):
    """A plugin of a `<model>`."""

    kind = "Model"

    def Load(self, model: Model, sdf: Element) -> None:
        """Begin: `model` and its sensors are ready, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(model, sdf)")


class SensorPlugin(PluginT):
    """A plugin of a `<sensor>`."""

    kind = "Sensor"

    def Load(self, sensor: Sensor, sdf: Element) -> None:
        """Begin: `sensor` is ready, `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(sensor, sdf)")


class SystemPlugin(PluginT):
    """A plugin of the server or the client, named on the command line; it comes before any world."""

    kind = "System"

    def Load(self, argc: int = 0, argv: list[str] | None = None) -> None:
        """Begin, before there is a world: `argv` is the whole command line."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(argc, argv)")


class VisualPlugin(PluginT):
    """A plugin of a `<visual>`; loaded where pictures are drawn."""

    kind = "Visual"

    def Load(self, visual: Visual, sdf: Element) -> None:
        """Begin: `sdf` is the `<plugin>` element."""
        raise NotImplementedError(f"{type(self).__name__} has no Load(visual, sdf)")


class GUIPlugin(PluginT):
    """A plugin of the client, in `<gui>` or on the command line. `gui` is its place there once it is loaded."""

    kind = "GUI"
    gui: GUI

    def Load(self, sdf: Element) -> None:
        """Begin; `sdf` is the `<plugin>` element, or an empty one."""


KINDS = {kind.kind: kind for kind in (WorldPlugin, ModelPlugin, SensorPlugin, SystemPlugin, VisualPlugin, GUIPlugin)}


def _registrar(kind: type[PluginT]) -> Callable[[C], C]:
    name = f"GZ_REGISTER_{kind.kind.upper()}_PLUGIN"

    def register(plugin: C) -> C:
        if not (isinstance(plugin, type) and issubclass(plugin, kind)):
            raise ParameterError(f"{name}({plugin!r}): it needs a class that is derived from {kind.__name__}")
        collect(kind.kind, plugin)
        return plugin

    register.__name__ = register.__qualname__ = name
    register.__doc__ = f"Offer a {kind.__name__}: the last line of its file, or a decorator of its class. One a file."
    return register


GZ_REGISTER_WORLD_PLUGIN = _registrar(WorldPlugin)
GZ_REGISTER_MODEL_PLUGIN = _registrar(ModelPlugin)
GZ_REGISTER_SENSOR_PLUGIN = _registrar(SensorPlugin)
GZ_REGISTER_SYSTEM_PLUGIN = _registrar(SystemPlugin)
GZ_REGISTER_VISUAL_PLUGIN = _registrar(VisualPlugin)
GZ_REGISTER_GUI_PLUGIN = _registrar(GUIPlugin)
