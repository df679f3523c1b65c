"""The form of the step in Python: the same work as step.c, operation by operation."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Sequence
from ctypes import c_double, c_void_p
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from libgz.geometry import rotate
from libgz.ode.context import MAX_CONTACTS, NO_HIT, StepContext, Tables, read_body, read_joint
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.types import Contact, ContactGeom, ContactMode, GeomClass, JointType, Surface, SurfaceParameters

__all__ = ["PythonStep"]

# ODE is called with the interpreter lock held (PyDLL), so its callbacks need not take it.
_NEAR_CALLBACK = ctypes.PYFUNCTYPE(None, c_void_p, c_void_p, c_void_p)


class _Handle(c_void_p):
    """A handle that stays one: a result of plain c_void_p becomes an int, and must be made an argument again."""


# What a pair is: two spaces, nothing that moves, one body and something static, two bodies, or two bodies whose shapes
# ODE itself cannot collide.
_SPACES, _STATIC, _PLAIN, _BODIES, _CYLINDERS = range(5)
_Pair: TypeAlias = (
    "tuple[int, c_void_p, c_void_p, c_void_p, c_void_p, c_void_p, Sequence[tuple[c_void_p, ...]]]"  # see near()
)
_ROUND = {GeomClass.CAPSULE, GeomClass.CYLINDER}
MOST_PAIRS = 100_000  # remembered; each is some hundred bytes


class PythonStep:
    """The same in Python: slower by half, and at home where there is no C compiler.

    States are copied out only when somebody asks, for each copy costs a ctypes call.
    """

    name = "python"
    reads_all = False

    def __init__(self, context: StepContext, tables: Tables) -> None:
        self._context = context
        self._tables = tables
        self._ode: OdeLibrary = ode()
        self._fault: BaseException | None = None
        self._pairs: dict[tuple[int, int], _Pair] = {}
        self._pairs_valid_for: tuple[int, float] = (-1, 0.0)
        self._contact_arrays: dict[tuple[float, ...], tuple[Any, list[tuple[c_void_p, ...]]]] = {}
        self._contact_count = 0
        self._near = self._make_near()

    def forget(self, geom: int) -> None:
        """Drop what is remembered of a geom, because it was destroyed or given to another body."""
        self._pairs.clear()

    def _make_near(self) -> Any:
        """The near-callback, with everything it touches in local names: it runs once per pair and step.

        What it needs of a pair is looked up once and kept as ready-made C arguments.
        """
        collide = self._ode.unchecked("dCollide", ctypes.c_int)
        collide2 = self._ode.unchecked("dSpaceCollide2", None)
        connected = self._ode.unchecked("dAreConnectedExcluding", ctypes.c_int)
        create = self._ode.unchecked("dJointCreateContact", _Handle)
        attach = self._ode.unchecked("dJointAttach", None)
        context, pairs, look_up = self._context, self._pairs, self._look_up_pair
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
                elif kind == _STATIC or connected(body1, body2, contact_type):
                    return
                elif kind == _BODIES:
                    count = collide(one, two, most, first, size)
                else:
                    count = self._collide_cylinder(geom1, geom2, first.value or 0)
                if count:
                    if context.classic:
                        count = self._refine(geom1, geom2, count)
                    self._contact_count += count
                    for contact in contacts[count]:
                        attach(create(world, group, contact), body1, body2)
            except BaseException as fault:  # noqa: BLE001 - ctypes would print and drop it; step() raises it
                self._fault = fault

        self._keep = _NEAR_CALLBACK(near)
        callback = ctypes.cast(self._keep, c_void_p)
        return callback

    def _look_up_pair(self, geom1: int, geom2: int) -> _Pair:
        """What a pair of geoms or spaces is, and what it collides with; remembered until a geom goes or changes."""
        lib, one, two = self._ode, c_void_p(geom1), c_void_p(geom2)
        if len(self._pairs) > MOST_PAIRS:
            self._pairs.clear()
        if lib.dGeomIsSpace(geom1) or lib.dGeomIsSpace(geom2):
            pair: _Pair = (_SPACES, one, two, one, two, one, [])
        else:
            body1, body2 = (lib.dGeomGetBody(geom) or 0 for geom in (geom1, geom2))
            kinds = {lib.dGeomGetClass(geom) for geom in (geom1, geom2)}
            kind = _BODIES if body1 and body2 else _PLAIN if body1 or body2 else _STATIC
            if kind == _BODIES and self._context.no_cylinder_pairs and GeomClass.CYLINDER in kinds <= _ROUND:
                kind = _CYLINDERS
            a, b = self._rows(geom1, geom2)
            if self._context.classic and not int(a[Surface.BITS]) & int(b[Surface.BITS]):
                kind = _STATIC
            first, contacts = self._contacts(a, b)
            pair = (kind, one, two, c_void_p(body1), c_void_p(body2), first, contacts)
        self._pairs[geom1, geom2] = pair
        return pair

    def _rows(self, geom1: int, geom2: int) -> tuple[list[float], list[float]]:
        """The surfaces of two geoms."""
        surface, data = self._tables.surface, self._ode.dGeomGetData
        return surface[data(geom1) or 0].tolist(), surface[data(geom2) or 0].tolist()

    def _refine(self, geom1: int, geom2: int, count: int) -> int:
        """What classic adds to contacts; deepest and refine_point in step.c, operation by operation."""
        a, b = self._rows(geom1, geom2)
        points, plain = self._contact_arrays[*a, *b][0], self._surface(a, b)
        most = int(min(a[Surface.MAX_CONTACTS], b[Surface.MAX_CONTACTS]))
        while count > most:
            shallow = min(range(count), key=lambda i: points[i].geom.depth)
            for i in range(shallow, count - 1):
                points[i] = points[i + 1]
            count -= 1
        slips = [(a[column] + b[column]) * count for column in (Surface.SLIP1, Surface.SLIP2)]
        slack = max(a[Surface.MIN_DEPTH], b[Surface.MIN_DEPTH])
        limit = max(a[Surface.MAX_VEL], b[Surface.MAX_VEL])
        for point in points[:count]:
            point.surface = plain
            surface, mode = point.surface, plain.mode
            surface.slip1, surface.slip2 = slips
            mode |= (ContactMode.SLIP1 if slips[0] > 0.0 else 0) | (ContactMode.SLIP2 if slips[1] > 0.0 else 0)
            if self._friction_direction(a, b, geom1, geom2, point):
                mode |= ContactMode.FDIR1
            surface.mode = int(mode)
            point.geom.depth = max(0.0, point.geom.depth - slack)
            if point.geom.depth > 0.0:
                surface.soft_erp = min(plain.soft_erp, limit * self._context.step / point.geom.depth)
        return count

    def _friction_direction(self, a: list[float], b: list[float], geom1: int, geom2: int, point: Any) -> bool:
        """friction_direction in step.c, operation by operation."""
        first, second = (row[Surface.FDIR1 : Surface.FDIR1 + 3] for row in (a, b))
        local, geom = first, geom1
        if _dot(first, first) == 0.0 or (b[Surface.MU] < a[Surface.MU] and _dot(second, second) > 0.0):
            local, geom = second, geom2
        if _dot(local, local) == 0.0:
            return False
        m, n = self._ode.dGeomGetRotation(geom).contents, point.geom.normal[:3]
        aim = [m[4 * k] * local[0] + m[4 * k + 1] * local[1] + m[4 * k + 2] * local[2] for k in range(3)]
        along = _dot(aim, n)
        aim = [v - along * w for v, w in zip(aim, n, strict=True)]
        size = math.sqrt(_dot(aim, aim))
        if size < 1e-9:
            return False
        point.fdir1[:3] = [v / size for v in aim]
        return True

    def _contacts(self, a: list[float], b: list[float]) -> tuple[c_void_p, list[tuple[c_void_p, ...]]]:
        """Contacts with the surface of two geoms: where dCollide writes, and the first n of them for each n."""
        key = (*a, *b)
        if key not in self._contact_arrays:
            array, surface = (Contact * MAX_CONTACTS)(), self._surface(a, b)
            for contact in array:
                contact.surface = surface
            start, size = ctypes.addressof(array), ctypes.sizeof(Contact)
            handles = [c_void_p(start + i * size) for i in range(MAX_CONTACTS)]
            self._contact_arrays[key] = array, [tuple(handles[:n]) for n in range(MAX_CONTACTS + 1)]
        array, contacts = self._contact_arrays[key]
        return c_void_p(ctypes.addressof(array) + Contact.geom.offset), contacts

    def _collide_cylinder(self, geom1: int, geom2: int, first: int) -> int:
        """Contacts of a cylinder with a cylinder or capsule; collide_cylinder in step.c, operation by operation."""
        ode_, box = self._ode, self._context.stand_in
        cylinder = geom2 if ode_.dGeomGetClass(geom2) == GeomClass.CYLINDER else geom1
        other = geom1 if cylinder == geom2 else geom2
        p, q = ode_.dGeomGetPosition(cylinder).contents[:3], ode_.dGeomGetPosition(other).contents[:3]
        r, s = self._columns(cylinder), self._columns(other)
        radius, length = self._round_size(cylinder)
        _, other_length = self._round_size(other)
        axis, other_axis = r[2], s[2]
        gap = [b - a for a, b in zip(p, q, strict=True)]
        along, t = _dot(gap, axis), _dot(other_axis, axis)
        gap = [g - along * a for g, a in zip(gap, axis, strict=True)]
        other_axis = [o - t * a for o, a in zip(other_axis, axis, strict=True)]
        square = _dot(other_axis, other_axis)
        t = -_dot(gap, other_axis) / square if square > 1e-9 else 0.0
        t = max(min(t, 0.5 * other_length), -0.5 * other_length)
        aim = [g + t * o for g, o in zip(gap, other_axis, strict=True)]
        size = _dot(aim, aim)
        if size < 1e-18:
            aim, size = r[0], 1.0
        size = math.sqrt(size)
        aim = [a / size for a in aim]
        side = [
            axis[1] * aim[2] - axis[2] * aim[1],
            axis[2] * aim[0] - axis[0] * aim[2],
            axis[0] * aim[1] - axis[1] * aim[0],
        ]
        rotation = (c_double * 12)(*(v for k in range(3) for v in (aim[k], side[k], axis[k], 0.0)))
        one, two = (box if geom == cylinder else geom for geom in (geom1, geom2))
        count = 0
        for radial, tangential in ((radius, 0.2 * radius), (radius * 0.70710678118654752,) * 2):
            ode_.dGeomBoxSetLengths(box, 2.0 * radial, 2.0 * tangential, length)
            ode_.dGeomSetPosition(box, *p)
            ode_.dGeomSetRotation(box, rotation)
            at = first + count * ctypes.sizeof(Contact)
            count += ode_.dCollide(one, two, MAX_CONTACTS // 2, at, ctypes.sizeof(Contact))
        return count

    def _columns(self, geom: int) -> list[list[float]]:
        """The axes of a geom: the columns of its rotation matrix."""
        m = self._ode.dGeomGetRotation(geom).contents
        return [[m[0], m[4], m[8]], [m[1], m[5], m[9]], [m[2], m[6], m[10]]]

    def _round_size(self, geom: int) -> tuple[float, float]:
        """Radius and length of a cylinder or capsule."""
        radius, length = c_double(), c_double()
        is_cylinder = self._ode.dGeomGetClass(geom) == GeomClass.CYLINDER
        get = self._ode.dGeomCylinderGetParams if is_cylinder else self._ode.dGeomCapsuleGetParams
        get(geom, ctypes.byref(radius), ctypes.byref(length))
        return radius.value, length.value

    def _surface(self, a: list[float], b: list[float]) -> SurfaceParameters:
        """The contact rule; make_surface in step.c, operation by operation."""
        softness = 1.0 / a[Surface.KP] + 1.0 / b[Surface.KP]
        kd = a[Surface.KD] + b[Surface.KD]
        erp, cfm = 1.0, 0.0
        if softness > 0.0:
            spring = self._context.step * (1.0 / softness)
            erp, cfm = spring / (spring + kd), 1.0 / (spring + kd)
        mode = ContactMode.SOFT_ERP | ContactMode.SOFT_CFM | ContactMode.APPROX1
        bounce, bounce_vel, mu2 = max(a[Surface.BOUNCE], b[Surface.BOUNCE]), 0.0, 0.0
        if self._context.classic:
            bounce = min(a[Surface.BOUNCE], b[Surface.BOUNCE])
            bounce_vel = min(a[Surface.BOUNCE_VEL], b[Surface.BOUNCE_VEL])
            mu2 = min(a[Surface.MU2], b[Surface.MU2])
            mode |= ContactMode.MU2
        if bounce > 0.0:
            mode |= ContactMode.BOUNCE
        return SurfaceParameters(
            mode=int(mode),
            mu=min(a[Surface.MU], b[Surface.MU]),
            mu2=mu2,
            bounce=bounce,
            bounce_vel=bounce_vel,
            soft_erp=erp,
            soft_cfm=cfm,
        )

    def step(self) -> bool:
        """Both halves."""
        self.collide()
        return self.solve()

    def collide(self) -> None:
        """Find contacts and make joints of them."""
        context, ode_ = self._context, self._ode
        valid_for = (self._tables.surface_edits, context.step)
        if valid_for != self._pairs_valid_for:
            self._pairs.clear()
            self._contact_arrays.clear()
            self._pairs_valid_for = valid_for
        self._contact_count = 0
        ode_.dSpaceCollide(context.space, None, self._near)
        context.contact_count = self._contact_count
        self._raise_fault()

    def solve(self) -> bool:
        """Move everything, empty the contact group."""
        context, ode_ = self._context, self._ode
        ode_.dRandSetSeed(context.seed)
        done = (ode_.dWorldQuickStep if context.quick else ode_.dWorldStep)(context.world, context.step)
        ode_.dJointGroupEmpty(context.contacts)
        context.seed = ode_.dRandGetSeed()
        return bool(done)

    def _raise_fault(self) -> None:
        fault, self._fault = self._fault, None
        if fault is not None:
            raise fault

    def read(self) -> None:
        """Copy all states out."""
        context, tables = self._context, self._tables
        for row in range(context.body_count):
            if tables.body_ids[row]:
                read_body(self._ode, tables, row)
        for row in range(context.joint_count):
            if tables.joint_ids[row]:
                read_joint(self._ode, tables, row)

    def scan(
        self,
        frame: NDArray[np.float64],
        rays: NDArray[np.float64],
        owner: int,
        ranges: NDArray[np.float64],
        rows: NDArray[np.int64],
    ) -> None:
        """Cast rays from a frame."""
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
        end = start + rays[:, 6:7] * direction
        low, high = np.minimum(start, end).min(axis=0), np.maximum(start, end).max(axis=0)
        ode_.dGeomBoxSetLengths(context.probe, *(high - low + 1e-6).tolist())
        ode_.dGeomSetPosition(context.probe, *(0.5 * (low + high)).tolist())
        hit = ContactGeom()
        hit_address, hit_size = ctypes.addressof(hit), ctypes.sizeof(hit)
        seen = self._gather(owner)
        for i, (first, along, length) in enumerate(zip(starts, directions, lengths, strict=True)):
            ode_.dGeomRaySetLength(context.ray, length)
            ode_.dGeomRaySet(context.ray, *first, *along)
            for geom, row in seen:
                if ode_.dCollide(context.ray, geom, 1, hit_address, hit_size) and hit.depth < ranges[i]:
                    ranges[i], rows[i] = hit.depth, row

    def _gather(self, owner: int) -> list[tuple[int, int]]:
        """(geom, row) of all geoms whose bounding box meets the probe's, without those of body `owner`."""
        ode_, context = self._ode, self._context
        seen: list[tuple[int, int]] = []
        probe = context.probe

        def near(_data: int, geom1: int, geom2: int) -> None:
            try:
                geom = geom2 if geom1 == probe else geom1
                if ode_.dGeomIsSpace(geom):
                    ode_.dSpaceCollide2(probe, geom, None, address)
                    return
                row = ode_.dGeomGetData(geom) or 0
                if not owner or self._tables.owner[row] != owner:
                    seen.append((geom, row))
            except BaseException as fault:  # noqa: BLE001 - as in _make_near
                self._fault = fault

        callback = _NEAR_CALLBACK(near)
        address = ctypes.cast(callback, c_void_p)
        ode_.dSpaceCollide2(probe, context.space, None, address)
        self._raise_fault()
        return seen


def _dot(a: list[float], b: list[float]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
