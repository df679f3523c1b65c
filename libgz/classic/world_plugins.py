"""WorldPlugins: the plugins that run in a world, and those that could not be loaded."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, NotFoundError, PluginError, nearest
from libgz.classic.loading import LoadedPlugin, Missing, called, new_plugin, reload_all
from libgz.classic.physics.model import Model
from libgz.classic.physics.world_services import WorldServices
from libgz.classic.ros_names import is_ros_name, notice
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, upgraded

if TYPE_CHECKING:
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["WorldPlugins", "names_of", "plugins_in", "system_plugins"]

log = logging.getLogger("libgz.classic")

PLUGIN = f"<sdf version='{NEWEST}'><model name='any'>%s</model></sdf>"

system_plugins: list[LoadedPlugin] = []  # System plugins belong to the process, not to a world


def plugins_in(element: Element | None) -> Iterator[Element]:
    """The `<plugin>` elements of an element."""
    return element.named("plugin") if element is not None else iter(())


def names_of(element: Element) -> tuple[str, str]:
    """(filename, name) of a `<plugin>`."""
    return element.Get(str, "filename"), element.Get(str, "name")


class WorldPlugins:
    """Loads the plugins of a world and its models, and knows those that its sensors and visuals hold.

    Args:
        server: whose world this is.

    Attributes:
        failures: why plugins could not be loaded: (kind, name of the holder, filename, name) -> reason.
        reloading: whether edited files are loaded again.
    """

    def __init__(self, server: WorldServices) -> None:
        self._server, self._world, self._core = server, server.world, server.world.core
        self._of_world: list[LoadedPlugin] = []
        self._of_models: dict[Model, list[LoadedPlugin]] = {}
        self.failures: dict[tuple[str, str, str, str], str] = {}
        self.reloading = False

    @property
    def _file(self) -> str | None:
        """The path of the world's file, if it has one."""
        element = self._server.element
        return element.file if element is not None and element.file else None

    # Load --------------------------------------------------------------------------------------------------------

    def load_all_of_world(self) -> None:
        """Load the World plugins of the file, in its order."""
        for element in plugins_in(self._server.element):
            self.load_for_world(*names_of(element), element)

    def load_all_of_models(self, models: Iterable[Model]) -> None:
        """Load the Model plugins of the elements of models."""
        for model in models:
            for element in plugins_in(model.GetSDF()):
                count = self._core.problems.count
                if not self.load_for_model(model, *names_of(element), element):
                    self._note_failure(("Model", model.GetScopedName(), *names_of(element)), count)

    def load_for_world(self, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a World plugin; returns whether it runs."""
        with self._core.hold():
            plugin = self.new("World", filename, name, f"World[{self._world.Name()}]", sdf)
            if plugin is not None and plugin.start(self._world, sdf or Element("plugin")):
                plugin.source = _source(sdf, self._server.element)
                self._of_world.append(plugin)
                return True
        return False

    def load_for_model(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin; returns whether it runs."""
        with self._core.hold():
            plugin = self.new("Model", filename, name, f"Model[{model.GetName()}]", sdf, model.core)
            if plugin is not None and plugin.start(model, sdf or Element("plugin")):
                plugin.source = _source(sdf, model.GetSDF())
                self._of_models.setdefault(model, []).append(plugin)
                return True
        return False

    def new(
        self, kind: str, filename: str, name: str, holder: str, sdf: Element | None, entity: CoreModel | None = None
    ) -> LoadedPlugin | None:
        """A plugin of this world, constructed; None if that fails, which is logged."""
        if is_ros_name(filename):
            notice(self._core)
        missing = self._core.extension(Missing)
        where = sdf.where if sdf is not None and sdf.line else ""
        return new_plugin(kind, filename, name, holder, self._core.events, self._file, entity, missing, where)

    def remove_from_world(self, name: str) -> None:
        """Remove a World plugin; of several with one name the first.

        Raises:
            NotFoundError: there is none of this name.
        """
        known = self.of_world
        if name not in known:
            raise NotFoundError(f"world {self._world.Name()!r} has no plugin {name!r}{nearest(name, known)}")
        self._of_world.remove(known[name])
        known[name].drop()

    @property
    def of_world(self) -> dict[str, LoadedPlugin]:
        """World plugins by name; of several with one name the first."""
        return {plugin.name: plugin for plugin in reversed(self._of_world)}

    def running(self) -> Iterator[LoadedPlugin]:
        """All running plugins of this world."""
        for model in self._world.all_models():
            yield from self.of_model(model)
        yield from self._others()

    def _others(self) -> Iterator[LoadedPlugin]:
        """The plugins of the world, of sensors and of visuals."""
        yield from list(self._of_world)
        for part in (self._server.sensors, self._server.visuals):
            if part is not None:
                yield from part.plugins()

    def of_model(self, model: Model) -> list[LoadedPlugin]:
        """The Model plugins of a model, in the order of the file."""
        return list(self._of_models.get(model, ()))

    def reset_of(self, model: Model) -> None:
        """Reset the Model plugins of a model."""
        with self._core.hold():
            for plugin in self.of_model(model):
                plugin.reset()

    def reset(self) -> None:
        """Call Reset of all plugins: those of models, of the world, of sensors and visuals, and System plugins."""
        for model in self._world.all_models():
            self.reset_of(model)
        self.reset_others()

    def reset_others(self) -> None:
        """Call Reset of the plugins that are none of models."""
        for plugin in (*self._others(), *system_plugins):
            plugin.reset()

    def remove_of(self, model: Model) -> None:
        """Drop the Model plugins of a model that is removed."""
        for plugin in self._of_models.pop(model, ()):
            plugin.drop()

    def close(self) -> None:
        """Drop all plugins."""
        for plugin in list(self.running()):
            plugin.drop()

    def check_state(self) -> None:
        """Find out which plugin keeps the state from being encoded."""
        for plugin in self.running():
            plugin.check_state()

    # All of them -------------------------------------------------------------------------------------------------

    def by_holder(self) -> Iterator[tuple[str, str, list[LoadedPlugin]]]:
        """(kind, name of the holder, its plugins) of all holders that have any."""
        if self._of_world:
            yield "World", "", self._of_world
        for model, plugins in self._of_models.items():
            yield "Model", model.GetScopedName(), plugins
        for part in (self._server.sensors, self._server.visuals):
            if part is not None:
                yield from part.plugins_by_holder()

    def present(self) -> Iterator[tuple[str, str, LoadedPlugin]]:
        """(kind, name of the holder, plugin) of all plugins that run."""
        for kind, holder, plugins in self.by_holder():
            yield from ((kind, holder, plugin) for plugin in plugins if plugin.plugin is not None)

    # Reload ------------------------------------------------------------------------------------------------------

    def _all_plugins(self) -> Iterator[tuple[str, str, LoadedPlugin]]:
        """(kind, name of the holder, plugin) of all plugins that were loaded, System plugins included."""
        for kind, holder, plugins in self.by_holder():
            for plugin in plugins:
                yield kind, holder, plugin
        for plugin in system_plugins:
            yield "System", "", plugin

    def _absent(self) -> Iterator[tuple[str, str, str, str]]:
        """(kind, name of the holder, filename, name) of plugins that the file has, but that could not be loaded."""
        present = {(kind, holder, one.filename, one.name) for kind, holder, one in self._all_plugins()}
        for kind, holder, element in self._elements():
            row = kind, holder, *names_of(element)
            if row not in present:
                yield row

    def _elements(self) -> Iterator[tuple[str, str, Element]]:
        """(kind, name of the holder, `<plugin>`) of all that this world's file, or an inserted text, has."""
        for element in plugins_in(self._server.element):
            yield "World", "", element
        for model in self._world.all_models():
            for element in plugins_in(model.GetSDF()):
                yield "Model", model.GetScopedName(), element
        for kind, part in (("Sensor", self._server.sensors), ("Visual", self._server.visuals)):
            for holder, element in part.elements() if part is not None else ():
                yield kind, holder, element

    def plugin_names(self) -> list[str]:
        """What the plugins of this world are called."""
        return [plugin.name for *_, plugin in self._all_plugins()] + [name for *_, name in self._absent()]

    def has_plugin(self, name: str) -> bool:
        """Whether a plugin, or a plugin's file, is called this."""
        return any(one.called(name, holder) for _, holder, one in self._all_plugins()) or any(self._wanted(name))

    def _wanted(self, name: str) -> Iterator[tuple[str, str, str, str]]:
        """Those of `_absent` that are called this."""
        for row in self._absent():
            _, holder, filename, own = row
            if name in (own, filename, f"{holder}::{own}") or called(Path(filename).with_suffix(".py"), name):
                yield row

    def reload_plugin(self, name: str) -> list[str]:
        """Load the files of plugins again, replace their instances, and load those that had failed to load.

        Returns:
            What was replaced, such as ``Model plugin robot1::drive``.

        Raises:
            PluginError: a file or its class fails; the former instance runs on, and the world is as before.
        """
        found = [row for row in self._all_plugins() if row[2].called(name, row[1])]
        absent = list(self._wanted(name))
        before = self._state_before() if found else None
        server = self._core.gz_server
        try:
            with server.hand_over(server.interfaces.values()):
                reload_all([plugin for *_, plugin in found])
            for *_, plugin in found:
                plugin.precede({other for *_, other in self._all_plugins() if other.number > plugin.number})
        except PluginError:
            if before is not None:
                self._core.snapshots.restore(before)
            raise
        for kind, holder, filename, own in absent:
            count = self._core.problems.count
            if self.load_again(kind, holder, filename, own, "") is None:
                failed = self._core.problems.errors_since(count)
                raise PluginError("\n".join(map(str, failed)) or f"plugin {own!r} did not start; the log says why")
        rows = [(kind, holder, plugin.name) for kind, holder, plugin in found]
        rows += [(kind, holder, own) for kind, holder, _, own in absent]
        return [f"{kind} plugin {holder}::{own}" if holder else f"{kind} plugin {own}" for kind, holder, own in rows]

    def _state_before(self) -> bytes | None:
        """The state to return to if a plugin fails; None if this world's state cannot be saved."""
        self.reloading = True
        try:
            return self._core.snapshots.save()
        except GazeboError as error:
            log.debug("the world's state cannot be saved: %s", error)
            return None
        finally:
            self.reloading = False

    def load_again(self, kind: str, holder: str, filename: str, name: str, source: str) -> LoadedPlugin | None:
        """A plugin of a state that ended since, or was loaded at run time in another process."""
        key = kind, holder, filename, name
        if key in self.failures:  # it failed when what holds it was built again
            return None
        owner, load = self._holder(kind, holder)
        if owner is None:
            self.failures[key] = f"there is no {holder}"
            return None
        sdf = self._server.element if kind == "World" else owner.GetSDF()
        own = next((e for e in plugins_in(sdf) if names_of(e) == (filename, name)), None)
        element = SdfFile.from_string(PLUGIN % source).root.children[0].child("plugin") if source else own
        before = {id(plugin) for *_, plugins in self.by_holder() for plugin in plugins}
        count = self._core.problems.count
        load(filename, name, element)
        self._note_failure(key, count)
        plugins = [plugin for *_, plugins in self.by_holder() for plugin in plugins]
        return next((plugin for plugin in plugins if id(plugin) not in before), None)

    def _note_failure(self, plugin: tuple[str, str, str, str], count: int) -> None:
        """Keep why a plugin was not loaded: the first error after so many errors and warnings."""
        added = self._core.problems.errors_since(count)
        if added:
            self.failures[plugin] = added[0].message

    def _holder(self, kind: str, name: str) -> tuple[Any, Callable[[str, str, Element | None], object]]:
        """What holds plugins, and a function that loads one more for it."""
        if kind == "World":
            return self._world, self.load_for_world
        if kind == "Model":
            model = self._world.ModelByName(name)
            return model, lambda *values: self.load_for_model(model, *values) if model is not None else None
        part = self._server.sensors if kind == "Sensor" else self._server.serve_visuals()
        return part.holder(name) if part is not None else (None, print)


def _source(sdf: Element | None, holder: Element | None) -> str:
    """The text of a plugin's element; empty if it stands in its holder's element, or if there is none."""
    return "" if sdf is None or sdf.GetParent() is holder else upgraded(sdf).ToString()
