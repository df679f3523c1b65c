"""Settings of an engine: time, gravity, solver, how joints and contacts are treated."""

from __future__ import annotations

import math
import weakref
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from libgz.errors import ClosedError, ParameterError
from libgz.ode.context import Step, StepContext
from libgz.ode.lib import OdeLibrary
from libgz.ode.types import ContactRule
from libgz.physics.check import finite, finite_tuple, not_negative, positive

if TYPE_CHECKING:
    from libgz.geometry import VectorLike

__all__ = ["SOLVERS", "EngineSettings"]

MOST_ITERATIONS = 100_000
SMALLEST_CFM = 1e-10  # ODE's own, for doubles: none at all makes its solvers fail on redundant joints
SOLVERS = ("world", "quick")


class EngineSettings:
    """Base of Engine: what a world's file and users set."""

    _context: StepContext
    _destroy: weakref.finalize[..., Any]
    _ode: OdeLibrary
    _gravity: tuple[float, ...]
    step_form: Step
    surface_edits: int
    # As ODE has them until somebody sets others; read them, and set them by the two functions below.
    iterations = 20
    over_relaxation = 1.3
    erp = 0.2
    cfm = SMALLEST_CFM
    correcting_velocity = math.inf

    def wake(self) -> None:
        """Wake all bodies that may sleep."""
        raise NotImplementedError

    @property
    def world(self) -> int:
        """The handle of the ODE world.

        Raises:
            ClosedError: the world was closed.
        """
        if not self._destroy.alive:
            raise ClosedError("this world was closed")
        return int(self._context.world)

    @property
    def step_time(self) -> float:
        """Length of one step [s]."""
        return float(self._context.step)

    @step_time.setter
    def step_time(self, seconds: float) -> None:
        self._context.step = positive(seconds, "stepTime [s]")

    @property
    def solver(self) -> str:
        """``"world"`` or ``"quick"``."""
        return SOLVERS[self._context.quick]

    @solver.setter
    def solver(self, name: str) -> None:
        if name not in SOLVERS:
            raise ParameterError(f"solver is {name!r}; allowed are {', '.join(SOLVERS)}")
        self._context.quick = SOLVERS.index(name)

    @property
    def seed(self) -> int:
        """The state of ODE's random numbers in this world."""
        return int(self._context.seed)

    @seed.setter
    def seed(self, value: int) -> None:
        self._context.seed = int(value) & 0xFFFFFFFF

    @property
    def gravity(self) -> tuple[float, ...]:
        """[m/s^2], shape (3,)."""
        return self._gravity

    @gravity.setter
    def gravity(self, value: VectorLike) -> None:
        self._gravity = finite_tuple(value, 3, "gravity [m/s^2]")
        self._ode.dWorldSetGravity(self.world, *self._gravity)
        self._context.gravity[:] = self._gravity
        self.wake()

    def set_quick_step(self, iterations: int, over_relaxation: float) -> None:
        """Iterations of the quick solver, and its over-relaxation, 1 to 2.

        Raises:
            ParameterError: there are more than 100 000 iterations, or the over-relaxation is not above zero.
        """
        if iterations > MOST_ITERATIONS:
            raise ParameterError(f"there are {iterations} iterations a step; allowed are {MOST_ITERATIONS} at most")
        self.iterations = max(1, int(iterations))
        self.over_relaxation = positive(over_relaxation, "over-relaxation")
        self._ode.dWorldSetQuickStepNumIterations(self.world, self.iterations)
        self._ode.dWorldSetQuickStepW(self.world, self.over_relaxation)

    def set_constraints(self, erp: float, cfm: float, correcting_velocity: float) -> None:
        """How joints mend their errors: share per step, softness, and the fastest a contact pushes out [m/s]."""
        self.erp = finite(not_negative(erp, "erp"), "erp")
        self.cfm = max(finite(not_negative(cfm, "cfm"), "cfm"), SMALLEST_CFM)
        self.correcting_velocity = not_negative(correcting_velocity, "velocity [m/s]")
        self._ode.dWorldSetERP(self.world, self.erp)
        self._ode.dWorldSetCFM(self.world, self.cfm)
        self._ode.dWorldSetContactMaxCorrectingVel(self.world, self.correcting_velocity)

    @property
    def contact_rule(self) -> ContactRule:
        """How contact points become contact joints: as in the legacy server (default) or in Gazebo classic."""
        return ContactRule(self._context.contact_rule)

    @contact_rule.setter
    def contact_rule(self, rule: ContactRule) -> None:
        self._context.contact_rule = ContactRule(rule)
        self.surface_edits += 1

    @property
    def count_turns(self) -> bool:
        """Whether angles of joints count full turns; without it (default) they stay within -pi and pi [rad]."""
        return bool(self._context.count_turns)

    @count_turns.setter
    def count_turns(self, value: bool) -> None:
        self._context.count_turns = int(value)

    @property
    def check_divergence(self) -> bool:
        """Whether the Python form of the step looks for diverged bodies; off by default.

        It takes as long as a legacy world's whole step. The native form always looks for them.
        """
        return bool(self._context.check_divergence)

    @check_divergence.setter
    def check_divergence(self, value: bool) -> None:
        self._context.check_divergence = int(value)

    @property
    def steps(self) -> int:
        """How many steps were made so far."""
        return int(self._context.steps)

    @property
    def contact_count(self) -> int:
        """Contact points in the last step."""
        return int(self._context.contact_count)

    @property
    def max_contacts(self) -> int:
        """Contact points of a pair of geoms at most, in a world of classic; a geom may want fewer."""
        return int(self._context.max_contacts)

    @max_contacts.setter
    def max_contacts(self, value: int) -> None:
        self._context.max_contacts = max(0, int(value))

    @property
    def cone(self) -> bool:
        """Whether friction acts against the motion, as in a cone, in a world of classic; else along two axes."""
        return bool(self._context.cone)

    @cone.setter
    def cone(self, value: bool) -> None:
        self._context.cone = int(value)

    @property
    def record_contacts(self) -> bool:
        """Whether `contacts` is filled; off until somebody wants it, and then it costs nothing."""
        return bool(self._context.record)

    @record_contacts.setter
    def record_contacts(self, value: bool) -> None:
        self._context.record = int(value)

    @property
    def watch_motion(self) -> bool:
        """Whether bodies know their accelerations and what was put on them in the last step; off at first."""
        return bool(self._context.watch)

    @watch_motion.setter
    def watch_motion(self, value: bool) -> None:
        if value and not self._context.watch:
            self._begin_watch()
        self._context.watch = int(value)

    def _begin_watch(self) -> None:
        """There was no step yet that could have changed anything."""
        raise NotImplementedError

    @property
    def contacts(self) -> NDArray[np.void]:
        """The contact points of the last step, a copy; empty unless `record_contacts` is on.

        Fields: ``geom1``, ``geom2``: rows, which `geoms` maps to geoms (row 0: one without a record); ``position`` [m];
        ``normal``, which points into the first geom; ``depth`` [m]; ``force1``, ``torque1``, ``force2``, ``torque2``:
        what the contact did to the body of either geom [N], and about its centre of mass [N m]; zero for what stands
        still. All global. After `collide` alone, forces are zero.
        """
        return self.step_form.contacts()
