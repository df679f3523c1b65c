"""Bounds: which numbers ODE's memory may hold, for a state that comes from a file; beyond them, ODE ends the process.

The memory of a state, see `Parts`, is read as words of 8 bytes. What each of them is follows from the classes of ODE
0.16 (ode/src/objects.h, joints/*.h). A whole state is checked before any of it reaches ODE. Limits are those of the
setters (`check`); velocities are bounded by the step itself, so that here they must only be finite, and efforts, too,
which may be what they are when the sum of several is not finite.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from libgz.base.errors import LibraryError, StateError
from libgz.ode.lib import ADVICE, ode
from libgz.ode.memory import Layout
from libgz.ode.parts import Parts
from libgz.ode.types import GeomClass, JointType, Surface
from libgz.physics.check import FAR, LARGEST, WIDE

__all__ = ["FINITE", "Block", "check_memory"]

Words = NDArray[np.float64]

FINITE = 1e150  # whose square is finite, too
_UNIT = 1e-6  # error of rotations and of unit vectors

_BODY_WORDS = 76  # of a body from its mass to its steps left
_BODY_MARKS = 0b111111111  # of a body, that may differ: how it turns, disabled, gravity, damping, gyroscopic
_GEOM_ENABLED, _GEOM_EMPTY = 16, 32

# Joints, behind lambda[6], which is written only. v: vector or quaternion, 4 words; d: number; m: limit and motor, 11
# words; a: the head of an angular motor, with its mode and number of axes.
_JOINTS: dict[int, str] = {
    JointType.BALL: "vvdd",
    JointType.HINGE: "vvvvvm",
    JointType.SLIDER: "vvvm",
    JointType.UNIVERSAL: "vvvvvvmm",
    JointType.HINGE2: "vvvvddvvvvmmdd",
    JointType.FIXED: "vvdd",
    JointType.AMOTOR: "avvvvvdddmmmm",
    JointType.PISTON: "vvvvvmm",
    JointType.DBALL: "vvddd",
}
_LAMBDA, _HEAD = 6, 3
_SIZES = {"v": 4, "d": 1, "m": 11, "a": _HEAD}
# Of a motor: vel, fmax, lostop, histop, fudge factor, cfm, stop erp, stop cfm, bounce.
_MOTOR = (
    *((-LARGEST, LARGEST), (-math.inf, math.inf), (-math.inf, LARGEST), (-LARGEST, math.inf), (-LARGEST, LARGEST)),
    *((0.0, 1e12), (0.0, LARGEST), (0.0, 1e12), (0.0, LARGEST)),
)
_MOST_STOP = 3

_POSR_WORDS = 16
_BITS_WORDS = 2

# Columns of the surface table that may be infinite, or below zero.
_INFINITE = {
    *(Surface.MU, Surface.MU2, Surface.TORSION, Surface.MAX_VEL, Surface.KP, Surface.KD, Surface.SLIP1, Surface.SLIP2),
    *(Surface.BOUNCE_VEL, Surface.RADIUS, Surface.PATCH_RADIUS),
}
_SIGNED = (*range(Surface.FDIR1, Surface.FDIR1 + 3), Surface.TRACK_SPEED, *range(Surface.PIVOT, Surface.PIVOT + 3))


class Block(NamedTuple):
    """Rows of a table that follow each other.

    Attributes:
        table: one of com, state, motion, joints, springs, surface, feedback.
        columns: of a row [words].
        rows: how many.
        address: of the first.
    """

    table: str
    columns: int
    rows: int
    address: int


def check_memory(parts: Parts, blocks: Sequence[Block], memory: bytes, present: bytes, distance: float) -> None:
    """Check the memory of a state.

    Args:
        parts: what it is of.
        blocks: the rows of tables in it.
        memory: the state.
        present: the same memory as it is now.
        distance: how far from the origin bodies may be [m].

    Raises:
        StateError: a number would end the process, or the state has another size.
        LibraryError: this ODE has other classes than those of which the words are known.
    """
    if len(memory) != len(present) or len(memory) % 8:
        raise StateError("the state is damaged: it has not the memory of these bodies, joints and geoms")
    bodies, joints, rows, spaces = parts.handles
    words, before = np.frombuffer(memory), np.frombuffer(present)
    at = _end_of_orders(words.view(np.int64), len(spaces) + len(bodies))
    lib, where = ode(), parts.where
    geoms = tuple(
        (lib.dGeomGetClass(geom), bool(lib.dGeomGetBody(geom)) and (2 if lib.dGeomIsOffset(geom) else 1))
        for geom in rows
        if geom
    )
    tables = tuple((block.table, block.columns, block.rows) for block in blocks)
    kinds = tuple(map(lib.dJointGetType, joints))
    plan = _plan(bytes(where), len(bodies), kinds, geoms, tables, len(spaces), distance)
    if len(words) - at != len(plan.low):
        raise StateError("the state is damaged: it has not the memory of these bodies, joints and geoms")
    with np.errstate(all="ignore"):
        _check(plan, words[at:], before[at:])


def _end_of_orders(counts: NDArray[np.int64], lists: int) -> int:
    """The first word behind the order of the geoms of spaces and bodies, which is checked natively."""
    at = 0
    for _ in range(lists):
        count = int(counts[at]) if at < len(counts) else -1
        if not 0 <= count < len(counts) - at:
            raise StateError("the state is damaged: it has not the geoms of these spaces and bodies")
        at += 1 + count
    return at


class _Plan(NamedTuple):
    """What the words of a state are, from the order of geoms on.

    Attributes:
        low, high: within which each one is; a word of which both are NaN is no number, or not checked.
        checked: which are.
        masses: the first words of what depends on the masses of bodies, a row each.
        rotations: the words of rotations, 12 a row.
        units: the words of quaternions, 4 a row, with 0 in place of the fourth one of the normal of a plane.
        axes: the first words of axes of bodies, 3 a row, which may be zero.
        small: words with integers of 4 bytes: at which stop a motor is.
        heads: words of the heads of angular motors.
        samples: words of which the second integer stays as it is.
        marks: words with marks.
        changing: of each of these, the marks that may differ from what they are.
    """

    low: Words
    high: Words
    checked: NDArray[np.bool_]
    masses: NDArray[np.int64]
    rotations: NDArray[np.int64]
    quaternions: NDArray[np.int64]
    normals: NDArray[np.int64]
    axes: NDArray[np.int64]
    stops: NDArray[np.int64]
    heads: NDArray[np.int64]
    samples: NDArray[np.int64]
    marks: NDArray[np.int64]
    changing: NDArray[np.int64]


class _Planner:
    """Collects what the words are, one object after another."""

    def __init__(self) -> None:
        self.low: list[float] = []
        self.high: list[float] = []
        self.places: dict[str, list[int]] = {name: [] for name in _Plan._fields[3:-1]}
        self.changing: list[int] = []

    def add(self, count: int, low: float, high: float) -> None:
        """So many numbers of one range."""
        self.low += [low] * count
        self.high += [high] * count

    def skip(self, count: int = 1) -> None:
        """So many words that are no numbers, or that ODE only writes."""
        self.add(count, math.nan, math.nan)

    def note(self, what: str) -> None:
        """Something else to check begins here."""
        self.places[what].append(len(self.low))

    def mark(self, changing: int) -> None:
        """A word with marks."""
        self.note("marks")
        self.changing.append(changing)
        self.skip()

    def plan(self) -> _Plan:
        """All of it."""
        widths = {"masses": 30, "rotations": 12, "quaternions": 4, "normals": 3, "axes": 3, "heads": _HEAD}
        indices = {
            name: np.array(starts, np.int64).reshape(-1, 1) + np.arange(widths.get(name, 1))
            for name, starts in self.places.items()
        }
        low, high = np.array(self.low), np.array(self.high)
        return _Plan(low, high, ~np.isnan(low), **indices, changing=np.array(self.changing, np.int64))


@functools.lru_cache(maxsize=32)
def _plan(
    layout: bytes,
    bodies: int,
    joints: tuple[int, ...],
    geoms: tuple[tuple[int, int], ...],
    tables: tuple[tuple[str, int, int], ...],
    spaces: int,
    distance: float,
) -> _Plan:
    """What the words are of so many bodies, joints of these types, geoms of these classes and places, and so on."""
    where, words = Layout.from_buffer_copy(layout), _Planner()
    if where.body[1] - where.body[0] != 8 * _BODY_WORDS - 4 or where.damping[1] - where.damping[0] != 8 * 5:
        raise LibraryError(f"this ODE keeps its bodies in another way than libode 0.16; {ADVICE}")
    for _ in range(bodies):
        _add_body(words, distance)
    for kind in joints:
        _add_joint(words, kind, (where.joint_end[kind] - where.joint) // 8)
    for kind, place in geoms:
        _add_geom(words, kind, place, (where.geom_end[kind] - where.geom) // 8, distance)
    for table, columns, rows in tables:
        for low, high in (_RANGES[table](columns)) * rows:
            words.add(1, low, high)
    always = where.dirty | where.stale_box
    for _, place in geoms:
        words.mark(always | _GEOM_ENABLED | _GEOM_EMPTY | (where.stale_place if place else 0))
    for _ in range(spaces):
        words.mark(always)
        words.skip(_BITS_WORDS)
    return words.plan()


def _add_body(words: _Planner, distance: float) -> None:
    """Marks, then the words of `dxBody` from its mass on."""
    words.mark(_BODY_MARKS)
    words.note("masses")
    words.add(1, 0.0, FINITE)  # mass
    words.add(4, -LARGEST, LARGEST)  # centre
    words.add(12, -FINITE, FINITE)  # moments of inertia
    words.add(13, -FINITE, FINITE)  # the inverses of both, moments first
    words.add(4, -distance, distance)  # place
    words.note("rotations")
    words.add(12, -FINITE, FINITE)
    words.note("quaternions")
    words.add(4, -FINITE, FINITE)
    words.add(8, -FINITE, FINITE)  # velocities
    words.skip(8)  # efforts may be any: the step stops bodies with such ones (begin_motion)
    words.note("axes")
    words.add(4, -FINITE, FINITE)  # the one about which it turns exactly
    words.add(1, -math.inf, math.inf)  # time until it falls asleep
    words.note("samples")
    words.skip()  # steps until then, and how many samples are averaged
    words.add(3, -math.inf, math.inf)  # two thresholds, and the time left
    words.skip()  # steps left
    words.add(2, 0.0, 1.0)  # damping
    words.add(3, 0.0, math.inf)  # from which velocities on, and the largest one


def _add_joint(words: _Planner, kind: int, count: int) -> None:
    form = _JOINTS.get(kind, "")
    if _LAMBDA + sum(map(_SIZES.__getitem__, form)) != count:
        raise LibraryError(f"this ODE keeps its joints in another way than libode 0.16; {ADVICE}")
    words.skip(_LAMBDA)
    for part in form:
        if part == "a":
            words.note("heads")
            words.skip(_HEAD)
        elif part == "m":
            for low, high in _MOTOR:
                words.add(1, low, high)
            words.note("stops")
            words.skip()
            words.add(1, -FINITE, FINITE)  # the error there
        else:
            words.add(_SIZES[part], -FINITE, FINITE)


def _add_geom(words: _Planner, kind: int, place: int, count: int, distance: float) -> None:
    words.skip(_BITS_WORDS)
    if kind == GeomClass.PLANE:
        words.note("normals")
        words.add(count - _BITS_WORDS, -2.0 * LARGEST, 2.0 * LARGEST)
        return
    words.add(count - _BITS_WORDS, 0.0, LARGEST)
    if place == _AT_BODY:
        words.skip(_POSR_WORDS)
        return
    reach = LARGEST if distance > 2.0 * FAR else WIDE
    most = distance + reach if place == _GLOBAL else 2.0 * reach
    words.add(4, -most, most)
    if kind == GeomClass.RAY:  # ODE sets its direction only, in the third column
        words.add(12, -1.0 - _UNIT, 1.0 + _UNIT)
        return
    words.note("rotations")
    words.add(12, -FINITE, FINITE)


_GLOBAL, _AT_BODY = 0, 1  # of geoms: without a body, and where its body is; 2: elsewhere on it


def _check(plan: _Plan, words: Words, before: Words) -> None:
    numbers = words[plan.checked]
    sound = (numbers >= plan.low[plan.checked]) & (numbers <= plan.high[plan.checked])  # false for NaN
    if not sound.all():
        raise StateError(f"the state is damaged: a number in it is out of its range: {numbers[~sound][0]:g}")
    matrices = words[plan.rotations].reshape(-1, 3, 4)[:, :, :3]
    error = np.abs(np.matmul(matrices, matrices.transpose(0, 2, 1)) - np.eye(3))
    _require((error <= _UNIT).all() and (np.linalg.det(matrices) > 0.0).all(), "a rotation in it is none")
    axes = words[plan.axes]
    for units in (words[plan.quaternions], words[plan.normals], axes[axes.any(axis=1)]):
        _require((np.abs((units * units).sum(axis=1) - 1.0) <= _UNIT).all(), "a direction in it has not length 1")
    masses = words[plan.masses]
    changed = (masses.view(np.int64) != before[plan.masses].view(np.int64)).any(axis=1)
    if changed.any():
        _check_masses(masses[changed])
    stops = words[plan.stops].view(np.int32)[:, ::2]
    _require(((stops >= 0) & (stops <= _MOST_STOP)).all(), "a joint is at a stop that it has not")
    for mode, axes, *bodies, _ in words[plan.heads].view(np.int32).tolist():
        sound_head = mode in (0, 1) and 0 <= axes <= 3 and all(0 <= body <= 2 for body in bodies)
        _require(sound_head and not (mode == 1 and axes != 3), "a motor has axes that none has")
    samples = words[plan.samples].view(np.int32) != before[plan.samples].view(np.int32)
    _require(not samples[:, 1::2].any(), "a body counts averages")
    marks = words[plan.marks].view(np.int32)[:, 0] ^ before[plan.marks].view(np.int32)[:, 0]
    _require(not (marks & ~plan.changing).any(), "something in it has marks that it never has")


def _require(sound: Any, what: str) -> None:
    if not sound:
        raise StateError(f"the state is damaged: {what}")


def _check_masses(body: Words) -> None:
    """Masses and moments, and what ODE has computed from them, which must fit."""
    mass, inverse_mass = body[:, 0], body[:, 29]
    _require((mass > 0.0).all(), "a mass is not above zero")
    moments, inverse = (body[:, first : first + 12].reshape(-1, 3, 4)[:, :, :3] for first in (5, 17))
    _require(
        (np.abs(moments - moments.transpose(0, 2, 1)) <= _UNIT * np.abs(moments).max()).all(), "moments are no matrix"
    )
    moving = ~((inverse_mass == 0.0) & (inverse == 0.0).all(axis=(1, 2)))  # not kinematic
    mass, inverse_mass, moments, inverse = mass[moving], inverse_mass[moving], moments[moving], inverse[moving]
    scale = np.trace(moments, axis1=1, axis2=2)[:, None, None]
    _require((scale > 0.0).all(), "moments of inertia are not above zero")
    _require((np.linalg.eigvalsh(moments / scale) > -1e-12).all(), "moments of inertia are not above zero")
    _require((np.abs(inverse_mass * mass - 1.0) <= _UNIT).all(), "the inverse of a mass is wrong")
    _require((np.abs(moments @ inverse - np.eye(3)) <= 1e-2).all(), "the inverse of moments of inertia is wrong")


def _surface_ranges(columns: int) -> list[tuple[float, float]]:
    return [
        (-LARGEST if column in _SIGNED else 0.0, math.inf if column in _INFINITE else 2.0**53)
        for column in range(columns)
    ]


# The lowest and the highest numbers of the columns of a table; what only Python reads is not checked.
_RANGES: dict[str, Callable[[int], list[tuple[float, float]]]] = {
    "com": lambda columns: [(-LARGEST, LARGEST)] * columns,
    "springs": lambda columns: [(-FINITE, FINITE)] * columns,
    "surface": _surface_ranges,
    **{name: lambda columns: [(math.nan, math.nan)] * columns for name in ("state", "motion", "joints", "feedback")},
}
