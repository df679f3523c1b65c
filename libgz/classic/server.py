"""WorldServer: what makes an SDF world one of Gazebo classic: its sensors, its plugins, its topics."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

from libgz.classic.common import SphericalCoordinates
from libgz.classic.loading import LoadedPlugin, new_plugin
from libgz.classic.math import Vector3d
from libgz.classic.physics.model import Model
from libgz.classic.physics.world import World
from libgz.classic.topics import WorldTopics
from libgz.errors import NotFoundError, nearest
from libgz.geometry import GzVector
from libgz.sdf.element import Element
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.base import Base
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.joint_controller import JointController
    from libgz.classic.physics.link import Link
    from libgz.classic.rendering.plugins import VisualPlugins
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["WorldServer", "attach", "system_plugins"]

log = logging.getLogger("libgz.classic")

system_plugins: list[LoadedPlugin] = []  # of this process


def attach(core: CoreWorld) -> WorldServer:
    """Make a world one of Gazebo classic; the same again for one that is."""
    for companion in core.companions:
        if isinstance(companion, WorldServer):
            return companion
    server = WorldServer(core)
    core.companions.append(server)
    if core.running:
        server.start()
    return server


class WorldServer:
    """Loads what a world names, in classic's order, and goes along with it.

    Everything of a world happens in one thread and in one order, so that the same world runs the same each time.

    Args:
        core: the engine's world.
        quiet: without topics, for a client's copy of a world.
    """

    def __init__(self, core: CoreWorld, quiet: bool = False) -> None:
        self.core = core
        file = core.extension(SdfWorld).file
        root = file.root if file is not None else None
        self.element = next(root.named("world"), root) if root is not None else None
        self.world = World(core, self)
        self._world_plugins: list[LoadedPlugin] = []
        self.sensors: WorldSensors | None = None
        self.topics = None if quiet else WorldTopics(self)
        self.visuals: VisualPlugins | None = None
        self.stopped = False
        self._to_step, self._lent = 0, False  # iterations that a pause is lifted for, and whether it is lifted
        self._new: list[CoreModel] = list(core.entities)
        self._started = False

    @property
    def filename(self) -> str | None:
        """The world's file."""
        return self.element.file if self.element is not None and self.element.file else None

    # Start -------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Sensors and their plugins, then World plugins in the order of the file, then Model plugins.

        What any of them inserts, removes or resets meanwhile comes when all are loaded.
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
        """Give models that joined a running world their sensors and plugins."""
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
            if self.sensors.draws:
                self.serve_visuals().add(added)

    def _create_sensors(self, holder: Link | Joint) -> bool:
        """Make the sensors that stand in a link's or joint's element; whether there are any."""
        elements = list(_named(holder.GetSDF(), "sensor"))
        for element in elements:
            self.all_sensors().create(holder, element)
        return bool(elements)

    def joint_added(self, joint: Joint) -> None:
        """A joint was made while the world runs: controllers take it in, and it gets its sensors."""
        for controller in self._controllers_of(joint):
            controller.AddJoint(joint)
        if self._started and self._create_sensors(joint):
            with self.core.hold():
                self.all_sensors().start_new()

    def joint_removed(self, joint: Joint) -> None:
        """A joint is no more: controllers let it go, and its sensors go."""
        for controller in self._controllers_of(joint):
            controller.RemoveJoint(joint)
        if self.sensors is not None:
            self.sensors.remove_on(joint)

    @staticmethod
    def _controllers_of(joint: Joint) -> Iterator[JointController]:
        """Those of its model and of the models around that."""
        part: Base | None = joint.GetParentModel()
        while isinstance(part, Model):
            if part.controller is not None:
                yield part.controller
            part = part.GetParent()

    def all_sensors(self) -> WorldSensors:
        """The world's sensors, though there may be none yet."""
        if self.sensors is None:
            from libgz.classic.sensors.manager import WorldSensors

            self.sensors = WorldSensors(self.world)
        return self.sensors

    def serve_visuals(self) -> VisualPlugins:
        """The world is drawn here: load Visual plugins, those of models that come later, too."""
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
        """Load a World plugin; whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("World", filename, name, f"World[{self.world.Name()}]")
            if plugin is not None and plugin.start(self.world, sdf or Element("plugin")):
                self._world_plugins.append(plugin)
                return True
        return False

    def load_model_plugin(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin; whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("Model", filename, name, f"Model[{model.GetName()}]")
            if plugin is not None and plugin.start(model, sdf or Element("plugin")):
                model.plugins.append(plugin)
                return True
        return False

    def new_plugin(self, kind: str, filename: str, name: str, holder: str) -> LoadedPlugin | None:
        """A plugin of this world, constructed; None after telling why."""
        return new_plugin(kind, filename, name, holder, self.core.events, self.filename)

    def remove_world_plugin(self, name: str) -> None:
        """Let a World plugin go; of several of one name the first.

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
        """World plugins by name; the first where several have one."""
        return {plugin.name: plugin for plugin in reversed(self._world_plugins)}

    def plugins(self) -> Iterator[LoadedPlugin]:
        """All plugins of this world that run."""
        for model in self.world.all_models():
            yield from model.plugins
        yield from self._plugins_beside_models()

    def _plugins_beside_models(self) -> Iterator[LoadedPlugin]:
        """Those of the world, of sensors and of visuals."""
        yield from list(self._world_plugins)
        for part in (self.sensors, self.visuals):
            if part is not None:
                yield from part.plugins()

    # Companion of the world --------------------------------------------------------------------------------------

    def model_added(self, model: CoreModel) -> None:
        """A model was built; its sensors and plugins come when all that come with it are there."""
        self._new.append(model)
        self.world.changed()
        self.core.events["AddEntity"](model.GetId())

    def model_removed(self, model: CoreModel) -> None:
        """Let its plugins, sensors and controllers go."""
        self._new = [new for new in self._new if new is not model]
        self.world.changed()
        self.core.events["DeleteEntity"](model.GetId())
        if not model.is_model:
            return
        view = self.world.view(model)
        for plugin in view.plugins:
            plugin.drop()
        view.plugins.clear()
        if self.sensors is not None:
            self.sensors.remove_of(view)
        if self.visuals is not None:
            self.visuals.remove_of(view)
        self.world.forget(view)

    def step_paused(self, count: int) -> None:
        """Run the next so many iterations although the world is paused."""
        self._to_step += count

    def end_steps(self) -> None:
        """The pause was lifted for good: there is nothing to count any more."""
        self._to_step, self._lent = 0, False

    def remove(self, family: list[CoreModel]) -> None:
        """Take models out, those first that are inside others."""
        self.core.remove(list(reversed(family)))

    def update(self) -> None:
        """Joint controllers and animations."""
        self.world.before_physics()

    def step(self, paused: bool) -> None:
        """Models that joined, then sensors, then messages."""
        if self._new:
            self.finish_added()
        if self.sensors is not None:
            self.sensors.update()
        if self.topics is not None:
            self.topics.update()
        if self._to_step or self._lent:
            self._lift_pause(paused)

    def _lift_pause(self, paused: bool) -> None:
        """Lift a pause as long as there are iterations to run; so a signal or a message can end them."""
        if self._lent and not paused:
            self._to_step -= 1
        if self.core.paused and self._to_step > 0:
            self.core.paused, self._lent = False, True
        elif self._lent and self._to_step <= 0:
            self.core.paused, self._lent, self._to_step = True, False, 0
            self.core.events["Step"]()
        elif not self._lent:
            self._to_step = 0  # the world runs anyway

    def time_was_reset(self) -> None:
        """The clock was set back."""
        if self.sensors is not None:
            self.sensors.reset()

    def reset(self) -> None:
        """Clock and models were put back: so are controllers, sensors and plugins."""
        self.time_was_reset()
        for model in self.world.all_models():
            model.after_reset()
        for plugin in (*self._plugins_beside_models(), *system_plugins):
            plugin.call("Reset")

    def close(self) -> None:
        """The world ends."""
        for plugin in list(self.plugins()):
            plugin.drop()
        for part in (self.visuals, self.sensors, self.topics):
            if part is not None:
                part.close()
        self.world.close()

    # What the world tells ----------------------------------------------------------------------------------------

    def sensor_names(self) -> list[str]:
        """Full names of all sensors."""
        return self.sensors.names() if self.sensors is not None else []

    def magnetic_field(self) -> Vector3d:
        """The field [T]."""
        return Vector3d(*self.core.extension(SdfWorld).settings.magnetic_field)

    def set_magnetic_field(self, field: tuple[float, ...]) -> None:
        """Replace the field [T]."""
        self.core.extension(SdfWorld).settings.magnetic_field = GzVector(*field)

    def spherical_coordinates(self) -> SphericalCoordinates:
        """Where the file says the world lies."""
        place = self.core.extension(SdfWorld).settings.spherical_coordinates
        if place is None:
            return SphericalCoordinates()
        latitude, longitude, heading = (
            math.radians(place.Get(float, key)) for key in ("latitude_deg", "longitude_deg", "heading_deg")
        )
        surface = SphericalCoordinates.EARTH_WGS84  # the only one SDF knows
        return SphericalCoordinates(surface, latitude, longitude, place.Get(float, "elevation"), heading)


def _names(element: Element) -> tuple[str, str]:
    """(filename, name) of a `<plugin>`."""
    return element.Get(str, "filename"), element.Get(str, "name")


def _named(element: Element | None, name: str) -> Iterator[Element]:
    return element.named(name) if element is not None else iter(())
