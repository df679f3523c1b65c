"""The ODE world: its settings and its step.

Bodies, geoms, joints and spaces register with their engine and live in its tables (`libgz.ode.tables`), which one
native call fills after each step; bodies, joints and sensors read the tables, never ODE one value at a time.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
import math
import weakref
from collections.abc import Callable, Iterator, Sequence
from itertools import islice, takewhile
from threading import get_ident
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import ClosedError, GazeboError, ParameterError
from libgz.base.geometry import GzPose, GzQuatern, GzVector, VectorLike
from libgz.base.law import law
from libgz.base.quota import Quota
from libgz.ode.context import SOLVERS, HeightField, HeldEffort, RayScan, StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.memory import prepare
from libgz.ode.nearby import geoms_near
from libgz.ode.step import Step
from libgz.ode.tables import Tables
from libgz.ode.types import ContactRule
from libgz.physics.check import FAR, LARGEST, finite, finite_tuple, not_negative, positive
from libgz.physics.lock import WorldLock, exclusive
from libgz.physics.space import ALL_COLLIDE, LASER_COLLIDE, Space
from libgz.physics.state import EngineState

__all__ = ["SOLVERS", "Engine", "HasEngine"]

log = logging.getLogger("libgz.physics")

MAX_ITERATIONS = 100_000
MOST_RAYS, MOST_TRIANGLES = 20_000_000, 70_000_000  # of all lasers, and of all meshes and terrains, of a world
MOST_COMPARED = 5_000  # geoms, when a crowd is searched for
SMALLEST_CFM = 1e-10  # ODE's default with doubles; with none at all its solvers fail on redundant joints
CELLS, WIDE_CELLS = (-3, 10), (2, 10)  # of the hash space, as powers of two [m]: ODE's default, and for far bodies
DEFAULT_LAYER = 0.001  # [m] of SDF


class HasEngine(Protocol):
    """What bodies and joints are built in: an `Engine`, or a World that has one."""

    @property
    def engine(self) -> Engine:
        """The ODE world."""


class RayBundle(Protocol):
    """A sensor's rays."""

    @property
    def body(self) -> Any:
        """The body that they are fixed to, which removes them from `Engine.ray_bundles` when it is closed."""

    def segments(self) -> NDArray[np.float64]:
        """Global ends of all rays as far as they reached [m], shape (n, 2, 3)."""


class Coupling(Protocol):
    """What couples motions of joints."""

    @property
    def broken(self) -> bool:
        """Whether a body or joint of it was closed."""


class Sleeper(Protocol):
    """A body that may sleep."""

    @property
    def id(self) -> int:
        """The ODE handle."""


class Engine:
    """One ODE world.

    Attributes:
        lock: held by a step, and by all that changes the world.
        tables: the states of bodies and joints, and the contact properties of geoms.
        bodies, joints, geoms: the objects of `physics.body`, `physics.joint` and `physics.geom` by their rows. These
            modules stand above this one, so their types are not named here.
        spaces: open spaces, in order of construction.
        dummies: open bodies without a row, likewise.
        attached: joints with bodies, in the order in which they were attached: ODE solves in it.
        couplings: screws and gears, in order of construction.
        auto_disabled: bodies that may sleep.
        quirks: names of quirks of the legacy server that are in force.
        rays, triangles: how many there are, and may be.
        ray_bundles: rays of sensors whose bodies are open, for a renderer to show.
        moved_dummies: bodies without an ODE body whose pose was set; who publishes their poses empties it.
        collisions: how often `collide` was called.
        iterations, over_relaxation: of the quick solver; see `set_quick_step`.
        erp, cfm, correcting_velocity: see `set_constraints`.
        abandoned: whether a step was ever abandoned because ODE could not solve it.
        facade: the object by which the API of a layer above presents this engine; set by that layer.

    Args:
        gravity: [m/s^2], shape (3,).
        step_time: length of a step [s].
        solver: ``"world"``, ODE's exact solver, ``"quick"``, its iterative one, or ``"tree"``, which is exact, too, and
            eliminates joints along their tree: for robots with many joints.
        seed: start of ODE's random numbers, which only the quick solver uses.

    Raises:
        LibraryError: ODE is absent or unfit.
        ParameterError: an argument is out of range.
    """

    def __init__(
        self, *, gravity: VectorLike = (0.0, 0.0, -9.8), step_time: float = 0.02, solver: str = "world", seed: int = 0
    ) -> None:
        lib = ode()
        prepare()
        self._ode: OdeLibrary = lib
        self.lock = WorldLock()
        world, top, contacts = lib.dWorldCreate(), lib.dHashSpaceCreate(None), lib.dJointGroupCreate(0)
        self.top = Space(self, top)
        probe, ray = lib.dCreateBox(None, 1.0, 1.0, 1.0), lib.dCreateRay(None, 1.0)
        for geom in (probe, ray):
            lib.dGeomSetCategoryBits(geom, LASER_COLLIDE)
            lib.dGeomSetCollideBits(geom, ALL_COLLIDE & ~LASER_COLLIDE)
        lib.dGeomRaySetClosestHit(ray, 1)
        stand_in = lib.dCreateBox(None, 1.0, 1.0, 1.0)
        self._context = StepContext(world=world, space=top, contacts=contacts, ray=ray, probe=probe, stand_in=stand_in)
        self._context.max_contacts = 20
        self._context.max_distance = 2.0 * FAR
        self._context.no_cylinder_pairs = True
        self.tables = Tables(self._context, lib)
        self.native = Step(self._context)
        self._step = self.native.step
        self.lock.interrupt = self.native.interrupter(self.lock.wanted)
        self._thread = 0  # that stepped last
        self._destroy = weakref.finalize(
            self, _destroy_world, lib, world, top, contacts, (probe, ray, stand_in), self.native.release
        )
        # Not when a process ends, whose threads may still step, or have when it was forked: that frees all.
        self._destroy.atexit = False
        self.bodies: dict[int, Any] = self.tables.bodies.objects
        self.joints: dict[int, Any] = self.tables.joints.objects
        self.geoms: dict[int, Any] = self.tables.geoms.objects
        self.spaces: dict[Space, None] = {}
        self.dummies: dict[Any, None] = {}
        self.attached: dict[Any, None] = {}
        self.couplings: list[Coupling] = []
        self._state = EngineState(self, self._context)
        self._held: ctypes.Array[HeldEffort] | tuple[()] = ()
        self._fields: dict[int, tuple[NDArray[np.float64], tuple[float, float]]] = {}
        self.auto_disabled: set[Sleeper] = set()
        self.quirks: frozenset[str] = frozenset()
        self.ray_bundles: weakref.WeakSet[RayBundle] = weakref.WeakSet()
        self.rays = Quota("rays of lasers and sonars", MOST_RAYS)
        self.triangles = Quota("triangles of meshes and terrains", MOST_TRIANGLES)
        self._made: list[weakref.ref[Any]] | None = None  # where joints and rays that are made are noted
        self.moved_dummies: set[Any] = set()
        self.collisions = 0
        self.facade: Any = None
        self.abandoned = False
        self._failed_pairs: set[tuple[int, ...]] = set()  # rows of geoms that were reported
        self.iterations = 20
        self.over_relaxation = 1.3
        self.erp = 0.2
        self.cfm = SMALLEST_CFM
        self.correcting_velocity = math.inf
        self._surface_layer = DEFAULT_LAYER
        self.step_time = step_time
        self.solver = solver
        not_negative(seed, "seed")
        self.seed = seed
        self.gravity = gravity

    @property
    def engine(self) -> Engine:
        """The engine itself, so that it is a `HasEngine`."""
        return self

    @property
    def world(self) -> int:
        """The handle of the ODE world.

        Raises:
            ClosedError: the world was closed.
        """
        if not self._destroy.alive:
            raise ClosedError("this world was closed")
        return int(self._context.world)

    # Settings ----------------------------------------------------------------------------------------------------

    @property
    def step_time(self) -> float:
        """Length of one step [s]."""
        return float(self._context.step)

    @step_time.setter
    @exclusive
    def step_time(self, seconds: float) -> None:
        self._context.step = self.tables.record.step = positive(seconds, "stepTime [s]")

    @property
    @law
    def gravity(self) -> tuple[float, ...]:
        """[m/s^2], shape (3,)."""
        return tuple(self._context.gravity)

    @gravity.setter
    @exclusive
    def gravity(self, value: VectorLike) -> None:
        gravity = finite_tuple(value, 3, "gravity [m/s^2]", LARGEST)
        self._ode.dWorldSetGravity(self.world, *gravity)
        self._context.gravity[:] = gravity
        self.wake()

    @property
    def solver(self) -> str:
        """``"world"``, ``"quick"`` or ``"tree"``."""
        return SOLVERS[self._context.solver]

    @solver.setter
    @exclusive
    def solver(self, name: str) -> None:
        if name not in SOLVERS:
            raise ParameterError(f"solver is {name!r}; allowed are {', '.join(SOLVERS)}")
        self._context.solver = SOLVERS.index(name)

    @property
    def seed(self) -> int:
        """The state of ODE's random numbers in this world."""
        return int(self._context.seed)

    @seed.setter
    @exclusive
    def seed(self, value: int) -> None:
        self._context.seed = int(value) & 0xFFFFFFFF

    @exclusive
    def set_quick_step(self, iterations: int, over_relaxation: float) -> None:
        """Set iterations of the quick solver, and its over-relaxation, 1 to 2.

        Raises:
            ParameterError: there are more than 100 000 iterations, or the over-relaxation is not above zero.
        """
        if iterations > MAX_ITERATIONS:
            raise ParameterError(f"there are {iterations} iterations a step; allowed are {MAX_ITERATIONS} at most")
        self.iterations = max(1, int(iterations))
        self.over_relaxation = positive(over_relaxation, "over-relaxation")
        self._ode.dWorldSetQuickStepNumIterations(self.world, self.iterations)
        self._ode.dWorldSetQuickStepW(self.world, self.over_relaxation)

    @exclusive
    def set_constraints(self, erp: float, cfm: float, correcting_velocity: float) -> None:
        """Set how errors of joints are corrected: share per step, softness, and the limit for contacts [m/s].

        Raises:
            ParameterError: a number is negative, or the share or softness is not finite.
        """
        self.erp = finite(not_negative(erp, "erp"), "erp")
        self.cfm = max(finite(not_negative(cfm, "cfm"), "cfm"), SMALLEST_CFM)
        self.correcting_velocity = not_negative(correcting_velocity, "velocity [m/s]")
        self._ode.dWorldSetERP(self.world, self.erp)
        self._ode.dWorldSetCFM(self.world, self.cfm)
        self._ode.dWorldSetContactMaxCorrectingVel(self.world, self.correcting_velocity)

    @property
    def surface_layer(self) -> float:
        """The world's `contact_surface_layer` [m], kept without effect, as in Gazebo: surfaces have a `min_depth`."""
        return self._surface_layer

    @surface_layer.setter
    @exclusive
    def surface_layer(self, depth: float) -> None:
        self._surface_layer = finite(not_negative(depth, "contact_surface_layer [m]"), "contact_surface_layer [m]")

    @property
    def count_turns(self) -> bool:
        """Whether angles of joints count full turns; without it (default) they stay within -pi and pi [rad]."""
        return bool(self._context.count_turns)

    @count_turns.setter
    @exclusive
    def count_turns(self, value: bool) -> None:
        self._context.count_turns = int(value)

    @exclusive
    def extend_range(self) -> None:
        """Use cells of 4 m instead of 1/8 m in ODE's hash space.

        Small cells beyond 2^28 m overflow ODE's count, which ends the process. The order in which contacts are found
        depends on the cells, so only worlds that need it have large ones.
        """
        self.set_range(2.0 * LARGEST)

    @exclusive
    def set_range(self, distance: float) -> None:
        """Set how far from the origin a body may be [m]; beyond 2e8 m the cells of ODE's hash space are large."""
        self._ode.dHashSpaceSetLevels(self.top.id, *(WIDE_CELLS if distance > 2.0 * FAR else CELLS))
        self._context.max_distance = distance

    def collide_alone(self) -> None:
        """Let no other world collide beside this one: ODE's colliders of a shape use memory that worlds share."""
        self._context.alone = 1

    @exclusive
    def show_field_to_rays(self, geom: int, heights: NDArray[np.float64], size: tuple[float, float]) -> None:
        """Let rays read a height field themselves.

        Args:
            geom: its handle.
            heights: [m] contiguous, in rows along its y; they are kept.
            size: along x and y [m].
        """
        self._fields[geom] = heights, size
        self._show_fields()

    @exclusive
    def hide_field_from_rays(self, geom: int) -> None:
        """Let rays read a height field, which goes, no longer."""
        if self._fields.pop(geom, None) is not None:
            self._show_fields()

    def _show_fields(self) -> None:
        shown = [
            HeightField(geom, heights.ctypes.data, *heights.shape, *size)
            for geom, (heights, size) in self._fields.items()
        ]
        self._shown = (HeightField * len(shown))(*shown)
        self._context.fields, self._context.field_count = ctypes.addressof(self._shown), len(shown)

    # Contacts ----------------------------------------------------------------------------------------------------

    @property
    def contact_rule(self) -> ContactRule:
        """How contact points become contact joints: as in the legacy server (default) or in Gazebo classic.

        Under the legacy rule two boxes stand in for a cylinder against cylinders and capsules, with any ODE; under the
        classic rule the contacts are ODE's own, if it finds any.
        """
        return ContactRule(self._context.contact_rule)

    @contact_rule.setter
    @exclusive
    def contact_rule(self, rule: ContactRule) -> None:
        self._context.contact_rule = ContactRule(rule)
        self._context.no_cylinder_pairs = rule == ContactRule.LEGACY or not self._ode.collides_cylinders
        self.tables.geoms.edits += 1

    @property
    def max_contacts(self) -> int:
        """Limit of contact points of a pair of geoms, under the classic rule (0: none); a geom may have a lower one."""
        return int(self._context.max_contacts)

    @max_contacts.setter
    @exclusive
    def max_contacts(self, value: int) -> None:
        self._context.max_contacts = max(0, int(value))

    @property
    def cone(self) -> bool:
        """Whether friction acts against the motion, as in a cone, under the classic rule; else along two axes."""
        return bool(self._context.cone)

    @cone.setter
    @exclusive
    def cone(self, value: bool) -> None:
        self._context.cone = int(value)

    @property
    def exact_rest(self) -> bool:
        """Whether bodies rest without shaking under the classic rule; off by default, on in SDF worlds.

        Resting contacts then keep a depth of 3e-6 m instead of 0, so that none is lost from one step to the next; and
        where the solver is ``"quick"``, islands (bodies that joints and contacts connect) of few constraints, all of
        whose bodies are slower than 0.1 m/s and rad/s, are solved exactly.
        """
        return bool(self._context.exact_rest)

    @exact_rest.setter
    @exclusive
    def exact_rest(self, value: bool) -> None:
        self._context.exact_rest = int(value)

    @property
    def explicit_gyroscopic(self) -> bool:
        """Whether gyroscopic torque is -w x I w of the begin of a step, as in Gazebo classic; off by default.

        ODE finds that torque implicitly: C. Lacoursiere, Stabilizing gyroscopic forces in rigid multibody simulations,
        2006. The explicit one adds energy to bodies with unequal moments of inertia, the more the faster they turn.
        """
        return bool(self._context.explicit_gyroscopic)

    @explicit_gyroscopic.setter
    @exclusive
    def explicit_gyroscopic(self, value: bool) -> None:
        self._context.explicit_gyroscopic = int(value)
        for body in self.bodies.values():
            self._ode.dBodySetGyroscopicMode(body.id, int(not value))

    @property
    def contact_count(self) -> int:
        """Contact points in the last step."""
        return int(self._context.contact_count)

    def hold(self, efforts: ctypes.Array[HeldEffort] | None) -> None:
        """Apply efforts in each step from now on, in this order, and no others; None for none.

        See `Joint.write_held`. They may be written again between two steps.
        """
        if efforts is not None and efforts is not self._held:
            self._take_held(efforts)
        self._context.held_count = 0 if efforts is None else len(efforts)

    @exclusive  # a step that is under way reads the former ones
    def _take_held(self, efforts: ctypes.Array[HeldEffort]) -> None:
        self._context.held_count = 0
        self._held, self._context.held = efforts, ctypes.addressof(efforts)

    def drop_held(self, joint: int) -> None:
        """Apply no more efforts on a joint, by its handle: it is being destroyed."""
        for effort in self._held:
            if effort.joint == joint:
                effort.joint = None

    @property
    def record_contacts(self) -> bool:
        """Whether `contacts` is filled; off by default, and then it costs nothing."""
        return bool(self._context.record_contacts)

    @record_contacts.setter
    @exclusive
    def record_contacts(self, value: bool) -> None:
        self._context.record_contacts = int(value)

    @property
    def contacts(self) -> NDArray[np.void]:
        """The contact points of the last step, a copy; empty unless `record_contacts` is on.

        Fields: ``geom1``, ``geom2``: rows, which `geoms` maps to geoms (row 0: one without an object); ``position``
        [m]; ``normal``, which points into the first geom; ``depth`` [m]; ``force1``, ``torque1``, ``force2``,
        ``torque2``: force on the body of either geom [N], and torque about its centre of mass [N m]; zero for what does
        not move. All global. Bodies that are asleep carry what they carried before. After `collide`, the forces of
        others are zero.
        """
        return self.native.contacts()

    # States ------------------------------------------------------------------------------------------------------

    @property
    def states(self) -> NDArray[np.float64]:
        """States of all bodies, shape (rows, 16), read-only, valid until the next step.

        Columns: position [m] and quaternion (u, x, y, z) of the body frame, position of the centre of mass [m],
        linear velocity of that [m/s], angular velocity [rad/s]; all global.
        """
        if self.tables.touched:
            with self.lock:  # reading releases the interpreter lock
                self.native.read()
        bodies = self.tables.bodies
        view = bodies.state[: bodies.used].view()
        view.flags.writeable = False
        return view

    @property
    def lowest(self) -> float:
        """Height of the lowest body [m], closed ones included; 0 if all are above that."""
        bodies = self.tables.bodies
        return float(bodies.state[: bodies.used, 2].min(initial=0.0))

    @property
    def record_motion(self) -> bool:
        """Whether accelerations of bodies, and the efforts applied in the last step, are available; off by default."""
        return bool(self._context.record_motion)

    @record_motion.setter
    @exclusive
    def record_motion(self, value: bool) -> None:
        if value and not self._context.record_motion:
            self.forget_motion()
        self._context.record_motion = int(value)

    @exclusive
    def forget_motion(self) -> None:
        """Set recorded accelerations and efforts to zero, as before the first step."""
        self.tables.bodies.motion[:] = 0.0

    @exclusive
    def wake(self) -> None:
        """Wake all sleeping bodies: what they rest on was moved or removed, or gravity changed."""
        if self.steps and self.auto_disabled:  # nothing sleeps before
            enable = self._ode.dBodyEnable
            for body in self.auto_disabled:
                enable(body.id)
            self.tables.disturb()

    @exclusive
    def turn_bodies(
        self, bodies: Sequence[Any], point: GzVector, rotation: GzQuatern, slide: GzVector, still: bool
    ) -> int:
        """Turn bodies about a global point [m] by a rotation, and slide them [m], at rest then if wanted.

        Returns:
            How many were moved, from the first one on. `Body.SetPose` is for the next one: it is a dummy, or closed, or
            its pose is not one that can be set as it is.
        """
        rows = self._movable(bodies)
        return self.native.turn_bodies(self.tables.record, rows, point, rotation, slide, still) if rows else 0

    @exclusive
    def carry_bodies(self, bodies: Sequence[Any], before: GzPose, after: GzPose) -> int:
        """Move bodies, at rest then, with a frame from one global pose of it to another [m]; as `turn_bodies`."""
        rows = self._movable(bodies)
        return self.native.carry_bodies(self.tables.record, rows, before, after, True) if rows else 0

    def _movable(self, bodies: Sequence[Any]) -> list[int]:
        """The rows of the first bodies, up to one that native code does not move."""
        return [body.row for body in takewhile(lambda body: body.row >= 0 and not body.closed, bodies)]

    @exclusive
    def sort_geoms(self) -> None:
        """Bring moving geoms into the order of their bodies: contacts are found in it, and ODE keeps that of movement.

        A run that begins with it is the same to the bit, whatever was before.
        """
        self._ode.dSpaceClean(self.top.id)
        for body in self.bodies.values():
            self._ode.dBodySetPosition(body.id, *body.GetCoMPose().pos)

    def add_coupling(self, coupling: Coupling) -> None:
        """Register a screw or gear; broken ones are forgotten."""
        self.couplings = [*(known for known in self.couplings if not known.broken), coupling]

    @exclusive
    def get_state(self) -> dict[str, Any]:
        """All that decides what the next steps do, as plain data; equal states are equal.

        Between steps only. Bodies, geoms, joints and spaces are numbered in the order of their construction, so a state
        also fits an engine of another process in which the same world was built.

        Raises:
            LibraryError: the loaded ODE keeps its state in a way that is not known.
            ClosedError: the world was closed.
        """
        _ = self.world  # raises if it is closed
        return self._state.get()

    def read_state(self) -> dict[str, Any]:
        """`get_state`, for a caller that holds the lock."""
        if not self._destroy.alive:
            _ = self.world  # raises
        return self._state.get()

    @exclusive
    def set_state(self, state: dict[str, Any]) -> None:
        """Set a state of `get_state`: what follows is the same to the bit as what followed then.

        Joints, geoms, bodies and spaces that are not in it are closed.

        Raises:
            StateError: bodies, geoms, joints or spaces of the state are missing, and nothing was changed; or it was
                made with another build of ODE.
            LibraryError, ClosedError: as `get_state`.
        """
        _ = self.world
        self._state.set(state)

    # Step and scan -----------------------------------------------------------------------------------------------

    @property
    def steps(self) -> int:
        """How many steps were made so far."""
        return int(self._context.steps)

    def step(self) -> None:
        """Collide, step, and copy the states out.

        Raises:
            GazeboError: ODE ran out of memory.
            ClosedError: the world was closed.
        """
        with self.lock:
            self.advance()

    def advance(self) -> None:
        """`step`, for a caller that holds the lock."""
        self.enter()
        self._finish(self._step())

    def enter(self) -> None:
        """Prepare the calling thread for steps and scans of the native code."""
        if get_ident() != self._thread:
            self._enter_thread()

    def finish(self) -> None:
        """Recover from what went wrong in a step of native updates.

        Raises:
            GazeboError: ODE ran out of memory.
        """
        self._finish(int(self.tables.record.done))

    def _enter_thread(self) -> None:
        self._ode.ensure_thread()
        self._thread = get_ident()

    @exclusive
    def collide(self) -> None:
        """The first half of a step, for work between contacts and motion; `solve` follows."""
        self._enter_thread()
        self.collisions += 1
        self.native.collide()

    @exclusive
    def solve(self) -> None:
        """The second half of a step."""
        self._finish(self.native.solve())

    @exclusive
    def drop_contacts(self) -> None:
        """End a step after `collide` without a second half: nothing moves, and what was recorded stays."""
        ode().dJointGroupEmpty(self._context.contacts)

    def _finish(self, done: int) -> None:
        """Note which rows are fresh now, and recover from what went wrong."""
        if self.tables.touched:
            self.tables.step_done()
        if done == 1:
            return
        if not done:
            raise GazeboError(self._out_of_memory())
        self._recover(self._context)

    def _out_of_memory(self) -> str:
        """What ODE could not solve: bodies in many contacts with each other, most of them where geoms crowd."""
        geoms = [geom for geom in self.geoms.values() if not geom.body.dummy][:MOST_COMPARED]
        boxes = np.array([geom.bounds() for geom in geoms]).reshape(-1, 2, 3)
        low, high = boxes[:, 0], boxes[:, 1]
        crowds = [int(((low <= high[i]) & (high >= low[i])).all(axis=1).sum()) - 1 for i in range(len(geoms))]
        most = max(crowds, default=0)
        if not most:
            return "ODE ran out of memory in a step: the world is too large"
        geom = geoms[crowds.index(most)]
        where = geom.body.model._entity_place() if hasattr(geom.body.model, "_entity_place") else ""
        return (
            f"{where}ODE ran out of memory in a step: too many contacts at once; {geom.label} is where {most} other "
            "shapes are, too"
        )

    def _recover(self, context: StepContext) -> None:
        """After a step in which bodies diverged or ODE failed: report it, and bring bodies to finite states."""
        if context.reset_row:
            self.bodies[context.reset_row - 1].report_divergence()
        if context.abandoned and not self.abandoned:
            self.abandoned = True
            log.error(
                "step %d was abandoned and nothing moved in it: ODE cannot solve it; joints and contacts contradict "
                "each other, or numbers are too large",
                self.steps,
            )
        if context.diverged:
            self.extend_range()
        if context.diverged or context.abandoned:
            for body in self.bodies.values():
                body.recover(drop_efforts=bool(context.abandoned))
        if context.collision_failed:
            context.collision_failed = 0
            self._report_failed_pair(tuple(context.failed_rows))
            self.sort_geoms()  # the failed pair may have left a wrong bounding box of a geom in ODE

    def overlap(self, geom1: int, geom2: int) -> float:
        """The depth of the deepest contact point of two geoms, by their handles [m]; -1 if they do not touch."""
        self._ode.ensure_thread()
        return self.native.overlap(geom1, geom2)

    @exclusive
    def geoms_near(self, low: Sequence[float], high: Sequence[float]) -> list[Any]:
        """The geoms whose bounding boxes meet the box between two corners [m], global; in no particular order.

        Corners may be infinite; none is met by a box whose lower corner is beyond the upper one, or that has a NaN.
        """
        lib, probe = self._ode, self._context.probe or 0
        if not all(a <= b for a, b in zip(low, high, strict=True)):
            return []
        # ODE takes no infinity.
        box = [[max(-LARGEST, min(corner, LARGEST)) for corner in side] for side in zip(low, high, strict=True)]
        lib.dGeomBoxSetLengths(probe, *(b - a for a, b in box))
        lib.dGeomSetPosition(probe, *(0.5 * (a + b) for a, b in box))
        return [self.geoms[lib.dGeomGetData(geom) or 0] for geom in geoms_near(lib, probe, self.top.id)]

    def _report_failed_pair(self, rows: tuple[int, ...]) -> None:
        """Report a pair of geoms whose collision detection failed, the first time; row -1 is a ray."""
        if rows in self._failed_pairs:
            return
        self._failed_pairs.add(rows)
        log.error(
            "collision detection between %s and %s failed; contacts skipped: is a size extreme, or a mesh broken?",
            *(self.geoms[row].label if row in self.geoms else "a ray" for row in rows),
        )

    def scan(
        self,
        frame: NDArray[np.float64],
        rays: NDArray[np.float64],
        owner: int,
        ranges: NDArray[np.float64],
        rows: NDArray[np.int64],
    ) -> None:
        """Cast rays; the arguments are those of a `RayScan`. `geoms` maps rows to geoms."""
        self.scanner(RayScan(frame, rays, owner, ranges, rows))()

    @contextlib.contextmanager
    def making(self, parts: list[weakref.ref[Any]]) -> Iterator[None]:
        """Note the joints and ray bundles that are made meanwhile in `parts`, and only there."""
        outer, self._made = self._made, parts
        try:
            yield
        finally:
            self._made = outer

    def note_made(self, part: Any) -> None:
        """Note a joint or ray bundle for whoever wants to know what is made."""
        if self._made is not None:
            self._made.append(weakref.ref(part))

    def scanner(self, scan: RayScan) -> Callable[[], None]:
        """A prepared scan that can be run again and again, at less cost than as many calls of `scan`."""
        ensure_thread, cast, lock = self._ode.ensure_thread, self.native.scanner(scan), self.lock

        def make() -> None:
            if not lock.try_acquire():
                lock.wait()
            try:
                ensure_thread()
                cast()
            finally:
                lock.release()

        return make

    @contextlib.contextmanager
    def whole(self) -> Iterator[None]:
        """For a `with` block that builds something: if it fails, the bodies and spaces that it made are closed."""
        made: tuple[dict[Any, Any], ...] = (self.bodies, self.dummies, self.spaces)  # in order of construction
        counts = [len(things) for things in made]
        try:
            yield
        except BaseException:
            for things, count in zip(made, counts, strict=True):
                for thing in [*islice(things.values() if things is self.bodies else things, count, None)]:
                    thing.close()
            raise

    @exclusive
    def close(self) -> None:
        """Destroy the world and everything in it; later use of its parts raises ClosedError."""
        if not self._destroy.alive:
            return
        self.auto_disabled.clear()  # or each part that closes would wake them all
        for part in [*self.joints.values(), *self.bodies.values(), *self.geoms.values(), *self.spaces]:
            part.close()
        self._destroy()
        self._step = self._closed_step

    def _closed_step(self) -> int:
        raise ClosedError("this world was closed")


def _destroy_world(
    lib: OdeLibrary, world: int, top: int, contacts: int, geoms: tuple[int, ...], release: Callable[[], object]
) -> None:
    """Free everything of one world, with what is still in the spaces."""
    lib.dJointGroupDestroy(contacts)
    for geom in geoms:
        lib.dGeomDestroy(geom)
    lib.dSpaceDestroy(top)
    lib.dWorldDestroy(world)
    release()
