"""The form of the step in Python: the same work as step.c, operation by operation."""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Callable, Sequence
from ctypes import c_void_p
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.base.geometry import rotate
from libgz.ode import python_state
from libgz.ode.context import CONTACT, MAX_CONTACTS, NO_HIT, STEP_NEEDS_RECOVERY, Publication, RayScan, StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.nearby import NEAR_CALLBACK, geoms_near
from libgz.ode.parts import Parts
from libgz.ode.python_contacts import FullContacts, make_surface
from libgz.ode.python_islands import Islands
from libgz.ode.python_motion import MotionLimits, apply_spring, finish_motion, record_motion
from libgz.ode.python_overlaps import set_apart
from libgz.ode.tables import Tables
from libgz.ode.types import Contact, ContactGeom, ContactRule, JointType

__all__ = ["PythonStep"]

# ODE is called with the interpreter lock held (PyDLL), so its callbacks need not take it.


class _Handle(c_void_p):
    """A handle that stays an object: a result of plain c_void_p would become an int and need another conversion."""


# Kinds of pairs: two spaces, nothing that moves, one body and something static, two bodies, or one that `FullContacts`
# collides.
_SPACES, _STATIC, _PLAIN, _BODIES, _FULL = range(5)
_Pair: TypeAlias = (
    "tuple[int, c_void_p, c_void_p, c_void_p, c_void_p, c_void_p, Sequence[tuple[c_void_p, ...]]]"  # see near()
)
MOST_PAIRS = 100_000  # in the cache; each takes some hundred bytes


class PythonStep:
    """The step in Python, for installations without a C compiler; it takes twice as long.

    States are copied out only on demand, for each copy costs a ctypes call.
    """

    name = "python"
    reads_all = False

    def __init__(self, context: StepContext, tables: Tables) -> None:
        self._context = context
        self._tables = tables
        self._ode: OdeLibrary = ode()
        self._error: BaseException | None = None
        self._pairs: dict[tuple[int, int], _Pair] = {}
        self._pairs_valid_for: tuple[int, float, int] = (-1, 0.0, 0)
        self._contact_arrays: dict[tuple[float, ...], tuple[Any, list[tuple[c_void_p, ...]]]] = {}
        self._full = FullContacts(context, tables)
        self._limits = MotionLimits(self._ode)
        self._islands = Islands(context, tables, self._full.log)
        self._contact_count = 0
        self._near = self._make_near()

    def contacts(self) -> NDArray[np.void]:
        """A copy of the contact points recorded in this step."""
        return self._full.log.contacts()

    def set_contacts(self, contacts: bytes) -> None:
        """Replace the contact points recorded in the last step."""
        self._full.log.set(np.frombuffer(contacts, dtype=CONTACT))

    def get_state(self, parts: Parts) -> bytes:
        """The memory of ODE that decides what comes next."""
        return python_state.get_state(self._ode, parts)

    def set_state(self, parts: Parts, state: bytes) -> bool:
        """Put it back; false, and nothing has changed, if a geom is not where the state has it."""
        fits = len(state) == len(self.get_state(parts))
        return fits and python_state.set_state(self._ode, parts, state)

    @staticmethod
    def release() -> None:
        """Nothing to do: all memory is Python's."""

    def overlap(self, geom1: int, geom2: int) -> float:
        """The depth of the deepest contact point of two geoms [m]; -1 without any."""
        return self._full.overlap(geom1, geom2)

    def forget(self, geom: int) -> None:
        """Drop what is cached of a geom, because it was destroyed or got another body."""
        self._pairs.clear()

    def _make_near(self) -> Any:
        """The near-callback, with everything it touches in local names: it runs once per pair and step.

        What it needs of a pair is looked up once and kept as C arguments.
        """
        collide = self._ode.unchecked("dCollide", ctypes.c_int)
        collide2 = self._ode.unchecked("dSpaceCollide2", None)
        connected = self._ode.unchecked("dAreConnectedExcluding", ctypes.c_int)
        create = self._ode.unchecked("dJointCreateContact", _Handle)
        attach = self._ode.unchecked("dJointAttach", None)
        pairs, look_up = self._pairs, self._look_up_pair
        world, group = c_void_p(self._context.world), c_void_p(self._context.contacts)
        most, size, contact_type = (ctypes.c_int(v) for v in (MAX_CONTACTS, ctypes.sizeof(Contact), JointType.CONTACT))

        def near(_data: int, geom1: int, geom2: int) -> None:
            try:
                pair = pairs.get((geom1, geom2)) or look_up(geom1, geom2)
                kind, one, two, body1, body2, first, contacts = pair
                if kind == _PLAIN:
                    count = collide(one, two, most, first, size)
                elif kind == _SPACES:
                    collide2(one, two, None, callback)
                    return
                elif kind == _FULL:
                    self._full.touch(geom1, geom2)
                    return
                elif kind == _STATIC or connected(body1, body2, contact_type):
                    return
                else:
                    count = collide(one, two, most, first, size)
                if count:
                    self._contact_count += count
                    for contact in contacts[count]:
                        attach(create(world, group, contact), body1, body2)
            except BaseException as error:  # noqa: BLE001 - ctypes would print and drop it; step() raises it
                self._error = error

        self._keep = NEAR_CALLBACK(near)
        callback = ctypes.cast(self._keep, c_void_p)
        return callback

    def _look_up_pair(self, geom1: int, geom2: int) -> _Pair:
        """The kind of a pair of geoms or spaces and its C arguments; cached until a geom is destroyed or changed."""
        lib, context, one, two = self._ode, self._context, c_void_p(geom1), c_void_p(geom2)
        if len(self._pairs) > MOST_PAIRS:
            self._pairs.clear()
        if lib.dGeomIsSpace(geom1) or lib.dGeomIsSpace(geom2):
            pair: _Pair = (_SPACES, one, two, one, two, one, [])
        else:
            body1, body2 = (lib.dGeomGetBody(geom) or 0 for geom in (geom1, geom2))
            kind = _BODIES if body1 and body2 else _PLAIN if body1 or body2 else _STATIC
            legacy = context.contact_rule == ContactRule.LEGACY and not context.record_contacts
            if kind != _STATIC and (not legacy or self._full.round_pair(geom1, geom2)):
                kind = _FULL
            first, contacts = self._contacts(*self._full.rows(geom1, geom2))
            pair = (kind, one, two, c_void_p(body1), c_void_p(body2), first, contacts)
        self._pairs[geom1, geom2] = pair
        return pair

    def _contacts(self, a: list[float], b: list[float]) -> tuple[c_void_p, list[tuple[c_void_p, ...]]]:
        """Contacts with the surface of two geoms: where dCollide writes, and the first n of them for each n."""
        key = (*a, *b)
        if key not in self._contact_arrays:
            array, surface = (Contact * MAX_CONTACTS)(), make_surface(self._context, a, b)
            for contact in array:
                contact.surface = surface
            start, size = ctypes.addressof(array), ctypes.sizeof(Contact)
            handles = [c_void_p(start + i * size) for i in range(MAX_CONTACTS)]
            self._contact_arrays[key] = array, [tuple(handles[:n]) for n in range(MAX_CONTACTS + 1)]
        array, contacts = self._contact_arrays[key]
        return c_void_p(ctypes.addressof(array) + Contact.geom.offset), contacts

    def step(self) -> int:
        """Both halves."""
        self.collide()
        return self.solve()

    def collide(self) -> None:
        """Find contacts and make joints of them."""
        context, ode_ = self._context, self._ode
        recording = context.record_contacts
        valid_for = (self._tables.geoms.edits, context.step, recording)
        if valid_for != self._pairs_valid_for:
            self._pairs.clear()
            self._contact_arrays.clear()
            self._pairs_valid_for = valid_for
        self._contact_count = self._full.count = 0
        self._full.touches.clear()
        self._full.overlaps.clear()
        if context.exact_rest and context.contact_rule == ContactRule.CLASSIC:
            self._full.find_held()
        self._full.log.begin(bool(recording))
        ode_.dSpaceCollide(context.space, None, self._near)
        self._full.log.carry_on(ode_)
        context.contact_count = self._contact_count + self._full.count
        self._raise_error()

    def solve(self) -> int:
        """Move everything, empty the contact group."""
        context, ode_ = self._context, self._ode
        ode_.dRandSetSeed(context.seed)
        recording = self._pairs_valid_for[2]
        if recording:
            self._full.log.request_feedback(ode_)
        joints, bodies = self._tables.joints, self._tables.bodies
        for row in sorted(joints.sprung):
            if joints.ids[row]:
                apply_spring(ode_, joints, row, unwind=bool(context.count_turns))
        context.reset_row = 0
        moving = self._bodies() if context.check_divergence or context.record_motion else []
        if context.check_divergence:
            for row, body in moving:
                if self._limits.reset_diverged(body):
                    context.reset_row = row + 1
        if context.record_motion:
            for row, _ in moving:
                record_motion(ode_, bodies, row)
        done = self._islands.move(self._full.touches)
        if done and self._full.overlaps:
            set_apart(context, self._tables, self._full.overlaps, self._full.held)
        if recording:
            self._full.log.collect_feedback(ode_)
        ode_.dJointGroupEmpty(context.contacts)
        context.seed = ode_.dRandGetSeed()
        context.steps += 1
        if context.record_motion:
            for row, _ in moving:
                finish_motion(ode_, bodies, row, context.step)
        if context.count_turns:
            self._read_joints()
        if context.check_divergence:
            context.diverged = sum(self._limits.has_diverged(body, context.max_distance) for _, body in moving)
        return STEP_NEEDS_RECOVERY if done and (context.reset_row or context.diverged) else int(done != 0)

    def _bodies(self) -> list[tuple[int, int]]:
        """Rows and handles of all bodies."""
        handles = self._tables.bodies.ids[: self._context.body_count].tolist()
        return [(row, body) for row, body in enumerate(handles) if body]

    def _raise_error(self) -> None:
        error, self._error = self._error, None
        if error is not None:
            raise error

    def read(self) -> None:
        """Copy all states out."""
        for row, _ in self._bodies():
            self._tables.bodies.read(row)
        self._read_joints()

    def publish(self, publication: Publication) -> None:
        """Copy header and states to a mapped file."""
        place, header = publication.target or 0, publication.header or 0
        sequence = ctypes.c_uint64.from_address(header + publication.sequence_offset)
        shared = ctypes.c_uint64.from_address(place + publication.sequence_offset)
        sequence.value += 1
        shared.value = sequence.value
        ctypes.memmove(place, header, publication.header_size)
        bodies, joints = self._tables.bodies, self._tables.joints
        for row, _ in self._bodies():
            if not bodies.fresh[row]:
                bodies.read(row)
        angles = joints.state[: self._context.joint_count].copy()
        for row in joints.ids[: self._context.joint_count].nonzero()[0].tolist():
            if not joints.fresh[row]:
                angles[row] = joints.values_of(row)
        ctypes.memmove(place + publication.bodies_offset, bodies.state.ctypes.data, self._context.body_count * 16 * 8)
        ctypes.memmove(place + publication.joints_offset, angles.ctypes.data, angles.nbytes)
        ctypes.memmove(place + publication.fixed_offset, publication.fixed, publication.fixed_size)
        sequence.value += 1
        shared.value = sequence.value

    def _read_joints(self) -> None:
        joints = self._tables.joints
        for row in joints.ids[: self._context.joint_count].nonzero()[0].tolist():
            joints.read(row)

    def scanner(self, scan: RayScan) -> Callable[[], object]:
        """A prepared scan."""
        return functools.partial(self._scan, scan)

    def _scan(self, scan: RayScan) -> None:
        frame, rays, owner, ranges, rows = scan
        ranges[:] = NO_HIT
        rows[:] = -1
        if not len(rays):
            return
        ode_, context, position = self._ode, self._context, frame[:3].tolist()
        rotation = frame[3:].tolist()
        starts, directions, lengths = [], [], rays[:, 6].tolist()
        for ray in rays.tolist():
            starts.append([p + o for p, o in zip(rotate(rotation, ray[:3]), position, strict=True)])
            directions.append(list(rotate(rotation, ray[3:6])))
        start, direction = np.array(starts), np.array(directions)
        with np.errstate(over="ignore", invalid="ignore"):
            end = start + rays[:, 6:7] * direction
        finite = np.isfinite(start).all(axis=1) & np.isfinite(end).all(axis=1)  # else ODE's assertions fail
        if not finite.any():
            return
        start, end = start[finite], end[finite]
        low, high = np.minimum(start, end).min(axis=0), np.maximum(start, end).max(axis=0)
        with np.errstate(over="ignore"):
            ode_.dGeomBoxSetLengths(context.probe, *(high - low + 1e-6).tolist())
            ode_.dGeomSetPosition(context.probe, *(0.5 * (low + high)).tolist())
        hit = ContactGeom()
        hit_address, hit_size = ctypes.addressof(hit), ctypes.sizeof(hit)
        seen = self._gather(owner)
        for i, (first, along, length) in enumerate(zip(starts, directions, lengths, strict=True)):
            if not finite[i]:
                continue
            ode_.dGeomRaySetLength(context.ray, length)
            ode_.dGeomRaySet(context.ray, *first, *along)
            for geom, row, box in seen:
                if not _may_hit(first, along, length, box):
                    continue
                if ode_.dCollide(context.ray, geom, 1, hit_address, hit_size) and hit.depth < ranges[i]:
                    ranges[i], rows[i] = hit.depth, row

    def _gather(self, owner: int) -> list[tuple[int, int, list[float]]]:
        """(geom, row, bounding box) of all geoms whose box meets that of the probe, without those of body `owner`."""
        ode_, context = self._ode, self._context
        seen: list[tuple[int, int, list[float]]] = []
        box = (ctypes.c_double * 6)()
        for geom in geoms_near(ode_, context.probe or 0, context.space or 0):
            row = ode_.dGeomGetData(geom) or 0
            if not owner or self._tables.geoms.owner[row] != owner:
                ode_.dGeomGetAABB(geom, box)
                seen.append((geom, row, box[:]))
        return seen


def _may_hit(start: Sequence[float], direction: Sequence[float], length: float, box: Sequence[float]) -> bool:
    """may_hit in step.c: whether a ray meets a box enlarged by a small margin."""
    first, last = 0.0, length
    for k in range(3):
        low, high, along = box[2 * k] - 1e-9 - start[k], box[2 * k + 1] + 1e-9 - start[k], direction[k]
        if -1e-12 < along < 1e-12:
            if low > 0.0 or high < 0.0:
                return False
            continue
        a, b = low / along, high / along
        if a > b:
            a, b = b, a
        first, last = max(first, a - 1e-9), min(last, b + 1e-9)
        if first > last:
            return False
    return True
