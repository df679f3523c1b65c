"""The contact rule in Python: the same work as collide_geoms in step.c, operation by operation.

`PythonStep` has a quicker way for the plain pairs of legacy worlds.
"""

from __future__ import annotations

import ctypes
import math
from ctypes import c_double
from typing import Any

import numpy as np
from numpy.typing import NDArray

from libgz.ode.context import CONTACT, MAX_CONTACTS, MOST_CONTACTS, StepContext
from libgz.ode.lib import OdeLibrary, ode
from libgz.ode.python_islands import Touch, TouchPoint, default_direction, is_calm
from libgz.ode.python_overlaps import Overlap
from libgz.ode.python_vectors import cross, dot, to_global
from libgz.ode.tables import Tables
from libgz.ode.types import (
    Contact,
    ContactMode,
    ContactRule,
    GeomClass,
    JointFeedback,
    JointType,
    Mass,
    Surface,
    SurfaceParameters,
)

__all__ = ["ContactLog", "FullContacts", "make_surface"]

_ROUND = {GeomClass.CAPSULE, GeomClass.CYLINDER}
_PATCH_LEVER = 0.58904862254808621  # 3 pi / 16: mean lever of friction in a patch under Hertz's pressure
# Explained in step.c.
_SOFT_RATIO, _REST_DEPTH, _REST_ERP, _REST_CFM = 0.25, 3e-6, 0.2, 1e-7  # -, [m], -, [s]
_SOFTNESS_SPREAD, _DEPTH_SPREAD = 0.3, 0.05  # -, [1/s]
_STICKING = 40.0  # [m/s^2]
_LARGE, _SMALL_LEVEL, _LARGE_LEVEL = 1e6, -2, 9  # [m], -, -


def make_surface(context: StepContext, a: list[float], b: list[float]) -> SurfaceParameters:
    """The contact parameters of two surfaces; make_surface in step.c."""
    softness = 1.0 / a[Surface.KP] + 1.0 / b[Surface.KP]
    kd = a[Surface.KD] + b[Surface.KD]
    erp, cfm = 1.0, 0.0
    if softness > 0.0:
        spring = context.step * (1.0 / softness)
        erp, cfm = spring / (spring + kd), 1.0 / (spring + kd)
    mode = ContactMode.SOFT_ERP | ContactMode.SOFT_CFM | ContactMode.APPROX1
    bounce, bounce_vel, mu2 = max(a[Surface.BOUNCE], b[Surface.BOUNCE]), 0.0, 0.0
    if context.contact_rule == ContactRule.CLASSIC:
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


class ContactLog:
    """The contact points of a step and their forces; record_point, request_feedback, collect_feedback in step.c."""

    def __init__(self) -> None:
        self._records: list[tuple[Any, ...]] = []
        self._earlier: list[tuple[Any, ...]] = []  # of the step before
        self._joints: list[tuple[int, bool]] = []
        self._feedback: Any = None

    def begin(self, recording: bool) -> None:
        """Begin a step, and keep the records of the step before."""
        self._earlier = self._records.copy() if recording else []
        self.clear()

    def clear(self) -> None:
        """Remove the records."""
        self._records.clear()
        self._joints.clear()
        self._feedback = None

    def add(self, rows: tuple[int, int], point: Any, depth: float, joint: int, reversed_: bool) -> None:
        """Record a point; joint 0: none; `reversed_`: the joint's first body is that of the second geom."""
        self._records.append((*rows, tuple(point.pos[:3]), tuple(point.normal[:3]), depth))
        self._joints.append((joint, reversed_))

    @property
    def count(self) -> int:
        """The number of points so far."""
        return len(self._records)

    def set_efforts(self, record: int, *efforts: list[float]) -> None:
        """Set the efforts of a point that is not solved by ODE, as its joint's bodies have them."""
        result = self._feedback[record]
        for (force, torque), effort in zip(((result.f1, result.t1), (result.f2, result.t2)), efforts, strict=False):
            force[:3], torque[:3] = effort[:3], effort[3:]

    def request_feedback(self, ode_: OdeLibrary) -> None:
        """Request the forces of this step from ODE."""
        if not self._joints:
            return
        self._feedback = (JointFeedback * len(self._joints))()
        for (joint, _), feedback in zip(self._joints, self._feedback, strict=True):
            if joint:
                ode_.dJointSetFeedback(joint, ctypes.addressof(feedback))

    def carry_on(self, ode_: OdeLibrary) -> None:
        """Contacts of bodies that are asleep carry what they carried in the step before; carry_on in step.c."""
        place, start = -1, 0
        for i, (joint, _) in enumerate(self._joints):
            if not joint or _is_awake(ode_, joint):
                continue
            pair, before = self._records[i][:2], self._earlier
            if i == 0 or self._records[i - 1][:2] != pair:
                place = self._find_pair(pair, start)
            elif place >= 0:
                place = place + 1 if place + 1 < len(before) and before[place + 1][:2] == pair else -1
            if place >= 0:
                start = place
                self._records[i] = self._records[i][:5] + before[place][5:]

    def _find_pair(self, pair: tuple[int, int], start: int) -> int:
        """The place of a pair's first record in the step before; -1 without any."""
        before = self._earlier
        for n in range(len(before)):
            i = (start + n) % len(before)
            if before[i][:2] == pair and (i == 0 or before[i - 1][:2] != pair):
                return i
        return -1

    def collect_feedback(self, ode_: OdeLibrary) -> None:
        """Add the forces to the records."""
        self.carry_on(ode_)
        zero = (0.0, 0.0, 0.0)
        for i, (joint, reversed_) in enumerate(self._joints):
            if not joint or not _is_awake(ode_, joint):
                continue
            result = self._feedback[i]
            first, second = (tuple(result.f1[:3]), tuple(result.t1[:3])), (tuple(result.f2[:3]), tuple(result.t2[:3]))
            self._records[i] = self._records[i][:5] + ((zero, zero, *first) if reversed_ else (*first, *second))
        self._joints = [(0, False)] * len(self._joints)

    def set(self, contacts: NDArray[np.void]) -> None:
        """Replace the points by others, with their forces."""
        self.clear()
        self._records = [tuple(contact[name].tolist() for name in CONTACT.names or ()) for contact in contacts]

    def contacts(self) -> NDArray[np.void]:
        """A copy of the points."""
        found = np.zeros(len(self._records), dtype=CONTACT)
        for i, record in enumerate(self._records):
            for name, value in zip(CONTACT.names or (), record, strict=False):
                found[name][i] = value
        return found


def _is_awake(ode_: OdeLibrary, joint: int) -> bool:
    """Whether one of a joint's bodies is not asleep."""
    return any(
        body and ode_.dBodyIsEnabled(body) for body in (ode_.dJointGetBody(joint, 0), ode_.dJointGetBody(joint, 1))
    )


class FullContacts:
    """Contacts under the classic rule, of round shapes, and of worlds that record contacts."""

    def __init__(self, context: StepContext, tables: Tables) -> None:
        self._context, self._tables = context, tables
        self._ode: OdeLibrary = ode()
        self._points = (Contact * MOST_CONTACTS)()
        self.log = ContactLog()
        self.touches: list[Touch] = []
        self.overlaps: list[Overlap] = []
        self.held: set[int] = set()  # handles of bodies that a joint connects with the world
        self.count = 0

    def find_held(self) -> None:
        """find_held in step.c."""
        ode_, joints = self._ode, self._tables.joints.ids[: self._context.joint_count].tolist()
        pairs = [[ode_.dJointGetBody(joint, k) or 0 for k in (0, 1)] for joint in joints if joint]
        self.held = {one or two for one, two in pairs if bool(one) != bool(two)}

    def rows(self, geom1: int, geom2: int) -> tuple[list[float], list[float]]:
        """The surfaces of two geoms."""
        surface, data = self._tables.geoms.surface, self._ode.dGeomGetData
        return surface[data(geom1) or 0].tolist(), surface[data(geom2) or 0].tolist()

    def round_pair(self, geom1: int, geom2: int) -> bool:
        """Whether boxes stand in for one of two geoms."""
        kinds = {self._ode.dGeomGetClass(geom) for geom in (geom1, geom2)}
        return bool(self._context.no_cylinder_pairs) and GeomClass.CYLINDER in kinds and kinds <= _ROUND

    def touch(self, geom1: int, geom2: int) -> None:
        """Find and make the contacts of two geoms, of which one has a body; collide_geoms in step.c."""
        ode_, context, points = self._ode, self._context, self._points
        body1, body2 = (ode_.dGeomGetBody(geom) or 0 for geom in (geom1, geom2))
        if body1 and body2 and ode_.dAreConnectedExcluding(body1, body2, JointType.CONTACT):
            return
        a, b = self.rows(geom1, geom2)
        classic = context.contact_rule == ContactRule.CLASSIC
        if classic and not self._may_touch(a, b, body1, body2):
            return
        count = self._find_points(geom1, geom2, MOST_CONTACTS if classic else MAX_CONTACTS)
        if not count:
            return
        surface, ghost, limits, rigid = make_surface(context, a, b), False, (math.inf, 0.0), False
        if classic:
            ghost = a[Surface.GHOST] != 0.0 or b[Surface.GHOST] != 0.0
            count = self._deepest(a, b, count)
            max_vel, min_depth = _limits(a, b, body1, body2)
            limits = max_vel, max(min_depth, context.surface_layer)
            rigid = self._make_rigid(a, b, (body1, body2), surface)
            if not ghost:
                self.touches.append(Touch(body1 or body2, body2 if body1 else 0, []))
        data = (ode_.dGeomGetData(geom1) or 0, ode_.dGeomGetData(geom2) or 0)
        for i in range(count):
            point, joint, withheld = points[i], 0, 0.0
            found = point.geom.depth
            point.surface = surface
            kept = self._vary(limits[1], point) if rigid else 0.0
            if classic:
                withheld = self._refine(a, b, (geom1, geom2), (body1, body2), (*limits, kept), count, found, point)
            if not ghost:
                joint = ode_.dJointCreateContact(context.world, context.contacts, ctypes.addressof(point))
                ode_.dJointAttach(joint, body1, body2)
                self.count += 1
                if classic:
                    record = self.log.count if context.record_contacts else -1
                    copy = Contact.from_buffer_copy(point)
                    self.touches[-1].points.append(TouchPoint(copy, joint, record))
                if withheld > 0.0 and context.exact_rest:
                    softness = 1.0 / a[Surface.KP] + 1.0 / b[Surface.KP]
                    normal = tuple(point.geom.normal[:3])
                    self.overlaps.append(Overlap(body1, body2, normal, withheld, softness))
            if context.record_contacts:
                self.log.add(data, point.geom, found, joint, not body1)

    def _find_points(self, geom1: int, geom2: int, most: int) -> int:
        """find_points in step.c."""
        address = ctypes.addressof(self._points) + Contact.geom.offset
        if self.round_pair(geom1, geom2):
            return self._collide_cylinder(geom1, geom2, address)
        return int(self._ode.dCollide(geom1, geom2, most, address, ctypes.sizeof(Contact)))

    def overlap(self, geom1: int, geom2: int) -> float:
        """gz_overlap in step.c."""
        count = self._find_points(geom1, geom2, MAX_CONTACTS)
        return max((float(self._points[i].geom.depth) for i in range(count)), default=-1.0)

    def _may_touch(self, a: list[float], b: list[float], body1: int, body2: int) -> bool:
        """may_touch in step.c."""
        if not int(a[Surface.BITS]) & int(b[Surface.BITS]):
            return False
        if a[Surface.GHOST] != 0.0 or b[Surface.GHOST] != 0.0:
            return bool(self._context.record_contacts and int(a[Surface.GHOST_BITS]) & int(b[Surface.GHOST_BITS]))
        if self._context.record_contacts:
            return True
        return any(body and self._ode.dBodyIsEnabled(body) for body in (body1, body2))

    def _deepest(self, a: list[float], b: list[float], count: int) -> int:
        """deepest in step.c: keep as many as are allowed, in their order."""
        points = self._points
        most = int(min(a[Surface.MAX_CONTACTS], b[Surface.MAX_CONTACTS], self._context.max_contacts))
        while count > most:
            shallow = min(range(count), key=lambda i: points[i].geom.depth)
            for i in range(shallow, count - 1):
                points[i] = points[i + 1]
            count -= 1
        return count

    def _refine(
        self,
        a: list[float],
        b: list[float],
        geoms: tuple[int, int],
        bodies: tuple[int, int],
        limits: tuple[float, float, float],
        count: int,
        found: float,
        point: Any,
    ) -> float:
        """refine_point in step.c; the depth that would be corrected without max_vel [m]."""
        surface = point.surface
        limit, min_depth, kept = limits
        surface.slip1 = (a[Surface.SLIP1] + b[Surface.SLIP1]) * count
        surface.slip2 = (a[Surface.SLIP2] + b[Surface.SLIP2]) * count
        if surface.slip1 > 0.0:
            surface.mode |= ContactMode.SLIP1
        if surface.slip2 > 0.0:
            surface.mode |= ContactMode.SLIP2
        tracks = a[Surface.TRACK] != 0.0 or b[Surface.TRACK] != 0.0
        if not (tracks and self._set_track((a, b), geoms, bodies, point)):
            aimed = self._friction_direction(a, b, *geoms, point)
            if aimed:
                surface.mode |= ContactMode.FDIR1
            if self._context.cone:
                self._set_cone(bodies, point, aimed)
        _add_torsion(a, b, point)
        stiffness = _elastic_stiffness(a, b, found)
        if stiffness > 0.0:
            spring, kd = self._context.step * stiffness, a[Surface.KD] + b[Surface.KD]
            surface.soft_erp = spring / (spring + kd)
            surface.soft_cfm = 1.0 / (spring + kd)
            point.geom.depth = found
            return 0.0
        point.geom.depth = max(0.0, point.geom.depth - min_depth)
        if point.geom.depth > 0.0:
            return self._limit_speed(bodies, limit, point)
        if found < kept and not surface.mode & ContactMode.BOUNCE:
            surface.motionN = surface.soft_erp * (found - kept) / self._context.step
            surface.mode |= ContactMode.MOTION_N
        return 0.0

    def _limit_speed(self, bodies: tuple[int, int], limit: float, point: Any) -> float:
        """limit_speed in step.c; the depth that is withheld [m]."""
        surface, depth = point.surface, point.geom.depth
        most = limit * self._context.step / depth
        if most >= surface.soft_erp:
            return 0.0
        withheld: float = (surface.soft_erp - most) * depth
        lighter = min(self._mass(body) for body in bodies if body)
        surface.soft_cfm = max(surface.soft_cfm * (most / surface.soft_erp), _REST_CFM / lighter)
        surface.soft_erp = most
        return withheld

    def _vary(self, min_depth: float, point: Any) -> float:
        """vary in step.c: the depth that is kept."""
        p = point.geom.pos
        wave = 6.0 * p[0] + 8.45 * p[1] + 11.35 * p[2]
        wave = 2.0 * math.fabs(wave % 1.0 - 0.5)
        point.surface.soft_cfm = point.surface.soft_cfm * (1.0 + _SOFTNESS_SPREAD * wave)
        kept: float = max(0.0, _REST_DEPTH - min_depth) - _REST_DEPTH * _DEPTH_SPREAD * self._context.step * wave
        point.geom.depth = max(0.0, point.geom.depth - kept)
        return kept

    def _make_rigid(self, a: list[float], b: list[float], bodies: tuple[int, int], surface: Any) -> bool:
        """make_rigid in step.c: whether the springs stand for rigid surfaces."""
        context = self._context
        if not context.exact_rest or all(body in self.held for body in bodies if body):
            return False
        mass = min(self._mass(body) for body in bodies if body)
        if context.step * context.step <= _SOFT_RATIO * mass * (1.0 / a[Surface.KP] + 1.0 / b[Surface.KP]):
            return False
        if surface.soft_erp > _REST_ERP and all(is_calm(context, self._ode, body) for body in bodies if body):
            surface.soft_cfm = surface.soft_cfm * (_REST_ERP / surface.soft_erp)
            surface.soft_erp = _REST_ERP
        surface.soft_cfm = max(surface.soft_cfm, _REST_CFM / mass)
        return True

    def _mass(self, body: int) -> float:
        mass = Mass()
        self._ode.dBodyGetMass(body, ctypes.addressof(mass))
        return float(mass.mass)

    def _level(self, geom: int) -> int:
        """level_of in step.c."""
        ode_, body, space = self._ode, self._ode.dGeomGetBody(geom), self._ode.dGeomGetSpace(geom)
        if ode_.dGeomGetClass(geom) == GeomClass.PLANE:
            return _LARGE_LEVEL
        extents = self._extents(geom if body or not space or space == self._context.space else space)
        part = ode_.dBodyGetFirstGeom(body) if body else None
        while part:
            box = self._extents(part)
            extents = [(min, max)[k % 2](extents[k], box[k]) for k in range(6)]
            part = ode_.dBodyGetNextGeom(part)
        extent = max(0.0, *(extents[k + 1] - extents[k] for k in (0, 2, 4)))
        if not extent < _LARGE:
            return _LARGE_LEVEL
        return min(max(math.frexp(extent)[1], _SMALL_LEVEL), _LARGE_LEVEL)

    def _extents(self, geom: int) -> list[float]:
        box = (ctypes.c_double * 6)()
        self._ode.dGeomGetAABB(geom, box)
        return list(box)

    def _second_first(self, geom1: int, geom2: int) -> bool:
        """second_first in step.c."""
        ode_, levels = self._ode, (self._level(geom1), self._level(geom2))
        if levels[0] != levels[1]:
            return levels[1] < levels[0]
        body1, body2 = ode_.dGeomGetBody(geom1), ode_.dGeomGetBody(geom2)
        made1, made2 = (self._tables.geoms.owner[ode_.dGeomGetData(geom) or 0] for geom in (geom1, geom2))
        return not body2 or bool(body1 and made2 > made1)

    def _friction_direction(self, a: list[float], b: list[float], geom1: int, geom2: int, point: Any) -> bool:
        """friction_direction in step.c."""
        first, second = (row[Surface.FDIR1 : Surface.FDIR1 + 3] for row in (a, b))
        if dot(first, first) == 0.0 and dot(second, second) == 0.0:
            return False
        local, geom = (second, geom2) if self._second_first(geom1, geom2) else (first, geom1)
        if dot(local, local) == 0.0:
            return False
        return _set_friction_direction(point, to_global(self._rotation_of(geom), local))

    def _rotation_of(self, geom: int) -> Any:
        """rotation_of in step.c."""
        return (
            _UNTURNED if self._ode.dGeomGetClass(geom) == GeomClass.PLANE else self._ode.dGeomGetRotation(geom).contents
        )

    def _set_track(
        self, rows: tuple[list[float], list[float]], geoms: tuple[int, int], bodies: tuple[int, int], point: Any
    ) -> bool:
        """set_track in step.c."""
        n, motion = point.geom.normal[:3], [0.0, 0.0, 0.0]
        first = 1.0 if bodies[0] else -1.0
        found: list[float] | None = None
        pivot: list[float] | None = None
        for row, geom, sign in zip(rows, geoms, (-1.0, 1.0), strict=True):
            if row[Surface.TRACK] == 0.0:
                continue
            axis = to_global(self._rotation_of(geom), row[Surface.FDIR1 : Surface.FDIR1 + 3])
            way = [sign * v for v in cross(axis, n)]
            size = math.sqrt(dot(way, way))
            if size < 1e-9:
                continue
            if row[Surface.TRACK] == 2.0:
                pivot = row[Surface.PIVOT : Surface.PIVOT + 3]
            way = [v / size for v in way]
            motion = [v + first * sign * row[Surface.TRACK_SPEED] * w for v, w in zip(motion, way, strict=True)]
            found = found or way
        if found is None:
            return False
        point.fdir1[:3] = found
        if pivot is not None:
            arm = [v - w for v, w in zip(point.geom.pos[:3], pivot, strict=True)]
            _set_friction_direction(point, cross(n, arm))
        point.surface.motion1 = dot(motion, point.fdir1[:3])
        point.surface.mode |= ContactMode.FDIR1 | ContactMode.MOTION1
        return True

    def _set_cone(self, bodies: tuple[int, int], point: Any, aimed: bool) -> None:
        """set_cone in step.c."""
        surface, n = point.surface, point.geom.normal[:3]
        if not (surface.mu < math.inf and surface.mu2 < math.inf):
            return
        slide = [0.0, 0.0, 0.0]
        for body, sign in zip(bodies, (1.0, -1.0), strict=True):
            if body:
                self._add_velocity(body, point.geom.pos, sign, slide)
        one = point.fdir1[:3] if aimed else default_direction(n)
        two = cross(n, one)
        along, across = dot(slide, one), dot(slide, two)
        size = math.sqrt(along * along + across * across)
        if size < 1e-9:
            return
        along, across = surface.mu * along / size, surface.mu2 * across / size
        mu = math.sqrt(along * along + across * across)
        if not mu > 0.0:
            return
        point.fdir1[:3] = [(along * v + across * w) / mu for v, w in zip(one, two, strict=True)]
        surface.mu = mu
        surface.mu2 = 0.0 if size > self._context.step * (_STICKING * mu) else mu
        surface.mode |= ContactMode.FDIR1

    def _add_velocity(self, body: int, at: Any, sign: float, slide: list[float]) -> None:
        """add_velocity in step.c."""
        ode_, context = self._ode, self._context
        x, v, w = (
            get(body).contents for get in (ode_.dBodyGetPosition, ode_.dBodyGetLinearVel, ode_.dBodyGetAngularVel)
        )
        share = context.step if ode_.dBodyGetGravityMode(body) and not ode_.dBodyIsKinematic(body) else 0.0
        arm = [at[k] - x[k] for k in range(3)]
        for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
            slide[k] = slide[k] + sign * (v[k] + (w[i] * arm[j] - w[j] * arm[i]) + share * context.gravity[k])

    def _collide_cylinder(self, geom1: int, geom2: int, first: int) -> int:
        """Contacts of a cylinder with a cylinder or capsule; collide_cylinder in step.c."""
        ode_, box = self._ode, self._context.stand_in
        cylinder = geom2 if ode_.dGeomGetClass(geom2) == GeomClass.CYLINDER else geom1
        other = geom1 if cylinder == geom2 else geom2
        p, q = ode_.dGeomGetPosition(cylinder).contents[:3], ode_.dGeomGetPosition(other).contents[:3]
        r, s = self._columns(cylinder), self._columns(other)
        radius, length = self._round_size(cylinder)
        _, other_length = self._round_size(other)
        axis, other_axis = r[2], s[2]
        gap = [b - a for a, b in zip(p, q, strict=True)]
        along, t = dot(gap, axis), dot(other_axis, axis)
        gap = [g - along * a for g, a in zip(gap, axis, strict=True)]
        other_axis = [o - t * a for o, a in zip(other_axis, axis, strict=True)]
        square = dot(other_axis, other_axis)
        t = -dot(gap, other_axis) / square if square > 1e-9 else 0.0
        t = max(min(t, 0.5 * other_length), -0.5 * other_length)
        aim = [g + t * o for g, o in zip(gap, other_axis, strict=True)]
        size = dot(aim, aim)
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


def _add_torsion(a: list[float], b: list[float], point: Any) -> None:
    """add_torsion in step.c."""
    lever = max(a[Surface.PATCH_RADIUS], b[Surface.PATCH_RADIUS])
    if a[Surface.BY_PATCH] == 0.0 or b[Surface.BY_PATCH] == 0.0:
        bend = 0.0
        for radius in (a[Surface.RADIUS], b[Surface.RADIUS]):
            if radius > 0.0:
                bend = bend + 1.0 / radius
        depth = point.geom.depth
        lever = math.sqrt(depth / bend) if bend > 0.0 and depth > 0.0 else 0.0
    if not lever > 0.0:
        return
    lever = _PATCH_LEVER * lever * min(a[Surface.TORSION], b[Surface.TORSION])
    if not lever > 0.0:
        return
    surface = point.surface
    surface.mode |= ContactMode.ROLLING | ContactMode.APPROX1_N
    surface.rho = surface.rho2 = -1.0
    surface.rhoN = lever


def _limits(a: list[float], b: list[float], body1: int, body2: int) -> tuple[float, float]:
    """max_vel and min_depth of a pair; set_limits in step.c."""
    limited = a[Surface.MAX_VEL] < math.inf and b[Surface.MAX_VEL] < math.inf
    max_vel = math.inf if body1 and body2 and not limited else _of_bodies(a, b, body1, body2, Surface.MAX_VEL)
    return max_vel, _of_bodies(a, b, body1, body2, Surface.MIN_DEPTH)


def _elastic_stiffness(a: list[float], b: list[float], depth: float) -> float:
    """elastic_stiffness in step.c."""
    compliance = a[Surface.COMPLIANCE] + b[Surface.COMPLIANCE]
    curvature = a[Surface.CURVATURE] + b[Surface.CURVATURE]
    if a[Surface.COMPLIANCE] <= 0.0 or b[Surface.COMPLIANCE] <= 0.0 or depth <= 0.0:
        return 0.0
    if curvature > 0.0:
        return 4.0 / 3.0 / compliance * math.sqrt(depth / curvature)
    return 2.0 / compliance * max(a[Surface.PATCH_RADIUS], b[Surface.PATCH_RADIUS])


def _of_bodies(a: list[float], b: list[float], body1: int, body2: int, column: int) -> float:
    """of_bodies in step.c."""
    if not body1:
        return b[column]
    return min(a[column], b[column]) if body2 else a[column]


def _set_friction_direction(point: Any, aim: list[float]) -> bool:
    """set_friction_direction in step.c."""
    n = point.geom.normal[:3]
    along = dot(aim, n)
    aim = [v - along * w for v, w in zip(aim, n, strict=True)]
    size = math.sqrt(dot(aim, aim))
    if size < 1e-9:
        return False
    point.fdir1[:3] = [v / size for v in aim]
    return True


_UNTURNED = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
