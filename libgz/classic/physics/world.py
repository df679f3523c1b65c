"""World: a view on a running world, as plugins see it."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from libgz.classic.common import Battery, SphericalCoordinates, Time
from libgz.classic.math import Vector3d
from libgz.classic.physics.animations import Animations
from libgz.classic.physics.base import Base, Entity, find_named, view_of
from libgz.classic.physics.engine import PhysicsEngine
from libgz.classic.physics.insertion import insert_document, insert_file, insert_text
from libgz.classic.physics.light import Light
from libgz.classic.physics.model import Model
from libgz.classic.physics.preset import PresetManager
from libgz.classic.physics.registry import enter, leave
from libgz.classic.physics.state import WorldState, save_world
from libgz.errors import NotFoundError, nearest
from libgz.geometry import GzCoordPoseAdd, GzPose, VectorLike
from libgz.physics.check import LARGEST, finite_tuple
from libgz.sdf.element import Element
from libgz.sdfworld.light import SdfLight
from libgz.sdfworld.model import SdfModel
from libgz.sdfworld.world import SdfWorld
from libgz.simulation.event import Event
from libgz.simulation.world import World as CoreWorld

if TYPE_CHECKING:
    from libgz.classic import sdf as classic_sdf
    from libgz.classic.physics.joint_controller import JointController
    from libgz.classic.server import WorldServer
    from libgz.physics.body import Body
    from libgz.physics.geom import Geom
    from libgz.sdf.reader import SdfFile
    from libgz.simulation.entity import Entity as CoreModel

__all__ = ["World"]

NOWHERE = 1000.0  # [m] what looks down sees nothing farther than this


class World(Base):
    """A view on a simulated world."""

    def __init__(self, core: CoreWorld, server: WorldServer) -> None:
        self.core, self.server = core, server
        super().__init__(self, core.name, None)
        self.animations = Animations(self)
        self.controllers: list[JointController] = []
        self._physics = PhysicsEngine(self)
        self._presets: PresetManager | None = None
        self.joint_event = Event("JointUpdate")
        self._batteries: list[Battery] | None = None
        self._attached: list[tuple[Model, Model, GzPose]] = []
        enter(self)

    def Name(self) -> str:
        """The name in its file."""
        return self.core.name

    GetName = Name

    def children(self) -> list[Base]:
        """Models, then lights."""
        return [*self.Models(), *self.Lights()]

    def SDF(self) -> Element | None:
        """The `<world>` element."""
        return self.server.element

    GetSDF = SDF

    # Time --------------------------------------------------------------------------------------------------------

    def SimTime(self) -> Time:
        """Simulated time, pauses excluded."""
        return Time(self.core.GetSimTime())

    GetSimTime = SimTime

    def SetSimTime(self, t: Time) -> None:
        """Set the simulated time."""
        self.core.set_sim_time(float(t))

    def RealTime(self) -> Time:
        """Time since the world started."""
        return Time(self.core.GetRealTime())

    GetRealTime = RealTime

    def PauseTime(self) -> Time:
        """Simulated time spent paused."""
        return Time(self.core.GetPauseTime())

    GetPauseTime = PauseTime

    def StartTime(self) -> Time:
        """Wall-clock time when the world started."""
        return Time(self.core.GetWallTime() - self.core.GetRealTime())

    GetStartTime = StartTime

    def Iterations(self) -> int:
        """Steps done."""
        return self.core.iterations

    GetIterations = Iterations

    def IsPaused(self) -> bool:
        """Whether time stands still."""
        return self.core.paused

    def SetPaused(self, p: bool) -> None:
        """Stop time, or let it run."""
        self.core.paused = bool(p)

    def Step(self, steps: int = 1) -> None:
        """Run so many iterations, paused or not; a paused world is paused again after them."""
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
        """Run so many iterations; 0: until Stop is called."""
        self.server.stopped = False
        done = 0
        while not self.server.stopped and (not iterations or done < iterations):
            self.core.Step()
            done += 1

    def Stop(self) -> None:
        """End Run, or the server's loop."""
        self.server.stopped = True

    def Running(self) -> bool:
        """Whether it has not been stopped."""
        return not self.server.stopped

    GetRunning = Running

    def PhysicsEnabled(self) -> bool:
        """Whether forces and contacts act."""
        return self.core.physics_enabled

    GetEnablePhysicsEngine = PhysicsEnabled

    def SetPhysicsEnabled(self, enable: bool) -> None:
        """Let physics act, or leave all where it is while time goes on."""
        self.core.physics_enabled = bool(enable)

    EnablePhysicsEngine = SetPhysicsEnabled

    # Reset -------------------------------------------------------------------------------------------------------

    def Reset(self) -> None:
        """Put clock, models and plugins back to the start; in a callback, at the end of this iteration."""
        self.core.Reset()

    def ResetTime(self) -> None:
        """Set the clock to 0."""
        self.core.after_step(self._reset_time)

    def _reset_time(self) -> None:
        self.core.clock.reset()
        self.server.time_was_reset()
        self.core.events["TimeReset"]()

    def ResetEntities(self, type: int = Base.BASE) -> None:
        """Put entities of a kind back: models, or everything."""
        if type in (Base.BASE, Base.ENTITY, Base.MODEL):
            for model in self.Models():
                model.Reset()

    # Models ------------------------------------------------------------------------------------------------------

    def all_models(self) -> list[Model]:
        """All models, nested ones included."""
        return [self.view(core) for core in self.core.models]

    def view(self, core: CoreModel) -> Model:
        """The view on a model of the engine."""
        return view_of(core, lambda: Model(self, core, self._parent_of(core)))

    def _parent_of(self, core: CoreModel) -> Model | None:
        return self.view(core.parent) if isinstance(core.parent, SdfModel) else None

    def Models(self) -> list[Model]:
        """The models that are not nested."""
        return [model for model in self.all_models() if model.GetParent() is None]

    GetModels = Models

    def ModelCount(self) -> int:
        """How many models there are, nested ones not counted."""
        return len(self.Models())

    GetModelCount = ModelCount

    def ModelByName(self, name: str) -> Model | None:
        """A model by its name or scoped name; None if there is none."""
        name = name.removeprefix(f"{self.Name()}::")
        found = (c for c in self.core.models if c.GetId() == name)
        core = next(found, None)
        return None if core is None else self.view(core)

    def ModelByIndex(self, index: int) -> Model | None:
        """A model by its number; None if there is none."""
        models = self.Models()
        return models[index] if 0 <= index < len(models) else None

    def GetModel(self, which: str | int) -> Model | None:
        """A model by name or number; None if there is none."""
        return self.ModelByIndex(which) if isinstance(which, int) else self.ModelByName(which)

    def BaseByName(self, name: str) -> Base | None:
        """Anything by its name or scoped name; None if there is none."""
        name = name.removeprefix(f"{self.Name()}::")
        scope = name
        while scope:  # a scoped name is looked for in its model, not in all
            model = self.ModelByName(scope)
            found = next((part for part in model.tree() if part.GetScopedName() == name), None) if model else None
            if found is not None:
                return found
            scope = scope.rpartition("::")[0]
        return find_named((part for top in self.children() for part in top.tree()), name)

    GetByName = BaseByName

    def EntityByName(self, name: str) -> Entity | None:
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
        """How many lights there are."""
        return len(self.Lights())

    def LightByName(self, name: str) -> Light | None:
        """A light by name; None if there is none."""
        return next((light for light in self.Lights() if light.GetName() == name), None)

    def Light(self, which: str | int) -> Light | None:
        """A light by name or number; None if there is none."""
        lights = self.Lights()
        if isinstance(which, int):
            return lights[which] if 0 <= which < len(lights) else None
        return self.LightByName(which)

    def PrintEntityTree(self) -> str:
        """The names of everything, a line each."""
        return self.Print()

    # What a geom or body belongs to ------------------------------------------------------------------------------

    def link_of(self, body: Body) -> Any:
        """The Link of a body; None for one of no model."""
        core = body.model
        if core is None or core.world is not self.core or not core.is_model:
            return None
        return self.view(core).link(body)

    def collision_of(self, geom: Geom) -> Any:
        """The Collision of a geom; None for one of no model."""
        known = geom.__dict__.get("classic_view")
        link = self.link_of(geom.body) if known is None else None
        if link is None:
            return known
        return next((c for c in link.GetCollisions() if c.geom is geom), None) if link is not None else None

    def ray_down(self, start: VectorLike, above: Base | None = None) -> tuple[float, str]:
        """(distance [m], scoped name) of the collision below a point; those of `above` are not seen.

        Raises:
            ParameterError: the point is not finite, or absurdly far away.
        """
        engine = self.core.engine
        frame = np.array((*finite_tuple(start, 3, "point [m]", LARGEST), 1.0, 0.0, 0.0, 0.0))
        rays = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, -1.0, NOWHERE]])
        ranges, rows = np.zeros(1), np.zeros(1, dtype=np.int64)
        owner = getattr(getattr(above, "body", None), "number", 0)
        engine.scan(frame, rays, owner, ranges, rows)
        row = int(rows[0])
        if row < 0:
            return NOWHERE, ""
        collision = self.collision_of(engine.geoms[row])
        return float(ranges[0]), collision.GetScopedName() if collision is not None else ""

    def EntityBelowPoint(self, pt: VectorLike) -> Entity | None:
        """The collision below a point [m]; None if there is none."""
        return self.EntityByName(self.ray_down(pt)[1])

    GetEntityBelowPoint = EntityBelowPoint

    # Changes -----------------------------------------------------------------------------------------------------

    def InsertModelString(self, sdfString: str) -> None:
        """Add the models and lights of an SDF text; in a callback, at the end of this iteration.

        Raises:
            ParameterError: it is no text.
        """
        insert_text(self, sdfString)

    def InsertModelFile(self, sdfFilename: str | os.PathLike[str]) -> None:
        """Add the models and lights of a file, `model://name` included; in a callback, at the end of this iteration.

        Raises:
            ParameterError: it is no file's name.
        """
        insert_file(self, sdfFilename)

    def InsertModelSDF(self, sdf: Element | SdfFile | classic_sdf.SDF) -> None:
        """Add the models and lights of an SDF document; in a callback, at the end of this iteration.

        Raises:
            ParameterError: it is none.
        """
        insert_document(self, sdf)

    def RemoveModel(self, which: Model | str) -> None:
        """Take a model or light out, with all that is in it; in a callback, at the end of this iteration.

        Raises:
            NotFoundError: there is none of this name.
        """
        entity: Base | None = which if isinstance(which, Base) else self.BaseByName(which)
        if entity is None or not isinstance(entity, Model | Light):
            names = [part.GetName() for part in self.children()]
            raise NotFoundError(f"world {self.Name()!r} has no model {which!r}{nearest(str(which), names)}")
        family: list[CoreModel] = [entity.core]
        if isinstance(entity, Model):
            family = [model.core for model in entity.family()]
        self.core.after_step(lambda: self.server.remove(family))

    def Clear(self) -> None:
        """Take everything out."""
        for part in self.children():
            self.RemoveModel(part)  # type: ignore[arg-type]

    def LoadPlugin(self, filename: str, name: str, sdf: Element | None = None) -> None:
        """Load a World plugin now."""
        self.server.load_world_plugin(filename, name, sdf)

    def RemovePlugin(self, name: str) -> None:
        """Let a World plugin go, with all it is connected to."""
        self.server.remove_world_plugin(name)

    def load_model_plugin(self, model: Model, filename: str, name: str, sdf: Element | None) -> bool:
        """Load a Model plugin now; whether it runs."""
        return self.server.load_model_plugin(model, filename, name, sdf)

    def attach(self, parent: Model, model: Model, offset: GzPose) -> None:
        """Carry a model along with another."""
        model.SetEnabled(False)
        self._attached.append((parent, model, offset))

    def detach(self, parent: Model, name: str) -> None:
        """Let such a model go."""
        self._attached = [
            row
            for row in self._attached
            if not (row[0] is parent and name in (row[1].GetName(), row[1].GetScopedName()))
        ]

    # Physics -----------------------------------------------------------------------------------------------------

    def Physics(self) -> PhysicsEngine:
        """The physics engine."""
        return self._physics

    GetPhysicsEngine = Physics

    def PresetMgr(self) -> PresetManager:
        """The world's `<physics>` profiles."""
        if self._presets is None:
            self._presets = PresetManager(self)
        return self._presets

    GetPresetManager = PresetMgr

    def Gravity(self) -> Vector3d:
        """[m/s^2]."""
        return Vector3d(*self.core.engine.gravity)

    def SetGravity(self, gravity: VectorLike) -> None:
        """Set it [m/s^2]; what sleeps wakes."""
        self.core.engine.gravity = tuple(gravity)
        for model in self.Models():
            model.SetEnabled(True)

    def MagneticField(self) -> Vector3d:
        """[T]."""
        return self.server.magnetic_field()

    def SetMagneticField(self, field: VectorLike) -> None:
        """Set it [T].

        Raises:
            ParameterError: it is not three finite numbers.
        """
        self.server.set_magnetic_field(finite_tuple(field, 3, "magnetic field [T]"))

    def SphericalCoords(self) -> SphericalCoordinates:
        """Where on Earth the world lies."""
        return self.server.spherical_coordinates()

    GetSphericalCoordinates = SphericalCoords

    # Sensors, state ----------------------------------------------------------------------------------------------

    def sensor_names(self) -> list[str]:
        """Full names of all sensors."""
        return self.server.sensor_names()

    def SensorsInitialized(self) -> bool:
        """Whether all sensors are ready: once the world runs, always."""
        return True

    def SetState(self, state: WorldState) -> None:
        """Bring all links to the poses and velocities of a state."""
        state.apply(self)

    def Save(self, filename: str) -> None:
        """Write the world as SDF with the present poses.

        Raises:
            WorldFileError: the file cannot be written.
        """
        save_world(self, Path(filename))

    def forget(self, model: Model) -> None:
        """A model leaves."""
        self.controllers = [c for c in self.controllers if c is not model.controller]
        for part in model.tree():
            if isinstance(part, Entity):
                self.animations.stop(part)
        self._attached = [row for row in self._attached if model not in row[:2]]

    def close(self) -> None:
        """The world ends."""
        leave(self)

    # Called by the server ----------------------------------------------------------------------------------------

    def changed(self) -> None:
        """Models have come or gone."""
        self._batteries = None

    def _all_batteries(self) -> list[Battery]:
        if self._batteries is None:
            self._batteries = [b for model in self.all_models() for link in model.GetLinks() for b in link.batteries]
        return self._batteries

    def before_physics(self) -> None:
        """What acts by itself in every iteration: joint controllers, animations, what is carried along."""
        for controller in self.controllers:
            controller.Update()
        for battery in self._all_batteries():
            battery.Update()
        if self.joint_event:
            self.joint_event()
        self.animations.update()
        for parent, model, offset in self._attached:
            model.move(GzCoordPoseAdd(offset, parent.pose()))
