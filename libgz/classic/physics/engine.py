"""PhysicsEngine: the settings of the engine, by Gazebo's names."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from libgz.classic.math import Vector3d
from libgz.classic.physics.contact import ContactManager
from libgz.classic.physics.ray_shape import RayShape
from libgz.errors import ParameterError, nearest
from libgz.geometry import VectorLike

if TYPE_CHECKING:
    from libgz.classic.physics.collision import Collision
    from libgz.classic.physics.joint import Joint
    from libgz.classic.physics.model import Model
    from libgz.classic.physics.world import World
    from libgz.physics.engine import Engine

__all__ = ["PhysicsEngine"]


class PhysicsEngine:
    """ODE, and how a world steps."""

    def __init__(self, world: World) -> None:
        self._world = world
        self._contacts = ContactManager(world)

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
        """The file's real_time_factor, which nothing depends on."""
        sdf = self._world.SDF()
        return sdf.child("physics").Get(float, "real_time_factor") if sdf is not None else 1.0

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
            "solver_type": plain("solver", str),
            "iters": plain("iterations", int),
            "sor": plain("over_relaxation", float),
            "erp": plain("erp", float),
            "cfm": plain("cfm", float),
            "contact_max_correcting_vel": plain("correcting_velocity", float),
            "contact_surface_layer": plain("surface_layer", float),
            "max_contacts": plain("max_contacts", int),
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
        if key not in keys:
            raise ParameterError(f"physics has no parameter {key!r}; it has {', '.join(keys)}{nearest(key, keys)}")
        return keys[key]

    # Making things -----------------------------------------------------------------------------------------------

    def CreateJoint(self, type: str, parent: Model | None = None) -> Joint:
        """A joint of a kind that `Load(parent link, child link, pose)` and `Init` bring to life."""
        from libgz.classic.physics.make_joint import unborn_joint

        return unborn_joint(self._world, type, parent)

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
