"""WorldServer: the companion that gives an SDF world the sensors, plugins and topics of Gazebo classic."""

from __future__ import annotations

import contextlib
import logging
import math
from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from libgz.base.errors import GazeboError, NotFoundError, PluginError, StateError, nearest
from libgz.classic.commands import PausedSteps
from libgz.classic.describe import entity_message
from libgz.classic.loading import LoadedPlugin, Missing, called, is_ready, new_plugin, reload_all
from libgz.classic.math import Rand
from libgz.classic.physics.activity import Activity
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.ids import Ids
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.world import World
from libgz.classic.ros_names import is_ros_name, notice
from libgz.classic.topics import WorldTopics
from libgz.sdf.element import Element
from libgz.sdf.reader import SdfFile
from libgz.sdf.upgrade import NEWEST, upgraded
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.event import unowned
from libgz.simulation.state import decode, encode, get_values, set_values, undeclared
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.link import Link
    from libgz.classic.rendering.plugins import VisualPlugins
    from libgz.classic.rendering.scene import Scene
    from libgz.classic.sensors.manager import WorldSensors
    from libgz.classic.sensors.sensor import Sensor
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["WorldServer", "attach", "system_plugins"]

log = logging.getLogger("libgz.classic")

# What its state consists of, in order.
PARTS = ("quiet", "settings", "published", "sensors", "topics", "plugins")
KINDS = ("World", "Model", "Sensor", "Visual")  # of plugins that belong to a world
QUIET = ("random", "ids", "activity", "scene", "wind")
PLUGIN = f"<sdf version='{NEWEST}'><model name='any'>%s</model></sdf>"

system_plugins: list[LoadedPlugin] = []  # System plugins belong to the process, not to a world


def attach(core: CoreWorld) -> WorldServer:
    """The WorldServer of a world, created on first use; it starts at once if the world runs."""
    if core.facade is not None:
        server: WorldServer = core.facade.server
        return server
    with unowned():  # a plugin of another world may have asked
        server = WorldServer(core)
        core.companions.append(server)
        core.reloaders.append(server)
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
        self._world_plugins: list[LoadedPlugin] = []
        self._model_plugins: dict[Model, list[LoadedPlugin]] = {}
        self.sensors: WorldSensors | None = None
        self.topics = None if quiet else WorldTopics(self.world, self.paused_steps)
        self.visuals: VisualPlugins | None = None
        self.scene: Scene | None = None
        self.stopped = False
        self._new: list[CoreModel] = list(core.entities)
        self._started = self._reloading = False
        self._first: Sequence[Any] | None = None  # the state at the start, if the world ran before
        self._first_plugins: dict[tuple[str, str, str, str], int] = {}  # their numbers at the start
        self._not_loaded: dict[tuple[str, str, str, str], str] = {}  # plugins that failed for this state, and why
        self._seen: set[type] = set()  # classes of plugins; those without a declared state were reported

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
            self._open_topics(added, announce=False)
        self._first_plugins = {
            (kind, holder, plugin.filename, plugin.name): plugin.number for kind, holder, plugin in self._present()
        }

    def start_late(self) -> None:
        """Start beside a world that runs: the world's state at its start has no part of this."""
        self.start()
        self._first = self.get_state()

    @staticmethod
    def _plugins_of(element: Element | None) -> Iterator[Element]:
        return element.named("plugin") if element is not None else iter(())

    def finish_added(self) -> None:
        """Create sensors and plugins of models that were inserted."""
        while self._new and self._started:
            added, self._new = self._new, []
            self._add_sensors(added)
            self._load_model_plugins(added)
            self._open_topics(added, announce=True)

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

    def _load_model_plugins(self, added: list[CoreModel]) -> None:
        for model in self._models(added):
            for element in self._plugins_of(model.GetSDF()):
                errors = len(self.core.problems.errors)
                if not self.load_model_plugin(model, *_names(element), element):
                    self._note_failure(("Model", model.GetScopedName(), *_names(element)), errors)

    # Plugins -----------------------------------------------------------------------------------------------------

    def load_world_plugin(self, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a World plugin; returns whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("World", filename, name, f"World[{self.world.Name()}]", sdf)
            if plugin is not None and plugin.start(self.world, sdf or Element("plugin")):
                plugin.source = _source(sdf, self.element)
                self._world_plugins.append(plugin)
                return True
        return False

    def load_model_plugin(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin; returns whether it runs."""
        with self.core.hold():
            plugin = self.new_plugin("Model", filename, name, f"Model[{model.GetName()}]", sdf, model.core)
            if plugin is not None and plugin.start(model, sdf or Element("plugin")):
                plugin.source = _source(sdf, model.GetSDF())
                self._model_plugins.setdefault(model, []).append(plugin)
                return True
        return False

    def new_plugin(
        self, kind: str, filename: str, name: str, holder: str, sdf: Element | None, entity: CoreModel | None = None
    ) -> LoadedPlugin | None:
        """A plugin of this world, constructed; None if that fails, which is logged."""
        if is_ros_name(filename):
            notice(self.core)
        missing = self.core.extension(Missing)
        where = sdf.where if sdf is not None and sdf.line else ""
        return new_plugin(kind, filename, name, holder, self.core.events, self.filename, entity, missing, where)

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

    # Reload ------------------------------------------------------------------------------------------------------

    def _all_plugins(self) -> Iterator[tuple[str, str, LoadedPlugin]]:
        """(kind, name of the holder, plugin) of all plugins that were loaded, System plugins included."""
        for kind, holder, plugins in self._plugins_by_holder():
            for plugin in plugins:
                yield kind, holder, plugin
        for plugin in system_plugins:
            yield "System", "", plugin

    def _absent(self) -> Iterator[tuple[str, str, str, str]]:
        """(kind, name of the holder, filename, name) of plugins that the file has, but that could not be loaded."""
        present = {(kind, holder, one.filename, one.name) for kind, holder, one in self._all_plugins()}
        for kind, holder, element in self._elements():
            row = kind, holder, *_names(element)
            if row not in present:
                yield row

    def _elements(self) -> Iterator[tuple[str, str, Element]]:
        """(kind, name of the holder, `<plugin>`) of all that this world's file, or an inserted text, has."""
        for element in self._plugins_of(self.element):
            yield "World", "", element
        for model in self.world.all_models():
            for element in self._plugins_of(model.GetSDF()):
                yield "Model", model.GetScopedName(), element
        for kind, part in (("Sensor", self.sensors), ("Visual", self.visuals)):
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
        server = self.core.gz_server
        try:
            with server.hand_over(server.interfaces.values()):
                reload_all([plugin for *_, plugin in found])
            for *_, plugin in found:
                plugin.precede({other for *_, other in self._all_plugins() if other.number > plugin.number})
        except PluginError:
            if before is not None:
                self.core.snapshots.restore(before)
            raise
        for kind, holder, filename, own in absent:
            errors = len(self.core.problems.errors)
            if self._load_again(kind, holder, filename, own, "") is None:
                failed = self.core.problems.errors[errors:]
                raise PluginError("\n".join(map(str, failed)) or f"plugin {own!r} did not start; the log says why")
        rows = [(kind, holder, plugin.name) for kind, holder, plugin in found]
        rows += [(kind, holder, own) for kind, holder, _, own in absent]
        return [f"{kind} plugin {holder}::{own}" if holder else f"{kind} plugin {own}" for kind, holder, own in rows]

    def _state_before(self) -> bytes | None:
        """The state to return to if a plugin fails; None if this world's state cannot be saved."""
        self._reloading = True
        try:
            return self.core.snapshots.save()
        except GazeboError as error:
            log.debug("the world's state cannot be saved: %s", error)
            return None
        finally:
            self._reloading = False

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
        entity = self.world.view_of(model)
        if self.topics is not None and entity is not None:
            self.topics.removed(entity)
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
        """Reset the plugins; all else was returned to the start with the world, or has no part in a start state."""
        self._arrange_as_at_start()
        for model in self.world.all_models():
            self.reset_plugins(model)
        for plugin in (*self._other_plugins(), *system_plugins):
            plugin.reset()

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
        return (
            self._quiet(),
            self._settings(),
            self.physics.GetContactManager().published,
            self.sensors.save() if self.sensors is not None else None,
            self.topics.save() if self.topics is not None else None,
            self._saved_plugins() if not starting else None,
        )

    def check_state(self) -> None:
        """Find out which plugin keeps the state from being encoded."""
        for plugin in self.plugins():
            plugin.check_state()

    def loads_plugins(self, state: Sequence[Any] | None) -> bool:
        """Whether plugins of a state do not run."""
        plugins = state[-1] if state else None  # the last of the PARTS
        return bool(plugins and plugins[0] != self._list_plugins() and any(True for _ in self._missing(plugins[0])))

    def _missing(self, listed: bytes) -> Iterator[tuple[str, str, str, str, str]]:
        """(kind, name of the holder, file, name, text) of plugins in a list that do not run."""
        running = Counter((kind, holder, one.filename, one.name) for kind, holder, one in self._present())
        for kind, holder, rows in decode(listed):
            for filename, name, source, *_ in rows:
                running[kind, holder, filename, name] -= 1
                if running[kind, holder, filename, name] < 0:
                    yield kind, holder, filename, name, source

    def _surplus(self, listed: bytes) -> Iterator[tuple[str, LoadedPlugin]]:
        """(kind, plugin) of plugins that run and are not in a list."""
        wanted = Counter(
            (kind, holder, filename, name) for kind, holder, rows in decode(listed) for filename, name, *_ in rows
        )
        for kind, holder, plugin in self._present():
            wanted[kind, holder, plugin.filename, plugin.name] -= 1
            if wanted[kind, holder, plugin.filename, plugin.name] < 0:
                yield kind, plugin

    def _quiet(self) -> bytes:
        """What few worlds have much of, encoded."""
        scene = self.scene.save() if self.scene is not None else None
        wind = self.world.Wind().save()
        return encode((Rand.SaveState(), self.ids.save(), self.activity.save(), scene, wind))

    def set_state(self, state: Sequence[Any] | None) -> bool:
        """Take what `get_state` returned; None, for what a world was before this was attached to it.

        Returns:
            Whether plugins were loaded again, or dropped.
        """
        values = self._first if state is None else state
        if values is None:
            return False
        saved = dict(zip(PARTS, values, strict=True))
        quiet = dict(zip(QUIET, decode(saved["quiet"]), strict=True)) if saved["quiet"] != self._quiet() else None
        if quiet is not None:
            Rand.LoadState(quiet["random"])
            self.ids.load_names(quiet["ids"])
        if saved["sensors"] is not None:
            self.all_sensors()
        if self.sensors is not None:
            self.sensors.load(saved["sensors"])
        if quiet is not None:
            self._load_quiet(quiet["activity"], quiet["scene"])
        else:
            self.activity.refresh_controllers()
        others = saved["plugins"] is not None and self._load_plugins(*saved["plugins"])
        if saved["quiet"] != self._quiet():
            quiet = dict(zip(QUIET, decode(saved["quiet"]), strict=True))
            self.ids.load(quiet["ids"])
            self.world.Wind().load(quiet["wind"])
        if saved["settings"] != self._settings():
            requested = get_values(self.paused_steps)
            for part, values in zip(self._parts_with_settings, decode(saved["settings"]), strict=True):
                set_values(part, values)
            if state is None or saved["plugins"] is None:  # a reset leaves the pause as it is, and its iterations
                set_values(self.paused_steps, requested)
        contacts = self.physics.GetContactManager()
        contacts.forget()
        contacts.published = saved["published"]
        if self.topics is not None and saved["topics"] is not None:
            self.topics.load(saved["topics"], replace=saved["plugins"] is not None)
        return others

    def _load_quiet(self, activity: Sequence[Any], scene: Sequence[Any] | None) -> None:
        self.activity.load(activity)
        if self.scene is None and scene is not None:
            from libgz.classic.rendering.scene import scene_of

            scene_of(self.world)
        if self.scene is not None:
            self.scene.load(scene)

    @property
    def _parts_with_settings(self) -> tuple[Any, ...]:
        return self.physics, self.presets, self.paused_steps

    def _settings(self) -> bytes:
        return encode([get_values(part) for part in self._parts_with_settings])

    def entities_rebuilt(self, state: Sequence[Any] | None) -> None:
        """Entities were built again: make their sensors, and load their plugins, and others that a state has.

        Plugins are loaded before joints and links that they made return with the state.
        """
        self._not_loaded.clear()
        if self._new and self.scene is not None:
            self.scene.shape_again()
        with self._discarded():
            self.finish_added()
            self._load_missing(self._first if state is None else state)

    def _load_missing(self, state: Sequence[Any] | None) -> None:
        """Load the plugins of a state that do not run, but those that need its sensors and visuals."""
        saved: dict[str, Any] = dict(zip(PARTS, state, strict=True)) if state is not None else {"plugins": None}
        if saved["plugins"] is None or saved["plugins"][0] == self._list_plugins():
            return
        self.ids.load_names(dict(zip(QUIET, decode(saved["quiet"]), strict=True))["ids"], of_models=True)
        for kind, plugin in [*self._surplus(saved["plugins"][0])]:
            if kind in ("World", "Model"):  # drop it before others are loaded, which may serve what it does
                plugin.drop()
        for kind, *names in [*self._missing(saved["plugins"][0])]:
            if kind in ("World", "Model"):
                self._load_again(kind, *names)
        for *_, plugins in self._plugins_by_holder():
            plugins[:] = [plugin for plugin in plugins if plugin.plugin is not None]

    @contextlib.contextmanager
    def _discarded(self) -> Iterator[None]:
        """What plugins that are loaded for a state insert or delete has no effect, for the state has it."""
        with self.core.hold():
            deferred = self.core.agenda.deferred
            before = len(deferred)
            try:
                yield
            finally:
                del deferred[before:]

    def _plugins_by_holder(self) -> Iterator[tuple[str, str, list[LoadedPlugin]]]:
        """(kind, name of the holder, its plugins) of all holders that have any."""
        if self._world_plugins:
            yield "World", "", self._world_plugins
        for model, plugins in self._model_plugins.items():
            yield "Model", model.GetScopedName(), plugins
        for part in (self.sensors, self.visuals):
            if part is not None:
                yield from part.plugins_by_holder()

    def _present(self) -> Iterator[tuple[str, str, LoadedPlugin]]:
        """(kind, name of the holder, plugin) of all plugins that run."""
        for kind, holder, plugins in self._plugins_by_holder():
            yield from ((kind, holder, plugin) for plugin in plugins if plugin.plugin is not None)

    def _saved_plugins(self) -> tuple[bytes, list[Any]]:
        """Which plugins there are, encoded, and the states of those that keep one."""
        return self._list_plugins(), [plugin.save() for plugin in self._keeping()]

    def _keeping(self) -> list[LoadedPlugin]:
        """The plugins that keep a state, in the order of their list."""
        holders = sorted(self._plugins_by_holder(), key=itemgetter(0, 1))
        return [one for *_, plugins in holders for one in plugins if one.plugin is not None and one.keeps]

    def _list_plugins(self) -> bytes:
        """By kind and holder: file, name and text of each plugin, when it was loaded, and whether it keeps a state."""
        rows = []
        holders = sorted(self._plugins_by_holder(), key=itemgetter(0, 1))
        numbers = sorted(one.number for *_, plugins in holders for one in plugins if one.plugin is not None)
        for kind, holder, plugins in holders:
            running = [plugin for plugin in plugins if plugin.plugin is not None]
            for plugin in plugins:
                if plugin.plugin_class not in self._seen and not self._reloading:
                    self._warn_of_undeclared(plugin)
            if running:
                kept = [(p.filename, p.name, p.source, bisect_left(numbers, p.number), p.keeps) for p in running]
                rows.append((kind, holder, kept))
        return encode(rows)

    def _load_plugins(self, listed: bytes, states: Sequence[Any]) -> bool:
        """Make the plugins those of a state, and set their states; whether they were others."""
        if listed == self._list_plugins():
            for plugin, saved in zip(self._keeping(), states, strict=True):
                self._load_state(plugin, saved)
            return False
        left = iter(states)
        wanted = {
            (kind, holder): [(*names, next(left) if keeps else None) for *names, keeps in rows]
            for kind, holder, rows in decode(listed)
        }
        for kind, _ in wanted:
            if kind not in KINDS:
                raise StateError(f"the state is damaged: plugins are of the kinds {', '.join(KINDS)}, not {kind!r}")
        order: list[tuple[int, LoadedPlugin]] = []
        with self._discarded():
            for kind, holder, plugins in list(self._plugins_by_holder()):
                order += self._match(kind, holder, plugins, wanted.pop((kind, holder), ()))
            for (kind, holder), rows in wanted.items():
                order += self._match(kind, holder, [], rows)
        self._arrange([plugin for _, plugin in sorted(order, key=itemgetter(0))])
        return True

    @staticmethod
    def _arrange(order: Sequence[LoadedPlugin]) -> None:
        """Have the callbacks of plugins called in the order in which a state has them loaded."""
        numbers = sorted(plugin.number for plugin in order)
        for place, (plugin, number) in enumerate(zip(order, numbers, strict=True)):
            if any(other.number < plugin.number for other in order[place + 1 :]):
                plugin.precede(set(order[place + 1 :]))
            plugin.number = number

    def _arrange_as_at_start(self) -> None:
        """Have the plugins of the start called in its order, which a state may have changed; later ones come last."""
        present = [
            (self._first_plugins.get((kind, holder, plugin.filename, plugin.name), math.inf), plugin.number, plugin)
            for kind, holder, plugin in self._present()
        ]
        self._arrange([plugin for *_, plugin in sorted(present, key=itemgetter(0, 1))])
        for *_, plugins in self._plugins_by_holder():
            plugins.sort(key=attrgetter("number"))

    def _match(
        self, kind: str, holder: str, present: list[LoadedPlugin], rows: Sequence[Any]
    ) -> list[tuple[int, LoadedPlugin]]:
        """Drop plugins that came since a state, load again those that ended, and set their states.

        Returns:
            The plugins, and their numbers in the order in which they were loaded.
        """
        left = [plugin for plugin in present if plugin.plugin is not None]
        kept: list[LoadedPlugin | None] = []
        for filename, name, *_ in rows:
            same = next((one for one in left if (one.filename, one.name) == (filename, name)), None)
            left = [other for other in left if other is not same]
            kept.append(same)
        for plugin in left:  # before others are loaded, as in `_load_missing`
            plugin.drop()
        found = []
        for same, (filename, name, source, number, saved) in zip(kept, rows, strict=True):
            one = same or self._load_again(kind, holder, filename, name, source)
            if one is not None:
                found.append((one, number, saved))
            else:
                reason = self._not_loaded.get((kind, holder, filename, name)) or "the log says why"
                place = f" of {holder}" if holder else ""
                self.core.snapshots.failures.append(
                    StateError(f"{kind} plugin {name!r}{place} of the state cannot be loaded again: {reason}")
                )
        present[:] = [plugin for plugin, *_ in found]
        for plugin, _, saved in found:
            self._load_state(plugin, saved)
        return [(number, plugin) for plugin, number, _ in found]

    def _load_state(self, plugin: LoadedPlugin, saved: Any) -> None:
        """Set the state of a plugin; what fails is kept, and the other plugins are set all the same."""
        try:
            plugin.load_state(saved)
        except PluginError as error:
            self.core.snapshots.failures.append(error)

    def _load_again(self, kind: str, holder: str, filename: str, name: str, source: str) -> LoadedPlugin | None:
        """A plugin of a state that ended since, or was loaded at run time in another process."""
        key = kind, holder, filename, name
        if key in self._not_loaded:  # it failed when what holds it was built again
            return None
        owner, load = self._holder(kind, holder)
        if owner is None:
            self._not_loaded[key] = f"there is no {holder}"
            return None
        sdf = self.element if kind == "World" else owner.GetSDF()
        own = next((e for e in self._plugins_of(sdf) if _names(e) == (filename, name)), None)
        element = SdfFile.from_string(PLUGIN % source).root.children[0].child("plugin") if source else own
        before = {id(plugin) for *_, plugins in self._plugins_by_holder() for plugin in plugins}
        errors = len(self.core.problems.errors)
        load(filename, name, element)
        self._note_failure(key, errors)
        plugins = [plugin for *_, plugins in self._plugins_by_holder() for plugin in plugins]
        return next((plugin for plugin in plugins if id(plugin) not in before), None)

    def _note_failure(self, plugin: tuple[str, str, str, str], errors: int) -> None:
        """Keep why a plugin was not loaded: the first error that was added to so many."""
        added = self.core.problems.errors[errors:]
        if added:
            self._not_loaded[plugin] = added[0].message

    def _holder(self, kind: str, name: str) -> tuple[Any, Callable[[str, str, Element | None], object]]:
        """What holds plugins, and a function that loads one more for it."""
        if kind == "World":
            return self.world, self.load_world_plugin
        if kind == "Model":
            model = self.world.ModelByName(name)
            return model, lambda *values: self.load_model_plugin(model, *values) if model is not None else None
        part = self.sensors if kind == "Sensor" else self.serve_visuals()
        return part.holder(name) if part is not None else (None, print)

    def _warn_of_undeclared(self, plugin: LoadedPlugin) -> None:
        kind: Any = plugin.plugin_class
        self._seen.add(kind)
        if undeclared(kind) and not is_ready(plugin.path):  # those of libgz declare theirs in their bases
            log.warning(
                "%s: class %s does not declare its state, so snapshots of the world do not have it; name its "
                'attributes, `STATE = ("goal", "since")`, or write `STATE = ()` if it remembers nothing',
                plugin,
                kind.__name__,
            )

    def close(self) -> None:
        """Drop all plugins, and close sensors and topics."""
        for plugin in list(self.plugins()):
            plugin.drop()
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


def _names(element: Element) -> tuple[str, str]:
    """(filename, name) of a `<plugin>`."""
    return element.Get(str, "filename"), element.Get(str, "name")


def _source(sdf: Element | None, holder: Element | None) -> str:
    """The text of a plugin's element; empty if it stands in its holder's element, or if there is none."""
    return "" if sdf is None or sdf.GetParent() is holder else upgraded(sdf).ToString()


def _named(element: Element | None, name: str) -> Iterator[Element]:
    return element.named(name) if element is not None else iter(())
