"""PhysicsEngine: the parameters of the engine, by Gazebo's names."""

from __future__ import annotations

import itertools
import logging
from typing import TYPE_CHECKING, Any, Literal, overload

from libgz.base.errors import ParameterError, nearest
from libgz.base.geometry import GzPose, VectorLike
from libgz.classic.math import Vector3d
from libgz.classic.names import takes_names
from libgz.classic.physics.base import view_of
from libgz.classic.physics.contact_manager import ContactManager
from libgz.classic.physics.joint import FIRST_PITCH, Joint, first_axes
from libgz.physics.check import finite, not_negative
from libgz.sdfworld.axis import JointPlan
from libgz.sdfworld.joint import SdfJoint
from libgz.sdfworld.physics import PHYSICS
from libgz.sdfworld.world import SdfWorld

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.ray_shape import MultiRayShape, RayShape
    from libgz.classic.physics.world import Model, World
    from libgz.physics.engine import Engine
    from libgz.physics.lock import WorldLock
    from libgz.sdf.element import Element

__all__ = ["PhysicsEngine"]

log = logging.getLogger("libgz.classic")

_numbers = itertools.count(1)

# Parameters that act, in the order of the messages that list them.
PARAMETERS = ("type", "gravity", "magnetic_field", *PHYSICS)
# Parameters of Gazebo's without effect here: the path of their element in <physics>, and their defaults.
WITHOUT_EFFECT: dict[str, tuple[tuple[str, ...], Any]] = {
    "contact_residual_smoothing": ((), 0.01),
    "contact_sor_scale": ((), 0.25),
    "island_threads": (("ode", "solver"), 0),
    "min_step_size": (("ode", "solver"), 0.0001),
    "precon_iters": (("ode", "solver"), 0),
    "real_time_factor": ((), 1.0),
    "sor_lcp_tolerance": ((), -1.0),
    "thread_position_correction": (("ode", "solver"), False),
    "use_dynamic_moi_rescaling": (("ode", "solver"), False),
    "world_step_solver": (("ode", "solver"), "ODE_DANTZIG"),
}
ALIASES = {
    "inertia_ratio_reduction": "use_dynamic_moi_rescaling",
    "rms_error_tolerance": "sor_lcp_tolerance",
}  # other names of parameters


@takes_names
class PhysicsEngine:
    """The physics engine of a world, ODE: step size, rate and parameters."""

    STATE = ("_without_effect", "_contacts")

    def __init__(self, world: World) -> None:
        self._world = world
        self._contacts = ContactManager(world)
        self._without_effect: dict[str, Any] = {}  # values that were set

    @property
    def engine(self) -> Engine:
        """The engine of the world."""
        return self._world.core.engine

    def GetType(self) -> str:
        """``ode``."""
        return "ode"

    def World(self) -> World:
        """The world."""
        return self._world

    def GetContactManager(self) -> ContactManager:
        """The contact manager."""
        return self._contacts

    # Time --------------------------------------------------------------------------------------------------------

    def GetMaxStepSize(self) -> float:
        """The step size [s]."""
        return self.engine.step_time

    def SetMaxStepSize(self, stepSize: float) -> None:
        """Set the step size [s]; the real-time update rate does not change."""
        self.SetParam("max_step_size", stepSize)

    def GetRealTimeUpdateRate(self) -> float:
        """The number of steps per second of real time [Hz]; 0: as fast as possible."""
        return float(PHYSICS["real_time_update_rate"].get(self._world.core))

    def SetRealTimeUpdateRate(self, rate: float) -> None:
        """Set the number of steps per second of real time [Hz]; 0: as fast as possible."""
        self.SetParam("real_time_update_rate", rate)

    def GetUpdatePeriod(self) -> float:
        """The real time between steps [s]; 0: as fast as possible."""
        rate = self.GetRealTimeUpdateRate()
        return 1.0 / rate if rate > 0.0 else 0.0

    def GetTargetRealTimeFactor(self) -> float:
        """The parameter real_time_factor; it has no effect."""
        return float(self.GetParam("real_time_factor"))

    def SetTargetRealTimeFactor(self, factor: float) -> None:
        """Set the parameter real_time_factor; it has no effect."""
        self.SetParam("real_time_factor", float(factor))

    def GetPhysicsUpdateMutex(self) -> WorldLock:
        """The world's lock: ``with world.Physics().GetPhysicsUpdateMutex():`` holds off steps and other threads."""
        return self._world.core.lock

    # Parameters --------------------------------------------------------------------------------------------------

    def GetGravity(self) -> Vector3d:
        """The gravity [m/s^2]."""
        return self._world.Gravity()

    def SetGravity(self, gravity: VectorLike) -> None:
        """Set the gravity [m/s^2]."""
        self._world.SetGravity(gravity)

    def SetSeed(self, seed: int) -> None:
        """Set the seed of ODE's random numbers."""
        self.engine.seed = seed

    def SetAutoDisableFlag(self, autoDisable: bool) -> None:
        """Enable or disable auto-disable, sleep while at rest, for all models without joints."""
        for model in self._world.Models():
            model.SetAutoDisable(autoDisable)

    def GetAutoDisableFlag(self) -> bool:
        """Whether auto-disable is enabled for a model."""
        return any(model.GetAutoDisable() for model in self._world.Models())

    def InitForThread(self) -> None:
        """Without effect: the engine needs no preparation of threads."""

    def SetParam(self, key: str, value: Any) -> bool:
        """Set a parameter; returns True.

        Raises:
            ParameterError: there is no such parameter, or the value is not allowed.
        """
        match key := ALIASES.get(key, key):
            case "type":
                if value != "ode":
                    raise ParameterError(f"type {value!r} is not supported; only ode is")
            case "gravity":
                self.SetGravity(value)
            case "magnetic_field":
                self._world.SetMagneticField(value)
            case _ if key in PHYSICS:
                parameter = PHYSICS[key]
                parameter.set(self._world.core, _converted(key, parameter.kind, value))
            case _:
                self._set_without_effect(key, value)
        return True

    def GetParam(self, key: str) -> Any:
        """The value of a parameter.

        Raises:
            ParameterError: there is no such parameter.
        """
        match key := ALIASES.get(key, key):
            case "type":
                return "ode"
            case "gravity":
                return self.GetGravity()
            case "magnetic_field":
                return self._world.MagneticField()
            case _ if key in PHYSICS:
                return PHYSICS[key].get(self._world.core)
        return self._value_without_effect(key)

    def _set_without_effect(self, key: str, value: Any) -> None:
        kind = type(WITHOUT_EFFECT[key][1]) if key in WITHOUT_EFFECT else object
        if kind in (int, float):
            value = _converted(key, kind, value)
            finite(value if value == WITHOUT_EFFECT[key][1] else not_negative(value, key), key)
        if value != self._value_without_effect(key):
            log.warning("physics parameter %s is kept, and has no effect", key)
        self._without_effect[key] = value

    def _value_without_effect(self, key: str) -> Any:
        """The value that was set, else that of the file."""
        if key not in WITHOUT_EFFECT:
            known = [*PARAMETERS, *WITHOUT_EFFECT]
            raise ParameterError(f"physics has no parameter {key!r}; it has {', '.join(known)}{nearest(key, known)}")
        if key in self._without_effect:
            return self._without_effect[key]
        path, default = WITHOUT_EFFECT[key]
        holder = self._world.core.extension(SdfWorld).settings.physics
        for name in path:
            holder = holder.child(name)
        return holder.Get(type(default), key, default)[0]

    def GetSDF(self) -> Element:
        """The `<physics>` element."""
        return self._world.core.extension(SdfWorld).settings.physics

    # Parameters by methods of their own --------------------------------------------------------------------------

    def GetMaxContacts(self) -> int:
        """The maximum number of contact points of two collisions, the parameter ``max_contacts``."""
        return int(self.GetParam("max_contacts"))

    def SetMaxContacts(self, maxContacts: int) -> None:
        """Set the maximum number of contact points of two collisions, the parameter ``max_contacts``."""
        self.SetParam("max_contacts", int(maxContacts))

    def GetSORPGSIters(self) -> int:
        """The iterations of the quick solver, the parameter ``iters``."""
        return int(self.GetParam("iters"))

    def SetSORPGSIters(self, iters: int) -> None:
        """Set the iterations of the quick solver, the parameter ``iters``."""
        self.SetParam("iters", int(iters))

    def GetSORPGSPreconIters(self) -> int:
        """The parameter ``precon_iters``; it has no effect."""
        return int(self.GetParam("precon_iters"))

    def SetSORPGSPreconIters(self, iters: int) -> None:
        """Set the parameter ``precon_iters``; it has no effect."""
        self.SetParam("precon_iters", int(iters))

    def GetSORPGSW(self) -> float:
        """The relaxation of the quick solver, the parameter ``sor``."""
        return float(self.GetParam("sor"))

    def SetSORPGSW(self, w: float) -> None:
        """Set the relaxation of the quick solver, the parameter ``sor``."""
        self.SetParam("sor", float(w))

    def GetWorldERP(self) -> float:
        """The share of an error that a step corrects, the parameter ``erp``."""
        return float(self.GetParam("erp"))

    def SetWorldERP(self, erp: float) -> None:
        """Set the share of an error that a step corrects, the parameter ``erp``."""
        self.SetParam("erp", float(erp))

    def GetWorldCFM(self) -> float:
        """The constraint force mixing, the parameter ``cfm``."""
        return float(self.GetParam("cfm"))

    def SetWorldCFM(self, cfm: float) -> None:
        """Set the constraint force mixing, the parameter ``cfm``."""
        self.SetParam("cfm", float(cfm))

    def GetContactMaxCorrectingVel(self) -> float:
        """The velocity at which contacts are corrected at most [m/s]."""
        return float(self.GetParam("contact_max_correcting_vel"))

    def SetContactMaxCorrectingVel(self, vel: float) -> None:
        """Set the velocity at which contacts are corrected at most [m/s]."""
        self.SetParam("contact_max_correcting_vel", float(vel))

    def GetContactSurfaceLayer(self) -> float:
        """The `contact_surface_layer` [m], which has no effect, as in Gazebo; surfaces have a `min_depth`."""
        return float(self.GetParam("contact_surface_layer"))

    def SetContactSurfaceLayer(self, layerDepth: float) -> None:
        """Set the `contact_surface_layer` [m], which has no effect, as in Gazebo."""
        self.SetParam("contact_surface_layer", float(layerDepth))

    # Making things -----------------------------------------------------------------------------------------------

    def CreateJoint(self, type: str, parent: Model | None = None) -> Joint:
        """A new joint of a type, which acts from `Load(parent link, child link, pose)` on.

        Its axes are those of ``Model.CreateJoint`` until SetAxis changes them.
        """
        name = f"joint_{next(_numbers)}"
        plan = JointPlan(name, type, None, None, GzPose(), first_axes(type), pitch=FIRST_PITCH)
        core = SdfJoint(self.engine, plan)
        joint = view_of(core, lambda: Joint(self._world, None, core))
        if parent is not None:
            joint.SetModel(parent)
        return joint

    @overload
    def CreateShape(self, type: Literal["ray"], collision: Collision | None = None) -> RayShape: ...
    @overload
    def CreateShape(self, type: Literal["multiray"], collision: Collision | None = None) -> MultiRayShape: ...
    @overload
    def CreateShape(self, type: str, collision: Collision | None = None) -> RayShape | MultiRayShape: ...
    def CreateShape(self, type: str, collision: Collision | None = None) -> RayShape | MultiRayShape:
        """A new ray, ``ray``, or several, ``multiray``, for AddRay; with a collision they are fixed to its link.

        Raises:
            ParameterError: the type is neither.
        """
        from libgz.classic.physics.ray_shape import MultiRayShape, RayShape  # of sensors

        if type == "multiray":
            return MultiRayShape(
                self._world.core.engine, collision.link.body if collision is not None else None, GzPose()
            )
        if type != "ray":
            raise ParameterError(f"CreateShape makes no {type!r} by itself; it makes ray and multiray")
        return RayShape(self._world, collision.link if collision is not None else None)


def _converted(key: str, kind: type, value: Any) -> Any:
    """The value of a parameter as its type.

    Raises:
        ParameterError: it is no such value.
    """
    try:
        return kind(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{key} is {value!r}; it must be of the type {kind.__name__}") from None
