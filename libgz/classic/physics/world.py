"""World: a view on a simulated world, for plugins; the parent of all other views.

Modules below import the types of views above them, such as Model for Link, from here, for type checkers only; at run
time each of them imports modules below it only.
"""

from __future__ import annotations

import itertools
import math
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.base.errors import NotFoundError, nearest
from libgz.base.geometry import GzVector, VectorLike
from libgz.base.law import law
from libgz.classic.common import SphericalCoordinates, Time
from libgz.classic.math import Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.atmosphere import Atmosphere
from libgz.classic.physics.base import Base, Entity, find_named, view_of
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.insertion import insert_document, insert_file, insert_text
from libgz.classic.physics.joint import Joint
from libgz.classic.physics.light import Light
from libgz.classic.physics.link import Link
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.wind import Wind
from libgz.classic.physics.world_services import WorldServices
from libgz.physics.check import LARGEST, finite_tuple
from libgz.sdf.element import Element
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from collections.abc import Callable

    from libgz.classic import sdf as classic_sdf
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.state import WorldState
    from libgz.physics.body import Body
    from libgz.physics.geom import Geom
    from libgz.physics.lock import WorldLock
    from libgz.sdf.reader import SdfFile
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["Joint", "Link", "Model", "World"]

_LATEST = 2.0**31 - 1.0  # [s]

NO_HIT = 1000.0  # [m] the range of rays that look for the entity below, and their distance without a hit


@takes_names
class World(Base):
    """A view on a simulated world.

    Attributes:
        core: the engine's world.
        server: the WorldServer, which keeps all state that is not the engine's.
        played: of a world that plays a log, returns the first and the last time of the log [s].
    """

    def __init__(self, core: CoreWorld, server: WorldServices) -> None:
        self.core, self.server = core, server
        self.played: Callable[[], tuple[float, float]] | None = None
        super().__init__(self, core.name, None)

    def Name(self) -> str:
        """The name."""
        return self.core.name

    GetName = Name

    def children(self) -> list[Base]:
        """The top-level models, then the lights."""
        return [*self.Models(), *self.Lights()]

    def SDF(self) -> Element | Any:
        """The `<world>` element."""
        return self.server.element

    GetSDF = SDF

    # Time --------------------------------------------------------------------------------------------------------

    def SimTime(self) -> Time:
        """The sim time, pauses excluded; within +-2^31 s, as a Time of Gazebo."""
        return Time(max(-_LATEST, min(_LATEST, self.core.GetSimTime())))

    GetSimTime = SimTime

    def SetSimTime(self, t: Time) -> None:
        """Set the sim time."""
        self.core.set_sim_time(float(t))

    def RealTime(self) -> Time:
        """The real time since the world started."""
        return Time(self.core.GetRealTime())

    GetRealTime = RealTime

    def PauseTime(self) -> Time:
        """The sim time spent paused."""
        return Time(self.core.GetPauseTime())

    GetPauseTime = PauseTime

    def StartTime(self) -> Time:
        """The wall-clock time at which the world started."""
        return Time(self.core.GetWallTime() - self.core.GetRealTime())

    GetStartTime = StartTime

    def Iterations(self) -> int:
        """The number of iterations."""
        return self.core.iterations

    GetIterations = Iterations

    # Run ---------------------------------------------------------------------------------------------------------

    def IsPaused(self) -> bool:
        """Whether the world is paused."""
        return self.core.paused

    def SetPaused(self, p: bool) -> None:
        """Pause the world, or resume it."""
        self.core.paused = bool(p)

    def Step(self, steps: int = 1) -> None:
        """Run a number of iterations, also of a paused world, which is paused again afterwards."""
        paused = self.core.paused
        self.core.paused = False
        try:
            self.core.step(steps)
        finally:
            if paused:
                self.core.paused = True
        self.core.events["Step"]()

    StepWorld = Step

    def Run(self, iterations: int = 0) -> None:
        """Run a number of iterations; 0: until Stop is called."""
        self.server.stopped = False
        done = 0
        while not self.server.stopped and (not iterations or done < iterations):
            self.core.Step()
            done += 1

    RunBlocking = Run

    def Stop(self) -> None:
        """End Run, or the loop of gzserver."""
        self.server.stopped = True

    def Running(self) -> bool:
        """Whether Stop was not called."""
        return not self.server.stopped

    GetRunning = Running

    def PhysicsEnabled(self) -> bool:
        """Whether physics is enabled."""
        return self.core.physics_enabled

    GetEnablePhysicsEngine = PhysicsEnabled

    def SetPhysicsEnabled(self, enable: bool) -> None:
        """Enable or disable physics; without it sim time advances and nothing moves."""
        self.core.physics_enabled = bool(enable)

    EnablePhysicsEngine = SetPhysicsEnabled

    # Reset -------------------------------------------------------------------------------------------------------

    def Reset(self) -> None:
        """Reset time, models and plugins; in a callback, at the end of the iteration."""
        self.core.Reset()

    def ResetTime(self) -> None:
        """Set the sim time to 0; in a callback, at the end of the iteration."""
        self.core.after_step(self._reset_time)

    def _reset_time(self) -> None:
        self.core.clock.reset()
        self.server.time_was_reset()
        self.core.events["TimeReset"]()

    def ResetEntities(self, type: int = Base.BASE) -> None:
        """Reset the entities of a type: Base.MODEL, Base.LIGHT, Base.ENTITY or Base.BASE; other types are not reset.

        As in Gazebo, Base.MODEL resets models alone: their links and joints stay as they are in them.
        """
        if type == Base.MODEL:
            for model in self.all_models():
                model.Reset()
        if type in (Base.BASE, Base.ENTITY):
            for model in self.Models():
                model.restore()
        if type in (Base.BASE, Base.ENTITY, Base.LIGHT):
            for light in self.Lights():
                light.SetWorldPose(light.InitialRelativePose())

    def ResetPhysicsStates(self) -> None:
        """Set velocities, forces and torques of all links to zero."""
        for model in self.Models():
            model.ResetPhysicsStates()

    def EnableAllModels(self) -> None:
        """Wake all links."""
        for model in self.Models():
            model.SetEnabled(True)

    def DisableAllModels(self) -> None:
        """Put all links to sleep (auto-disabled)."""
        for model in self.Models():
            model.SetEnabled(False)

    def IsLoaded(self) -> bool:
        """Whether it is loaded: always, for a plugin's Load is called afterwards."""
        return True

    def WorldPoseMutex(self) -> WorldLock:
        """The world's lock: ``with world.WorldPoseMutex():`` holds off steps and other threads."""
        return self.core.lock

    GetSetWorldPoseMutex = WorldPoseMutex

    # Models ------------------------------------------------------------------------------------------------------

    def all_models(self) -> list[Model]:
        """All models, nested ones included."""
        return [self.view(core) for core in self.core.models]

    def view(self, core: CoreModel) -> Model:
        """The view on a model of the engine."""
        return view_of(core, lambda: _model_class(core)(self, core, self._parent_of(core)))

    def view_of(self, core: CoreModel) -> Model | Light | None:
        """The view on a model or light of the engine's world; None for what is neither."""
        if isinstance(core, SdfLight):
            return self._light(core)
        return self.view(core) if core.is_model else None

    def _parent_of(self, core: CoreModel) -> Model | None:
        return self.view(core.parent) if isinstance(core.parent, SdfModel) else None

    def Models(self) -> list[Model]:
        """The top-level models."""
        return [model for model in self.all_models() if model.GetParent() is self]

    GetModels = Models

    def ModelCount(self) -> int:
        """The number of top-level models."""
        return len(self.Models())

    GetModelCount = ModelCount

    def ModelByName(self, name: str) -> Model | Any:
        """A model by its scoped name, else the first with this name, nested ones included; None if there is none."""
        name = name.removeprefix(f"{self.Name()}::")
        found = self.model_of(name)
        if found is not None and found.GetScopedName() == name:
            return found
        model: Model | Any = find_named(self.all_models(), name)  # renamed, or nested
        return model

    def model_of(self, identifier: str) -> Model | None:
        """The model with this id in the engine, which is its scoped name until it is renamed; None if there is none."""
        core = next((core for core in self.core.models if core.GetId() == identifier), None)
        return None if core is None else self.view(core)

    def ModelByIndex(self, index: int) -> Model | Any:
        """A top-level model by index; None if there is none."""
        models = self.Models()
        return models[index] if 0 <= index < len(models) else None

    def GetModel(self, which: str | int) -> Model | Any:
        """A model by name or index; None if there is none."""
        return self.ModelByIndex(which) if isinstance(which, int) else self.ModelByName(which)

    def BaseByName(self, name: str) -> Base | Any:
        """A model, link, joint, collision or light by name or scoped name, the world by its own; None for none."""
        if name == self.Name():
            return self
        name = name.removeprefix(f"{self.Name()}::")
        scope = name
        while scope:  # search the model of a scoped name before all others
            model = self.ModelByName(scope)
            found = next((part for part in model.tree() if part.GetScopedName() == name), None) if model else None
            if found is not None:
                return found
            scope = scope.rpartition("::")[0]
        return find_named((part for top in self.children() for part in top.tree()), name)

    GetByName = BaseByName

    def EntityByName(self, name: str) -> Entity | Any:
        """A model, link, collision or light by name; None if there is none."""
        found = self.BaseByName(name)
        return found if isinstance(found, Entity) else None

    GetEntity = EntityByName

    def Lights(self) -> list[Light]:
        """All lights."""
        cores = self.core.extension(SdfWorld).lights
        return [self._light(core) for core in cores]

    def _light(self, core: SdfLight) -> Light:
        return view_of(core, lambda: Light(self, core))

    def LightCount(self) -> int:
        """The number of lights."""
        return len(self.Lights())

    def LightByName(self, name: str) -> Light | Any:
        """A light by name; None if there is none."""
        name = name.removeprefix(f"{self.Name()}::")
        return next((light for light in self.Lights() if light.GetName() == name), None)

    def Light(self, which: str | int) -> Light | Any:
        """A light by name or index; None if there is none."""
        lights = self.Lights()
        if isinstance(which, int):
            return lights[which] if 0 <= which < len(lights) else None
        return self.LightByName(which)

    GetLight, GetLights, GetLightCount = Light, Lights, LightCount

    def PrintEntityTree(self) -> str:
        """The names of all objects, one per line."""
        return self.Print()

    # Views on bodies and geoms -----------------------------------------------------------------------------------

    def link_of(self, body: Body) -> Link | None:
        """The view on a body; None for one that belongs to no model of this world."""
        core = body.model
        if core is None or core.world is not self.core or not core.is_model:
            return None
        return self.view(core).link(body)

    def collision_of(self, geom: Geom) -> Collision | None:
        """The view on a geom; None for one that belongs to no model of this world, and for one without contacts."""
        if geom.facade is None:
            link = self.link_of(geom.body)
            if link is None:
                return None
            link.GetCollisions()  # creates the views of all its geoms
        view: Collision | None = geom.facade
        return view

    def ray_down(self, start: VectorLike, above: Base | None = None) -> tuple[float, str]:
        """(distance [m], scoped name) of the nearest collision below a point, without those of link `above`.

        Raises:
            ParameterError: the point is not finite, or out of range.
        """
        engine = self.core.engine
        frame = np.array((*finite_tuple(start, 3, "point [m]", LARGEST), 1.0, 0.0, 0.0, 0.0))
        rays = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, -1.0, NO_HIT]])
        ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
        owner = above.body.number if isinstance(above, Link) else 0
        engine.scan(frame, rays, owner, ranges, rows)
        row = int(rows[0])
        if row < 0:
            return NO_HIT, ""
        collision = self.collision_of(engine.geoms[row])
        return float(ranges[0]), collision.GetScopedName() if collision is not None else ""

    def EntityBelowPoint(self, pt: VectorLike) -> Entity | Any:
        """The nearest collision below a point [m]; None if there is none."""
        return self.EntityByName(self.ray_down(pt)[1])

    def ModelBelowPoint(self, pt: VectorLike) -> Model | Any:
        """The model of the nearest collision below a point [m]; None if there is none."""
        entity = self.EntityBelowPoint(pt)
        return entity.GetParentModel() if entity is not None else None

    GetEntityBelowPoint, GetModelBelowPoint = EntityBelowPoint, ModelBelowPoint

    def UniqueModelName(self, name: str) -> str:
        """The name itself, or with ``_0``, ``_1``, ... at its end the first that no model has."""
        numbers = itertools.count()
        found = name
        while self.ModelByName(found) is not None:
            found = f"{name}_{next(numbers)}"
        return found

    def StripWorldName(self, name: str) -> str:
        """A scoped name without the world's name before it."""
        return name.removeprefix(f"{self.Name()}::")

    # Changes -----------------------------------------------------------------------------------------------------

    def InsertModelString(self, sdfString: str) -> None:
        """Add the models and lights of an SDF text; in a callback, at the end of the iteration.

        Raises:
            ParameterError: it is not a string.
        """
        insert_text(self, sdfString)

    def InsertModelFile(self, sdfFilename: str | os.PathLike[str]) -> None:
        """Add the models and lights of a file or `model://name`; in a callback, at the end of the iteration.

        Raises:
            ParameterError: it is not the name of a file.
        """
        insert_file(self, sdfFilename)

    def InsertModelSDF(self, sdf: Element | SdfFile | classic_sdf.SDF) -> None:
        """Add the models and lights of an SDF document; in a callback, at the end of the iteration.

        Raises:
            ParameterError: it is not an SDF document.
        """
        insert_document(self, sdf)

    def LoadLight(self, sdf: Element | SdfFile | classic_sdf.SDF, parent: Base | None = None) -> None:
        """Add the light of a `<light>` element; in a callback, at the end of the iteration.

        Raises:
            ParameterError: it is not an SDF document.
        """
        insert_document(self, sdf)

    def RemoveModel(self, which: Model | str) -> None:
        """Remove a model, with all nested models, or a light; in a callback, at the end of the iteration.

        Raises:
            NotFoundError: there is none of this name.
        """
        entity: Base | None = which if isinstance(which, Base) else self._removable(which)
        if entity is None or not isinstance(entity, Model | Light):
            names = [part.GetName() for part in self.children()]
            raise NotFoundError(f"world {self.Name()!r} has no model {which!r}{nearest(str(which), names)}")
        family: list[CoreModel] = [entity.core]
        if isinstance(entity, Model):
            family = [model.core for model in entity.family()]
        nested_first = list(reversed(family))
        self.core.after_step(lambda: self.core.remove(nested_first))

    def _removable(self, name: str) -> Base | Any:
        """The model or light of a name, which the world, or a link, may have, too."""
        model = self.ModelByName(name)
        return model if model is not None else self.LightByName(name)

    def Clear(self) -> None:
        """Remove all models and lights."""
        for part in self.children():
            self.RemoveModel(part)  # type: ignore[arg-type]

    def LoadPlugin(self, filename: str, name: str, sdf: Element | None = None) -> None:
        """Load a World plugin now."""
        self.server.plugins.load_for_world(filename, name, sdf)

    def RemovePlugin(self, name: str) -> None:
        """Remove a World plugin; its connections and subscriptions end.

        Raises:
            NotFoundError: there is none of this name.
        """
        self.server.plugins.remove_from_world(name)

    # Physics -----------------------------------------------------------------------------------------------------

    def Physics(self) -> PhysicsEngine:
        """The physics engine."""
        return self.server.physics

    GetPhysicsEngine = Physics

    def PresetMgr(self) -> PresetManager:
        """The physics profiles."""
        return self.server.presets

    GetPresetManager = PresetMgr

    @law
    def Gravity(self) -> Vector3d:
        """The gravity [m/s^2]."""
        return Vector3d(*self.core.engine.gravity)

    def SetGravity(self, gravity: VectorLike) -> None:
        """Set the gravity [m/s^2], and wake all models."""
        self.core.engine.gravity = tuple(gravity)
        for model in self.Models():
            model.SetEnabled(True)

    def MagneticField(self) -> Vector3d:
        """The magnetic field [T]."""
        return Vector3d(*self.core.extension(SdfWorld).settings.magnetic_field)

    def SetMagneticField(self, field: VectorLike) -> None:
        """Set the magnetic field [T].

        Raises:
            ParameterError: it is not three finite numbers.
        """
        self.core.extension(SdfWorld).settings.magnetic_field = GzVector(*finite_tuple(field, 3, "magnetic field [T]"))

    def Wind(self) -> Wind:
        """The wind."""
        return view_of(self.core.extension(SdfWorld).settings.wind, lambda: Wind(self))

    def WindEnabled(self) -> bool:
        """Whether there is wind."""
        return self.core.extension(SdfWorld).settings.wind.enabled

    def SetWindEnabled(self, enable: bool) -> None:
        """Enable or disable the wind."""
        self.core.extension(SdfWorld).settings.wind.enabled = bool(enable)

    def Atmosphere(self) -> Atmosphere:
        """The air: temperature, pressure, density."""
        return view_of(self.core.extension(SdfWorld).settings.atmosphere, lambda: Atmosphere(self))

    def AtmosphereEnabled(self) -> bool:
        """Whether the atmosphere is enabled."""
        return self.core.extension(SdfWorld).settings.atmosphere.enabled

    def SetAtmosphereEnabled(self, enable: bool) -> None:
        """Enable or disable the atmosphere: a mark for plugins, which its numbers do not depend on."""
        self.core.extension(SdfWorld).settings.atmosphere.enabled = bool(enable)

    def SphericalCoords(self) -> SphericalCoordinates:
        """The world's position and orientation on Earth, from its file."""
        place = self.core.extension(SdfWorld).settings.spherical_coordinates
        if place is None:
            return SphericalCoordinates()
        return SphericalCoordinates(
            SphericalCoordinates.EARTH_WGS84,  # the only surface that SDF has
            math.radians(place.Get(float, "latitude_deg")),
            math.radians(place.Get(float, "longitude_deg")),
            place.Get(float, "elevation"),
            math.radians(place.Get(float, "heading_deg")),
        )

    GetSphericalCoordinates = SphericalCoords

    # Sensors, state ----------------------------------------------------------------------------------------------

    def SensorsInitialized(self) -> bool:
        """Whether all sensors are ready: always, as soon as the world runs."""
        return True

    def SetState(self, state: WorldState) -> None:
        """Set the poses and velocities of all links to those of a state."""
        state.apply(self)

    def Save(self, filename: str) -> None:
        """Write the world as SDF with the present poses.

        Raises:
            WorldFileError: the file cannot be written.
        """
        from libgz.classic.physics.state import save_world  # most worlds do without it

        save_world(self, Path(filename))


def _model_class(core: CoreModel) -> type[Model]:
    """The class of the view on a model or an actor."""
    if not core.is_actor:
        return Model
    from libgz.classic.physics.actor import Actor  # with it come skeletons

    return Actor
