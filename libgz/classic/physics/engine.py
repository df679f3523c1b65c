"""PhysicsEngine: the settings of the engine, by Gazebo's names."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.classic.math import Vector3d
from libgz.classic.physics.base import view_of
from libgz.classic.physics.contact import ContactManager
from libgz.classic.physics.joint import Joint, first_axes
from libgz.classic.physics.ray_shape import RayShape
from libgz.errors import ParameterError, nearest
from libgz.geometry import GzPose, GzVector, VectorLike
from libgz.sdfworld.axis import Axis, JointPlan
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.world import SdfWorld

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World
    from libgz.physics.engine import Engine

__all__ = ["PhysicsEngine"]

log = logging.getLogger("libgz.classic")

_numbers = itertools.count(1)

# Parameters of Gazebo's that nothing depends on here: where a <physics> has them, and their defaults.
KEPT: dict[str, tuple[tuple[str, ...], Any]] = {
    "contact_surface_layer": (("ode", "constraints"), 0.001),
    "island_threads": (("ode", "solver"), 0),
    "min_step_size": (("ode", "solver"), 0.0001),
    "precon_iters": (("ode", "solver"), 0),
    "real_time_factor": ((), 1.0),
    "thread_position_correction": (("ode", "solver"), False),
    "use_dynamic_moi_rescaling": (("ode", "solver"), False),
    "world_step_solver": (("ode", "solver"), "ODE_DANTZIG"),
}


class PhysicsEngine:
    """ODE, and how a world steps."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._contacts = ContactManager(world)
        self._kept: dict[str, Any] = {}

    @property
    def engine(self) -> Engine:
        """The engine itself."""
        return self._world.core.engine

    def GetType(self) -> str:
        """``ode``."""
        return "ode"

    def World(self) -> World:
        """The world."""
        return self._world

    def GetContactManager(self) -> ContactManager:
        """The contacts of the last step."""
        return self._contacts

    # Time --------------------------------------------------------------------------------------------------------

    def GetMaxStepSize(self) -> float:
        """Length of a step [s]."""
        return self.engine.step_time

    def SetMaxStepSize(self, stepSize: float) -> None:
        """Set the length of a step [s]; steps a second stay as many."""
        rate = self.GetRealTimeUpdateRate()
        self.engine.step_time = stepSize
        self.SetRealTimeUpdateRate(rate)

    def GetRealTimeUpdateRate(self) -> float:
        """Steps per second of real time [Hz]; 0: as fast as possible."""
        return self._world.core.simSpeed / self.engine.step_time

    def SetRealTimeUpdateRate(self, rate: float) -> None:
        """Set the steps per second of real time [Hz]; 0: as fast as possible."""
        self._world.core.simSpeed = rate * self.engine.step_time

    def GetUpdatePeriod(self) -> float:
        """Real time between steps [s]; 0: as fast as possible."""
        rate = self.GetRealTimeUpdateRate()
        return 1.0 / rate if rate > 0.0 else 0.0

    def GetTargetRealTimeFactor(self) -> float:
        """The real_time_factor of the file, or what was set since; nothing depends on it."""
        return float(self.GetParam("real_time_factor"))

    # Parameters --------------------------------------------------------------------------------------------------

    def GetGravity(self) -> Vector3d:
        """[m/s^2]."""
        return self._world.Gravity()

    def SetGravity(self, gravity: VectorLike) -> None:
        """Set it [m/s^2]."""
        self._world.SetGravity(gravity)

    def SetSeed(self, seed: int) -> None:
        """Set the seed of ODE's random numbers."""
        self.engine.seed = seed

    def SetAutoDisableFlag(self, autoDisable: bool) -> None:
        """Whether models may fall asleep at rest."""
        for model in self._world.Models():
            model.SetAutoDisable(autoDisable)

    def InitForThread(self) -> None:
        """Nothing to do: the engine readies every thread that it is used in."""

    def _keys(self) -> dict[str, tuple[Callable[[], Any], Callable[[Any], None]]]:
        e = self.engine

        def solver(**changed: float) -> None:
            now = {"iterations": e.iterations, "over_relaxation": e.over_relaxation}
            e.set_quick_step(**{**now, **changed})  # type: ignore[arg-type]

        def constraints(**changed: float) -> None:
            now = {"erp": e.erp, "cfm": e.cfm, "correcting_velocity": e.correcting_velocity}
            e.set_constraints(**{**now, **changed})

        def plain(name: str, kind: type) -> tuple[Callable[[], Any], Callable[[Any], None]]:
            return lambda: getattr(e, name), lambda value: setattr(e, name, kind(value))

        return {
            "type": (lambda: "ode", lambda value: _only(value, "type", "ode")),
            "max_step_size": (self.GetMaxStepSize, lambda value: self.SetMaxStepSize(float(value))),
            "real_time_update_rate": (
                self.GetRealTimeUpdateRate,
                lambda value: self.SetRealTimeUpdateRate(float(value)),
            ),
            "gravity": (self.GetGravity, self.SetGravity),
            "magnetic_field": (self._world.MagneticField, self._world.SetMagneticField),
            "solver_type": plain("solver", str),
            "iters": (lambda: e.iterations, lambda value: solver(iterations=int(value))),
            "sor": (lambda: e.over_relaxation, lambda value: solver(over_relaxation=float(value))),
            "erp": (lambda: e.erp, lambda value: constraints(erp=float(value))),
            "cfm": (lambda: e.cfm, lambda value: constraints(cfm=float(value))),
            "contact_max_correcting_vel": (
                lambda: e.correcting_velocity,
                lambda value: constraints(correcting_velocity=float(value)),
            ),
            "max_contacts": plain("max_contacts", int),
            "friction_model": (
                lambda: "cone_model" if e.cone else "pyramid_model",
                lambda value: setattr(e, "cone", value == "cone_model"),
            ),
        }

    def SetParam(self, key: str, value: Any) -> bool:
        """Set a parameter; true.

        Raises:
            ParameterError: there is no such parameter, or the value is not allowed.
        """
        self._row(key)[1](value)
        return True

    def GetParam(self, key: str) -> Any:
        """A parameter.

        Raises:
            ParameterError: there is no such parameter.
        """
        return self._row(key)[0]()

    def _row(self, key: str) -> tuple[Callable[[], Any], Callable[[Any], None]]:
        keys = self._keys()
        if key in KEPT:
            return lambda: self._kept_value(key), lambda value: self._keep(key, value)
        if key not in keys:
            known = [*keys, *KEPT]
            raise ParameterError(f"physics has no parameter {key!r}; it has {', '.join(known)}{nearest(key, known)}")
        return keys[key]

    def _keep(self, key: str, value: Any) -> None:
        if value != self._kept_value(key):
            log.warning("physics parameter %s is kept, and has no effect", key)
        self._kept[key] = value

    def _kept_value(self, key: str) -> Any:
        """What was set, else what the file says."""
        if key in self._kept:
            return self._kept[key]
        path, default = KEPT[key]
        holder = self._world.core.extension(SdfWorld).settings.physics
        for name in path:
            holder = holder.child(name)
        return holder.Get(type(default), key, default)[0]

    # Making things -----------------------------------------------------------------------------------------------

    def CreateJoint(self, type: str, parent: Model | None = None) -> Joint:
        """A joint of a kind that `Load(parent link, child link, pose)` and `Init` bring to life.

        Its axes are z and, for a second one, x, until SetAxis gives it others.
        """
        name = f"joint_{next(_numbers)}"
        axes = [Axis(GzVector(*axis)) for axis in first_axes(type)]
        plan = JointPlan(name, type, None, None, GzPose(), axes)
        core = SdfJoint(self.engine, plan)
        joint = view_of(core, lambda: Joint(self._world, None, core))
        if parent is not None:
            joint.SetModel(parent)
        return joint

    def CreateShape(self, type: str, collision: Collision | None = None) -> RayShape:
        """A ray to ask what lies on it; with a collision, in its link's frame.

        Raises:
            ParameterError: the type is not ``ray``; other shapes come with their collisions.
        """
        if type != "ray":
            raise ParameterError(f"CreateShape makes no {type!r} by itself; it makes ray")
        return RayShape(self._world, collision.link if collision is not None else None)


def _only(value: Any, what: str, allowed: str) -> None:
    if value != allowed:
        raise ParameterError(f"{what} {value!r} is not here; only {allowed} is")
