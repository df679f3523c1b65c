"""States in Python: the same bytes, in the same order, as gz_get_state and gz_set_state in step.c."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Iterator, Sequence

from libgz.ode.lib import OdeLibrary
from libgz.ode.parts import Parts
from libgz.ode.types import GeomClass

__all__ = ["get_state", "set_state"]

_POSR_SIZE = 16 * 8  # a position and a rotation, as ODE keeps them
_WORD = struct.Struct("q")
_Place = tuple[int, int]  # address and size


def get_state(ode_: OdeLibrary, parts: Parts) -> bytes:
    """The memory of ODE that decides what comes next."""
    written: list[bytes] = []
    for codes in _orders(ode_, parts):
        written.append(struct.pack(f"{1 + len(codes)}q", len(codes), *codes))
    for address, size in (*_places(ode_, parts), *_marks(parts)):
        data = ctypes.string_at(address, size) if address else bytes(size)
        written.append(data if size % 8 == 0 else data + bytes(8 - size % 8))
    return b"".join(written)


def set_state(ode_: OdeLibrary, parts: Parts, state: bytes) -> bool:
    """Put it back; false, and nothing has changed, if a geom is not where the state has it."""
    orders, at = _read_orders(ode_, parts, state)
    if orders is None:
        return False
    _, _, geoms, spaces = parts.handles
    _order(ode_, parts, orders)
    for address, size in _places(ode_, parts):
        at = _put(state, at, address, size)
    where = parts.where
    for geom in filter(None, geoms):
        stale = where.stale_place if ode_.dGeomGetBody(geom) else 0
        ctypes.c_uint32.from_address(geom + where.geom_flags).value |= where.dirty | where.stale_box | stale
    for space in spaces:
        ctypes.c_uint32.from_address(space + where.geom_flags).value |= where.dirty | where.stale_box
    ode_.dSpaceClean(spaces[0])
    box = (ctypes.c_double * 6)()
    for geom in filter(None, geoms):
        ode_.dGeomGetAABB(geom, box)
    for address, size in _marks(parts):
        at = _put(state, at, address, size)
    return True


def _put(state: bytes, at: int, address: int, size: int) -> int:
    if address:
        ctypes.memmove(address, state[at : at + size], size)
    return at + (size + 7) // 8 * 8


def _places(ode_: OdeLibrary, parts: Parts) -> Iterator[_Place]:
    """The memory of bodies, joints, geoms and tables; address 0: there is none."""
    where, (bodies, joints, geoms, _) = parts.where, parts.handles
    first, last = where.body
    damping, end = where.damping
    for body in bodies:
        yield body + where.body_flags, 4
        yield body + first, last - first
        yield body + damping, end - damping
    for joint in joints:
        yield joint + where.joint, where.joint_end[ode_.dJointGetType(joint)] - where.joint
    for geom in filter(None, geoms):
        kind = ode_.dGeomGetClass(geom)
        yield geom + where.geom, where.geom_end[kind] - where.geom
        if kind == GeomClass.PLANE:
            continue
        if not ode_.dGeomGetBody(geom):
            yield ctypes.addressof(ode_.dGeomGetPosition(geom).contents), _POSR_SIZE
        elif ode_.dGeomIsOffset(geom):
            yield ctypes.addressof(ode_.dGeomGetOffsetPosition(geom).contents), _POSR_SIZE
        else:
            yield 0, _POSR_SIZE
    yield from parts.places


def _marks(parts: Parts) -> Iterator[_Place]:
    """The marks of geoms and spaces, and the bits of spaces."""
    where, (_, _, geoms, spaces) = parts.where, parts.handles
    for geom in filter(None, geoms):
        yield geom + where.geom_flags, 4
    for space in spaces:
        yield space + where.geom_flags, 4
        yield space + where.geom, 16


def _orders(ode_: OdeLibrary, parts: Parts) -> Iterator[list[int]]:
    """The geoms of each space, then of each body: a row, or ~ the index of a space."""
    bodies, _, _, spaces = parts.handles
    indices = {space: ~i for i, space in enumerate(spaces)}
    for space in reversed(spaces):
        handles = [ode_.dSpaceGetGeom(space, i) for i in range(ode_.dSpaceGetNumGeoms(space))]
        yield [indices[geom] if geom in indices else ode_.dGeomGetData(geom) or 0 for geom in handles]
    for body in bodies:
        yield [ode_.dGeomGetData(geom) or 0 for geom in _geoms_of(ode_, body)]


def _geoms_of(ode_: OdeLibrary, body: int) -> list[int]:
    found, geom = [], ode_.dBodyGetFirstGeom(body)
    while geom:
        found.append(geom)
        geom = ode_.dBodyGetNextGeom(geom)
    return found


def _coded(parts: Parts, code: int) -> int:
    _, _, geoms, spaces = parts.handles
    handles: Sequence[int] = geoms if code >= 0 else spaces
    index = code if code >= 0 else ~code
    return handles[index] if index < len(handles) else 0


def _read_orders(ode_: OdeLibrary, parts: Parts, state: bytes) -> tuple[list[list[int]] | None, int]:
    """The geoms of each space, then of each body, and where the rest of the state begins; None: they do not fit."""
    bodies, _, _, spaces = parts.handles
    orders: list[list[int]] = []
    at = 0
    for owner in (*reversed(spaces), *bodies):
        is_space = len(orders) < len(spaces)
        present = ode_.dSpaceGetNumGeoms(owner) if is_space else len(_geoms_of(ode_, owner))
        (count,) = _WORD.unpack_from(state, at)
        if count != present:
            return None, 0
        geoms = [_coded(parts, code) for code in struct.unpack_from(f"{count}q", state, at + 8)]
        find_owner = ode_.dGeomGetSpace if is_space else ode_.dGeomGetBody
        if any(not geom or find_owner(geom) != owner for geom in geoms):
            return None, 0
        orders.append(geoms)
        at += 8 * (1 + count)
    return orders, at


def _order(ode_: OdeLibrary, parts: Parts, orders: list[list[int]]) -> None:
    """Bring geoms into the order of the state: parents of spaces last, for a space may move while it is changed."""
    bodies, _, _, spaces = parts.handles
    for space, geoms in zip(reversed(spaces), orders, strict=False):
        for geom in reversed(geoms):  # each goes to the front
            ode_.dSpaceRemove(space, geom)
            ode_.dSpaceAdd(space, geom)
    for body, geoms in zip(bodies, orders[len(spaces) :], strict=True):
        if geoms == _geoms_of(ode_, body):
            continue
        for geom in reversed(geoms):
            ode_.dGeomSetBody(geom, None)
            ode_.dGeomSetBody(geom, body)
            ode_.dGeomSetOffsetPosition(geom, 0.0, 0.0, 0.0)
