"""The ODE world: its spaces, its tables of states, and its step.

All poses, velocities, joint angles and rates live in contiguous tables which one native call fills after each step;
bodies, joints and sensors read the tables, never ODE one value at a time.
"""

from __future__ import annotations

import weakref
from collections.abc import Callable
from threading import get_ident
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from libgz.errors import ClosedError, GazeboError
from libgz.ode.context import RayScan, Step, StepContext, read_body, read_joint
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.step import choose_step
from libgz.ode.types import SURFACE_COLUMNS, Surface, dInfinity
from libgz.physics.check import FAR, LARGEST, not_negative
from libgz.physics.divergence import mend, tell, tell_baffled, tell_gave_up
from libgz.physics.settings import EngineSettings

if TYPE_CHECKING:
    from libgz.geometry import VectorLike
    from libgz.physics.body import Body
    from libgz.physics.geom import Geom
    from libgz.physics.joint import Joint

__all__ = ["Engine", "HasEngine", "Space"]

FIXED_COLLIDE = 1  # GZ_FIXED_COLLIDE: ground, terrain, roads: they never collide with each other
LASER_COLLIDE = 2  # GZ_LASER_COLLIDE: rays
ALL_COLLIDE = 0xFFFFFFFF

# Of a new geom: kp 1e4 N/m, no damper, infinite friction; what only classic looks at is set by its collisions.
DEFAULT_SURFACE = np.zeros(SURFACE_COLUMNS)
DEFAULT_SURFACE[[Surface.KP, Surface.MU, Surface.MU2, Surface.TORSION]] = 1e4, dInfinity, dInfinity, dInfinity
DEFAULT_SURFACE[[Surface.MAX_CONTACTS, Surface.MAX_VEL, Surface.BITS]] = 10, dInfinity, 0xFFFFFFFF
DEFAULT_SURFACE[[Surface.GHOST_BITS, Surface.BY_PATCH]] = 0xFFFFFFFF, 1


class HasEngine(Protocol):
    """What bodies and joints are built in: an `Engine`, or a World that has one."""

    @property
    def engine(self) -> Engine:
        """The ODE world."""


class RayBundle(Protocol):
    """A sensor's rays."""

    def segments(self) -> NDArray[np.float64]:
        """Global ends of all rays as far as they reached [m], shape (n, 2, 3)."""


class Space:
    """A simple ODE space inside the engine's top space. Geoms of one space never touch each other.

    Args:
        engine: where.
        handle: an ODE space that somebody else owns; without one, a new space is made.
        parent: a space that this one is a part of, and closes with: parts that lie together are passed over together.
    """

    def __init__(self, engine: Engine, handle: int | None = None, parent: Space | None = None) -> None:
        self.engine = engine
        self._id = handle
        self._parts: list[Space] = []
        if handle is None:
            self._id = ode().dSimpleSpaceCreate((parent or engine.top).id)
            engine.spaces[self] = None
        if parent is not None:
            parent._parts.append(self)

    @property
    def id(self) -> int:
        """The ODE handle.

        Raises:
            ClosedError: the space was closed.
        """
        if self._id is None:
            raise ClosedError("this space was closed")
        return self._id

    def set_fixed(self) -> None:
        """Mark as ground: no contacts with other fixed spaces."""
        self.set_bits(FIXED_COLLIDE, ALL_COLLIDE & ~FIXED_COLLIDE)

    def set_bits(self, category: int, collide: int) -> None:
        """What this space is, and what it collides with."""
        ode().dGeomSetCategoryBits(self.id, category)
        ode().dGeomSetCollideBits(self.id, collide)

    def close(self) -> None:
        """Destroy the space and its parts; its geoms are closed by their bodies."""
        for part in self._parts:
            part.close()
        if self._id is not None:
            self.engine.step_form.forget(self._id)
            ode().dSpaceSetCleanup(self._id, 0)
            ode().dSpaceDestroy(self._id)
            self._id = None
            self.engine.spaces.pop(self, None)


class Engine(EngineSettings):
    """One ODE world.

    Args:
        gravity: [m/s^2], shape (3,).
        step_time: length of a step [s].
        solver: ``"world"``, ODE's exact solver, or ``"quick"``, its iterative one.
        seed: start of ODE's random numbers, which only the quick solver draws.

    Raises:
        LibraryError: ODE is absent or unfit.
        ParameterError: an argument is out of range.
    """

    view: Any = None  # the object by which a layer above shows this engine; set by that layer

    def __init__(
        self, *, gravity: VectorLike = (0.0, 0.0, -9.8), step_time: float = 0.02, solver: str = "world", seed: int = 0
    ) -> None:
        lib = ode()
        self._ode: OdeLibrary = lib
        world, top, contacts = lib.dWorldCreate(), lib.dHashSpaceCreate(None), lib.dJointGroupCreate(0)
        self.top = Space(self, top)
        self.quirks: frozenset[str] = frozenset()
        self.bodies: dict[int, Body] = {}
        self.sleepers: set[Body] = set()  # bodies that may fall asleep
        self.joints: dict[int, Joint] = {}
        self.geoms: dict[int, Geom] = {}
        self.spaces: dict[Space, None] = {}
        self.gave_up = False  # whether it was told that ODE gave up a step
        self.baffling: set[tuple[int, ...]] = set()  # pairs of geoms that it was told of that ODE cannot collide them
        self.ray_bundles: weakref.WeakSet[RayBundle] = weakref.WeakSet()  # for who wants to show them
        self._make_tables()
        probe, ray = lib.dCreateBox(None, 1.0, 1.0, 1.0), lib.dCreateRay(None, 1.0)
        for geom in (probe, ray):
            lib.dGeomSetCategoryBits(geom, LASER_COLLIDE)
            lib.dGeomSetCollideBits(geom, ALL_COLLIDE & ~LASER_COLLIDE)
        lib.dGeomRaySetClosestHit(ray, 1)
        stand_in = lib.dCreateBox(None, 1.0, 1.0, 1.0)
        self._context = StepContext(world=world, space=top, contacts=contacts, ray=ray, probe=probe, stand_in=stand_in)
        self._context.max_contacts = 20
        self._context.farthest = 2.0 * FAR
        self._context.no_cylinder_pairs = "libccd" not in lib.configuration
        self.step_form: Step = choose_step(self._context, self)
        self._step = self.step_form.step
        self._thread = 0  # that stepped last
        self.collisions = 0  # how often `collide` was called
        self._publish_tables()
        shapes = (probe, ray, stand_in)
        self._destroy = weakref.finalize(
            self, _destroy_world, lib, world, top, contacts, shapes, self.step_form.release
        )
        self.step_time = step_time
        self.solver = solver
        not_negative(seed, "seed")
        self.seed = seed
        self.gravity = gravity

    @property
    def engine(self) -> Engine:
        """The engine itself, so that it can stand where a World does."""
        return self

    # Tables ------------------------------------------------------------------------------------------------------

    def _make_tables(self) -> None:
        """Empty tables; `_grow` doubles them. Geom row 0 is for geoms without a record."""
        self.bodies_used = self.joints_used = 0
        self.geoms_used = 1
        self._free_rows: dict[str, list[int]] = {"body": [], "joint": [], "geom": []}
        self.com = np.zeros((16, 3))
        self.body_state = np.zeros((16, 16))
        self.body_start = np.zeros((16, 12))
        self.body_ids = np.zeros(16, dtype=np.uintp)
        self.joint_state = np.zeros((16, 4))
        self.springs = np.zeros((16, 3))
        self.pushing: set[int] = set()  # rows of joints with a spring or damper
        self.joint_types = np.zeros(16, dtype=np.int64)
        self.joint_ids = np.zeros(16, dtype=np.uintp)
        self.surface = np.tile(DEFAULT_SURFACE, (16, 1))
        self.owner = np.zeros(16, dtype=np.int64)
        self.surface_edits = 0

    _TABLES = {
        "body": ("com", "body_state", "body_start", "body_ids"),
        "joint": ("joint_state", "springs", "joint_types", "joint_ids"),
        "geom": ("surface", "owner"),
    }

    def _new_row(self, kind: str, used: int) -> tuple[int, int]:
        """(row, rows in use) for a new body, joint or geom; tables grow when they are full."""
        if self._free_rows[kind]:
            return self._free_rows[kind].pop(), used
        for name in self._TABLES[kind]:
            table: NDArray[Any] = getattr(self, name)
            if used == len(table):
                setattr(self, name, np.concatenate([table, np.zeros_like(table)]))
        return used, used + 1

    def _publish_tables(self) -> None:
        """Tell the step where the tables are, and make the flat views that single values are read through."""
        context = self._context
        context.surface, context.owner = self.surface.ctypes.data, self.owner.ctypes.data
        context.bodies, context.com = self.body_ids.ctypes.data, self.com.ctypes.data
        context.body_state, context.joint_state = self.body_state.ctypes.data, self.joint_state.ctypes.data
        context.springs = self.springs.ctypes.data
        context.body_start = self.body_start.ctypes.data
        context.joints, context.joint_types = self.joint_ids.ctypes.data, self.joint_types.ctypes.data
        context.body_count, context.joint_count = self.bodies_used, self.joints_used
        self.body_values = _flat(self.body_state)
        self.joint_values = _flat(self.joint_state)
        self.body_fresh = bytearray(len(self.body_ids))
        self.joint_fresh = bytearray(len(self.joint_ids))
        self._all_bodies = (b"\1" if self.step_form.reads_all else b"\0") * len(self.body_ids)
        self._all_joints = (b"\1" if self.step_form.reads_all else b"\0") * len(self.joint_ids)
        self._no_joints = bytes(len(self.joint_ids))
        self._touched = True  # whether a row may be stale, or fresh, that will not be so after a step

    def add_body(self, body: Body, handle: int) -> int:
        """Register a body; its row."""
        row, self.bodies_used = self._new_row("body", self.bodies_used)
        self.body_ids[row] = handle
        self.com[row] = 0.0
        self.body_start[row] = 0.0
        self.bodies[row] = body
        self._publish_tables()
        return row

    def remove_body(self, row: int) -> None:
        """Free the row of a body that closes."""
        self.body_ids[row] = 0
        del self.bodies[row]
        self._free_rows["body"].append(row)

    def add_joint(self, joint: Joint, kind: int) -> int:
        """Register a joint; its row. It is read once it joins something: `join`."""
        row, self.joints_used = self._new_row("joint", self.joints_used)
        self.joint_ids[row] = 0
        self.joint_types[row] = kind
        self.set_spring(row, (0.0, 0.0, 0.0))
        self.joint_state[row] = 0.0
        self.joints[row] = joint
        self._publish_tables()
        return row

    def join(self, row: int, handle: int) -> None:
        """Read a joint from now on; with handle 0 no more, for ODE crashes on some joints without bodies."""
        self.joint_ids[row] = handle
        self.joint_state[row] = 0.0
        self.joint_moved(row)

    def set_spring(self, row: int, spring: tuple[float, ...]) -> None:
        """Stiffness, damping and reference with which a joint pushes by itself."""
        self.springs[row] = spring
        (self.pushing.add if spring[0] or spring[1] else self.pushing.discard)(row)

    def remove_joint(self, row: int) -> None:
        """Free the row of a joint that closes."""
        self.joint_ids[row] = 0
        del self.joints[row]
        self._free_rows["joint"].append(row)

    def add_geom(self, geom: Geom, owner: int) -> int:
        """Register a geom of the body numbered `owner`; its row."""
        row, self.geoms_used = self._new_row("geom", self.geoms_used)
        self.owner[row] = owner
        self.surface[row] = DEFAULT_SURFACE
        self.geoms[row] = geom
        self.surface_edits += 1
        self._publish_tables()
        return row

    def remove_geom(self, row: int, handle: int) -> None:
        """Free the row of a geom that closes."""
        self.step_form.forget(handle)
        self.surface_edits += 1
        del self.geoms[row]
        self._free_rows["geom"].append(row)

    def set_surface(self, row: int, column: int, value: float) -> None:
        """Change one property of how a geom touches others; `column` is one of `Surface`."""
        self.surface[row, column] = value
        self.surface_edits += 1

    # States ------------------------------------------------------------------------------------------------------

    def read_body(self, row: int) -> None:
        """Bring one body's row up to date after it was moved."""
        read_body(self._ode, self._tables, row)
        self.body_fresh[row] = 1

    def read_joint(self, row: int) -> None:
        """Bring one joint's row up to date."""
        read_joint(self._ode, self._tables, row, unwind=self.count_turns)
        self.joint_fresh[row] = 1

    def body_moved(self, row: int) -> None:
        """Note that a body's state was set: its row and all joint rows are read anew when they are asked for."""
        self._touched = True
        self.body_fresh[row] = 0
        self.joint_fresh[:] = self._no_joints

    def joint_moved(self, row: int) -> None:
        """Note that a joint was changed: its row is read anew when it is asked for."""
        self._touched = True
        self.joint_fresh[row] = 0

    @property
    def states(self) -> NDArray[np.float64]:
        """States of all bodies, shape (rows, 16), read-only, valid until the next step.

        Columns: position [m] and quaternion (u, x, y, z) of the body frame, position of the centre of mass [m],
        linear velocity of that [m/s], angular velocity [rad/s]; all global.
        """
        self.step_form.read()
        view = self.body_state[: self.bodies_used].view()
        view.flags.writeable = False
        return view

    def _begin_watch(self) -> None:
        self.body_start[: self.bodies_used] = 0.0
        self.body_start[: self.bodies_used, :6] = self.states[:, 10:16]

    def wake(self) -> None:
        """Wake all bodies that may sleep: what they rest on was moved or taken away, or gravity changed."""
        if self.steps:  # nothing sleeps before
            for body in self.sleepers:
                body.Enable(True)

    def look_far(self) -> None:
        """Let ODE's cells be 4 m wide, and not 1/8 m: those it cannot count beyond 2^28 m, and ends the process.

        The order in which contacts are found may change with it: so only worlds that must have it.
        """
        self._ode.dHashSpaceSetLevels(self.top.id, 2, 10)
        self._context.farthest = 2.0 * LARGEST

    def sort_geoms(self) -> None:
        """Bring moving geoms into the order of their bodies: contacts are found in it, and ODE keeps that of movement.

        A run that begins with it is the same to the bit, whatever was before.
        """
        self._ode.dSpaceClean(self.top.id)
        for body in self.bodies.values():
            self._ode.dBodySetPosition(body.id, *body.GetCoMPose().pos)

    # Step and scan -----------------------------------------------------------------------------------------------

    def step(self) -> None:
        """Collide, step, and copy the states out.

        Raises:
            GazeboError: ODE ran out of memory.
            ClosedError: the world was closed.
        """
        if get_ident() != self._thread:
            self._enter_thread()
        self._finish(self._step())

    def _enter_thread(self) -> None:
        self._ode.ensure_thread()
        self._thread = get_ident()

    def collide(self) -> None:
        """The first half of a step, for those who want to act between contacts and motion; `solve` follows."""
        self._enter_thread()
        self.collisions += 1
        self.step_form.collide()

    def solve(self) -> None:
        """The second half of a step."""
        self._finish(self.step_form.solve())

    def _finish(self, done: int) -> None:
        """Note which rows are fresh now."""
        if self._touched:
            self.body_fresh[:] = self._all_bodies
            self.joint_fresh[:] = self._all_joints
            self._touched = not self.step_form.reads_all
        if done == 1:
            return
        if not done:
            raise GazeboError("ODE ran out of memory in a step: the world is too large")
        self._mend(self._context)

    def _mend(self, context: StepContext) -> None:
        """After a step in which ODE lost its way: halt what ran away, and tell of it."""
        if context.halted:
            tell(self.bodies[context.halted - 1])
        if context.gave_up:
            tell_gave_up(self)
        if context.lost:
            self.look_far()
        if context.lost or context.gave_up:
            mend(self.bodies.values(), bool(context.gave_up))
        if context.baffled:
            context.baffled = 0
            tell_baffled(self, tuple(context.baffled_by))
            self.sort_geoms()  # a pair that was given up may have left ODE's bounding box of a geom wrong

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

    def scanner(self, scan: RayScan) -> Callable[[], None]:
        """A scan ready to be made again and again: that costs less than as many calls of `scan`."""
        ensure_thread, cast = self._ode.ensure_thread, self.step_form.scanner(scan)

        def make() -> None:
            ensure_thread()
            cast()

        return make

    def close(self) -> None:
        """Destroy the world and everything in it; later use of its parts raises ClosedError."""
        if not self._destroy.alive:
            return
        self.sleepers.clear()  # or each part that goes would wake them all
        parts: list[Joint | Geom | Body | Space] = [*self.joints.values(), *self.bodies.values()]
        parts += [*self.geoms.values(), *self.spaces]
        for part in parts:
            part.close()
        self._destroy()
        self._step = self._closed_step

    def _closed_step(self) -> int:
        raise ClosedError("this world was closed")

    @property
    def _tables(self) -> Engine:
        return self


def _flat(table: NDArray[np.float64]) -> memoryview[float]:
    """A table's values in one row, through which single ones are read faster than through numpy."""
    buffer: Any = table.reshape(-1)
    return memoryview(buffer)


def _destroy_world(
    lib: OdeLibrary, world: int, top: int, contacts: int, geoms: tuple[int, ...], release: Callable[[], object]
) -> None:
    """Free everything of one world; what is still in the spaces goes with them."""
    release()
    lib.dJointGroupDestroy(contacts)
    for geom in geoms:
        lib.dGeomDestroy(geom)
    lib.dSpaceDestroy(top)
    lib.dWorldDestroy(world)
