"""WorldServer: the companion that gives an SDF world the sensors, plugins and topics of Gazebo classic."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from libgz.classic.commands import PausedSteps
from libgz.classic.describe import entity_message
from libgz.classic.math import Rand
from libgz.classic.physics.activity import Activity
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.ids import Ids
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.world import World
from libgz.classic.plugin_states import PluginStates
from libgz.classic.topics import WorldTopics
from libgz.classic.world_plugins import WorldPlugins
from libgz.sdf.element import Element
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.event import unowned
from libgz.simulation.state import decode, encode, get_values, set_values
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.link import Link
    from libgz.classic.rendering.plugins import VisualPlugins
    from libgz.classic.rendering.scene import Scene
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.classic.sensors.sensor import Sensor
    from libgz.simulation.entity import Entity as CoreModel
    from libgz.simulation.plan import Plan

__all__ = ["WorldServer", "attach"]

# What its state consists of, in order.
PARTS = ("quiet", "settings", "published", "sensors", "topics", "plugins")
QUIET = ("random", "ids", "activity", "scene", "wind")


def attach(core: CoreWorld) -> WorldServer:
    """The WorldServer of a world, created on first use; it starts at once if the world runs."""
    if core.facade is not None:
        server: WorldServer = core.facade.server
        return server
    with unowned():  # a plugin of another world may have asked
        server = WorldServer(core)
        core.companions.append(server)
        core.reloaders.append(server.plugins)
        if core.running:
            server.start_late()
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
        ids: the numbers of views.
        activity: joint controllers, batteries, animations and attached models.
        physics, presets: settings of the engine, and their profiles.
        paused_steps: requested iterations of a paused world.
        plugins: the plugins of the world; `plugin_states` saves and restores them.
        sensors, visuals: sensors and Visual plugins; None as long as there are none.
        scene: the rendered part of the world; None as long as nobody asked for it.
        topics: the topics; None if quiet.
        stopped: whether World.Stop was called.
    """

    def __init__(self, core: CoreWorld, quiet: bool = False) -> None:
        self.core = core
        file = core.extension(SdfWorld).file
        root = file.root if file is not None else None
        self.element = next(root.named("world"), root) if root is not None else None
        self.world = core.facade = World(core, self)
        self.ids = Ids(self.world)
        self.activity = Activity(self.world)
        self.physics = PhysicsEngine(self.world)
        self.presets = PresetManager(self.world)
        self.paused_steps = PausedSteps(core)
        self.plugins = WorldPlugins(self)
        self.plugin_states = PluginStates(core, self.plugins)
        self.sensors: WorldSensors | None = None
        self.topics = None if quiet else WorldTopics(self.world, self.paused_steps)
        self.visuals: VisualPlugins | None = None
        self.scene: Scene | None = None
        self.stopped = False
        self._new: list[CoreModel] = list(core.entities)
        self._started = False
        self._state = _ServerState(self)

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
            self._subscribe(added)
            self.plugins.load_all_of_world()
            self.plugins.load_all_of_models(self._models(added))
            self._open_topics(added, announce=False)
        self.plugin_states.note_start()

    def start_late(self) -> None:
        """Start beside a world that runs: the world's state at its start has no part of this."""
        self.start()
        self._state.first = self.get_state()

    def finish_added(self) -> None:
        """Create sensors and plugins of models that were inserted."""
        while self._new and self._started:
            added, self._new = self._new, []
            self._add_sensors(added)
            self._subscribe(added)
            self.plugins.load_all_of_models(self._models(added))
            self._open_topics(added, announce=True)

    def _subscribe(self, added: list[CoreModel]) -> None:
        """Subscribe to the topics by which new models are commanded, before their plugins may publish on them."""
        if self.topics is not None:
            for model in self._models(added):
                self.topics.subscribe(model)

    def _open_topics(self, added: list[CoreModel], announce: bool) -> None:
        """Open the topics of new models and lights."""
        if self.topics is not None:
            for core in added:
                entity = self.world.view_of(core)
                if entity is not None:
                    self.topics.added(entity, announce)

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
        entity = self.world.view_of(model)
        if self.topics is not None and entity is not None:
            self.topics.removed(entity)
        if not model.is_model:
            return
        view = self.world.view(model)
        self.plugins.remove_of(view)
        if self.sensors is not None:
            self.sensors.remove_of(view)
        if self.visuals is not None:
            self.visuals.remove_of(view)
        self.activity.forget(view)

    def idle_until(self) -> float:
        """The sim time of the next measurement [s], if until then there is nothing to do."""
        if self._new or self.paused_steps.requested or not self.activity.idle:
            return -math.inf
        if self.topics is not None and not self.topics.idle:
            return -math.inf
        return self.sensors.idle_until() if self.sensors is not None else math.inf

    def skipped(self) -> None:
        """The sensors know the sim time of the last step."""
        if self.sensors is not None:
            self.sensors.skipped()

    def returned(self) -> None:
        """Nothing to do."""

    def prepare(self) -> None:
        """Obey commands that came meanwhile."""
        self.activity.prepare()

    def plan_update(self, plan: Plan) -> None:
        """Add joint controllers."""
        self.activity.plan(plan)

    def plan_end(self, plan: Plan) -> None:
        """Add what sensors measure by laws."""
        if self.sensors is not None:
            self.sensors.plan_end(plan)

    def update(self) -> None:
        """Update batteries, animations and attached models."""
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
        """Reset the plugins; all else was returned to the start with the world, or has no part in a start state."""
        self.plugin_states.arrange_as_at_start()
        self.plugins.reset()

    def reseed(self, seed: int) -> None:
        """Begin the random numbers of a world that was made with this seed: of sensors' noise, and of math.Rand."""
        Rand.Seed(seed)
        if self.sensors is not None:
            self.sensors.reseed(seed)

    # State -------------------------------------------------------------------------------------------------------

    def get_state(self) -> tuple[Any, ...]:
        """The state of sensors, plugins, topics and all else of classic, as plain data.

        That of the start has no plugins, for a reset calls their Reset.
        """
        starting = self.core.starting
        if self._new:
            self.finish_added()
        return self._state.save(with_plugins=not starting)

    def check_state(self) -> None:
        """Find out which plugin keeps the state from being encoded."""
        self.plugins.check_state()

    def loads_plugins(self, state: Sequence[Any] | None) -> bool:
        """Whether plugins of a state do not run."""
        plugins = state[-1] if state else None  # the last of the PARTS
        return bool(plugins and self.plugin_states.differ(plugins[0]))

    def set_state(self, state: Sequence[Any] | None) -> bool:
        """Take what `get_state` returned; None, for what a world was before this was attached to it.

        Returns:
            Whether plugins were loaded again, or dropped.
        """
        return self._state.load(state)

    def entities_rebuilt(self, state: Sequence[Any] | None) -> None:
        """Entities were built again: make their sensors, and load their plugins, and others that a state has.

        Plugins are loaded before joints and links that they made return with the state.
        """
        self.plugins.failures.clear()
        if self._new and self.scene is not None:
            self.scene.shape_again()
        with self.plugin_states.discarding():
            self.finish_added()
            self._state.load_missing_plugins(state)

    def close(self) -> None:
        """Drop all plugins, and close sensors and topics."""
        self.plugins.close()
        for part in (self.visuals, self.sensors, self.topics):
            if part is not None:
                part.close()

    def sensors_of(self, holder: Link | Joint) -> list[Sensor]:
        """The sensors that a link carries, or that measure a joint."""
        found = self.sensors.sensors.values() if self.sensors is not None else ()
        return [sensor for sensor in found if sensor.parent is holder]

    def described(self, entity: object) -> Any:
        """The message that describes a model, link, joint, collision or light; None for anything else."""
        return entity_message(entity)

    def sensor_names(self) -> list[str]:
        """The full scoped names of all sensors."""
        return self.sensors.names() if self.sensors is not None else []


class _ServerState:
    """What a world's state has of its server.

    Attributes:
        first: the state at the start, if the world ran before; else None.
    """

    def __init__(self, server: WorldServer) -> None:
        self._server = server
        self.first: Sequence[Any] | None = None

    def save(self, *, with_plugins: bool) -> tuple[Any, ...]:
        """The `PARTS`."""
        sensors, topics = self._server.sensors, self._server.topics
        return (
            self._quiet(),
            self._settings(),
            self._server.physics.GetContactManager().published,
            sensors.save() if sensors is not None else None,
            topics.save() if topics is not None else None,
            self._server.plugin_states.save() if with_plugins else None,
        )

    def load_missing_plugins(self, state: Sequence[Any] | None) -> None:
        """Load the plugins of a state that do not run, but those that need its sensors and visuals."""
        values = self.first if state is None else state
        if values is None:
            return
        saved = dict(zip(PARTS, values, strict=True))
        if saved["plugins"] is None or self._server.plugin_states.is_current(saved["plugins"][0]):
            return
        quiet = dict(zip(QUIET, decode(saved["quiet"]), strict=True))
        self._server.ids.load_names(quiet["ids"], of_models=True)
        self._server.plugin_states.load_missing(saved["plugins"][0])

    def load(self, state: Sequence[Any] | None) -> bool:
        """Do what `WorldServer.set_state` describes."""
        values = self.first if state is None else state
        if values is None:
            return False
        saved = dict(zip(PARTS, values, strict=True))
        quiet = dict(zip(QUIET, decode(saved["quiet"]), strict=True)) if saved["quiet"] != self._quiet() else None
        if quiet is not None:
            Rand.LoadState(quiet["random"])
            self._server.ids.load_names(quiet["ids"])
        if saved["sensors"] is not None:
            self._server.all_sensors()
        if self._server.sensors is not None:
            self._server.sensors.load(saved["sensors"])
        if quiet is not None:
            self._load_quiet(quiet["activity"], quiet["scene"])
        else:
            self._server.activity.refresh_controllers()
        others = saved["plugins"] is not None and self._server.plugin_states.load(*saved["plugins"])
        if saved["quiet"] != self._quiet():
            quiet = dict(zip(QUIET, decode(saved["quiet"]), strict=True))
            self._server.ids.load(quiet["ids"])
            self._server.world.Wind().load(quiet["wind"])
        if saved["settings"] != self._settings():
            requested = get_values(self._server.paused_steps)
            for part, values in zip(self._with_settings, decode(saved["settings"]), strict=True):
                set_values(part, values)
            if state is None or saved["plugins"] is None:  # a reset leaves the pause as it is, and its iterations
                set_values(self._server.paused_steps, requested)
        contacts = self._server.physics.GetContactManager()
        contacts.forget()
        contacts.published = saved["published"]
        if self._server.topics is not None and saved["topics"] is not None:
            self._server.topics.load(saved["topics"], replace=saved["plugins"] is not None)
        return others

    def _quiet(self) -> bytes:
        """What few worlds have much of, encoded."""
        scene = self._server.scene.save() if self._server.scene is not None else None
        wind = self._server.world.Wind().save()
        return encode((Rand.SaveState(), self._server.ids.save(), self._server.activity.save(), scene, wind))

    def _load_quiet(self, activity: Sequence[Any], scene: Sequence[Any] | None) -> None:
        self._server.activity.load(activity)
        if self._server.scene is None and scene is not None:
            from libgz.classic.rendering.scene import scene_of

            scene_of(self._server.world)
        if self._server.scene is not None:
            self._server.scene.load(scene)

    @property
    def _with_settings(self) -> tuple[Any, ...]:
        return self._server.physics, self._server.presets, self._server.paused_steps

    def _settings(self) -> bytes:
        return encode([get_values(part) for part in self._with_settings])


def _named(element: Element | None, name: str) -> Iterator[Element]:
    return element.named(name) if element is not None else iter(())
