"""World: models on an engine, stepped together, with the interfaces they serve."""

from __future__ import annotations

import logging
import os
import time
from types import TracebackType
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.errors import GazeboError, InterfaceError, NotFoundError, PluginError, WorldFileError, nearest
from libgz.geometry import GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzVector
from libgz.interfaces.sim import Sim
from libgz.physics.engine import Engine, Space
from libgz.simulation.factory import ModelFactory
from libgz.simulation.plugins import find_plugin, load_plugin, own_traceback
from libgz.simulation.settings import GlobalAttributes, read_global, read_quirks
from libgz.transport.server import LocalServer, Server
from libgz.worldfile.file import WorldFile

if TYPE_CHECKING:
    from libgz.physics.body import Body
    from libgz.physics.joint import Joint
    from libgz.simulation.model import Model
    from libgz.transport.interface import Interface
    from libgz.worldfile.node import WorldFileNode

__all__ = ["World"]

log = logging.getLogger("libgz.simulation")


class World:
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

    Raises:
        LibraryError: ODE is absent or unfit.
    """

    def __init__(
        self, server_id: int | None = None, force: bool = False, *, seed: int = 0, solver: str = "world"
    ) -> None:
        self.server_id = server_id
        self.gz_server: LocalServer = LocalServer() if server_id is None else Server(server_id, force)
        self.engine = Engine(seed=seed, solver=solver)
        self.seed = seed
        self.random = np.random.SeedSequence(seed)
        self.factory = ModelFactory()
        self.file: WorldFile | None = None
        self.models: list[Model] = []
        self.sim = Sim()
        self._updating: list[Model] = []
        self._followers: list[Model] = []
        self._simTime = self._pauseTime = 0.0
        self._start: float | None = None
        self._paused = self._closed = False
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
        return cls._ready(WorldFile.from_file(filename), options)

    @classmethod
    def from_string(cls, text: str, **options: Any) -> World:
        """The same from the text of a worldfile."""
        file = WorldFile()
        file.LoadString(text)
        return cls._ready(file, options)

    @classmethod
    def _ready(cls, file: WorldFile, options: dict[str, Any]) -> World:
        world = cls(**options)
        try:
            world.Load(file)
            world.Initialize()
        except BaseException:
            world.close()
            raise
        return world

    def __enter__(self) -> World:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def worldId(self) -> Engine:
        """What old plugins pass to joints: the engine."""
        return self.engine

    # Load --------------------------------------------------------------------------------------------------------

    def Load(self, file: WorldFile) -> int:
        """Build all models of a worldfile; 0.

        Faults are gathered over the whole file. Warnings are logged; attributes that nobody read are among them.

        Raises:
            WorldFileError: there are errors; the message lists them all, one a line.
        """
        self.file = file
        values, fog = read_global(file)
        self.engine.quirks = read_quirks(file, values.legacyQuirks)
        self._apply(values, fog)
        self._visit(file.GetRootNode(), None)
        file.GetRootNode().note_unused()
        for warning in file.faults.warnings:
            log.warning("%s", warning)
        file.faults.raise_errors()
        return 0

    def _visit(self, node: WorldFileNode, parent: Model | None) -> None:
        """Walk an element and what is in it; a model inside a model is its child, others have no parent."""
        if node.GetNSPrefix() == "model":
            self.LoadModel(node, parent)
            return
        for child in node.children:
            self._visit(child, None)

    def LoadModel(self, node: WorldFileNode, parent: Model | None = None) -> Model | None:
        """Build the model of an element, and those inside it; None if there is none to build.

        What is wrong becomes a fault of the worldfile: an unknown model a warning, anything else an error.
        """
        try:
            model = self._new_model(node)
            if model is not None:
                self._load_model(model, node, parent)
        except GazeboError as fault:
            node.error(str(fault))
            model = None
        except Exception as fault:
            log.debug("the Load that failed", exc_info=True)
            node.error(f"Load failed with\n{own_traceback(fault)}")
            model = None
        if model is None:
            _skip(node)
            return None
        for child in node.children:
            if child.GetNSPrefix() == "model":
                self.LoadModel(child, model)
            else:
                self._visit(child, None)
        return model

    def _new_model(self, node: WorldFileNode) -> Model | None:
        """The model object of an element, its plugin loaded; None for an unknown class."""
        plugin = node.GetString("plugin")
        if plugin is not None:
            filename = node.file.filename
            path = find_plugin(plugin, filename)
            log.info("loading %s...", path)
            self.factory.register_plugin(load_plugin(path))
        model = self.factory.NewModel(self, node.GetName())
        if model is None:
            hint = nearest(node.name, self.factory.names()) or "; `libgz models` lists those there are"
            node.warn(f"unknown model class, skipped with all that is in it{hint}")
        return model

    def _load_model(self, model: Model, node: WorldFileNode, parent: Model | None) -> None:
        """Steps 3 to 7 of loading one model: id, parent, Load, pose, weld."""
        model.node = node
        model.SetName(node.GetName())
        model.SetId((node.GetString("id", node.GetName()) or "").strip())
        if parent is not None:
            model.SetParent(parent, parent.GetBody((node.GetString("parentBody", "canonical") or "").strip()))
        try:
            model.MasterLoad(node.file, node)
            model.initPose = self._given_pose(model, node)
            self.SetModelPose(model, model.initPose)
            model.Attach()
        except BaseException:
            model.Detach()
            model.close()
            raise
        if model.fixed:
            model.modelSpaceId.set_fixed()
        self.models.append(model)
        self._updating.append(model)
        if model.follows:
            self._followers.append(model)
        log.debug("loaded %s %r", model.GetName(), model.GetId())

    def _given_pose(self, model: Model, node: WorldFileNode) -> GzPose:
        """The pose in the file, relative to the parent body; where a 0.4 file counts from another origin, corrected."""
        pose = GzPose(node.GetPosition("xyz"), node.GetRotation("rpy"))
        return self._convert_origin(model, pose, -1.0)

    def _convert_origin(self, model: Model, pose: GzPose, sign: float) -> GzPose:
        """A pose of the file's origin as one of ours (sign -1), or back (+1)."""
        if model.node is None or not model.node.file.is_old:
            return pose
        file = model.node.file
        own = GzPose(GzVector(0.0, 0.0, sign * file.origin_height(model.node)))
        pose = GzCoordPoseAdd(own, pose)
        if model.parent is not None and model.parent.node is not None:
            pose.pos.z -= sign * file.origin_height(model.parent.node)
        return pose

    # Start and end -----------------------------------------------------------------------------------------------

    def Initialize(self) -> int:
        """Start the server, let all models make their interfaces, and offer `sim` last; 0.

        Raises:
            ServerError: the server id is in use.
            PluginError: a model's Init failed.
        """
        self._start = time.monotonic()
        self.gz_server.start()
        file = self.file or WorldFile()
        for model in self.models:
            self._init_model(model, file)
        self.sim.create(self.gz_server, "default")
        self.sim.data.pause = int(self.settings.pause)
        self.gz_server.post()
        return 0

    def _init_model(self, model: Model, file: WorldFile) -> None:
        if model.node is None:
            return
        where = f"{file.label}:{model.node.line}: <{model.node.tag}>"
        try:
            model.MasterInit(file, model.node)
        except GazeboError as fault:
            raise PluginError(f"{where}: Init of model {model.GetId()!r}: {fault}") from fault
        except Exception as fault:
            raise PluginError(
                f"{where}: Init of model {model.GetId()!r} failed with\n{own_traceback(fault)}"
            ) from fault

    def Finalize(self) -> int:
        """Let all models go, then the server; 0. Can be called twice."""
        if self._start is None:
            return 0
        self._start = None
        for model in self.models:
            try:
                model.Fini()
            except Exception as fault:  # noqa: BLE001 - a plugin's; the others must still end
                log.error("Fini of model %r failed with\n%s", model.GetId(), own_traceback(fault))
        self.sim.destroy()
        self.gz_server.stop()
        return 0

    def close(self) -> None:
        """End the world and free everything in it. Can be called twice."""
        if self._closed:
            return
        self._closed = True
        self.Finalize()
        self.gz_server.stop()
        self.engine.close()

    # Step --------------------------------------------------------------------------------------------------------

    def step(self, count: int = 1) -> None:
        """Run `count` steps, as fast as they go."""
        for _ in range(count):
            self.Step()

    def run(self, seconds: float) -> None:
        """Run until that much more sim time [s] has passed, as fast as it goes."""
        self.step(round(seconds / self.engine.step_time))

    def Step(self) -> int:
        """One step: buttons, models, physics, followers, clock, news to clients; 0."""
        step = self.engine.step_time
        paused = self._read_buttons()
        self._update_models(0.0 if paused else step)
        if paused:
            self._pauseTime += step
        else:
            self._simTime += step
            self.engine.step()
            for model in self._followers:
                model.follow()
        if self.sim.lock():
            data = self.sim.data
            data.sim_time, data.pause_time, data.real_time = self._simTime, self._pauseTime, self.GetRealTime()
            self.sim.unlock()
        self.gz_server.post()
        return 0

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
            self.ResetModelPoses()
        if save:
            self.Save()
        return self._paused

    def _update_models(self, step: float) -> None:
        """Update all models in order. One that raises is reported and stopped; the others go on."""
        failed = False
        for model in self._updating:
            try:
                model.MasterUpdate(step)
            except Exception as fault:  # noqa: BLE001 - a plugin may raise anything
                failed = True
                model.failed = fault
                log.error(
                    "model %r stopped, its motors off: its Update failed with\n%s", model.GetId(), own_traceback(fault)
                )
        if failed:
            for model in self._updating:
                if model.failed is not None:
                    model.motors_off()
            self._updating = [model for model in self._updating if model.failed is None]

    # Poses -------------------------------------------------------------------------------------------------------

    def SetModelPose(self, model: Model, pose: GzPose) -> None:
        """Move a model, and all that is attached to it, to a pose relative to its parent body, or global [m].

        All velocities become zero.
        """
        parent = model.parentBody
        target = GzCoordPoseAdd(pose, parent.GetPose()) if parent is not None else pose
        self._move(model, target)
        if parent is not None:
            model.relPose = pose
            model.weld()

    def _move(self, model: Model, target: GzPose) -> None:
        """Move a model to a global pose; its children go rigidly with the bodies they are attached to."""
        places = [
            (child, GzCoordPoseSub(child.GetPose(), child.parentBody.GetPose()))
            for child in model.children
            if child.parentBody is not None
        ]
        model.SetPose(target)
        for child, relative in places:
            if child.parentBody is not None:
                self._move(child, GzCoordPoseAdd(relative, child.parentBody.GetPose()))

    def ResetModelPoses(self) -> None:
        """Put all models back to their initial poses, at rest. The clock and the models' own memory stay."""
        for model in self.models:
            self.SetModelPose(model, model.initPose)

    reset = ResetModelPoses

    def Save(self) -> int:
        """Make the present poses of top-level models their initial ones, and write them to the worldfile; 0 or -1."""
        if self.file is None:
            return -1
        for model in self.models:
            if model.parent is not None or model.node is None or model.node.file is not self.file:
                continue
            pose = self._convert_origin(model, model.GetPose(), +1.0)
            model.initPose = model.GetPose()
            model.node.SetPosition("xyz", pose.pos, add=True)
            model.node.SetRotation("rpy", pose.rot, add=True)
        try:
            self.file.Save()
        except WorldFileError as fault:
            log.error("%s", fault)
            return -1
        return 0

    # Time --------------------------------------------------------------------------------------------------------

    def GetSimTime(self) -> float:
        """Simulated time [s], pauses excluded."""
        return self._simTime

    def GetPauseTime(self) -> float:
        """Simulated time spent paused [s]: one step for each paused step."""
        return self._pauseTime

    def GetRealTime(self) -> float:
        """Wall-clock time since Initialize [s]."""
        return 0.0 if self._start is None else time.monotonic() - self._start

    def GetWallTime(self) -> float:
        """Unix time [s]."""
        return time.time()

    def GetDayTime(self) -> float:
        """Time since midnight [s]: the world's dayTime plus real time, or the local clock's."""
        if self.settings.dayTime >= 0.0:
            return self.settings.dayTime + self.GetRealTime()
        now = time.localtime()
        return now.tm_hour * 3600.0 + now.tm_min * 60.0 + now.tm_sec

    # Look-up -----------------------------------------------------------------------------------------------------

    def GetNumModels(self) -> int:
        """How many models there are."""
        return len(self.models)

    def GetModels(self) -> list[Model]:
        """All models, in order of the worldfile."""
        return list(self.models)

    def GetSpaceId(self) -> Space:
        """The top space, in which the models' own spaces lie."""
        return self.engine.top

    def model(self, id: str) -> Model:
        """The first model with this id.

        Raises:
            NotFoundError: there is none.
        """
        for model in self.models:
            if model.GetId() == id:
                return model
        ids = [model.GetId() for model in self.models]
        raise NotFoundError(f"there is no model {id!r}; there are {', '.join(map(repr, ids))}{nearest(id, ids)}")

    def body(self, model: str, name: str = "canonical") -> Body:
        """A body by the id of its model and its own name.

        Raises:
            NotFoundError: there is none.
        """
        return self.model(model).GetBody(name)

    def joint(self, model: str, name: str) -> Joint:
        """A joint by the id of its model and its own name.

        Raises:
            NotFoundError: there is none.
        """
        return self.model(model).GetJoint(name)

    def interface(self, type: str, id: str) -> Interface[Any]:
        """An interface that a model serves, by its type and id; commands to it act at the model's next tick.

        Raises:
            InterfaceError: there is none.
        """
        found = self.gz_server.interfaces.get((type, id))
        if found is None:
            names = [f"{kind}.{name}" for kind, name in self.gz_server.interfaces]
            raise InterfaceError(
                f"no model serves {type}.{id}; there are {', '.join(names)}" + nearest(f"{type}.{id}", names)
            )
        return found


def _skip(node: WorldFileNode) -> None:
    """Mark an element that is not built, and all in it, so that none of it is called unused."""
    for inside in node.walk():
        inside.used = True
