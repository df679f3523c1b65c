"""Where ODE keeps what its functions do not return: the idle counters of bodies, all of a joint, the marks of geoms.

ODE has setters that change last bits (they normalise quaternions), and no getter for some of what decides the next
step. So a state is copied from ODE's own memory. What lies where is found when ODE is loaded: each place is looked for
by writing an odd value with one of ODE's functions, and a place that is not found once, and in the expected order,
leaves `layout` without a result. No pointer is ever copied; those that link the bodies of a world are exchanged among
themselves.
"""

from __future__ import annotations

import ctypes
import functools
import struct
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from ctypes import c_int64
from typing import NamedTuple

from libgz.base.digest import sha256
from libgz.base.errors import LibraryError
from libgz.ode.lib import ADVICE, OdeLibrary, ode
from libgz.ode.types import Mass

__all__ = ["MOST_KINDS", "Layout", "clear_joint", "layout", "order_bodies", "prepare"]

MOST_KINDS = 16  # numbers of joint types and geom classes are below
_JOINTS = ["Ball", "Hinge", "Hinge2", "Slider", "Universal", "Fixed", "Piston", "DBall", "AMotor"]
_ODD_ADDRESS, _ODD_STEPS, _ODD_BITS = 0x1234567890AB, 0x3A5C7E91, 0x5A3C96E1
_ODD = 1234.56789
_POINTER = struct.Struct("P")
_WORLD_SIZE = 4096  # [byte] more than ODE's worlds have


class Layout(ctypes.Structure):
    """Offsets in ODE's objects [bytes]; mirrors `layout` in states.c.

    Attributes:
        body_flags: of the switches of a body.
        body: first and last + 1 of mass, inertia, place, velocities, efforts, thresholds of sleep, idle counters.
        damping: likewise, of damping.
        joint: of the first byte of a joint behind its links to others.
        joint_end: by type; 0 for types that are not used.
        geom_flags: of the marks of a geom.
        geom: of category and collide bits.
        geom_end: by class, behind the bits, and the lengths of simple shapes.
        dirty: the mark of a geom that has moved since collisions were last searched.
        stale_place: the mark of a geom whose place must be computed again from that of its body.
        stale_box: the mark of a geom whose bounding box must be computed again.
    """

    _fields_ = [
        ("body_flags", c_int64),
        ("body", c_int64 * 2),
        ("damping", c_int64 * 2),
        ("joint", c_int64),
        ("joint_end", c_int64 * MOST_KINDS),
        ("geom_flags", c_int64),
        ("geom", c_int64),
        ("geom_end", c_int64 * MOST_KINDS),
        ("dirty", c_int64),
        ("stale_place", c_int64),
        ("stale_box", c_int64),
    ]

    @functools.cached_property
    def digest(self) -> str:
        """A short text that differs for another layout."""
        return sha256(bytes(self)).hexdigest()[:16]


class _Allocator:
    """Notes the sizes of ODE's objects, and fills them before they are constructed."""

    def __init__(self, ode_: OdeLibrary) -> None:
        self._ode = ode_
        libc = ctypes.CDLL(None)
        self._malloc = libc.malloc
        self._malloc.restype, self._malloc.argtypes = ctypes.c_void_p, [ctypes.c_size_t]
        self._sizes: dict[int, int] = {}
        self._fill = 0
        self._function = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.c_size_t)(self._allocate)

    def _allocate(self, size: int) -> int:
        address = int(self._malloc(size) or 0)
        if address:
            ctypes.memset(address, self._fill, size)
            self._sizes[address] = size
        return address

    def size(self, create: Callable[[], int], fill: int = 0) -> tuple[int, int]:
        """The handle of a new object, made in memory filled with one byte, and its size."""
        self._fill = fill
        self._sizes.clear()
        previous = self._ode.dGetAllocHandler()
        self._ode.dSetAllocHandler(ctypes.cast(self._function, ctypes.c_void_p))
        try:
            handle = create()
        finally:
            self._ode.dSetAllocHandler(previous)
        if handle not in self._sizes:
            raise _unfit("an object is not one block of memory")
        return handle, self._sizes[handle]


def _unfit(what: str) -> LibraryError:
    return LibraryError(f"this ODE keeps its state in another way than libode 0.16 ({what}); {ADVICE}")


def _find(data: bytes, pattern: bytes, count: int = 1) -> list[int]:
    """Offsets of a pattern that must occur `count` times, aligned."""
    step = len(pattern)
    found = [i for i in range(0, len(data) - step + 1, step) if data[i : i + step] == pattern]
    if len(found) != count:
        raise _unfit(f"a value was found {len(found)} times instead of {count}")
    return found


def _word(handle: int, offset: int) -> int:
    return ctypes.c_uint32.from_address(handle + offset).value


def _pointer(address: int) -> int:
    return ctypes.c_void_p.from_address(address).value or 0


def _difference(handle: int, size: int, one: Callable[[], object], two: Callable[[], object]) -> int:
    """The offset of the one word that differs after two calls."""
    one()
    before = ctypes.string_at(handle, size)
    two()
    after = ctypes.string_at(handle, size)
    one()
    found = {i & ~3 for i in range(size) if before[i] != after[i]}
    if len(found) != 1:
        raise _unfit(f"a switch changes {len(found)} words")
    return found.pop()


@contextmanager
def _world(ode_: OdeLibrary) -> Iterator[int]:
    world = ode_.dWorldCreate()
    try:
        yield world
    finally:
        ode_.dWorldDestroy(world)


def _find_body(ode_: OdeLibrary, allocator: _Allocator, result: Layout) -> None:
    with _world(ode_) as world:
        body, size = allocator.size(lambda: ode_.dBodyCreate(world))
        result.body_flags = _difference(
            body, size, lambda: ode_.dBodySetGravityMode(body, 1), lambda: ode_.dBodySetGravityMode(body, 0)
        )
        mass = Mass(_ODD)
        mass.I[0], mass.I[5], mass.I[10] = 1.0, 1.0, 1.0
        ode_.dBodySetMass(body, ctypes.addressof(mass))
        ode_.dBodySetAutoDisableTime(body, _ODD + 1.0)
        ode_.dBodySetAutoDisableSteps(body, _ODD_STEPS)
        ode_.dBodyEnable(body)  # which starts the counters
        ode_.dBodySetLinearDamping(body, _ODD + 2.0)
        ode_.dBodySetAngularDamping(body, _ODD + 3.0)
        data = ctypes.string_at(body, size)
        start = _find(data, struct.pack("d", _ODD))[0]
        times = _find(data, struct.pack("d", _ODD + 1.0), 2)
        steps = _find(data, struct.pack("i", _ODD_STEPS), 2)
        damping = [_find(data, struct.pack("d", _ODD + more))[0] for more in (2.0, 3.0)]
        vectors = [
            ctypes.addressof(get(body).contents) - body
            for get in (
                ode_.dBodyGetPosition,
                ode_.dBodyGetRotation,
                ode_.dBodyGetQuaternion,
                ode_.dBodyGetLinearVel,
                ode_.dBodyGetAngularVel,
                ode_.dBodyGetForce,
                ode_.dBodyGetTorque,
            )
        ]
        expected = [start, *vectors, times[0], times[1], steps[1], damping[0], damping[1]]
        if expected != sorted(expected) or vectors[-1] + 128 < steps[0] - 64 or steps[1] != times[1] + 8:
            raise _unfit("the order of what a body holds")
        result.body[:] = start, steps[1] + 4
        result.damping[:] = damping[0], size


def _find_links(ode_: OdeLibrary, allocator: _Allocator) -> _Links:
    with _world(ode_) as world:
        one, size = allocator.size(lambda: ode_.dBodyCreate(world))
        two = ode_.dBodyCreate(world)
        following = _find(ctypes.string_at(two, size), _POINTER.pack(one))[0]
        place = _find(ctypes.string_at(one, size), _POINTER.pack(two + following))[0]
        first = _pointer(two + place) - world
        if not 0 < first < _WORLD_SIZE or _pointer(world + first) != two or _pointer(one + following):
            raise _unfit("the links of bodies")
        return _Links(first, following, place)


def _find_joints(ode_: OdeLibrary, allocator: _Allocator, result: Layout) -> dict[int, list[tuple[int, int]]]:
    """The layout of joints; returns the bytes that their constructors leave as they were: (offset, size) by type."""
    unset: dict[int, list[tuple[int, int]]] = {}
    with _world(ode_) as world:
        for kind in _JOINTS:
            create = functools.partial(getattr(ode_, f"dJointCreate{kind}"), world, None)
            (one, size), (two, _) = allocator.size(create, 0x00), allocator.size(create, 0xFF)
            raw = [ctypes.string_at(joint, size) for joint in (one, two)]
            number = ode_.dJointGetType(one)
            ode_.dJointSetFeedback(one, _ODD_ADDRESS)
            start = _find(ctypes.string_at(one, size), struct.pack("q", _ODD_ADDRESS))[0] + 8
            ode_.dJointSetFeedback(one, None)
            if result.joint not in (0, start) or not 0 < number < MOST_KINDS:
                raise _unfit("joints begin in different ways")
            result.joint, result.joint_end[number] = start, size
            words = [struct.unpack_from(f"{size // 4}I", data) for data in raw]
            unset[number] = [
                (4 * i, 4)
                for i, (a, b) in enumerate(zip(*words, strict=True))
                if (a, b) == (0, 0xFFFFFFFF) and 4 * i >= start
            ]
    return unset


def _find_geoms(ode_: OdeLibrary, allocator: _Allocator, result: Layout) -> None:
    space = ode_.dSimpleSpaceCreate(None)
    with _world(ode_) as world:
        body = ode_.dBodyCreate(world)
        geoms = []
        for create in (
            lambda: ode_.dCreateSphere(space, _ODD),
            lambda: ode_.dCreateBox(space, _ODD, _ODD, _ODD),
            lambda: ode_.dCreateCapsule(space, _ODD, _ODD),
            lambda: ode_.dCreateCylinder(space, _ODD, _ODD),
            lambda: ode_.dCreatePlane(space, 0.0, 0.0, 1.0, _ODD),
        ):
            geom, size = allocator.size(create)
            geoms.append((geom, size))
            flags = _difference(
                geom, size, functools.partial(ode_.dGeomEnable, geom), functools.partial(ode_.dGeomDisable, geom)
            )
            ode_.dGeomSetCategoryBits(geom, _ODD_BITS)
            ode_.dGeomSetCollideBits(geom, _ODD_BITS + 1)
            data = ctypes.string_at(geom, size)
            category, collide = (_find(data, struct.pack("Q", _ODD_BITS + more))[0] for more in (0, 1))
            if collide != category + 8 or result.geom not in (0, category) or result.geom_flags not in (0, flags):
                raise _unfit("geoms begin in different ways")
            result.geom_flags, result.geom = flags, category
            lengths = [i for i in range(collide + 8, size, 8) if data[i : i + 8] == struct.pack("d", _ODD)]
            result.geom_end[ode_.dGeomGetClass(geom)] = lengths[-1] + 8
        for number in range(MOST_KINDS):
            result.geom_end[number] = result.geom_end[number] or result.geom + 16
        geom, flags = geoms[0][0], result.geom_flags
        ode_.dGeomSetBody(geom, body)
        ode_.dGeomSetOffsetPosition(geom, 1.0, 0.0, 0.0)
        ode_.dSpaceClean(space)
        clean = _word(geom, flags)
        ode_.dBodySetPosition(body, 1.0, 1.0, 1.0)
        moved = _word(geom, flags)
        ode_.dGeomGetPosition(geom)
        placed = _word(geom, flags)
        ode_.dGeomGetAABB(geom, (ctypes.c_double * 6)())
        boxed = _word(geom, flags)
        result.stale_place, result.stale_box = moved & ~placed, placed & ~boxed
        result.dirty = boxed & ~clean
        if [mark.bit_count() for mark in (result.dirty, result.stale_place, result.stale_box)] != [1, 1, 1]:
            raise _unfit("the marks of geoms")
        ode_.dGeomSetBody(geom, None)
        ode_.dSpaceDestroy(space)


class _Links(NamedTuple):
    """Offsets of the pointers [byte] that link the bodies of a world, newest first."""

    first: int  # in the world: the first body
    following: int  # in a body: the next one
    place: int  # in a body: where the pointer to it is


class _Found(NamedTuple):
    """What is known of the loaded ODE: a layout, or why there is none; bytes of joints that nothing writes."""

    layout: Layout | None
    links: _Links | None
    unset: dict[int, list[tuple[int, int]]]  # offset and size, by type
    error: str = ""


_finding = threading.Lock()  # no other world may be stepped while ODE's allocator is replaced


@functools.cache
def _find_out() -> _Found:
    lib, result = ode(), Layout()
    allocator = _Allocator(lib)
    try:
        _find_body(lib, allocator, result)
        links = _find_links(lib, allocator)
        unset = _find_joints(lib, allocator, result)
        _find_geoms(lib, allocator, result)
    except LibraryError as error:
        return _Found(None, None, {}, str(error))
    return _Found(result, links, unset)


def prepare() -> None:
    """Find the layout, which must happen before the first world of a process is stepped."""
    with _finding:
        _find_out()


def layout() -> Layout:
    """The layout of the loaded ODE.

    Raises:
        LibraryError: it is none that libgz knows how to find.
    """
    found = _find_out()
    if found.layout is None:
        raise LibraryError(found.error)
    return found.layout


def clear_joint(handle: int, kind: int) -> None:
    """Set the bytes of a new joint that ODE leaves as they were to zero, so that equal joints are equal bytes."""
    for offset, size in _find_out().unset.get(kind, ()):
        ctypes.memset(handle + offset, 0, size)


def order_bodies(world: int, bodies: Sequence[int]) -> None:
    """Link the bodies of a world as if they had been made in this order, in which the step finds islands.

    Args:
        world: its handle.
        bodies: their handles, oldest first.

    Raises:
        LibraryError: it is not known where this ODE keeps the links.
    """
    links = _find_out().links
    if links is None:
        raise LibraryError(_find_out().error)
    at, present = world + links.first, set(bodies)
    listed: list[int] = []
    while body := _pointer(at):
        listed.append(body)
        at = body + links.following
    newest_first = reversed(bodies)
    at = world + links.first
    for body in [next(newest_first) if body in present else body for body in listed]:
        ctypes.c_void_p.from_address(at).value = body
        ctypes.c_void_p.from_address(body + links.place).value = at
        at = body + links.following
    ctypes.c_void_p.from_address(at).value = None
