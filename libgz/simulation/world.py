"""World: entities on an engine, stepped together, with the interfaces they serve."""

from __future__ import annotations

import itertools
import logging
import struct
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeVar, overload

import numpy as np

from libgz.base.closing import Closing
from libgz.base.errors import (
    ClosedError,
    GazeboError,
    InterfaceError,
    NotFoundError,
    ParameterError,
    StateError,
    listed,
    nearest,
)
from libgz.base.geometry import GzColor, GzCoordPoseAdd, GzCoordPoseSub, GzPose, GzPoseOf, GzVector
from libgz.base.law import law
from libgz.interfaces.sim import Sim
from libgz.ode.crew import Task
from libgz.physics.appearance import Backdrop
from libgz.physics.body import Body
from libgz.physics.check import finite, not_negative
from libgz.physics.engine import Engine
from libgz.physics.joint import Joint
from libgz.physics.lock import exclusive
from libgz.physics.space import Space
from libgz.simulation.agenda import Agenda
from libgz.simulation.buttons import Buttons
from libgz.simulation.clock import Clock
from libgz.simulation.companion import Companion
from libgz.simulation.entity import Entity
from libgz.simulation.era import Era
from libgz.simulation.event import WorldEvents, everywhere
from libgz.simulation.falls import Falls
from libgz.simulation.journal import Journal
from libgz.simulation.pacing import Pacer
from libgz.simulation.problems import Problem, Problems
from libgz.simulation.publication import Publication
from libgz.simulation.running import add_running, remove_running, running_worlds
from libgz.simulation.running_code import names, report_wait
from libgz.simulation.snapshot import Snapshots
from libgz.simulation.state import undeclared
from libgz.simulation.stepping import Stepping
from libgz.simulation.updates import LawCall, UpdateRows
from libgz.transport.interface import Interface
from libgz.transport.layout import LIBGAZEBO_VERSION, NATIVE
from libgz.transport.server import LocalServer, Server
from libgz.transport.tables import LocalTables

if TYPE_CHECKING:
    from libgz.simulation.batch import Batch, Columns
    from libgz.simulation.reloading import Reloader
    from libgz.simulation.rewind import Rewind

if TYPE_CHECKING:  # for the types that `interface` returns; written by scripts/make_overloads.py
    from libgz.interfaces.actarray import Actarray
    from libgz.interfaces.camera import Camera
    from libgz.interfaces.factory import Factory
    from libgz.interfaces.fiducial import Fiducial
    from libgz.interfaces.gps import Gps
    from libgz.interfaces.gripper import Gripper
    from libgz.interfaces.guicam import Guicam
    from libgz.interfaces.ir import Ir
    from libgz.interfaces.joint import Joints
    from libgz.interfaces.laser import Laser
    from libgz.interfaces.position import Position
    from libgz.interfaces.power import Power
    from libgz.interfaces.ptz import Ptz
    from libgz.interfaces.sonar import Sonar
    from libgz.interfaces.stereo import Stereo
    from libgz.interfaces.truth import Truth
    from libgz.interfaces.wifi import Wifi

__all__ = ["World"]

log = logging.getLogger("libgz.simulation")

E = TypeVar("E")
K = TypeVar("K", bound=Entity)
J = TypeVar("J", bound=Joint)

_clones = itertools.count(1)
_SURROUNDINGS = struct.Struct("16d?4d")
_NO_FOG = (0.0, 0.0, 0.0, 0.0)


class World(Closing):
    """A simulated world: what both eras share. `libgz.World` loads files into it, and describes its arguments.

    Every call is safe in every thread: while one thread steps the world, a call of another one that changes it waits
    for the end of that step. Worlds do not wait for each other's calls.

    Attributes:
        engine: the ODE world.
        lock: what makes calls from several threads safe: a step holds it, and every call that changes the world.
            `with world.lock:` makes several calls one change, between two steps.
        clock: simulated and real time.
        agenda: changes deferred until a step is over.
        events: Gazebo's events of this world.
        entities: everything in the world, in order of the file; `models` are those of them that are models.
        problems: its errors and warnings.
        companions: what runs beside the world, notified of its events.
        reloaders: the parts that have plugins, for `reload_plugin`.
        era: how time is counted, and what a reset does.
        journal: where entities come from, and what was inserted.
        followers: the entities that are moved along with their parents after each step.
        rows: what the entities do in a step, for native code.
        buttons: pause, reset and save, which clients press.
        falls: the bodies that fell out of the world.
        publication: the states for other processes, while there is a server; else None.
        snapshots: takes and restores its states, without the checks of `get_state` and `set_state`.
        paced: whether the last steps waited until they were due in real time.
        clone_name: a name of its own, such as ``default_clone1``, if this is a clone; else empty.
        facade: the object by which the API of a layer above presents this world; set by that layer.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        *("name", "simSpeed", "utcOffset", "fogEnable", "fogDensity", "physics_enabled", "starts_paused", "_numbers"),
        "_surroundings",
        *("backdrop.fog_kind", "backdrop.shadows"),
        "falls.rows",
        "buttons.paused",
        *("clock.day_time", "clock.pause_time", "clock.iterations", "clock.sim_time"),  # what changes comes last
    )
    name: str
    simSpeed: float  # simulated seconds per second of real time; 0: as fast as possible
    utcOffset: float  # UTC at sim time 0 [s]
    fogEnable: bool
    fogDensity: float
    physics_enabled: bool
    starts_paused: bool
    _numbers: int  # of entities, that were given

    def __init__(
        self,
        server_id: int | None = None,
        force: bool = False,
        *,
        seed: int = 0,
        solver: str = "world",
        wire_version: int = LIBGAZEBO_VERSION,
        abi: str = NATIVE,
        strict: bool = False,
    ) -> None:
        self.server_id = server_id
        self.gz_server: LocalServer = (
            LocalServer(wire_version, abi) if server_id is None else Server(server_id, force, wire_version, abi)
        )
        self.engine = Engine(seed=seed, solver=solver)
        self._seed = seed
        self._random: np.random.SeedSequence | None = None
        self._spawned = 0  # as long as that is not needed
        self.name = "default"
        self.clone_name = ""
        self.clock = Clock()
        self.lock = self.engine.lock
        self.lock.report = report_wait
        clock = self.clock
        self.problems = Problems(self.lock.owned, strict, time=lambda: clock.sim_time)
        self.agenda = Agenda(self.lock)
        self.events = WorldEvents(everywhere)
        self.journal = Journal()
        self.companions: list[Companion] = []
        self.reloaders: list[Reloader] = []
        self.entities: list[Entity] = []
        self.models: list[Entity] = []
        self.sim = Sim()
        self.buttons = Buttons(self)
        self.physics_enabled = True
        self.starts_paused = False
        self.facade: Any = None
        self.rows = UpdateRows(self)
        self.followers: list[Entity] = []
        self._extensions: dict[Callable[[World], Any], Any] = {}
        self.falls = Falls(self.engine)
        self._numbers = 0
        self._start: bytes | GazeboError | None = None  # the state at the end of Initialize
        self._start_is_old = False  # since a model's class was edited
        self._resetting = self._resetting_again = False  # again: a reset that was asked for in a reset
        self._rewind: Rewind | None = None
        self.snapshots = Snapshots(self)
        self._checked: list[Entity] = []  # whose classes declare state, or were named in a warning
        self._undeclared: set[type] = set()  # classes of users that were named in a warning
        self._closed = False
        self._inside = False  # whether Step runs
        self.publication: Publication | None = None  # while a server runs
        self._stepping = Stepping(self)
        # Surroundings, by the old API's names.
        self.paced = False
        self.simSpeed, self.utcOffset = 1.0, 0.0
        self.utmZone = GzVector()
        self.utmOffset = GzVector()  # of the world's origin [m]
        self.skyColor = GzColor(0.7, 0.7, 0.9)
        self.fogEnable, self.fogDensity = False, 0.25
        self.backdrop = Backdrop()
        self.era = self._first_era()

    def _first_era(self) -> Era:
        """The era of a world into which nothing was loaded yet."""
        return Era()

    def __repr__(self) -> str:
        state = "closed" if self._closed else f"sim time {self.clock.sim_time:.3f} s"
        where = "" if self.server_id is None else f", server {self.server_id}"
        return f"<World {self.name!r}, {self.era.name}, {state}, {len(self.models)} models{where}>"

    @property
    def topic_space(self) -> str:
        """What `~` means in the names of its topics: its name; in a clone, a name that no other world has."""
        return self.clone_name or self.name

    @property
    def worldId(self) -> Engine:
        """What old plugins pass to joints: the engine."""
        return self.engine

    def extension(self, kind: Callable[[World], E]) -> E:
        """The one object of a class that extends this world; it is made by `kind(world)` when it is first asked for.

        Layers above keep here what they know of a world beside what this class knows.
        """
        if kind not in self._extensions:
            self._extensions[kind] = kind(self)
        extension: E = self._extensions[kind]
        return extension

    def present_extension(self, kind: Callable[[World], E]) -> E | None:
        """The object that `extension` has returned; None if none was made."""
        found: E | None = self._extensions.get(kind)
        return found

    @property
    def starting(self) -> bool:
        """Whether `Initialize` has not come to its end."""
        return self._start is None

    @property
    def extensions(self) -> list[Any]:
        """The objects that extend this world, in order of construction."""
        return list(self._extensions.values())

    # What is in it ---------------------------------------------------------------------------------------------------

    def GetNumModels(self) -> int:
        """How many models there are."""
        return len(self.models)

    def GetModels(self) -> list[Entity]:
        """All models, in order of the file."""
        return list(self.models)

    def GetSpaceId(self) -> Space:
        """The top space, which contains the models' own spaces."""
        return self.engine.top

    @overload
    def model(self, id: str) -> Entity: ...

    @overload
    def model(self, id: str, kind: type[K]) -> K: ...

    def model(self, id: str, kind: type[Entity] = Entity) -> Entity:
        """The first model, or light of an SDF world, with this id.

        Args:
            id: its id; in a world of SDF, its name.
            kind: its class, such as one of your own, whose attributes type checkers then know:
                `world.model("robot1", MyRobot).battery`.

        Raises:
            NotFoundError: there is none.
            ParameterError: it is not of this class.
        """
        for entity in self.entities:
            if entity.GetId() == id:
                return _of_kind(entity, kind, f"model {id!r}")
        raise NotFoundError(
            f"there is no model {id!r}; there are {listed(repr(entity.GetId()) for entity in self.entities)}"
            f"{nearest(id, (entity.GetId() for entity in self.entities))}"
        )

    def body(self, model: str, name: str = "canonical") -> Body:
        """A body by the id of its model and its own name.

        Raises:
            NotFoundError: there is none.
        """
        return self.model(model).GetBody(name)

    @overload
    def joint(self, model: str, name: str) -> Any: ...

    @overload
    def joint(self, model: str, name: str, kind: type[J]) -> J: ...

    def joint(self, model: str, name: str, kind: type[Joint] = Joint) -> Any:
        """A joint by the id of its model and its own name.

        Args:
            model: the id of its model.
            name: of the joint.
            kind: its class, such as `HingeJoint`, whose methods type checkers then know.

        Raises:
            NotFoundError: there is none.
            ParameterError: it is not of this class.
        """
        return _of_kind(self.model(model).GetJoint(name), kind, f"joint {name!r} of model {model!r}")

    # Written by scripts/make_overloads.py.
    @overload
    def interface(self, type: Literal["actarray"], id: str) -> Actarray: ...

    @overload
    def interface(self, type: Literal["camera"], id: str) -> Camera: ...

    @overload
    def interface(self, type: Literal["factory"], id: str) -> Factory: ...

    @overload
    def interface(self, type: Literal["fiducial"], id: str) -> Fiducial: ...

    @overload
    def interface(self, type: Literal["gps"], id: str) -> Gps: ...

    @overload
    def interface(self, type: Literal["gripper"], id: str) -> Gripper: ...

    @overload
    def interface(self, type: Literal["guicam"], id: str) -> Guicam: ...

    @overload
    def interface(self, type: Literal["ir"], id: str) -> Ir: ...

    @overload
    def interface(self, type: Literal["joint"], id: str) -> Joints: ...

    @overload
    def interface(self, type: Literal["laser"], id: str) -> Laser: ...

    @overload
    def interface(self, type: Literal["position"], id: str) -> Position: ...

    @overload
    def interface(self, type: Literal["power"], id: str) -> Power: ...

    @overload
    def interface(self, type: Literal["ptz"], id: str) -> Ptz: ...

    @overload
    def interface(self, type: Literal["sim"], id: str) -> Sim: ...

    @overload
    def interface(self, type: Literal["sonar"], id: str) -> Sonar: ...

    @overload
    def interface(self, type: Literal["stereo"], id: str) -> Stereo: ...

    @overload
    def interface(self, type: Literal["truth"], id: str) -> Truth: ...

    @overload
    def interface(self, type: Literal["wifi"], id: str) -> Wifi: ...

    @overload
    def interface(self, type: str, id: str) -> Interface[Any]: ...

    # End of what is written.
    def interface(self, type: str, id: str) -> Interface[Any]:
        """An interface that a model serves, by its type and id; commands to it act at the model's next tick.

        Raises:
            InterfaceError: there is none.
        """
        found = self.gz_server.interfaces.get((type, id))
        if found is None:
            names = [f"{kind}.{name}" for kind, name in self.gz_server.interfaces]
            raise InterfaceError(
                f"no model serves {type}.{id}; there are {', '.join(names) or 'none'}" + nearest(f"{type}.{id}", names)
            )
        return found

    @exclusive
    def adopt(self, entity: Entity) -> None:
        """Add an entity that is built: it takes part from the next step on."""
        self.entities.append(entity)
        if entity.is_model:
            self.models.append(entity)
        if entity.follows:
            self.followers.append(entity)
        self._entities_changed()
        for companion in self.companions:
            companion.model_added(entity)

    @exclusive
    def add_follower(self, entity: Entity) -> None:
        """Let an entity that was attached at run time, and without a joint, follow its parent."""
        if entity in self.entities and entity not in self.followers:
            self.followers.append(entity)
            self.update_rows_changed()

    @exclusive
    def DeleteModel(self, model: Entity | str) -> None:
        """Remove a model, by itself or its id, and all that is attached to it; during a step, after it.

        Raises:
            NotFoundError: there is none of this id.
        """
        found: Entity = self.model(model) if isinstance(model, str) else model
        self.after_step(lambda: self.remove(found.with_attached()))

    @exclusive
    def remove(self, entities: Iterable[Entity]) -> None:
        """Destroy entities at once: their interfaces, then their bodies and joints. Absent ones are passed over."""
        leaving = [entity for entity in entities if entity in self.entities]
        for entity in leaving:
            entity._entity_fini(removed=True)
            for interface in self.interfaces_of(entity):  # that its Fini forgot
                interface.destroy()
        for kept in (self.entities, self.models, self.followers):
            kept[:] = [entity for entity in kept if entity not in leaving]
        self._entities_changed()
        for companion in self.companions:
            for entity in leaving:
                companion.model_removed(entity)
        for entity in reversed(leaving):
            entity.Detach()
            entity.close()

    def _entities_changed(self) -> None:
        self.update_rows_changed()
        if self.publication is not None:
            self.publication.changed = True

    def interfaces_of(self, entity: Entity) -> list[Interface[Any]]:
        """The interfaces that an entity serves."""
        return [i for i in self.gz_server.interfaces.values() if i.model_id == entity.GetIntId()]

    @property
    def errors(self) -> list[Problem]:
        """The errors of models and plugins, and others that were logged for this world, in order; 1000 at most."""
        return list(self.problems.errors)

    @property
    def warnings(self) -> list[Problem]:
        """The warnings about this world and its files, in order; 1000 at most."""
        return list(self.problems.warnings)

    # Start and end ---------------------------------------------------------------------------------------------------

    @property
    def running(self) -> bool:
        """Whether Initialize was called, and Finalize not yet."""
        return self.clock.running

    @classmethod
    def all_running(cls) -> list[World]:
        """The worlds of this process that run, oldest first."""
        return [world for world in running_worlds() if isinstance(world, cls)]

    def attach_era(self) -> None:
        """Attach what the world's era offers on request, such as views and topics. A layer above overrides this."""

    @exclusive
    def Initialize(self) -> int:
        """Start the server, initialize all models, and create the interface `sim` last; 0.

        Raises:
            ServerError: the server id is in use.
            PluginError: a model's Init failed.
        """
        self.clock.start()
        self.update_rows_changed()
        add_running(self)
        self.gz_server.start()
        self.initialize(self.entities)
        self.sim.create(self.gz_server, "default")
        self.sim.data.pause = int(self.starts_paused)
        self.era.start(self)
        for companion in self.companions:
            companion.start()
        if self.gz_server.shared is not None:
            self.publication = Publication(self, self.gz_server.shared)
            self.publication.publish(self.starts_paused)
        self.gz_server.post()
        self.problems.check()
        try:
            self._start = self.snapshots.save()
        except GazeboError as error:  # of a model's own state; only a reset needs it
            self._start = error
        return 0

    @exclusive
    def publish(self) -> LocalTables:
        """Publish the states as they are now; the tables and the scene, which each step publishes from now on.

        Raises:
            ClosedError: the world is closed, or `Initialize` was not called.
        """
        self._check_ready("published")
        if self.gz_server.shared is None:
            self.gz_server.shared = LocalTables()
        if self.publication is None:
            self.update_rows_changed()
            self.publication = Publication(self, self.gz_server.shared)
        self.publication.publish(self.buttons.paused)
        return self.gz_server.shared

    @exclusive
    def initialize(self, entities: Iterable[Entity]) -> None:
        """Initialize entities that were added; they wait for `Initialize` where that is still to come.

        Raises:
            PluginError: one of them failed.
        """
        # An Init may insert models, which are initialized then, and delete some.
        for entity in list(entities) if self.running else ():
            if entity in self.entities:
                entity._entity_start()

    @exclusive
    def Finalize(self) -> int:
        """End all models, then the server; 0. Can be called twice."""
        if not self.running:
            return 0
        self.clock.stop()
        remove_running(self)
        self.publication = None
        self.rows.clear()
        for companion in self.companions:
            companion.close()
        for entity in self.entities:
            entity._entity_fini()
        self.sim.destroy()
        self.gz_server.stop()
        return 0

    @exclusive
    def close(self) -> None:
        """End the world and free everything in it. Can be called twice.

        Raises:
            GazeboError: it is called in a step, by a callback, or while plugins load or are reset.
            StrictError: a strict world had an error or warning that was not raised yet, such as one of a Fini.
        """
        if self._closed:
            return
        self._check_idle("closed")
        self._closed = True
        self.Finalize()
        self.rows.close()
        self.gz_server.stop()
        self.events.close()
        for entity in reversed(self.entities):
            entity._entity_end()
        self.engine.close()
        self._start = self._rewind = None  # large
        if sys.exc_info()[1] is None:  # an error that ends the world now has other causes
            self.problems.check(again=False)

    # Time ------------------------------------------------------------------------------------------------------------

    @law
    def GetSimTime(self) -> float:
        """Simulated time [s], pauses excluded."""
        return self.clock.sim_time

    def GetPauseTime(self) -> float:
        """Simulated time spent paused [s]: one step for each paused step."""
        return self.clock.pause_time

    def GetRealTime(self) -> float:
        """Wall-clock time since Initialize [s]."""
        return self.clock.real_time

    def GetWallTime(self) -> float:
        """Unix time [s]."""
        return time.time()

    def GetDayTime(self) -> float:
        """Time since midnight [s]: the world's dayTime plus real time, or the local clock's."""
        return self.clock.time_of_day()

    @property
    def iterations(self) -> int:
        """Steps done, pauses excluded."""
        return self.clock.iterations

    @exclusive
    def set_sim_time(self, seconds: float) -> None:
        """Set the sim time [s].

        Raises:
            ParameterError: it is NaN or infinite.
        """
        self.clock.set(seconds)

    # Step ------------------------------------------------------------------------------------------------------------

    def step(self, count: int = 1, last: LawCall | None = None) -> None:
        """Run `count` steps, as fast as possible. Threads that wait for the world have it between two of them.

        Args:
            count: steps.
            last: a law that is computed after them.
        """
        lock, obeyed = self.lock, 0
        with lock:  # taken once: that costs 1,000 instructions more than to see that it is held
            while count > 0:
                if lock.waiting:
                    lock.pass_on()
                count -= self._steps_alone(count, last=last)
                obeyed = self.rows.job.obeyed
            if last is not None and not obeyed:
                last()

    def step_beside(self, count: int, last: LawCall | None = None) -> Task[None]:
        """`step`, for a `Crew`."""
        lock, stepping, rows, obeyed = self.lock, self._stepping, self.rows, 0
        with lock:
            while count > 0:
                if lock.waiting:
                    lock.pass_on()
                self._begin_steps()
                try:
                    if free := stepping.prepare(count, last):
                        yield rows.job
                        made, end = stepping.finish(free)
                    else:
                        made, end = 1, stepping.run_in_python()
                    yield from self.agenda.awaited
                    end()
                finally:
                    self._inside = self.agenda.stepping = False
                self._end_steps()
                count -= made
                obeyed = rows.job.obeyed
            if last is not None and not obeyed:
                last()

    def step_on(self, most: int, pacer: Pacer | None = None) -> int:
        """Run one step, and more of them, `most` at most, for some milliseconds of real time; how many.

        With a pacer, which finds the first one due, others are made when they are due. For loops that have something
        to do now and then, but not in each step. Raises what `Step` does.
        """
        lock = self.lock
        if lock.waiting:
            lock.give_way()
        with lock:
            return self._steps_alone(most, None if pacer is None else pacer.pace)

    def batch(self, commands: Iterable[Columns] = (), readings: Iterable[Columns] = ()) -> Batch:
        """Commands and readings of many interfaces as two arrays, for loops that learn::

            batch = world.batch(
                commands=[("position.*", "cmd_vel_pos[0]", "cmd_vel_rot[2]")],
                readings=[("position.*", "pos[0]", "pos[1]", "rot[2]"), ("laser.*", "ranges")],
            )
            readings = batch.step([0.3, 0.1], steps=5)

        Args:
            commands: entries that are written before a step: a target, such as ``position.robot1`` or ``position.*``,
                and fields of it, such as ``cmd_vel_pos`` or ``cmd_vel_rot[2]``; see docs/interfaces.md.
            readings: entries that are read after it, likewise.

        Raises:
            NotFoundError: nothing serves a target.
            ParameterError: an interface has no such field, or none of these numbers yet; or a command is a field that
                the server writes.
            ClosedError: the world is closed, or `Initialize` was not called.
        """
        from libgz.simulation.batch import Batch  # most worlds do without it

        self._check_ready("controlled")
        return Batch(self, commands, readings)

    def run(self, seconds: float) -> None:
        """Run until that much more sim time [s] has passed, as fast as possible.

        Raises:
            ParameterError: it is negative, NaN or infinite.
        """
        what = "time to run [s]"
        self.step(round(finite(not_negative(seconds, what), what) / self.engine.step_time))

    def Step(self) -> int:
        """One step: buttons, models, physics, followers, clock, post to clients; 0.

        While another thread steps or changes the world, this one waits.

        Raises:
            GazeboError: it is called in a step, by a callback, or while plugins load or are reset.
            ClosedError: the world is closed, or `Initialize` was not called.
            StrictError: a strict world had an error or warning.
        """
        lock = self.lock
        if lock.waiting:
            lock.give_way()
        if not lock.try_acquire():  # at once if this thread holds it
            lock.wait()
        try:
            self._steps_alone(1)
        finally:
            lock.release()
        return 0

    def _steps_alone(self, count: int, pace: int | None = None, last: LawCall | None = None) -> int:
        """One step or more, in the thread that holds the lock; how many."""
        self.paced = pace is not None
        self._begin_steps()
        try:
            made = self._stepping.run(count, pace, last)
        finally:
            self._inside = self.agenda.stepping = False
        self._end_steps()
        return made

    @property
    def rewinding(self) -> bool:
        """Whether states are kept for `rewind`."""
        return self._rewind is not None

    def _begin_steps(self) -> None:
        if self._inside or self.agenda.holding or not self.clock.running:
            self._check_ready("stepped")
        self._inside = True

    def _end_steps(self) -> None:
        if self._rewind is not None and self._rewind.due(self.clock.sim_time):
            self._keep_state(self._rewind, self.clock.sim_time)
        if self.problems.failure is not None:
            self.problems.check()
        for companion in self.companions:
            companion.returned()

    def _keep_state(self, ring: Rewind, now: float) -> None:
        """Keep the present state for `rewind`; a SaveState that fails must not end the run."""
        try:
            ring.keep(now, self.snapshots.save())
        except GazeboError as error:
            if ring.fail(now):
                log.error("the state of sim time %g s cannot be kept for rewinding: %s", now, error)

    @property
    def present_step(self) -> tuple[int, float] | None:
        """What distinguishes the step that runs now from others: (number, pause time [s]); None between steps."""
        return (self.clock.iterations, self.clock.pause_time) if self._inside else None

    def _check_ready(self, what: str) -> None:
        if not self.clock.running:
            first = "Initialize comes before the first step" if what == "stepped" else "Initialize comes first"
            raise ClosedError("the world is closed" if self._closed else first)
        self._check_idle(what)

    def _check_idle(self, what: str) -> None:
        if self._inside:
            raise GazeboError(f"a world cannot be {what} in a callback: its step is under way")
        if self.agenda.holding:
            raise GazeboError(
                f"a world cannot be {what} while plugins load, are reset, come or go, or a state is saved or set"
            )

    def update_rows_changed(self) -> None:
        """Build the rows again before the next step; called after a change of what `plan_update` depends on."""
        self.rows.valid = False

    # State -----------------------------------------------------------------------------------------------------------

    @exclusive
    def get_state(self) -> bytes:
        """The whole state of the world, for `set_state`; equal states are equal bytes.

        Raises:
            GazeboError: a step is under way, or plugins load or are reset.
            ClosedError: the world is closed, or `Initialize` was not called.
            ParameterError: a model or plugin declares something as its state that is not plain data.
            PluginError: a SaveState failed; the message has the traceback.
        """
        if self._inside or self.agenda.holding or not self.clock.running:
            self._check_ready("saved")
        self._warn_of_models()
        return self.snapshots.save()

    @exclusive
    def set_state(self, state: bytes, *, untrusted: bool = False) -> None:
        """Bring the world into a state of itself, or of another world of the same file, in any process.

        What happens from then on is equal to the bit to what happened after `get_state`. Models that came since are
        removed. From the first one on that went, models are built again, in their order; references to the former ones
        raise ClosedError. Clients stay connected.

        Args:
            state: the bytes.
            untrusted: for states of strangers: one that needs a plugin to be loaded is refused.

        Raises:
            GazeboError: a step is under way, or plugins load or are reset.
            ClosedError: the world is closed, or `Initialize` was not called.
            StateError: these bytes are no state of this version of libgz, or one of another file, or damaged, or
                something that cannot be built again is missing; the world is as before.
            PluginError: a LoadState failed; the message has the traceback. Or a plugin is needed, and not trusted.
        """
        if self._inside or self.agenda.holding or not self.clock.running:
            self._check_ready("restored")
        with self.agenda.hold():
            self.snapshots.restore(state, untrusted=untrusted)

    def keep_rewind(self, seconds: float, interval: float = 0.1, megabytes: float = 512.0) -> None:
        """Keep the states of the last seconds of sim time from now on, for `rewind`; 0 seconds end that.

        Args:
            seconds: how far `rewind` can go back [s].
            interval: between two states [s]; 0 for one after each step.
            megabytes: what all states may take; beyond that the oldest ones are dropped.

        Raises:
            ParameterError: a number is negative, or not finite.
            GazeboError: the world's state cannot be saved; see `get_state`.
        """
        from libgz.simulation.rewind import Rewind  # most worlds do without it

        for value, what in ((seconds, "seconds"), (interval, "interval [s]"), (megabytes, "megabytes")):
            finite(not_negative(value, what), what)
        with self.lock:
            self._check_ready("saved")
            ring = Rewind(seconds, interval, megabytes) if seconds > 0.0 else None
            if ring is not None:
                ring.keep(self.clock.sim_time, self.get_state())
            self._rewind = ring

    def rewind(self, seconds: float) -> float:
        """Bring the world back to the last state that was kept `seconds` or more before now; its sim time [s].

        Raises:
            ParameterError: the number is negative, or not finite.
            StateError: no state was kept, or none that old.
            GazeboError: a step is under way; and the errors of `set_state`.
        """
        finite(not_negative(seconds, "seconds"), "seconds")
        with self.lock:
            self._check_ready("rewound")
            if self._rewind is None:
                raise StateError("no states are kept to rewind to: call keep_rewind first, or start with --rewind SEC")
            self.set_state(self._rewind.at(self.clock.sim_time - seconds))
            self._rewind.due(self.clock.sim_time)
            return self.clock.sim_time

    def clone(self) -> Self:
        """An independent world of the same file in the same state, without a server for other processes.

        Its name is the same; in the names of its topics, `topic_space` stands instead of it.

        Raises:
            GazeboError: a step is under way, or plugins load or are reset.
            StateError: the world was not loaded from a file.
        """
        state = self.get_state()
        clone = self._twin()  # without this world's lock: a plugin's Load may wait for a thread that uses this world
        try:
            clone.Initialize()
            clone.set_state(state)
        except BaseException:
            clone.close()
            raise
        return clone

    def _twin(self) -> Self:
        """Another world of the same file, which is not initialized.

        Raises:
            StateError: the world was not loaded from a file.
        """
        twin = type(self)(
            seed=self.seed,
            solver=self.engine.solver,
            wire_version=self.gz_server.version,
            abi=self.gz_server.abi,
            strict=self.problems.strict,
        )
        twin.clone_name = f"{self.name}_clone{next(_clones)}"
        try:
            self.era.load_into(twin)
        except BaseException:
            twin.close()
            raise
        return twin

    def reload_plugin(self, name: str) -> list[str]:
        """Load an edited plugin file again while the world runs.

        Plugins of classic: the connections and subscriptions of the former instance end; a new one gets Load with the
        same arguments, then Init, then the state that both declare. Models of worldfiles: each model of the file is
        built again in its place, with its pose, its velocity, its declared state, and what is attached to it; clients
        of its interfaces stay connected. Modules beside the file that it imports are loaded again, too, if one was
        edited. If the new one fails, the former one runs on.

        Args:
            name: of the plugin (``drive``, or ``robot1::drive``), of its file (``drive.py``, ``libdrive.so``), or the
                id or class of a model of a worldfile. All plugins that are called this are replaced.

        Returns:
            What was replaced, such as ``Model plugin robot1::drive``.

        Raises:
            NotFoundError: no plugin has this name.
            PluginError: the edited file, its Load or its Init fails; the message has the traceback.
            GazeboError: a step is under way, or plugins load or are reset.
            ClosedError: the world is closed, or `Initialize` was not called.
        """
        from libgz.simulation.reloading import reload  # most worlds do without it

        with self.lock:
            self._check_ready("changed")
            return reload(self, name)

    def forget_states(self) -> None:
        """Drop the states that were kept: entities are built otherwise now. A reset finds out anew how they begin."""
        self._start_is_old = True
        if self._rewind is not None:
            self._rewind.clear()

    @property
    def seed(self) -> int:
        """What all random numbers begin with; while the world runs, to set it is to call `reseed`."""
        return self._seed

    @seed.setter
    def seed(self, seed: int) -> None:
        if self.running:
            self.reseed(seed)
        else:
            self.begin_random(seed)

    @property
    def random(self) -> np.random.SeedSequence:
        """Parent of the random numbers of sensors and models; made when first used, because numpy loads it slowly."""
        if self._random is None:
            self._random = np.random.SeedSequence(self.seed, n_children_spawned=self._spawned)
        return self._random

    @property
    def spawned(self) -> int:
        """How many generators were made from `random`."""
        return self._spawned if self._random is None else self._random.n_children_spawned

    def restart_random(self, spawned: int) -> None:
        """Make `random` that of the present seed, from which so many generators were made."""
        self._random, self._spawned = None, spawned

    def reseed(self, seed: int) -> None:
        """Begin new random numbers, those of a world that was made with this seed: of sensors' noise and of ODE.

        A generator that a model of your own made stays as it is; `random.n_children_spawned` counts those that were
        made from the world's `random`. A state has its world's seed, and so does the state that a reset returns to.

        Raises:
            ParameterError: the seed is negative, or no integer.
            GazeboError: a step is under way, or plugins load or are reset.
        """
        with self.lock:
            self._check_ready("given a seed")
            self.begin_random(seed)

    def begin_random(self, seed: int) -> None:
        """Do what `reseed` describes, also while a state is set.

        Raises:
            ParameterError: the seed is negative, or no integer.
        """
        if not isinstance(seed, int):
            raise ParameterError(f"seed is {seed!r}; it must be an integer")
        not_negative(seed, "seed")
        self._seed = self.engine.seed = seed
        self.restart_random(self.spawned)
        for companion in self.companions:
            companion.reseed(seed)

    def return_to_start(self) -> None:
        """Bring the world into its state at the end of Initialize.

        Raises:
            ClosedError: `Initialize` was not called.
            GazeboError: that state could not be saved.
        """
        start = self._first_state() if self._start_is_old else self._start
        if start is None:
            raise ClosedError("Initialize comes before the first reset")
        if isinstance(start, GazeboError):
            raise start
        self._warn_of_models()
        # After a class was edited, the order of the engine's objects is another one.
        self.snapshots.restore(start, anew=self._start_is_old)
        self._start, self._start_is_old = start, False

    @exclusive
    def begin_here(self) -> None:
        """Make the present state the one that a reset returns to, such as after an edit before the first step."""
        self._start, self._start_is_old = None, False  # while it is taken, the world is `starting`
        try:
            self._start = self.snapshots.save()
        except GazeboError as error:
            self._start = error

    def _first_state(self) -> bytes | GazeboError | None:
        """The state at the start of a world of the same file, with models as their classes are now."""
        with self._twin() as twin:
            twin.Initialize()
            return twin._start

    @property
    def _surroundings(self) -> bytes:
        """Vectors and colours, as the bytes of their numbers."""
        backdrop, zone, offset, sky = self.backdrop, self.utmZone, self.utmOffset, self.skyColor
        ambient, fog = backdrop.ambient, backdrop.fog_color
        return _SURROUNDINGS.pack(
            *(zone.x, zone.y, zone.z, offset.x, offset.y, offset.z),
            *(sky.r, sky.g, sky.b, sky.a, ambient.r, ambient.g, ambient.b, ambient.a),
            *(backdrop.fog_start, backdrop.fog_end, fog is not None),
            *(_NO_FOG if fog is None else (fog.r, fog.g, fog.b, fog.a)),
        )

    @_surroundings.setter
    def _surroundings(self, packed: bytes) -> None:
        numbers, backdrop = _SURROUNDINGS.unpack(packed), self.backdrop
        self.utmZone, self.utmOffset = GzVector(*numbers[:3]), GzVector(*numbers[3:6])
        self.skyColor, backdrop.ambient = GzColor(*numbers[6:10]), GzColor(*numbers[10:14])
        backdrop.fog_start, backdrop.fog_end, foggy, *fog = numbers[14:]
        backdrop.fog_color = GzColor(*fog) if foggy else None

    def warn_of_undeclared(self, what: str, kind: type) -> None:
        """Warn once of a class of users that does not declare its state; `what` is what it is, such as ``model``."""
        if kind in self._undeclared or not undeclared(kind):
            return
        self._undeclared.add(kind)
        if getattr(kind, "not_kept", ""):
            log.warning("%s %s: %s", what, kind.__name__, kind.not_kept)  # type: ignore[attr-defined]
            return
        log.warning(
            "%s %s declares no state, so states and resets keep only its bodies, joints and interfaces: add STATE = "
            '("name", ...) with the attributes that change while it runs, or STATE = () if none does',
            what,
            kind.__name__,
        )

    def _warn_of_models(self) -> None:
        if self.entities != self._checked:
            self._checked = list(self.entities)
            for kind in {type(entity): None for entity in self.entities}:
                self.warn_of_undeclared("model", kind)

    def next_number(self) -> int:
        """A number for a new entity."""
        self._numbers += 1
        return self._numbers

    # Changes ---------------------------------------------------------------------------------------------------------

    def after_step(self, action: Callable[[], object]) -> None:
        """Call `action` at once; during a step, or while plugins load or are reset, after that."""
        self.agenda.after_step(action)

    def hold(self) -> AbstractContextManager[None]:
        """Hold changes back until the end; inside another hold or a step, until the end of that."""
        return self.agenda.hold()

    @property
    def paused(self) -> bool:
        """Whether time stands still."""
        return self.buttons.pause

    @paused.setter
    @exclusive
    def paused(self, value: bool) -> None:
        if self.buttons.press_pause(bool(value)):
            self.events["Pause"](bool(value))

    @exclusive
    def SetModelPose(self, model: Entity, pose: GzPose) -> None:
        """Move a model, and all that is attached to it, to a pose relative to its parent body, or global [m].

        All velocities become zero.
        """
        pose = GzPoseOf(pose)
        parent = model.parentBody
        self._move(model, GzCoordPoseAdd(pose, parent.GetPose()) if parent is not None else pose)
        if parent is not None:
            model.relPose = pose
            model.weld()

    def _move(self, entity: Entity, target: GzPose) -> None:
        """Move an entity to a global pose; its children move rigidly with the bodies they are attached to."""
        places = [
            (child, GzCoordPoseSub(child.GetPose(), child.parentBody.GetPose()))
            for child in entity.children
            if child.parentBody is not None
        ]
        entity.SetPose(target)
        for child, relative in places:
            if child.parentBody is not None:
                self._move(child, GzCoordPoseAdd(relative, child.parentBody.GetPose()))

    @exclusive
    def ResetModelPoses(self) -> None:
        """Return all models to their initial poses, at rest. The clock and the models' own memory stay."""
        for entity in self.entities:
            self.SetModelPose(entity, entity.initPose)

    def Reset(self) -> None:
        """Return the world to its state at the end of Initialize. During a step, after it.

        Models that were inserted since are removed, deleted ones are built again. In a world of classic, plugins are
        not returned to an earlier state: their `Reset` is called.

        Raises:
            GazeboError: a reset that was asked for in a reset, such as by a plugin's `Reset`, asks for another one.
        """
        with self.lock:
            if self._resetting_again:
                raise GazeboError("a reset that a reset has asked for asks for another one, which would never end")
            again = self._resetting
            self.after_step(lambda: self._reset(again))

    def _reset(self, again: bool) -> None:
        before = self._resetting, self._resetting_again
        self._resetting, self._resetting_again = True, again
        try:
            self.era.reset(self)
        finally:
            self._resetting, self._resetting_again = before

    reset = Reset

    @exclusive
    def Save(self, *, whole: bool = False) -> int:
        """Make the present poses of top-level models their initial ones, and write them to the file; 0 or -1.

        Args:
            whole: whether models that were deleted are left out, and inserted ones are added at the end; without it
                the file keeps its models, as the button `save` of interface `sim` always did.
        """
        return self.era.save(self, whole)


def _of_kind(found: E, kind: type[Any], what: str) -> E:
    """What was found, if it is of a class."""
    if not isinstance(found, kind):
        raise ParameterError(f"{what} is a {type(found).__name__}, not a {kind.__name__}")
    return found


names(World._steps_alone, lambda _: "", outermost=True)
