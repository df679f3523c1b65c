"""WorldServer: the companion that gives an SDF world the sensors, plugins and topics of Gazebo classic."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING

from libgz.classic.commands import PausedSteps
from libgz.classic.loading import LoadedPlugin, new_plugin
from libgz.classic.physics.activity import Activity
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.world import World
from libgz.classic.topics import WorldTopics
from libgz.errors import NotFoundError, nearest
from libgz.sdf.element import Element
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.link import Link
    from libgz.classic.rendering.plugins import VisualPlugins
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["WorldServer", "attach", "system_plugins"]

log = logging.getLogger("libgz.classic")

system_plugins: list[LoadedPlugin] = []  # System plugins belong to the process, not to a world


def attach(core: CoreWorld) -> WorldServer:
    """The WorldServer of a world, created on first use; it starts at once if the world runs."""
    if core.facade is not None:
        server: WorldServer = core.facade.server
        return server
    server = WorldServer(core)
    core.companions.append(server)
    if core.running:
        server.start()
    return server


class WorldServer:
    """Creates sensors, plugins and topics of a world, and updates them.

    All calls are made in one thread and in a fixed order, so that runs of a world can be repeated.

    Args:
        core: the engine's world.
        quiet: without topics, for a client's copy of a world.

    Attributes:
        element: the `<world>` element; None if the world was not loaded from SDF.
        world: the view on the world.
        activity: joint controllers, batteries, animations and attached models.
        physics, presets: settings of the engine, and their profiles.
        paused_steps: requested iterations of a paused world.
        sensors, visuals: sensors and Visual plugins; None as long as there are none.
        topics: the topics; None if quiet.
        stopped: whether World.Stop was called.
    """

    def __init__(self, core: CoreWorld, quiet: bool = False) -> None:
        self.core = core
        file = core.extension(SdfWorld).file
        root = file.root if file is not None else None
        self.element = next(root.named("world"), root) if root is not None else None
        self.world = core.facade = World(core, self)
        self.activity = Activity(self.world)
        self.physics = PhysicsEngine(self.world)
        self.presets = PresetManager(self.world)
        self.paused_steps = PausedSteps(core)
        self._world_plugins: list[LoadedPlugin] = []
        self._model_plugins: dict[Model, list[LoadedPlugin]] = {}
        self.sensors: WorldSensors | None = None
        self.topics = None if quiet else WorldTopics(self.world, self.paused_steps)
        self.visuals: VisualPlugins | None = None
        self.stopped = False
        self._new: list[CoreModel] = list(core.entities)
        self._started = False

    @property
    def filename(self) -> str | None:
        """The path of the world's file, if it has one."""
        return self.element.file if self.element is not None and self.element.file else None

    # Start -------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Create sensors and their plugins, then World plugins in the order of the file, then Model plugins.

        Insertions, removals and resets that plugins request meanwhile are deferred until all are loaded.
        """
        self._started = True
        with self.core.hold():
            self.core.events["WorldCreated"](self.world.Name())
            added, self._new = self._new, []
            self._add_sensors(added)
            for element in self._plugins_of(self.element):
                self.load_world_plugin(*_names(element), element)
            self._load_model_plugins(added)

    @staticmethod
    def _plugins_of(element: Element | None) -> Iterator[Element]:
        return element.named("plugin") if element is not None else iter(())

    def finish_added(self) -> None:
        """Create sensors and plugins of models that were inserted."""
        while self._new and self._started:
            added, self._new = self._new, []
            self._add_sensors(added)
            self._load_model_plugins(added)
            if self.topics is not None:
                for model in self._models(added):
                    self.topics.model_added(model)

    def _add_sensors(self, added: list[CoreModel]) -> None:
        for core in added:
            for part in self._models([core]):
                for link in part.GetLinks():
                    self._create_sensors(link)
                for joint in part.GetJoints():
                    self._create_sensors(joint)
        if self.sensors is not None:
            self.sensors.start_new()
            if self.sensors.renders:
                self.serve_visuals().add(added)

    def _create_sensors(self, holder: Link | Joint) -> bool:
        """Create the sensors of a link's or joint's element; returns whether there are any."""
        elements = list(_named(holder.GetSDF(), "sensor"))
        for element in elements:
            self.all_sensors().create(holder, element)
        return bool(elements)

    def joint_added(self, joint: Joint) -> None:
        """Add a new joint to controllers, and create its sensors."""
        self.activity.joint_added(joint)
        if self._started and self._create_sensors(joint):
            with self.core.hold():
                self.all_sensors().start_new()

    def joint_removed(self, joint: Joint) -> None:
        """Remove a joint from controllers, and remove its sensors."""
        self.activity.joint_removed(joint)
        if self.sensors is not None:
            self.sensors.remove_on(joint)

    def all_sensors(self) -> WorldSensors:
        """The sensors, created on first use."""
        if self.sensors is None:
            from libgz.classic.sensors.manager import WorldSensors

            self.sensors = WorldSensors(self.world)
        return self.sensors

    def serve_visuals(self) -> VisualPlugins:
        """The Visual plugins, created on first use: from then on those of new models are loaded, too."""
        if self.visuals is None:
            from libgz.classic.rendering.plugins import VisualPlugins

            self.visuals = VisualPlugins(self.world)
        return self.visuals

    def _models(self, cores: list[CoreModel]) -> list[Model]:
        return [self.world.view(core) for core in cores if core.is_model]

    def _load_model_plugins(self, added: list[CoreModel]) -> None:
        for model in self._models(added):
            for element in self._plugins_of(model.GetSDF()):
                self.load_model_plugin(model, *_names(element), element)

    # Plugins -----------------------------------------------------------------------------------------------------

    def load_world_plugin(self, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a World plugin; returns whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("World", filename, name, f"World[{self.world.Name()}]")
            if plugin is not None and plugin.start(self.world, sdf or Element("plugin")):
                self._world_plugins.append(plugin)
                return True
        return False

    def load_model_plugin(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin; returns whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("Model", filename, name, f"Model[{model.GetName()}]", model.core)
            if plugin is not None and plugin.start(model, sdf or Element("plugin")):
                self._model_plugins.setdefault(model, []).append(plugin)
                return True
        return False

    def new_plugin(
        self, kind: str, filename: str, name: str, holder: str, entity: CoreModel | None = None
    ) -> LoadedPlugin | None:
        """A plugin of this world, constructed; None if that fails, which is logged."""
        return new_plugin(kind, filename, name, holder, self.core.events, self.filename, entity)

    def remove_world_plugin(self, name: str) -> None:
        """Remove a World plugin; of several with one name the first.

        Raises:
            NotFoundError: there is none of this name.
        """
        known = self.world_plugins
        if name not in known:
            raise NotFoundError(f"world {self.world.Name()!r} has no plugin {name!r}{nearest(name, known)}")
        self._world_plugins.remove(known[name])
        known[name].drop()

    @property
    def world_plugins(self) -> dict[str, LoadedPlugin]:
        """World plugins by name; of several with one name the first."""
        return {plugin.name: plugin for plugin in reversed(self._world_plugins)}

    def plugins(self) -> Iterator[LoadedPlugin]:
        """All running plugins of this world."""
        for model in self.world.all_models():
            yield from self.model_plugins(model)
        yield from self._other_plugins()

    def _other_plugins(self) -> Iterator[LoadedPlugin]:
        """The plugins of the world, of sensors and of visuals."""
        yield from list(self._world_plugins)
        for part in (self.sensors, self.visuals):
            if part is not None:
                yield from part.plugins()

    def model_plugins(self, model: Model) -> list[LoadedPlugin]:
        """The Model plugins of a model, in the order of the file."""
        return list(self._model_plugins.get(model, ()))

    def reset_plugins(self, model: Model) -> None:
        """Reset the Model plugins of a model."""
        with self.core.hold():
            for plugin in self.model_plugins(model):
                plugin.reset()

    # Companion of the world --------------------------------------------------------------------------------------

    def model_added(self, model: CoreModel) -> None:
        """A model was built; its sensors and plugins follow when all models of the file are built."""
        self._new.append(model)
        self.activity.models_changed()
        self.core.events["AddEntity"](model.GetId())

    def model_removed(self, model: CoreModel) -> None:
        """Remove plugins, sensors and controllers of the model."""
        self._new = [new for new in self._new if new is not model]
        self.activity.models_changed()
        self.core.events["DeleteEntity"](model.GetId())
        if not model.is_model:
            return
        view = self.world.view(model)
        for plugin in self._model_plugins.pop(view, ()):
            plugin.drop()
        if self.sensors is not None:
            self.sensors.remove_of(view)
        if self.visuals is not None:
            self.visuals.remove_of(view)
        self.activity.forget(view)

    def update(self) -> None:
        """Update joint controllers, batteries, animations and attached models."""
        self.activity.update()

    def step(self, paused: bool) -> None:
        """Finish inserted models, then update sensors, then topics."""
        if self._new:
            self.finish_added()
        if self.sensors is not None:
            self.sensors.update()
        if self.topics is not None:
            self.topics.update()
        self.paused_steps.update(paused)

    def time_was_reset(self) -> None:
        """Reset the times of the sensors."""
        if self.sensors is not None:
            self.sensors.reset()

    def reset(self) -> None:
        """Reset sensors, controllers and plugins."""
        self.time_was_reset()
        for model in self.world.all_models():
            model.after_reset()
        for plugin in (*self._other_plugins(), *system_plugins):
            plugin.reset()

    def get_state(self) -> object:
        """Nothing yet."""
        return None

    def set_state(self, state: object) -> None:
        """Nothing yet."""

    def close(self) -> None:
        """Drop all plugins, and close sensors and topics."""
        for plugin in list(self.plugins()):
            plugin.drop()
        for part in (self.visuals, self.sensors, self.topics):
            if part is not None:
                part.close()

    def sensor_names(self) -> list[str]:
        """The full scoped names of all sensors."""
        return self.sensors.names() if self.sensors is not None else []


def _names(element: Element) -> tuple[str, str]:
    """(filename, name) of a `<plugin>`."""
    return element.Get(str, "filename"), element.Get(str, "name")


def _named(element: Element | None, name: str) -> Iterator[Element]:
    return element.named(name) if element is not None else iter(())
