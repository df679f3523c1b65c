"""World: models on an engine, stepped together, with the interfaces they serve."""

from __future__ import annotations

import importlib
import logging
import os
import time
from collections.abc import Callable, Iterable
from types import TracebackType
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from libgz.errors import ClosedError, GazeboError, PluginError
from libgz.geometry import GzVector
from libgz.interfaces.sim import Sim
from libgz.legacy.factory import ModelFactory
from libgz.legacy.loader import Loader
from libgz.legacy.settings import GlobalAttributes, read_global, read_quirks
from libgz.ode.types import ContactRule
from libgz.physics.appearance import Backdrop
from libgz.physics.check import finite, not_negative
from libgz.physics.engine import Engine
from libgz.sdf.reader import SdfFile, is_sdf, is_sdf_text
from libgz.simulation.agenda import Agenda
from libgz.simulation.changes import delete_models, end_model, family_of, insert_models, unlock_interfaces
from libgz.simulation.clock import Clock
from libgz.simulation.companion import Companion
from libgz.simulation.event import WorldEvents, everywhere
from libgz.simulation.lookup import Lookup
from libgz.simulation.plugins import own_traceback
from libgz.transport.layout import LIBGAZEBO_VERSION
from libgz.transport.server import LocalServer, Server
from libgz.worldfile.file import WorldFile

if TYPE_CHECKING:
    from libgz.legacy.model import Model

__all__ = ["World"]

log = logging.getLogger("libgz.simulation")


class World(Lookup, Loader, Clock, Agenda):
    """A simulated world.

    In process, without the wire::

        with libgz.World.from_file("worlds/pioneer2at.world") as world:
            world.interface("position", "robot1").command(vx=0.3)
            world.step(1000)
            print(world.model("robot1").GetPose())

    Args:
        server_id: serve the models' interfaces to other programs under this id; None keeps them in this process.
        force: take over a server id whose owner cannot be told to be dead.
        seed: of everything random in this world.
        solver: ``"world"``, ODE's exact solver, or ``"quick"``, its iterative one.
        wire_version: of the interfaces: 0x060, or 0x050 for clients of Gazebo 0.5.

    Raises:
        LibraryError: ODE is absent or unfit.
        ParameterError: there is no such solver or version, or the seed is negative.
    """

    _all: ClassVar[list[World]] = []

    def __init__(
        self,
        server_id: int | None = None,
        force: bool = False,
        *,
        seed: int = 0,
        solver: str = "world",
        wire_version: int = LIBGAZEBO_VERSION,
    ) -> None:
        self.server_id = server_id
        self.gz_server: LocalServer = (
            LocalServer(wire_version) if server_id is None else Server(server_id, force, wire_version)
        )
        self.engine = Engine(seed=seed, solver=solver)
        self.seed = seed
        self.random = np.random.SeedSequence(seed)
        self.factory = ModelFactory()
        self.file: WorldFile | None = None
        self.models: list[Model] = []
        self.sim = Sim()
        self._updating: list[Model] = []
        self._followers: list[Model] = []
        Clock.__init__(self)
        Agenda.__init__(self)
        self._paused = self._closed = False
        self._inside = False  # whether Step runs
        self.name = "default"
        self.sdf: SdfFile | None = None
        self.physics_enabled = True
        self.events = WorldEvents(everywhere)
        self.companions: list[Companion] = []
        self._begin, self._contact, self._end = (
            self.events[name] for name in ("WorldUpdateBegin", "BeforePhysicsUpdate", "WorldUpdateEnd")
        )
        self._apply(GlobalAttributes(), False)

    def _apply(self, values: GlobalAttributes, fog: bool) -> None:
        """Take on the settings of a worldfile."""
        self.settings = values
        self.simSpeed = values.speed
        self.utcOffset = values.utcOffset
        self.utmZone = GzVector(values.utmZone, 0.0, 0.0)
        self.utmOffset = values.utmOffset
        self.skyColor = values.skyColor
        self.fogEnable = fog
        self.fogDensity = values.fogDensity
        self.backdrop = Backdrop()
        self.engine.step_time = values.stepTime
        self.engine.gravity = tuple(values.gravity)

    @classmethod
    def from_file(cls, filename: str | os.PathLike[str], **options: Any) -> World:
        """Load a worldfile and make it ready to step.

        Args:
            filename: the worldfile.
            **options: those of World.

        Raises:
            WorldFileError: the worldfile has errors; the message lists them all.
            PluginError: a model's Init failed.
            ServerError: the server id is in use.
        """
        return cls._ready(lambda world: world.LoadFile(filename), options)

    @classmethod
    def from_string(cls, text: str, **options: Any) -> World:
        """The same from the text of a legacy worldfile or an SDF document."""
        if is_sdf_text(text):
            return cls._ready(lambda world: world.load_sdf(SdfFile.from_string(text)), options)
        file = WorldFile()
        file.LoadString(text)
        return cls._ready(lambda world: world.Load(file), options)

    @classmethod
    def _ready(cls, load: Callable[[World], object], options: dict[str, Any]) -> World:
        world = cls(**options)
        try:
            load(world)
            world.Initialize()
        except BaseException:
            world.close()
            raise
        return world

    def __enter__(self) -> World:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def worldId(self) -> Engine:
        """What old plugins pass to joints: the engine."""
        return self.engine

    # Load --------------------------------------------------------------------------------------------------------

    def Load(self, file: WorldFile) -> int:
        """Build all models of a worldfile; 0.

        Errors are gathered over the whole file. Warnings are logged; attributes that nobody read are among them.

        Raises:
            WorldFileError: there are errors; the message lists them all, one a line.
        """
        self.file = file
        values, fog = read_global(file)
        self.engine.quirks = read_quirks(file, values.legacyQuirks)
        self._apply(values, fog)
        self.visit(file.GetRootNode())
        file.note_foreign(not self.models)
        file.GetRootNode().note_unused()
        for warning in file.diagnostics.warnings:
            log.warning("%s", warning)
        file.diagnostics.raise_errors()
        return 0

    def LoadFile(self, filename: str | os.PathLike[str]) -> int:
        """Build all models of a legacy worldfile or an SDF file, told apart by the root element; 0.

        Raises:
            WorldFileError: the file cannot be read, or has errors; the message lists them all, one a line.
        """
        return self.load_sdf(SdfFile.load(filename)) if is_sdf(filename) else self.Load(WorldFile.from_file(filename))

    def load_sdf(self, file: SdfFile) -> int:
        """Build what an SDF document describes, and load Gazebo classic's part of it if it has any; 0.

        Raises:
            WorldFileError: it has errors; the message lists them all.
        """
        from libgz.sdfworld.loader import load_sdf

        self.engine.contact_rule = ContactRule.CLASSIC
        self.engine.count_turns = self.engine.check_divergence = True
        self.sdf = file
        named = next(file.root.named("world"), None)
        self.name = named.Get(str, "name") if named is not None else self.name
        load_sdf(self, file)
        if any(True for name in ("plugin", "sensor") for _ in file.root.find(name)):
            # By name, for classic stands above this package.
            importlib.import_module("libgz.classic.server").attach(self)
        return 0

    @property
    def running(self) -> bool:
        """Whether Initialize was called, and Finalize not yet."""
        return self._start is not None

    @classmethod
    def all_running(cls) -> list[World]:
        """The worlds of this process that run, oldest first."""
        return [world for world in cls._all if world.running]

    def adopt(self, model: Model) -> None:
        """Take a model in that is built: it is updated from the next step on."""
        self.models.append(model)
        self._updating.append(model)
        if model.follows:
            self._followers.append(model)
        for companion in self.companions:
            companion.model_added(model)

    def take_along(self, model: Model) -> None:
        """Let a model that was attached at run time, and without a joint, follow its parent."""
        if model in self.models and model not in self._followers:
            self._followers.append(model)

    # Start and end -----------------------------------------------------------------------------------------------

    def Initialize(self) -> int:
        """Start the server, let all models make their interfaces, and offer `sim` last; 0.

        Raises:
            ServerError: the server id is in use.
            PluginError: a model's Init failed.
        """
        self._start = time.monotonic()
        self._all.append(self)
        self.gz_server.start()
        file = self.file or WorldFile()
        self.init_models(self.models, file)
        self.sim.create(self.gz_server, "default")
        self.sim.data.pause = int(self.settings.pause)
        if self.sdf is not None:
            self.engine.sort_geoms()
        for companion in self.companions:
            companion.start()
        self.gz_server.post()
        return 0

    def init_models(self, models: Iterable[Model], file: WorldFile) -> None:
        """Let models make their interfaces; nothing to do before the server is started."""
        # An Init may insert models, which are initialized then, and delete some.
        for model in list(models) if self._start is not None else ():
            if model in self.models:
                self._init_model(model, file)

    def _init_model(self, model: Model, file: WorldFile) -> None:
        if model.node is None:
            return
        where = f"{file.label}:{model.node.line}: <{model.node.tag}>"
        model.initialized = False
        try:
            model.MasterInit(file, model.node)
            model.initialized = True
        except GazeboError as error:
            raise PluginError(f"{where}: Init of model {model.GetId()!r}: {error}") from error
        except Exception as error:
            raise PluginError(
                f"{where}: Init of model {model.GetId()!r} failed with\n{own_traceback(error)}"
            ) from error

    def Finalize(self) -> int:
        """Let all models go, then the server; 0. Can be called twice."""
        if self._start is None:
            return 0
        self._start = None
        self._all.remove(self)
        for companion in self.companions:
            companion.close()
        for model in self.models:
            end_model(model)
        self.sim.destroy()
        self.gz_server.stop()
        return 0

    def close(self) -> None:
        """End the world and free everything in it. Can be called twice.

        Raises:
            GazeboError: it is called in a step, by a callback, or while plugins load or are reset.
        """
        if self._closed:
            return
        self._check_idle("closed")
        self._closed = True
        self.Finalize()
        self.gz_server.stop()
        self.events.close()
        self.engine.close()

    # Step --------------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> None:
        """Run `count` steps, as fast as they go."""
        for _ in range(count):
            self.Step()

    def run(self, seconds: float) -> None:
        """Run until that much more sim time [s] has passed, as fast as it goes.

        Raises:
            ParameterError: it is negative, NaN or infinite.
        """
        what = "time to run [s]"
        self.step(round(finite(not_negative(seconds, what), what) / self.engine.step_time))

    def Step(self) -> int:
        """One step: buttons, models, physics, followers, clock, news to clients; 0.

        Raises:
            GazeboError: it is called in a step, by a callback, or while plugins load or are reset.
            ClosedError: the world is closed, or `Initialize` was not called.
        """
        if self._start is None:
            raise ClosedError("the world is closed" if self._closed else "Initialize comes before the first step")
        self._check_idle("stepped")
        self._inside = True
        try:
            self._step()
        finally:
            self._inside = self._stepping = False
        return 0

    def _check_idle(self, what: str) -> None:
        if self._inside:
            raise GazeboError(f"a world cannot be {what} in a callback: its step is under way")
        if self._holding:
            raise GazeboError(f"a world cannot be {what} while plugins load, are reset, come or go")

    def _step(self) -> None:
        paused = self._read_buttons()
        self._stepping = True
        if paused:
            self._update_models(0.0)
            self._pauseTime += self.engine.step_time
        else:
            self._advance()
        if self._afterwards:
            self.act()
        self._stepping = bool(self.companions)
        for companion in self.companions:
            companion.step(paused)
        if self._afterwards:
            self.act()
        if self.sim.lock():
            data = self.sim.data
            data.sim_time, data.pause_time, data.real_time = self._simTime, self._pauseTime, self.GetRealTime()
            self.sim.unlock()
        self.gz_server.post()

    def _advance(self) -> None:
        """Move everything by one step of sim time, and tell who listens."""
        engine, step = self.engine, self.engine.step_time
        self.iterations += 1
        # Classic counts a step when it begins, the legacy server when its models have been updated.
        early = self.sdf is not None
        self._simTime += step if early else 0.0
        if self._begin:
            self._begin(self.update_info())
        self._update_models(step)
        self._simTime += 0.0 if early else step
        for companion in self.companions:
            companion.update()
        if self._contact and self.physics_enabled:
            engine.collide()
            self._contact(self.update_info())
            engine.solve()
        elif self.physics_enabled:
            engine.step()
        for model in self._followers:
            model.follow()
        if self._end:
            self._end()

    def _read_buttons(self) -> bool:
        """Act on the sim interface's reset and save; whether the world is paused."""
        if not self.sim.lock():
            return self._paused
        data = self.sim.data
        self._paused, reset, save = bool(data.pause), data.reset, data.save
        if reset or save:
            data.reset = data.save = 0
        self.sim.unlock()
        if reset:
            self.Reset()
        if save:
            self.Save()
        return self._paused

    def _update_models(self, step: float) -> None:
        """Update all models in order. One that raises is reported and stopped; the others go on."""
        failed = False
        for model in self._updating:
            try:
                model.MasterUpdate(step)
            except Exception as error:  # noqa: BLE001 - a plugin may raise anything
                failed = True
                model.failed = error
                log.error(
                    "model %r stopped, its motors off: its Update failed with\n%s", model.GetId(), own_traceback(error)
                )
        if failed:
            for model in self._updating:
                if isinstance(model.failed, BaseException):  # a subclass may mean something else by it
                    model.motors_off()
                    unlock_interfaces(self, model)
            self._updating = [model for model in self._updating if not isinstance(model.failed, BaseException)]

    # Changes -----------------------------------------------------------------------------------------------------

    @property
    def paused(self) -> bool:
        """Whether time stands still."""
        return bool(self.sim.data.pause)

    @paused.setter
    def paused(self, value: bool) -> None:
        if self.sim.lock():
            changed = bool(self.sim.data.pause) != bool(value)
            self._paused = bool(value)
            self.sim.data.pause = int(value)
            self.sim.unlock()
            if changed:
                self.events["Pause"](bool(value))

    def Reset(self) -> None:
        """Put everything back: in a legacy world the models' poses, in one of classic the clock and plugins, too.

        During a step, after it.
        """
        self.after_step(self._reset if self.sdf is not None else self.ResetModelPoses)

    def _reset(self) -> None:
        self.engine.seed = self.seed
        self.reset_time()
        for model in self.models:
            if model.parent is None:
                model.restore()
        self.engine.sort_geoms()
        self.engine.wake()
        for companion in self.companions:
            companion.reset()
        self.events["WorldReset"]()

    reset = Reset

    def InsertModel(self, text: str, label: str = "<string>") -> list[Model]:
        """Add the models of a text, one `<model:...>` element or a worldfile's; they take part from the next step.

        Raises:
            WorldFileError: the text has errors or no model; nothing was added.
            PluginError: an Init failed; nothing was added.
            GazeboError: a step is running; use `after_step`.
        """
        if self._stepping:
            raise GazeboError("models cannot be inserted during a step; use World.after_step")
        with self.hold():
            return insert_models(self, text, label)

    def DeleteModel(self, model: Model | str) -> None:
        """Remove a model, by itself or its id, and all that is attached to it; during a step, after it.

        Raises:
            NotFoundError: there is none of this id.
        """
        found = self.model(model) if isinstance(model, str) else model
        self.after_step(lambda: delete_models(self, family_of(found)))

    def forget(self, models: list[Model]) -> None:
        """Take models off the lists."""
        for kept in (self.models, self._updating, self._followers):
            kept[:] = [model for model in kept if model not in models]
        for companion in self.companions:
            for model in models:
                companion.model_removed(model)
