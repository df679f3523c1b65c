"""ModelFactory: model classes by the names that worldfiles give them."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from libgz.base.errors import ParameterError, PluginError
from libgz.base.trust import trusted
from libgz.legacy.model import Model
from libgz.simulation.plugins import Plugin, collect
from libgz.simulation.world import World

if TYPE_CHECKING:
    from importlib import metadata

__all__ = ["GZ_REGISTER_PLUGIN", "GZ_REGISTER_STATIC", "ModelFactory", "builtin_folder", "register_builtin"]

log = logging.getLogger("libgz.simulation")

M = TypeVar("M", bound="Callable[..., Any]")

ENTRY_POINTS = "libgz.models"  # the group under which installed packages offer models
_builtin: dict[str, str] = {}  # name in worldfiles -> "module:Class"
_builtin_folder = Path()
_static: dict[str, Callable[[World], Model]] = {}


def register_builtin(models: Mapping[str, str], folder: Path) -> None:
    """Offer the built-in models to all worlds.

    Args:
        models: name in worldfiles -> ``"module:Class"``; modules are imported when they are used.
        folder: where the modules are; worlds may name them as plugins.
    """
    global _builtin_folder
    _builtin.update(models)
    _builtin_folder = folder


def builtin_folder() -> Path:
    """The folder of the built-in models."""
    return _builtin_folder


def GZ_REGISTER_PLUGIN(name: str, model: M) -> M:
    """Offer a model class under a worldfile name; the last line of a plugin file.

    Args:
        name: as in `<model:name>`; it need not be the class's own.
        model: the class, a subclass of Model.
    """
    if not callable(model):
        raise ParameterError(f"GZ_REGISTER_PLUGIN({name!r}, ...): {model!r} is not a class")
    if not collect(name, model):
        _static.setdefault(name, model)
    return model


def GZ_REGISTER_STATIC(name: str, model: M) -> M:
    """Offer a model class under a worldfile name to all worlds of this process."""
    _static.setdefault(name, model)
    return model


class ModelFactory:
    """The model classes one world knows: the built-in ones, those of its plugins, and those of installed packages.

    The first registration of a name wins.
    """

    def __init__(self) -> None:
        self._plugins: dict[str, Callable[[World], Model]] = {}
        self._files: dict[str, Path] = {}  # of plugins, by the names that they have registered
        self._builtin: dict[str, str] = {}
        self._packages: dict[str, metadata.EntryPoint] | None = None
        self.RegisterAll()

    def RegisterAll(self) -> None:
        """Register the built-in models."""
        self._builtin = dict(_builtin)

    def RegisterModel(self, type: str, classname: str, fn: Callable[[World], Model]) -> None:
        """Register one class or function World -> Model; `type` is a word for the log."""
        if classname in self._builtin or classname in self._plugins:
            log.debug("%s is registered already; the first registration is used", classname)
            return
        self._plugins[classname] = fn
        log.debug("registered %s (%s)", classname, type)

    def register_plugin(self, plugin: Plugin) -> None:
        """Register all classes of a plugin file."""
        for name, kind in plugin.registered:
            if name in self._builtin:
                log.warning(
                    "plugin %s registers %r, which is a built-in model: the built-in one is used", plugin.path, name
                )
            if name not in self._builtin and name not in self._plugins:
                self._files[name] = plugin.path
            self.RegisterModel("plugin", name, kind)

    def file_of(self, classname: str) -> Path | None:
        """The plugin file that a class comes from; None for one of another origin."""
        return self._files.get(classname)

    def replace_plugin(self, plugin: Plugin) -> dict[str, Callable[[World], Model]]:
        """Take the classes of a plugin file that was edited instead of its former ones, which are returned.

        Raises:
            PluginError: it does not register all of them any more.
        """
        names = [name for name, path in self._files.items() if path == plugin.path]
        registered = dict(reversed(plugin.registered))
        for name in names:
            if name not in registered:
                raise PluginError(f"{plugin.path} does not register {name!r} any more; it has {', '.join(registered)}")
        before = {name: self._plugins[name] for name in names}
        self._plugins.update({name: registered[name] for name in names})
        self.register_plugin(plugin)
        return before

    def return_classes(self, before: Mapping[str, Callable[[World], Model]]) -> None:
        """Take the former classes again, which `replace_plugin` returned."""
        self._plugins.update(before)

    def find(self, classname: str) -> Callable[[World], Model] | None:
        """The class or function of a name, or None if it is unknown."""
        if classname in self._builtin:
            module, _, name = self._builtin[classname].partition(":")
            return getattr(import_module(module), name)  # type: ignore[no-any-return]
        kind = self._plugins.get(classname) or _static.get(classname)
        if kind is None and classname in self._offered():
            kind = self._offered()[classname].load()
        return kind

    def NewModel(self, world: World, classname: str) -> Model | None:
        """A new model, or None if the name is unknown."""
        kind = self.find(classname)
        return None if kind is None else kind(world)

    def knows(self, classname: str) -> bool:
        """Whether a name is built in or was registered; packages that are not in use are not searched."""
        return classname in self._builtin or classname in self._plugins or classname in _static

    def _offered(self) -> dict[str, metadata.EntryPoint]:
        """Models of installed packages; looked up only when a name is unknown otherwise."""
        if not trusted():
            return {}
        if self._packages is None:
            from importlib import metadata  # slow to import

            self._packages = {point.name: point for point in metadata.entry_points(group=ENTRY_POINTS)}
        return self._packages

    def names(self) -> list[str]:
        """All names a worldfile may use here."""
        return sorted({*self._builtin, *self._plugins, *_static, *self._offered()})
